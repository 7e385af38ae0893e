#include "common/video_job.hpp"

#include "altiro3D/video_conversion.hpp"
#include "common/folder_run.hpp"
#include "common/native_options.hpp"
#include "common/picture_options.hpp"
#include "common/quilt_options.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <opencv2/core.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

// The depth sources of the options, for the library.
class EstimatedDepth : public DepthSource {
  public:
    explicit EstimatedDepth(ChosenDepth& depth) : depth_(depth) {}
    std::string description() const override { return depth_.description(); }
    DepthKind kind() const override { return depth_.kind(); }
    const DepthNetwork* network() const override { return depth_.network(); }
    DepthEdges edges() const override { return depth_.source().edges(); }
    void load() override { depth_.source().load(); }
    void read(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        depth_.source().read(image, photo, raw);
    }
    void readFrame(const cv::Mat& image, cv::Mat& photo, cv::Mat& raw) override {
        depth_.source().readFrame(image, photo, raw);
    }

  private:
    ChosenDepth& depth_;
};

std::string factsText(const VideoFacts& facts) {
    std::string text = sizeText(facts.size);
    if (facts.averageRate.isKnown()) text += ", " + fixed(facts.averageRate.value(), 2) + " fps";
    if (facts.duration) text += ", " + clockText(*facts.duration);
    text += ", " + facts.codec;
    for (const VideoStreamFacts& stream : facts.streams) {
        if (stream.kind == StreamKind::Audio) text += ", sound " + stream.codec;
        if (stream.kind == StreamKind::Subtitle) text += ", subtitles " + stream.codec;
    }
    return text;
}

// A picture opens as a video of one frame; only --input-... makes this intentional.
// @param facts null: of a file that is not opened yet
void refusePicture(const CommandLine& commandLine, const VideoPlan& plan, const VideoFacts* facts) {
    std::error_code error;
    if (!fs::is_regular_file(plan.input, error) || commandLine.has("input-format") ||
        commandLine.has("input-options") ||
        !(facts != nullptr ? isPicture(plan.input, *facts) : isHeifPicture(plan.input))) {
        return;
    }
    throw UsageError(plan.inputName() + ": is a picture, expected a video; " +
                     (plan.fromQuilt
                          ? "quilt2native makes a Native picture of it if OUT is named as one"
                          : "photo2native makes a Native of a photo"));
}

// Videos carry no mark; ordinary ones have no 4:4:4 at the very size of a panel.
void refuseNativeVideo(const VideoPlan& plan, const VideoFacts& facts, const ChosenDisplay& display,
                       Messages& messages) {
    const bool fullColour = facts.pixelFormat.find("444") != std::string::npos ||
                            facts.pixelFormat.find("gbr") != std::string::npos;
    if (facts.size != display.panelSize() || !fullColour) return;
    const std::string like = "has the panel's size and 4:4:4 colour, like a Native video";
    if (plan.isFromFolder) {
        throw NotTaken{
            {plan.input, FileKind::NativeVideo, like + "; if it is none, it is converted alone"}};
    }
    messages.warn("the video " + like + "; do not convert a Native again");
}

DisplayUse useOf(VideoProduct product) {
    switch (product) {
    case VideoProduct::Native:
        break;
    case VideoProduct::Quilt:
        return DisplayUse::Quilt;
    case VideoProduct::Rgbd:
        return DisplayUse::None;
    }
    return DisplayUse::Show;
}

// Shows some of the first frames of a file (0, 1, 2, 4, 8, ...): one of them may be dark, or a
// title. None if the frames cannot be read twice.
// @param look false: it has seen enough
void forEarlyFrames(const VideoPlan& plan, int lastFrame,
                    const std::function<bool(const cv::Mat&)>& look) {
    std::error_code error;
    if (!fs::is_regular_file(plan.input, error)) return;
    VideoReader reader(plan.input, plan.part);
    int wanted = 0;
    for (int number = 0; number <= lastFrame; ++number) {
        const auto frame = reader.next();
        if (!frame) break;
        if (number != wanted) continue;
        wanted = std::max(1, 2 * wanted);
        if (!look(frame->picture)) break;
    }
}

