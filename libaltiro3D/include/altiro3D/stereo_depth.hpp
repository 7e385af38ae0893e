#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"

#include <opencv2/core/mat.hpp>
#include <string>

namespace altiro3D {

/// What matchStereo() found. Disparities are shares of the picture's width: (x of a point in the
/// left picture - x in the right one) / width. Larger = nearer. 3D cameras shift the pictures
/// against each other, so disparities may have both signs.
struct ALTIRO3D_EXPORT StereoMatch {
    double shift = 0;    ///< Median disparity. This and the next two are of px with detail.
    double farthest = 0; ///< Smallest disparity: percentile 0.5.
    double nearest = 0;  ///< Largest disparity: percentile 99.5.
    /// By how much the right picture is lower than the left one in its middle, as share of the
    /// width; it was moved back before matching.
    double lower = 0;
    double rollDegrees = 0;    ///< Rotation of the right picture, clockwise; it was undone.
    double matchedShare = 0;   ///< Share of the left picture's px that have a match, 0..1.
    double likeness = 0;       ///< Correlation of the fine detail of matched px, -1..1.
    bool isReliable = false;   ///< Enough px match and are alike; otherwise do not use the depth.
    bool isFlat = false;       ///< The range of the disparities is below 0.15 %.
    bool looksSwapped = false; ///< Background appears in front of foreground: exchange the eyes.

    /// For people: "shift -12.0 %, 93 % matched", and further findings that are unusual.
    /// @return the text
    [[nodiscard]] std::string text() const;
    /// Remarks for the user: the pictures do not match, the eyes look swapped.
    /// @param pair name of the pair for the text, for example StereoPair::origin
    /// @return the remarks, usually none
    [[nodiscard]] Notes remarks(const std::string& pair) const;
};

/// Finds the depth of a stereo pair by matching (OpenCV's semi-global matching).
///
/// The pictures are shrunk to at most 1000 px a side and 750 000 px; a vertical offset, a small
/// rotation and a small difference of scale between them are found and undone, and brightness and
/// contrast are made equal. Disparities are searched from -35 % to +35 % of the width, first
/// coarsely. A px counts as matched if the match from the right picture leads back to it within 1
/// px. Px without a match take the farther disparity beside them, because px that one eye does not
/// see belong to the background. A median of the surrounding px, weighted by similarity of colour,
/// then smooths them.
///
/// @param left [rows x cols, CV_8UC3, BGR]
/// @param right as `left`; its shape may differ by 5 %, it is resized to the left picture's size
/// @param disparity [the shrunk size, CV_32FC1, shares of the width, larger = nearer]; without any
///        match and for flat pairs, all values are `shift`
/// @return what was found
/// @throws Error InvalidArgument (empty, wrong type), Mismatch (shapes)
[[nodiscard]] ALTIRO3D_EXPORT StereoMatch matchStereo(const cv::Mat& left, const cv::Mat& right,
                                                      cv::Mat& disparity);

} // namespace altiro3D
