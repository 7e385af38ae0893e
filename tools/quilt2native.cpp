// quilt2native: turns a quilt, or a video of quilts, into a Native.

#include "altiro3D/altiro3D.hpp"
#include "cli/bridge.hpp"
#include "cli/eyes_options.hpp"
#include "cli/folders.hpp"
#include "cli/go_folder.hpp"
#include "cli/inputs.hpp"
#include "cli/json_text.hpp"
#include "cli/page_options.hpp"
#include "cli/print_options.hpp"
#include "photo/sway_options.hpp"
#include "video/video_run.hpp"

#include <opencv2/imgproc.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

// The command line.
struct QuiltJob {
    std::vector<fs::path> names; // with --go or --bridge: quilts and folders of quilts
    fs::path quilt;              // or a folder of quilts
    fs::path native;             // empty: not made
    bool replace = false;
    bool skipExisting = false;
    bool recursive = false;
    DisplayOptions display;
    QuiltRequest layout;
    QuiltSampling sampling;
    std::optional<FitMode> fit;
    fs::path swayFile; // empty: none
    SwayOptions sway;
    std::optional<cv::Size> swaySize;
    EyesFiles eyes;
    fs::path pageFile; // of a folder of quilts: the folder of their pages; empty: none
    PageOptions page;
    std::optional<PrintOptions> print;
    VideoJob video;
    std::optional<GoFolder> go;
    std::optional<BridgeJob> bridge;
    bool isFolder = false;
    bool makesVideo = false;
    bool tellsKind = false; // and does nothing else
};

StereoPair eyesOf(const cv::Mat& quilt, const QuiltLayout& layout, double aspect,
                  Messages& messages) {
    if (layout.viewCount < 2)
        throw UsageError("--save-stereo needs two views, but the quilt has one");
    const auto [left, right] = viewsOfEyes(layout);
    messages.say("eyes: views " + std::to_string(left) + " and " + std::to_string(right));
    return eyesOfQuilt(quilt, layout, aspect);
}

bool isVideo(const fs::path& file) {
    if (canWriteImage(file) || !isFile(file)) return false; // a picture by its name, or a pipe
    try {
        const VideoFacts facts = VideoReader(file).facts();
        return !isPicture(file, facts) && facts.format != "gif";
    } catch (const Error&) {
        return false; // reading it as a picture reports the error
    }
}

// A quilt that was read, and its shape.
struct ReadQuilt {
    cv::Mat picture;
    QuiltLayout layout;
    QuiltShape shape;
};

// @param isFromFolder not named itself @throws NotTaken if such a picture is not a quilt
ReadQuilt readQuilt(const QuiltJob& job, const fs::path& quiltFile, bool isFromFolder,
                    const ChosenDisplay& display, Messages& messages) {
    const PhotoFile file = pictureToRead(quiltFile);
    refuseNative(file, "a quilt");
    const cv::Mat picture = readPhotoFile(file, messages);
    std::optional<FoundQuilt> found;
    if (!isLayoutStated(job.layout, quiltFile)) found = findQuiltLayout(picture);
    if (isFromFolder && found && found->verdict == QuiltVerdict::NoQuilt)
        throw NotTaken{{quiltFile, FileKind::Photo,
                        "is a photo or another picture of one view; photo2native makes Natives of "
                        "photos"}};
    const QuiltLayout layout =
        chooseQuilt(job.layout, display, messages, quiltFile, picture.size(), found);
    for (const Note& note : checkQuiltLayout(picture, layout)) {
        const bool isAsked = job.layout.grid && note.code == NoteCode::Doubtful; // -q says so
        if (!isAsked) messages.warn(quiltFile.string() + ": " + note.text);
    }
    const QuiltShape shape(quiltFile, layout, display, job.fit);
    messages.say("quilt: " + quiltText(layout, shape.shownAspect()) +
                 (found ? foundText(*found) : ""));
    return {picture, layout, shape};
}

// Gives the views of a quilt the shape in which the panel shows them.
// @param isCut cut the quilt to views of whole px first, as a map needs it
cv::Mat shapedQuilt(const ReadQuilt& read, bool isCut, Messages& messages) {
    Notes notes;
    const cv::Mat tiles = isCut ? cropQuilt(read.picture, read.layout, &notes) : read.picture;
    messages.warn(notes);
    tellShape(read.shape, messages);
    return read.shape.apply(tiles);
}

