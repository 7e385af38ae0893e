#include "common/video_sink.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D::tools {

namespace {

constexpr double kSegmentSeconds = 6; // what a run that dies loses at most; encoders start slowly
constexpr int kLeastSegmentFrames = 12;
constexpr int kMostSegmentFrames = 600;
constexpr int kUsualSegmentFrames = 180;

} // namespace

VideoSink::VideoSink(const VideoPlan& plan, const VideoWriterOptions& options,
                     const std::string& settings, bool resume, VideoReader& reader)
    : plan_(plan) {
    if (!plan.isFile) {
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
    VideoReader again(plan_.input, plan_.part);
    segments_->finish(&again, complete);
}

} // namespace altiro3D::tools
