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

/// What one picture costs with one setting.
struct SettingCost {
    std::string name;        ///< Of the setting.
    double milliseconds = 0; ///< From the fitted photo and its depth to the Native.
};

/// The setting that was chosen.
struct BudgetChoice {
    std::size_t index = 0; ///< Among the costs.
    bool fits = false;     ///< Within the budget.
};

/// The first setting that makes the Native within the budget; the last if none does.
/// @param costs best setting first; not empty
inline BudgetChoice chooseWithinBudget(const std::vector<SettingCost>& costs,
                                       double budgetMilliseconds) {
    for (std::size_t i = 0; i < costs.size(); ++i) {
        if (costs[i].milliseconds <= budgetMilliseconds) return {i, true};
    }
    return {costs.size() - 1, false};
}

/// The settings that a budget may choose, best first. All take one path to the Native.
/// @param base strength and focus of all of them
std::vector<NamedViewOptions> budgetSettings(const ViewOptions& base);

/// --budget: the best setting that makes the Native of a picture in a given time.
class Budget {
  public:
    static void add(CommandLine& commandLine);
    /// @throws UsageError
    explicit Budget(const CommandLine& commandLine);

    /// A budget was given, and nothing is chosen yet.
    bool mustChoose() const { return milliseconds_ && costs_.empty(); }

    /// Chooses for all pictures of a run and says what. The costs are measured, or taken from the
    /// user's cache if they were measured before.
    ///
    /// @param base strength and focus
    /// @param work what the costs depend on besides setting, picture and machine; fit for a file
    ///        name
    /// @param makeNative all that is done for the Native of the first picture
    ViewOptions choose(const ViewOptions& base, const std::string& work,
                       const std::function<void(const ViewOptions&)>& makeNative,
                       Messages& messages);

    /// For reports: what was measured and chosen, or null.
    nlohmann::ordered_json report() const;

  private:
    std::optional<double> milliseconds_;
    std::string advice_; // what takes less time
    std::vector<SettingCost> costs_;
    BudgetChoice choice_;
    bool fromCache_ = false;
};

} // namespace altiro3D::tools
