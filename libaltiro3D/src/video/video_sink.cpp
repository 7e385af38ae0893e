#include "video/video_sink.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D {

namespace {

constexpr double kSegmentSeconds =
    6; // an interrupted run loses at most this; encoders start slowly
constexpr int kMinSegmentFrames = 12;
constexpr int kMaxSegmentFrames = 600;
constexpr int kUsualSegmentFrames = 180;

int segmentFrames(const Fraction& rate) {
    if (!rate.isKnown()) return kUsualSegmentFrames;
    return static_cast<int>(std::clamp<double>(std::round(rate.value() * kSegmentSeconds),
                                               kMinSegmentFrames, kMaxSegmentFrames));
}

} // namespace

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
    if (conversion.unfinished == UnfinishedRun::Discard)
        ResumableVideoWriter::discard(conversion.output);
    ResumableVideoOptions resumable;
    resumable.settings = settings;
    resumable.resume = conversion.unfinished == UnfinishedRun::Resume;
    resumable.segmentFrames = segmentFrames(options.frameRate);
    VideoReader probe(input_, part_);
    segments_.emplace(conversion.output, options, resumable, &probe);
}

void VideoSink::write(const PipelineFrame& frame) {
    if (segments_) {
        segments_->write(frame.result, frame.state);
    } else {
        plain_->write(frame.result);
    }
}

void VideoSink::finish(bool complete) {
    if (plain_) {
        plain_->finish();
        return;
    }
    VideoReader again(input_, part_);
    segments_->finish(&again, complete);
}

} // namespace altiro3D
