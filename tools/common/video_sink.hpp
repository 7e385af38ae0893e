#pragma once

#include "altiro3D/resumable_video.hpp"
#include "altiro3D/video_pipeline.hpp"
#include "altiro3D/video_writer.hpp"
#include "common/video_plan.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace altiro3D::tools {

/// Where the frames of a video go: to segments that a later run can go on from, or, if the input
/// cannot be read once more, straight to the file.
class VideoSink {
  public:
    /// @param plan must outlive this
    /// @param settings see settingsText()
    /// @param resume goes on where an earlier run ended
    /// @param reader whose other streams are copied
    /// @throws Error
    VideoSink(const VideoPlan& plan, const VideoWriterOptions& options, const std::string& settings,
              bool resume, VideoReader& reader);

    /// What an earlier run has left.
    KeptVideo kept() const { return segments_ ? segments_->kept() : KeptVideo(); }
    /// Whether a later run can go on from what there is.
    bool keepsWork() const { return segments_ && segments_->keepsWork(); }
    /// Whether the state after that frame is to be in PipelineFrame::state.
    bool wantsState(std::int64_t frame) const { return segments_ && segments_->endsSegment(frame); }
    void write(const PipelineFrame& frame);
    /// @param complete no: the user has stopped, and may go on later
    void finish(bool complete);
    const Notes& notes() const { return segments_ ? segments_->notes() : plain_->notes(); }

  private:
    const VideoPlan& plan_;
    std::optional<VideoWriter> plain_;
    std::optional<ResumableVideoWriter> segments_;
};

} // namespace altiro3D::tools
