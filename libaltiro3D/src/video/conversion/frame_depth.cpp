#include "video/conversion/frame_depth.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "base/checks.hpp"
#include "base/state_bytes.hpp"
#include "base/text.hpp"
#include "depth/source/kind_notes.hpp"
#include "image/exif.hpp"
#include "image/image_read.hpp"
#include "media/video_picture.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr double kMissingSeconds = 0.5; // a depth video may end this much early
constexpr std::size_t kMaxNotes = 10;

std::uint64_t digest(const cv::Mat& picture) {
    std::uint64_t sum = pictureHash(picture);
    for (const int part : {picture.rows, picture.cols, picture.type()})
        sum = mixIn(sum, static_cast<std::uint64_t>(part));
    return sum;
}

// Frames mostly give the same remarks.
void addNew(const std::string& name, const Notes& from, Notes& notes) {
    for (const Note& note : from) {
        const std::string text = name + ": " + note.text;
        const bool isKnown = std::any_of(notes.begin(), notes.end(),
                                         [&](const Note& known) { return known.text == text; });
        if (notes.size() < kMaxNotes && !isKnown) notes.push_back({note.code, text});
    }
}

} // namespace

void measureRange(GivenVideoDepth& given) {
    std::error_code error;
    const bool isDirectory = fs::is_directory(given.source, error);
    const bool isFile = fs::is_regular_file(given.source, error);
    if (given.range || given.kind == DepthKind::Metric || !(isDirectory || isFile)) return;
    std::vector<std::uint64_t> counts(65536);
    const auto count = [&](const cv::Mat& raw) {
        if (raw.type() != CV_16UC1) return false;
        for (int y = 0; y < raw.rows; ++y) {
            const auto* const row = raw.ptr<std::uint16_t>(y);
            for (int x = 0; x < raw.cols; ++x)
                ++counts[row[x]];
        }
        return true;
    };
    if (isDirectory) {
        const auto& read = given.read ? given.read : readDepthSamples;
        for (const fs::path& file : listImages(given.source)) {
            if (!count(read(file, nullptr))) return;
        }
    } else {
        VideoReaderOptions options;
        options.isDepth = true;
        VideoReader video(given.source, options);
        VideoFrame frame;
        while (video.read(frame)) {
            if (!count(frame.picture)) return;
        }
    }
    const std::uint64_t total = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
    if (total == 0) return;
    // Ranks are rounded outwards, as by normalizeDepth().
    const DepthNormalization percentiles;
    const auto numberAt = [&](double rank) {
        auto left = static_cast<std::uint64_t>(rank);
        std::size_t number = 0;
        while (left >= counts[number])
            left -= counts[number++];
        return static_cast<double>(number);
    };
    const auto last = static_cast<double>(total - 1);
    given.range = DepthRange{numberAt(std::floor(percentiles.lowPercentile / 100 * last)),
                             numberAt(std::ceil(percentiles.highPercentile / 100 * last))};
}

// Given depth of a video: another video, or a directory with one picture per frame.
class GivenDepth {
  public:
    // @param part of the video that is read @param video that the depth belongs to
    // @throws Error Mismatch (its shape fits only if it is turned), and others
    GivenDepth(const GivenVideoDepth& given, const VideoReaderOptions& part,
               const VideoFacts& video);

    // Finds the depth of the part's first frame; call it before that frame is read.
    void begin(VideoReader& video);
    // The raw depth of a frame [any size, CV_8UC1, CV_16UC1 or CV_32FC1].
    // @param time when it is shown, s from the beginning of the part @param number in the part
    void read(double time, std::int64_t number, cv::Mat& raw);
    Notes notes() const;

  private:
    void fitShape(cv::Size depth, double sampleAspect, const VideoFacts& video);
    void requireRange(const cv::Mat& raw) const;
    void refuseUnusedRange(const cv::Mat& first) const;
    void readImage(std::int64_t number, cv::Mat& raw);
    void readFrame(double time, cv::Mat& raw);

    GivenVideoDepth given_;
    std::vector<std::filesystem::path> pictures_;
    std::int64_t firstPicture_ = 0;
    Notes notes_;
    int orientation_ = 1; // orientation of the video, where the depth lacks it; see upright()
    std::optional<VideoReader> video_;
    double unit_ = 1; // s
    VideoFrame frame_;
    VideoFrame ahead_;
    bool hasAhead_ = false;
    bool isFirst_ = true; // no frame was read as grey
    double missing_ = 0;  // s or frames beyond the end
};

