// slide2native: turns a video or photos from a camera that moves sideways into a Native.

#include "altiro3D/altiro3D.hpp"
#include "cli/eyes_options.hpp"
#include "cli/json_text.hpp"
#include "cli/outputs.hpp"
#include "cli/page_options.hpp"
#include "cli/picture_options.hpp"
#include "cli/print_options.hpp"
#include "cli/views_folder.hpp"
#include "photo/sway_options.hpp"

#include <opencv2/core.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

// The command line.
struct SlideJob {
    std::vector<fs::path> inputs; // a video, a folder of photos, or photos
    fs::path native;              // empty: this and the following ones are not saved
    fs::path quilt;
    fs::path views; // a folder
    fs::path photo;
    fs::path depth;
    fs::path splats;
    fs::path pageFile;
    PageOptions page;
    fs::path video;
    EyesFiles eyes;
    bool replace = false;
    SlideOptions slide;
    FitMode fit = FitMode::Cover;
    SwayOptions sway;
    std::optional<cv::Size> swaySize;
    DisplayOptions display;
    QuiltRequest layout;
    QuiltSampling sampling;
    std::optional<PrintOptions> print;
};

SlideJob slideJob(const CommandLine& commandLine) {
    const std::vector<fs::path>& names = commandLine.files();
    const bool isAlone = names.size() == 1 && commandLine.has("save-page");
    if (names.size() < 2 && !isAlone)
        commandLine.failNames("a video, a folder or photos, and OUT", 2);
    SlideJob job;
    job.inputs.assign(names.begin(), names.end() - (isAlone ? 0 : 1));
    if (!isAlone) job.native = names.back();
    job.print = printOptions(commandLine);
    if (isAlone)
        commandLine.refuse({"print"}, " makes a print, expected OUT, the name of its file");
    else
        requireNativeName(job.native, job.print.has_value());
    job.page = PageOptions(commandLine);
    constexpr std::pair<const char*, SlideViews> kMethods[] = {{"between", SlideViews::Between},
                                                               {"nearest", SlideViews::Nearest}};
    commandLine.take({{"save-quilt", job.quilt},
                      {"save-views", job.views},
                      {"save-photo", job.photo},
                      {"save-depth", job.depth},
                      {"save-splats", job.splats},
                      {"save-page", job.pageFile},
                      {"lg", job.video},
                      {"y", job.replace},
                      {"method", job.slide.views, kMethods},
                      {"focus", job.slide.focus, 0, 1},
                      {"turntable", job.slide.turntable},
                      {"view-angle", job.slide.viewDegrees, 1, 150}});
    if (!job.photo.empty()) requirePictureName(job.photo);
    if (!job.depth.empty()) requirePictureName(job.depth, false);
    requireSplatName(job.splats);
    requirePageName(job.pageFile);
    requireSwayFile(commandLine);
    if (!job.video.empty()) requireVideoName(job.video);
    job.eyes = EyesFiles(commandLine);
    job.fit = fitOption(commandLine).value_or(job.fit);
    job.sway = swayOptions(commandLine);
    job.swaySize = swaySizeOption(commandLine);
    job.display = displayOptions(commandLine);
    job.layout = quiltRequest(commandLine);
    job.sampling = pictureSampling(commandLine);
    return job;
}

