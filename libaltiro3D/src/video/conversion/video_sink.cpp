#include "video/conversion/video_sink.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D {

namespace {

constexpr double kSegmentSeconds =
    6; // an interrupted run loses at most this; encoders start slowly
constexpr int kMinSegmentFrames = 12;
constexpr int kMaxSegmentFrames = 600;
constexpr int kUsualSegmentFrames = 180;

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

VideoSink::VideoSink(const VideoConversion& conversion, const VideoWriterOptions& options,
                     const RunSettings& settings, VideoReader& reader)
    : input_(conversion.input), part_(conversion.part) {
    if (!canReadAgain(input_)) {
        plain_.emplace(conversion.output, options, &reader);
        return;
    }
    if (conversion.unfinished == UnfinishedRun::Discard) discardUnfinishedVideo(conversion.output);
    ResumableVideoOptions resumable;
    resumable.settings = settings;
    resumable.resume = conversion.unfinished == UnfinishedRun::Resume;
    resumable.segmentFrames = segmentFramesFor(options.frameRate);
    VideoReader probe(input_, part_);
    segments_.emplace(conversion.output, options, resumable, &probe);
}

VideoSink::VideoSink(const ChunkRange& range, const VideoWriterOptions& options)
    : borders_(range.borders) {
    chunk_.emplace(range.directory, options, range.segmentFrames,
                   static_cast<std::size_t>(range.first / range.segmentFrames));
    kept_.frames = range.begin;
    kept_.nextPts = range.beginPts;
    kept_.state = range.state;
}

const Notes& VideoSink::notes() const {
    static const Notes kNone;
    if (chunk_) return kNone;
    return segments_ ? segments_->notes() : plain_->notes();
}

void VideoSink::write(const PipelineFrame& frame) {
    if (chunk_) {
        if (chunk_->write(frame.result)) chunkSegments_.push_back(chunk_->end());
    } else if (segments_) {
        segments_->write(frame.result, frame.state);
    } else {
        plain_->write(frame.result);
    }
}

void VideoSink::finish(bool complete) {
    if (chunk_) {
        if (chunk_->hasBegun()) chunkSegments_.push_back(chunk_->end());
        return;
    }
    if (plain_) {
        plain_->finish();
        return;
    }
    VideoReader again(input_, part_);
    segments_->finish(&again, complete);
}

} // namespace altiro3D