GivenDepth::GivenDepth(const GivenVideoDepth& given, const VideoReaderOptions& part,
                       const VideoFacts& video)
    : given_(given) {
    const std::string name = given_.source.string();
    if (!given_.read) given_.read = readDepthSamples;
    std::error_code error;
    if (fs::is_directory(given_.source, error)) {
        pictures_ = listImages(given_.source);
        if (pictures_.empty())
            throw Error(ErrorCode::NotFound, name,
                        "holds no pictures, expected one depth image per frame");
        const cv::Mat first = given_.read(pictures_.front(), nullptr);
        refuseUnusedRange(first);
        fitShape(first.size(), 1, video);
        return;
    }
    VideoReaderOptions options;
    options.from = part.from;
    options.to = part.to;
    options.deinterlace = part.deinterlace;
    options.isDepth = true;
    video_.emplace(given_.source, options);
    unit_ = video_->facts().timeBase.value();
    if (!video_->read(frame_))
        throw Error(ErrorCode::BadFormat, name,
                    "has no depth for this part, expected one picture per frame");
    requireRange(frame_.picture);
    refuseUnusedRange(frame_.picture);
    fitShape(frame_.picture.size(), video_->facts().sampleAspect.value(), video);
    hasAhead_ = video_->read(ahead_);
}

// Compares the shape of the depth with that of the upright video, in px and as displayed: depth of
// px that are not square may have square ones. Depth that lacks the video's rotation is turned.
// @param sampleAspect of the depth
void GivenDepth::fitShape(cv::Size depth, double sampleAspect, const VideoFacts& video) {
    const auto mismatch = [&](cv::Size size, double aspect) {
        const auto ratio = [](cv::Size of) { return static_cast<double>(of.width) / of.height; };
        const double inPixels = std::log(ratio(size) / ratio(video.size));
        const double seen = inPixels + std::log(aspect / video.sampleAspect.value());
        return std::min(std::abs(inPixels), std::abs(seen));
    };
    constexpr double kSame = 1e-6;
    const double upright = mismatch(depth, sampleAspect);
    const double turned = mismatch({depth.height, depth.width}, 1 / sampleAspect);
    const bool fitsTurned = turned < upright - kSame;
    const auto isStoredTurned = [](const VideoFacts& facts) {
        return facts.rotationDegrees != 0 || facts.mirrored;
    };
    const bool lacksRotation =
        isStoredTurned(video) && !(video_ && isStoredTurned(video_->facts()));
    const bool isAcross = video.rotationDegrees % 180 != 0;
    // Where the shape does not decide, a depth video is taken as stored turned like the video, and
    // pictures as upright.
    const bool isUndecided = !isAcross || std::abs(turned - upright) <= kSame;
    const bool follows = lacksRotation && (isUndecided ? video_.has_value() : fitsTurned);
    const std::string name = given_.source.string();
    const std::string sizes = pairText(depth.width, depth.height) + " and " +
                              pairText(video.size.width, video.size.height);
    if (fitsTurned && !(follows && isAcross))
        throw Error(ErrorCode::Mismatch, name,
                    "fits the video only if it is turned (" + sizes +
                        "), expected depth of the video's orientation");
    if (follows) {
        orientation_ = orientationOf(video);
        notes_.push_back(
            {NoteCode::Converted, name + ": states no rotation and is turned as the video is"});
    }
    constexpr double kTolerance = 0.02; // as for photos
    if ((follows && isAcross ? turned : upright) > kTolerance)
        notes_.push_back({NoteCode::Doubtful, name + ": its shape differs from the video's (" +
                                                  sizes + "); it is stretched to fit"});
}

void GivenDepth::begin(VideoReader& video) {
    if (!video_) firstPicture_ = video.framesBefore();
}

void GivenDepth::read(double time, std::int64_t number, cv::Mat& raw) {
    if (video_) {
        readFrame(time, raw);
    } else {
        readImage(firstPicture_ + number, raw);
    }
    requireRange(raw);
    raw = upright(raw, orientation_);
}

void GivenDepth::refuseUnusedRange(const cv::Mat& first) const {
    if (!given_.range || (first.depth() == CV_16U && given_.kind != DepthKind::Metric)) return;
    throw Error(ErrorCode::InvalidArgument, "depth range",
                "is set for " + given_.source.string() +
                    ", which has no depth of 16 bits without a unit, expected none");
}

// Without a range, 16-bit depth is refused: it could be read only once, or begins with 8 bits.
void GivenDepth::requireRange(const cv::Mat& raw) const {
    if (raw.depth() != CV_16U || given_.range || given_.kind == DepthKind::Metric) return;
    throw Error(ErrorCode::BadFormat, given_.source.string(),
                "has depth of 16 bits whose range cannot be measured before the run, expected its "
                "range (--depth-range A:B)");
}

