#pragma once

#include "cli/command_line.hpp"
#include "cli/run_tool.hpp"
#include "photo/photo_run.hpp"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

/// photo2native for many machines, see chunk_folder.hpp. The folder of the plan also holds
/// `photos`, the list of all photos. A chunk is a run over a part of the list, with --skip-existing
/// unless the plan has -y, and leaves the names of its outputs in `chunks`. The join is a run with
/// --skip-existing over the whole list.
namespace altiro3D::tools {

/// The list of a plan.
struct PhotoChunks {
    std::string madeWith; ///< Version, display and depth, which must be the same on all machines.
    int threads = 1;      ///< Number of threads that each chunk must be made with.
    int chunkPhotos = 1;  ///< Photos of a chunk; the last one may have fewer.
    std::vector<FolderFile> photos;

    /// Number of chunks; they count from 1.
    int count() const;
    /// The first photo of a chunk, and the one after its last.
    /// @throws Error InvalidArgument (number)
    std::pair<std::size_t, std::size_t> photosOf(int number) const;
};

/// Whether a folder holds a plan of photo2native.
bool holdsPhotoChunks(const std::filesystem::path& folder);

/// Reads the list of a plan. @throws Error NotFound, ReadFailed, BadFormat
PhotoChunks readPhotoChunks(const std::filesystem::path& folder);

/// Whether a chunk has ended, and its outputs are there.
bool isPhotoChunkMade(const std::filesystem::path& folder, int number);

/// The part of a plan's photos that a call makes.
struct PhotoPart {
    PhotoChunks chunks; ///< All chunks of the plan.
    std::size_t first = 0;
    std::size_t end = 0;
    /// Only for the join of a run that replaces files (-y): the outputs that its chunks have made.
    /// All other files are older.
    std::optional<std::set<std::string>> made;

    /// Reduces a plan of all photos to this part.
    void keepOwn(PhotoPlan& photos) const;
    /// Marks the photos to be made again whose outputs are older than the plan.
    void markOutdated(PhotoPlan& photos) const;
    /// Requires what the plan was made with. @throws Error Mismatch
    void requireSame(const PhotoRun& run) const;
};

/// Adds the options of the plan, of its chunks and of the join.
void addPhotoChunkOptions(CommandLine& commandLine);

/// Plans a run, makes a chunk or joins the chunks, if the command line says so.
/// @param arguments the command line's words, the program's name first
/// @param addOptions adds all options of the tool to another command line, which reads the words of
///        the plan
/// @param make makes a part of the photos of the plan's job
/// @return the exit status, that of a join is the one of a run on one machine; nothing for other
///         command lines
/// @throws UsageError, Error
std::optional<int>
runPhotoChunks(const CommandLine& commandLine, const std::vector<std::string>& arguments,
               const std::function<void(CommandLine&)>& addOptions,
               const std::function<PhotosMade(const PhotoJob&, const PhotoPart&)>& make,
               Messages& messages);

} // namespace altiro3D::tools
