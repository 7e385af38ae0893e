// altiro3Dtradeoff: time and accuracy of each way to make views.

#include "altiro3D/altiro3D.hpp"
#include "altiro3D/trade.hpp"
#include "common/depth_options.hpp"
#include "common/depth_trade.hpp"
#include "common/outputs.hpp"
#include "common/picture_options.hpp"
#include "common/run_tool.hpp"
#include "common/trade_plot.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <set>
#include <sstream>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr int kViews = 48;

// One setting on one scene, or the mean of several.
struct Row {
    std::string setting;
    std::string scene;
    ViewAccuracy accuracy;
    ViewCost cost;
    double peakMegabytes = 0;
};

std::string lineOf(const Row& row) {
    char text[256];
    std::snprintf(text, sizeof text, "%-22s %8.2f ms %7.2f dB %6.4f %9.2f dB %6.4f %8.0f MB",
                  row.setting.c_str(), row.cost.millisecondsPerView, row.accuracy.psnrWhole,
                  row.accuracy.ssimWhole, row.accuracy.psnrInside, row.accuracy.ssimInside,
                  row.peakMegabytes);
    return text;
}

const char* const kHeading =
    "setting                 per view      whole frame        inside            memory";

Row measure(const NamedViewOptions& setting, const StereoScene& scene) {
    Row row;
    row.setting = setting.name;
    row.scene = scene.name;
    const ViewOptions options = scene.options(setting.options);
    cv::Mat view;
    Depth2Quilt({1, 1, scene.photo.size(), 1}, options).renderView(scene, 1, view);
    row.accuracy = compareViews(view, scene.truth, scene.band());
    resetPeakMemory();
    row.cost = measureViews(scene, options, kViews, 3);
    row.peakMegabytes = peakMegabytes();
    return row;
}

std::vector<Row> meansOf(const std::vector<Row>& rows, std::size_t settings) {
    std::vector<Row> means;
    const std::size_t scenes = rows.size() / settings;
    for (std::size_t s = 0; s < settings; ++s) {
        Row mean;
        mean.setting = rows[s].setting;
        mean.scene = "mean";
        for (std::size_t i = s; i < rows.size(); i += settings) {
            const Row& row = rows[i];
            const double share = 1.0 / static_cast<double>(scenes);
            addShare(share, row.accuracy, mean.accuracy);
            mean.cost.millisecondsPerView += share * row.cost.millisecondsPerView;
            mean.cost.preparationMilliseconds += share * row.cost.preparationMilliseconds;
            mean.peakMegabytes = std::max(mean.peakMegabytes, row.peakMegabytes);
        }
        means.push_back(mean);
    }
    return means;
}

double numberOf(const std::string& text, const std::string& file, const std::string& field) {
    double value = 0;
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, value);
    if (parsed.ec == std::errc() && parsed.ptr == end) return value;
    throw Error(ErrorCode::BadFormat, file, field + " is \"" + text + "\", expected a number");
}

// The depth as the tools use it; says what was done and how long it took.
void refine(const CommandLine& commandLine, Scene& scene, Messages& messages) {
    const DepthRefineOptions options = refineOptions(commandLine);
    if (options.keepsDepth()) return;
    const auto start = std::chrono::steady_clock::now();
    const DepthFlaws flaws = refineScene(scene, options);
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
    std::string said = "depth: refined in " + fixed(time.count(), 1) + " ms; edges soft over " +
                       fixed(flaws.softnessPixels, 1) + " px, too large by " +
                       fixed(flaws.growthPixels, 1) + " px, shifted by (" +
                       std::to_string(flaws.shiftPixels.x) + ", " +
                       std::to_string(flaws.shiftPixels.y) + ") px";
    if (flaws.mixedPixels > 0)
        said +=
            "; soft photo: near things extended by " + std::to_string(flaws.mixedPixels) + " px";
    messages.say(said);
}

StereoScene readScene(const std::string& name, const fs::path& photo, const fs::path& disparity,
                      double scale, const fs::path& truth) {
    const QuietStandardError quiet;
    const cv::Mat left =
        readPhoto(photo); // in this order, because the error names the first damaged file
    const cv::Mat raw = readDepthImage(disparity);
    return makeStereoScene(name, left, raw, scale, readPhoto(truth));
}

