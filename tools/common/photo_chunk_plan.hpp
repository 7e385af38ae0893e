#pragma once

#include "common/folder_search.hpp"
#include "common/photo_plan.hpp"

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// The plan of a run of photo2native on many machines, and the records of its chunks. A chunk is a
/// slice of the list of photos.
namespace altiro3D::tools {

/// Settings and input files besides the photos, by name.
using PhotoRunStamp = std::map<std::string, std::string>;

/// A plan.
// NOLINTNEXTLINE(bugprone-exception-escape): the library of JSON states no noexcept
struct PhotoChunkPlan {
    std::string id;                    ///< Differs between plans; set by readPhotoChunks().
    int threads = 1;                   ///< With which chunks must be made.
    int chunkPhotos = 1;               ///< Photos of a chunk; the last one may have fewer.
    PhotoRunStamp stamp;               ///< What else determines the outputs.
    PhotoInputs inputs;                ///< The photos; `batch` is true.
    std::vector<std::string> stamps;   ///< Of the photos: size and time of photo and depth image.
    nlohmann::ordered_json report;     ///< Of the run, without times and pictures.
    std::vector<std::string> warnings; ///< Of the plan.

    /// Number of chunks; they count from 1.
    int chunks() const;
    /// The first photo of a chunk, and the one after its last.
    /// @throws Error InvalidArgument (number)
    std::pair<std::size_t, std::size_t> photosOf(int number) const;
};

/// How a photo of a chunk ended.
struct PhotoResult { // NOLINT(bugprone-exception-escape): the library of JSON states no noexcept
    enum class End { Made, LeftOut, Failed };
    End end = End::Made;
    std::string text;                ///< Why it was left out or failed.
    FileKind kind = FileKind::Other; ///< If it was left out.
    bool isOfMachine = false; ///< It failed for a reason that another run may not have: full disk.
    std::vector<std::string> warnings;
    std::vector<std::pair<std::filesystem::path, std::uintmax_t>> outputs; ///< And their sizes.
    nlohmann::ordered_json report; ///< The entry in the report.
};

/// A chunk that was made.
struct PhotoChunkRecord { // NOLINT(bugprone-exception-escape): JSON states no noexcept
    std::string host;
    double seconds = 0;
    double peakMegabytes = 0;
    nlohmann::ordered_json depth; ///< See depthReport().
    std::vector<PhotoResult> photos;
};

/// Whether a folder holds the plan of a run of photo2native. False if it holds none, or another.
bool isPhotoPlan(const std::filesystem::path& folder);

/// Reads the plan of a folder.
/// @throws Error NotFound, ReadFailed, BadFormat (no plan of photos, a damaged one)
PhotoChunkPlan readPhotoChunks(const std::filesystem::path& folder);

/// Whether a folder holds a file of a plan.
bool holdsPlan(const std::filesystem::path& folder);

/// Makes the folder of a plan. @throws Error WriteFailed (also if it holds other files)
void makePhotoPlanFolder(const std::filesystem::path& folder);

/// Writes the plan of a folder. @throws Error WriteFailed
void writePhotoChunks(const PhotoChunkPlan& plan, const std::filesystem::path& folder);

/// Removes a plan with its records; the outputs stay. @throws Error WriteFailed
void removePhotoChunks(const std::filesystem::path& folder);

/// The record of a chunk; nothing if it was not made, or is of another plan.
/// @throws Error ReadFailed, BadFormat; InvalidArgument (number)
std::optional<PhotoChunkRecord> readPhotoChunk(const PhotoChunkPlan& plan,
                                               const std::filesystem::path& folder, int number);

/// Writes the record of a chunk. @throws Error WriteFailed
void writePhotoChunk(const PhotoChunkPlan& plan, const std::filesystem::path& folder, int number,
                     const PhotoChunkRecord& record);

/// Requires the outputs of a chunk, with their sizes. @throws Error BadFormat (names the output)
void requireOutputs(const PhotoChunkRecord& record, int number);

/// Whether a chunk is made: its outputs are there and have the right size, and no photo failed for
/// a reason of the machine.
/// @throws Error as readPhotoChunks(); InvalidArgument (number)
bool isPhotoChunkMade(const PhotoChunkPlan& plan, const std::filesystem::path& folder, int number);

/// Size and time of a file as text; "missing".
std::string fileStamp(const std::filesystem::path& file);

/// Size and time of a photo and its depth image.
std::string photoStamp(const FolderFile& file);

} // namespace altiro3D::tools
