#pragma once

#include "altiro3D/video_conversion.hpp"
#include "base/json_reader.hpp"
#include "media/video_segments.hpp"
#include "video/conversion/conversion_run.hpp"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// The files in the folder of a plan: the plan, the records of made chunks, and states for others.
namespace altiro3D {

constexpr const char* kChunkPlanFile = "plan.json";
constexpr const char* kChunks = "chunks"; ///< Folder of the chunks.
constexpr const char* kStates = "states"; ///< Folder of the states.

/// A plan as its file holds it.
struct ChunkPlan { // NOLINT(bugprone-exception-escape): the library of JSON states no noexcept
    VideoChunkPlan shown;
    Json settings;
    int segmentFrames = 1;
    std::vector<VideoSegment> segments; ///< Without their files.
    std::vector<std::int64_t> beginPts; ///< Pts of each chunk's frame `begin`.
    std::uint64_t id = 0;               ///< Differs between plans.

    std::size_t segmentOf(const VideoChunk& chunk) const {
        return static_cast<std::size_t>(chunk.first / segmentFrames);
    }
    std::size_t segmentCount(const VideoChunk& chunk) const {
        return static_cast<std::size_t>((chunk.frames + segmentFrames - 1) / segmentFrames);
    }
    /// The chunk of a number from 1. @throws Error InvalidArgument
    const VideoChunk& chunk(int number) const;
};

/// Sets the times of the chunks, and the counts of frames, from the segments.
void setTimes(ChunkPlan& plan, const Fraction& timeBase);

/// @throws Error NotFound, ReadFailed, BadFormat
ChunkPlan readChunkPlan(const std::filesystem::path& directory);
/// @throws Error WriteFailed
void writeChunkPlan(const ChunkPlan& plan, const Fraction& timeBase,
                    const std::filesystem::path& directory);

/// A chunk that is made.
struct ChunkRecord {
    std::string host;
    std::uint64_t processor = 0; ///< Differs between processors whose depth differs.
    std::vector<VideoSegment> segments;
    std::vector<std::uint64_t> sums; ///< Checksums of the segments' bytes.
};

std::filesystem::path chunkFolder(const std::filesystem::path& directory, int number);

/// The record of a chunk whose files have the right size; nothing if not made or of another plan.
/// @throws Error BadFormat, ReadFailed (damaged)
std::optional<ChunkRecord> readChunkRecord(const ChunkPlan& plan,
                                           const std::filesystem::path& directory, int number);

/// Writes the record of a chunk to the folder that holds its segments. @throws Error WriteFailed
void writeChunkRecord(const ChunkPlan& plan, std::uint64_t processor,
                      const std::vector<VideoSegment>& segments,
                      const std::filesystem::path& folder);

/// Requires the bytes of a segment as its chunk wrote them. @throws Error BadFormat, ReadFailed
void requireChecksum(const VideoSegment& segment, std::uint64_t sum, int number);

/// Whether a chunk is made and every byte of it is right.
bool isChunkWhole(const ChunkPlan& plan, const std::filesystem::path& directory, int number);

/// Removes the record of a chunk with damaged bytes, so that it counts as not made.
void dropIfDamaged(const ChunkPlan& plan, const std::filesystem::path& directory, int number);

/// The states that chunks leave for others. An unusable state is ignored, because depth can always
/// be made from the start of the scene.
class ChunkStates {
  public:
    /// @param directory the folder of the plan @param processor see ChunkRecord
    ChunkStates(const std::filesystem::path& directory, const ChunkPlan& plan,
                std::uint64_t processor)
        : directory_(directory / kStates), id_(plan.id), processor_(processor) {}

    /// Writes the state before a frame, unless it is there. @throws Error WriteFailed
    void keep(std::int64_t frame, const SavedState& state) const;
    /// Reads the state before a frame; nothing if missing, damaged or of another plan or processor.
    std::optional<SavedState> take(std::int64_t frame) const;

  private:
    std::filesystem::path nameOf(std::int64_t frame) const;

    std::filesystem::path directory_;
    std::uint64_t id_;
    std::uint64_t processor_;
};

/// A folder beside its final name. It is removed unless it is renamed. Its name states the machine
/// and the process: "000007.host-123-456".
class WorkFolder {
  public:
    /// @param target the final name @throws Error WriteFailed
    explicit WorkFolder(const std::filesystem::path& target);
    ~WorkFolder();
    WorkFolder(const WorkFolder&) = delete;
    WorkFolder& operator=(const WorkFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    /// Sets the time of the folder to now, at most once a minute, so that removeStale() of other
    /// machines leaves it alone. Call it often.
    void showLife();
    /// Renames the folder to its target. @return false if the target exists
    /// @throws Error WriteFailed
    bool finish();
    /// Moves another folder out of the way of finish().
    void moveAway();
    /// Removes the work folders beside this one whose processes were killed: on this machine, if
    /// the process does not exist; on any, if the folder has shown no life for an hour before this
    /// one was made, by the clock of the file system. A process whose folder is removed by mistake
    /// fails, and can be repeated. Failures are ignored.
    /// @param target name of their targets: "000007"; empty: all
    void removeStale(const std::string& target) const;

  private:
    std::filesystem::path target_;
    std::filesystem::path path_;
    std::chrono::steady_clock::time_point shown_;
};

} // namespace altiro3D
