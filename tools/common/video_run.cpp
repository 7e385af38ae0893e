#include "common/video_run.hpp"

#include "altiro3D/altiro3D.hpp"
#include "common/depth_options.hpp"
#include "common/display_options.hpp"
#include "common/display_player.hpp"
#include "common/picture_options.hpp"
#include "common/run_tool.hpp"
#include "common/video_options.hpp"
#include "common/video_plan.hpp"
#include "common/video_progress.hpp"
#include "common/video_sink.hpp"
#include "common/video_stages.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <functional>
#include <malloc.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <thread>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr int kExitStopped = 130; // as shells call it

// --- the user's stop -------------------------------------------------------------------------

std::atomic<bool> stopWanted{false};

// The first signal ends the video properly; a second one ends the process.
extern "C" void stopOnce(int signal) {
    stopWanted.store(true);
    std::signal(signal, SIG_DFL);
}

// --- reports ---------------------------------------------------------------------------------

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
                               const ChosenDepth& source) {
    VideoDepthOptions options;
    options.every = profile.depthEvery;
    if (const auto every = commandLine.value("depth-every")) {
        options.every = *every == "auto" ? 0 : *commandLine.wholeNumber("depth-every", 1, 1000);
    }
    const bool given = source.fromFiles() || source.rgbdSide();
    if (given) {
        if (commandLine.has("depth-every")) {
            throw UsageError("--depth-every says how often depth is estimated, but here it is "
                             "given; leave it out");
        }
        options.every = 1;
    }
    return options;
}

// All that a run works with.
struct Studio {
    VideoProfile profile;
    VideoPlan plan;
    ChosenDisplay display;
    ViewOptions views;
    QuiltLayout layout;
    std::unique_ptr<VideoReader> reader;
    std::optional<DepthStage> depth;
    std::optional<RenderStage> render;
    std::optional<QuiltStage> quilts; // instead of depth and render
    cv::Size size;                    // of what is written

    double unit() const { return reader->facts().timeBase.value(); }
};

// A picture opens as a video of one frame; who asks for that says so by --input-...
void refusePicture(const CommandLine& commandLine, const VideoPlan& plan, const VideoFacts& facts) {
    std::error_code error;
    if (!fs::is_regular_file(plan.input, error) || commandLine.has("input-format") ||
        commandLine.has("input-options") || !isPicture(plan.input, facts)) {
        return;
    }
    throw UsageError(plan.inputName() + ": is a picture, expected a video; " +
                     (plan.fromQuilt
                          ? "quilt2native makes a Native picture of it if OUT is named as one"
                          : "photo2native makes a Native of a photo"));
}

