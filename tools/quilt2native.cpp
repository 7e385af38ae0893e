// quilt2native: a quilt, or a video of quilts, becomes a Native.

#include "altiro3D/altiro3D.hpp"
#include "common/display_options.hpp"
#include "common/outputs.hpp"
#include "common/picture_options.hpp"
#include "common/run_tool.hpp"
#include "common/video_options.hpp"

#include <cmath>
#include <iostream>
#include <opencv2/core.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

// Fits each view of a quilt to the panel's shape, tile by tile.
cv::Mat fitViews(const cv::Mat& quilt, const QuiltLayout& layout, double viewAspect,
                 double panelAspect, FitMode mode) {
    cv::Mat fitted(quilt.size(), quilt.type());
    // A tile shows viewAspect whatever its px: fit in a space where that is so.
    const int height = layout.tileSize.height;
    const cv::Size shown(std::max(1, static_cast<int>(std::lround(height * viewAspect))), height);
    const PhotoFit toShown = fitPhoto(layout.tileSize, viewAspect, shown, FitMode::Stretch);
    const PhotoFit toPanel = fitPhoto(shown, panelAspect, layout.tileSize, mode);
    cv::parallel_for_(cv::Range(0, layout.columns * layout.rows), [&](const cv::Range& tiles) {
        cv::Mat view;
        for (int i = tiles.start; i < tiles.end; ++i) {
            applyFit(quilt(layout.tile(i)), toShown, view);
            applyFit(view, toPanel, view);
            view.copyTo(fitted(layout.tile(i)));
        }
    });
    return fitted;
}

// Tells from a quilt's name and layout how its views become the panel's shape.
class ViewShape {
  public:
    ViewShape(const fs::path& file, const QuiltLayout& layout, const Display& display, FitMode fit)
        : layout_(layout), panelAspect_(display.panelAspect()), fit_(fit) {
        const auto name = parseQuiltName(file);
        isStated_ = name && name->aspect;
        aspect_ = isStated_ ? *name->aspect
                            : static_cast<double>(layout.tileSize.width) / layout.tileSize.height;
    }

    // The quilt without unused px, its views fitted if that was asked for.
    cv::Mat apply(const cv::Mat& picture, Notes* notes) const {
        cv::Mat quilt = fitQuilt(picture, layout_, notes);
        if (fit_ != FitMode::Stretch) quilt = fitViews(quilt, layout_, aspect_, panelAspect_, fit_);
        return quilt;
    }

    void warnIfStretched(Messages& messages) const {
        if (fit_ != FitMode::Stretch || !isStated_) return;
        if (std::abs(aspect_ / panelAspect_ - 1) <= 0.05) return;
        messages.warn("the file name says that the views are meant for another shape than the "
                      "panel's; they are stretched to it (--fit contain or cover keep theirs)");
    }

  private:
    QuiltLayout layout_;
    double aspect_;
    double panelAspect_;
    bool isStated_;
    FitMode fit_;
};

// What a run has settled before it reads the quilt.
struct Job {
    const CommandLine& commandLine;
    fs::path quilt;
    fs::path native;
    Display display;
    FitMode fit = FitMode::Stretch;
};

// FFmpeg takes a picture for a video of one frame.
bool isPicture(const VideoReader& reader) {
    const std::string& format = reader.facts().format;
    const std::string ending = "_pipe";
    return format == "image2" || format == "gif" ||
           (format.size() > ending.size() &&
            format.compare(format.size() - ending.size(), ending.size(), ending) == 0);
}

bool isVideo(const fs::path& file) {
    if (canWritePicture(file)) return false; // by its name
    try {
        return !isPicture(VideoReader(file));
    } catch (const Error&) {
        return false; // who reads it as a picture says what is wrong with it
    }
}

void convertPicture(const Job& job, Messages& messages) {
    StageTimes times;
    const cv::Mat picture = readPhotoFile(job.quilt, messages);
    times.end("read");
    const QuiltLayout layout =
        chooseQuilt(job.commandLine, job.display, messages, job.quilt, picture.size());
    messages.say("quilt: " + layout.text());
    const ViewShape shape(job.quilt, layout, job.display, job.fit);
    Notes notes;
    const cv::Mat quilt = shape.apply(picture, &notes);
    messages.warn(notes);
    shape.warnIfStretched(messages);
    const Quilt2Native renderer = makeQuilt2Native(job.commandLine, job.display, layout, messages);
    times.end("look-up table");
    makeNativeFile(renderer, quilt, job.native, messages, times);
    messages.detail(times.text());
}

