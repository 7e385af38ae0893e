// splat2native: turns scenes of Gaussian splats into Natives.

#include "altiro3D/altiro3D.hpp"
#include "cli/bridge.hpp"
#include "cli/eyes_options.hpp"
#include "cli/folders.hpp"
#include "cli/go_folder.hpp"
#include "cli/inputs.hpp"
#include "cli/json_text.hpp"
#include "cli/outputs.hpp"
#include "cli/page_options.hpp"
#include "cli/print_options.hpp"
#include "cli/quilt_options.hpp"
#include "photo/sway_options.hpp"

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

// Files that are made of a scene; of several scenes, the folders for them. Empty: not requested.
struct SplatOutputs {
    fs::path native;
    fs::path quilt;
    fs::path views; // a folder
    fs::path depth;
    fs::path video;
    fs::path stereo;
    fs::path page;
};
struct OutputKind {
    const char* option;
    fs::path SplatOutputs::*file;
    const char* ending; // of its name in a folder
};
constexpr OutputKind kOutputs[] = {{"save-quilt", &SplatOutputs::quilt, ".png"},
                                   {"save-views", &SplatOutputs::views, "_views"},
                                   {"save-depth", &SplatOutputs::depth, "_depth.png"},
                                   {"lg", &SplatOutputs::video, ".mp4"},
                                   {"save-page", &SplatOutputs::page, ".html"},
                                   {"save-stereo", &SplatOutputs::stereo, ""}}; // by its layout

// The command line.
struct SplatJob {
    std::vector<fs::path> inputs;
    SplatOutputs outputs;
    fs::path report;
    bool replace = false;
    bool skipExisting = false;
    bool recursive = false;
    bool jsonProgress = false;
    bool isSheet = false; // --yaw sheet
    SplatAxes axes = SplatAxes::Auto;
    SplatCameraOptions camera;
    std::optional<double> focus;
    std::optional<double> strength;
    double orbit = 0; // degrees
    EyesFiles eyes;
    PageOptions page;
    SwayOptions sway;
    std::optional<cv::Size> swaySize;
    DisplayOptions display;
    QuiltRequest layout;
    QuiltSampling sampling;
    std::optional<PrintOptions> print;
    std::optional<GoFolder> go;
    std::optional<BridgeJob> bridge;
    bool quiltIsForBridge = false;
};

struct SplatItem : SplatOutputs {
    fs::path scene;
    EyesFiles eyes;
};

// All that the scenes of a run share.
struct SplatRun {
    const SplatJob& job;
    ChosenDisplay display;
    std::optional<PrintSheet> print;
    QuiltLayout layout;
};

std::optional<cv::Vec3d> readPlace(const std::string& text) {
    cv::Vec3d place;
    std::string rest = text;
    for (int i = 0; i < 3; ++i) {
        const std::size_t end = std::min(rest.find(','), rest.size());
        const std::string number = rest.substr(0, end);
        if (number.empty() || number.find_first_not_of("0123456789.eE+-") != std::string::npos)
            return std::nullopt;
        place[i] = numberAt(number);
        if ((end == rest.size()) != (i == 2)) return std::nullopt;
        rest.erase(0, std::min(end + 1, rest.size()));
    }
    return place;
}

void takeCamera(const CommandLine& commandLine, SplatJob& job) {
    constexpr std::pair<const char*, SplatAxes> kAxes[] = {
        {"auto", SplatAxes::Auto}, {"rdf", SplatAxes::Rdf}, {"rub", SplatAxes::Rub}};
    const char* const expected = "three numbers, such as 0,-1.5,2";
    SplatCameraOptions& camera = job.camera;
    job.isSheet = commandLine.value("yaw") == "sheet";
    if (!job.isSheet) commandLine.take({{"yaw", camera.yaw, -360, 360}});
    commandLine.take({{"splat-axes", job.axes, kAxes},
                      {"tilt", camera.tilt, -90, 90},
                      {"camera-position", camera.position, readPlace, expected},
                      {"look-at", camera.lookAt, readPlace, expected},
                      {"up", camera.up, readPlace, expected},
                      {"view-angle", camera.viewDegrees, 1, 150},
                      {"focus", job.focus, 0, 1},
                      {"orbit", job.orbit, 0, 180}});
    if (commandLine.value("strength").value_or("auto") != "auto")
        commandLine.take({{"strength", job.strength, 0, 10000}});
    commandLine.refuseWithout("lg", {"orbit"}, " is a motion of the video of --lg, expected --lg");
}

