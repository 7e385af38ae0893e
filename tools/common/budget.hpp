#pragma once

#include "altiro3D/trade.hpp"

#include <cstddef>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D::tools {

class CommandLine;
class Messages;

/// Time that one picture takes with one setting.
struct SettingCost {
    std::string name;        ///< Name of the setting.
    double milliseconds = 0; ///< From the fitted photo and its depth to the Native.
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

/// --budget: the best setting that makes the Native of a picture in a given time.
class Budget {
  public:
    static void add(CommandLine& commandLine);
    /// @throws UsageError
    explicit Budget(const CommandLine& commandLine);

    /// True if a budget was given and no setting is chosen yet.
    bool mustChoose() const { return milliseconds_ && costs_.empty(); }

    /// Chooses the setting for all pictures of a run and reports it. The costs are measured, or
    /// taken from the user's cache if they were measured before.
    ///
    /// @param base strength and focus
    /// @param work key of what the costs depend on besides setting, picture and machine; must be
    ///        usable in a file name
    /// @param makeNative makes the Native of the first picture
    ViewOptions choose(const ViewOptions& base, const std::string& work,
                       const std::function<void(const ViewOptions&)>& makeNative,
                       Messages& messages);

    /// The measured costs and the choice, for reports; null without a budget.
    nlohmann::ordered_json report() const;

  private:
    std::optional<double> milliseconds_;
    std::string advice_; // a way to take less time
    std::vector<SettingCost> costs_;
    BudgetChoice choice_;
    bool fromCache_ = false;
};

} // namespace altiro3D::tools
