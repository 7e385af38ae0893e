#pragma once

#include "common/display_options.hpp"
#include "common/outputs.hpp"
#include "common/photo_folder.hpp"

#include <filesystem>
#include <vector>

/// What photo2native is asked for.
namespace altiro3D::tools {

/// One photo and all that is made of it. Empty paths: not wanted.
struct PhotoItem {
    std::filesystem::path photo;
    std::filesystem::path depth; ///< given
    std::filesystem::path native;
    std::filesystem::path quilt;
    std::filesystem::path savedDepth;
    std::filesystem::path rgbd;
    std::filesystem::path views; ///< a directory
    std::filesystem::path video; ///< that sways
    bool isFromFolder = false; ///< Not named itself: it is left out if it turns out to be a quilt.
    bool isMade = false;       ///< An earlier run did all of it: `--skip-existing`.
};

/// All photos of a run.
struct PhotoPlan {
    std::vector<PhotoItem> items;
    bool batch = false; ///< outputs go into directories, and one bad photo does not stop the rest
    std::filesystem::path report;
    std::vector<LeftOutFile> leftOut; ///< Of folders: what is not converted.
};

/// The plan that a command line asks for.
/// @param layout of the quilts, which is a part of their names
/// @throws UsageError, Error (a directory that cannot be listed or holds no pictures)
PhotoPlan planPhotos(const CommandLine& commandLine, const ChosenDisplay& display,
                     const QuiltLayout& layout, Messages& messages);

/// Checks every name before any work is done: no output is an input, none would be lost. The result
/// makes the directories.
/// With `--skip-existing` the photos are marked whose outputs are all there.
/// @param views how many of them `--save-views` writes
/// @throws UsageError, Error
Outputs checkedOutputs(const CommandLine& commandLine, PhotoPlan& plan,
                       const ChosenDisplay& display, int views);

} // namespace altiro3D::tools
