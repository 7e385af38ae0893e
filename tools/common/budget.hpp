#pragma once

#include "altiro3D/trade.hpp"

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D::tools {

class CommandLine;
class Messages;

/// What the views of one picture cost with one setting.
struct SettingCost {
    std::string name;                   ///< Of the setting.
    double preparationMilliseconds = 0; ///< Once for all views.
    double millisecondsPerView = 0;     ///< For each view, without the preparation.

    /// Time of a set of views.
    double milliseconds(int views) const {
        return preparationMilliseconds + views * millisecondsPerView;
    }
};

/// The setting that was chosen.
struct BudgetChoice {
    std::size_t index = 0;   ///< Among the costs.
    double milliseconds = 0; ///< What its views take.
    bool fits = false;       ///< Within the budget.
};

/// The first setting whose views are made within the budget; the last if none is.
/// @param costs best setting first; not empty
inline BudgetChoice chooseWithinBudget(const std::vector<SettingCost>& costs, int views,
                                       double budgetMilliseconds) {
    BudgetChoice choice;
    for (std::size_t i = 0; i < costs.size() && !choice.fits; ++i) {
        const double milliseconds = costs[i].milliseconds(views);
        choice = {i, milliseconds, milliseconds <= budgetMilliseconds};
    }
    return choice;
}

/// The settings that a budget may choose, best first.
/// @param base strength and focus of all of them
std::vector<NamedViewOptions> budgetSettings(const ViewOptions& base);

/// --budget: the best setting that makes the views of a picture in a given time.
class Budget {
  public:
    static void add(CommandLine& commandLine);
    /// @throws UsageError
    explicit Budget(const CommandLine& commandLine);

    /// A budget was given, and nothing is chosen yet.
    bool mustChoose() const { return milliseconds_ && costs_.empty(); }

    /// Chooses for all pictures of a run and says what. The costs are measured on this picture, or
    /// taken from the user's cache if they were measured before.
    ///
    /// @param base strength and focus
    /// @param photo [rows x cols, CV_8UC3, BGR], as the views will be made from it
    /// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]
    ViewOptions choose(const ViewOptions& base, const QuiltLayout& layout, const cv::Mat& photo,
                       const cv::Mat& depth, Messages& messages);

    /// For reports: what was measured and chosen, or null.
    nlohmann::ordered_json report() const;

  private:
    std::optional<double> milliseconds_;
    int views_ = 0;
    std::vector<SettingCost> costs_;
    BudgetChoice choice_;
    bool fromCache_ = false;
};

} // namespace altiro3D::tools
