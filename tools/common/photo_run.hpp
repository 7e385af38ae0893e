#pragma once

#include "altiro3D/native_maker.hpp"
#include "common/budget.hpp"
#include "common/depth_options.hpp"
#include "common/display_options.hpp"
#include "common/native_options.hpp"
#include "common/photo_plan.hpp"
#include "common/picture_options.hpp"
#include "common/quilt_options.hpp"
#include "common/sway_options.hpp"

#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>

/// The work of photo2native.
namespace altiro3D::tools {

/// What the options determine before the photos are known.
struct PhotoSettings {
    Budget budget;
    NativeOptions options;
    SwayOptions sway;
    cv::Size swaySize; ///< of the swaying video; empty: the photo's
    ChosenDisplay display;
    QuiltLayout layout;
};

/// Reads the options and finds the display. @throws UsageError, Error
PhotoSettings photoSettings(const CommandLine& commandLine, Messages& messages);

/// Everything that all photos of a run share.
struct PhotoRun {
    ChosenDisplay display;
    CameraOptions camera;
    NativeMaker maker;
    AutoChoices choices;
    Budget budget;
    ChosenDepth depth;
    SwayOptions sway;
    cv::Size swaySize; ///< of the swaying video; empty: the photo's
    cv::Mat quilt;     ///< reused from photo to photo; empty if none is needed
    cv::Mat native;    ///< reused
};

/// Chooses the source of depth and makes the tables.
/// @param times receives the stages "network" and "display"
/// @throws UsageError, Error
PhotoRun openPhotoRun(const CommandLine& commandLine, const PhotoSettings& settings,
                      StageTimes& times, Messages& messages);

/// Makes all outputs of one photo. The Native is written last, so an existing Native means that all
/// outputs exist.
/// @return its entry in the report
/// @throws NotTaken, UsageError, Error
nlohmann::ordered_json makePicture(const CommandLine& commandLine, const PhotoItem& item,
                                   PhotoRun& run, Messages& messages);

/// The report of a run without its times and pictures.
nlohmann::ordered_json photoReport(const CommandLine& commandLine, const PhotoRun& run,
                                   const Messages& messages);

/// The text of a report's file.
std::string reportText(const nlohmann::ordered_json& report);

} // namespace altiro3D::tools
