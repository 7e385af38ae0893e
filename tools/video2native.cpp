// video2native: videos become Native videos.

#include "altiro3D/altiro3D.hpp"
#include "common/depth_options.hpp"
#include "common/display_options.hpp"
#include "common/given_depth.hpp"
#include "common/native_road.hpp"
#include "common/outputs.hpp"
#include "common/picture_options.hpp"
#include "common/run_tool.hpp"
#include "common/video_options.hpp"
#include "common/video_progress.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr double kSegmentSeconds = 4; // what a run that dies loses at most; encoders start slowly
constexpr int kLeastSegmentFrames = 12;
constexpr int kMostSegmentFrames = 600;
constexpr int kUsualSegmentFrames = 120;
constexpr int kExitStopped = 130; // as shells call it

// --- the user's stop -------------------------------------------------------------------------

std::atomic<bool> stopWanted{false};

// The first signal ends the video properly; a second one ends the process.
extern "C" void stopOnce(int signal) {
    stopWanted.store(true);
    std::signal(signal, SIG_DFL);
}

// --- what to make ----------------------------------------------------------------------------

enum class Product { Native, Quilt, Rgbd };

struct Plan {
    fs::path input;
    fs::path depth; // given, or empty
    fs::path output;
    fs::path report;
    Product product = Product::Native;
    bool fromQuilt = false;
    bool resumable = false;
    VideoReaderOptions part;
};

Plan planRun(const CommandLine& commandLine) {
    const std::vector<fs::path>& names = commandLine.files();
    const bool pair = commandLine.has("d");
    const std::size_t expected = pair ? 3 : 2;
    if (names.size() != expected) {
        throw UsageError(std::string("expected ") + (pair ? "IN DEPTH OUT" : "IN and OUT") +
                         ", got " + std::to_string(names.size()) +
                         " names; see video2native --help");
    }
    Plan plan;
    plan.input = names.front();
    plan.output = names.back();
    if (pair) plan.depth = names[1];
    if (const auto depth = commandLine.value("depth")) plan.depth = *depth;
    plan.report = commandLine.value("report").value_or("");
    commandLine.exclude("quilt", "rgbd-out");
    if (commandLine.has("quilt")) plan.product = Product::Quilt;
    if (commandLine.has("rgbd-out")) plan.product = Product::Rgbd;
    plan.fromQuilt = commandLine.has("from-quilt");
    if (plan.fromQuilt) {
        for (const char* option :
             {"quilt", "rgbd-out", "d", "depth", "rgbd", "n", "l", "net-profile", "network-size",
              "depth-every", "k", "g", "method", "continuous", "strength", "focus"})
            commandLine.exclude("from-quilt", option);
    }
    plan.part = videoReaderOptions(commandLine);
    requireVideoName(plan.output);
    std::error_code error;
    plan.resumable = fs::is_regular_file(plan.input, error) && plan.part.format.empty();
    if (commandLine.has("resume") && !plan.resumable) {
        throw UsageError("--resume reads IN once more, expected a file, not " +
                         plan.input.string());
    }
    return plan;
}