// scenes.csv: scene, left, right, disp_left, disp_scale by name; files in a folder named as the
// scene.
std::vector<StereoScene> readScenes(const fs::path& file) {
    std::istringstream text(readFile(file, 1 << 20));
    std::vector<StereoScene> scenes;
    std::vector<std::string> columns;
    for (std::string line; std::getline(text, line);) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        std::vector<std::string> cells;
        std::istringstream split(line);
        for (std::string cell; std::getline(split, cell, ',');)
            cells.push_back(cell);
        if (cells.empty()) continue;
        if (columns.empty()) {
            columns = cells;
            continue;
        }
        std::map<std::string, std::string> row;
        for (std::size_t i = 0; i < std::min(columns.size(), cells.size()); ++i) {
            row[columns[i]] = cells[i];
        }
        for (const char* needed : {"scene", "left", "right", "disp_left", "disp_scale"}) {
            if (!row[needed].empty()) continue;
            throw Error(ErrorCode::BadFormat, file.string(),
                        std::string("has no ") + needed + " in \"" + line +
                            "\", expected the columns scene, left, right, disp_left, disp_scale");
        }
        const fs::path folder = file.parent_path() / row["scene"];
        scenes.push_back(readScene(row["scene"], folder / row["left"], folder / row["disp_left"],
                                   numberOf(row["disp_scale"], file.string(), "disp_scale"),
                                   folder / row["right"]));
    }
    if (scenes.empty()) {
        throw Error(ErrorCode::BadFormat, file.string(), "lists no scenes, expected one per line");
    }
    return scenes;
}

// Without a true view, the most accurate setting is the reference.
StereoScene sceneOfPhoto(const CommandLine& commandLine, Messages& messages) {
    const std::vector<fs::path>& files = commandLine.files();
    ChosenDepth source(commandLine, messages);
    StageTimes times;
    StereoScene scene;
    const fs::path depthFile = source.fromFiles() ? files[1] : fs::path();
    if (autoChoices(commandLine).any())
        throw UsageError("--strength and --focus: auto is not possible here, expected a number");
    const double focus = viewOptions(commandLine).focus;
    Scene fitted = source.read(files[0], depthFile, focus, messages, times);
    const DepthRefineOptions later{DepthFlaws()};
    fitScene(fitted, fitPhoto(fitted.photo.size(), 0.75, QuiltLayout().tileSize), focus, fitted,
             later);
    static_cast<Scene&>(scene) = fitted;
    scene.name = files[0].filename().string();
    refine(commandLine, scene, messages);
    return scene;
}

std::vector<Row> measurePhoto(const CommandLine& commandLine, Messages& messages) {
    const StereoScene scene = sceneOfPhoto(commandLine, messages);
    const std::vector<NamedViewOptions> settings = tradeSettings(viewOptions(commandLine));
    cv::Mat reference;
    Depth2Quilt({1, 1, scene.photo.size(), 1}, settings.back().options)
        .renderView(scene, 1, reference);
    messages.say("reference: " + settings.back().name + ", outermost view, " +
                 sizeText(scene.photo.size()));
    messages.say(kHeading);
    std::vector<Row> rows;
    Progress progress(settings.size());
    for (const NamedViewOptions& setting : settings) {
        progress.step(setting.name);
        Row row;
        row.setting = setting.name;
        row.scene = scene.name;
        cv::Mat view;
        Depth2Quilt({1, 1, scene.photo.size(), 1}, setting.options).renderView(scene, 1, view);
        const int band =
            static_cast<int>(setting.options.strengthPercent / 200 * scene.photo.cols) + 2;
        row.accuracy = compareViews(view, reference, band);
        resetPeakMemory();
        row.cost = measureViews(scene, setting.options, kViews, 3);
        row.peakMegabytes = peakMegabytes();
        progress.clear();
        messages.say(lineOf(row));
        rows.push_back(row);
    }
    return rows;
}

// The views with default options, for visual comparison.
void saveViews(const StereoScene& scene, const fs::path& directory) {
    for (const NamedViewOptions& method : defaultSettings()) {
        cv::Mat view;
        Depth2Quilt({1, 1, scene.photo.size(), 1}, scene.options(method.options))
            .renderView(scene, 1, view);
        writeImage(directory / (method.name + ".png"), view);
    }
}

