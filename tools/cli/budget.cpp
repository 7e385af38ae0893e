#include "cli/budget.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/version.hpp"
#include "cli/run_tool.hpp"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr double kEnoughTime = 500; // ms after which there is no further repetition
constexpr int kCacheFormat = 5;

// JSON has no infinity: a setting that cannot be used is null in the text.
Json costsJson(const std::vector<SettingCost>& costs) {
    Json list = Json::array();
    for (const SettingCost& cost : costs)
        list.push_back({{"setting", cost.name}, {"milliseconds", cost.milliseconds}});
    return list;
}

// @throws Json::exception if it does not hold the costs of these settings
std::vector<SettingCost> parseCosts(const Json& list, const std::vector<std::string>& names) {
    std::vector<SettingCost> costs;
    for (const std::string& name : names) {
        const Json& entry = list.at(costs.size());
        if (entry.at("setting") != name) return {};
        const Json& cost = entry.at("milliseconds");
        const double milliseconds =
            cost.is_null() ? std::numeric_limits<double>::infinity() : cost.get<double>();
        if (!(milliseconds >= 0)) return {};
        costs.push_back({name, milliseconds});
    }
    if (list.size() != names.size()) return {};
    return costs;
}

std::string wholeMilliseconds(double value) {
    const std::string number = fixed(value, value < 10 ? 1 : 0);
    const std::size_t zero = number.find(".0");
    return (zero == std::string::npos ? number : number.substr(0, zero)) + " ms";
}

} // namespace

std::vector<NamedViewOptions> budgetSettings(const ViewOptions& base) {
    ViewOptions options;
    options.strengthPercent = base.strengthPercent;
    options.focus = base.focus;
    std::vector<NamedViewOptions> settings;
    options.method = ViewMethod::Layered;
    settings.push_back({"layered", options});
    settings.push_back({"layered, hard borders", options});
    settings.back().options.layered.softBorders = false;
    settings.push_back({"layered, hard borders, fill continue", settings.back().options});
    settings.back().options.layered.fill = LayeredFill::Continue;
    options.method = ViewMethod::Fast;
    settings.push_back({"fast, refinement 2", options});
    settings.back().options.refinement = 2;
    settings.push_back({"fast", options});
    return settings;
}

void Budget::add(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"budget"},
        "Choose the best method that makes a Native in MS milliseconds on this machine, 0.1..1e6, "
        "and, if depth is estimated and no network is named, the best network and input size. "
        "Reading and writing of files do not count. The times are measured on the first picture "
        "and kept in the user's cache directory. Not with --method, -g and their options.",
        "MS");
}

Budget::Budget(const CommandLine& commandLine) : advice_("smaller views (-r) take less") {
    commandLine.take(
        {{"budget", milliseconds_, 0.1, 1e6}, {"k", advice_, "it takes less without -k"}});
    commandLine.exclude("budget",
                        {"method", "g", "fill", "borders", "refine", "inpaint-from", "camera"});
}