void GivenDepth::readImage(std::int64_t number, cv::Mat& raw) {
    const auto count = static_cast<std::int64_t>(pictures_.size());
    missing_ = std::max(missing_, static_cast<double>(number - count + 1));
    const fs::path& file = pictures_[static_cast<std::size_t>(std::min(number, count - 1))];
    Notes notes;
    raw = given_.read(file, &notes);
    addKindNotes(file, raw, given_.kind, &notes);
    addNew(file.string(), notes, notes_);
}

void GivenDepth::readFrame(double time, cv::Mat& raw) {
    // The two videos have different time units; times match within half a frame.
    const auto begins = [&](const VideoFrame& frame) {
        return (static_cast<double>(frame.pts) - 0.5 * static_cast<double>(frame.duration)) * unit_;
    };
    while (hasAhead_ && begins(ahead_) <= time) {
        std::swap(frame_, ahead_);
        hasAhead_ = video_->read(ahead_);
    }
    if (!hasAhead_) missing_ = std::max(missing_, time - static_cast<double>(frame_.pts) * unit_);
    if (frame_.picture.channels() == 1) {
        raw = frame_.picture;
        return;
    }
    const std::string name = given_.source.string();
    Notes notes;
    raw = undoColourMap(frame_.picture, name, &notes);
    if (!raw.empty()) {
        addNew(name, notes, notes_);
        return;
    }
    if (isFirst_ && hasColours(frame_.picture))
        addNew(name,
               {{NoteCode::Doubtful,
                 "has colours, and depth has none: their grey value is taken (the video comes "
                 "first, then its depth)"}},
               notes_);
    isFirst_ = false;
    cv::cvtColor(frame_.picture, raw, cv::COLOR_BGR2GRAY);
}

Notes GivenDepth::notes() const {
    Notes notes = notes_;
    const std::string name = given_.source.string();
    if (video_) {
        for (const Note& note : video_->notes())
            notes.push_back(note);
        if (missing_ > kMissingSeconds)
            notes.push_back(
                {NoteCode::CutOff,
                 name + ": ends before the video; its last depth is used for the rest"});
    } else if (missing_ > 0) {
        notes.push_back(
            {NoteCode::CutOff,
             name + ": holds " + std::to_string(pictures_.size()) +
                 " pictures, fewer than the video has frames; the last one is used for the rest"});
    }
    return notes;
}

// Depth of frames with both eyes' pictures.
class EyesDepth {
  public:
    EyesDepth(const StereoVideo& video, DepthSource& fallback)
        : video_(video), fallback_(fallback) {}

    // @return the left eye's picture; the right one's is kept
    cv::Mat split(const cv::Mat& frame) {
        const StereoPair pair = splitStereoPair(frame, video_.layout, video_.halves);
        right_ = pair.right;
        hidden_ = {};
        return pair.left;
    }
    const cv::Mat& right() const { return right_; }

    // For a later run: results of the last frame, and the counts.
    void save(std::string& bytes) const {
        append(bytes, layer_.photo);
        append(bytes, layer_.depth);
        for (const std::uint64_t count :
             {counts_.all, counts_.flat, counts_.unlike, counts_.swapped})
            append(bytes, count);
    }
    bool load(std::string_view& rest) {
        return take(rest, CV_8UC3, layer_.photo) && take(rest, CV_32FC1, layer_.depth) &&
               layer_.photo.size() == layer_.depth.size() && take(rest, counts_.all) &&
               take(rest, counts_.flat) && take(rest, counts_.unlike) &&
               take(rest, counts_.swapped);
    }

    // @param raw of the left eye's picture, near = large
    void estimate(const cv::Mat& left, cv::Mat& raw) {
        const StereoMatch match = matchStereo(left, right_, raw, &hidden_);
        ++counts_.all;
        if (match.areEyes() && !match.isFlat) {
            if (match.looksSwapped) ++counts_.swapped;
            disparity_ = raw;
            return;
        }
        ++(match.isFlat ? counts_.flat : counts_.unlike);
        hidden_ = {};
        cv::Mat photo;
        cv::Mat numbers;
        fallback_.readFrame(left, photo, numbers);
        DepthNormalization normalization;
        normalization.kind = fallback_.kind();
        normalizeDepth(numbers, raw, normalization);
    }

    // The hidden layer: found by the estimate of this frame, or for a repeated one, known before.
    // @param depth of the frame
    HiddenLayer hidden(const VideoDepthStep& step, const cv::Mat& depth) {
        if (step.repeated) return layer_;
        layer_ = {};
        if (step.inferred && !hidden_.photo.empty() && depth.size() == disparity_.size()) {
            layer_ = {hidden_.photo, hidden_.depth.clone()};
            scaleHiddenDepth(disparity_, depth, layer_);
        }
        return layer_;
    }

