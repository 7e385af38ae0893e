#pragma once

#include "altiro3D/depth_map.hpp"

#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

namespace altiro3D::viewer {

/// What the mouse does to the depth of a photo.
enum class PaintTool {
    Nearer,
    Farther,
    Smooth,
    Copy, ///< Paints with the depth under the first place of the stroke.
    Lasso ///< Lifts what the stroke encircles.
};

/// The settings of a stroke.
struct Paint {
    PaintTool tool = PaintTool::Nearer;
    double radius = 0.04;   ///< The brush's, in longer sides of the photo, > 0..0.5.
    double amount = 0.1;    ///< 0..1; see DepthBrushOptions. Lasso: negative pushes back.
    bool keepsEdges = true; ///< See DepthBrushOptions; no effect on the lasso.
};

/// A part of a depth map before and after a stroke.
struct PaintedPart {
    cv::Rect place; ///< Empty if nothing changed.
    cv::Mat before; ///< [place.size(), CV_32FC1]
    cv::Mat after;
};

/// The depth map of a photo, to be painted on. It has the photo's shape and at most 1.5 million px
/// (kMaxCanvasPixels), so that strokes are quick.
class DepthCanvas {
  public:
    /// @param photo [CV_8UC3, BGR] @param depth [any size, CV_32FC1, 0..1], shows all of the photo
    DepthCanvas(const cv::Mat& photo, const cv::Mat& depth);

    /// Begins a stroke. @param place 0..1 of the photo, from its upper left corner; may lie outside
    void begin(const Paint& paint, cv::Point2d place);
    /// Continues it. @return true if the depth map has changed
    bool moveTo(cv::Point2d place);
    /// Ends it. @return what it changed
    PaintedPart end();
    bool isPainting() const { return painting_; }
    PaintTool tool() const { return paint_.tool; } ///< The last stroke's.

    /// Puts PaintedPart::before or PaintedPart::after into the depth map, to undo or redo a stroke.
    void put(const cv::Rect& place, const cv::Mat& part) { part.copyTo(depth_(place)); }
    /// The depth map so far; later strokes change it.
    const cv::Mat& depth() const { return stroke_ ? stroke_->depth() : depth_; }

  private:
    cv::Point2d inPixels(cv::Point2d place) const {
        return {place.x * photo_.cols - 0.5, place.y * photo_.rows - 0.5};
    }

    cv::Mat photo_;
    cv::Mat depth_;
    bool painting_ = false;
    Paint paint_;
    std::optional<DepthStroke> stroke_;
    std::vector<cv::Point2d> outline_;
    cv::Rect changed_;
};

constexpr double kMaxCanvasPixels = 1.5e6;

} // namespace altiro3D::viewer
