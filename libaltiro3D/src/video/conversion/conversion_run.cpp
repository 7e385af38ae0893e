#include "video/conversion/conversion_run.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/stereo_views.hpp"
#include "base/checks.hpp"
#include "media/video_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <system_error>
#include <thread>
#include <utility>

namespace altiro3D {

namespace {

constexpr double kSegmentSeconds = 6; // what an interrupted run loses; encoders start slowly
constexpr int kMinSegmentFrames = 12;
constexpr int kMaxSegmentFrames = 600;
constexpr int kUsualSegmentFrames = 180;

std::string nameOf(const std::filesystem::path& input) {
    return input == "-" ? "standard input" : input.string();
}

// The output replaces a file, which must not be one that is read.
void refuseInputAsOutput(const VideoConversion& conversion, const std::filesystem::path& input,
                         const char* what) {
    std::error_code error;
    if (conversion.output.empty() || conversion.output == "-" ||
        !std::filesystem::equivalent(conversion.output, input, error))
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
    const bool needsDisplay =
        conversion.product == VideoProduct::Native || conversion.product == VideoProduct::Quilt;
    check(!needsDisplay || conversion.display || conversion.map, "display",
          "is not set, expected one for Natives and quilts");
    if (conversion.given)
        check(conversion.given->source.empty() == conversion.given->rgbd.has_value(), "given",
              "depth has a source and an RGB-D layout, or neither, expected one of them");
    check(!conversion.map || (conversion.recipe.sampling.views == ViewFilter::Nearest &&
                              conversion.recipe.sampling.inTile == TileSampling::Nearest),
          "sampling", "is linear, but a look-up table holds single px, expected nearest");
    check(!conversion.recipe.choices.framing || conversion.recipe.fit == FitMode::Cover, "framing",
          "cannot be chosen automatically with this fit, expected cover");
    check((conversion.recipe.framing == Framing() && !conversion.recipe.choices.any()) ||
              (!conversion.fromQuilt && conversion.product != VideoProduct::Rgbd),
          "framing", "or an automatic choice is set, expected frames that are rendered as views");
    check(conversion.product != VideoProduct::Stereo ||
              (conversion.recipe.framing == Framing() && !conversion.recipe.choices.framing),
          "framing", "is set, but both eyes see whole frames, expected none");
    check(conversion.rgbdHalves != StereoHalves::Automatic, "rgbdHalves",
          "are automatic, expected full or squeezed ones");
    check(!conversion.stereo || (!conversion.given && !conversion.fromQuilt), "stereo",
          "is set, expected no other depth and no quilts");
    check(!conversion.eyes.filmed ||
              (conversion.stereo && conversion.product == VideoProduct::Stereo),
          "filmed", "is set, expected frames with both eyes, and the product Stereo");
    if (!conversion.fromQuilt) return;
    check(conversion.product == VideoProduct::Native, "product",
          "is not Native, but frames are quilts");
    check(!conversion.given && !conversion.depth, "depth", "is set, but frames are quilts");
    checkNumber(conversion.viewAspect == 0 ||
                    (conversion.viewAspect >= 0.01 && conversion.viewAspect <= 100),
                "viewAspect", conversion.viewAspect, "0.01..100, or 0");
}

// Refuses frames that have the wanted layout already.
void refuseSameLayout(const VideoConversion& conversion, const VideoFacts& facts) {
    const StereoVideo& now = *conversion.stereo;
    const auto same = eyesPictureOf(now.layout, now.halves, facts.size);
    if (same != conversion.eyes.picture || conversion.eyes.swapped || facts.areJoined()) return;
    throw Error(ErrorCode::InvalidArgument, nameOf(conversion.input),
                std::string("is ") + nameOf(*same).words + " already, expected another layout");
}

// Whether the output is written in segments, with which a later run can go on.
bool isResumable(const VideoConversion& conversion) {
    return !conversion.show && conversion.output != "-" && canReadAgain(conversion.input);
}

// A range is made by several runs, which read the input again.
void requireFileInput(const VideoConversion& conversion) {
    check(!conversion.show, "show", "is set, expected an output");
    check(conversion.output != "-", "output", "is standard output, expected a file");
    std::error_code error;
    if (std::filesystem::exists(conversion.input, error) && !canReadAgain(conversion.input))
        throw Error(ErrorCode::InvalidArgument, conversion.input.string(),
                    "can be read only once, expected a file");
}

// The target; empty if no picture is made for a display.
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
    const bool isStereo = conversion.product == VideoProduct::Stereo;
    const EyesPicture picture = conversion.eyes.picture;
    const bool isMixed = isStereo && (isInterlaced(picture) || isAnaglyph(picture));
    if (conversion.product != VideoProduct::Native && !isMixed) { // 4:2:0 would mix the eyes
        encoding.compatible =
            encoding.codec == VideoCodec::H264 || encoding.codec == VideoCodec::Hevc;
    }
    encoding.native = conversion.product == VideoProduct::Native;
    encoding.eyes.reset();
    if (isStereo) {
        encoding.eyes = conversion.eyes.picture;
        // read by findEyes(); containers do not state whether halves are squeezed
        encoding.tags.emplace_back("keywords", nameOf(conversion.eyes.picture).words);
    }
    encoding.size = size;
    constexpr int kLeast = 16; // least side for VideoWriterOptions
    if (std::min(size.width, size.height) < kLeast)
        throw Error(ErrorCode::Unsupported, nameOf(conversion.input),
                    "makes a video of " + sizeText(size) + ", expected at least " +
                        std::to_string(kLeast) + " px a side");
    encoding.timeBase = facts.timeBase;
    encoding.frameRate = facts.averageRate;
    encoding.constantRate = facts.constantRate;
    return encoding;
}

} // namespace

