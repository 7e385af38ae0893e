#pragma once

#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_io.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace altiro3D {

/// Where the frames of a conversion are written: to segments that a later run can go on from, or,
/// if the input cannot be read once more, straight to the file.
class VideoSink {
  public:
    /// @param conversion its input, part, output and what is done about an unfinished run
    /// @param options of the encoder, complete
    /// @param settings see conversionStamp()
    /// @param reader of the input; its other streams are copied
    /// @throws Error
    VideoSink(const VideoConversion& conversion, const VideoWriterOptions& options,
              const RunSettings& settings, VideoReader& reader);

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
    std::filesystem::path input_;
    VideoReaderOptions part_;
    std::optional<VideoWriter> plain_;
    std::optional<ResumableVideoWriter> segments_;
};

/// Whether the input of a conversion can be read once more.
bool canReadAgain(const std::filesystem::path& input);

} // namespace altiro3D
