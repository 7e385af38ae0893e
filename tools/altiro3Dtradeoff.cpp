// altiro3Dtradeoff: time and accuracy of each way to make views.

#include "altiro3D/altiro3D.hpp"
#include "altiro3D/depth2quilt.hpp"
#include "cli/chosen_depth.hpp"
#include "cli/json_text.hpp"
#include "cli/network_trust.hpp"
#include "cli/outputs.hpp"
#include "cli/picture_options.hpp"
#include "cli/run_tool.hpp"
#include "cli/trade_plot.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <sstream>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr int kViews = 48;

// The command line.
struct TradeJob {
    std::vector<fs::path> names; // photo, and its depth
    fs::path photo;              // with a true view
    fs::path disparity;
    double disparityScale = 1;
    fs::path truth;
    fs::path scenes; // many of them
    fs::path report;
    fs::path csv;
    fs::path plot;
    fs::path saveViews;
    bool replace = false;
    ViewOptions views;
    DepthRefineOptions refine;
    DepthOptions depth;

    bool hasTruth() const { return !photo.empty() || !scenes.empty(); }
};

// A way to make views, or a source of depth, on one scene or in the mean of several.
struct Row {
    std::string scene;
    std::string name;
    ViewAccuracy accuracy;      // with estimated depth: of method Layered, scaled to the true depth
    double milliseconds = 0;    // for a view, or for the depth of a photo
    double preparation = 0;     // ms
    double peakMegabytes = 0;   // of a way to make views
    double rankCorrelation = 0; // of estimated depth with the true one, -1..1
};

std::string lineOf(const Row& row) {
    char text[256];
    std::snprintf(text, sizeof text, "%-22s %8.2f ms %7.2f dB %6.4f %9.2f dB %6.4f %8.0f MB",
                  row.name.c_str(), row.milliseconds, row.accuracy.psnrWhole,
                  row.accuracy.ssimWhole, row.accuracy.psnrInside, row.accuracy.ssimInside,
                  row.peakMegabytes);
    return text;
}

std::string depthLineOf(const Row& row) {
    char text[256];
    std::snprintf(text, sizeof text, "%-24s %6.1f ms %7.3f %9.2f dB %6.4f %9.2f dB %6.4f",
                  row.name.c_str(), row.milliseconds, row.rankCorrelation, row.accuracy.psnrWhole,
                  row.accuracy.ssimWhole, row.accuracy.psnrInside, row.accuracy.ssimInside);
    return text;
}

const char* const kHeading =
    "setting                 per view      whole frame        inside            memory";
const char* const kDepthHeading =
    "estimated depth          per photo   order     layered, whole        inside";

cv::Mat outermostView(const Scene& scene, const ViewOptions& options) {
    cv::Mat view;
    Depth2Quilt({1, 1, scene.photo.size(), 1}, options).renderView(scene, 1, view);
    return view;
}

// @param truth the outermost view @param band px at the sides that are not "inside"
Row measure(const NamedViewOptions& setting, const StereoScene& scene, const ViewOptions& options,
            const cv::Mat& truth, int band) {
    Row row;
    row.name = setting.name;
    row.scene = scene.name;
    row.accuracy = compareViews(outermostView(scene, options), truth, band);
    resetPeakMemory();
    const ViewCost cost = measureViews(scene, options, kViews, 3);
    row.milliseconds = cost.millisecondsPerView;
    row.preparation = cost.preparationMilliseconds;
    row.peakMegabytes = peakMegabytes();
    return row;
}

// @param refine how the depth is refined before views are made
Row measureDepth(const std::string& name, DepthSource& source, const StereoScene& scene,
                 const DepthRefineOptions& refine) {
    Row row;
    row.scene = scene.name;
    row.name = name;
    Scene estimated;
    row.milliseconds = fastestMilliseconds([&] { source.readScene(scene.photo, 0.5, estimated); });
    Scene aligned{scene.photo, {}, {}, {}, estimated.edges};
    cv::Mat& depth = aligned.depth;
    cv::resize(estimated.depth, depth, scene.depth.size(), 0, 0, cv::INTER_LINEAR);
    row.rankCorrelation = rankCorrelation(depth, scene.depth);
    alignDepth(depth, scene.depth, depth);
    refineScene(aligned, refine);
    ViewOptions layered;
    layered.method = ViewMethod::Layered;
    row.accuracy =
        compareViews(outermostView(aligned, scene.options(layered)), scene.truth, scene.band());
    return row;
}