int segmentFramesFor(const Fraction& rate) {
    if (!rate.isKnown()) return kUsualSegmentFrames;
    return static_cast<int>(std::clamp<double>(std::round(rate.value() * kSegmentSeconds),
                                               kMinSegmentFrames, kMaxSegmentFrames));
}

bool canReadAgain(const std::filesystem::path& input) {
    std::error_code error;
    return std::filesystem::is_regular_file(input, error);
}

ConversionRun::ConversionRun(VideoConversion given, std::optional<ChunkRange> range)
    : conversion(std::move(given)), range_(std::move(range)) {
    if (range_) requireFileInput(conversion);
    checkFields(conversion);
    const VideoTarget target = targetOf(conversion);
    reader = conversion.reader ? std::move(conversion.reader)
                               : std::make_unique<VideoReader>(conversion.input, conversion.part);
    const VideoFacts& facts = reader->facts();
    unit_ = facts.timeBase.value();
    setDepthRange(conversion);
    if (!conversion.fromQuilt && !conversion.given && !conversion.eyes.filmed) {
        if (!conversion.depth) conversion.depth = estimatedDepth();
        conversion.depth->load(); // the stamp describes it
    }
    if (isResumable(conversion)) stamp = conversionStamp(conversion, target.layout);
    if (conversion.fromQuilt) {
        renderer = makeQuiltRenderer(conversion, target);
    } else if (conversion.eyes.filmed) {
        refuseSameLayout(conversion, facts);
        renderer = makeEyesRenderer(conversion, facts);
    } else {
        depth_ = std::make_unique<FrameDepth>(conversion, facts);
        const double aspect = facts.sampleAspect.value() * facts.size.width / facts.size.height;
        renderer = makePhotoRenderer(conversion, target, depth_->photoSize(facts.size),
                                     depth_->photoAspect(facts.size, aspect), depth_->edges());
    }
    encoding = encodingOf(conversion, facts, renderer->size());
    if (range_) {
        encoding.colour = encoding.colour ? encoding.colour : shownColour(facts.colour);
        progress.framesInAll = range_->frames;
        openOutput();
        return;
    }
    openOutput();
    if (facts.duration)
        progress.length = std::min(*facts.duration, conversion.part.to) - conversion.part.from;
    const bool whole = conversion.part.from <= 0 && !std::isfinite(conversion.part.to);
    if (whole) {
        progress.framesInAll = facts.frameCount;
    } else if (progress.length.value_or(0) > 0 && facts.averageRate.isKnown()) {
        progress.framesInAll = std::llround(*progress.length * facts.averageRate.value());
    }
    progress.frames = progress.keptFrames = kept_.frames;
    if (kept_.frames > 0) progress.end = seconds(kept_.nextPts);
}

void ConversionRun::openOutput() {
    if (range_) {
        chunk_.emplace(range_->directory, encoding, range_->segmentFrames,
                       static_cast<std::size_t>(range_->first / range_->segmentFrames));
        kept_ = {range_->begin, range_->beginPts, range_->state};
    } else if (!conversion.show && !isResumable(conversion)) {
        plain_.emplace(conversion.output, encoding, reader.get());
    } else if (!conversion.show) {
        if (conversion.unfinished == UnfinishedRun::Discard)
            discardUnfinishedVideo(conversion.output);
        VideoReader probe(conversion.input, conversion.part);
        segments_.emplace(conversion.output, encoding,
                          ResumableVideoOptions{segmentFramesFor(encoding.frameRate),
                                                conversion.unfinished == UnfinishedRun::Resume,
                                                stamp},
                          &probe);
        kept_ = segments_->kept();
    }
}

const Notes& ConversionRun::notes() const {
    static const Notes kNone;
    return segments_ ? segments_->notes() : plain_ ? plain_->notes() : kNone;
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
    if (conversion.show && !reader->facts().isLive) waitUntilDue(frame.source);
    return true;
}

void ConversionRun::waitUntilDue(const VideoFrame& frame) {
    const Clock::time_point now = Clock::now();
    if (!start_) start_ = now;
    const std::chrono::duration<double> time(seconds(frame.pts));
    std::this_thread::sleep_until(*start_ + std::chrono::duration_cast<Clock::duration>(time));
}