// Videos carry no mark; ordinary ones have no 4:4:4 at the very size of a panel.
void warnIfNative(const VideoFacts& facts, const ChosenDisplay& display, Messages& messages) {
    const bool fullColour = facts.pixelFormat.find("444") != std::string::npos ||
                            facts.pixelFormat.find("gbr") != std::string::npos;
    if (facts.size != display.panelSize() || !fullColour) return;
    messages.warn("the video has the panel's size and 4:4:4 colour, like a Native video; do not "
                  "convert a Native again");
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

// Opens everything but the output; all that can be said against the call is said here.
void openStudio(const CommandLine& commandLine, Studio& studio, Messages& messages) {
    VideoPlan& plan = studio.plan;
    studio.profile = videoProfile(commandLine);
    if (plan.show && !commandLine.has("profile")) studio.profile = videoProfile("live");
    studio.views = viewOptions(commandLine);
    if (!commandLine.has("method") && !commandLine.has("g")) {
        studio.views.method = studio.profile.method;
    }
    if (!plan.fromQuilt) requireKnobsOf(commandLine, studio.views.method);
    RenderStage::Settings settings;
    settings.fit = fitOption(commandLine, FitMode::Cover);
    checkNativeOptions(commandLine);
    studio.display = findDisplay(commandLine, messages, {}, useOf(plan.product));
    plan.part.threads = std::min(cv::getNumThreads(), 16);
    studio.reader = std::make_unique<VideoReader>(plan.input, plan.part);
    const VideoFacts& facts = studio.reader->facts();
    refusePicture(commandLine, plan, facts);
    messages.say(studio.plan.inputName() + ": " + factsText(facts));
    if (!plan.fromQuilt) warnIfQuilt(plan.input, "--from-quilt", messages);
    if (plan.product == VideoProduct::Native) warnIfNative(facts, studio.display, messages);
    studio.layout = plan.fromQuilt
                        ? chooseQuilt(commandLine, studio.display, messages, plan.input, facts.size)
                        : chooseQuilt(commandLine, studio.display, messages);
    if (plan.product == VideoProduct::Quilt && !commandLine.has("r") && !studio.display.map) {
        cv::Size& tile = studio.layout.tileSize; // 4:2:0 has even sides only
        tile = {std::max(2, tile.width / 2 * 2), std::max(2, tile.height / 2 * 2)};
    }
    if (plan.product == VideoProduct::Quilt) {
        plan.output = quiltFileName(plan.output, studio.layout, studio.display.aspect());
    }
    checkOutputs(commandLine, plan, studio.display);
    if (plan.fromQuilt) {
        const QuiltShape shape(plan.input, studio.layout, studio.display, fitOption(commandLine));
        messages.say("quilt: " + quiltText(studio.layout, shape.shownAspect()));
        tellShape(shape, messages);
        studio.quilts.emplace(commandLine, studio.display, studio.layout, shape, messages);
        studio.size = studio.display.panelSize();
        return;
    }
    if (plan.product == VideoProduct::Native)
        messages.say("quilt: " + quiltText(studio.layout, studio.display.aspect()));
    ChosenDepth source(commandLine, messages, Medium::Video);
    const VideoDepthOptions options = depthOptions(commandLine, studio.profile, source);
    studio.depth.emplace(plan.depth, plan.part, facts, std::move(source), options);
    settings.layout = studio.layout;
    settings.views = studio.views;
    settings.product = plan.product;
    settings.keep = nativeOptions(commandLine).keepResolution || studio.profile.keep;
    settings.continuous = studio.profile.keep;
    const double aspect = facts.sampleAspect.value() * facts.size.width / facts.size.height;
    studio.render.emplace(commandLine, studio.display, settings,
                          studio.depth->photoSize(facts.size), studio.depth->photoAspect(aspect),
                          messages);
    studio.size = studio.render->size();
}

// The stages between reading and writing.
// @param wantsState whether the state after a frame of that number is to be kept
std::vector<PipelineStage> middleStages(Studio& studio,
                                        const std::function<bool(std::int64_t)>& wantsState) {
    std::vector<PipelineStage> stages;
    if (studio.depth) {
        stages.push_back({"depth", [&studio, wantsState](PipelineFrame& frame) {
                              studio.depth->work(frame);
                              if (wantsState(frame.number)) frame.state = studio.depth->state();
                              return true;
                          }});
    }
    stages.push_back({"render", [&studio](PipelineFrame& frame) {
                          if (studio.quilts) {
                              studio.quilts->work(frame);
                          } else {
                              studio.render->work(frame);
                          }
                          frame.result.pts = frame.source.pts;
                          frame.result.duration = frame.source.duration;
                          return true;
                      }});
    return stages;
}

VideoWriterOptions encodingOf(const CommandLine& commandLine, const Studio& studio,
                              Messages& messages) {
    VideoWriterOptions encoding = encoderOptions(commandLine, studio.profile);
    const bool native = studio.plan.product == VideoProduct::Native;
    if (native && encoding.compatible) {
        messages.warn("--compat halves the colour resolution (4:2:0): in a Native neighbouring "
                      "sub-pixels belong to different views, so views are mixed and depth blurs; "
                      "use it only for players that refuse the usual file");
    }
    const bool mayBe = encoding.codec == VideoCodec::H264 || encoding.codec == VideoCodec::Hevc;
    if (!native) encoding.compatible = mayBe;
    encoding.size = studio.size;
    takeTimes(studio.reader->facts(), encoding);
    encoding.threads = cv::getNumThreads();
    return encoding;
}

// What a run has made.
struct Result {
    Tally tally;
    PipelineReport pipeline;
    double finishSeconds = 0; // after the pipeline: the encoder's last frames, joining the segments
    VideoWriterOptions encoding;
    std::int64_t keptFrames = 0;
    bool stopped = false;
    bool keepsWork = false; // what a later run can go on from
    bool failed = false;
    std::string cutOff; // that the video is, as its reader says it

    std::int64_t made() const { return tally.frames - keptFrames; }
    double seconds() const { return pipeline.seconds + finishSeconds; }
    double rate() const { return seconds() > 0 ? static_cast<double>(made()) / seconds() : 0; }
    const char* state() const {
        return stopped ? "stopped" : cutOff.empty() ? "done" : "truncated";
    }
};

void count(const PipelineFrame& frame, double unit, Tally& tally) {
    ++tally.frames;
    tally.inferences += frame.step.inferred ? 1 : 0;
    tally.repeated += frame.step.repeated ? 1 : 0;
    if (frame.step.cut && frame.number > 0) {
        tally.cuts.push_back(static_cast<double>(frame.source.pts) * unit);
    }
    tally.end = static_cast<double>(frame.source.pts + frame.source.duration) * unit;
}

// What the readers have to say in the end.
void tellRemarks(const CommandLine& commandLine, const Studio& studio, Result& result,
                 Messages& messages) {
    result.cutOff = tellNotes(*studio.reader, messages);
    if (studio.quilts) studio.quilts->tell(messages);
    if (!studio.depth) return;
    studio.depth->tell(messages);
    if (studio.plan.product != VideoProduct::Native) return;
    warnAboutParallax(
        commandLine,
        adjacentParallax(studio.views, studio.layout, studio.display.panelSize(), {0, 1}),
        messages);
}

[[noreturn]] void failEmpty(const VideoPlan& plan, const VideoFacts& facts, bool stopped) {
    if (stopped) {
        throw Error(ErrorCode::BadFormat, plan.inputName(), "was stopped before the first frame");
    }
    std::string problem = "holds no frames in this part, expected some";
    if (facts.duration && plan.part.from >= *facts.duration)
        problem += " (it ends at " + clockText(*facts.duration) + ")";
    throw Error(ErrorCode::BadFormat, plan.inputName(), problem);
}

// Makes the file.
Result convert(const CommandLine& commandLine, Studio& studio, bool jsonProgress,
               Messages& messages) {
    const VideoPlan& plan = studio.plan;
    VideoReader& reader = *studio.reader;
    const VideoFacts& facts = reader.facts();
    const double unit = studio.unit();
    Result result;
    result.encoding = encodingOf(commandLine, studio, messages);
    if (commandLine.has("y") && !commandLine.has("resume") && plan.isFile) {
        ResumableVideoWriter::discard(plan.output);
    }
    VideoSink sink(plan, result.encoding,
                   settingsText(commandLine, plan, studio.layout, studio.display,
                                studio.depth ? &studio.depth->source() : nullptr),
                   commandLine.has("resume"), reader);
    messages.warn(sink.notes());
    if (result.encoding.preset != "ultrafast" && result.encoding.preset != "superfast") {
        // x264's slower presets read memory they have not set: all of it is 0 from here on, or a
        // run that is resumed would not give the bytes of one that was not interrupted.
        mallopt(M_PERTURB, 0xff);
    }
    if (studio.depth) studio.depth->begin(reader);
    const KeptVideo kept = sink.kept();
    Tally& tally = result.tally;
    if (kept.frames > 0) {
        result.keptFrames = kept.frames;
        tally.frames = kept.frames;
        tally.end = static_cast<double>(kept.nextPts) * unit;
        messages.say("continues at " + clockText(tally.end) +
                     "; already made: " + counted(kept.frames, "frame"));
        if (studio.depth && !kept.state.empty()) studio.depth->setState(kept.state);
        reader.skipTo(kept.nextPts);
    } else if (commandLine.has("resume")) {
        messages.say("no earlier run was found; starts from the beginning");
    }
    std::optional<double> length;
    if (facts.duration) length = std::min(*facts.duration, plan.part.to) - plan.part.from;
    const bool whole = plan.part.from <= 0 && !std::isfinite(plan.part.to);
    VideoProgress progress(jsonProgress, whole ? facts.frameCount : std::nullopt, length,
                           kept.frames, tally.end);

    std::vector<PipelineStage> stages =
        middleStages(studio, [&sink](std::int64_t frame) { return sink.wantsState(frame); });
    stages.insert(stages.begin(), {"decode", [&](PipelineFrame& frame) {
                                       if (stopWanted.load() || !reader.read(frame.source))
                                           return false;
                                       frame.number += kept.frames;
                                       return true;
                                   }});
    stages.push_back({"encode", [&](PipelineFrame& frame) {
                          sink.write(frame);
                          count(frame, unit, tally);
                          progress.frame(tally.end);
                          return true;
                      }});
    PipelineOptions options;
    options.dropLate = facts.isDevice;
    try {
        result.pipeline = runPipeline(stages, options);
        result.stopped = stopWanted.load();
        if (tally.frames == 0) failEmpty(plan, facts, result.stopped);
        progress.finishing();
        const auto start = std::chrono::steady_clock::now();
        sink.finish(!result.stopped);
        result.keepsWork = sink.keepsWork();
        const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
        result.finishSeconds = time.count();
    } catch (...) {
        progress.clear();
        if (sink.keepsWork()) {
            messages.say("the frames so far are kept in " +
                         ResumableVideoWriter::partsDirectory(plan.output).string() +
                         "; --resume continues");
        }
        throw;
    }
    tellRemarks(commandLine, studio, result, messages);
    progress.end(result.state());
    constexpr const char* kProducts[] = {"Native", "quilt", "RGB-D"};
    messages.say(plan.output.string() + ": " + kProducts[static_cast<int>(plan.product)] +
                 " video, " + sizeText(studio.size) + ", " + counted(tally.frames, "frame") + ", " +
                 clockText(tally.end) + "; " + fixed(result.rate(), 1) + " fps");
    return result;
}

// Shows the video on the display, at its own pace; what is too slow is left out.
Result show(const CommandLine& commandLine, Studio& studio, Messages& messages) {
    VideoReader& reader = *studio.reader;
    const double unit = studio.unit();
    DisplayPlayer screen(commandLine, studio.display);
    Result result;
    std::atomic<bool> left{false};
    std::optional<std::chrono::steady_clock::time_point> start;
    if (studio.depth) studio.depth->begin(reader);
    std::vector<PipelineStage> stages = middleStages(studio, [](std::int64_t) { return false; });
    stages.insert(
        stages.begin(),
        {"decode", [&](PipelineFrame& frame) {
             if (stopWanted.load() || left.load() || !reader.read(frame.source)) return false;
             const auto now = std::chrono::steady_clock::now();
             const std::chrono::duration<double> time(static_cast<double>(frame.source.pts) * unit);
             if (!start) start = now;
             std::this_thread::sleep_until(
                 *start + std::chrono::duration_cast<std::chrono::steady_clock::duration>(time));
             return true;
         }});
    stages.push_back({"show", [&](PipelineFrame& frame) {
                          if (left.load()) return true;
                          if (!screen.show(frame.result.picture)) left.store(true);
                          count(frame, unit, result.tally);
                          return true;
                      }});
    PipelineOptions options;
    options.queueFrames = 1;
    options.dropLate = true;
    result.pipeline = runPipeline(stages, options);
    const int status = screen.end();
    result.stopped = stopWanted.load();
    if (status == DisplayPlayer::kCrashed && !result.stopped) {
        throw Error(ErrorCode::WriteFailed, "altiro3Dview",
                    "ended unexpectedly, expected it to show the video");
    }
    result.failed = status != kExitDone && !result.stopped; // and altiro3Dview has said why
    if (result.failed) return result;
    tellRemarks(commandLine, studio, result, messages);
    messages.say(studio.plan.inputName() + ": " + counted(result.tally.frames, "frame") +
                 " shown, " + std::to_string(result.pipeline.dropped) + " dropped; " +
                 fixed(result.rate(), 1) + " fps");
    return result;
}

Json reportOf(const CommandLine& commandLine, const Studio& studio, const Result& result,
              const Messages& messages) {
    const Tally& tally = result.tally;
    const VideoReadCounts& counts = studio.reader->counts();
    Json json = {{"tool", commandLine.name()},
                 {"version", version()},
                 {"openCv", CV_VERSION},
                 {"threads", cv::getNumThreads()},
                 {"input", studio.plan.input.string()},
                 {"output", studio.plan.output.string()},
                 {"state", result.state()},
                 {"width", studio.size.width},
                 {"height", studio.size.height},
                 {"frames", tally.frames},
                 {"framesOfThisRun", result.made()},
                 {"duration", tally.end},
                 {"seconds", result.seconds()},
                 {"finishSeconds", result.finishSeconds},
                 {"framesPerSecond", result.rate()},
                 {"stages", stagesJson(result.pipeline)},
                 {"inferences", tally.inferences},
                 {"repeatedFrames", tally.repeated},
                 {"droppedFrames", result.pipeline.dropped},
                 {"sceneCuts", tally.cuts},
                 {"corruptFrames", counts.corrupt},
                 {"repairedTimes", counts.repairedTimes},
                 {"truncated", counts.truncated},
                 {"peakMegabytes", peakMegabytes()}};
    Json settings = {
        {"profile", studio.profile.name},
        {"display", studio.display.source},
        {"quilt", studio.layout.text()},
        {"encoder", {{"preset", result.encoding.preset}, {"crf", result.encoding.crf}}}};
    if (studio.render) {
        settings["method"] = methodName(studio.views.method);
        settings["strengthPercent"] = studio.views.strengthPercent;
        settings["focus"] = studio.views.focus;
        settings["road"] = studio.render->pathName();
        settings["continuous"] = studio.render->continuous();
        settings["depth"] = studio.depth->source().description();
        settings["depthEvery"] = studio.depth->options().every; // 0: as pictures need it
        if (const DepthNetwork* network = studio.depth->source().network()) {
            settings["networkSize"] = {network->inputSize().width, network->inputSize().height};
        }
    }
    for (const auto& [option, value] : commandLine.given())
        settings["given"][option] = value;
    json["settings"] = settings;
    json["warnings"] = messages.warnings();
    return json;
}

void tellDetails(const Studio& studio, const Result& result, Messages& messages) {
    std::string times;
    for (const StageReport& stage : result.pipeline.stages) {
        const double frames = std::max<double>(1, static_cast<double>(stage.frames));
        times += (times.empty() ? "" : ", ") + stage.name + " " +
                 fixed(1000 * stage.seconds / frames, 1) + " ms";
    }
    messages.detail("a frame takes: " + times);
    if (!studio.plan.show)
        messages.detail("finishing the file took " + fixed(result.finishSeconds, 1) + " s");
    const Tally& tally = result.tally;
    if (studio.depth) {
        messages.detail("depth was inferred for " + std::to_string(tally.inferences) + " of " +
                        std::to_string(result.made()) + " frames, " +
                        std::to_string(tally.cuts.size()) + " scene cuts, " +
                        std::to_string(tally.repeated) + " repeated frames");
    }
    if (!studio.plan.show && result.pipeline.dropped > 0) {
        messages.say(counted(result.pipeline.dropped, "frame") +
                     " came too fast and were left out");
    }
}

} // namespace