// What is found in the first frames of a video of quilts.
std::optional<FoundQuilt> searchFrames(const VideoPlan& plan, int lastFrame) {
    std::optional<FoundQuilt> best;
    forEarlyFrames(plan, lastFrame, [&best](const cv::Mat& frame) {
        const FoundQuilt found = findQuiltLayout(frame);
        const bool saysMore =
            found.verdict == QuiltVerdict::Unsure && best &&
            (best->verdict == QuiltVerdict::NoQuilt || best->confidence < found.confidence);
        const bool isQuilt = found.verdict == QuiltVerdict::Quilt;
        if (isQuilt || !best || saysMore) best = found;
        return !isQuilt;
    });
    return best;
}

// Whether the halves of a frame are what the name says.
bool areNamedHalves(const fs::path& video, const SceneName& name, const cv::Mat& frame) {
    if (name.contents == SceneName::Contents::Eyes)
        return readNamedHalves(video, frame).has_value();
    return findDepthHalf(frame, name.isStacked).has_value();
}

// Videos whose names say that frames hold both eyes or photo and depth, and which do.
void refuseHalves(const VideoPlan& plan, Messages& messages) {
    constexpr int kLastFrame = 64;
    const std::optional<SceneName> name = parseSceneName(plan.input);
    std::error_code error;
    if (!name || !fs::is_regular_file(plan.input, error)) return;
    refuseVrName(plan.input);
    bool areHalves = false;
    forEarlyFrames(plan, kLastFrame, [&](const cv::Mat& frame) {
        areHalves = areNamedHalves(plan.input, *name, frame);
        return !areHalves;
    });
    const std::string tag = "by its name (" + name->tag + ")";
    const bool isRgbd = name->contents == SceneName::Contents::Rgbd;
    const std::string what = isRgbd ? "holds photo and depth " : "holds the pictures of both eyes ";
    if (!areHalves) {
        messages.warn(plan.inputName() + ": " + what + tag +
                      ", but its frames do not: " + "they are taken as ordinary ones");
        return;
    }
    const std::string remedy = isRgbd ? "video2native --rgbd right makes a Native of it"
                                      : "they would become one flat scene";
    if (plan.isFromFolder)
        throw NotTaken{{plan.input, FileKind::HalvesVideo, what + tag + "; " + remedy}};
    if (isRgbd)
        throw UsageError(plan.inputName() + ": " + what + tag +
                         ", expected --rgbd with the side of the depth, as --rgbd right");
    messages.warn(plan.inputName() + ": " + what + tag + "; " + remedy +
                  ", expected those of one eye");
}

// Videos of a folder that are not named as videos of quilts are searched for one.
void refuseQuiltVideo(const VideoPlan& plan, Messages& messages) {
    constexpr int kLastFrame = 4;
    const std::optional<FoundQuilt> found = searchFrames(plan, kLastFrame);
    if (!found || found->confidence <= 0) return;
    const std::string text = "a video of quilts of " + std::to_string(found->layout.columns) +
                             " columns x " + std::to_string(found->layout.rows) + " rows";
    if (found->verdict == QuiltVerdict::Quilt) {
        throw NotTaken{
            {plan.input, FileKind::QuiltVideo,
             "is " + text + "; quilt2native makes a Native of it if it is named itself"}};
    }
    if (found->verdict == QuiltVerdict::Unsure)
        messages.warnOfSubject("may be " + text +
                               "; if it is one, quilt2native -q makes its Native");
}

// The path from frames with depth to Natives.
// @param seenAspect width : height of the scene as it is shown
void choosePath(const CommandLine& commandLine, VideoJob& job, double seenAspect,
                Messages& messages) {
    NativeOptions& native = job.native;
    job.path = "quilt";
    if (job.plan.product == VideoProduct::Rgbd) return;
    tellCut(seenAspect, job.display.aspect(), native, messages);
    if (job.plan.product == VideoProduct::Quilt) return;
    const NativeMaker maker =
        makeNativeMaker(commandLine, job.display, job.layout, native, messages, job.profile.keep);
    job.path = pathName(maker);
    native.positions = maker.options().positions;
}

