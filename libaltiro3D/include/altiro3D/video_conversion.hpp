#pragma once

#include "altiro3D/depth_source.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/recipe.hpp"
#include "altiro3D/stereo_views.hpp"
#include "altiro3D/video_depth.hpp"
#include "altiro3D/video_io.hpp"
#include "altiro3D/view_options.hpp"

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
    std::int64_t dropped = 0;        ///< Frames of a device or of `show` that were too late.
};

/// Kind of video that a conversion makes.
enum class VideoProduct {
    Native, ///< A Native video for one display.
    Quilt,  ///< A video of quilts for other players, 4:2:0 where the codec allows it.
    Rgbd,   ///< Frame and depth side by side for other players, 4:2:0 where the codec allows it.
    Stereo  ///< Pictures of both eyes for other players, 4:2:0 where the codec allows it, unless
            ///< both are mixed (anaglyph, interleaved).
};

/// How the frames of a video hold both eyes' pictures.
struct StereoVideo {
    StereoLayout layout = StereoLayout::LeftRight; ///< Order of the eyes.
    /// Shape of the halves. Automatic halves follow the shape of the frame in px.
    StereoHalves halves = StereoHalves::Automatic;
};

/// The size of one eye's picture, stretched if halves are squeezed.
/// @param video how frames hold the pictures @param frame size of a frame in px @return px
[[nodiscard]] ALTIRO3D_EXPORT cv::Size photoSize(const StereoVideo& video, cv::Size frame);

/// Shape of a video's halves when shown. Automatic halves follow the frame's shape. Squeezed halves
/// count as full if the file already stretches their px, as Matroska does for stereo films.
/// @param video how frames hold the pictures @param facts of the video
/// @return Full or Squeezed
[[nodiscard]] ALTIRO3D_EXPORT StereoHalves halvesAsShown(const StereoVideo& video,
                                                         const VideoFacts& facts);

/// Result of findEyes().
struct FoundEyes {
    std::optional<StereoVideo> eyes; ///< How frames hold them; nothing: frames are flat pictures.
    /// Evidence for people: "the file states it (side by side)"; empty if nothing was found.
    std::string evidence;
    Notes notes; ///< Doubts: halves that look like a pair, tags that contradict the pictures, ...
};

/// Finds out whether a video's frames hold both eyes' pictures, by what the file states, else by
/// the tag in its name (parseSceneName()). A tag counts only if the halves of at least one examined
/// frame match. A video without either is flat; if its halves match, a note says so.
/// @param input as for VideoReader; only the frames of regular files are looked at, so tags of
///        other inputs do not count
/// @param facts of the input
/// @param options as for VideoReader; `from` and `to` do not matter
/// @return what was found; halves are never Automatic
/// @throws Error Unsupported (the name says that the video is for headsets; the file states a
///         layout that is not read); as VideoReader
[[nodiscard]] ALTIRO3D_EXPORT FoundEyes findEyes(const std::filesystem::path& input,
                                                 const VideoFacts& facts,
                                                 const VideoReaderOptions& options = {});

/// How a video for two eyes is made.
struct VideoEyes {
    EyesPicture picture = EyesPicture::SideBySide; ///< How a frame shows both eyes.
    EyesFrom from = EyesFrom::Both;                ///< Which eyes are rendered.
    bool swapped = false; ///< The left eye sees the right one's picture: depth is reversed.
    /// Keep both pictures as filmed and only change the layout of frames that hold both eyes.
    /// VideoConversion::stereo must be set; no depth is needed.
    bool filmed = false;
};

/// What to do if the output has an unfinished earlier run (isVideoUnfinished()).
enum class UnfinishedRun {
    Refuse, ///< The constructor of VideoConverter throws Error WriteFailed.
    Resume, ///< Continue the earlier run; without one, begin a new run.
    Discard ///< Remove the earlier run and begin a new one.
};

/// The numbers of 16-bit depth that become the ends of 0..1.
struct DepthRange {
    double low = 0;      ///< The number that becomes 0 (FarWhite: 1), 0..65535.
    double high = 65535; ///< The number that becomes 1 (FarWhite: 0), low..65535.
};

