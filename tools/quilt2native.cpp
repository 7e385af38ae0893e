// quilt2native: turns a quilt, or a video of quilts, into a Native.

#include "altiro3D/altiro3D.hpp"
#include "common/display_options.hpp"
#include "common/outputs.hpp"
#include "common/photo_folder.hpp"
#include "common/picture_options.hpp"
#include "common/run_tool.hpp"
#include "common/sway_options.hpp"
#include "common/video_options.hpp"
#include "common/video_progress.hpp"
#include "common/video_run.hpp"

#include <chrono>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

// The settings of a run, determined before it reads the quilt.
struct Job {
    const CommandLine& commandLine;
    fs::path quilt;
    fs::path native;
    std::optional<FitMode> fit;
    fs::path swayFile; // empty: none
    SwayOptions sway;
    std::optional<cv::Size> swaySize;
    ViewFilter between;
    bool isFromFolder = false; // not named itself: left out if it is no quilt
};

bool isVideo(const fs::path& file) {
    if (canWriteImage(file)) return false; // by its name
    try {
        const VideoFacts facts = VideoReader(file).facts();
        return !isPicture(file, facts) && facts.format != "gif";
    } catch (const Error&) {
        return false; // reading it as a picture reports the error
    }
}

// False if a picture of a folder is not a quilt.
bool convertPicture(const Job& job, const ChosenDisplay& display, Messages& messages) {
    StageTimes times;
    refuseNative(job.quilt, "a quilt");
    const cv::Mat picture = readPhotoFile(job.quilt, messages);
    times.end("read");
    std::optional<FoundQuilt> found;
    if (!isLayoutStated(job.commandLine, job.quilt)) found = findQuiltLayout(picture);
    if (job.isFromFolder && found && found->verdict == QuiltVerdict::NoQuilt) return false;
    const QuiltLayout layout =
        chooseQuilt(job.commandLine, display, messages, job.quilt, picture.size(), found);
    const QuiltShape shape(job.quilt, layout, display, job.fit);
    messages.say("quilt: " + quiltText(layout, shape.shownAspect()) +
                 (found ? foundText(*found) : ""));
    Notes notes;
    const cv::Mat tiles = display.map ? cropQuilt(picture, layout, &notes) : picture;
    messages.warn(notes);
    const cv::Mat quilt = shape.apply(tiles);
    tellShape(shape, messages);
    const Quilt2Native renderer = makeQuilt2Native(job.commandLine, display, layout, messages);
    times.end("look-up table");
    cv::Size swaySize;
    if (!job.swayFile.empty()) {
        swaySize = writeQuiltSwayFile(job.swayFile, fitQuilt(picture, layout), layout,
                                      shape.shownAspect(), job.swaySize,
                                      job.fit.value_or(FitMode::Cover), job.between, job.sway);
        times.end("video");
    }
    // last, so that an existing Native means that all outputs exist
    makeNativeFile(renderer, quilt, job.native, messages, times);
    if (!job.swayFile.empty())
        messages.say(job.swayFile.string() + ": video, " + swayText(job.sway, swaySize));
    messages.detail(times.text());
    return true;
}