std::optional<DepthRange> depthRangeOption(const CommandLine& commandLine) {
    const auto text = commandLine.value("depth-range");
    if (!text) return std::nullopt;
    if (!commandLine.has("depth") && !commandLine.has("d"))
        throw UsageError("--depth-range goes with --depth, expected a depth video or images");
    DepthRange range;
    char rest = 0;
    const bool isRead =
        std::sscanf(text->c_str(), "%lf:%lf%c", &range.low, &range.high, &rest) == 2;
    if (!isRead || !(range.low >= 0) || !(range.high > range.low) || !(range.high <= 65535)) {
        throw UsageError("--depth-range is \"" + *text +
                         "\", expected two numbers of 0..65535, as 0:4095");
    }
    return range;
}

double aspectOf(cv::Size size) {
    return static_cast<double>(size.width) / size.height;
}

void takeDepth(const CommandLine& commandLine, VideoJob& job, const std::optional<RgbdLayout>& rgbd,
               VideoConversion& conversion) {
    if (!job.depth) return;
    const std::optional<DepthRange> range = depthRangeOption(commandLine);
    if (!job.depth->fromFiles() && !rgbd) {
        conversion.depth = std::make_unique<EstimatedDepth>(*job.depth);
        return;
    }
    GivenVideoDepth& given = conversion.given.emplace();
    if (job.depth->fromFiles()) given.source = job.plan.depth;
    given.rgbd = rgbd;
    given.kind = job.depth->kind();
    given.range = range;
    given.read = [](const fs::path& file, Notes* notes) {
        const QuietStandardError quiet;
        return readDepthSamples(file, notes);
    };
}

VideoWriterOptions encodingOf(const CommandLine& commandLine, const VideoJob& job,
                              Messages& messages) {
    VideoWriterOptions encoding = encoderOptions(commandLine, job.profile);
    if (job.plan.product == VideoProduct::Native && encoding.compatible) {
        messages.warn("--compat halves the colour resolution (4:2:0): in a Native neighbouring "
                      "sub-pixels belong to different views, so views are mixed and depth blurs; "
                      "use it only for players that refuse the usual file");
    }
    encoding.threads = cv::getNumThreads();
    return encoding;
}

} // namespace

void prepareVideo(const CommandLine& commandLine, VideoJob& job, Messages& messages) {
    const VideoPlan& plan = job.plan;
    NativeOptions& native = job.native;
    job.profile = videoProfile(commandLine);
    if (plan.show && !commandLine.has("profile")) job.profile = videoProfile("live");
    native = nativeOptions(commandLine);
    if ((native.framing != Framing() || autoChoices(commandLine).any()) &&
        (plan.fromQuilt || plan.product == VideoProduct::Rgbd)) {
        throw UsageError(
            std::string(
                "--center, --zoom and auto apply to views that are made of frames, expected no ") +
            (plan.fromQuilt ? "--from-quilt" : "--rgbd-out") + " with them");
    }
    if (job.profile.keep) native.detail = Detail::Panel;
    if (plan.product != VideoProduct::Native) native.positions = ViewPositions::Discrete;
    if (!commandLine.has("method") && !commandLine.has("g"))
        native.views.method = job.profile.method;
    if (!plan.fromQuilt) requireKnobsOf(commandLine, native.views.method);
    checkNativeOptions(commandLine);
    job.display = findDisplay(commandLine, messages, {}, useOf(plan.product));
    if (job.display.map) native.sampling = {};
}

void openDepth(const CommandLine& commandLine, VideoJob& job, Messages& messages) {
    if (job.depth || job.plan.fromQuilt) return;
    ChosenDepth& depth = job.depth.emplace(commandLine, messages, Medium::Video);
    int& steps = job.depthOptions.every;
    steps = job.profile.depthEvery;
    const auto every = commandLine.value("depth-every");
    if (every) steps = *every == "auto" ? 0 : *commandLine.wholeNumber("depth-every", 1, 1000);
    if (!depth.fromFiles() && !depth.rgbd()) return;
    if (every) {
        throw UsageError("--depth-every says how often depth is estimated, but here it is given; "
                         "leave it out");
    }
    steps = 1;
}