void Budget::measure(const std::string& work, const std::vector<NamedViewOptions>& settings,
                     const std::vector<BudgetDepth>& depths,
                     const std::function<void(const ViewOptions&)>& makeNative,
                     Messages& messages) {
    const std::string key = std::string(version()) + "-" + std::to_string(cv::getNumberOfCPUs()) +
                            "-" + std::to_string(cv::getNumThreads()) + "-" + work;
    const fs::path directory = cacheDirectory();
    const fs::path file = directory.empty() ? fs::path() : directory / ("budget-" + key + ".json");
    std::vector<std::string> names;
    for (const NamedViewOptions& setting : settings)
        names.push_back(setting.name);
    std::vector<std::string> depthNames;
    for (const BudgetDepth& depth : depths)
        depthNames.push_back(depth.name);
    // the cache is optional: if anything is wrong with it, the costs are measured
    std::error_code error;
    if (!file.empty() && fs::exists(file, error)) {
        try {
            const Json json = Json::parse(readFile(file, 1 << 16));
            if (json.at("format") == kCacheFormat && json.at("key") == key) {
                costs_ = parseCosts(json.at("costs"), names);
                depthCosts_ = parseCosts(json.at("depths"), depthNames);
                fromCache_ = !costs_.empty() && depthCosts_.size() == depths.size();
            }
        } catch (const Error& problem) {
            messages.detail(std::string("costs in the cache are not used: ") + problem.what());
        } catch (const Json::exception&) {
            fromCache_ = false;
        }
    }
    if (fromCache_) return messages.detail("costs: from the cache, " + file.string());
    costs_.clear();
    depthCosts_.clear();
    bool isLasting = true; // a later run would leave out the same; only then the costs are cached
    for (const BudgetDepth& depth : depths) {
        double milliseconds = std::numeric_limits<double>::infinity();
        try {
            depth.prepare();
            milliseconds = fastestMilliseconds(depth.estimate, kEnoughTime);
        } catch (const Error& problem) {
            messages.detail("costs: depth by " + depth.name + " is left out: " + problem.what());
            isLasting = isLasting && problem.code() != ErrorCode::OutOfMemory;
        }
        depthCosts_.push_back({depth.name, milliseconds});
    }
    for (const NamedViewOptions& setting : settings)
        costs_.push_back(
            {setting.name, fastestMilliseconds([&] { makeNative(setting.options); }, kEnoughTime)});
    if (file.empty() || !isLasting) return;
    try {
        fs::create_directories(directory, error);
        const Json json = {{"format", kCacheFormat},
                           {"key", key},
                           {"costs", costsJson(costs_)},
                           {"depths", costsJson(depthCosts_)}};
        writeFile(file, json.dump(2) + "\n");
        messages.detail("costs: measured and kept as " + file.string());
    } catch (const Error& problem) {
        messages.detail(std::string("costs: measured, not kept: ") + problem.what());
    }
}

BudgetSetting Budget::choose(const ViewOptions& base, const std::string& work,
                             const std::vector<BudgetDepth>& depths,
                             const std::function<void(const ViewOptions&)>& makeNative,
                             Messages& messages) {
    const std::vector<NamedViewOptions> settings = budgetSettings(base);
    measure(work, settings, depths, makeNative, messages);
    std::vector<SettingCost> totals;
    std::vector<BudgetSetting> choices;
    for (std::size_t i = 0; i < settings.size(); ++i) {
        if (depths.empty()) {
            totals.push_back(costs_[i]);
            choices.push_back({settings[i].options, 0});
        }
        for (std::size_t d = 0; d < depths.size(); ++d) {
            if (!std::isfinite(depthCosts_[d].milliseconds)) continue;
            totals.push_back({depthCosts_[d].name + "; " + costs_[i].name,
                              depthCosts_[d].milliseconds + costs_[i].milliseconds});
            choices.push_back({settings[i].options, d});
        }
    }
    const BudgetChoice choice = chooseWithinBudget(totals, *milliseconds_);
    chosen_ = totals[choice.index];
    fits_ = choice.fits;
    const std::string taken = wholeMilliseconds(chosen_.milliseconds);
    const std::string budget = wholeMilliseconds(*milliseconds_);
    messages.say("budget: " + chosen_.name +
                 (depths.empty() ? ", Native in " : ", depth and Native in ") + taken + " of " +
                 budget);
    if (!fits_)
        messages.warn("no method meets the budget of " + budget + ": " + chosen_.name +
                      ", the quickest, takes " + taken + "; " + advice_);
    return choices[choice.index];
}

Json Budget::report() const {
    if (!milliseconds_) return nullptr;
    Json report = {{"milliseconds", *milliseconds_}};
    if (costs_.empty()) return report; // no picture so far
    report["chosen"] = chosen_.name;
    report["chosenMilliseconds"] = chosen_.milliseconds;
    report["fits"] = fits_;
    report["fromCache"] = fromCache_;
    report["measured"] = costsJson(costs_);
    report["measuredDepths"] = costsJson(depthCosts_);
    return report;
}

} // namespace altiro3D::tools
