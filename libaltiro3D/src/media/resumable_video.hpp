#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/video_io.hpp"
#include "base/json_reader.hpp"
#include "base/system_file.hpp"
#include "media/video_segments.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

/// Videos whose interrupted runs can be resumed, and the JSON files of such runs and of chunks.
namespace altiro3D {

constexpr std::uintmax_t kMaxRunBytes = std::uintmax_t{64} << 20; ///< Limit for a run's JSON file.
constexpr JsonLimits kRunLimits{8, 1000, false};                  ///< Ours have 3 levels.
constexpr std::int64_t kLatestPts = std::numeric_limits<std::int64_t>::max() / 8;

/// Calls `read`, which reads the members of a JSON file that this library has written. A member
/// that is missing, of another type or out of range is reported as damage of the file.
/// @throws Error BadFormat
template <class Read>
auto readingMembers(const std::filesystem::path& file, const Read& read) {
    try {
        return read();
    } catch (const Json::exception&) { // the next line throws
    } catch (const std::out_of_range&) {
    }
    throw Error(ErrorCode::BadFormat, file.string(),
                "is damaged, expected the file as it was written");
}
/// For readingMembers(): a condition that undamaged files fulfil.
inline void require(bool condition) {
    if (!condition) throw std::out_of_range("a member");
}
/// For readingMembers(): a whole number least..most, of 0 or more.
std::int64_t wholeNumber(const Json& value, std::int64_t least, std::int64_t most);
/// For readingMembers(): a number of 64 bits, such as a checksum.
std::uint64_t bitsOf(const Json& value);
/// The text of a JSON file. Bytes that are not UTF-8 are replaced.
std::string runFileText(const Json& value);

/// A segment as JSON files hold it.
Json jsonOf(const VideoSegment& segment);
/// For readingMembers(): the opposite of jsonOf(). @param folder of its file @param mostFrames it
/// may have
VideoSegment segmentOf(const Json& entry, const std::filesystem::path& folder, int mostFrames);

/// Reads run.json, the list of an unfinished run.
/// @param directory unfinishedVideoDirectory()
/// @throws Error ReadFailed, BadFormat
Json readRunFile(const std::filesystem::path& directory);

/// The settings as a file holds them: bytes that are not UTF-8 are replaced.
Json settingsJson(const RunSettings& settings);

/// The first setting that differs, as a sentence; empty if none does. Settings that only one run
/// has come first, because other differences may follow from them.
std::string differenceOf(const Json& before, const Json& now);

/// Options of a video that is written so that an interrupted run can be resumed.
struct ResumableVideoOptions {
    int segmentFrames = 60; ///< 1..100000. An interrupted run loses its last, incomplete segment.
    bool resume = false;    ///< Resume an earlier run, if there is one; otherwise begin a new run.
    RunSettings settings;   ///< All that influence the frames; they must be equal to resume.
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
/// video) and `run.json`, which lists them. It is removed when the file is complete.
///
/// One process at a time per name.
class ResumableVideoWriter {
  public:
    /// Begins or resumes a run.
    /// @param source reader of the source video, used in this call only, so that an unsuitable
    ///        source fails before any work is done; it must not have delivered a frame. May be
    ///        null.
    /// @throws Error as VideoWriter; InvalidArgument (segmentFrames); WriteFailed (an unfinished
    ///         run exists and `resume` is not set, or another process uses `NAME.parts`); Mismatch
    ///         (names the setting that differs); BadFormat (damaged contents of `NAME.parts`)
    ResumableVideoWriter(const std::filesystem::path& path, const VideoWriterOptions& options,
                         const ResumableVideoOptions& resumable, VideoReader* source = nullptr);
    /// Keeps complete segments, unless the video is complete; without any, removes `NAME.parts`.
    ~ResumableVideoWriter();
    ResumableVideoWriter(const ResumableVideoWriter&) = delete;
    ResumableVideoWriter& operator=(const ResumableVideoWriter&) = delete;

    /// What an earlier run has left. @return 0 frames if the run is new
    const KeptVideo& kept() const { return kept_; }
    /// Whether a segment is complete and the video is not: a later run can resume.
    bool keepsWork() const { return listed_ > 0; }
    /// Whether a frame is the last one of its segment. @param frameNumber from 0, over all runs
    bool endsSegment(std::int64_t frameNumber) const {
        return (frameNumber + 1) % segmentFrames_ == 0;
    }

    /// Encodes a frame; complete segments stay if it fails.
    /// @param frame the pts of the first one is kept().nextPts or more
    /// @param state what a later run needs to make the next frame; ignored unless endsSegment()
    /// @throws Error InvalidArgument (picture, time, after finish()), WriteFailed
    void write(const VideoFrame& frame, const SavedState& state = {});

    /// Joins all frames written so far and gives the file its name.
    /// @param source new reader of the source video, for sound and the other streams; may be null
    /// @param complete false: complete segments stay, so that a later run can resume
    /// @throws Error InvalidArgument (no frame was written, a second call, a source that has
    ///         delivered a frame), BadFormat (a damaged segment), Unsupported, WriteFailed, and
    ///         exceptions of reading the source
    void finish(VideoReader* source, bool complete = true);

    /// Remarks on what was left out or converted; finish() may add some.
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
    std::size_t listed_ = 0;             // number of segments in run.json
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
