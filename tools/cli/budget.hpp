#pragma once

#include "altiro3D/depth2quilt.hpp"

#include <cstddef>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D::tools {

class CommandLine;
class Messages;

/// Time that a stage takes on one picture with one setting.
struct SettingCost {
    std::string name;        ///< Name of the setting.
    double milliseconds = 0; ///< Infinite if the setting cannot be used.
};

/// The setting that was chosen.
struct BudgetChoice {
    std::size_t index = 0; ///< Index into the costs.
    bool fits = false;     ///< True if the setting is within the budget.
};

/// Chooses the first setting within the budget, or the last setting if none is.
/// @param costs best setting first; not empty
inline BudgetChoice chooseWithinBudget(const std::vector<SettingCost>& costs,
                                       double budgetMilliseconds) {
    for (std::size_t i = 0; i < costs.size(); ++i) {
        if (costs[i].milliseconds <= budgetMilliseconds) return {i, true};
    }
    return {costs.size() - 1, false};
}

/// The settings that --budget chooses from, best first. All take the same path to the Native.
/// @param base strength and focus of all of them
std::vector<NamedViewOptions> budgetSettings(const ViewOptions& base);

/// A source of depth that --budget can choose.
struct BudgetDepth {
    std::string name;
    std::function<void()> prepare;  ///< Gets ready to estimate; its time does not count.
    std::function<void()> estimate; ///< Estimates the depth of the first picture.
};

/// What --budget chose for all pictures of a run.
struct BudgetSetting {
    ViewOptions views;
    std::size_t depth = 0; ///< Index of the source of depth.
};

/// --budget: the best depth and the best method that make the Native of a picture in a given time.
class Budget {
  public:
    static void add(CommandLine& commandLine);
    Budget() = default; ///< None.
    /// @throws UsageError
    explicit Budget(const CommandLine& commandLine);

    /// True if a budget was given and no setting is chosen yet.
    bool mustChoose() const { return milliseconds_ && costs_.empty(); }

    /// Chooses the setting for all pictures of a run and reports it. The costs are measured, or
    /// taken from the user's cache if they were measured before. A better method takes
    /// precedence over a better source of depth: with good depth the method gains up to 9 dB, and
    /// with estimated depth as much as a better source does (docs/lab/views.md).
    ///
    /// @param base strength and focus
    /// @param work key of what the costs depend on besides setting, picture and machine; must be
    ///        usable in a file name
    /// @param depths sources of depth, best first; empty if depth is given, which takes no time
    /// @param makeNative makes the Native of the first picture
    BudgetSetting choose(const ViewOptions& base, const std::string& work,
                         const std::vector<BudgetDepth>& depths,
                         const std::function<void(const ViewOptions&)>& makeNative,
                         Messages& messages);

    /// The measured costs and the choice, for reports; null without a budget.
    nlohmann::ordered_json report() const;

  private:
    void measure(const std::string& work, const std::vector<NamedViewOptions>& settings,
                 const std::vector<BudgetDepth>& depths,
                 const std::function<void(const ViewOptions&)>& makeNative, Messages& messages);

    std::optional<double> milliseconds_;
    std::string advice_; // a way to take less time
    std::vector<SettingCost> costs_;
    std::vector<SettingCost> depthCosts_;
    SettingCost chosen_; // of depth and Native together
    bool fits_ = false;
    bool fromCache_ = false;
};

} // namespace altiro3D::tools