// Names of scenes and of the output, which may be left out if there are others.
void takeNames(const CommandLine& commandLine, SplatJob& job) {
    const std::vector<fs::path>& names = commandLine.files();
    const bool hasOthers =
        std::any_of(std::begin(kOutputs), std::end(kOutputs),
                    [&](const OutputKind& kind) { return !(job.outputs.*kind.file).empty(); });
    const bool isAlone = job.go || (names.size() == 1 && hasOthers);
    if (names.size() < (isAlone ? 1U : 2U))
        commandLine.failNames(job.go ? "SCENE" : "SCENE and OUT", job.go ? 1 : 2);
    job.inputs.assign(names.begin(), names.end() - (isAlone ? 0 : 1));
    if (!isAlone) job.outputs.native = names.back();
}

SplatJob splatJob(const CommandLine& commandLine) {
    SplatJob job;
    takeCamera(commandLine, job);
    job.print = printOptions(commandLine);
    requireSwayFile(commandLine);
    commandLine.exclude("y", "skip-existing");
    commandLine.take({{"y", job.replace},
                      {"skip-existing", job.skipExisting},
                      {"recursive", job.recursive},
                      {"report", job.report}});
    for (const OutputKind& kind : kOutputs)
        job.outputs.*kind.file = commandLine.value(kind.option).value_or("");
    job.jsonProgress = wantsJsonProgress(commandLine);
    job.eyes = EyesFiles(commandLine);
    job.page = PageOptions(commandLine);
    job.sway = swayOptions(commandLine);
    job.swaySize = swaySizeOption(commandLine);
    job.display = displayOptions(commandLine);
    job.layout = quiltRequest(commandLine);
    job.sampling = pictureSampling(commandLine);
    job.go = GoFolder::of(commandLine);
    if (job.go) {
        for (const OutputKind& kind : kOutputs)
            commandLine.exclude("go", kind.option);
        commandLine.exclude("go",
                            {"skip-existing", "m", "c", "serial", "invert", "q", "r", "print"});
    }
    job.bridge = bridgeJob(commandLine);
    if (job.bridge) {
        job.quiltIsForBridge = job.outputs.quilt.empty();
        if (job.quiltIsForBridge) job.outputs.quilt = cacheDirectory() / "bridge";
    }
    if (job.isSheet) {
        for (const char* const other : {"go", "bridge", "print", "skip-existing"})
            commandLine.exclude("yaw", other);
        for (const OutputKind& kind : kOutputs)
            commandLine.exclude("yaw", kind.option);
    }
    takeNames(commandLine, job);
    return job;
}

// The camera turned by 45 degrees from picture to picture, to choose the front of a thing.
cv::Mat yawSheet(const SplatScene& scene, const SplatRun& run) {
    constexpr int kColumns = 4;
    constexpr int kRows = 2;
    const cv::Size size = run.layout.tileSize;
    cv::Mat sheet(kRows * size.height, kColumns * size.width, CV_8UC3);
    for (int i = 0; i < kColumns * kRows; ++i) {
        SplatCameraOptions options = run.job.camera;
        options.yaw = i * 45;
        const auto camera = chooseSplatCamera(scene, size, run.display.aspect(), options).camera;
        cv::Mat tile =
            sheet(cv::Rect({i % kColumns * size.width, i / kColumns * size.height}, size));
        SplatRenderer(scene, camera).render(0, 1, tile);
        constexpr double kLetter = 1.0 / 600; // of the height
        cv::putText(tile, "--yaw " + std::to_string(i * 45),
                    {size.width / 30, size.height - size.height / 30}, cv::FONT_HERSHEY_SIMPLEX,
                    kLetter * size.height, cv::Scalar::all(255), std::max(1, size.height / 400),
                    cv::LINE_AA);
    }
    return sheet;
}

