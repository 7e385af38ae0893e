#include "common/budget.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/version.hpp"
#include "common/display_options.hpp"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr int kRepetitions = 3;     // the fastest one counts, because the machine may be busy
constexpr double kEnoughTime = 500; // ms after which there is no further repetition
constexpr int kCacheFormat = 3;

double measured(const std::function<void()>& work) {
    double fastest = 0;
    double total = 0;
    for (int i = 0; i < kRepetitions && total < kEnoughTime; ++i) {
        const auto start = std::chrono::steady_clock::now();
        work();
        const auto end = std::chrono::steady_clock::now();
        const double taken = std::chrono::duration<double, std::milli>(end - start).count();
        fastest = i == 0 ? taken : std::min(fastest, taken);
        total += taken;
    }
    return fastest;
}

Json costsJson(const std::vector<SettingCost>& costs) {
    Json list = Json::array();
    for (const SettingCost& cost : costs)
        list.push_back({{"setting", cost.name}, {"milliseconds", cost.milliseconds}});
    return list;
}

// The costs of all settings, or nothing if the text does not hold them.
std::vector<SettingCost> parseCosts(const std::string& text, const std::string& key,
                                    const std::vector<NamedViewOptions>& settings) {
    try {
        const Json json = Json::parse(text);
        if (json.at("format") != kCacheFormat || json.at("key") != key) return {};
        const Json& list = json.at("costs");
        if (list.size() != settings.size()) return {};
        std::vector<SettingCost> costs;
        for (std::size_t i = 0; i < settings.size(); ++i) {
            const Json& entry = list.at(i);
            SettingCost cost{entry.at("setting"), entry.at("milliseconds")};
            if (cost.name != settings[i].name || !(cost.milliseconds >= 0)) return {};
            costs.push_back(std::move(cost));
        }
        return costs;
    } catch (const Json::exception&) {
        return {};
    }
}

std::string wholeMilliseconds(double value) {
    char text[64];
    std::snprintf(text, sizeof text, value < 10 ? "%.1f" : "%.0f", value);
    const std::string number = text;
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
    settings.push_back({"layered, fill continue", options});
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
        "Choose the best method that makes a Native from a photo with depth in MS milliseconds on "
        "this machine, 0.1..1e6. The times are measured on the first picture and kept in the "
        "user's cache directory. Not with --method, -g and their options.",
        "MS");
}

Budget::Budget(const CommandLine& commandLine)
    : milliseconds_(commandLine.number("budget", 0.1, 1e6)) {
    for (const char* option : {"method", "g", "fill", "refine", "inpaint-from", "camera"}) {
        commandLine.exclude("budget", option);
    }
    advice_ = "smaller views (-r) take less";
    if (commandLine.has("k")) advice_ = "it takes less without -k";
    if (commandLine.has("best")) advice_ = "it takes less without --best";
}

ViewOptions Budget::choose(const ViewOptions& base, const std::string& work,
                           const std::function<void(const ViewOptions&)>& makeNative,
                           Messages& messages) {
    const std::vector<NamedViewOptions> settings = budgetSettings(base);
    const std::string key = std::string(version()) + "-" + std::to_string(cv::getNumberOfCPUs()) +
                            "-" + std::to_string(cv::getNumThreads()) + "-" + work;
    const fs::path directory = cacheDirectory();
    const fs::path file = directory.empty() ? fs::path() : directory / ("budget-" + key + ".json");
    std::vector<SettingCost> costs;
    // the cache is optional: if anything is wrong with it, the costs are measured
    std::error_code error;
    if (!file.empty() && fs::exists(file, error)) {
        try {
            costs = parseCosts(readFile(file, 1 << 16), key, settings);
        } catch (const Error& problem) {
            messages.detail(std::string("costs in the cache are not used: ") + problem.what());
        }
    }
    fromCache_ = !costs.empty();
    if (fromCache_) {
        messages.detail("costs: from the cache, " + file.string());
    } else {
        for (const NamedViewOptions& setting : settings)
            costs.push_back({setting.name, measured([&] { makeNative(setting.options); })});
        if (!file.empty()) {
            try {
                fs::create_directories(directory, error);
                const Json json = {
                    {"format", kCacheFormat}, {"key", key}, {"costs", costsJson(costs)}};
                writeFile(file, json.dump(2) + "\n");
                messages.detail("costs: measured and kept as " + file.string());
            } catch (const Error& problem) {
                messages.detail(std::string("costs: measured, not kept: ") + problem.what());
            }
        }
    }
    choice_ = chooseWithinBudget(costs, *milliseconds_);
    costs_ = std::move(costs);
    const NamedViewOptions& chosen = settings[choice_.index];
    const std::string taken = wholeMilliseconds(costs_[choice_.index].milliseconds);
    const std::string budget = wholeMilliseconds(*milliseconds_);
    messages.say("budget: " + chosen.name + ", Native in " + taken + " of " + budget);
    if (!choice_.fits) {
        messages.warn("no method keeps the budget of " + budget + ": " + chosen.name +
                      ", the quickest, takes " + taken + "; " + advice_);
    }
    return chosen.options;
}

Json Budget::report() const {
    if (!milliseconds_) return nullptr;
    Json report = {{"milliseconds", *milliseconds_}};
    if (costs_.empty()) return report; // no picture so far
    report["chosen"] = costs_[choice_.index].name;
    report["chosenMilliseconds"] = costs_[choice_.index].milliseconds;
    report["fits"] = choice_.fits;
    report["fromCache"] = fromCache_;
    report["measured"] = costsJson(costs_);
    return report;
}

} // namespace altiro3D::tools
