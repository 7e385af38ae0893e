#include "common/budget.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/version.hpp"
#include "common/display_options.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr int kRepetitions = 3;  // the fastest counts: others may be at work, too
constexpr int kMostViews = 1024; // that measureViews() takes
constexpr int kCacheFormat = 1;

// Two sets of views, of one view per thread and of three: preparation + views x per view.
SettingCost measured(const NamedViewOptions& setting, int viewCount, const cv::Mat& photo,
                     const cv::Mat& depth) {
    // a set is one picture, whose sides are limited
    const int side = kMaxQuiltSide / std::max(photo.cols, photo.rows);
    const int wanted = std::min({3 * cv::getNumThreads(), side * side, kMostViews});
    const int most = std::clamp(wanted, 1, viewCount);
    const int few = std::max(1, most / 3);
    const auto millisecondsOf = [&](int views) {
        return views *
               measureViews(photo, depth, setting.options, views, kRepetitions).millisecondsPerView;
    };
    SettingCost cost;
    cost.name = setting.name;
    const double all = millisecondsOf(most);
    cost.millisecondsPerView = all / most;
    if (most > few) {
        const double slope = (all - millisecondsOf(few)) / (most - few);
        cost.millisecondsPerView = std::clamp(slope, 0.0, cost.millisecondsPerView);
    }
    cost.preparationMilliseconds = std::max(0.0, all - most * cost.millisecondsPerView);
    return cost;
}

double millisecondsOf(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const auto end = std::chrono::steady_clock::now();
    return std::chrono::duration<double, std::milli>(end - start).count();
}

// Views of another size than the tiles are averaged into them, one view a thread.
double averagingMilliseconds(const cv::Mat& photo, cv::Size tileSize) {
    if (photo.size() == tileSize) return 0;
    const int count = std::max(1, cv::getNumThreads());
    return millisecondsOf([&] {
               cv::parallel_for_(cv::Range(0, count), [&](const cv::Range& range) {
                   cv::Mat tile;
                   for (int i = range.start; i < range.end; ++i)
                       cv::resize(photo, tile, tileSize, 0, 0, cv::INTER_AREA);
               });
           }) /
           count;
}

// Repeated sets are made in the same memory, a picture in fresh one, which the system clears first.
double memoryMilliseconds(const QuiltLayout& layout) {
    return millisecondsOf([&] {
        cv::Mat quilt(layout.size(), CV_8UC3);
        cv::parallel_for_(cv::Range(0, quilt.rows), [&](const cv::Range& rows) {
            quilt.rowRange(rows).setTo(cv::Scalar::all(0));
        });
    });
}

// What the costs depend on besides the picture.
std::string keyOf(const QuiltLayout& layout, cv::Size work) {
    const auto text = [](cv::Size size) {
        return std::to_string(size.width) + "x" + std::to_string(size.height);
    };
    return std::string(ALTIRO3D_VERSION) + "-" + std::to_string(cv::getNumberOfCPUs()) + "-" +
           std::to_string(cv::getNumThreads()) + "-" + text(work) +
           (work == layout.tileSize ? "" : "-" + text(layout.tileSize)) + "-" +
           std::to_string(layout.viewCount);
}

Json costsJson(const std::vector<SettingCost>& costs, int views) {
    Json list = Json::array();
    for (const SettingCost& cost : costs) {
        list.push_back({{"setting", cost.name},
                        {"preparationMilliseconds", cost.preparationMilliseconds},
                        {"millisecondsPerView", cost.millisecondsPerView},
                        {"milliseconds", cost.milliseconds(views)}});
    }
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
            SettingCost cost{entry.at("setting"), entry.at("preparationMilliseconds"),
                             entry.at("millisecondsPerView")};
            const bool good = cost.name == settings[i].name && cost.preparationMilliseconds >= 0 &&
                              cost.millisecondsPerView >= 0;
            if (!good) return {};
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
    commandLine.add({"budget"},
                    "Choose method and knobs: the best that makes the views of one picture in MS "
                    "milliseconds on this machine, 0.1..1e6. Measured on the first picture and "
                    "kept in the user's cache directory; not with --method, -g and their knobs.",
                    "MS");
}

Budget::Budget(const CommandLine& commandLine)
    : milliseconds_(commandLine.number("budget", 0.1, 1e6)) {
    for (const char* option : {"method", "g", "dilate", "soft-edges", "fill", "refine", "inpaint",
                               "inpaint-from", "camera", "fov"}) {
        commandLine.exclude("budget", option);
    }
}

ViewOptions Budget::choose(const ViewOptions& base, const QuiltLayout& layout, const cv::Mat& photo,
                           const cv::Mat& depth, Messages& messages) {
    const std::vector<NamedViewOptions> settings = budgetSettings(base);
    const std::string key = keyOf(layout, photo.size());
    const fs::path directory = cacheDirectory();
    const fs::path file = directory.empty() ? fs::path() : directory / ("budget-" + key + ".json");
    std::vector<SettingCost> costs;
    // the cache is a convenience: whatever is wrong with it, the costs are measured
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
        const double memory = memoryMilliseconds(layout);
        const double averaging = averagingMilliseconds(photo, layout.tileSize);
        for (const NamedViewOptions& setting : settings) {
            costs.push_back(measured(setting, layout.viewCount, photo, depth));
            costs.back().preparationMilliseconds += memory;
            costs.back().millisecondsPerView += averaging;
        }
        if (!file.empty()) {
            try {
                fs::create_directories(directory, error);
                const Json json = {{"format", kCacheFormat},
                                   {"key", key},
                                   {"costs", costsJson(costs, layout.viewCount)}};
                writeFile(file, json.dump(2) + "\n");
                messages.detail("costs: measured and kept as " + file.string());
            } catch (const Error& problem) {
                messages.detail(std::string("costs: measured, not kept: ") + problem.what());
            }
        }
    }
    views_ = layout.viewCount;
    choice_ = chooseWithinBudget(costs, views_, *milliseconds_);
    costs_ = std::move(costs);
    const NamedViewOptions& chosen = settings[choice_.index];
    const std::string taken =
        std::to_string(views_) + " views in " + wholeMilliseconds(choice_.milliseconds);
    const std::string budget = wholeMilliseconds(*milliseconds_);
    messages.say("budget: " + chosen.name + ", " + taken + " of " + budget);
    if (!choice_.fits) {
        messages.warn("no way to make the views keeps the budget of " + budget + ": " +
                      chosen.name + ", the quickest, makes " + taken +
                      "; fewer or smaller views take less");
    }
    return chosen.options;
}

Json Budget::report() const {
    if (!milliseconds_) return nullptr;
    Json report = {{"milliseconds", *milliseconds_}};
    if (costs_.empty()) return report; // no picture came so far
    report["chosen"] = costs_[choice_.index].name;
    report["chosenMilliseconds"] = choice_.milliseconds;
    report["fits"] = choice_.fits;
    report["views"] = views_;
    report["fromCache"] = fromCache_;
    report["measured"] = costsJson(costs_, views_);
    return report;
}

} // namespace altiro3D::tools