// @param native, page files to write; empty: not made
void convertPicture(const QuiltJob& job, const fs::path& quiltFile, const fs::path& native,
                    const fs::path& page, bool isFromFolder, const ChosenDisplay& display,
                    Messages& messages, const std::optional<PrintSheet>& print = std::nullopt) {
    StageTimes times;
    const ReadQuilt read = readQuilt(job, quiltFile, isFromFolder, display, messages);
    const auto& [picture, layout, shape] = read;
    times.end("read");
    cv::Size swaySize;
    if (!page.empty()) {
        writePage(page,
                  quiltPage(fitQuilt(picture, layout), layout, shape.shownAspect(),
                            job.page.text(quiltFile), job.page.side),
                  messages);
        times.end("page");
    }
    if (!job.swayFile.empty()) {
        swaySize = writeQuiltSwayFile(
            job.swayFile, fitQuilt(picture, layout), layout, shape.shownAspect(), job.swaySize,
            job.fit.value_or(FitMode::Cover), job.sampling.views, job.sway);
        times.end("video");
    }
    if (!job.eyes.files().empty()) {
        job.eyes.write(eyesOf(fitQuilt(picture, layout), layout, shape.shownAspect(), messages),
                       messages);
        times.end("eyes");
    }
    if (!native.empty()) {
        const cv::Mat quilt = shapedQuilt(read, display.map.has_value(), messages);
        const Quilt2Native renderer = makeQuilt2Native(job.sampling, display, layout);
        times.end("look-up table");
        // last, so that an existing Native means that all outputs exist
        makeNativeFile(renderer, quilt, native, print, messages, times);
    }
    if (!job.eyes.name().empty()) messages.say(job.eyes.names() + ": " + job.eyes.words());
    if (!job.swayFile.empty())
        messages.say(job.swayFile.string() + ": video, " + swayText(job.sway, swaySize));
    messages.detail(times.text());
}

// The extension of a Native. .mkv holds more kinds of subtitles than .mp4, so it is kept.
std::string endingOf(const fs::path& quilt) {
    if (!isVideoFileName(quilt)) return ".png";
    return lowerExtension(quilt) == ".mkv" ? ".mkv" : ".mp4";
}

// Converts the quilts of a folder; one that cannot be converted does not stop the rest. Exit
// status.
int convertFolder(const QuiltJob& job, Messages& messages) {
    const fs::path& outputFolder = job.native;
    FolderSearch search;
    // a quilt need not be named as one
    search.wanted = {FileKind::Photo, FileKind::Quilt, FileKind::QuiltVideo};
    search.recursive = job.recursive;
    search.pairDepth = false;
    if (outputFolder.empty()) search.wanted = {FileKind::Photo, FileKind::Quilt};
    for (const fs::path& output : {outputFolder, job.pageFile})
        if (!output.empty()) search.outputs.push_back(output);
    std::vector<LeftOutFile> leftOut;
    const std::vector<FolderFile> quilts =
        listNamed({job.quilt}, search, leftOut, "no pictures, expected quilts", messages);
    if (!outputFolder.empty()) requireDirectoryName(outputFolder, "quilts");
    VideoRun videos(job.video, messages);
    const ChosenDisplay& display = videos.display;
    Outputs outputs(job.replace || job.skipExisting);
    outputs.addInputs(display.files);
    std::vector<FolderItem> files;
    std::vector<fs::path> pages;
    const std::vector<std::string> stems = outputStems(quilts);
    for (std::size_t i = 0; i < quilts.size(); ++i) {
        const fs::path& quilt = quilts[i].file;
        const bool hasPage = !job.pageFile.empty() && !isVideoFileName(quilt);
        pages.push_back(hasPage ? job.pageFile / (stems[i] + ".html") : fs::path());
        FolderItem item{quilt, pages[i], job.skipExisting};
        if (hasPage) outputs.addPair(quilt, pages[i]);
        if (hasPage && !isFileWithContents(pages[i])) item.isMade = false;
        if (!outputFolder.empty()) {
            item.output = outputFolder / (stems[i] + "_native" + endingOf(quilt));
            outputs.addPair(quilt, item.output);
            item.isMade = item.isMade && isFileWithContents(item.output);
        }
        files.push_back(item);
    }
    outputs.check();
    outputs.makeDirectories();
    FolderRun run("quilt", leftOut, messages);
    const auto convert = [&](std::size_t i) {
        const auto& [quilt, native, isMade] = files[i];
        if (!isVideoFileName(quilt)) {
            convertPicture(job, quilt, outputFolder.empty() ? fs::path() : native, pages[i], true,
                           display, messages);
            return kExitDone;
        }
        return makeVideo(videos, files[i], run.place() + " ", nullptr, messages);
    };
    return run.convert(files, convert, [](std::size_t, const FolderEnd&) {});
}