/// Existing depth of a video. Exactly one of `source` and `rgbd` must be set.
struct GivenVideoDepth {
    /// A depth video, or a directory with one depth image per frame, sorted as by listImages().
    std::filesystem::path source;
    /// Position of the depth half in RGB-D frames. Automatic halves follow the frame's shape in px.
    std::optional<RgbdLayout> rgbd;
    DepthKind kind = DepthKind::NearWhite; ///< Meaning of the numbers.
    /// Range of 16-bit depth whose `kind` is not Metric. Default: percentiles 0.5 and 99.5 of all
    /// pictures of `source`, read once before the run. Required if `source` can be read only once.
    std::optional<DepthRange> range;
    /// Reads a depth image of the directory, as readDepthSamples(), which is the default.
    std::function<cv::Mat(const std::filesystem::path& file, Notes* notes)> read;
};

/// Reads a depth video for single pictures of its video, and gives the depth that VideoConverter
/// gives these pictures. For players. Move-only; one thread at a time per object.
class ALTIRO3D_EXPORT GivenDepthReader {
  public:
    /// @param given with a depth video as `source`
    /// @param video the facts of the video that the depth belongs to
    /// @throws Error InvalidArgument (`source` is not a file), and as VideoConverter
    GivenDepthReader(GivenVideoDepth given, const VideoFacts& video);
    ~GivenDepthReader();
    GivenDepthReader(GivenDepthReader&&) noexcept;            ///< Moves.
    GivenDepthReader& operator=(GivenDepthReader&&) noexcept; ///< Moves. @return *this

    /// Reads the depth of a picture. A picture that is not later than the last one, or more than
    /// 2 s later, begins a new scene.
    /// @param picture [rows x cols, CV_8UC3, BGR]
    /// @param seconds time of the picture, from the start of the file
    /// @param depth [size of the raw depth, CV_32FC1, 0..1, 1 = nearest]; always in new memory
    /// @return how the depth was made
    /// @throws Error as VideoConverter, when it runs
    VideoDepthStep next(const cv::Mat& picture, double seconds, cv::Mat& depth);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// How a video is converted. A Native video needs only `input`, `output` and `display`.
struct VideoConversion {
    std::filesystem::path input; ///< As for VideoReader.
    VideoReaderOptions part;     ///< The part of the input to convert, as for VideoReader.
    /// A reader of `input` with the options `part`, if it is open already; no frame may have been
    /// read from it. Null: the converter opens the input. Needed if the caller has opened a device
    /// or the standard input, because they can be opened only once.
    std::shared_ptr<VideoReader> reader;
    /// File name with the extension .mkv, .mp4, .m4v or .mov; an existing file is replaced. It must
    /// not be `input`. "-": Matroska to standard output; the run cannot be resumed. Exactly one of
    /// `output` and `show` must be set.
    std::filesystem::path output;
    /// Receives each picture [VideoConverter::size(), CV_8UC3, BGR] at its time, in the thread that
    /// called run(). Frames that are late are dropped. Returns false to cancel the run.
    std::function<bool(const cv::Mat& picture)> show;

    VideoProduct product = VideoProduct::Native;  ///< Kind of video to make.
    VideoEyes eyes;                               ///< For Stereo: layout and source of the eyes.
    StereoHalves rgbdHalves = StereoHalves::Full; ///< For Rgbd: Full or Squeezed.
    /// The display of Natives and quilts. Not needed for Rgbd and Stereo, or if `map` is set.
    std::optional<Display> display;
    /// Look-up table for the Natives. If set, Natives are made from quilts, and `recipe` must have
    /// discrete positions and nearest sampling.
    std::optional<NativeLut> map;
    /// Layout of the quilts. Default: `map`'s, else `display`'s. It must not differ from `map`'s.
    std::optional<QuiltLayout> layout;
    /// How views are rendered and fitted. With `fromQuilt` only `fit` and `sampling` are used, for
    /// Rgbd only `views.focus`. For Stereo, only `views` (kEyesStrength is a good strength),
    /// `refine`, `depthCurve` and `choices` are used: frames are shown whole, at their own size,
    /// and a framing is refused. If `recipe.refine.flaws` is not set, flaws are measured once per
    /// scene; with method Fast, estimated depth is not refined.
    ///
    /// `recipe.choices` are made at the first frame of each scene and hold for the scene. The
    /// strength is chosen for depth of 0..1, because depth changes during a scene. Choices are
    /// refused for Rgbd and with `fromQuilt`.
    Recipe recipe;

    /// The input's frames are quilts. `product` must be Native, `depth` and `given` unset.
    bool fromQuilt = false;
    /// If `fromQuilt` is set: width : height of the scene that a view shows, 0.01..100; 0: the
    /// views are stretched to the panel, and `recipe.fit` is ignored.
    double viewAspect = 0;

