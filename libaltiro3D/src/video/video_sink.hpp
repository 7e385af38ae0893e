#pragma once

#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_io.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace altiro3D {

/// Writes the frames of a conversion: to segments, from which a later run can continue, or directly
/// to the file if the input cannot be read again.
class VideoSink {
  public:
    /// @param conversion its input, part, output and treatment of an unfinished run are used
    /// @param options of the encoder, complete
    /// @param settings see conversionStamp()
    /// @param reader of the input; its other streams are copied
    /// @throws Error
    VideoSink(const VideoConversion& conversion, const VideoWriterOptions& options,
              const RunSettings& settings, VideoReader& reader);

    /// The work that an earlier run has kept.
    KeptVideo kept() const { return segments_ ? segments_->kept() : KeptVideo(); }
    /// Whether a later run can continue.
    bool keepsWork() const { return segments_ && segments_->keepsWork(); }
    /// Whether PipelineFrame::state must hold the state after that frame.
    bool wantsState(std::int64_t frame) const { return segments_ && segments_->endsSegment(frame); }
    void write(const PipelineFrame& frame);
    /// @param complete false: the user has stopped and may continue later
    void finish(bool complete);
    const Notes& notes() const { return segments_ ? segments_->notes() : plain_->notes(); }

  private:
    std::filesystem::path input_;
    VideoReaderOptions part_;
    std::optional<VideoWriter> plain_;
    std::optional<ResumableVideoWriter> segments_;
};

/// Whether the input of a conversion can be read again.
bool canReadAgain(const std::filesystem::path& input);

} // namespace altiro3D
