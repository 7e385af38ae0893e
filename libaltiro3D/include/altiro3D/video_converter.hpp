#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_pipeline.hpp"
#include "altiro3D/video_types.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

/// How far a conversion is.
struct VideoProgress {
    std::int64_t frames = 0;     ///< Frames that are made, those of an earlier run included.
    std::int64_t keptFrames = 0; ///< Of these, frames of an earlier run.
    double end = 0;              ///< Where they end, s from the beginning of the part.
    std::optional<std::int64_t> framesInAll; ///< Frames to be made, as far as known.
    std::optional<double> length;            ///< Length of the part, s, as far as known.
    bool finishing = false; ///< All frames are with the encoder; the file is being closed.
};

/// Takes the progress and says whether to go on.
using VideoProgressFunction = std::function<bool(const VideoProgress& progress)>;

/// What a conversion has made.
struct VideoConversionResult {
    std::int64_t frames = 0;     ///< Frames that were made, those of an earlier run included.
    std::int64_t keptFrames = 0; ///< Of these, frames of an earlier run.
    double end = 0;              ///< Where they end, s from the beginning of the part.
    std::int64_t inferences = 0; ///< Frames of this run for which depth was estimated.
    std::int64_t repeated = 0;   ///< Frames of this run that equal the one before.
    std::vector<double> cuts;    ///< Scene cuts of this run, s from the beginning of the part.
    bool cancelled = false;      ///< The progress function or `show` has ended the run.
    bool keepsWork = false;      ///< A later run can go on.
    PipelineReport pipeline;     ///< Times of the stages "decode", "depth", "render", "encode".
    double finishSeconds = 0;    ///< After the pipeline: the last encoded frames, the whole file.
    VideoReadCounts counts;      ///< What the reader of the input met.
    Notes notes; ///< For people; the first one tells of the cut where `counts.truncated`.

    /// Frames of this run. @return frames that were made and not kept
    std::int64_t made() const { return frames - keptFrames; }
    /// Time of this run. @return pipeline and finish, s
    double seconds() const { return pipeline.seconds + finishSeconds; }
};

/// Converts a video: decodes, finds depth, renders and encodes, each in a thread of its own.
///
/// A file is written in segments beside the output (ResumableVideoWriter), so that a run that was
/// interrupted can be resumed with the same inputs and settings. A run that was resumed gives the
/// bytes of one that was not. Other inputs are written at once (VideoWriter). Sound, subtitles,
/// chapters and tags come along. From a device, frames that come too fast are left out.
///
/// Given depth of 8 and 16 bits is used as it is: 0 is 0, the largest value is 1. Distances and
/// floating-point numbers have no range of their own; VideoDepth gives them one that follows
/// slowly. Of a depth video the picture counts that is shown at the time of the frame, of a
/// directory the picture of the frame's number in the whole video. Its last one stays if it ends
/// too early.
///
/// One thread at a time per object; run() returns when its threads have ended.
class ALTIRO3D_EXPORT VideoConverter {
  public:
    /// Checks all that can be checked, opens inputs and output.
    ///
    /// @param conversion what is converted, and how
    /// @throws Error as VideoReader, VideoWriter, ResumableVideoWriter (Mismatch: a run with other
    ///         settings is to be resumed), NativeMaker, VideoDepth; InvalidArgument (fields that do
    ///         not go together); NotFound, BadFormat (no depth in the given source)
    explicit VideoConverter(VideoConversion conversion);
    /// Removes an unfinished file; whole segments stay.
    ~VideoConverter();
    VideoConverter(VideoConverter&&) noexcept;            ///< Moves.
    VideoConverter& operator=(VideoConverter&&) noexcept; ///< Moves. @return *this

    /// What the input says about itself. @return the facts, the same all the time
    const VideoFacts& facts() const;
    /// Size of the pictures that are made. @return columns x rows in px
    cv::Size size() const;
    /// How far it is. @return before run(): what an earlier run has left
    const VideoProgress& progress() const;
    /// What the output cannot hold of the input. @return one sentence each, for people
    const Notes& notes() const;
    /// Whether a later run can go on, also after an exception.
    /// @return true if a segment is whole and the output is not complete
    bool keepsWork() const;

    /// Converts the video. A run that is cancelled ends the file properly after the frames that are
    /// on their way, and what is there can be resumed. If not one frame is made, no file is.
    ///
    /// @param goOn called before each frame is read and after each is made, from several threads
    ///        but never two at a time, and once when the file is closed (then its value does not
    ///        count). False cancels the run. May be empty.
    /// @return what was made
    /// @throws Error InvalidArgument (a second call); BadFormat (no frames in the part, broken
    ///         depth), WriteFailed, and what reading, depth and rendering throw, and what the
    ///         functions of the caller throw. Whole segments stay, see keepsWork().
    VideoConversionResult run(const VideoProgressFunction& goOn = {});

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// A time of a video for people.
/// @param seconds s, shown as 0 if less
/// @return "0:05.2" or "1:02:03.4"
ALTIRO3D_EXPORT std::string clockText(double seconds);

} // namespace altiro3D
