#include "video/conversion/given_depth.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "base/text.hpp"
#include "image/image_read.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr double kMissingSeconds = 0.5; // a depth video may end this much early
constexpr std::size_t kMaxNotes = 10;

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

GivenDepth::GivenDepth(const GivenVideoDepth& given, const VideoReaderOptions& part,
                       const VideoFacts& video)
    : given_(given) {
    const std::string name = given_.source.string();
    if (!given_.read) given_.read = readDepthSamples;
    std::error_code error;
    if (fs::is_directory(given_.source, error)) {
        pictures_ = listImages(given_.source);
        if (pictures_.empty()) {
            throw Error(ErrorCode::NotFound, name,
                        "holds no pictures, expected one depth image per frame");
        }
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
    if (!video_->read(frame_)) {
        throw Error(ErrorCode::BadFormat, name,
                    "has no depth for this part, expected one picture per frame");
    }
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
    // Where the shape does not decide, a video is stored as the other one is; pictures are upright.
    const bool isUndecided = !isAcross || std::abs(turned - upright) <= kSame;
    const bool follows = lacksRotation && (isUndecided ? video_.has_value() : fitsTurned);
    const std::string name = given_.source.string();
    const std::string sizes = sizeText(depth) + " and " + sizeText(video.size);
    if (fitsTurned && !(follows && isAcross)) {
        throw Error(ErrorCode::Mismatch, name,
                    "fits the video only if it is turned (" + sizes +
                        "), expected depth of the video's orientation");
    }
    if (follows) {
        rotationDegrees_ = video.rotationDegrees;
        mirrored_ = video.mirrored;
        notes_.push_back(
            {NoteCode::Converted, name + ": states no rotation and is turned as the video is"});
    }
    constexpr double kTolerance = 0.02; // as for photos
    if ((follows && isAcross ? turned : upright) > kTolerance) {
        notes_.push_back({NoteCode::Doubtful, name + ": its shape differs from the video's (" +
                                                  sizes + "); it is stretched to fit"});
    }
}

// Turns depth as the video's pictures are turned.
void GivenDepth::turn(cv::Mat& raw) const {
    constexpr int kTurns[] = {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180,
                              cv::ROTATE_90_COUNTERCLOCKWISE};
    cv::Mat turned; // the memory of `raw` may be shared
    if (rotationDegrees_ != 0) {
        cv::rotate(raw, turned, kTurns[rotationDegrees_ / 90 - 1]);
        raw = turned;
        turned = cv::Mat();
    }
    if (mirrored_) {
        cv::flip(raw, turned, 1);
        raw = turned;
    }
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
    turn(raw);
}

void GivenDepth::refuseUnusedRange(const cv::Mat& first) const {
    if (!given_.range || (first.depth() == CV_16U && given_.kind != DepthKind::Metric)) return;
    throw Error(ErrorCode::InvalidArgument, "depth range",
                "is set for " + given_.source.string() +
                    ", which has no depth of 16 bits without a unit, expected none");
}

// Only depth that is read once, or that begins with 8 bits, has none.
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
    addNotes(file.string(), notes);
}

void GivenDepth::addNotes(const std::string& name, const Notes& notes) {
    for (const Note& note : notes) {
        const std::string text = name + ": " + note.text;
        const bool isKnown = std::any_of(notes_.begin(), notes_.end(),
                                         [&](const Note& known) { return known.text == text; });
        if (notes_.size() < kMaxNotes && !isKnown) notes_.push_back({note.code, text});
    }
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
    if (!hasAhead_) {
        missing_ = std::max(missing_, time - static_cast<double>(frame_.pts) * unit_);
    }
    if (frame_.picture.channels() == 1) {
        raw = frame_.picture;
        return;
    }
    const std::string name = given_.source.string();
    Notes notes;
    raw = undoColourMap(frame_.picture, name, &notes);
    if (!raw.empty()) {
        addNotes(name, notes);
        return;
    }
    if (isFirst_ && hasColours(frame_.picture)) {
        addNotes(name, {{NoteCode::Doubtful,
                         "has colours, and depth has none: their grey value is taken (the video "
                         "comes first, then its depth)"}});
    }
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

} // namespace altiro3D