// Converts the quilts of a folder; one that cannot be converted does not stop the rest. Exit
// status.
int convertFolder(const CommandLine& commandLine, Messages& messages) {
    const auto start = std::chrono::steady_clock::now();
    const fs::path& folder = commandLine.files()[0];
    const fs::path& outputFolder = commandLine.files()[1];
    std::error_code error;
    if (commandLine.has("lg")) {
        throw UsageError("--lg makes one video, expected a single quilt instead of a folder");
    }
    FolderSearch search;
    search.pairDepth = false;
    search.outputs = {outputFolder};
    std::vector<fs::path> quilts;
    std::vector<LeftOutFile> leftOut;
    const PhotoFolder found = searchFolder(folder, search);
    for (const FolderPhoto& picture : found.photos)
        quilts.push_back(picture.photo);
    for (const LeftOutFile& file : found.leftOut) {
        if (file.kind == "quilt") {
            quilts.push_back(file.file);
            continue;
        }
        leftOut.push_back(file);
        messages.say(file.file.string() + ": " +
                     (file.kind == "folder" ? "is a folder, which is not searched" : file.why));
    }
    if (quilts.empty()) {
        throw Error(ErrorCode::NotFound, folder.string(), "holds no pictures, expected quilts");
    }
    if (!fs::is_directory(outputFolder, error) &&
        (fs::exists(outputFolder, error) || canWriteImage(outputFolder))) {
        throw UsageError(outputFolder.string() + ": names one file, expected a directory for the "
                                                 "Natives of several quilts");
    }
    const ChosenDisplay display = findDisplay(commandLine, messages);
    const bool skip = commandLine.has("skip-existing");
    Outputs outputs(commandLine.has("y") || skip);
    for (const fs::path& file : display.files)
        outputs.addInput(file);
    std::vector<fs::path> natives;
    for (const fs::path& quilt : quilts) {
        natives.push_back(outputFolder / (quilt.stem().string() + "_native.png"));
        outputs.addInput(quilt);
        outputs.addOutput(natives.back());
    }
    outputs.addDirectory(outputFolder);
    outputs.check();
    outputs.makeDirectories();
    std::size_t made = 0;
    std::size_t skipped = 0;
    bool failed = false;
    for (std::size_t i = 0; i < quilts.size(); ++i) {
        if (skip && fs::is_regular_file(natives[i], error)) {
            ++skipped;
            continue;
        }
        messages.setSubject(quilts[i].filename().string());
        try {
            const Job job{commandLine, quilts[i], natives[i], fitOption(commandLine),
                          {},          {},        {},         ViewFilter::Nearest,
                          true};
            if (convertPicture(job, display, messages)) {
                ++made;
            } else {
                messages.say("is a photo or another picture of one view; photo2native makes "
                             "Natives of photos");
                leftOut.push_back({quilts[i], "photo", {}});
            }
            messages.flushWarnings();
        } catch (const std::exception& problem) {
            messages.dropWarnings();
            messages.fail(sentenceOf(problem));
            failed = true;
        }
    }
    messages.setSubject({});
    std::string text = counted(made, "quilt") + " made";
    if (skipped > 0) text += ", " + std::to_string(skipped) + " skipped as the outputs exist";
    if (!leftOut.empty())
        text += ", " + std::to_string(leftOut.size()) + " left out (" + kindsText(leftOut) + ")";
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    messages.say(text + ", in " + fixed(time.count(), 1) + " s");
    return failed ? kExitFailed : kExitDone;
}

// Returns the exit status.
int convertVideo(const CommandLine& commandLine, Messages& messages) {
    VideoPlan plan;
    plan.input = commandLine.files()[0];
    plan.output = commandLine.files()[1];
    plan.fromQuilt = true;
    plan.report = commandLine.value("report").value_or("");
    std::error_code error;
    plan.isFile = fs::is_regular_file(plan.input, error);
    return runVideo(commandLine, plan, messages);
}

// Whether a picture is a quilt: its name says so, or its views are found in it, or it fills the
// quilt that options or display tell.
bool isQuilt(const CommandLine& commandLine, Messages& messages) {
    const fs::path& file = commandLine.files()[0];
    std::error_code error;
    if (!fs::is_regular_file(file, error)) return false;
    refuseNative(file, "a photo or a quilt");
    if (parseQuiltName(file) || isVideo(file)) return true;
    const ChosenDisplay display = findDisplay(commandLine, messages);
    const QuiltLayout layout = chooseQuilt(commandLine, display, messages, file, std::nullopt);
    const cv::Mat picture = readPhotoFile(file, messages);
    if (!isLayoutStated(commandLine, file)) {
        const FoundQuilt found = findQuiltLayout(picture);
        if (found.verdict != QuiltVerdict::Unsure) return found.verdict == QuiltVerdict::Quilt;
    }
    const cv::Size size = picture.size();
    return cv::Size(size.width / layout.columns, size.height / layout.rows) == layout.tileSize;
}