    /// Frames hold both eyes' pictures. The left one is the photo, and its depth is found by
    /// matching (matchStereo()) as often as `depthOptions` says. Where the eyes do not match or
    /// show the same picture, `depth` estimates it. With `depthOptions.every` 1, the right eye's
    /// picture also fills disocclusions. Not with `given` and `fromQuilt`.
    std::optional<StereoVideo> stereo;

    /// Source of the depth; null: estimatedDepth(). Ignored if `given` is set.
    std::shared_ptr<DepthSource> depth;
    /// How often depth is estimated and how steady it is. `every` is ignored if `given` is set.
    VideoDepthOptions depthOptions;
    std::optional<GivenVideoDepth> given; ///< Existing depth, used instead of an estimate.

    /// Options of the output. The converter sets `size`, `timeBase`, `frameRate`, `constantRate`,
    /// `native` and `eyes`. For Stereo, it adds a tag. Except for Natives, anaglyphs and interlaced
    /// pictures, it sets `compatible` if the codec is H264 or Hevc.
    VideoWriterOptions encoding;
    /// What to do with an unfinished earlier run. Ignored unless `input` is a regular file.
    UnfinishedRun unfinished = UnfinishedRun::Refuse;
    /// Further settings of the caller, such as command-line options. A run can be resumed only if
    /// they are equal, and the error names the one that differs.
    RunSettings settings;
};

/// What was chosen for a scene.
struct SceneChoice {
    double start = 0;           ///< First frame, s from the start of the part.
    Framing framing;            ///< See NativeOptions::framing.
    double focus = 0;           ///< See ViewOptions::focus.
    double strengthPercent = 0; ///< See ViewOptions::strengthPercent.
};

/// Result of a conversion.
struct VideoConversionResult {
    std::int64_t frames = 0;          ///< Frames made, including those of an earlier run.
    std::int64_t keptFrames = 0;      ///< Frames of an earlier run, which were not made again.
    double end = 0;                   ///< End of the last frame made, s from the start of the part.
    std::int64_t inferences = 0;      ///< Frames of this run for which depth was estimated.
    std::int64_t repeated = 0;        ///< Frames of this run that equal the frame before.
    std::vector<double> cuts;         ///< Scene cuts in this run, s from the start of the part.
    std::vector<SceneChoice> choices; ///< The choices of this run, see VideoConversion::recipe.
    bool cancelled = false;           ///< The progress function or `show` has cancelled the run.
    bool keepsWork = false;           ///< A later run can resume, see VideoConverter::keepsWork().
    /// Times of "decode", "depth" (not for quilts), "render", and "encode" or "show".
    PipelineReport pipeline;
    double finishSeconds = 0; ///< Time to close the file after the last frame, s.
    VideoReadCounts counts;   ///< Counts of the input's reader.
    /// Remarks about the input and its depth; if `counts.truncated`, the first one has the code
    /// CutOff. VideoConverter::notes() has those about the output.
    Notes notes;

    /// Frames made in this run. @return frames - keptFrames
    [[nodiscard]] std::int64_t made() const { return frames - keptFrames; }
    /// Wall time of this run. @return pipeline.seconds + finishSeconds, s
    [[nodiscard]] double seconds() const { return pipeline.seconds + finishSeconds; }
};

/// Converts a video in four stages with one thread each: decode, estimate depth, render, encode.
///
/// Sound, subtitles, chapters and tags are copied. If the input is a regular file, the output is
/// written in segments of about 6 s (12..600 frames), in `NAME.parts` next to it. An interrupted or
/// cancelled run can then be resumed with the same inputs and settings, after its last complete
/// segment; before the end of the first one there is nothing to resume (keepsWork()), and the next
/// run begins anew. A resumed run gives the same bytes as one without interruption. From a device
/// or a pipe, or to standard output, the output is written by VideoWriter and cannot be resumed. If
/// a device delivers frames faster than they are converted, some are dropped.
///
/// Given depth of 8 bits is not normalized: value 0 becomes 0, 255 becomes 1 (FarWhite: reversed).
/// Depth of 16 bits has one range, see GivenVideoDepth::range. Distances and floats have no fixed
/// range; VideoDepth normalizes them with a range that changes slowly. A frame gets the picture of
/// the depth video that is shown at the same time. With a directory, frame n of the whole video
/// gets the n-th depth image. If the depth ends early, its last picture is used for the rest.
///
///     VideoConversion conversion;
///     conversion.input = "clip.mp4";
///     conversion.output = "native.mp4";
///     conversion.display = readDisplay("visual.json");
///     VideoConverter converter(std::move(conversion));
///     const VideoConversionResult result = converter.run();
///
/// One thread at a time per object; run() returns when its threads have ended.
class ALTIRO3D_EXPORT VideoConverter {
  public:
    /// Checks the options and opens input and output.
    /// @param conversion what to convert, and how
    /// @throws Error as VideoReader, VideoWriter (WriteFailed: also an unfinished
    ///         run, see UnfinishedRun; Mismatch: its settings differ), NativeMaker, VideoDepth;
    ///         InvalidArgument (contradictory fields); NotFound, BadFormat (no depth in
    ///         GivenVideoDepth::source)
    explicit VideoConverter(VideoConversion conversion);
    /// Removes an unfinished file. Complete segments stay.
    ~VideoConverter();
    VideoConverter(VideoConverter&&) noexcept;            ///< Moves.
    VideoConverter& operator=(VideoConverter&&) noexcept; ///< Moves. @return *this

