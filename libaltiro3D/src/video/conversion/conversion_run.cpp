#include "video/conversion/conversion_run.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "media/run_settings.hpp"
#include "media/video_picture.hpp"
#include "video/conversion/conversion_stamp.hpp"
#include "video/conversion/given_depth.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <thread>

namespace altiro3D {

namespace {

std::string nameOf(const std::filesystem::path& input) {
    return input == "-" ? "standard input" : input.string();
}

// The output replaces a file, which must not be one that is read.
void refuseInputAsOutput(const VideoConversion& conversion, const std::filesystem::path& input,
                         const char* what) {
    std::error_code error;
    if (conversion.output.empty() || !std::filesystem::equivalent(conversion.output, input, error))
        return;
    throw Error(ErrorCode::InvalidArgument, conversion.output.string(),
                std::string("is also the ") + what + ", expected another file");
}

void checkFields(const VideoConversion& conversion) {
    check(conversion.output.empty() == static_cast<bool>(conversion.show), "output",
          conversion.show ? "is set beside show, expected one of them"
                          : "is empty, expected a file or a function show");
    refuseInputAsOutput(conversion, conversion.input, "input");
    if (conversion.given) refuseInputAsOutput(conversion, conversion.given->source, "depth");
    const bool needsDisplay = conversion.product != VideoProduct::Rgbd;
    check(!needsDisplay || conversion.display || conversion.map, "display",
          "is not set, expected one for Natives and quilts");
    if (conversion.given) {
        check(conversion.given->source.empty() == conversion.given->rgbd.has_value(), "given",
              "depth has a source and an RGB-D layout, or neither, expected one of them");
    }
    check(!conversion.map || (conversion.native.sampling.views == ViewFilter::Nearest &&
                              conversion.native.sampling.inTile == TileSampling::Nearest),
          "sampling", "is linear, but a look-up table holds single px, expected nearest");
    check(!conversion.choices.framing || conversion.native.fit == FitMode::Cover, "framing",
          "cannot be chosen automatically with this fit, expected cover");
    check((conversion.native.framing == Framing() && !conversion.choices.any()) ||
              (!conversion.fromQuilt && conversion.product != VideoProduct::Rgbd),
          "framing", "or an automatic choice is set, expected frames that are rendered as views");
    if (!conversion.fromQuilt) return;
    check(conversion.product == VideoProduct::Native, "product",
          "is not Native, but frames are quilts");
    check(!conversion.given && !conversion.depth, "depth", "is set, but frames are quilts");
    checkNumber(conversion.viewAspect == 0 ||
                    (conversion.viewAspect >= 0.01 && conversion.viewAspect <= 100),
                "viewAspect", conversion.viewAspect, "0.01..100, or 0");
}

// Empty if no picture is made for a display.
VideoTarget targetOf(const VideoConversion& conversion) {
    VideoTarget target;
    if (conversion.map) {
        target = {conversion.map->quilt(), conversion.map->panelSize()};
    } else if (conversion.display) {
        target = {conversion.display->quilt, conversion.display->panelSize()};
    }
    if (conversion.layout) target.layout = *conversion.layout;
    check(!conversion.map || target.layout == conversion.map->quilt(), "layout",
          "is " + target.layout.text() + ", expected that of the map");
    return target;
}

// Sets the range of given depth: that of the interrupted run, or a new one. If the depth is of
// another file now, the settings differ anyway.
void setDepthRange(VideoConversion& conversion) {
    if (!conversion.given || conversion.given->rgbd) return;
    if (conversion.unfinished == UnfinishedRun::Resume && isVideoUnfinished(conversion.output)) {
        const Json run = readRunFile(unfinishedVideoDirectory(conversion.output));
        if (run.contains("settings")) takeDepthRange(conversion, run["settings"]);
    }
    measureRange(*conversion.given);
}

VideoWriterOptions encodingOf(const VideoConversion& conversion, const VideoFacts& facts,
                              cv::Size size) {
    VideoWriterOptions encoding = conversion.encoding;
    if (conversion.product != VideoProduct::Native) {
        encoding.compatible =
            encoding.codec == VideoCodec::H264 || encoding.codec == VideoCodec::Hevc;
    }
    encoding.native = conversion.product == VideoProduct::Native;
    encoding.size = size;
    encoding.timeBase = facts.timeBase;
    encoding.frameRate = facts.averageRate;
    encoding.constantRate = facts.constantRate;
    return encoding;
}

} // namespace

ConversionRun::ConversionRun(VideoConversion given, std::optional<ChunkRange> range)
    : conversion(std::move(given)), range_(std::move(range)) {
    checkFields(conversion);
    const VideoTarget target = targetOf(conversion);
    reader = conversion.reader ? std::move(conversion.reader)
                               : std::make_unique<VideoReader>(conversion.input, conversion.part);
    const VideoFacts& facts = reader->facts();
    unit_ = facts.timeBase.value();
    setDepthRange(conversion);
    if (!conversion.fromQuilt && !conversion.given) {
        if (!conversion.depth) conversion.depth = estimatedDepth();
        conversion.depth->load(); // the stamp describes it
    }
    if (!conversion.show && canReadAgain(conversion.input))
        stamp = conversionStamp(conversion, target.layout);
    if (conversion.fromQuilt) {
        renderer = makeQuiltRenderer(conversion, target);
    } else {
        depth_ = std::make_unique<FrameDepth>(conversion, facts);
        const double aspect = facts.sampleAspect.value() * facts.size.width / facts.size.height;
        renderer = makePhotoRenderer(conversion, target, depth_->photoSize(facts.size),
                                     depth_->photoAspect(facts.size, aspect), depth_->edges());
    }
    encoding = encodingOf(conversion, facts, renderer->size());
    if (range_) {
        encoding.colour = encoding.colour ? encoding.colour : shownColour(facts.colour);
        sink.emplace(*range_, encoding);
        progress.framesInAll = range_->frames;
        return;
    }
    if (!conversion.show) sink.emplace(conversion, encoding, stamp, *reader);

    if (facts.duration)
        progress.length = std::min(*facts.duration, conversion.part.to) - conversion.part.from;
    const bool whole = conversion.part.from <= 0 && !std::isfinite(conversion.part.to);
    if (whole) {
        progress.framesInAll = facts.frameCount;
    } else if (progress.length.value_or(0) > 0 && facts.averageRate.isKnown()) {
        progress.framesInAll = std::llround(*progress.length * facts.averageRate.value());
    }
    if (!sink) return;
    const KeptVideo kept = sink->kept();
    progress.frames = progress.keptFrames = kept.frames;
    if (kept.frames > 0) progress.end = seconds(kept.nextPts);
}

// The caller holds the mutex.
bool ConversionRun::mayGoOn() {
    if (!cancelled_ && goOn_ && !goOn_(progress)) cancelled_ = true;
    return !cancelled_;
}

bool ConversionRun::read(PipelineFrame& frame) {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (!mayGoOn()) return false;
    }
    const std::int64_t number = frame.number + (range_ ? range_->begin : progress.keptFrames);
    if (range_ && number >= range_->end()) return false;
    if (!reader->read(frame.source)) return false;
    frame.number = number;
    if (!sink && !reader->facts().isLive) waitUntilDue(frame.source);
    return true;
}