void writeVideo(const SplatItem& item, const SplatRun& run, const SplatScene& scene,
                const SplatPlacement& placed) {
    const SplatJob& job = run.job;
    const cv::Size size =
        job.swaySize.value_or(swaySize(run.layout.tileSize, run.display.aspect()));
    const double aspect = static_cast<double>(size.width) / size.height;
    const SplatCamera camera = chooseSplatCamera(scene, size, aspect, job.camera).camera;
    const SplatRenderer middle(scene, camera);
    writeSwayFile(item.video, size, job.sway, [&](double position, cv::Mat& picture) {
        if (job.orbit == 0)
            return middle.render(position * placed.baseline, placed.focusDistance, picture);
        const double angle = position * job.orbit / 2 * CV_PI / 180;
        SplatCamera turned = camera; // around the focus, at one distance
        turned.axes = cv::Matx33d(std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0,
                                  std::cos(angle)) *
                      camera.axes;
        const cv::Vec3d toFocus(0, 0, placed.focusDistance);
        turned.eye = camera.eye + camera.axes.t() * toFocus - turned.axes.t() * toFocus;
        SplatRenderer(scene, turned).render(0, placed.focusDistance, picture);
    });
}

// Makes all outputs of a scene, the Native last. @return its entry in the report
Json makeScene(const SplatItem& item, const SplatRun& run, Messages& messages) {
    StageTimes times;
    const SplatJob& job = run.job;
    Notes notes;
    const SplatScene scene = readSplats(item.scene, job.axes, &notes);
    for (const Note& note : notes)
        messages.warn(item.scene.string() + ": " + note.text);
    times.end("read");
    endIfStopWanted();
    const QuiltLayout& layout = run.layout;
    if (job.isSheet) {
        writeImage(item.native, yawSheet(scene, run));
        messages.say(item.native.string() + ": eight views, to choose --yaw");
        return {{"scene", item.scene.string()}, {"sheet", item.native.string()}};
    }
    const auto [camera, how] =
        chooseSplatCamera(scene, layout.tileSize, run.display.aspect(), job.camera);
    const SplatRenderer renderer(scene, camera);
    const SplatView middle = renderer.render();
    const SplatPlacement placed = placeSplats(middle, camera, layout, job.focus, job.strength);
    messages.say(std::to_string(scene.splats.size()) + " splats; camera: " + how + "; focus " +
                 fixed(placed.focus, 2) + ", strength " + fixed(placed.strengthPercent, 1) + " %");
    times.end("camera");

    cv::Mat quilt;
    renderQuilt(renderer, placed, layout, quilt, [](int) {
        endIfStopWanted();
        return true;
    });
    times.end("views");
    if (!item.views.empty())
        writeViews([&](int view) { return item.views / viewFileName(view, layout.viewCount); },
                   quilt, layout);
    if (!item.depth.empty()) writeImage(item.depth, depthTo16Bit(depthOf(middle, placed)));
    if (!item.quilt.empty()) writeImage(item.quilt, quilt);
    if (!item.eyes.files().empty())
        item.eyes.write(eyesOfQuilt(quilt, layout, run.display.aspect()), messages);
    if (!item.page.empty())
        writeFile(item.page, quiltPage(quilt, layout, run.display.aspect(),
                                       job.page.text(item.scene), job.page.side));
    if (!item.video.empty()) writeVideo(item, run, scene, placed);
    times.end("other outputs");
    if (!item.native.empty()) {
        const Quilt2Native native = makeQuilt2Native(job.sampling, run.display, layout, messages);
        // a look-up table alone does not tell the lenses
        const cv::Mat shown =
            run.display.isMapOnly ? quilt : filterForLens(quilt, layout, run.display.calibration);
        makeNativeFile(native, shown, item.native, run.print, messages, times);
    }
    Json entry = {{"scene", item.scene.string()},
                  {"splats", scene.splats.size()},
                  {"camera", how},
                  {"focus", placed.focus},
                  {"strengthPercent", placed.strengthPercent}};
    if (!item.native.empty()) entry["native"] = item.native.string();
    for (const OutputKind& kind : kOutputs) {
        if ((item.*kind.file).empty()) continue;
        entry[kind.option] = (item.*kind.file).string();
        if (!messages.hasSubject()) messages.say((item.*kind.file).string());
    }
    for (const auto& [stage, milliseconds] : times.milliseconds())
        entry["milliseconds"][stage] = milliseconds;
    messages.detail(times.text());
    return entry;
}