// Whether a picture is a quilt: its name says so, or its views are found in it, or it fills the
// quilt that options or display tell.
bool isQuilt(const QuiltJob& job, Messages& messages) {
    const fs::path& file = job.quilt;
    if (!isFile(file)) return false;
    refuseNative(file, "a photo or a quilt");
    if (parseQuiltName(file) || isVideo(file)) return true;
    const ChosenDisplay display = findDisplay(job.display, messages);
    const QuiltLayout layout = chooseQuilt(job.layout, display, messages, file, std::nullopt);
    const cv::Mat picture = readPhotoFile(file, messages);
    FoundQuilt found;
    found.verdict = QuiltVerdict::Unsure;
    if (!isLayoutStated(job.layout, file)) found = findQuiltLayout(picture);
    return isQuiltPicture(found, picture.size(), layout);
}

// Lays a quilt out anew, with other columns, rows and size of views. If the number of views
// differs, each new view is the nearest old one.
cv::Mat laidOut(const cv::Mat& quilt, const QuiltLayout& from, const QuiltLayout& to) {
    if (from == to) return quilt;
    cv::Mat result(to.size(), CV_8UC3, cv::Scalar::all(0));
    for (int i = 0; i < to.viewCount; ++i) {
        const double place = to.viewCount > 1 ? double(i) / (to.viewCount - 1) : 0.5;
        const cv::Mat view = quilt(from.tile(cvRound(place * (from.viewCount - 1))));
        const bool shrinks = view.cols > to.tileSize.width;
        cv::resize(view, result(to.tile(i)), to.tileSize, 0, 0,
                   shrinks ? cv::INTER_AREA : cv::INTER_CUBIC);
    }
    return result;
}

// The quilts that are named, and those of the folders among the names.
std::vector<FolderFile> listQuilts(const QuiltJob& job, std::vector<LeftOutFile>& leftOut,
                                   Messages& messages) {
    FolderSearch search;
    search.wanted = {FileKind::Photo, FileKind::Quilt};
    search.recursive = job.recursive;
    search.pairDepth = false;
    return listNamed(job.names, search, leftOut, "no pictures, expected quilts", messages);
}

// Shows quilts where they lie. Exit status.
int showQuilts(const QuiltJob& job, Messages& messages) {
    const ChosenDisplay display = findDisplay(job.display, messages, {}, DisplayUse::Quilt);
    std::vector<LeftOutFile> leftOut;
    std::vector<BridgeEntry> entries;
    for (const FolderFile& quilt : listQuilts(job, leftOut, messages)) {
        requireFile(quilt.file);
        if (parseQuiltName(quilt.file)) {
            entries.push_back(bridgeEntry(quilt.file, display.aspect()));
        } else {
            const ReadQuilt read = readQuilt(job, quilt.file, false, display, messages);
            entries.emplace_back();
            entries.back().file = quilt.file;
            entries.back().grid = {read.layout.columns, read.layout.rows};
            entries.back().aspect = read.shape.shownAspect();
        }
        if (!isVideoFileName(quilt.file)) entries.back().seconds = job.bridge->seconds;
    }
    showOnBridge(*job.bridge, entries, messages);
    return kExitDone;
}

// Writes quilts to the storage of a Go. Exit status.
int fillGo(const QuiltJob& job, Messages& messages) {
    const GoFolder& go = *job.go;
    std::vector<LeftOutFile> leftOut;
    const std::vector<FolderFile> quilts = listQuilts(job, leftOut, messages);
    go.requireSpace(quilts.size());
    const ChosenDisplay display = goDisplay();
    const std::vector<std::string> stems = outputStems(quilts);
    Outputs outputs(false);
    std::vector<FolderItem> files;
    for (std::size_t i = 0; i < quilts.size(); ++i) {
        files.push_back({quilts[i].file, go.quiltFile(i, stems[i])});
        outputs.addPair(files[i].input, files[i].output);
    }
    outputs.check();
    outputs.makeDirectories();
    std::vector<fs::path> made;
    FolderRun run("quilt", leftOut, messages);
    const auto convert = [&](std::size_t i) {
        const bool isNamed =
            std::find(job.names.begin(), job.names.end(), files[i].input) != job.names.end();
        const ReadQuilt read = readQuilt(job, files[i].input, !isNamed, display, messages);
        const int views = read.layout.viewCount;
        if (views != display.quilt.viewCount)
            messages.say("its " + counted(views, "view") + " become the " +
                         std::to_string(display.quilt.viewCount) + " of a Go");
        writeImage(files[i].output,
                   laidOut(shapedQuilt(read, false, messages), read.layout, display.quilt));
        made.push_back(files[i].output);
        return kExitDone;
    };
    const int status = run.convert(files, convert, [](std::size_t, const FolderEnd&) {});
    go.finish(made, messages);
    return status;
}