void ConversionRun::waitUntilDue(const VideoFrame& frame) {
    const Clock::time_point now = Clock::now();
    if (!start_) start_ = now;
    const std::chrono::duration<double> time(seconds(frame.pts));
    std::this_thread::sleep_until(*start_ + std::chrono::duration_cast<Clock::duration>(time));
}

void ConversionRun::count(const PipelineFrame& frame) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!isBefore(frame)) ++progress.frames;
    progress.end = seconds(frame.source.pts + frame.source.duration);
    result_.inferences += frame.step.inferred ? 1 : 0;
    result_.repeated += frame.step.repeated ? 1 : 0;
    if (frame.step.cut && frame.number > 0) result_.cuts.push_back(seconds(frame.source.pts));
    mayGoOn();
}

std::vector<PipelineStage> ConversionRun::stages() {
    std::vector<PipelineStage> all;
    all.push_back({"decode", [this](PipelineFrame& frame) { return read(frame); }});
    if (depth_) {
        all.push_back({"depth", [this](PipelineFrame& frame) {
                           depth_->work(frame);
                           if (sink && sink->wantsState(frame.number))
                               frame.state = depth_->state();
                           return true;
                       }});
    }
    all.push_back({"render", [this](PipelineFrame& frame) {
                       if (isBefore(frame)) {
                           renderer->pass(frame);
                       } else {
                           renderer->work(frame);
                       }
                       if (!frame.state.bytes.empty()) renderer->keepState(frame.state);
                       frame.result.pts = frame.source.pts;
                       frame.result.duration = frame.source.duration;
                       return true;
                   }});
    if (sink) {
        all.push_back({"encode", [this](PipelineFrame& frame) {
                           if (range_ && !frame.state.bytes.empty())
                               range_->keep(frame.number + 1, frame.state);
                           if (!isBefore(frame)) sink->write(frame);
                           count(frame);
                           return true;
                       }});
    } else {
        all.push_back({"show", [this](PipelineFrame& frame) {
                           if (cancelled_) return true;
                           if (!conversion.show(frame.result.picture)) cancelled_ = true;
                           count(frame);
                           return true;
                       }});
    }
    return all;
}

