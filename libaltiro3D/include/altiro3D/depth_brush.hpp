#pragma once

#include "altiro3D/export.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace altiro3D {

/// What a brush does to a depth map.
enum class DepthBrush {
    Nearer,  ///< Adds the amount.
    Farther, ///< Subtracts the amount.
    Smooth,  ///< Averages over about half of the radius.
    Level    ///< Moves all depth to one level.
};

/// Options of a DepthStroke.
struct DepthBrushOptions {
    DepthBrush brush = DepthBrush::Nearer; ///< What the brush does.
    /// Radius, px of the depth map, 0.5..4096. The inner half has the full effect, which falls to 0
    /// at the radius.
    double radius = 40;
    /// Nearer and Farther: the change of depth, 0..1. Smooth and Level: the share of the change
    /// that is made, 0..1.
    double amount = 0.1;
    double level = 0.5; ///< The depth that Level moves to, 0..1.
    /// Whether the brush stops at edges of the photo (docs/mathematics.md, 4b). Each place of the
    /// stroke changes the surface that is under its middle.
    bool keepsEdges = true;
};

/// One stroke of a brush over a depth map. A place that the stroke meets several times is changed
/// once, with the largest effect. One thread at a time.
class ALTIRO3D_EXPORT DepthStroke {
  public:
    /// Begins a stroke without a place yet.
    /// @param photo [rows x cols, CV_8UC3, BGR]
    /// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]; values beyond are clamped, NaN counts
    ///        as 0; it is not changed
    /// @param options what the stroke does
    /// @throws Error InvalidArgument (empty, wrong type, options out of range), Mismatch (sizes
    ///         differ)
    DepthStroke(const cv::Mat& photo, const cv::Mat& depth, const DepthBrushOptions& options);
    ~DepthStroke();
    DepthStroke(DepthStroke&& other) noexcept;            ///< Takes over a stroke.
    DepthStroke& operator=(DepthStroke&& other) noexcept; ///< Takes over a stroke.

    /// Draws a straight line from the last place, or begins at this one.
    /// @param place x and y, px; (0, 0) is the centre of the first px. May lie outside the photo.
    /// @return the part of the depth map that may have changed; empty if none
    /// @throws Error InvalidArgument (not finite)
    cv::Rect moveTo(cv::Point2d place);

    /// The depth map so far. @return [as photo, CV_32FC1, 0..1]; later calls of moveTo() change it
    [[nodiscard]] const cv::Mat& depth() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Brings what lies inside an outline nearer, or farther. The border follows the strongest edges of
/// the photo near the outline, up to 5 % of the photo's longer side inside of it and 1.5 % outside;
/// without edges it is the outline (docs/mathematics.md, 4b).
///
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]; values beyond are clamped, NaN counts as 0
/// @param outline a closed polygon, px; (0, 0) is the centre of the first px. Points outside the
///        photo are moved to its border. Fewer than three points enclose nothing.
/// @param amount change of depth, -1..1; positive is nearer
/// @param lifted [as depth]; may be `depth` itself
/// @return the part of the depth map that may have changed; empty if none
/// @throws Error InvalidArgument (empty, wrong type, an amount or a point that is out of range or
///         not finite), Mismatch (sizes differ)
ALTIRO3D_EXPORT cv::Rect liftDepth(const cv::Mat& photo, const cv::Mat& depth,
                                   const std::vector<cv::Point2d>& outline, double amount,
                                   cv::Mat& lifted);

} // namespace altiro3D
