#pragma once

#include "views/view_methods.hpp"

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D {

/// A px of a surface of a scene, or of the background that is painted behind one.
struct LayeredPixel {
    int x = 0;           ///< Column of the photo; painted ones may lie beside the frame.
    int y = 0;           ///< Row.
    float depth = 0;     ///< 0..1
    float across = 0;    ///< Slope of the surface: depth of the next column minus this one's,
    float down = 0;      ///< and of the next row.
    float share = 1;     ///< The part of the px that it covers, 0..1.
    std::uint8_t bgr[3]; ///< Its colour.

    /// 0: the photo's own px. Else it is this many columns right (< 0: left) of a surface's end.
    int beside = 0;
    int width = 0; ///< With `beside`: visible columns of the surface.
    /// Painted behind a nearer surface or beside the frame. Otherwise a px with `beside` is one
    /// into which a surface's border reaches.
    bool isHidden = false;
    bool isLast = false; ///< The last px of a surface of its row.
};

/// All px of a scene, as method Layered sees it: surfaces that are cut at steps of the depth, and
/// what is painted behind them on both sides.
/// @param photo, depth, focus, options as for makeLayeredRenderer()
std::vector<LayeredPixel> layeredPixels(const cv::Mat& photo, const cv::Mat& depth, double focus,
                                        const LayeredSettings& options);

} // namespace altiro3D
