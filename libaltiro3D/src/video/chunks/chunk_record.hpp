#pragma once

#include "media/video_segments.hpp"
#include "video/chunks/chunk_plan.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// The record of a chunk that is made, and the check of its files.
namespace altiro3D {

/// A chunk that is made.
struct ChunkRecord {
    std::string host;
    std::uint64_t processor = 0; ///< Differs between processors whose depth differs.
    std::vector<VideoSegment> segments;
    std::vector<std::uint64_t> sums; ///< Of the bytes of the segments.
};

/// The folder of a chunk.
std::filesystem::path chunkFolder(const std::filesystem::path& directory, int number);

/// The record of a chunk, whose files have the right size. Nothing if the chunk is not made or not
/// of this plan.
/// @throws Error BadFormat, ReadFailed (damaged)
std::optional<ChunkRecord> readChunkRecord(const ChunkPlan& plan,
                                           const std::filesystem::path& directory, int number);

/// Writes the record of a chunk to the folder that holds its segments.
/// @throws Error WriteFailed
void writeChunkRecord(const ChunkPlan& plan, std::uint64_t processor,
                      const std::vector<VideoSegment>& segments,
                      const std::filesystem::path& folder);

/// Requires the bytes of a segment as its chunk wrote them.
/// @throws Error BadFormat, ReadFailed
void requireChecksum(const VideoSegment& segment, std::uint64_t sum, int number);

/// Whether a chunk is made and every byte of it is right.
bool isChunkWhole(const ChunkPlan& plan, const std::filesystem::path& directory, int number);

/// Removes the record of a chunk that has not the bytes that were written, so that the chunk counts
/// as not made.
void dropIfDamaged(const ChunkPlan& plan, const std::filesystem::path& directory, int number);

} // namespace altiro3D
