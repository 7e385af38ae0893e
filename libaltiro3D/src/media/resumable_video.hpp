#pragma once

#include "altiro3D/video_io.hpp"
#include "base/json_reader.hpp"
#include "base/posix_file.hpp"
#include "media/video_segments.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

/// Options of a video that is written so that an interrupted run can be resumed.
struct ResumableVideoOptions {
    /// Frames per segment, 1..100000. An interrupted run loses the frames of its last, incomplete
    /// segment.
    int segmentFrames = 60;
    bool resume = false;  ///< Resume an earlier run, if there is one; otherwise begin a new run.
    RunSettings settings; ///< All settings that influence the frames; they must be equal to resume.
};

/// Frames and state that an earlier run has left.
struct KeptVideo {
    std::int64_t frames = 0;  ///< Frames in complete segments.
    std::int64_t nextPts = 0; ///< End of the last one, in units of VideoWriterOptions::timeBase.
    SavedState state;         ///< State that the caller passed with the last one.
};

/// Writes a video in segments that stay on the disk if the process is interrupted. finish() joins
/// them without encoding again. A resumed run gives the same bytes as one without interruption.
///
/// The directory `NAME.parts` beside the target `NAME` holds the segments (each is a playable
/// video) and `run.json`, which lists them. It is removed when the file is complete. Sound and the
/// other streams of the source are copied when the segments are joined. An existing target is
/// replaced.
///
/// One thread at a time per object, one process at a time per name.
class ResumableVideoWriter {
  public:
    /// Begins or resumes a run.
    ///
    /// @param path file name with the extension .mkv, .mp4, .m4v or .mov
    /// @param options as for VideoWriter
    /// @param resumable see ResumableVideoOptions
    /// @param source reader of the source video, used in this call only; it must not have delivered
    ///        a frame. It is checked now, so that an unsuitable source fails before any work is
    ///        done. May be null. finish() needs another reader.
    /// @throws Error as VideoWriter; InvalidArgument (segmentFrames); WriteFailed (an unfinished
    ///         run exists and `resume` is not set, or another process uses `NAME.parts`); Mismatch
    ///         (names the setting that differs); BadFormat (damaged contents of `NAME.parts`)
    ResumableVideoWriter(const std::filesystem::path& path, const VideoWriterOptions& options,
                         const ResumableVideoOptions& resumable, VideoReader* source = nullptr);
    /// Keeps all complete segments, unless the video is complete. Without any, `NAME.parts` is
    /// removed.
    ~ResumableVideoWriter();
    ResumableVideoWriter(const ResumableVideoWriter&) = delete;
    ResumableVideoWriter& operator=(const ResumableVideoWriter&) = delete;

    /// What an earlier run has left. @return 0 frames if the run is new
    const KeptVideo& kept() const { return kept_; }
    /// Whether a later run can resume.
    /// @return true if a segment is complete and the video is not
    bool keepsWork() const { return listed_ > 0; }
    /// Whether a frame is the last one of its segment. write() ignores the state of other frames.
    /// @param frameNumber number of the frame, from 0, over all runs
    /// @return true if it is the last one
    bool endsSegment(std::int64_t frameNumber) const {
        return (frameNumber + 1) % segmentFrames_ == 0;
    }

    /// Encodes a frame.
    ///
    /// @param frame as for VideoWriter::write(); the pts of the first frame is kept().nextPts or
    ///        more
    /// @param state state that a later run needs to make the next frame; see endsSegment()
    /// @throws Error InvalidArgument (picture, time, after finish()), WriteFailed; complete
    ///         segments stay
    void write(const VideoFrame& frame, const SavedState& state = {});

    /// Joins all frames written so far and gives the file its name.
    ///
    /// @param source a new reader of the source video, which supplies sound and the other streams;
    ///        may be null
    /// @param complete true: the video is complete and the segments are removed; false: complete
    ///        segments stay, so that a later run can resume
    /// @throws Error InvalidArgument (no frame was written, a second call, a source that has
    ///         delivered a frame), BadFormat (a damaged segment), Unsupported, WriteFailed, and
    ///         exceptions of reading the source
    void finish(VideoReader* source, bool complete = true);

    /// Remarks on what was left out or converted. @return the remarks; finish() may add some
    const Notes& notes() const { return notes_; }

  private:
    void readRun();
    void writeRun();
    void closeSegment(const SavedState& state, bool listed);

    std::filesystem::path path_;
    std::filesystem::path directory_;
    VideoWriterOptions options_;
    int segmentFrames_;
    KeptVideo kept_;
    Notes notes_;
    Json settings_;
    FileHandle lock_;
    std::vector<VideoSegment> segments_; // whole ones
    std::size_t listed_ = 0;             // of them, in run.json
    std::vector<std::string> states_;    // file names of the states after them; empty: none
    std::optional<SegmentWriter> writer_;
    bool finished_ = false;
    bool complete_ = false; // and nothing is kept
};

/// Removes an unfinished run, if there is one.
/// @param path file name of the video
/// @throws Error WriteFailed (another process uses it, no permission)
void discardUnfinishedVideo(const std::filesystem::path& path);

} // namespace altiro3D