// What is wanted of all quilts.
void takeCommon(const CommandLine& commandLine, QuiltJob& job) {
    commandLine.take({{"recursive", job.recursive}});
    job.display = displayOptions(commandLine);
    job.layout = quiltRequest(commandLine);
    job.fit = fitOption(commandLine);
}

// The job of --go or --bridge.
void takeShow(const CommandLine& commandLine, QuiltJob& job) {
    const char* const show = job.go ? "go" : "bridge";
    commandLine.exclude(show,
                        {"y", "skip-existing", "lg", "save-stereo", "save-page", "m", "invert"});
    commandLine.exclude(
        show, {"view-filter", "sampling", "codec", "resume", "report", "progress", "print"});
    job.names = commandLine.files();
    if (job.names.empty()) commandLine.failNames("QUILT", 1);
    takeCommon(commandLine, job);
    if (job.go) commandLine.exclude("go", {"c", "serial"});
}

// Refuses names and options that do not go together, and takes the options of videos.
void takeKind(const CommandLine& commandLine, QuiltJob& job) {
    const bool isStream = isStandardStream(job.native);
    requireNoTerminal(job.native);
    job.isFolder = !isStandardStream(job.quilt) && isDirectory(job.quilt);
    if (job.isFolder && isStream)
        throw UsageError("- stands for one picture, expected a directory for several");
    if (job.isFolder && !job.swayFile.empty())
        throw UsageError("--lg makes one video, expected a single quilt instead of a folder");
    if (!job.isFolder) requirePageName(job.pageFile);
    if (job.isFolder || canWriteVideo(job.native))
        commandLine.refuse({"save-stereo", "print"},
                           " is made of one quilt, expected a single picture");
    if (!job.isFolder)
        commandLine.refuse({"skip-existing", "recursive"},
                           " applies to folders, expected a directory of quilts");
    job.makesVideo = !job.isFolder && canWriteVideo(job.native);
    if (job.makesVideo && !job.swayFile.empty())
        throw UsageError(job.native.string() +
                         ": is a video's name, expected a picture's with --lg, such as .png");
    if (!job.pageFile.empty() && !job.isFolder && (job.makesVideo || isVideo(job.quilt)))
        throw UsageError("--save-page shows one picture, expected a quilt instead of a video");
    if (job.native.empty())
        commandLine.refuse({"print"}, " makes a print, expected OUT, the name of its file");
    if (!job.isFolder && !job.makesVideo && isVideo(job.quilt))
        throw UsageError(job.native.string() + ": is not the name of a video, but " +
                         job.quilt.string() + " is a video; expected .mp4, .mov or .mkv");
    if (!job.makesVideo)
        commandLine.refuse({"codec", "crf", "preset", "max-rate", "compat", "no-audio",
                            "no-subtitles", "resume", "progress", "report"},
                           " applies to videos, expected a video as output");
    job.video.input = job.quilt;
    job.video.output = job.native;
    job.video.fromQuilt = true;
    job.video.canReadAgain = isFile(job.quilt);
    commandLine.take({{"report", job.video.report}});
    job.video = videoJob(commandLine, job.video);
    if (job.isFolder || job.makesVideo) return;
    if (!job.native.empty() && (job.print || !isStream))
        requireNativeName(job.native, job.print.has_value());
    if (!job.swayFile.empty()) requireVideoName(job.swayFile);
    if (!job.eyes.files().empty()) requirePictureName(job.eyes.name());
    if (!isStandardStream(job.quilt)) requireFile(job.quilt);
}

QuiltJob quiltJob(const CommandLine& commandLine) {
    QuiltJob job;
    job.go = GoFolder::of(commandLine);
    job.bridge = bridgeJob(commandLine);
    if (job.go || job.bridge) {
        takeShow(commandLine, job);
        return job;
    }
    job.page = PageOptions(commandLine);
    job.pageFile = commandLine.value("save-page").value_or("");
    if (!job.pageFile.empty() && commandLine.files().size() == 1)
        job.quilt = commandLine.files().front();
    else
        commandLine.takeNames("QUILT and OUT", {&job.quilt, &job.native});
    commandLine.exclude("y", "skip-existing");
    requireSwayFile(commandLine);
    commandLine.take({{"y", job.replace},
                      {"skip-existing", job.skipExisting},
                      {"lg", job.swayFile},
                      {"tell-kind", job.tellsKind}});
    takeCommon(commandLine, job);
    job.sampling = pictureSampling(commandLine);
    job.sway = swayOptions(commandLine);
    job.swaySize = swaySizeOption(commandLine);
    job.eyes = EyesFiles(commandLine);
    job.print = printOptions(commandLine);
    if (!job.tellsKind) takeKind(commandLine, job);
    return job;
}