void ConversionRun::failEmpty() const {
    std::string problem = "holds no frames in this part, expected at least one";
    const auto& duration = reader->facts().duration;
    if (duration && conversion.part.from >= *duration)
        problem += " (it ends at " + clockText(*duration) + ")";
    throw Error(ErrorCode::BadFormat, nameOf(conversion.input), problem);
}

// Ends the segments of a chunk.
void ConversionRun::finishRange(const VideoConversionResult& result) {
    if (result.cancelled) return;
    sink->finish(true);
    if (result.frames == range_->frames) return;
    throw Error(ErrorCode::Mismatch, nameOf(conversion.input),
                "has " + std::to_string(range_->first + result.frames) +
                    " frames up to the end of this chunk, expected " +
                    std::to_string(range_->end()) + " as when the plan was made");
}

// Ends the file and the report.
void ConversionRun::finish(VideoConversionResult& result) {
    result.cancelled = cancelled_;
    result.frames = progress.frames;
    result.keptFrames = progress.keptFrames;
    result.end = progress.end;
    if (range_) {
        finishRange(result);
    } else if (result.frames == 0 && sink && !result.cancelled) {
        failEmpty();
    } else if (result.frames > 0 && sink) {
        progress.finishing = true;
        if (goOn_) goOn_(progress);
        const Clock::time_point start = Clock::now();
        sink->finish(!result.cancelled);
        result.finishSeconds = std::chrono::duration<double>(Clock::now() - start).count();
        result.keepsWork = sink->keepsWork();
    }
    result.choices = renderer->choices();
    for (SceneChoice& choice : result.choices)
        choice.start *= unit_;
    result.counts = reader->counts();
    result.notes = reader->notes();
    const Notes more[] = {renderer->notes(), depth_ ? depth_->notes() : Notes()};
    for (const Notes& notes : more)
        result.notes.insert(result.notes.end(), notes.begin(), notes.end());
}

VideoConversionResult ConversionRun::run(const VideoProgressFunction& goOn) {
    check(!begun_, "run", "is called again, expected one call");
    begun_ = true;
    goOn_ = goOn;
    if (depth_) depth_->begin(*reader);
    if (progress.keptFrames > 0 || (range_ && range_->begin > 0)) {
        KeptVideo kept = sink->kept();
        if (depth_ && !kept.state.bytes.empty()) {
            renderer->takeState(kept.state);
            depth_->setState(kept.state);
        }
        reader->skipTo(kept.nextPts);
    }
    PipelineOptions options;
    options.threads = conversion.threads;
    options.dropLate = reader->facts().isDevice;
    if (!sink) {
        options.threads = true;
        options.dropLate = true;
        options.queueFrames = 1;
    }
    result_.pipeline = runPipeline(stages(), options);
    VideoConversionResult result = std::move(result_);
    finish(result);
    return result;
}

} // namespace altiro3D