std::vector<fs::path> outputsOf(const SplatItem& item, int views) {
    std::vector<fs::path> files = {item.native, item.quilt, item.depth, item.page, item.video};
    for (int i = 0; i < views && !item.views.empty(); ++i)
        files.push_back(item.views / viewFileName(i, views));
    for (const fs::path& file : item.eyes.files())
        files.push_back(file);
    files.erase(std::remove(files.begin(), files.end(), fs::path()), files.end());
    return files;
}

// The scenes of a job with the names of their outputs. @param isBatch outputs are folders
std::vector<SplatItem> planScenes(const SplatRun& run, const std::vector<FolderFile>& scenes,
                                  bool isBatch) {
    const SplatJob& job = run.job;
    const std::vector<std::string> stems = outputStems(scenes);
    std::vector<SplatItem> items;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        SplatItem item{job.outputs, scenes[i].file, job.eyes};
        if (isBatch) {
            if (!item.native.empty()) item.native /= stems[i] + "_native.png";
            for (const OutputKind& kind : kOutputs)
                if (!(item.*kind.file).empty()) item.*kind.file /= stems[i] + kind.ending;
            if (!item.stereo.empty())
                item.eyes = EyesFiles(job.eyes, item.stereo.string() + job.eyes.ending());
        }
        if (job.quiltIsForBridge) item.quilt = quiltForBridge(stems[i]);
        if (job.go)
            item.quilt = job.go->quiltFile(i, stems[i]);
        else if (!item.quilt.empty())
            item.quilt = quiltFileName(item.quilt, run.layout, run.display.aspect());
        items.push_back(item);
    }
    return items;
}

void checkOutputs(const SplatRun& run, const std::vector<SplatItem>& items, bool isBatch) {
    const SplatJob& job = run.job;
    Outputs outputs(job.replace || job.skipExisting);
    outputs.addInputs(run.display.files);
    for (const SplatItem& item : items) {
        outputs.addInputs({item.scene});
        if (job.isSheet) {
            requirePictureName(item.native);
        } else if (!item.native.empty()) {
            requireNativeName(item.native, job.print.has_value());
        }
        for (const fs::path& file : {item.quilt, item.depth})
            if (!file.empty()) requirePictureName(file, file != item.depth);
        if (!item.video.empty()) requireVideoName(item.video);
        requirePageName(item.page);
        if (!item.views.empty()) outputs.addDirectory(item.views);
        for (const fs::path& file : outputsOf(item, run.layout.viewCount)) {
            if (isBatch || job.go || (job.quiltIsForBridge && file == item.quilt))
                outputs.addDirectory(file.parent_path());
            if (file == item.native && !isBatch && !job.isSheet)
                outputs.addNative(file);
            else
                outputs.addOutputs({file});
        }
    }
    outputs.addOutputs({job.report});
    outputs.check();
    outputs.makeDirectories();
}