QuiltLayout layoutOfViews(const CommandLine& commandLine, const VideoJob& job, Messages& messages) {
    QuiltLayout layout = chooseQuilt(commandLine, job.display, messages);
    if (job.plan.product == VideoProduct::Quilt && !commandLine.has("r") && !job.display.map) {
        cv::Size& tile = layout.tileSize; // 4:2:0 has even sides only
        tile = {std::max(2, tile.width / 2 * 2), std::max(2, tile.height / 2 * 2)};
    }
    return layout;
}

VideoConversion openVideo(const CommandLine& commandLine, VideoJob& job, Messages& messages) {
    VideoPlan& plan = job.plan;
    NativeOptions& native = job.native;
    VideoConversion conversion;
    plan.part.threads = std::min(cv::getNumThreads(), 16);
    refusePicture(commandLine, plan, nullptr); // FFmpeg's error would not say so
    conversion.reader = std::make_unique<VideoReader>(plan.input, plan.part);
    const VideoFacts& facts = conversion.reader->facts();
    refusePicture(commandLine, plan, &facts);
    messages.say((messages.hasSubject() ? "" : plan.inputName() + ": ") + factsText(facts));
    if (!plan.fromQuilt) {
        warnIfQuilt(plan.input, "--from-quilt", messages);
        if (!commandLine.has("rgbd") && !commandLine.has("depth") && !commandLine.has("d"))
            refuseHalves(plan, messages);
    }
    if (plan.product == VideoProduct::Native) refuseNativeVideo(plan, facts, job.display, messages);
    std::optional<RgbdLayout> rgbd;
    std::optional<FoundQuilt> found;
    if (plan.fromQuilt && !isLayoutStated(commandLine, plan.input)) found = searchFrames(plan, 64);
    if (plan.isFromFolder && !plan.fromQuilt && !job.depth->rgbd())
        refuseQuiltVideo(plan, messages);
    job.layout = plan.fromQuilt ? chooseQuilt(commandLine, job.display, messages, plan.input,
                                              facts.size, found)
                                : layoutOfViews(commandLine, job, messages);
    if (plan.product == VideoProduct::Quilt)
        plan.output = quiltFileName(plan.output, job.layout, job.display.aspect());
    checkOutputs(commandLine, plan, job.display);
    if (plan.fromQuilt) {
        const QuiltShape shape(plan.input, job.layout, job.display, fitOption(commandLine));
        messages.say("quilt: " + quiltText(job.layout, shape.shownAspect()) +
                     (found ? foundText(*found) : ""));
        tellShape(shape, messages);
        native.fit = shape.fit();
        conversion.viewAspect = shape.aspect();
    } else {
        if (plan.product == VideoProduct::Native)
            messages.say("quilt: " + quiltText(job.layout, job.display.aspect()));
        openDepth(commandLine, job, messages);
        if (job.depth->rgbd()) {
            rgbd = rgbdOf(plan.input, *job.depth->rgbd(),
                          facts.sampleAspect.value() * aspectOf(facts.size), messages);
        }
        const cv::Size photo = rgbd ? rgbd->photoSize(facts.size) : facts.size;
        choosePath(commandLine, job, facts.sampleAspect.value() * aspectOf(photo), messages);
    }
    job.encoding = encodingOf(commandLine, job, messages);

    conversion.input = plan.input;
    conversion.part = plan.part;
    conversion.output = plan.output;
    conversion.product = plan.product;
    conversion.display = job.display;
    conversion.map = job.display.map;
    conversion.layout = job.layout;
    conversion.native = native;
    conversion.choices = autoChoices(commandLine);
    conversion.fromQuilt = plan.fromQuilt;
    takeDepth(commandLine, job, rgbd, conversion);
    conversion.depthOptions = job.depthOptions;
    conversion.encoding = job.encoding;
    conversion.settings = settingsOf(commandLine);
    if (commandLine.has("resume")) {
        conversion.unfinished = UnfinishedRun::Resume;
    } else if (commandLine.has("y")) {
        conversion.unfinished = UnfinishedRun::Discard;
    }
    return conversion;
}

} // namespace altiro3D::tools
