// splat2native: turns scenes of Gaussian splats into Natives.

#include "altiro3D/altiro3D.hpp"
#include "cli/json_text.hpp"
#include "cli/quilt_options.hpp"
#include "photo/photo_plan.hpp"

#include <locale>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

// The command line.
struct SplatJob : OutputJob {
    bool isSheet = false; // --yaw sheet
    SplatAxes axes = SplatAxes::Auto;
    SplatCameraOptions camera;
    std::optional<double> focus;
    std::optional<double> strength;
    double orbit = 0; // degrees
    QuiltSampling sampling;
};

// All that the scenes of a run share.
struct SplatRun {
    const SplatJob& job;
    ChosenDisplay display;
    std::optional<PrintSheet> print;
    QuiltLayout layout;
};

std::optional<cv::Vec3d> readPlace(const std::string& text) {
    std::istringstream stream(text);
    stream.imbue(std::locale::classic());
    cv::Vec3d place;
    char first = 0;
    char second = 0;
    stream >> place[0] >> first >> place[1] >> second >> place[2];
    if (!stream || !stream.eof() || first != ',' || second != ',') return std::nullopt;
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

SplatJob splatJob(const CommandLine& commandLine) {
    SplatJob job;
    job.things = "scenes";
    job.hasOwnViews = true;
    takeCamera(commandLine, job);
    takeOutputs(commandLine, job);
    commandLine.exclude("go", "print");
    job.sampling = pictureSampling(commandLine);
    if (job.isSheet) {
        for (const char* const other : {"go", "bridge", "print", "skip-existing"})
            commandLine.exclude("yaw", other);
        for (const OutputKind& kind : outputKinds())
            commandLine.exclude("yaw", kind.option);
    }
    // the output may be left out if there are others
    const std::vector<fs::path>& names = commandLine.files();
    const bool isAlone = job.go || (names.size() == 1 && job.hasOthers());
    if (names.size() < (isAlone ? 1U : 2U))
        commandLine.failNames(job.go ? "SCENE" : "SCENE and OUT", job.go ? 1 : 2);
    job.inputs.assign(names.begin(), names.end() - (isAlone ? 0 : 1));
    if (!isAlone) job.outputs.native = names.back();
    if (isStandardStream(job.outputs.native))
        throw UsageError("- stands for standard output, expected the name of a file");
    job.makesNative = !job.isSheet;
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

void writeVideo(const PhotoItem& item, const SplatRun& run, const SplatScene& scene,
                const SplatPlacement& placed) {
    const SplatJob& job = run.job;
    const cv::Size size =
        job.swaySize.empty() ? swaySize(run.layout.tileSize, run.display.aspect()) : job.swaySize;
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
Json makeScene(const PhotoItem& item, const SplatRun& run, Messages& messages) {
    StageTimes times;
    const SplatJob& job = run.job;
    Notes notes;
    const SplatScene scene = readSplats(item.photo, job.axes, &notes);
    for (const Note& note : notes)
        messages.warn(item.photo.string() + ": " + note.text);
    times.end("read");
    endIfStopWanted();
    const QuiltLayout& layout = run.layout;
    if (job.isSheet) {
        writeImage(item.native, yawSheet(scene, run));
        messages.say(item.native.string() + ": eight views, to choose --yaw");
        return {{"scene", item.photo.string()}, {"sheet", item.native.string()}};
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
    if (!item.savedDepth.empty())
        writeImage(item.savedDepth, depthTo16Bit(depthOf(middle, placed)));
    if (!item.quilt.empty()) writeImage(item.quilt, quilt);
    if (!item.eyes.files().empty())
        item.eyes.write(eyesOfQuilt(quilt, layout, run.display.aspect()), messages);
    if (!item.page.empty())
        writeFile(item.page, quiltPage(quilt, layout, run.display.aspect(),
                                       job.page.text(item.photo), job.page.side));
    if (!item.video.empty()) writeVideo(item, run, scene, placed);
    times.end("other outputs");
    if (!item.native.empty()) {
        const Quilt2Native native = makeQuilt2Native(job.sampling, run.display, layout);
        // a look-up table alone does not tell the lenses
        const cv::Mat shown =
            run.display.isMapOnly ? quilt : filterForLens(quilt, layout, run.display.calibration);
        makeNativeFile(native, shown, item.native, run.print, messages, times);
    }
    Json entry = {{"scene", item.photo.string()},
                  {"splats", scene.splats.size()},
                  {"camera", how},
                  {"focus", placed.focus},
                  {"strengthPercent", placed.strengthPercent}};
    if (!item.native.empty()) entry["native"] = item.native.string();
    for (const OutputKind& kind : outputKinds()) {
        if ((item.*kind.file).empty()) continue;
        entry[kind.option] = (item.*kind.file).string();
        if (!messages.hasSubject()) messages.say((item.*kind.file).string());
    }
    for (const auto& [stage, milliseconds] : times.milliseconds())
        entry["milliseconds"][stage] = milliseconds;
    messages.detail(times.text());
    return entry;
}

// Makes the scenes, one after the other. @param entries of the report @return exit status
int makeScenes(const SplatRun& run, const PhotoPlan& plan, std::vector<fs::path>& quilts,
               Json& entries, Messages& messages) {
    const bool isJson = run.job.jsonProgress;
    std::vector<FolderItem> files;
    for (const PhotoItem& item : plan.items)
        files.push_back({item.photo, mainOutput(item), item.isMade});
    const auto make = [&](std::size_t i) {
        entries.push_back(makeScene(plan.items[i], run, messages));
        if (!plan.items[i].quilt.empty()) quilts.push_back(plan.items[i].quilt);
        return kExitDone;
    };
    const auto ended = [&](std::size_t i, const FolderEnd& end) {
        end.addTo(entries, "scene", files[i]);
    };
    if (files.size() > 1 || !plan.leftOut.empty())
        return FolderRun("scene", plan.leftOut, messages, isJson).convert(files, make, ended);
    return convertOne(
        "scene", files[0], [&] { make(0); }, [&](const FolderEnd& end) { ended(0, end); }, messages,
        isJson);
}

int runScenes(const SplatJob& job, Messages& messages) {
    if (job.jsonProgress) messages.leaveStandardOutput();
    SplatRun run{job, job.go ? goDisplay() : findDisplay(job.display, messages), {}, {}};
    run.print = printSheet(job.print, run.display, messages);
    run.layout = chooseQuilt(job.quilt, run.display, messages);
    FolderSearch search;
    search.wanted = {FileKind::Splats};
    search.recursive = job.recursive;
    search.pairDepth = false;
    search.outputs = {job.outputs.native};
    PhotoInputs inputs;
    inputs.files = listNamed(job.inputs, search, inputs.leftOut,
                             "no scenes of splats, expected .ply, .splat or .spz", messages);
    inputs.batch = job.go || job.inputs.size() > 1 || isDirectory(job.inputs.front());
    if (inputs.batch && job.isSheet) throw UsageError("--yaw sheet shows one scene, expected one");
    if (inputs.batch && !job.outputs.native.empty())
        requireDirectoryName(job.outputs.native, job.things);
    PhotoPlan plan = planPhotos(job, run.display, run.layout, inputs);
    checkedOutputs(job, plan, run.display, run.layout.viewCount).makeDirectories();
    if (job.go) job.go->requireSpace(plan.items.size());
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
        const int status = makeScenes(run, plan, quilts, entries, messages);
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
    PageOptions::add(commandLine, "the views, blended", " Without OUT no Native is made.");
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