    Notes notes() const {
        Notes notes;
        const auto note = [&](const std::string& text) {
            notes.push_back({NoteCode::Doubtful, text});
        };
        if (counts_.flat == counts_.all && counts_.all > 0) {
            note("both eyes see the same picture: the video is flat (2D), and its depth is "
                 "estimated");
        } else if (counts_.flat + counts_.unlike > 0) {
            note("the eyes do not match, or see the same, in " +
                 std::to_string(counts_.flat + counts_.unlike) + " of " +
                 std::to_string(counts_.all) +
                 (counts_.all == 1 ? " frame" : " frames, of those that were compared") +
                 ": depth is estimated there");
        }
        if (2 * counts_.swapped > counts_.all - counts_.flat - counts_.unlike)
            note("the eyes look swapped: the background appears in front of the foreground");
        return notes;
    }

  private:
    StereoVideo video_;
    DepthSource& fallback_;
    cv::Mat right_;      // the right eye's picture
    cv::Mat disparity_;  // disparity of the last estimate
    HiddenLayer hidden_; // hidden layer of the last estimate, with disparities
    HiddenLayer layer_;  // hidden layer of the last frame, with depth
    struct {
        std::uint64_t all = 0;
        std::uint64_t flat = 0;
        std::uint64_t unlike = 0;
        std::uint64_t swapped = 0;
    } counts_; // counts of estimates
};

FrameDepth::FrameDepth(VideoConversion& conversion, const VideoFacts& facts)
    : flatDepth_(conversion.recipe.views.focus), options_(conversion.depthOptions),
      unit_(facts.timeBase.value()) {
    if (conversion.given) {
        const GivenVideoDepth& given = *conversion.given;
        rgbd_ = given.rgbd;
        kind_ = given.kind;
        range_ = given.range.value_or(DepthRange());
        options_.every = 1;
        if (!rgbd_) given_ = std::make_unique<GivenDepth>(given, conversion.part, facts);
    } else {
        source_ = std::move(conversion.depth);
        kind_ = source_->kind();
        if (conversion.stereo) {
            rgbd_ = halvesOf(*conversion.stereo);
            kind_ = DepthKind::NearWhite;
            eyes_ = std::make_unique<EyesDepth>(*conversion.stereo, *source_);
        }
    }
    start();
}

FrameDepth::~FrameDepth() = default;

Notes FrameDepth::notes() const {
    return given_ ? given_->notes() : eyes_ ? eyes_->notes() : notes_;
}

void FrameDepth::start() {
    const auto estimate = [this](const cv::Mat& picture, cv::Mat& raw) {
        if (eyes_) {
            eyes_->estimate(picture, raw);
        } else if (source_) {
            cv::Mat photo;
            source_->readFrame(picture, photo, raw);
        } else {
            raw_.copyTo(raw);
        }
    };
    depth_.emplace(estimate, kind_, options_);
}

void FrameDepth::begin(VideoReader& video) {
    if (given_) given_->begin(video);
}

cv::Size FrameDepth::photoSize(cv::Size frame) const {
    return rgbd_ ? rgbd_->photoSize(frame) : frame;
}

double FrameDepth::photoAspect(cv::Size frame, double frameAspect) const {
    const cv::Size photo = photoSize(frame);
    const auto aspect = [](cv::Size size) { return static_cast<double>(size.width) / size.height; };
    return frameAspect * aspect(photo) / aspect(frame);
}

SavedState FrameDepth::state() const {
    std::string bytes;
    append(bytes, lastPhoto_);
    append(bytes, lastRaw_);
    if (!source_) cuts_.save(bytes);
    if (eyes_) eyes_->save(bytes);
    return {bytes + depth_->state().bytes};
}

void FrameDepth::setState(const SavedState& state) {
    std::string_view rest(state.bytes);
    if (!take(rest, lastPhoto_) || !take(rest, lastRaw_) || (!source_ && !cuts_.load(rest)) ||
        (eyes_ && !eyes_->load(rest)))
        throw damagedState();
    depth_->setState({std::string(rest)});
}

