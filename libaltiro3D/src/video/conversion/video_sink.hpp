#pragma once

#include "altiro3D/video_io.hpp"
#include "media/resumable_video.hpp"
#include "media/video_segments.hpp"
#include "video/conversion/video_pipeline.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <vector>

namespace altiro3D {

/// The frames of a conversion that a chunk makes; they count from 0 in the part of the video.
struct ChunkRange {
    std::int64_t begin = 0;          ///< From here on depth is made, from `first` on also pictures.
    std::int64_t beginPts = 0;       ///< time of that frame
    SavedState state;                ///< State before that frame; empty: a scene begins there.
    std::int64_t first = 0;          ///< first frame to write; it begins a segment
    std::int64_t frames = 0;         ///< frames to write
    int segmentFrames = 1;           ///< frames of a segment
    std::filesystem::path directory; ///< receives the segments
    std::set<std::int64_t> borders;  ///< Frames before which `keep` receives the state.
    std::function<void(std::int64_t frame, const SavedState& state)> keep;

    std::int64_t end() const { return first + frames; }
};

/// Frames of a segment of a conversion's output.
int segmentFramesFor(const Fraction& rate);

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

    /// Writes the segments of a chunk, which are not joined.
    VideoSink(const ChunkRange& range, const VideoWriterOptions& options);

    /// The work that an earlier run has kept.
    KeptVideo kept() const { return segments_ ? segments_->kept() : kept_; }
    /// Whether a later run can continue.
    bool keepsWork() const { return segments_ && segments_->keepsWork(); }
    /// Whether PipelineFrame::state must hold the state after that frame.
    bool wantsState(std::int64_t frame) const {
        return segments_ ? segments_->endsSegment(frame) : borders_.count(frame + 1) > 0;
    }
    void write(const PipelineFrame& frame);
    /// @param complete false: the user has stopped and may continue later
    void finish(bool complete);
    /// The segments of a chunk, after finish().
    const std::vector<VideoSegment>& chunk() const { return chunkSegments_; }
    const Notes& notes() const;

  private:
    std::filesystem::path input_;
    VideoReaderOptions part_;
    std::optional<VideoWriter> plain_;
    std::optional<ResumableVideoWriter> segments_;
    // of a chunk
    std::optional<SegmentWriter> chunk_;
    std::vector<VideoSegment> chunkSegments_;
    std::set<std::int64_t> borders_;
    KeptVideo kept_;
};

/// Whether the input of a conversion can be read again.
bool canReadAgain(const std::filesystem::path& input);

} // namespace altiro3D
