#pragma once

#include "altiro3D/native_maker.hpp"
#include "photo/photo_plan.hpp"

#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>

/// The work of photo2native.
namespace altiro3D::tools {

/// Everything that all photos of a run share.
struct PhotoRun {
    const PhotoJob& job;
    ChosenDisplay display;
    NativeMaker maker;
    Budget budget;
    ChosenDepth depth;
    cv::Mat quilt;  ///< reused from photo to photo; empty if none is needed
    cv::Mat native; ///< reused
};

/// Chooses the source of depth and prepares the maker of Natives.
/// @param job must outlive the run
/// @param times receives "network", if one is loaded now, and "display"
/// @throws UsageError, Error
PhotoRun openPhotoRun(const PhotoJob& job, const ChosenDisplay& display, const QuiltLayout& layout,
                      StageTimes& times, Messages& messages);

/// Makes all outputs of one photo. The Native is written last, so an existing Native means that all
/// outputs exist.
/// @return its entry in the report
/// @throws NotTaken, UsageError, Error
nlohmann::ordered_json makePhoto(const PhotoItem& item, PhotoRun& run, Messages& messages);

/// The report of a run without its times and pictures.
nlohmann::ordered_json photoReport(const PhotoRun& run, const Messages& messages);

/// The text of a report's file.
std::string reportText(const nlohmann::ordered_json& report);

/// How the photos of a call ended.
struct PhotosMade { // NOLINT(bugprone-exception-escape): the library of JSON states no noexcept
    int status = kExitDone;
    bool mayRecover = false; ///< See FolderRun.
    std::vector<std::filesystem::path> outputs;
    nlohmann::ordered_json pictures = nlohmann::ordered_json::array(); ///< Of the report.
};

} // namespace altiro3D::tools