// Exit status.
int convertVideo(const Job& job, Messages& messages) {
    VideoReader reader(job.quilt);
    if (isPicture(reader)) {
        throw UsageError(job.quilt.string() + ": is a picture, expected a video, or the name of a "
                                              "picture for the Native");
    }
    const VideoFacts& facts = reader.facts();
    const QuiltLayout layout =
        chooseQuilt(job.commandLine, job.display, messages, job.quilt, facts.size);
    messages.say("quilt: " + layout.text());
    const ViewShape shape(job.quilt, layout, job.display, job.fit);
    shape.warnIfStretched(messages);
    const Quilt2Native renderer = makeQuilt2Native(job.commandLine, job.display, layout, messages);
    VideoWriterOptions options;
    options.size = renderer.panelSize();
    takeTimes(facts, options);
    VideoWriter writer(job.native, options, &reader);
    Notes notes;
    const auto expected = static_cast<std::size_t>(facts.frameCount.value_or(0));
    Progress progress(expected);
    std::size_t frames = 0;
    runPipeline({{"decode", [&](PipelineFrame& frame) { return reader.read(frame.source); }},
                 {"render",
                  [&](PipelineFrame& frame) {
                      const cv::Mat& picture = frame.source.picture;
                      renderer.render(shape.apply(picture, frame.number == 0 ? &notes : nullptr),
                                      frame.result.picture);
                      frame.result.pts = frame.source.pts;
                      frame.result.duration = frame.source.duration;
                      return true;
                  }},
                 {"encode", [&](PipelineFrame& frame) {
                      writer.write(frame.result);
                      if (frames++ < expected) progress.step(job.quilt.filename().string());
                      return true;
                  }}});
    progress.clear();
    if (frames == 0) {
        throw Error(ErrorCode::BadFormat, job.quilt.string(),
                    "holds no frames, expected a video of quilts");
    }
    writer.finish();
    messages.warn(notes);
    const std::string cutOff = tellNotes(reader, messages);
    messages.warn(writer.notes());
    messages.say(job.native.string() + ": Native video, " + std::to_string(options.size.width) +
                 " x " + std::to_string(options.size.height) + " px, " + std::to_string(frames) +
                 " frames");
    if (cutOff.empty()) return kExitDone;
    messages.flushWarnings();
    messages.fail(cutOff);
    return kExitFailed;
}

// Whether a picture is a quilt: its name says so, or it fills the quilt that options or display
// tell.
bool isQuilt(const CommandLine& commandLine, Messages& messages) {
    const fs::path& file = commandLine.files()[0];
    if (parseQuiltName(file) || isVideo(file)) return true;
    const Display display = findDisplay(commandLine, messages);
    const QuiltLayout layout = chooseQuilt(commandLine, display, messages, file, std::nullopt);
    const cv::Size size = readPhotoFile(file, messages).size();
    return cv::Size(size.width / layout.columns, size.height / layout.rows) == layout.tileSize;
}

int run(const CommandLine& commandLine, Messages& messages) {
    if (commandLine.files().size() != 2) {
        throw UsageError("expected QUILT and OUT, got " +
                         std::to_string(commandLine.files().size()) +
                         " names; see quilt2native --help");
    }
    if (commandLine.has("tell-kind")) {
        messages.leaveStandardOutput();
        std::cout << (isQuilt(commandLine, messages) ? "quilt" : "photo") << "\n";
        messages.dropWarnings(); // the run to come says them
        return kExitDone;
    }
    Job job{commandLine, commandLine.files()[0], commandLine.files()[1], {}, FitMode::Stretch};
    job.fit = fitOption(commandLine, FitMode::Stretch);
    const bool video = canWriteVideo(job.native);
    if (!video && isVideo(job.quilt)) {
        throw UsageError(job.native.string() + ": is no video's name, but " + job.quilt.string() +
                         " is a video; expected .mp4, .mov or .mkv");
    }
    if (!video) requirePictureName(job.native);
    job.display = findDisplay(commandLine, messages);
    Outputs outputs(commandLine.has("y"));
    outputs.addInput(job.quilt);
    for (const fs::path& file : job.display.files)
        outputs.addInput(file);
    outputs.addOutput(job.native);
    outputs.check();
    if (video) return convertVideo(job, messages);
    convertPicture(job, messages);
    return kExitDone;
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine("quilt2native", "Turns a quilt, the collage of all views, into the "
                                            "Native picture for a display; or a video of quilts "
                                            "into a Native video with its sound.");
    commandLine.addUsage("[options] QUILT OUT.png");
    commandLine.addUsage("[options] QUILTVIDEO OUT.mp4");
    commandLine.addSection("Output");
    commandLine.add({"y"}, "Replace the output if it exists.");
    addDisplayOptions(commandLine);
    addFitOption(commandLine, "stretch");
    addSamplingOptions(commandLine);
    commandLine.addHidden("tell-kind"); // for altiro3Dimage
    commandLine.addNote("A file name that ends in _qs<columns>x<rows>a<aspect>, such as "
                        "photo_qs8x6a0.75.png, tells the layout; otherwise it is the display's own "
                        "or that of -q. View 0 is the bottom-left tile. A Native video is "
                        "H.264 4:4:4 in .mp4, .mov or .mkv, which keeps the colour of every "
                        "sub-pixel; sound, subtitles, chapters and tags are copied.");
    return runTool(argc, argv, commandLine, run);
}