std::vector<Row> measureScenes(const CommandLine& commandLine, std::vector<StereoScene>& scenes,
                               Messages& messages) {
    const std::vector<NamedViewOptions> settings = tradeSettings();
    std::vector<Row> rows;
    Progress progress(scenes.size() * settings.size());
    for (StereoScene& scene : scenes) {
        messages.say(scene.name + ", " + sizeText(scene.photo.size()) + ", disparity up to " +
                     fixed(scene.largestDisparity, 2) + " px");
        refine(commandLine, scene, messages);
        messages.say(kHeading);
        for (const NamedViewOptions& setting : settings) {
            progress.step(scene.name + ", " + setting.name);
            rows.push_back(measure(setting, scene));
            progress.clear();
            messages.say(lineOf(rows.back()));
        }
    }
    if (scenes.size() > 1) {
        messages.say("mean of " + std::to_string(scenes.size()) + " scenes");
        messages.say(kHeading);
        for (const Row& row : meansOf(rows, settings.size())) {
            messages.say(lineOf(row));
            rows.push_back(row);
        }
    }
    return rows;
}

// The sources of depth that can be loaded. A network that cannot run with half its size is left
// out.
std::vector<std::pair<std::string, std::unique_ptr<DepthSource>>>
loadDepthSources(const std::vector<NamedDepthSource>& sources, Messages& messages) {
    std::vector<std::pair<std::string, std::unique_ptr<DepthSource>>> loaded;
    for (const NamedDepthSource& source : sources) {
        try {
            loaded.emplace_back(source.name, source.load());
        } catch (const Error& error) {
            if (source.isUsual) messages.warn(error.what());
        }
    }
    return loaded;
}

// What each source of depth would cost and give instead of the true disparity. One that fails is
// left out of every scene.
std::vector<DepthRow> measureDepths(const CommandLine& commandLine,
                                    const std::vector<StereoScene>& scenes,
                                    const std::vector<NamedDepthSource>& listed,
                                    Messages& messages) {
    auto sources = loadDepthSources(listed, messages);
    if (sources.empty()) return {};
    const DepthRefineOptions refine = refineOptions(commandLine);
    std::vector<DepthRow> rows;
    Progress progress(scenes.size() * sources.size());
    for (const StereoScene& scene : scenes) {
        messages.say(kDepthHeading + (scenes.size() > 1 ? ", " + scene.name : std::string()));
        for (auto source = sources.begin(); source != sources.end();) {
            const std::string name = source->first;
            progress.step(scene.name + ", " + name);
            try {
                rows.push_back(measureDepth(name, *source->second, scene, refine));
                progress.clear();
                messages.say(lineOf(rows.back()));
                ++source;
            } catch (const Error& error) {
                progress.clear();
                messages.warn("depth by " + name + " is left out: " + error.what());
                const auto isOfIt = [&](const DepthRow& row) { return row.source == name; };
                rows.erase(std::remove_if(rows.begin(), rows.end(), isOfIt), rows.end());
                source = sources.erase(source);
            }
        }
    }
    if (scenes.size() > 1) {
        messages.say(std::string(kDepthHeading) + ", mean");
        for (const DepthRow& row : meansOf(rows, sources.size())) {
            messages.say(lineOf(row));
            rows.push_back(row);
        }
    }
    return rows;
}

// JSON has no infinity: the PSNR of equal pictures is null.
std::string jsonOf(const std::vector<Row>& rows, const std::vector<DepthRow>& depths, bool truth) {
    Json list = Json::array();
    for (const Row& row : rows) {
        list.push_back({{"scene", row.scene},
                        {"setting", row.setting},
                        {"millisecondsPerView", row.cost.millisecondsPerView},
                        {"preparationMilliseconds", row.cost.preparationMilliseconds},
                        {"psnrWhole", row.accuracy.psnrWhole},
                        {"ssimWhole", row.accuracy.ssimWhole},
                        {"psnrInside", row.accuracy.psnrInside},
                        {"ssimInside", row.accuracy.ssimInside},
                        {"peakMegabytes", row.peakMegabytes}});
    }
    Json depthList = Json::array();
    for (const DepthRow& row : depths) {
        depthList.push_back({{"scene", row.scene},
                             {"source", row.source},
                             {"milliseconds", row.milliseconds},
                             {"rankCorrelation", row.rankCorrelation},
                             {"psnrWhole", row.accuracy.psnrWhole},
                             {"ssimWhole", row.accuracy.ssimWhole},
                             {"psnrInside", row.accuracy.psnrInside},
                             {"ssimInside", row.accuracy.ssimInside}});
    }
    const Json report = {{"tool", "altiro3Dtradeoff"},
                         {"version", version()},
                         {"openCv", CV_VERSION},
                         {"threads", cv::getNumThreads()},
                         {"views", kViews},
                         {"against", truth ? "true view" : "most accurate setting"},
                         {"rows", list},
                         {"estimatedDepth", depthList}};
    return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

// Names may hold commas and quotation marks.
std::string quoted(std::string text) {
    for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2)
        text.insert(at, 1, '"');
    return '"' + text + '"';
}