int makeNative(const SlideJob& job, Messages& messages) {
    Notes remarks;
    std::vector<fs::path> files;
    const SlidePictureSource source = slideOf(job.inputs, files, &remarks);
    Outputs outputs(job.replace);
    outputs.addInputs(files);
    if (!job.native.empty()) outputs.addNative(job.native);
    StageTimes times;
    ChosenDisplay display = findDisplay(job.display, messages);
    const std::optional<PrintSheet> print = printSheet(job.print, display, messages);
    outputs.addInputs(display.files);
    const QuiltLayout layout = chooseQuilt(job.layout, display, messages);
    const int count = layout.viewCount;
    fs::path quiltOutput;
    if (!job.quilt.empty()) {
        quiltOutput = quiltFileName(job.quilt, layout, display.aspect());
        requirePictureName(quiltOutput);
    }
    outputs.addOutputs({quiltOutput, job.photo, job.depth, job.splats, job.pageFile, job.video});
    outputs.addOutputs(job.eyes.files());
    if (!job.views.empty()) {
        outputs.addDirectory(job.views);
        for (int i = 0; i < count; ++i)
            outputs.addOutputs({job.views / viewFileName(i, count)});
    }
    outputs.check();
    if (!job.depth.empty()) warnAboutDepthFormat(job.depth, messages);
    messages.say("quilt: " + quiltText(layout, display.aspect()));
    catchStop();

    const SlidePictureSource stoppable = [&](const auto& take) {
        source([&](const cv::Mat& picture) {
            endIfStopWanted();
            return take(picture);
        });
    };
    showStatus("looking for the path of the camera");
    SlideOptions options = slideOptionsFor(layout, display.aspect(), job.fit, job.slide);
    if (files.size() > 1)
        for (const fs::path& file : files)
            options.names.push_back(file.filename().string());
    CameraSlide slide(stoppable, options, job.inputs.front().string());
    clearStatus();
    times.end("find the path");
    for (const std::string& line : slide.report().lines())
        messages.say(line);
    messages.warn(remarks);
    messages.warn(slide.notes());
    outputs.makeDirectories();

    Progress progress(static_cast<std::size_t>(count));
    const cv::Mat quilt = quiltOfSlide(
        slide, layout, display.aspect(), job.fit, [&](int view, const cv::Mat& picture) {
            progress.step("view " + std::to_string(view + 1));
            if (!job.views.empty()) writeImage(job.views / viewFileName(view, count), picture);
        });
    progress.clear();
    times.end("views");
    if (!job.photo.empty() || !job.depth.empty() || !job.splats.empty()) {
        cv::Mat photo;
        cv::Mat depth;
        slide.makeDepth(photo, depth);
        normalizeDepth(depth, depth);
        if (!job.photo.empty()) writeImage(job.photo, photo);
        if (!job.depth.empty()) writeImage(job.depth, depthTo16Bit(depth));
        if (!job.splats.empty()) {
            SplatScene scene = photoSplats({photo, depth}, PlacementOptions());
            scene.camera.reset();
            writeSplats(job.splats, scene);
        }
        times.end("depth");
    }
    if (!quiltOutput.empty()) writeImage(quiltOutput, quilt);
    if (!job.eyes.files().empty())
        job.eyes.write(eyesOfQuilt(quilt, layout, display.aspect()), messages);
    if (!job.pageFile.empty())
        writePage(job.pageFile,
                  quiltPage(quilt, layout, display.aspect(), job.page.text(job.inputs.front()),
                            job.page.side),
                  messages);
    if (!job.video.empty())
        writeQuiltSwayFile(job.video, quilt, layout, display.aspect(), job.swaySize, job.fit,
                           ViewFilter::Nearest, job.sway);
    times.end("other outputs");
    if (!job.native.empty()) {
        const Quilt2Native renderer = makeQuilt2Native(job.sampling, display, layout);
        makeNativeFile(renderer, quilt, job.native, print, messages, times);
    }
    if (!quiltOutput.empty()) messages.say(quiltOutput.string() + ": quilt");
    messages.detail(times.text());
    return kExitDone;
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine(
        "slide2native", "Turns a video or photos from a camera that moves sideways into the Native "
                        "picture for a display: real views, without estimated depth.");
    commandLine.addUsage("[options] VIDEO OUT.png");
    commandLine.addUsage("[options] DIR OUT.png");
    commandLine.addUsage("[options] PHOTO... OUT.png");
    commandLine.addUsage("--save-page OUT.html [options] VIDEO | DIR");
    commandLine.addSection("Views");
    commandLine.add({"method"},
                    "How each view is made: between (default), from the two pictures on either "
                    "side, each px moved to its place; or nearest, from the nearest picture moved "
                    "as a whole, which is faster.",
                    "between|nearest");
    commandLine.add({"focus"},
                    "Depth that appears on the panel's surface, 0 (farthest) .. 1 (nearest); "
                    "default: the median of what is seen.",
                    "D");
    commandLine.add({"turntable"}, "The camera stands still, and the thing turns in front of it "
                                   "by 35 degrees or less.");
    commandLine.addAdvanced({"view-angle"},
                            "Horizontal angle of view of the camera in degrees, if it is known; "
                            "default: estimated.",
                            "DEG");
    addFitOption(commandLine, "cover");
    commandLine.addSection("Output");
    commandLine.add({"save-quilt"}, "Also write the quilt (named ..._qs<columns>x<rows>a<aspect>).",
                    "FILE");
    commandLine.addAdvanced({"save-views"}, "Also write the single views, leftmost camera first.",
                            "DIR");
    commandLine.add({"save-photo"}, "Also write the middle view, for --save-depth.", "FILE");
    commandLine.add({"save-depth"},
                    "Also write the depth of the middle view, 16-bit, near = white.", "FILE.png");
    commandLine.add({"save-splats"},
                    "Also write the middle view with its depth as Gaussian splats.",
                    "FILE.ply|FILE.spz");
    PageOptions::add(commandLine, "the views, blended",
                     " Without OUT, of a video or a folder no Native is made.");
    EyesFiles::add(commandLine, "The eyes' pictures are two of the views.", false);
    addSwayFileOption(commandLine, "It shows the views, and");
    commandLine.add({"y"}, "Replace outputs that exist.");
    commandLine.addSection("Video of --lg");
    addSwayOptions(commandLine);
    addPrintOptions(commandLine);
    addDisplayOptions(commandLine);
    addSamplingOptions(commandLine, "linear");
    commandLine.addNote(
        "Slide the camera sideways by 20 to 40 cm, look straight ahead and keep the "
        "scene still. Turn off the stabilisation of a phone: it warps the pictures. "
        "Small turns of the hand, uneven speed, focus and exposure are evened out.");
    commandLine.addNote("Photos may be " + readableFormats() +
                        ", in the order in which they were taken: by name in a folder, as given "
                        "otherwise.");
    commandLine.addExample("clip.mp4 native.png", "Make a Native of a filmed slide.");
    commandLine.addExample("--save-quilt scene.png photos native-p.png",
                           "Do the same with a folder of photos, and write the quilt.");
    commandLine.addExample("--save-photo m.png --save-depth d.png clip.mp4 native-d.png",
                           "Also write the middle view and its depth, for photo2native -d.");
    return runTool(argc, argv, commandLine, [](const CommandLine& given, Messages& messages) {
        return makeNative(slideJob(given), messages);
    });
}
