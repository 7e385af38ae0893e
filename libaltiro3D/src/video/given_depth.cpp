#include "video/given_depth.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr double kMissingSeconds = 0.5; // a depth video may end this much early
constexpr std::size_t kMaxNotes = 10;

} // namespace

GivenDepth::GivenDepth(const GivenVideoDepth& given, const VideoReaderOptions& part)
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
        return;
    }
    VideoReaderOptions options;
    options.from = part.from;
    options.to = part.to;
    video_.emplace(given_.source, options);
    unit_ = video_->facts().timeBase.value();
    if (!video_->read(frame_)) {
        throw Error(ErrorCode::BadFormat, name,
                    "has no depth for this part, expected one picture per frame");
    }
    if (hasColours(frame_.picture)) {
        notes_.push_back({NoteCode::Doubtful,
                          name +
                              ": has colours, and depth has none: their grey value is taken (the "
                              "video comes first, then its depth)"});
    }
    hasAhead_ = video_->read(ahead_);
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
}

void GivenDepth::readImage(std::int64_t number, cv::Mat& raw) {
    const auto count = static_cast<std::int64_t>(pictures_.size());
    missing_ = std::max(missing_, static_cast<double>(number - count + 1));
    const fs::path& file = pictures_[static_cast<std::size_t>(std::min(number, count - 1))];
    Notes notes;
    raw = given_.read(file, &notes);
    for (const Note& note : notes) {
        const std::string text = file.string() + ": " + note.text;
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
