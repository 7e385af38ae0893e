#pragma once

#include "common/display_options.hpp"
#include "common/folder_search.hpp"
#include "common/outputs.hpp"

#include <filesystem>
#include <vector>

/// The inputs and outputs of a run of photo2native.
namespace altiro3D::tools {

/// One photo and its outputs. An empty path: not requested.
struct PhotoItem {
    std::filesystem::path photo;
    std::filesystem::path depth; ///< its depth image; with `--stereo files` the right eye's picture
    std::filesystem::path native;
    std::filesystem::path quilt;
    std::filesystem::path savedDepth;
    std::filesystem::path rgbd;
    std::filesystem::path photoWithDepth; ///< JPEG with depth inside
    std::filesystem::path views;          ///< a directory
    std::filesystem::path video;          ///< the swaying video
    bool isFromFolder = false; ///< Not named itself: it is left out if it turns out to be a quilt.
    bool isMade = false;       ///< All outputs exist already: `--skip-existing`.
};

/// All photos of a run.
struct PhotoPlan {
    std::vector<PhotoItem> items;
    bool batch = false; ///< outputs are directories; a photo that fails does not stop the run
    bool skipExisting = false; ///< photos whose outputs all exist are not made again
    std::filesystem::path report;
    std::vector<LeftOutFile> leftOut; ///< Of folders: what is not converted.
};

/// The photos that the names of a command line stand for.
struct PhotoInputs {
    std::vector<FolderFile> files;    ///< With their depth images or right eye's pictures.
    std::vector<LeftOutFile> leftOut; ///< Of folders: what is not converted.
    bool batch = false;               ///< See PhotoPlan.
};

/// Checks the names and searches the folders among them. Says what is left out.
/// @throws UsageError, Error (a directory that cannot be listed or holds no pictures)
PhotoInputs listPhotos(const CommandLine& commandLine, Messages& messages);

/// Derives the plan from the command line. The names of the outputs depend on all inputs.
/// @param layout layout of the quilts, which is part of their names
/// @throws UsageError, Error
PhotoPlan planPhotos(const CommandLine& commandLine, const ChosenDisplay& display,
                     const QuiltLayout& layout, const PhotoInputs& inputs);

/// Checks every name before any work, see Outputs::check(). The result creates the directories.
/// With PhotoPlan::skipExisting, marks the photos whose outputs all exist.
/// @param views number of views that `--save-views` writes
/// @throws UsageError, Error
Outputs checkedOutputs(const CommandLine& commandLine, PhotoPlan& plan,
                       const ChosenDisplay& display, int views);

/// All files that are made of a photo. @param views as for checkedOutputs()
std::vector<std::filesystem::path> outputsOf(const PhotoItem& item, int views);

} // namespace altiro3D::tools