// Everything that shapes the frames and the file: a run goes on with the same only.
std::string settingsText(const CommandLine& commandLine, const Plan& plan, const Display& display) {
    Json settings = Json::object();
    if (!plan.resumable) return settings.dump();
    for (const auto& [option, value] : commandLine.given()) {
        const bool shapes = option != "y" && option != "v" && option != "resume" &&
                            option != "progress" && option != "report";
        if (shapes) settings["-" + std::string(option.size() > 1 ? "-" : "") + option] = value;
    }
    for (const fs::path& file : {plan.input, plan.depth}) {
        if (file.empty() || fs::is_directory(file)) continue;
        settings[file.filename().string()] =
            std::to_string(fs::file_size(file)) + " bytes of " +
            std::to_string(fs::last_write_time(file).time_since_epoch().count());
    }
    settings["display"] =
        fingerprintText(display.calibration ? fingerprint(*display.calibration)
                                            : display.map->calibrationFingerprint());
    settings["version"] = ALTIRO3D_VERSION;
    return settings.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// --- frames ----------------------------------------------------------------------------------

// Shape of the picture as it is seen.
double seenAspect(const VideoFacts& facts) {
    return facts.sampleAspect.value() * facts.size.width / facts.size.height;
}

bool same(const cv::Mat& a, const cv::Mat& b) {
    return a.size() == b.size() && a.type() == b.type() && a.isContinuous() && b.isContinuous() &&
           std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

// Makes the depth of frames: estimated and kept steady, or as it was given.
class DepthStage {
  public:
    DepthStage(const Plan& plan, const VideoFacts& facts, DepthSource source,
               const VideoDepthOptions& options)
        : source_(std::move(source)), options_(options), unit_(facts.timeBase.value()) {
        if (source_.fromFiles()) given_.emplace(plan.depth, plan.part, facts);
        start();
    }

    void work(PipelineFrame& frame) {
        if (given_) {
            given_->read(static_cast<double>(frame.source.pts) * unit_, frame.number, raw_);
        } else if (source_.rgbdSide()) {
            cv::Mat photo;
            splitRgbd(frame.source.picture, *source_.rgbdSide(), photo, raw_);
            raw_.convertTo(raw_, CV_8U); // a grey value of a frame
            frame.source.picture = photo;
        } else {
            frame.step = depth_->next(frame.source.picture, frame.depth);
            return;
        }
        useGiven(frame);
    }

    VideoDepth& depth() { return *depth_; }
    const DepthSource& source() const { return source_; }
    const VideoDepthOptions& options() const { return options_; }
    void tell(Messages& messages) const {
        if (given_) given_->tell(messages);
    }

  private:
    void start() {
        const auto estimate = [this](const cv::Mat& picture, cv::Mat& raw) {
            if (raw_.empty()) {
                source_.estimate(picture, raw);
            } else {
                raw_.copyTo(raw);
            }
        };
        depth_.emplace(estimate, source_.kind(), options_);
    }

    // Grey values are taken as they are, so that nothing wavers; distances and floats have no range
    // of their own and get one that follows them slowly.
    void useGiven(PipelineFrame& frame) {
        const bool samePhoto = same(frame.source.picture, lastPhoto_);
        const bool sameDepth = same(raw_, lastRaw_);
        lastPhoto_ = frame.source.picture;
        lastRaw_ = raw_.clone();
        const bool grey = raw_.depth() == CV_8U || raw_.depth() == CV_16U;
        if (grey && source_.kind() != DepthKind::Metric) {
            frame.step.repeated = samePhoto && sameDepth;
            const double most = raw_.depth() == CV_8U ? 255 : 65535;
            const bool farWhite = source_.kind() == DepthKind::FarWhite;
            ownMemory(frame.depth);
            raw_.convertTo(frame.depth, CV_32F, (farWhite ? -1 : 1) / most, farWhite ? 1 : 0);
            return;
        }
        if (samePhoto && !sameDepth) start(); // what moves is not seen in the picture
        frame.step = depth_->next(frame.source.picture, frame.depth);
        frame.step.inferred = false;
    }

    DepthSource source_;
    VideoDepthOptions options_;
    double unit_;
    std::optional<GivenDepth> given_;
    cv::Mat raw_; // given
    cv::Mat lastRaw_;
    cv::Mat lastPhoto_;
    std::optional<VideoDepth> depth_;
};

// Makes what is written of frames with depth.
class RenderStage {
  public:
    RenderStage(const CommandLine& commandLine, const Display& display, const QuiltLayout& layout,
                const ViewOptions& views, const VideoProfile& profile, Product product, FitMode fit,
                double seenAspect, Messages& messages)
        : layout_(layout), views_(views), product_(product), fit_(fit),
          panelAspect_(display.panelAspect()), seenAspect_(seenAspect), workSize_(layout.tileSize) {
        if (product == Product::Native) {
            const bool keep = commandLine.has("k") || profile.keep;
            road_.emplace(commandLine, display, layout, views.method, messages, profile.keep);
            if (road_->direct()) renderer_.emplace(road_->renderer(views));
            if (keep) workSize_ = display.panelSize;
            size_ = display.panelSize;
        } else if (product == Product::Quilt) {
            if (commandLine.has("k")) workSize_ = display.panelSize;
            size_ = layout.size();
        }
        if (product != Product::Native || !road_->direct()) quilter_.emplace(layout, views);
    }

    // Size of what is written, from the size of the photos.
    cv::Size size(cv::Size photo) {
        if (product_ == Product::Rgbd) {
            // square px, even sides
            const double width = photo.height * seenAspect_;
            workSize_ = {std::max(2, static_cast<int>(std::lround(width / 2)) * 2),
                         std::max(2, photo.height / 2 * 2)};
            size_ = {2 * workSize_.width, workSize_.height};
        }
        return size_;
    }

    std::string roadName() const { return road_ ? road_->name() : "quilt"; }
    bool continuous() const { return road_ && road_->continuous(); }

    void work(PipelineFrame& frame) {
        if (frame.step.repeated && !last_.empty()) {
            frame.result.picture = last_;
            return;
        }
        const cv::Mat& photo = frame.source.picture;
        ownMemory(frame.result.picture);
        if (product_ == Product::Rgbd) {
            const PhotoFit fit = fitPhoto(photo.size(), 1, workSize_, FitMode::Stretch);
            fitFrame(frame, fit);
            joinRgbd(photo_, depth_, DepthSide::Right, frame.result.picture);
        } else {
            // what counts is the shape that is seen: px of the frame need not be square
            const double pixelAspect = seenAspect_ * photo.rows / photo.cols;
            const PhotoFit fit =
                fitPhoto(photo.size(), panelAspect_ / pixelAspect, workSize_, fit_);
            fitFrame(frame, fit);
            cv::Mat& quilt = product_ == Product::Quilt ? frame.result.picture : quilt_;
            if (quilter_) quilter_->render(photo_, depth_, quilt);
            if (renderer_) {
                renderer_->render(photo_, depth_, frame.result.picture);
            } else if (road_) {
                road_->makeNative(views_, photo_, depth_, quilt_, frame.result.picture);
            }
        }
        last_ = frame.result.picture;
    }

  private:
    void fitFrame(const PipelineFrame& frame, const PhotoFit& fit) {
        applyFit(frame.source.picture, fit, photo_);
        applyFitToDepth(frame.depth, frame.source.picture.size(), fit, photo_, views_.focus,
                        depth_);
    }

    QuiltLayout layout_;
    ViewOptions views_;
    Product product_;
    FitMode fit_;
    double panelAspect_;
    double seenAspect_;
    cv::Size workSize_;
    cv::Size size_;
    std::optional<NativeRoad> road_;
    std::optional<NativeRenderer> renderer_;
    std::optional<Depth2Quilt> quilter_;
    cv::Mat photo_;
    cv::Mat depth_;
    cv::Mat quilt_;
    cv::Mat last_;
};

// Makes Natives of frames that are quilts.
class QuiltStage {
  public:
    QuiltStage(const CommandLine& commandLine, const Display& display, const QuiltLayout& layout,
               Messages& messages)
        : layout_(layout), renderer_(makeQuilt2Native(commandLine, display, layout, messages)) {}

    void work(PipelineFrame& frame) {
        if (!last_.empty() && same(frame.source.picture, lastQuilt_)) {
            frame.step.repeated = true;
            frame.result.picture = last_;
            return;
        }
        Notes notes;
        const cv::Mat quilt = fitQuilt(frame.source.picture, layout_, &notes);
        ownMemory(frame.result.picture);
        renderer_.render(quilt, frame.result.picture);
        last_ = frame.result.picture;
        lastQuilt_ = frame.source.picture;
    }

  private:
    QuiltLayout layout_;
    Quilt2Native renderer_;
    cv::Mat last_;
    cv::Mat lastQuilt_;
};

// Where the frames go: to segments that a later run can go on from, or straight to the file.
class Sink {
  public:
    Sink(const Plan& plan, VideoWriterOptions options, const std::string& settings, bool resume,
         VideoReader& reader)
        : plan_(plan) {
        if (!plan.resumable) {
            plain_.emplace(plan.output, options, &reader);
            return;
        }
        ResumableVideoOptions resumable;
        resumable.settings = settings;
        resumable.resume = resume;
        resumable.segmentFrames = kUsualSegmentFrames;
        if (options.frameRate.isKnown()) {
            resumable.segmentFrames = static_cast<int>(
                std::clamp<double>(std::round(options.frameRate.value() * kSegmentSeconds),
                                   kLeastSegmentFrames, kMostSegmentFrames));
        }
        VideoReader probe(plan.input, plan.part);
        segments_.emplace(plan.output, options, resumable, &probe);
    }

    KeptVideo kept() const { return segments_ ? segments_->kept() : KeptVideo(); }
    bool wantsState(std::int64_t frame) const { return segments_ && segments_->endsSegment(frame); }
    void write(const PipelineFrame& frame) {
        if (segments_) {
            segments_->write(frame.result, frame.state);
        } else {
            plain_->write(frame.result);
        }
    }
    void finish(bool complete) {
        if (plain_) {
            plain_->finish();
            return;
        }
        VideoReader again(plan_.input, plan_.part);
        segments_->finish(&again, complete);
    }
    const Notes& notes() const { return segments_ ? segments_->notes() : plain_->notes(); }

  private:
    const Plan& plan_;
    std::optional<VideoWriter> plain_;
    std::optional<ResumableVideoWriter> segments_;
};

// --- reports ---------------------------------------------------------------------------------

std::string fixed(double value, int decimals) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
    return text;
}

std::string factsText(const VideoFacts& facts) {
    std::string text =
        std::to_string(facts.size.width) + " x " + std::to_string(facts.size.height) + " px";
    if (facts.averageRate.isKnown()) text += ", " + fixed(facts.averageRate.value(), 2) + " fps";
    if (facts.duration) text += ", " + clockText(*facts.duration);
    text += ", " + facts.codec;
    for (const VideoStreamFacts& stream : facts.streams) {
        if (stream.kind == StreamKind::Audio) text += ", sound " + stream.codec;
        if (stream.kind == StreamKind::Subtitle) text += ", subtitles " + stream.codec;
    }
    return text;
}

struct Tally {
    std::int64_t frames = 0;
    std::int64_t inferences = 0;
    std::int64_t repeated = 0;
    std::vector<double> cuts; // s
    double end = 0;           // s
};

Json stagesJson(const PipelineReport& report) {
    Json stages = Json::array();
    for (const StageReport& stage : report.stages) {
        const double frames = std::max<double>(1, static_cast<double>(stage.frames));
        stages.push_back({{"name", stage.name},
                          {"frames", stage.frames},
                          {"millisecondsPerFrame", 1000 * stage.seconds / frames},
                          {"longestMilliseconds", 1000 * stage.longest}});
    }
    return stages;
}

// --- the run ---------------------------------------------------------------------------------

VideoDepthOptions depthOptions(const CommandLine& commandLine, const VideoProfile& profile,
                               const DepthSource& source) {
    VideoDepthOptions options;
    options.every = profile.depthEvery;
    if (const auto every = commandLine.value("depth-every")) {
        options.every = *every == "auto" ? 0 : *commandLine.wholeNumber("depth-every", 1, 1000);
    }
    const bool given = source.fromFiles() || source.rgbdSide();
    if (given) {
        if (commandLine.has("depth-every")) {
            throw UsageError("--depth-every is about a network, but depth is given; expected it "
                             "without");
        }
        options.every = 1;
    }
    return options;
}

// The panel's own quilt layout, or that of a quilt video.
QuiltLayout layoutOf(const CommandLine& commandLine, const Plan& plan, const Display& display,
                     const VideoFacts& facts, Messages& messages) {
    return plan.fromQuilt ? chooseQuilt(commandLine, display, messages, plan.input, facts.size)
                          : chooseQuilt(commandLine, display, messages);
}

int run(const CommandLine& commandLine, Messages& messages) {
    const bool jsonProgress = VideoProgress::json(commandLine);
    if (jsonProgress) messages.leaveStandardOutput();
    const VideoProfile profile = videoProfile(commandLine);
    Plan plan = planRun(commandLine);
    ViewOptions views = viewOptions(commandLine);
    if (!commandLine.has("method") && !commandLine.has("g")) views.method = profile.method;
    const FitMode fit = fitOption(commandLine, FitMode::Cover);
    VideoWriterOptions encoding = encoderOptions(commandLine, profile);
    NativeRoad::check(commandLine);
    const Display display = findDisplay(commandLine, messages);
    plan.part.threads = std::min(cv::getNumThreads(), 16);
    VideoReader reader(plan.input, plan.part);
    const VideoFacts& facts = reader.facts();
    messages.say((plan.input == "-" ? "standard input" : plan.input.string()) + ": " +
                 factsText(facts));
    const QuiltLayout layout = layoutOf(commandLine, plan, display, facts, messages);
    if (plan.product == Product::Quilt) {
        plan.output = quiltFileName(plan.output, layout, display.panelAspect());
    }
    Outputs outputs(commandLine.has("y") || commandLine.has("resume"));
    for (const fs::path& file : display.files)
        outputs.addInput(file);
    for (const fs::path& file : {plan.input, plan.depth}) {
        if (!file.empty() && file != "-") outputs.addInput(file);
    }
    for (const char* option : {"n", "net-profile"}) {
        if (const auto file = commandLine.value(option)) outputs.addInput(*file);
    }
    outputs.addOutput(plan.output);
    if (!plan.report.empty()) outputs.addOutput(plan.report);
    outputs.check();

    // what every frame passes through
    const bool native = plan.product == Product::Native;
    std::optional<DepthStage> depth;
    std::optional<RenderStage> render;
    std::optional<QuiltStage> quilts;
    if (native) messages.say("quilt: " + layout.text());
    if (plan.fromQuilt) {
        quilts.emplace(commandLine, display, layout, messages);
        encoding.size = display.panelSize;
    } else {
        DepthSource source(commandLine, messages, Medium::Video);
        const VideoDepthOptions options = depthOptions(commandLine, profile, source);
        const double aspect =
            seenAspect(facts) *
            (!source.rgbdSide()                                                                ? 1
             : *source.rgbdSide() == DepthSide::Left || *source.rgbdSide() == DepthSide::Right ? 0.5
                                                                                               : 2);
        cv::Size photo = facts.size;
        if (source.rgbdSide() == DepthSide::Left || source.rgbdSide() == DepthSide::Right) {
            photo.width /= 2;
        } else if (source.rgbdSide()) {
            photo.height /= 2;
        }
        depth.emplace(plan, facts, std::move(source), options);
        render.emplace(commandLine, display, layout, views, profile, plan.product, fit, aspect,
                       messages);
        encoding.size = render->size(photo);
    }
    takeTimes(facts, encoding);
    encoding.threads = cv::getNumThreads();
    if (native && encoding.compatible) {
        messages.warn("--compat halves the colour resolution (4:2:0): in a Native neighbouring "
                      "sub-pixels belong to different views, so views are mixed and depth blurs; "
                      "use it only for players that refuse the usual file");
    }
    if (!native)
        encoding.compatible =
            encoding.codec == VideoCodec::H264 || encoding.codec == VideoCodec::Hevc;
    if (commandLine.has("y") && !commandLine.has("resume") && plan.resumable) {
        ResumableVideoWriter::discard(plan.output);
    }
    Sink sink(plan, encoding, settingsText(commandLine, plan, display), commandLine.has("resume"),
              reader);
    messages.warn(sink.notes());
    const KeptVideo kept = sink.kept();
    if (kept.frames > 0) {
        const double unit = facts.timeBase.value();
        messages.say("goes on at " + clockText(static_cast<double>(kept.nextPts) * unit) + ", " +
                     std::to_string(kept.frames) + " frames are there");
        if (depth && !kept.state.empty()) depth->depth().setState(kept.state);
        reader.skipTo(kept.nextPts);
    }

    const double unit = facts.timeBase.value();
    std::optional<double> length;
    if (facts.duration) length = std::min(*facts.duration, plan.part.to) - plan.part.from;
    Tally tally;
    tally.frames = kept.frames;
    tally.end = static_cast<double>(kept.nextPts) * unit;
    VideoProgress progress(jsonProgress, facts.frameCount, length, kept.frames);
    std::signal(SIGINT, stopOnce);
    std::signal(SIGTERM, stopOnce);

    std::vector<PipelineStage> stages;
    stages.push_back({"decode", [&](PipelineFrame& frame) {
                          if (stopWanted.load() || !reader.read(frame.source)) return false;
                          frame.number += kept.frames;
                          return true;
                      }});
    if (depth) {
        stages.push_back({"depth", [&](PipelineFrame& frame) {
                              depth->work(frame);
                              if (sink.wantsState(frame.number))
                                  frame.state = depth->depth().state();
                              return true;
                          }});
    }
    stages.push_back({"render", [&](PipelineFrame& frame) {
                          if (quilts) {
                              quilts->work(frame);
                          } else {
                              render->work(frame);
                          }
                          frame.result.pts = frame.source.pts;
                          frame.result.duration = frame.source.duration;
                          return true;
                      }});
    stages.push_back({"encode", [&](PipelineFrame& frame) {
                          sink.write(frame);
                          ++tally.frames;
                          tally.inferences += frame.step.inferred ? 1 : 0;
                          tally.repeated += frame.step.repeated ? 1 : 0;
                          if (frame.step.cut && frame.number > 0) {
                              tally.cuts.push_back(static_cast<double>(frame.source.pts) * unit);
                          }
                          tally.end =
                              static_cast<double>(frame.source.pts + frame.source.duration) * unit;
                          progress.frame(tally.end);
                          return true;
                      }});
    PipelineOptions pipeline;
    pipeline.threads = !commandLine.has("in-turn");
    pipeline.dropLate = !plan.resumable && plan.input != "-";
    PipelineReport report;
    try {
        report = runPipeline(stages, pipeline);
    } catch (...) {
        progress.clear();
        if (plan.resumable && tally.frames > 0) {
            messages.say("what is made so far is kept in " +
                         ResumableVideoWriter::partsDirectory(plan.output).string() +
                         "; --resume goes on");
        }
        throw;
    }
    const bool stopped = stopWanted.load();
    if (tally.frames == 0) {
        throw Error(ErrorCode::BadFormat, plan.input.string(),
                    stopped ? "was stopped before the first frame"
                            : "holds no frames in this part, expected some");
    }
    sink.finish(!stopped);
    const VideoReadCounts& counts = reader.counts();
    progress.end(stopped ? "stopped" : counts.truncated ? "truncated" : "done");
    std::string cutOff; // that the video is, as its reader says it
    for (const std::string& note : reader.notes()) {
        const bool isIt = counts.truncated && note.find("is cut off") != std::string::npos;
        if (isIt) {
            cutOff = note;
        } else {
            messages.warn(note);
        }
    }
    if (depth) depth->tell(messages);
    if (depth && native) {
        const AdjacentParallax parallax =
            adjacentParallax(views, layout, display.panelSize, {0, 1});
        if (parallax.viewPixels > kParallaxBudgetPixels) {
            messages.warn("parallax between adjacent views is up to " +
                          fixed(parallax.viewPixels, 1) + " view px, above " +
                          fixed(kParallaxBudgetPixels, 0) +
                          ": hard edges will show double; lower --strength or move --focus");
        }
    }

    const std::int64_t made = tally.frames - kept.frames;
    const double rate = report.seconds > 0 ? static_cast<double>(made) / report.seconds : 0;
    constexpr const char* kProducts[] = {"Native", "quilt", "RGB-D"};
    messages.say(plan.output.string() + ": " + kProducts[static_cast<int>(plan.product)] +
                 " video, " + std::to_string(encoding.size.width) + " x " +
                 std::to_string(encoding.size.height) + " px, " + std::to_string(tally.frames) +
                 " frames, " + clockText(tally.end) + "; " + fixed(rate, 1) + " fps");
    std::string times;
    for (const StageReport& stage : report.stages) {
        times +=
            (times.empty() ? "" : ", ") + stage.name + " " +
            fixed(1000 * stage.seconds / std::max<double>(1, static_cast<double>(stage.frames)),
                  1) +
            " ms";
    }
    messages.detail("a frame takes: " + times);
    if (depth) {
        messages.detail("depth was inferred for " + std::to_string(tally.inferences) + " of " +
                        std::to_string(made) + " frames, " + std::to_string(tally.cuts.size()) +
                        " scene cuts, " + std::to_string(tally.repeated) + " repeated frames");
    }
    if (report.dropped > 0) {
        messages.say(std::to_string(report.dropped) + " frames came too fast and were left out");
    }
    if (!plan.report.empty()) {
        Json json = {{"tool", commandLine.name()},
                     {"version", ALTIRO3D_VERSION},
                     {"openCv", CV_VERSION},
                     {"threads", cv::getNumThreads()},
                     {"input", plan.input.string()},
                     {"output", plan.output.string()},
                     {"state", stopped            ? "stopped"
                               : counts.truncated ? "truncated"
                                                  : "done"},
                     {"width", encoding.size.width},
                     {"height", encoding.size.height},
                     {"frames", tally.frames},
                     {"framesOfThisRun", made},
                     {"duration", tally.end},
                     {"seconds", report.seconds},
                     {"framesPerSecond", rate},
                     {"stages", stagesJson(report)},
                     {"inferences", tally.inferences},
                     {"repeatedFrames", tally.repeated},
                     {"droppedFrames", report.dropped},
                     {"sceneCuts", tally.cuts},
                     {"corruptFrames", counts.corrupt},
                     {"repairedTimes", counts.repairedTimes},
                     {"truncated", counts.truncated},
                     {"peakMegabytes", peakMegabytes()}};
        Json settings = {{"profile", profile.name},
                         {"display", display.source},
                         {"quilt", layout.text()},
                         {"encoder", {{"preset", encoding.preset}, {"crf", encoding.crf}}}};
        if (render) {
            settings["method"] = methodName(views.method);
            settings["strengthPercent"] = views.strengthPercent;
            settings["focus"] = views.focus;
            settings["road"] = render->roadName();
            settings["continuous"] = render->continuous();
            settings["depth"] = depth->source().description();
            settings["depthEvery"] = depth->options().every; // 0: as pictures need it
            if (const DepthNetwork* network = depth->source().network()) {
                settings["networkSize"] = {network->inputSize().width, network->inputSize().height};
            }
        }
        for (const auto& [option, value] : commandLine.given())
            settings["given"][option] = value;
        json["settings"] = settings;
        json["warnings"] = messages.warnings();
        writeFile(plan.report, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
    }
    if (stopped) {
        messages.warn("stopped at " + clockText(tally.end) + "; " + plan.output.string() +
                      " is whole up to there" +
                      (plan.resumable ? ", --resume goes on" : std::string()));
        return kExitStopped;
    }
    if (counts.truncated) {
        messages.flushWarnings();
        messages.fail(cutOff + "; what is there was converted");
        return kExitFailed;
    }
    return kExitDone;
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine("video2native",
                            "Turns a flat video into a Native video for a light-field display: "
                            "depth is estimated (or given) and kept steady, every sub-pixel of the "
                            "panel shows its own view; sound, subtitles and chapters are kept.");
    commandLine.addUsage("[options] IN OUT.mp4");
    commandLine.addUsage("[options] --rgbd right RGBD.mp4 OUT.mp4");
    commandLine.addUsage("[options] --depth DEPTH IN OUT.mp4");
    commandLine.addUsage("[options] --from-quilt QUILT_qs8x6a0.75.mp4 OUT.mp4");
    commandLine.addUsage("--profile live /dev/video0 OUT.mkv");
    commandLine.addSection("Profile");
    addProfileOption(commandLine);
    addDepthOptions(commandLine, Medium::Video);
    commandLine.add({"depth-every"},
                    "Run the network on every N-th frame and carry its depth along the motion in "
                    "between; auto (default): as often as the picture needs it; 1: on all.",
                    "N");
    addViewOptions(commandLine);
    NativeRoad::add(commandLine);
    addFitOption(commandLine, "cover");
    commandLine.addSection("Input");
    commandLine.add({"from-quilt"}, "The frames of IN are quilts.");
    addVideoInputOptions(commandLine);
    commandLine.addSection("Output");
    commandLine.add({"quilt"}, "Write a quilt video (named ..._qs<columns>x<rows>a<aspect>, 4:2:0) "
                               "for other players, not a Native.");
    commandLine.add({"rgbd-out"}, "Write frame and depth side by side (4:2:0), not a Native.");
    addEncoderOptions(commandLine);
    commandLine.add({"resume"}, "Go on where an earlier run of the same command ended.");
    commandLine.add({"y"}, "Replace outputs that exist, and begin again.");
    VideoProgress::add(commandLine);
    commandLine.add({"report"}, "Write settings, counts and the time of each stage, for programs.",
                    "FILE.json");
    commandLine.add({"in-turn"}, "Do one step after the other, not side by side; for comparison.");
    addDisplayOptions(commandLine, "layout"); // --quilt is the video
    addSamplingOptions(commandLine);
    commandLine.addNote("IN is anything that FFmpeg reads, - for standard input, or a capture "
                        "device. Ctrl-C ends the file properly (exit status 130); a run that dies "
                        "leaves OUT.parts, and the same command with --resume goes on.");
    return runTool(argc, argv, commandLine, run);
}