void FrameDepth::work(PipelineFrame& frame) {
    if (eyes_) {
        frame.source.picture = eyes_->split(frame.source.picture);
        const std::uint64_t left = digest(frame.source.picture);
        const std::uint64_t right = digest(eyes_->right());
        if (left == lastPhoto_ && right != lastRaw_)
            start(); // the left eye does not see what moves
        lastPhoto_ = left;
        lastRaw_ = right;
    }
    if (source_) {
        frame.step = depth_->next(frame.source.picture, frame.depth);
        // only if every frame has it: else it would flicker
        if (eyes_ && options_.every == 1) frame.hidden = eyes_->hidden(frame.step, frame.depth);
        return;
    }
    if (given_) {
        given_->read(static_cast<double>(frame.source.pts) * unit_, frame.number, raw_);
    } else {
        cv::Mat photo;
        Notes notes;
        splitRgbd(frame.source.picture, *rgbd_, photo, raw_, &notes);
        if (photo.size() != photoSize(frame.source.picture.size()))
            throw Error(ErrorCode::Unsupported, "RGB-D frame",
                        "has a white gap between photo and depth, expected halves without a gap");
        addNew("RGB-D frames", notes, notes_);
        raw_.convertTo(raw_, CV_8U); // a grey value of a frame
        frame.source.picture = photo;
    }
    useGiven(frame);
}

// Grey values have one range for the whole video, so that the depth does not waver. Distances and
// floats have no fixed range; they get one that follows them slowly.
void FrameDepth::useGiven(PipelineFrame& frame) {
    const std::uint64_t photo = digest(frame.source.picture);
    const std::uint64_t raw = digest(raw_);
    const bool samePhoto = photo == lastPhoto_;
    const bool sameDepth = raw == lastRaw_;
    lastPhoto_ = photo;
    lastRaw_ = raw;
    const bool grey = raw_.depth() == CV_8U || raw_.depth() == CV_16U;
    if (grey && kind_ != DepthKind::Metric) {
        frame.step.repeated = samePhoto && sameDepth;
        frame.step.cut = cuts_.next(frame.source.picture).cut;
        const DepthRange range = raw_.depth() == CV_8U ? DepthRange{0, 255} : range_;
        if (range.high <= range.low) {
            frame.depth.create(raw_.size(), CV_32FC1);
            frame.depth.setTo(flatDepth_);
            return;
        }
        const double scale = (kind_ == DepthKind::FarWhite ? -1 : 1) / (range.high - range.low);
        raw_.convertTo(frame.depth, CV_32F, scale,
                       -scale * (kind_ == DepthKind::FarWhite ? range.high : range.low));
        if (raw_.depth() != CV_8U) frame.depth = cv::min(cv::max(frame.depth, 0), 1);
        return;
    }
    if (samePhoto && !sameDepth) start(); // the picture does not show what moves
    frame.step = depth_->next(frame.source.picture, frame.depth);
    frame.step.inferred = false;
}

struct GivenDepthReader::Impl {
    VideoConversion conversion;
    VideoFacts video;
    std::optional<FrameDepth> depth;
    double last = 0; // s, of the last picture
};

GivenDepthReader::GivenDepthReader(GivenVideoDepth given, const VideoFacts& video) try
    : impl_(std::make_unique<Impl>()) {
    std::error_code error;
    if (given.rgbd || !fs::is_regular_file(given.source, error))
        throw Error(ErrorCode::InvalidArgument, given.source.string(),
                    "is not a file, expected a depth video");
    measureRange(given);
    impl_->conversion.given = std::move(given);
    impl_->video = video;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

GivenDepthReader::~GivenDepthReader() = default;
GivenDepthReader::GivenDepthReader(GivenDepthReader&&) noexcept = default;
GivenDepthReader& GivenDepthReader::operator=(GivenDepthReader&&) noexcept = default;

VideoDepthStep GivenDepthReader::next(const cv::Mat& picture, double seconds, cv::Mat& depth) try {
    checkType(picture, {CV_8UC3}, "picture", "CV_8UC3 (8-bit BGR)");
    constexpr double kMostRead = 2; // s, that are read rather than skipped
    constexpr double kMargin = 1;   // s, for the picture of depth that begins before
    Impl& impl = *impl_;
    double& from = impl.conversion.part.from;
    if (!impl.depth || seconds <= impl.last || seconds > impl.last + kMostRead) {
        from = std::max(0.0, seconds - kMargin);
        try {
            impl.depth.emplace(impl.conversion, impl.video);
        } catch (const Error&) { // the depth has ended; its last picture is found from the start
            if (from == 0) throw;
            from = 0;
            impl.depth.emplace(impl.conversion, impl.video);
        }
    }
    impl.last = seconds;
    PipelineFrame frame;
    frame.source.picture = picture;
    frame.source.pts = std::llround((seconds - from) / impl.video.timeBase.value());
    impl.depth->work(frame);
    depth = frame.depth;
    return frame.step;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