// Whether PipelineFrame::state must hold the state after that frame.
bool ConversionRun::wantsState(std::int64_t frame) const {
    if (segments_) return segments_->endsSegment(frame);
    return range_ && range_->borders.count(frame + 1) > 0;
}

void ConversionRun::write(const PipelineFrame& frame) {
    if (isBefore(frame)) return;
    if (chunk_) {
        if (chunk_->write(frame.result)) chunkSegments_.push_back(chunk_->end());
    } else if (segments_) {
        segments_->write(frame.result, frame.state);
    } else {
        plain_->write(frame.result);
    }
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
                           if (wantsState(frame.number)) frame.state = depth_->state();
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
    if (!conversion.show) {
        all.push_back({"encode", [this](PipelineFrame& frame) {
                           if (range_ && !frame.state.bytes.empty())
                               range_->keep(frame.number + 1, frame.state);
                           write(frame);
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
    if (chunk_->hasBegun()) chunkSegments_.push_back(chunk_->end());
    if (result.frames == range_->frames) return;
    throw Error(ErrorCode::Mismatch, nameOf(conversion.input),
                "has " + std::to_string(range_->first + result.frames) +
                    " frames up to the end of this chunk, expected " +
                    std::to_string(range_->end()) + " as when the plan was made");
}

// @param complete false: the user has stopped and may continue later
void ConversionRun::finishFile(bool complete) {
    if (plain_) return plain_->finish();
    VideoReader again(conversion.input, conversion.part);
    segments_->finish(&again, complete);
}

// Ends the file and the report.
void ConversionRun::finish(VideoConversionResult& result) {
    result.cancelled = cancelled_;
    result.frames = progress.frames;
    result.keptFrames = progress.keptFrames;
    result.end = progress.end;
    if (range_) {
        finishRange(result);
    } else if (result.frames == 0 && !conversion.show && !result.cancelled) {
        failEmpty();
    } else if (result.frames > 0 && !conversion.show) {
        progress.finishing = true;
        if (goOn_) goOn_(progress);
        const Clock::time_point start = Clock::now();
        finishFile(!result.cancelled);
        result.finishSeconds = std::chrono::duration<double>(Clock::now() - start).count();
        result.keepsWork = keepsWork();
    }
    result.choices = renderer->choices();
    for (SceneChoice& choice : result.choices)
        choice.start *= unit_;
    result.counts = reader->counts();
    for (const Note& note : reader->notes()) {
        const bool isOfOwnDepth = note.code == NoteCode::AsItIs && conversion.given &&
                                  conversion.given->source == conversion.input;
        if (!isOfOwnDepth) result.notes.push_back(note);
    }
    if (!reader->facts().eyes.empty() && !conversion.stereo)
        addNote(&result.notes, NoteCode::Doubtful,
                nameOf(conversion.input) + ": holds the pictures of both eyes (" +
                    reader->facts().eyes + "), which become one flat scene");
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
        if (depth_ && !kept_.state.bytes.empty()) {
            renderer->takeState(kept_.state);
            depth_->setState(kept_.state);
        }
        reader->skipTo(kept_.nextPts);
    }
    PipelineOptions options;
    options.dropLate = reader->facts().isDevice;
    if (conversion.show) {
        options.dropLate = true;
        options.queueFrames = 1;
    }
    result_.pipeline = runPipeline(stages(), options);
    VideoConversionResult result = std::move(result_);
    finish(result);
    return result;
}

struct VideoConverter::Impl : ConversionRun {
    using ConversionRun::ConversionRun;
};

VideoConverter::VideoConverter(VideoConversion conversion) try
    : impl_(std::make_unique<Impl>(std::move(conversion))) {
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}
VideoConverter::~VideoConverter() = default;
VideoConverter::VideoConverter(VideoConverter&&) noexcept = default;
VideoConverter& VideoConverter::operator=(VideoConverter&&) noexcept = default;

const VideoFacts& VideoConverter::facts() const {
    return impl_->reader->facts();
}

cv::Size VideoConverter::size() const {
    return impl_->renderer->size();
}

const VideoProgress& VideoConverter::progress() const {
    return impl_->progress;
}

const Notes& VideoConverter::notes() const {
    return impl_->notes();
}

bool VideoConverter::keepsWork() const {
    return impl_->keepsWork();
}

VideoConversionResult VideoConverter::run(const VideoProgressFunction& goOn) try {
    return impl_->run(goOn);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

std::string clockText(double seconds) {
    char text[48];
    constexpr double kLongest = 1e15;
    const auto tenths = std::llround(seconds > 0 ? std::min(seconds, kLongest) * 10 : 0);
    const long long hours = tenths / 36000;
    const int minutes = static_cast<int>(tenths / 600 % 60);
    const double rest = static_cast<double>(tenths % 600) / 10;
    if (hours > 0) {
        std::snprintf(text, sizeof text, "%lld:%02d:%04.1f", hours, minutes, rest);
    } else {
        std::snprintf(text, sizeof text, "%d:%04.1f", minutes, rest);
    }
    return text;
}

} // namespace altiro3D
