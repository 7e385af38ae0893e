#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_io.hpp"

#include <cstdint>
#include <filesystem>
#include <vector>

/// @file
/// The conversion of a video by many machines that share a folder: a plan divides it into chunks,
/// each chunk is made by any machine at any time, and the join writes the file. Its bytes are those
/// of VideoConverter with the same conversion on one machine.
///
///     planVideoChunks(conversion(), "film.plan");                     // once
///     makeVideoChunk(conversion(), "film.plan", 7);                   // each number, anywhere
///     joinVideoChunks(conversion(), "film.plan");                     // once
///
/// A chunk consists of whole segments of the output. Depth is carried from frame to frame within a
/// scene, so a chunk that begins inside a scene first makes depth alone, without pictures, from the
/// scene's first frame or from the last state that another chunk left in the folder.
///
/// Each call may be repeated, interrupted at any time, and made twice at once: results are written
/// beside their final name, checked and renamed. A call compares the conversion with the one of the
/// plan, including size and time of all input files, and refuses another one. The number of
/// threads (`cv::setNumThreads()`, VideoWriterOptions::threads) is part of it, because networks and
/// encoders give other bits with another number.

namespace altiro3D {

/// A piece of work of a plan.
struct VideoChunk {
    /// First frame whose depth is made if no state was left by another chunk, from 0 in the part.
    std::int64_t begin = 0;
    std::int64_t first = 0; ///< First frame whose picture is made; begin..first.
    /// Frames whose pictures are made. 0: the chunk makes depth alone, for chunks that begin inside
    /// one long scene. Without it these chunks would each make the depth from its first frame.
    std::int64_t frames = 0;
    double start = 0; ///< Time of frame `first`, s from the start of the part.
    double end = 0;   ///< End of the last frame, s from the start of the part.
};

/// A video divided into chunks.
struct VideoChunkPlan {
    /// In the order in which they should be started: first those without pictures, on which others
    /// wait, then the longest. Chunk number N is `chunks[N - 1]`.
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
    /// if there is one, and have half to one and a half of this length, and at least one segment.
    double seconds = 60;
};

/// Divides a video into chunks: reads it once, finds the scene cuts, and writes the plan. If the
/// folder already holds the plan of the same conversion and length, that plan is returned.
///
/// @param conversion as for VideoConverter; `input` must be a regular file, `show` empty. With
///        UnfinishedRun::Discard, another plan in the folder is removed with its chunks.
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
///
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
///
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
