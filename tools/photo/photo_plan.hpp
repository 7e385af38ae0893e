#pragma once

#include "altiro3D/products.hpp"
#include "cli/bridge.hpp"
#include "cli/budget.hpp"
#include "cli/depth_options.hpp"
#include "cli/display_options.hpp"
#include "cli/eyes_options.hpp"
#include "cli/folders.hpp"
#include "cli/go_folder.hpp"
#include "cli/outputs.hpp"
#include "cli/page_options.hpp"
#include "cli/picture_options.hpp"
#include "cli/print_options.hpp"
#include "photo/sway_options.hpp"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

/// The command line, the inputs and the outputs of a run of photo2native.
namespace altiro3D::tools {

/// Files that are made of a photo. An empty path: not requested.
struct PhotoOutputs {
    std::filesystem::path native; ///< "-": standard output
    std::filesystem::path quilt;
    std::filesystem::path savedDepth; ///< See PhotoJob::savedDepthSide.
    std::filesystem::path rgbd;
    std::filesystem::path photoWithDepth; ///< JPEG with depth inside
    std::filesystem::path video;          ///< the swaying video
    std::filesystem::path views;          ///< a directory
    std::filesystem::path splats;         ///< See PhotoJob::splatSide.
    std::filesystem::path page;           ///< See OutputJob::page.
    std::filesystem::path stereo;         ///< See EyesFiles.

    /// Whether depth is written, alone or with the photo.
    bool savesDepth() const {
        return !savedDepth.empty() || !photoWithDepth.empty() || !rgbd.empty();
    }
};

/// An output besides the Native, the option that names it, and the end of its name in a folder.
struct OutputKind {
    const char* option;
    std::filesystem::path PhotoOutputs::*file;
    const char* ending;
    bool isOneFile = true;
};
const std::vector<OutputKind>& outputKinds();

/// The part of the command line that tools with these outputs share, whatever they convert.
struct OutputJob {
    const char* things = "photos"; ///< What is converted, for messages.
    /// Views have the shape of the display: the name of a quilt does not choose another one, and
    /// quilts that only Bridge needs lie in the cache.
    bool hasOwnViews = false;
    bool makesNative = true; ///< PhotoOutputs::native is one, not another picture.
    std::vector<std::filesystem::path> inputs; ///< Names of photos and folders.
    PhotoOutputs outputs; ///< As they are named: of several photos, folders for them.
    PageOptions page;     ///< What PhotoOutputs::page shows.
    std::filesystem::path report;
    std::optional<GoFolder> go; ///< `--go`: PhotoOutputs::quilt is its folder.
    std::optional<BridgeJob> bridge;
    bool quiltIsForBridge = false; ///< No option names a quilt; planPhotos() chooses its place.
    bool replace = false;          ///< `-y`
    bool skipExisting = false;     ///< Photos whose outputs all exist are not made again.
    bool recursive = false;
    bool jsonProgress = false;
    DisplayOptions display;
    QuiltRequest quilt;
    EyesFiles eyes; ///< How pictures for two eyes are made; named as PhotoOutputs::stereo.
    std::optional<PrintOptions> print;
    SwayOptions sway;
    cv::Size swaySize; ///< The swaying video's; empty: chosen by the picture.

    /// Whether something else than the Native is asked for.
    bool hasOthers() const;
};
/// Reads the options of all these tools. @throws UsageError, Error
void takeOutputs(const CommandLine& commandLine, OutputJob& job);

/// The command line of a run.
struct PhotoJob : OutputJob {
    int savedDepthSide = 0;        ///< Longer side of depth that is saved, at most; px.
    int splatSide = 1024;          ///< Longer side of the grid of splats that are saved, at most.
    bool keepsSplatCamera = false; ///< Splats are saved with the photo's camera.
    std::filesystem::path plan;    ///< Folder of `--plan`.
    DepthOptions depth;
    SceneOptions scene;
    CameraOptions camera;
    Budget budget;
    /// The pictures of the eyes stay as they were photographed: no option changes them.
    bool keepsEyes = true;
    bool isStrengthGiven = false;             ///< As a number, or by a camera.
    std::map<std::string, std::string> given; ///< The options as they were given, for the report.
};
/// What a job needs the display for.
DisplayUse displayUse(const PhotoJob& job);
/// Turns a command line into a job. @throws UsageError, Error (camera file)
PhotoJob photoJob(const CommandLine& commandLine);

/// One photo and its outputs.
struct PhotoItem : PhotoOutputs {
    std::filesystem::path photo;
    std::filesystem::path depth; ///< its depth image; with `--stereo files` the right eye's picture
    EyesFiles eyes;              ///< The files of PhotoOutputs::stereo.
    bool isFromFolder = false; ///< Not named itself: it is left out if it turns out to be a quilt.
    bool isMade = false;       ///< All outputs exist already: `--skip-existing`.
};

/// The photos that the names of a job stand for.
struct PhotoInputs {
    std::vector<FolderFile> files;    ///< With their depth images or right eye's pictures.
    std::vector<LeftOutFile> leftOut; ///< What is not converted of folders.
    bool batch = false; ///< outputs are directories; a photo that fails does not stop the run
};

/// All photos of a run.
struct PhotoPlan : PhotoInputs {
    std::vector<PhotoItem> items;
};

/// The first of its outputs, which stands for all.
const std::filesystem::path& mainOutput(const PhotoItem& item);

/// Searches the folders among the names of a job. Says what is left out.
/// @throws UsageError, Error (a directory that cannot be listed or holds no pictures)
PhotoInputs listPhotos(const PhotoJob& job, Messages& messages);

/// Derives the plan from a job. The names of the outputs depend on all inputs.
/// @param layout layout of the quilts, which is part of their names
/// @throws UsageError, Error
PhotoPlan planPhotos(const OutputJob& job, const ChosenDisplay& display, const QuiltLayout& layout,
                     const PhotoInputs& inputs);

/// Checks every name before any work, see Outputs::check(). The result creates the directories.
/// With OutputJob::skipExisting, marks the photos whose outputs all exist.
/// @param views number of views that `--save-views` writes
/// @param alsoRead further files that are read
/// @throws UsageError, Error
Outputs checkedOutputs(const OutputJob& job, PhotoPlan& plan, const ChosenDisplay& display,
                       int views, const Outputs::Files& alsoRead = {});
Outputs checkedOutputs(const PhotoJob& job, PhotoPlan& plan, const ChosenDisplay& display,
                       int views);

/// All files that are made of a photo. @param views as for checkedOutputs()
std::vector<std::filesystem::path> outputsOf(const PhotoItem& item, int views);

} // namespace altiro3D::tools
