#pragma once

#include "altiro3D/depth_source.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/video_depth.hpp"
#include "altiro3D/video_io.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

/// A frame in a pipeline. Frames and their memory are reused. A stage that keeps a reference to a
/// picture forces later writers to allocate new memory, see ownMemory().
struct PipelineFrame {
    std::int64_t number = 0; ///< From 0, in the order of display.
    VideoFrame source;       ///< The frame as read.
    cv::Mat depth;           ///< [any size, CV_32FC1, 0..1, 1 = nearest]
    VideoDepthStep step;     ///< How the depth was made.
    VideoFrame result;       ///< The frame to write.
    SavedState state;        ///< What a later run needs to resume after this frame; usually empty.
};

/// One processing step, applied to every frame.
struct PipelineStage {
    std::string name; ///< For reports: "decode", "depth", "render", "encode".
    /// Processes a frame. It is called for all frames in order, in one thread. Returning false ends
    /// the run: the frame is dropped, earlier stages stop, and later stages finish their frames.
    std::function<bool(PipelineFrame&)> work;
};

/// Options of a pipeline.
struct PipelineOptions {
    int queueFrames = 3; ///< Frames that may wait between two stages, 1..64.
    bool threads = true; ///< One thread per stage; false: all stages in one thread, for comparison.
    /// For live input: the first stage never waits. If queueFrames frames already wait behind it,
    /// the oldest one is dropped. With queueFrames = 1 the second stage always gets the newest
    /// frame.
    bool dropLate = false;
};

/// Statistics of a stage.
struct StageReport {
    std::string name;        ///< Name of the stage.
    std::int64_t frames = 0; ///< Frames it processed.
    double seconds = 0;      ///< Processing time of all frames, s.
    double longest = 0;      ///< Processing time of the slowest frame, s.
};

/// Statistics of a pipeline run.
struct PipelineReport {
    std::vector<StageReport> stages; ///< In order.
    double seconds = 0;              ///< Wall time of the run, s.
    std::int64_t dropped = 0;        ///< Frames dropped by PipelineOptions::dropLate.
};

/// Prepares a picture for writing: if its memory is shared, the reference is released, and
/// `create()` then allocates new memory.
///
/// @param picture [any size and type]; empty afterwards if its memory is shared, else unchanged
ALTIRO3D_EXPORT void ownMemory(cv::Mat& picture);

/// Runs frames through stages, each in its own thread, with short queues between them. Memory does
/// not grow with the length of the video, and results do not depend on the speed of the stages.
///
/// Returns when the last frame has passed the last stage. If a stage throws, all stages stop and
/// the exception is rethrown here.
///
/// @param stages one or more, in processing order
/// @param options queue length, threads and live input
/// @return statistics of each stage
/// @throws Error InvalidArgument (no stage, queueFrames); exceptions of the stages pass through
ALTIRO3D_EXPORT PipelineReport runPipeline(const std::vector<PipelineStage>& stages,
                                           const PipelineOptions& options = {});

/// What a video becomes.
enum class VideoProduct {
    Native, ///< A Native video for the display.
    Quilt,  ///< A video of quilts for other players, 4:2:0 where the codec allows it.
    Rgbd    ///< Frame and depth side by side for other players, 4:2:0 where the codec allows it.
};

/// What is done about an earlier run of the same output that has not ended.
enum class UnfinishedRun {
    Refuse, ///< It is an error.
    Resume, ///< The run goes on where it ended; without one a new run begins.
    Discard ///< It is removed, and a new run begins.
};

/// Depth that comes with a video. At most one of `source` and `side` is set.
struct GivenVideoDepth {
    /// A video, or a directory with one depth picture per frame in the order of their names.
    std::filesystem::path source;
    std::optional<DepthSide> side;         ///< Each frame is an RGB-D picture: where its depth is.
    DepthKind kind = DepthKind::NearWhite; ///< Meaning of the numbers.
    /// Reads a picture of the directory as readDepthSamples() does, which is used if it is empty.
    std::function<cv::Mat(const std::filesystem::path& file, Notes* notes)> read;
};

/// How a video is converted. Input, output and display are enough.
struct VideoConversion {
    std::filesystem::path input; ///< As for VideoReader.
    VideoReaderOptions part;     ///< The part of the input that is converted, as for VideoReader.
    /// The input if it is open already, without a frame read from it; may be null. A device and
    /// the standard input can be opened only once.
    std::unique_ptr<VideoReader> reader;
    std::filesystem::path output; ///< .mkv, .mp4, .m4v or .mov; empty: `show` takes the pictures.
    /// Takes each picture [size() of the converter, CV_8UC3, BGR] when it is due, in the thread of
    /// run(). Frames that are late are left out. False ends the run.
    std::function<bool(const cv::Mat& picture)> show;

    VideoProduct product = VideoProduct::Native; ///< What the video becomes.
    /// What Natives and quilts are made for. Not needed for Rgbd and beside `map`.
    std::optional<Display> display;
    std::optional<NativeLut> map; ///< Look-up table through which Natives are made.
    /// Layout of the quilts; nothing: that of `map`, else the display's.
    std::optional<QuiltLayout> layout;
    NativeOptions native; ///< Method, knobs and fit. Frames that are quilts need the fit only.

    bool fromQuilt = false; ///< Frames are quilts; product is Native.
    /// Of frames that are quilts: width : height of what a view shows, 0.01..100; 0: the panel's.
    double viewAspect = 0;

    /// Estimates the depth; null: depthFromCues(). Not used with `given` depth and for quilts.
    std::unique_ptr<DepthSource> depth;
    VideoDepthOptions depthOptions;       ///< How often depth is estimated and how steady it is.
    std::optional<GivenVideoDepth> given; ///< Depth that need not be estimated.

    VideoWriterOptions encoding; ///< Size, times and `compatible` of quilts and RGB-D are set here.
    UnfinishedRun unfinished = UnfinishedRun::Refuse; ///< Of an output whose input is a file.
    /// The caller's own settings: they are compared when a run is resumed, before those of this
    /// structure, and named in the error.
    RunSettings settings;
    bool threads = true; ///< See PipelineOptions::threads.
};

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
    Notes notes; ///< About the input; the first one is CutOff where `counts.truncated`.

    /// Frames of this run. @return frames that were made and not kept
    [[nodiscard]] std::int64_t made() const { return frames - keptFrames; }
    /// Time of this run. @return pipeline and finish, s
    [[nodiscard]] double seconds() const { return pipeline.seconds + finishSeconds; }
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
    [[nodiscard]] const VideoFacts& facts() const;
    /// Size of the pictures that are made. @return columns x rows in px
    [[nodiscard]] cv::Size size() const;
    /// How far it is. @return before run(): what an earlier run has left
    [[nodiscard]] const VideoProgress& progress() const;
    /// What the output cannot hold of the input. @return one sentence each, for people
    [[nodiscard]] const Notes& notes() const;
    /// Whether a later run can go on, also after an exception.
    /// @return true if a segment is whole and the output is not complete
    [[nodiscard]] bool keepsWork() const;

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
[[nodiscard]] ALTIRO3D_EXPORT std::string clockText(double seconds);

} // namespace altiro3D
