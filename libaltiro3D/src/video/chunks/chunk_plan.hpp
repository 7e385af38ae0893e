#pragma once

#include "altiro3D/video_conversion.hpp"
#include "base/json_reader.hpp"

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

/// The file of a plan of chunks, and its folder.
namespace altiro3D {

constexpr const char* kChunkPlanFile = "plan.json"; ///< In the folder of a plan.
constexpr const char* kChunks = "chunks";           ///< Folder of the chunks in that of a plan.
constexpr const char* kStates = "states";           ///< Folder of the states in that of a plan.
constexpr JsonLimits kChunkJsonLimits{8, 1000, false};
constexpr std::uintmax_t kMaxChunkJsonBytes = std::uintmax_t{64} << 20;
constexpr std::int64_t kLatestPts = std::numeric_limits<std::int64_t>::max() / 8;

/// The frames of a segment of the output.
struct SegmentPlan {
    std::int64_t frames = 0;
    std::int64_t pts = 0;
    std::int64_t end = 0;
    std::uint64_t times = 0;
};

/// A plan as its file holds it.
struct ChunkPlan { // NOLINT(bugprone-exception-escape): the library of JSON states no noexcept
    VideoChunkPlan shown;
    Json settings;
    int segmentFrames = 1;
    std::vector<SegmentPlan> segments;
    std::vector<std::int64_t> beginPts; ///< Of the chunks.
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

/// Reads the plan of a folder.
/// @throws Error NotFound, ReadFailed, BadFormat
ChunkPlan readChunkPlan(const std::filesystem::path& directory);

/// Writes the plan of a folder.
/// @throws Error WriteFailed
void writeChunkPlan(const ChunkPlan& plan, const Fraction& timeBase,
                    const std::filesystem::path& directory);

/// The text of a JSON file. Bytes that are not UTF-8 are replaced.
std::string chunkJsonText(const Json& value);

/// Requires the settings of the plan, except for the length of chunks.
/// @throws Error Mismatch (names the first that differs)
void requireSettings(const ChunkPlan& plan, const Json& settings,
                     const std::filesystem::path& directory);

/// Requires an output, and an input that can be read again.
/// @throws Error InvalidArgument
void requireFileInput(const VideoConversion& conversion);

/// Makes the folders of a plan.
/// @throws Error WriteFailed (also if the folder holds other files)
void makePlanFolders(const std::filesystem::path& directory);

/// Removes a plan with its chunks.
/// @throws Error WriteFailed
void removePlan(const std::filesystem::path& directory);

} // namespace altiro3D