std::string csvOf(const std::vector<Row>& rows) {
    std::string text = "scene,setting,ms_per_view,preparation_ms,psnr_whole,ssim_whole,psnr_inside,"
                       "ssim_inside,peak_mb\n";
    for (const Row& row : rows) {
        text += quoted(row.scene) + "," + quoted(row.setting) + "," +
                fixed(row.cost.millisecondsPerView, 4) + "," +
                fixed(row.cost.preparationMilliseconds, 3) + "," +
                fixed(row.accuracy.psnrWhole, 4) + "," + fixed(row.accuracy.ssimWhole, 5) + "," +
                fixed(row.accuracy.psnrInside, 4) + "," + fixed(row.accuracy.ssimInside, 5) + "," +
                fixed(row.peakMegabytes, 1) + "\n";
    }
    return text;
}

std::string plotOf(const std::vector<Row>& rows) {
    std::vector<TradePoint> points;
    const std::string scene = rows.back().scene; // the mean, or the only scene
    for (const Row& row : rows) {
        if (row.scene != scene || !std::isfinite(row.accuracy.psnrInside)) continue;
        points.push_back({row.setting, row.cost.millisecondsPerView, row.accuracy.psnrInside});
    }
    return tradePlotSvg(points, scene);
}

// Refuses options without an effect.
void checkOptions(const CommandLine& commandLine, bool truth) {
    const std::set<std::string> forTruth = {
        "photo", "disparity", "disparity-scale", "truth", "scenes", "report",     "csv",
        "plot",  "y",         "save-views",      "j",     "v",      "exact-depth"};
    for (const auto& [option, value] : commandLine.given()) {
        const std::string name = (option.size() > 1 ? "--" : "-") + option;
        if (truth && forTruth.count(option) == 0) {
            throw UsageError(name + " does not apply to scenes with a true view; leave it out");
        }
    }
    if (commandLine.has("disparity-scale") && !commandLine.has("photo")) {
        throw UsageError("--disparity-scale applies to --disparity, expected --photo with it");
    }
}