// Makes the scenes, one after the other. @param entries of the report @return exit status
int makeScenes(const SplatRun& run, const std::vector<SplatItem>& items,
               const std::vector<LeftOutFile>& leftOut, std::vector<fs::path>& quilts,
               Json& entries, Messages& messages) {
    std::vector<FolderItem> files;
    for (const SplatItem& item : items) {
        const std::vector<fs::path> made = outputsOf(item, run.layout.viewCount);
        files.push_back(
            {item.scene, made.front(),
             run.job.skipExisting && std::all_of(made.begin(), made.end(), isFileWithContents)});
    }
    const auto make = [&](std::size_t i) {
        entries.push_back(makeScene(items[i], run, messages));
        if (!items[i].quilt.empty()) quilts.push_back(items[i].quilt);
        return kExitDone;
    };
    const auto ended = [&](std::size_t i, const FolderEnd& end) {
        end.addTo(entries, "scene", files[i]);
    };
    if (items.size() > 1 || !leftOut.empty())
        return FolderRun("scene", leftOut, messages, run.job.jsonProgress)
            .convert(files, make, ended);
    return convertOne(
        "scene", files[0], [&] { make(0); }, [&](const FolderEnd& end) { ended(0, end); }, messages,
        run.job.jsonProgress);
}

int runScenes(const SplatJob& job, Messages& messages) {
    if (job.jsonProgress) messages.leaveStandardOutput();
    SplatRun run{job, job.go ? goDisplay() : findDisplay(job.display, messages), {}, {}};
    run.print = printSheet(job.print, run.display, messages);
    run.layout = chooseQuilt(job.layout, run.display, messages);
    FolderSearch search;
    search.wanted = {FileKind::Splats};
    search.recursive = job.recursive;
    search.pairDepth = false;
    search.outputs = {job.outputs.native};
    std::vector<LeftOutFile> leftOut;
    const std::vector<FolderFile> scenes =
        listNamed(job.inputs, search, leftOut, "no scenes of splats, expected .ply, .splat or .spz",
                  messages);
    bool isBatch = job.inputs.size() > 1 || isDirectory(job.inputs.front());
    if (isBatch && job.isSheet) throw UsageError("--yaw sheet shows one scene, expected one");
    if (isBatch && !job.outputs.native.empty()) requireDirectoryName(job.outputs.native, "scenes");
    isBatch = isBatch && !job.go;
    if (!isBatch && scenes.size() == 1) requireFile(scenes[0].file);
    const std::vector<SplatItem> items = planScenes(run, scenes, isBatch);
    checkOutputs(run, items, isBatch);
    if (job.go) job.go->requireSpace(items.size());
    messages.say("quilt: " + quiltText(run.layout, run.display.aspect()));
    std::vector<fs::path> quilts;
    Json entries = Json::array();
    const auto writeReport = [&](int status) {
        if (job.report.empty()) return;
        const Json report = {{"tool", "splat2native"},
                             {"version", version()},
                             {"state", stateName(status)},
                             {"scenes", entries},
                             {"warnings", messages.warnings()}};
        writeFile(job.report, jsonText(report, 2) + "\n");
    };
    try {
        const int status = makeScenes(run, items, leftOut, quilts, entries, messages);
        if (job.go) job.go->finish(quilts, messages);
        writeReport(status);
        if (job.bridge && status != kExitStopped)
            showOnBridge(*job.bridge, quilts, false, run.display.aspect(), messages);
        return status;
    } catch (...) {
        writeReport(kExitFailed);
        throw;
    }
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine("splat2native",
                            "Turns scenes of Gaussian splats, from a phone's scan or made of a "
                            "photo, into Native pictures for a light-field display.");
    commandLine.addUsage("[options] SCENE OUT.png");
    commandLine.addUsage("[options] SCENE SCENE... | DIR  OUTDIR");
    commandLine.addUsage("--yaw sheet [options] SCENE SHEET.png");
    commandLine.addUsage("--lg OUT.mp4 [options] SCENE");
    commandLine.addUsage("--save-page OUT.html [options] SCENE");
    commandLine.addUsage("--go DIR [options] SCENE... | DIR");
    commandLine.addSection("Camera");
    commandLine.add({"yaw"},
                    "Turn the camera to its right around the scene by DEG degrees; sheet: only "
                    "write one picture of eight turns, to choose the front.",
                    "DEG|sheet");
    commandLine.add({"tilt"}, "Turn the camera upwards around the scene, -90..90 degrees.", "DEG");
    commandLine.add({"view-angle"},
                    "Vertical angle of view in degrees; default: that of the file, else 14 for a "
                    "thing, or what fills the panel for a scene in front of the origin.",
                    "DEG");
    commandLine.addAdvanced({"camera-position"}, "Place of the camera in the scene.", "X,Y,Z");
    commandLine.addAdvanced({"look-at"}, "Place in the middle of the picture.", "X,Y,Z");
    commandLine.addAdvanced({"up"}, "Direction that is up in the picture; default: 0,-1,0.",
                            "X,Y,Z");
    commandLine.addAdvanced({"splat-axes"},
                            "Axes of the file: x right, y down, z forward (rdf), or x right, y up, "
                            "z back (rub); auto: rub for .spz, rdf for all others. Try the other "
                            "one for a scene that is upside down.",
                            "auto|rdf|rub");
    commandLine.addSection("Views");
    commandLine.add({"focus"},
                    "Depth that appears on the panel's surface, 0 (farthest) .. 1 (nearest); "
                    "default: the median of what the middle shows.",
                    "D");
    commandLine.add({"strength"},
                    "Parallax between the outermost views of depth 0 and 1, % of the width; auto, "
                    "the default: the largest without double edges.",
                    "P|auto");
    commandLine.addSection("Output");
    commandLine.add({"save-quilt"}, "Also write the quilt (named ..._qs<columns>x<rows>a<aspect>).",
                    "FILE");
    commandLine.addAdvanced({"save-views"}, "Also write the single views, leftmost camera first.",
                            "DIR");
    commandLine.add({"save-depth"},
                    "Also write the depth of the middle view, 16-bit, near = white.", "FILE.png");
    PageOptions::add(commandLine, "the views, blended; without OUT no Native is made");
    EyesFiles::add(commandLine, "The eyes' pictures are two of the views.", false);
    addSwayFileOption(commandLine, "It shows the scene from the sides, and");
    GoFolder::addOptions(commandLine, "scenes");
    addBridgeOptions(commandLine, "Also show the quilts by");
    addProgressOption(commandLine);
    commandLine.addAdvanced(
        {"report"}, "Write what was chosen and the time of each stage, for programs.", "FILE.json");
    commandLine.add({"y"}, "Replace outputs that exist.");
    commandLine.addAdvanced({"skip-existing"}, "Skip scenes whose outputs all exist.");
    addRecursiveOption(commandLine, "scenes");
    commandLine.addSection("Video of --lg");
    addSwayOptions(commandLine);
    commandLine.add({"orbit"},
                    "Turn the camera around the focus by DEG degrees in all, 0..180; default: it "
                    "moves sideways as on the display.",
                    "DEG");
    addPrintOptions(commandLine);
    addDisplayOptions(commandLine);
    addSamplingOptions(commandLine, "linear");
    commandLine.addNote(
        "SCENE may be .ply (as 3DGS, SHARP, SuperSplat and others write it, also compressed), "
        ".splat or .spz. The camera is that of the file, or of cameras.json beside it; else the "
        "tool chooses a sensible one and prints it. 2 % of what is seen is farther than depth 0, "
        "and 2 % is nearer than depth 1. With several scenes or a directory the last name is the "
        "directory for the outputs, and so are the names of --save-... and --lg.");
    commandLine.addExample("scan.ply native.png", "Make a Native of a scan.");
    commandLine.addExample("--yaw sheet scan.ply sheet.png", "See it from eight sides,");
    commandLine.addExample("--yaw 90 --tilt 10 scan.ply right.png", "and show one of them.");
    commandLine.addExample("--lg scan.mp4 --orbit 60 scan.ply", "Make only a video around it.");
    return runTool(argc, argv, commandLine, [](const CommandLine& given, Messages& messages) {
        return runScenes(splatJob(given), messages);
    });
}
