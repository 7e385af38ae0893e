#pragma once

#include "altiro3D/native_maker.hpp"
#include "cli/chosen_depth.hpp"
#include "photo/photo_plan.hpp"

#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

/// The work of photo2native.
namespace altiro3D::tools {

/// Everything that all photos of a run share.
struct PhotoRun {
    const PhotoJob& job;
    ChosenDisplay display;
    NativeMaker maker;
    Budget budget;
    ChosenDepth depthSource;
    cv::Mat quilt{};                   ///< reused from photo to photo; empty if none is needed
    cv::Mat native{};                  ///< reused; none of a print
    std::optional<PrintSheet> print{}; ///< The sheet; nothing for panels.
    /// Limit of the strength, %: prints have one, see printOn().
    double mostStrength = std::numeric_limits<double>::infinity();
    /// Set before makePhoto() if no other photo follows: its depth releases the network's memory.
    bool isForOnePhoto = false;
    /// The network in the report, kept past ChosenDepth::release().
    std::shared_ptr<const nlohmann::ordered_json> networkEntry = nullptr;

    /// Prints the photos. Without --strength, their strength is limited to what the sheet shows
    /// without blur.
    void printOn(const PrintSheet& sheet, Messages& messages);
};

/// Chooses the source of depth and prepares the maker of Natives.
/// @param job must outlive the run
///
/// A network that the job names is loaded now, the usual one by the first photo without depth.
/// @param times receives "display", and "network" if one is loaded now
/// @throws UsageError, Error
PhotoRun openPhotoRun(const PhotoJob& job, const ChosenDisplay& display, const QuiltLayout& layout,
                      StageTimes& times, Messages& messages);

/// Makes all outputs of one photo. The Native is written last, so an existing Native means that all
/// outputs exist.
/// @return its entry in the report
/// @throws NotTaken, Stopped, UsageError, Error
nlohmann::ordered_json makePhoto(const PhotoItem& item, PhotoRun& run, Messages& messages);

/// How the photos of a call ended.
struct PhotosMade {
    int status = kExitDone;
    bool mayRecover = false; ///< See FolderRun.
    std::vector<std::filesystem::path> outputs;
    std::vector<std::string> notMade; ///< A line for each photo that failed or was left out.
};

} // namespace altiro3D::tools
