#include "viewer/model/depth_canvas.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/enum_table.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::viewer {

namespace {

cv::Mat downscaled(const cv::Mat& photo) {
    const double pixels = static_cast<double>(photo.total());
    if (pixels <= kMaxCanvasPixels) return photo;
    const double scale = std::sqrt(kMaxCanvasPixels / pixels);
    cv::Mat result;
    cv::resize(photo, result,
               {std::max(1, static_cast<int>(photo.cols * scale)),
                std::max(1, static_cast<int>(photo.rows * scale))},
               0, 0, cv::INTER_AREA);
    return result;
}

// As PaintTool; the last one is not used, as the lasso is no brush.
constexpr DepthBrush kBrushes[] = {DepthBrush::Nearer, DepthBrush::Farther, DepthBrush::Smooth,
                                   DepthBrush::Level, DepthBrush::Level};

} // namespace

DepthCanvas::DepthCanvas(const cv::Mat& photo, const cv::Mat& depth) : photo_(downscaled(photo)) {
    fitDepth(depth, {0, 0, double(depth.cols), double(depth.rows)}, photo_, depth_);
}

void DepthCanvas::begin(const Paint& paint, cv::Point2d place) {
    painting_ = true;
    paint_ = paint;
    changed_ = {};
    outline_.clear();
    stroke_.reset();
    if (paint.tool == PaintTool::Lasso) return outline_.push_back(inPixels(place));
    DepthBrushOptions options;
    options.brush = entryOf(kBrushes, paint.tool);
    options.radius = std::max(0.5, paint.radius * std::max(photo_.cols, photo_.rows));
    options.amount = std::abs(paint.amount);
    options.keepsEdges = paint.keepsEdges;
    const cv::Point2d at = inPixels(place);
    options.level = static_cast<double>(
        depth_.at<float>(std::clamp(static_cast<int>(std::lround(at.y)), 0, depth_.rows - 1),
                         std::clamp(static_cast<int>(std::lround(at.x)), 0, depth_.cols - 1)));
    stroke_.emplace(photo_, depth_, options);
    moveTo(place);
}

bool DepthCanvas::moveTo(cv::Point2d place) {
    if (!painting_) return false;
    if (!stroke_) {
        outline_.push_back(inPixels(place));
        return false;
    }
    const cv::Rect changed = stroke_->moveTo(inPixels(place));
    changed_ |= changed;
    return !changed.empty();
}

PaintedPart DepthCanvas::end() {
    painting_ = false;
    cv::Mat after;
    if (stroke_) {
        after = stroke_->depth();
    } else {
        changed_ = liftDepth(photo_, depth_, outline_, paint_.amount, after);
    }
    PaintedPart part{changed_, {}, {}};
    if (!changed_.empty()) {
        part.before = depth_(changed_).clone();
        part.after = after(changed_).clone();
        part.after.copyTo(depth_(changed_));
    }
    stroke_.reset();
    return part;
}

} // namespace altiro3D::viewer
