#include "common/video_sink.hpp"

#include "altiro3D/error.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D::tools {

namespace {

constexpr double kSegmentSeconds = 6; // what a run that dies loses at most; encoders start slowly
constexpr int kLeastSegmentFrames = 12;
constexpr int kMostSegmentFrames = 600;
constexpr int kUsualSegmentFrames = 180;

// The same failure, and what this tool offers.
Error withAdvice(const Error& error, const std::string& advice) {
    const std::string text = error.what(); // "subject: problem"
    const std::size_t end = text.find(": ");
    return {error.code(), text.substr(0, end), text.substr(end + 2) + "; " + advice};
}

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
    if (!resume && ResumableVideoWriter::isUnfinished(plan.output)) {
        throw Error(ErrorCode::WriteFailed, plan.output.string(),
                    "an unfinished run of it is kept in " +
                        ResumableVideoWriter::partsDirectory(plan.output).string() +
                        ", expected --resume to continue it, or -y to start again");
    }
    VideoReader probe(plan.input, plan.part);
    try {
        segments_.emplace(plan.output, options, resumable, &probe);
    } catch (const Error& error) {
        const bool isOfAnother =
            error.code() == ErrorCode::Mismatch || error.code() == ErrorCode::BadFormat;
        if (!resume || !isOfAnother) throw;
        throw withAdvice(error, "-y begins again");
    }
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