int runVideo(const CommandLine& commandLine, const VideoPlan& plan, Messages& messages) {
    const bool jsonProgress = VideoProgress::json(commandLine);
    if (jsonProgress) messages.leaveStandardOutput();
    Studio studio;
    studio.plan = plan;
    openStudio(commandLine, studio, messages);
    std::signal(SIGINT, stopOnce);
    std::signal(SIGTERM, stopOnce);
    const Result result = studio.plan.show ? show(commandLine, studio, messages)
                                           : convert(commandLine, studio, jsonProgress, messages);
    if (result.failed) return kExitFailed;
    tellDetails(studio, result, messages);
    if (!plan.report.empty()) {
        writeFile(plan.report, reportOf(commandLine, studio, result, messages)
                                       .dump(2, ' ', false, Json::error_handler_t::replace) +
                                   "\n");
    }
    if (result.stopped) {
        std::string line = "stopped at " + clockText(result.tally.end);
        if (!plan.show) line += "; " + studio.plan.output.string() + " is whole up to there";
        if (result.keepsWork) line += ", --resume continues";
        messages.warn(line);
        return kExitStopped;
    }
    if (!result.cutOff.empty() && !plan.show) {
        messages.flushWarnings();
        messages.fail(result.cutOff);
        return kExitFailed;
    }
    return kExitDone;
}

} // namespace altiro3D::tools