    /// Properties of the input, of the whole file. @return the facts; they do not change
    [[nodiscard]] const VideoFacts& facts() const;
    /// Size of the pictures that are made. @return columns x rows in px
    [[nodiscard]] cv::Size size() const;
    /// The progress. Do not call it during run(), whose `goOn` receives it.
    /// @return before run(): the frames of an earlier run, or 0, and the expected length
    [[nodiscard]] const VideoProgress& progress() const;
    /// Remarks on streams of the input that the output leaves out or converts.
    /// @return the remarks, complete after run()
    [[nodiscard]] const Notes& notes() const;
    /// Whether a later run can resume, also after an exception of run().
    /// @return true if a segment is complete and the output is not; false for a run that was
    ///         cancelled before its first complete segment
    [[nodiscard]] bool keepsWork() const;

    /// Converts the video. A cancelled run still converts the frames that were read already (about
    /// a dozen) and closes the file, which can be played. A later run can resume if keepsWork().
    /// Without frames, no file is written. With `show`, a cancelled run shows no further picture.
    /// @param goOn receives the progress before each frame is read and after each frame is made,
    ///        from several threads, never two at a time. It is called once more before the file is
    ///        closed (VideoProgress::finishing); this return value is ignored. May be empty.
    /// @return counts, times and remarks
    /// @throws Error InvalidArgument (a second call); BadFormat (no frames in the part, broken
    ///         depth), WriteFailed; also exceptions of reading, depth and rendering, and of the
    ///         caller's functions. Complete segments stay, see keepsWork().
    VideoConversionResult run(const VideoProgressFunction& goOn = {});

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Formats a time of a video for people.
/// @param seconds time in s; negative values count as 0
/// @return minutes and seconds "0:05.2", from one hour on with hours "1:02:03.4"
[[nodiscard]] ALTIRO3D_EXPORT std::string clockText(double seconds);

// The conversion of a video by many machines that share a folder: a plan divides it into chunks,
// each chunk is made by any machine at any time, and the join writes the file. Its bytes are those
// of VideoConverter with the same conversion on one machine.
//
//     planVideoChunks(conversion(), "film.plan");                     // once
//     makeVideoChunk(conversion(), "film.plan", 7);                   // each number, anywhere
//     joinVideoChunks(conversion(), "film.plan");                     // once
//
// A chunk consists of whole segments of the output. Depth is carried from frame to frame within a
// scene, so a chunk that begins inside a scene first makes depth alone, without pictures, from the
// scene's first frame or from the last state that another chunk left in the folder.
//
// Each call may be repeated, interrupted at any time, and run twice at the same time: results are
// written next to their final name, checked and renamed. A call compares the conversion with the
// one of the plan, including size and time of all input files, and refuses a different one. The
// number of threads (`cv::setNumThreads()`, VideoWriterOptions::threads) is part of it, because the
// output of networks and encoders depends on it.

/// A piece of work of a plan.
struct VideoChunk {
    /// First frame whose depth is made, if no other chunk has left a state. Frames are counted from
    /// 0 at the start of the part.
    std::int64_t begin = 0;
    /// First frame whose picture is made, `begin` or later. The frames from `begin` up to it get
    /// depth only.
    std::int64_t first = 0;
    /// Frames whose pictures are made. 0: the chunk makes depth alone, for the chunks that begin
    /// inside one long scene. Without it, each of these would make depth from the scene's first
    /// frame.
    std::int64_t frames = 0;
    double start = 0; ///< Time of frame `first`, s from the start of the part.
    double end = 0;   ///< End of the last frame, s from the start of the part.
};

/// A video divided into chunks.
struct VideoChunkPlan {
    /// Chunks in the order in which to start them: first those without pictures, which save other
    /// chunks work, then the others, the longest first. Chunk number N is `chunks[N - 1]`.
    std::vector<VideoChunk> chunks;
    std::int64_t frames = 0; ///< Frames of the video.
    double end = 0;          ///< End of the last frame, s from the start of the part.
    /// Frames whose depth is made twice, if the chunks without pictures are made first.
    std::int64_t repeatedFrames = 0;
    int threads = 1;        ///< Number for `cv::setNumThreads()` with which chunks must be made.
    double seconds = 0;     ///< Time that the plan took, s.
    bool cancelled = false; ///< The progress function has cancelled the plan; nothing was written.
    Notes notes;            ///< Remarks about the input and the output.
};

/// How a video is divided.
struct VideoChunkOptions {
    /// Desired length of a chunk, 1..86400 s. Chunks end between segments, soon after a scene cut
    /// if there is one. They have half to one and a half of this length (the last one may be
    /// shorter), and at least one segment.
    double seconds = 60;
};

/// Divides a video into chunks: reads it once, finds the scene cuts, and writes the plan. If the
/// folder already holds the plan of the same conversion and length, that plan is returned.
/// @param conversion as for VideoConverter; `input` must be a regular file, `show` empty. With
///        UnfinishedRun::Discard, any plan in the folder, even an equal one, is removed with its
///        chunks first.
/// @param directory the folder; it is made if it does not exist. All machines must see it.
/// @param options length of the chunks
/// @param goOn receives the progress before each frame; may be empty
/// @return the plan
/// @throws Error as VideoConverter; InvalidArgument (an input that is not a file, options);
///         WriteFailed (the folder holds other files); Mismatch (a plan of another conversion)
[[nodiscard]] ALTIRO3D_EXPORT VideoChunkPlan
planVideoChunks(VideoConversion conversion, const std::filesystem::path& directory,
                const VideoChunkOptions& options = {}, const VideoProgressFunction& goOn = {});

/// Reads a plan.
/// @param directory the folder
/// @return the plan
/// @throws Error NotFound, ReadFailed, BadFormat (no plan, a damaged one)
[[nodiscard]] ALTIRO3D_EXPORT VideoChunkPlan
readVideoChunks(const std::filesystem::path& directory);

/// Whether a chunk is made: its files are there and have the right size.
/// @param directory the folder of the plan
/// @param number number of the chunk, 1..number of chunks
/// @return false also for a chunk of another plan
/// @throws Error as readVideoChunks(); InvalidArgument (number)
[[nodiscard]] ALTIRO3D_EXPORT bool isVideoChunkMade(const std::filesystem::path& directory,
                                                    int number);

/// Makes a chunk. If it is made already and its files are undamaged, nothing is done.
/// @param conversion equal to that of the plan
/// @param directory the folder of the plan
/// @param number number of the chunk, 1..number of chunks
/// @param goOn receives the progress of the chunk, as for VideoConverter::run(); may be empty
/// @return counts and times; `keptFrames` is the number of frames if the chunk was made already. A
///         cancelled chunk leaves nothing.
/// @throws Error as VideoConverter and readVideoChunks(); Mismatch (names the setting or the input
///         that differs from the plan)
ALTIRO3D_EXPORT VideoConversionResult makeVideoChunk(VideoConversion conversion,
                                                     const std::filesystem::path& directory,
                                                     int number,
                                                     const VideoProgressFunction& goOn = {});

/// Checks all chunks, joins them without encoding again, and writes VideoConversion::output with
/// sound, subtitles and chapters. The chunks stay.
/// @param conversion equal to that of the plan, except for the name of the output
/// @param directory the folder of the plan
/// @param goOn receives the progress before each segment is copied; may be empty
/// @return `frames`, `keptFrames`, `end`, `cancelled`, `finishSeconds`, `notes`
/// @throws Error as VideoWriter and readVideoChunks(); NotFound (chunks that are not made);
///         BadFormat (names a damaged file and its chunk); Mismatch (another conversion; chunks
///         made by machines whose depth differs)
ALTIRO3D_EXPORT VideoConversionResult joinVideoChunks(VideoConversion conversion,
                                                      const std::filesystem::path& directory,
                                                      const VideoProgressFunction& goOn = {});

} // namespace altiro3D