int run(const CommandLine& commandLine, Messages& messages) {
    if (commandLine.files().size() != 2) commandLine.failNames("QUILT and OUT", 2);
    if (commandLine.has("tell-kind")) {
        messages.leaveStandardOutput();
        messages.print(isQuilt(commandLine, messages) ? "quilt" : "photo");
        messages.dropWarnings(); // the following run shows them
        return kExitDone;
    }
    std::error_code error;
    if (fs::is_directory(commandLine.files()[0], error))
        return convertFolder(commandLine, messages);
    commandLine.exclude("y", "skip-existing");
    requireSwayFile(commandLine);
    const auto between = commandLine.choice("view-filter", {"nearest", "linear"});
    const Job job{commandLine,
                  commandLine.files()[0],
                  commandLine.files()[1],
                  fitOption(commandLine),
                  commandLine.value("lg").value_or(""),
                  swayOptions(commandLine),
                  swaySizeOption(commandLine),
                  between.value_or(0) == 1 ? ViewFilter::Linear : ViewFilter::Nearest};
    if (canWriteVideo(job.native)) {
        if (!job.swayFile.empty()) {
            throw UsageError(job.native.string() +
                             ": is a video's name, expected a picture's with --lg, such as .png");
        }
        return convertVideo(commandLine, messages);
    }
    if (isVideo(job.quilt)) {
        throw UsageError(job.native.string() + ": is not the name of a video, but " +
                         job.quilt.string() + " is a video; expected .mp4, .mov or .mkv");
    }
    for (const char* option : {"codec", "crf", "preset", "compat", "no-audio", "no-subtitles",
                               "resume", "progress", "report"}) {
        if (commandLine.has(option)) {
            throw UsageError("--" + std::string(option) +
                             " applies to videos, expected a "
                             "video as output");
        }
    }
    requirePictureName(job.native);
    if (!job.swayFile.empty()) requireVideoName(job.swayFile);
    requireFile(job.quilt);
    const ChosenDisplay display = findDisplay(commandLine, messages);
    Outputs outputs(commandLine.has("y"));
    outputs.addInput(job.quilt);
    for (const fs::path& file : display.files)
        outputs.addInput(file);
    outputs.addNative(job.native);
    if (!job.swayFile.empty()) outputs.addOutput(job.swayFile);
    outputs.check();
    convertPicture(job, display, messages);
    return kExitDone;
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine("quilt2native", "Turns a quilt, the collage of all views, into the "
                                            "Native picture for a display; or a video of quilts "
                                            "into a Native video with its sound.");
    commandLine.addUsage("[options] QUILT OUT.png");
    commandLine.addUsage("[options] QUILTVIDEO OUT.mp4");
    commandLine.addUsage("[options] DIR OUTDIR");
    commandLine.addSection("Output");
    addSwayFileOption(commandLine, "It shows them in the shape that they have in the Native and");
    commandLine.add({"y"}, "Replace outputs that exist.");
    commandLine.addAdvanced({"skip-existing"}, "With a folder: skip quilts whose Native exists.");
    commandLine.addSection("Video of --lg");
    addSwayOptions(commandLine);
    commandLine.addSection("Videos");
    addEncoderOptions(commandLine);
    commandLine.add({"resume"}, "Continue an interrupted run of the same command.");
    VideoProgressLine::add(commandLine);
    commandLine.addAdvanced({"report"},
                            "Write settings, counts and the time of each stage, for programs.",
                            "FILE.json");
    addDisplayOptions(commandLine);
    addFitOption(commandLine, "contain if the file's name states another shape, else stretch");
    addSamplingOptions(commandLine);
    commandLine.addHidden("tell-kind"); // for altiro3Dimage
    commandLine.addNote(
        "A file name that ends in _qs<columns>x<rows>a<aspect>, such as "
        "photo_qs8x6a0.75.png, states the layout, and so does -q; otherwise it is found in the "
        "picture. A Native video is "
        "H.264 4:4:4 in .mp4, .mov or .mkv, which keeps the colour of every "
        "sub-pixel; sound, subtitles, chapters and tags are copied.");
    commandLine.addTerm(CommandLine::Chapter::Examples, "holiday_qs8x6a0.75.png native.png",
                        "Make a Native of a quilt whose name states its layout.");
    commandLine.addTerm(CommandLine::Chapter::Examples, "-q 6x8 quilt.png native-q.png",
                        "Read the quilt as 6 rows of 8 views.");
    commandLine.addTerm(CommandLine::Chapter::Examples,
                        "--lg swing.mp4 holiday_qs8x6a0.75.png native-lg.png",
                        "Also write a video of the views for any screen.");
    return runTool(argc, argv, commandLine, run);
}
