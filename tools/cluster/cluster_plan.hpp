#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D::tools {

/// A plan of video2native or photo2native, as a program sees it that starts the chunks.
struct ClusterPlan {
    std::filesystem::path folder;    ///< Absolute.
    std::string tool;                ///< "video2native" or "photo2native".
    std::string unit;                ///< What a chunk makes: "frame" or "photo".
    int threads = 1;                 ///< With which chunks must be made.
    int depthAlone = 0;              ///< The first chunks, on which others wait, make depth alone.
    std::vector<std::int64_t> units; ///< Frames or photos of chunk 1, 2, ...; 0 for depth alone.

    int chunks() const { return static_cast<int>(units.size()); }
    /// Folder of the logs.
    std::filesystem::path logs() const { return folder / "logs"; }
    /// The program that makes a chunk or joins: beside this program if it is there.
    std::string program() const;
};

/// Reads a plan.
/// @throws Error NotFound, ReadFailed, BadFormat (no plan, a damaged one)
ClusterPlan readClusterPlan(const std::filesystem::path& folder);

/// Whether each chunk is made, from its files. Number 1 first.
std::vector<bool> madeChunks(const ClusterPlan& plan);

/// Runs of neighbouring numbers: "1-3,7". @param numbers in order
std::string rangesText(const std::vector<int>& numbers);

/// A sentence about a folder that only this machine sees, by its name or its file system; empty if
/// it looks shared.
std::string localText(const std::filesystem::path& folder);

/// A word for a shell, quoted if it needs it.
std::string shellWord(const std::string& text);

} // namespace altiro3D::tools