// The mean of each row over the scenes, but the maximum of the peak memory.
// @param rows those of each scene in turn: `count` of them, in the same order
std::vector<Row> meansOf(const std::vector<Row>& rows, std::size_t count) {
    std::vector<Row> means;
    const double share = static_cast<double>(count) / static_cast<double>(rows.size());
    for (std::size_t first = 0; first < count; ++first) {
        Row mean;
        mean.name = rows[first].name;
        mean.scene = "mean";
        for (std::size_t i = first; i < rows.size(); i += count) {
            const Row& row = rows[i];
            mean.accuracy.psnrWhole += share * row.accuracy.psnrWhole;
            mean.accuracy.ssimWhole += share * row.accuracy.ssimWhole;
            mean.accuracy.psnrInside += share * row.accuracy.psnrInside;
            mean.accuracy.ssimInside += share * row.accuracy.ssimInside;
            mean.milliseconds += share * row.milliseconds;
            mean.preparation += share * row.preparation;
            mean.rankCorrelation += share * row.rankCorrelation;
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
void refine(const DepthRefineOptions& options, Scene& scene, Messages& messages) {
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

StereoScene readStereoScene(const std::string& name, const fs::path& photo,
                            const fs::path& disparity, double scale, const fs::path& truth) {
    const QuietStandardError quiet;
    const cv::Mat left =
        readPhoto(photo); // in this order, because the error names the first damaged file
    const cv::Mat raw = readDepthImage(disparity);
    return makeStereoScene(name, left, raw, scale, readPhoto(truth));
}

// Reads scenes.csv. Its first line names the columns, among them scene, left, right, disp_left and
// disp_scale. The files of a scene lie in a folder of its name.
std::vector<StereoScene> readStereoScenes(const fs::path& file) {
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
        for (std::size_t i = 0; i < std::min(columns.size(), cells.size()); ++i)
            row[columns[i]] = cells[i];
        for (const char* needed : {"scene", "left", "right", "disp_left", "disp_scale"}) {
            if (!row[needed].empty()) continue;
            throw Error(ErrorCode::BadFormat, file.string(),
                        std::string("has no ") + needed + " in \"" + line +
                            "\", expected the columns scene, left, right, disp_left, disp_scale");
        }
        const fs::path folder = file.parent_path() / row["scene"];
        scenes.push_back(readStereoScene(
            row["scene"], folder / row["left"], folder / row["disp_left"],
            numberOf(row["disp_scale"], file.string(), "disp_scale"), folder / row["right"]));
    }
    if (scenes.empty())
        throw Error(ErrorCode::BadFormat, file.string(), "lists no scenes, expected one per line");
    return scenes;
}

// Without a true view, the most accurate setting is the reference.
StereoScene sceneOfPhoto(const TradeJob& job, Messages& messages) {
    ChosenDepth source(job.depth, messages);
    StageTimes times;
    StereoScene scene;
    const fs::path depthFile = job.depth.fromFiles ? job.names[1] : fs::path();
    const double focus = job.views.focus;
    const PhotoScene read = source.read(job.names[0], depthFile, focus, messages, times);
    const DepthRefineOptions later{DepthFlaws()};
    Scene fitted;
    fitScene(read, fitPhoto(read.photo.size(), 0.75, QuiltLayout().tileSize), focus, fitted, later);
    static_cast<Scene&>(scene) = fitted;
    scene.name = job.names[0].filename().string();
    refine(job.refine, scene, messages);
    return scene;
}

std::vector<Row> measurePhoto(const TradeJob& job, Messages& messages) {
    const StereoScene scene = sceneOfPhoto(job, messages);
    const std::vector<NamedViewOptions> settings = tradeSettings(job.views);
    const cv::Mat reference = outermostView(scene, settings.back().options);
    messages.say("reference: " + settings.back().name + ", outermost view, " +
                 sizeText(scene.photo.size()));
    messages.say(kHeading);
    std::vector<Row> rows;
    Progress progress(settings.size());
    for (const NamedViewOptions& setting : settings) {
        progress.step(setting.name);
        const int band =
            static_cast<int>(setting.options.strengthPercent / 200 * scene.photo.cols) + 2;
        rows.push_back(measure(setting, scene, setting.options, reference, band));
        progress.clear();
        messages.say(lineOf(rows.back()));
    }
    return rows;
}

// The views with default options, for visual comparison.
void saveViews(const StereoScene& scene, const fs::path& directory) {
    for (const NamedViewOptions& method : defaultSettings())
        writeImage(directory / (method.name + ".png"),
                   outermostView(scene, scene.options(method.options)));
}

std::vector<Row> measureScenes(const TradeJob& job, std::vector<StereoScene>& scenes,
                               Messages& messages) {
    const std::vector<NamedViewOptions> settings = tradeSettings();
    std::vector<Row> rows;
    Progress progress(scenes.size() * settings.size());
    for (StereoScene& scene : scenes) {
        messages.say(scene.name + ", " + sizeText(scene.photo.size()) + ", disparity up to " +
                     fixed(scene.largestDisparity, 2) + " px");
        refine(job.refine, scene, messages);
        messages.say(kHeading);
        for (const NamedViewOptions& setting : settings) {
            progress.step(scene.name + ", " + setting.name);
            rows.push_back(
                measure(setting, scene, scene.options(setting.options), scene.truth, scene.band()));
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

// Time and accuracy of each source of depth in place of the true disparity. A source that fails on
// one scene is left out of all scenes.
std::vector<Row> measureDepths(const DepthRefineOptions& refine,
                               const std::vector<StereoScene>& scenes,
                               const std::vector<NamedDepthSource>& listed, Messages& messages) {
    auto sources = loadDepthSources(listed, messages);
    if (sources.empty()) return {};
    std::vector<Row> rows;
    Progress progress(scenes.size() * sources.size());
    for (const StereoScene& scene : scenes) {
        messages.say(kDepthHeading + (scenes.size() > 1 ? ", " + scene.name : std::string()));
        for (auto source = sources.begin(); source != sources.end();) {
            const std::string name = source->first;
            progress.step(scene.name + ", " + name);
            try {
                rows.push_back(measureDepth(name, *source->second, scene, refine));
                progress.clear();
                messages.say(depthLineOf(rows.back()));
                ++source;
            } catch (const Error& error) {
                progress.clear();
                messages.warn("depth by " + name + " is left out: " + error.what());
                const auto isOfIt = [&](const Row& row) { return row.name == name; };
                rows.erase(std::remove_if(rows.begin(), rows.end(), isOfIt), rows.end());
                source = sources.erase(source);
            }
        }
    }
    if (scenes.size() > 1) {
        messages.say(std::string(kDepthHeading) + ", mean");
        for (const Row& row : meansOf(rows, sources.size())) {
            messages.say(depthLineOf(row));
            rows.push_back(row);
        }
    }
    return rows;
}

void addAccuracy(const ViewAccuracy& accuracy, Json& json) {
    json["psnrWhole"] = accuracy.psnrWhole;
    json["ssimWhole"] = accuracy.ssimWhole;
    json["psnrInside"] = accuracy.psnrInside;
    json["ssimInside"] = accuracy.ssimInside;
}

// JSON has no infinity: the PSNR of equal pictures is null.
std::string jsonOf(const std::vector<Row>& rows, const std::vector<Row>& depths, bool truth) {
    Json list = Json::array();
    for (const Row& row : rows) {
        list.push_back({{"scene", row.scene},
                        {"setting", row.name},
                        {"millisecondsPerView", row.milliseconds},
                        {"preparationMilliseconds", row.preparation}});
        addAccuracy(row.accuracy, list.back());
        list.back()["peakMegabytes"] = row.peakMegabytes;
    }
    Json depthList = Json::array();
    for (const Row& row : depths) {
        depthList.push_back({{"scene", row.scene},
                             {"source", row.name},
                             {"milliseconds", row.milliseconds},
                             {"rankCorrelation", row.rankCorrelation}});
        addAccuracy(row.accuracy, depthList.back());
    }
    const Json report = {{"tool", "altiro3Dtradeoff"},
                         {"version", version()},
                         {"openCv", CV_VERSION},
                         {"threads", cv::getNumThreads()},
                         {"views", kViews},
                         {"against", truth ? "true view" : "most accurate setting"},
                         {"rows", list},
                         {"estimatedDepth", depthList}};
    return jsonText(report, 2) + "\n";
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
    for (const Row& row : rows)
        text += quoted(row.scene) + "," + quoted(row.name) + "," + fixed(row.milliseconds, 4) +
                "," + fixed(row.preparation, 3) + "," + fixed(row.accuracy.psnrWhole, 4) + "," +
                fixed(row.accuracy.ssimWhole, 5) + "," + fixed(row.accuracy.psnrInside, 4) + "," +
                fixed(row.accuracy.ssimInside, 5) + "," + fixed(row.peakMegabytes, 1) + "\n";
    return text;
}

std::string plotOf(const std::vector<Row>& rows) {
    std::vector<TradePoint> points;
    const std::string scene = rows.back().scene; // the mean, or the only scene
    for (const Row& row : rows) {
        if (row.scene != scene || !std::isfinite(row.accuracy.psnrInside)) continue;
        points.push_back({row.name, row.milliseconds, row.accuracy.psnrInside});
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
        if (truth && forTruth.count(option) == 0)
            throw UsageError(name + " does not apply to scenes with a true view; leave it out");
    }
    commandLine.refuseWithout("photo", {"disparity-scale"},
                              " applies to --disparity, expected --photo with it");
}

TradeJob tradeJob(const CommandLine& commandLine) {
    commandLine.exclude("photo", "scenes");
    TradeJob job;
    commandLine.take({{"photo", job.photo},
                      {"disparity", job.disparity},
                      {"truth", job.truth},
                      {"scenes", job.scenes},
                      {"report", job.report},
                      {"csv", job.csv},
                      {"plot", job.plot},
                      {"save-views", job.saveViews},
                      {"y", job.replace}});
    checkOptions(commandLine, job.hasTruth());
    if (job.photo.empty() != job.disparity.empty() || job.photo.empty() != job.truth.empty())
        throw UsageError("--photo, --disparity and --truth belong together; see "
                         "altiro3Dtradeoff --help");
    commandLine.take({{"disparity-scale", job.disparityScale, 1e-6, 1e6}});
    const SceneOptions scene = sceneOptions(commandLine, AutoUse::None);
    if (scene.recipe.choices.any())
        throw UsageError("--strength and --focus: auto is not possible here, expected a number");
    job.views = scene.recipe.views;
    job.refine = scene.recipe.refine;
    job.depth = depthOptions(commandLine);
    job.names = commandLine.files();
    const std::size_t wanted = job.hasTruth() ? 0 : job.depth.fromFiles ? 2 : 1;
    if (job.names.size() != wanted)
        commandLine.failNames(wanted == 0   ? "no names beside --photo or --scenes"
                              : wanted == 2 ? "PHOTO and DEPTH"
                                            : "PHOTO (with -d PHOTO and DEPTH)",
                              wanted);
    if (!job.saveViews.empty() && job.photo.empty())
        throw UsageError("--save-views shows one scene, expected --photo, --disparity and --truth");
    return job;
}

int run(const TradeJob& job, Messages& messages) {
    Outputs outputs(job.replace);
    outputs.addInputs({job.photo, job.disparity, job.truth, job.scenes});
    outputs.addInputs(job.names);
    outputs.addOutputs({job.report, job.csv, job.plot});
    if (!job.saveViews.empty()) {
        outputs.addDirectory(job.saveViews);
        for (const NamedViewOptions& method : defaultSettings())
            outputs.addOutputs({job.saveViews / (method.name + ".png")});
    }
    outputs.check();
    outputs.makeDirectories();

    std::vector<Row> rows;
    std::vector<Row> depths;
    if (job.hasTruth()) {
        std::vector<StereoScene> scenes =
            job.photo.empty() ? readStereoScenes(job.scenes)
                              : std::vector<StereoScene>{
                                    readStereoScene(job.photo.filename().string(), job.photo,
                                                    job.disparity, job.disparityScale, job.truth)};
        const auto sources = depthSources(messages);   // may fail, so before any work
        const std::vector<StereoScene> exact = scenes; // measureScenes() refines their depth
        rows = measureScenes(job, scenes, messages);
        depths = measureDepths(job.refine, exact, sources, messages);
        if (!job.saveViews.empty()) saveViews(scenes.front(), job.saveViews);
    } else {
        rows = measurePhoto(job, messages);
    }
    if (!job.report.empty()) writeFile(job.report, jsonOf(rows, depths, job.hasTruth()));
    if (!job.csv.empty()) writeFile(job.csv, csvOf(rows));
    if (!job.plot.empty()) writeFile(job.plot, plotOf(rows));
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
    commandLine.addAdvanced({"csv"}, "Write all numbers as a table.", "FILE");
    commandLine.add({"plot"}, "Draw accuracy over time, with the best settings marked.",
                    "FILE.svg");
    commandLine.add({"save-views"}, "Write the view of each method with default options.", "DIR");
    commandLine.add({"y"}, "Replace outputs that exist.");
    addDepthOptions(commandLine);
    commandLine.addSection("Views");
    for (const char* field : {"strength", "focus", "exact-depth"})
        addField(commandLine, field);
    commandLine.addNote(
        "Without a true view the most accurate setting is the reference: the numbers "
        "are the differences from it. Times are those of a set of 48 "
        "views, divided by 48; -j 1 measures one thread. \"Inside\" leaves "
        "out the borders that the photo does not show; inf dB means no difference.");
    commandLine.addNote(
        "With a true view a second table compares the sources of estimated depth on this machine: "
        "the time per photo, Spearman's rank correlation with the true disparity, and the accuracy "
        "of method Layered with this depth, scaled and shifted to the true one.");
    commandLine.addExample("holiday.jpg", "Compare the methods on a photo, with estimated depth.");
    commandLine.addExample("--plot trade.svg -d holiday.jpg painted.png",
                           "Compare them with given depth, and draw the result.");
    commandLine.addExample("-j 1 --report trade.json holiday.jpg",
                           "Measure one thread, and write all numbers.");
    return runTool(argc, argv, commandLine, [](const CommandLine& given, Messages& messages) {
        return run(tradeJob(given), messages);
    });
}