int run(const CommandLine& commandLine, Messages& messages) {
    const bool single = commandLine.has("photo");
    const bool collection = commandLine.has("scenes");
    commandLine.exclude("photo", "scenes");
    checkOptions(commandLine, single || collection);
    for (const char* needed : {"disparity", "truth"}) {
        if (single == commandLine.has(needed)) continue;
        throw UsageError("--photo, --disparity and --truth belong together; see "
                         "altiro3Dtradeoff --help");
    }
    const std::size_t wanted = single || collection ? 0 : commandLine.has("d") ? 2 : 1;
    if (commandLine.files().size() != wanted) {
        commandLine.failNames(wanted == 0   ? "no names beside --photo or --scenes"
                              : wanted == 2 ? "PHOTO and DEPTH"
                                            : "PHOTO (with -d PHOTO and DEPTH)",
                              wanted);
    }
    Outputs outputs(commandLine.has("y"));
    for (const char* input : {"photo", "disparity", "truth", "scenes"}) {
        if (const auto file = commandLine.value(input)) outputs.addInput(*file);
    }
    for (const fs::path& file : commandLine.files())
        outputs.addInput(file);
    for (const char* output : {"report", "csv", "plot"}) {
        if (const auto file = commandLine.value(output)) outputs.addOutput(*file);
    }
    const auto views = commandLine.value("save-views");
    if (views && !single) {
        throw UsageError("--save-views shows one scene, expected --photo, --disparity and --truth");
    }
    if (views) {
        outputs.addDirectory(*views);
        for (const NamedViewOptions& method : defaultSettings()) {
            outputs.addOutput(fs::path(*views) / (method.name + ".png"));
        }
    }
    outputs.check();
    outputs.makeDirectories();

    std::vector<Row> rows;
    std::vector<DepthRow> depths;
    if (single) {
        const fs::path photo = *commandLine.value("photo");
        std::vector<StereoScene> scene = {
            readScene(photo.filename().string(), photo, *commandLine.value("disparity"),
                      commandLine.number("disparity-scale", 1e-6, 1e6).value_or(1),
                      *commandLine.value("truth"))};
        const auto sources = depthSources(messages);  // may fail, so before any work
        const std::vector<StereoScene> exact = scene; // the depth that rows are made of is refined
        rows = measureScenes(commandLine, scene, messages);
        depths = measureDepths(commandLine, exact, sources, messages);
        if (views) saveViews(scene.front(), *views);
    } else if (collection) {
        std::vector<StereoScene> scenes = readScenes(*commandLine.value("scenes"));
        const auto sources = depthSources(messages); // as above
        const std::vector<StereoScene> exact = scenes;
        rows = measureScenes(commandLine, scenes, messages);
        depths = measureDepths(commandLine, exact, sources, messages);
    } else {
        rows = measurePhoto(commandLine, messages);
    }
    if (const auto file = commandLine.value("report")) {
        writeFile(*file, jsonOf(rows, depths, single || collection));
    }
    if (const auto file = commandLine.value("csv")) writeFile(*file, csvOf(rows));
    if (const auto file = commandLine.value("plot")) writeFile(*file, plotOf(rows));
    return kExitDone;
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine("altiro3Dtradeoff",
                            "Measures how fast and how accurate each way to make views is on this "
                            "machine: time per view, PSNR, SSIM and memory.");
    commandLine.addUsage("[options] PHOTO");
    commandLine.addUsage("[options] -d PHOTO DEPTH");
    commandLine.addUsage("--photo L.png --disparity D.png --disparity-scale S --truth R.png");
    commandLine.addUsage("--scenes scenes.csv");
    commandLine.addSection("Against a true view");
    commandLine.add({"photo"}, "Photo of the left camera.", "L.png");
    commandLine.add({"disparity"},
                    "Its disparity: larger is nearer, content moves to the left; 0 is unknown.",
                    "D.png");
    commandLine.add({"disparity-scale"}, "Values per px of disparity (default 1).", "S");
    commandLine.add({"truth"}, "Photo of the right camera.", "R.png");
    commandLine.add({"scenes"},
                    "Many scenes: a table with the columns scene, left, right, disp_left and "
                    "disp_scale; each scene's files are in a folder with its name.",
                    "FILE.csv");
    commandLine.addSection("Output");
    commandLine.add({"report"}, "Write all numbers, for programs.", "FILE.json");
    commandLine.addOldName("report", "json");
    commandLine.addAdvanced({"csv"}, "Write all numbers as a table.", "FILE");
    commandLine.add({"plot"}, "Draw accuracy over time, with the best settings marked.",
                    "FILE.svg");
    commandLine.add({"save-views"}, "Write the view of each method with default options.", "DIR");
    commandLine.add({"y"}, "Replace outputs that exist.");
    addDepthOptions(commandLine);
    commandLine.addSection("Views");
    addSceneOptions(commandLine, AutoUse::None);
    addRefineOption(commandLine);
    commandLine.addNote(
        "Without a true view the most accurate setting is the reference: the numbers "
        "are the differences from it. Times are those of a set of 48 "
        "views, divided by 48; -j 1 measures one thread. \"Inside\" leaves "
        "out the borders that the photo does not show; inf dB means no difference.");
    commandLine.addNote(
        "With a true view a second table compares the sources of estimated depth on this machine: "
        "the time per photo, Spearman's rank correlation with the true disparity, and the accuracy "
        "of method Layered with this depth, scaled and shifted to the true one.");
    commandLine.addTerm(CommandLine::Chapter::Examples, "holiday.jpg",
                        "Compare the methods on a photo, with estimated depth.");
    commandLine.addTerm(CommandLine::Chapter::Examples,
                        "--plot trade.svg -d holiday.jpg painted.png",
                        "Compare them with given depth, and draw the result.");
    commandLine.addTerm(CommandLine::Chapter::Examples, "-j 1 --report trade.json holiday.jpg",
                        "Measure one thread, and write all numbers.");
    return runTool(argc, argv, commandLine, run);
}
