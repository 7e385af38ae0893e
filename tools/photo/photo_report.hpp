#pragma once

#include "photo/photo_run.hpp"

#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/types.hpp>
#include <string>

/// What photo2native says of the photos it makes, to people and in its report.
namespace altiro3D::tools {

/// What was made of a photo.
struct PhotoFacts {
    const PhotoItem& item;
    cv::Size photoSize{};
    cv::Size videoSize{};
    double aspect = 1; ///< The Native's.
    double quiltAspect = 1;
    cv::Rect crop{}; ///< The part of the photo on the panel.
    Framing framing{};
    ViewOptions views{};
    AdjacentParallax parallax{};
    std::string chosen{}; ///< Automatically.
    std::string depthSource{};
    bool isUnblurred = false;
    bool isImageUsed = false; ///< The depth image of the item.

    double photoAspect() const { return static_cast<double>(photoSize.width) / photoSize.height; }
};

/// Says what was made: a line for each file, or one for each of many photos.
void tellPicture(const PhotoRun& run, const PhotoFacts& made, Messages& messages);
/// The entry of a photo in the report.
nlohmann::ordered_json pictureReport(const PhotoRun& run, const PhotoFacts& made,
                                     const StageTimes& times);
/// The report of a run without its times and pictures.
nlohmann::ordered_json photoReport(const PhotoRun& run, int exitStatus, const Messages& messages);
/// The network of a run, for its report.
nlohmann::ordered_json networkJson(const PhotoRun& run);

} // namespace altiro3D::tools
