#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/video_reader.hpp"
#include "altiro3D/video_types.hpp"
#include "altiro3D/video_writer.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace altiro3D {

/// How a video is written so that a run that dies can go on.
struct ResumableVideoOptions {
    int segmentFrames = 60; ///< Frames that are kept at a time, 1..100000: what a dying run loses.
    bool resume = false;    ///< Go on where an earlier run ended, if there is one.
    /// Everything that shapes the frames, as a JSON object of texts: a run is resumed with the same
    /// settings only.
    std::string settings = "{}";
};

/// What an earlier run has left.
struct KeptVideo {
    std::int64_t frames = 0;  ///< Frames that are written already.
    std::int64_t nextPts = 0; ///< Time of the next one, in the options' time base.
    std::string state;        ///< What the caller gave with the last of them.
};

/// Writes a video in segments that outlive the process, and joins them in the end without encoding
/// again. A run that is resumed gives the same bytes as one that was not interrupted.
///
/// Beside `NAME` a directory `NAME.parts` holds the segments (each of them plays) and `run.json`,
/// which lists them; it goes when the file is complete. The other streams of the source are copied
/// when the segments are joined.
///
/// One thread at a time per object, one process at a time per name.
class ALTIRO3D_EXPORT ResumableVideoWriter {
  public:
    /// Begins or resumes a run.
    ///
    /// @param path .mkv, .mp4, .m4v or .mov
    /// @param options as for VideoWriter
    /// @param resumable see ResumableVideoOptions
    /// @param source the video that the frames are made from, opened for this call only: what the
    ///        file cannot hold of it is said before any work is done; may be null
    /// @throws Error as VideoWriter; InvalidArgument (segmentFrames, settings that are no JSON
    ///         object); WriteFailed (`NAME.parts` is there and `resume` is not set, or another
    ///         process is at it); Mismatch (other settings, by name); BadFormat (what is in
    ///         `NAME.parts`)
    ResumableVideoWriter(const std::filesystem::path& path, const VideoWriterOptions& options,
                         const ResumableVideoOptions& resumable, VideoReader* source = nullptr);
    /// Keeps all whole segments; without any, nothing stays.
    ~ResumableVideoWriter();
    ResumableVideoWriter(ResumableVideoWriter&&) noexcept;            ///< Moves.
    ResumableVideoWriter& operator=(ResumableVideoWriter&&) noexcept; ///< Moves. @return *this

    /// Where a video's segments are.
    /// @param path of the video
    /// @return `path` + ".parts"
    static std::filesystem::path partsDirectory(const std::filesystem::path& path);

    /// Whether an earlier run has left something to go on from.
    /// @param path of the video
    /// @return true if there is a `run.json` in `NAME.parts`
    static bool isUnfinished(const std::filesystem::path& path);

    /// Removes what an earlier run has left; without an unfinished run nothing is done.
    /// @param path of the video
    /// @throws Error WriteFailed (another process is at it, no permission)
    static void discard(const std::filesystem::path& path);

    /// What was there at the beginning. @return 0 frames if the run is new
    const KeptVideo& kept() const;
    /// Whether there is something that a later run can go on from.
    /// @return true if a segment is whole and the video is not complete
    bool keepsWork() const;
    /// Whether a segment ends with a frame; write() keeps a state with such frames only.
    /// @param frameNumber number of the frame, from 0, over all runs
    /// @return true if it does
    bool endsSegment(std::int64_t frameNumber) const;

    /// Encodes a frame.
    ///
    /// @param frame as for VideoWriter; the first one's pts is kept().nextPts or more
    /// @param state what is needed to make the next frame, if this one ends a segment
    /// @throws Error InvalidArgument (picture, time, after finish()), WriteFailed; whole segments
    ///         stay
    void write(const VideoFrame& frame, const std::string& state = {});

    /// Joins all segments and gives the file its name.
    ///
    /// @param source the video that the frames were made from, opened anew for this call; may be
    ///        null
    /// @param complete false: more frames could follow; then the segments stay, so that a later run
    ///        can go on
    /// @throws Error InvalidArgument (no frame was written, a second call, a source that has
    ///         begun), BadFormat (a damaged segment), Unsupported, WriteFailed, and what reading
    ///         the source throws
    void finish(VideoReader* source, bool complete = true);

    /// What was left out or changed. @return one sentence each, for people
    const Notes& notes() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