int run(const QuiltJob& job, Messages& messages) {
    if (job.bridge) return showQuilts(job, messages);
    if (job.go) return fillGo(job, messages);
    if (job.tellsKind) {
        messages.leaveStandardOutput();
        messages.print(isQuilt(job, messages) ? "quilt" : "photo");
        messages.dropWarnings(); // the following run shows them
        return kExitDone;
    }
    if (isStandardStream(job.native)) messages.useStandardError();
    if (job.isFolder) return convertFolder(job, messages);
    if (job.makesVideo) return runVideo(job.video, messages);
    ChosenDisplay display = findDisplay(job.display, messages);
    const std::optional<PrintSheet> print = printSheet(job.print, display, messages);
    Outputs outputs(job.replace);
    outputs.addInputs({job.quilt});
    outputs.addInputs(display.files);
    if (!job.native.empty()) outputs.addNative(job.native);
    outputs.addOutputs({job.pageFile, job.swayFile});
    outputs.addOutputs(job.eyes.files());
    outputs.check();
    convertPicture(job, job.quilt, job.native, job.pageFile, false, display, messages, print);
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
    commandLine.addUsage("--save-page OUT.html [options] QUILT");
    commandLine.addUsage("--go DIR [options] QUILT... | DIR");
    commandLine.addUsage("--bridge auto [options] QUILT... | DIR");
    commandLine.addSection("Output");
    addSwayFileOption(commandLine, "It shows them in the shape that they have in the Native and");
    EyesFiles::add(commandLine, "The eyes' pictures are two of the views.", false);
    PageOptions::add(commandLine, "the views, blended",
                     " For a folder, FILE is a folder of pages. Without OUT no Native is made.");
    GoFolder::addOptions(commandLine, "quilts");
    addBridgeOptions(commandLine, "Instead of Natives: show the quilts, also videos, by");
    commandLine.add({"y"}, "Replace outputs that exist.");
    commandLine.addAdvanced({"skip-existing"}, "With a folder: skip quilts whose Native exists.");
    addRecursiveOption(commandLine, "quilts");
    commandLine.addSection("Video of --lg");
    addSwayOptions(commandLine);
    commandLine.addSection("Videos");
    addEncoderOptions(commandLine);
    commandLine.add({"resume"}, "Continue an interrupted run of the same command.");
    addProgressOption(commandLine);
    commandLine.addAdvanced({"report"},
                            "Write settings, counts and the time of each stage, for programs.",
                            "FILE.json");
    addPrintOptions(commandLine);
    addDisplayOptions(commandLine);
    addFitOption(commandLine, "contain if the file's name states another shape, else stretch");
    addSamplingOptions(commandLine, "linear");
    commandLine.addHidden("tell-kind"); // for altiro3Dimage
    commandLine.addNote(
        "A file name that ends in _qs<columns>x<rows>a<aspect>, such as "
        "photo_qs8x6a0.75.png, states the layout, and so does -q; otherwise it is found in the "
        "picture. A Native video is "
        "H.264 4:4:4 in .mp4, .mov or .mkv, which keeps the colour of every "
        "sub-pixel; sound, subtitles, chapters and tags are copied.");
    commandLine.addNote(
        "In a directory, only quilts are converted, and videos of quilts whose names state the "
        "layout; one bad quilt does not stop the rest. Photos, Natives, other videos and other "
        "files are named, counted and left out.");
    commandLine.addNote(
        "QUILT may be - for a picture on standard input, and OUT.png - for standard "
        "output; messages then go to standard error.");
    commandLine.addNote("Quilts may be " + readableFormats() + ", or videos of quilts.");
    commandLine.addExample("holiday_qs8x6a0.75.png native.png",
                           "Make a Native of a quilt whose name states its layout.");
    commandLine.addExample("-q 6x8 quilt.png native-q.png", "Read the quilt as 6 rows of 8 views.");
    commandLine.addExample("--lg swing.mp4 holiday_qs8x6a0.75.png native-lg.png",
                           "Also write a video of the views for any screen.");
    return runTool(argc, argv, commandLine, [](const CommandLine& given, Messages& messages) {
        return run(quiltJob(given), messages);
    });
}
