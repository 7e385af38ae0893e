#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace altiro3D {

/// What is known about the background that near objects hide in a photo, for example from the other
/// eye's picture. It covers the whole photo.
struct HiddenLayer {
    cv::Mat photo; ///< [any size, CV_8UC3, BGR]; empty: nothing is known
    /// [as HiddenLayer::photo, CV_32FC1, 0..1 or somewhat beyond, 1 = nearest, NaN = unknown]; from
    /// matchStereo(): disparities, which scaleHiddenDepth() turns into depth
    cv::Mat depth;
};

/// What is known about the edges of a depth map; it decides what refinement corrects.
enum class DepthEdges {
    Unknown, ///< Refinement measures their flaws and corrects them.
    Matched, ///< Found by matching two pictures; refinement does not move them.
    /// Aligned with the photo's edges when a network estimated the depth. Refinement only
    /// extends them by Scene::mixedPixels.
    Aligned
};

/// A photo and its depth map.
struct Scene {
    cv::Mat photo; ///< [rows x cols, CV_8UC3, BGR]
    cv::Mat depth; ///< [any size until fitted, CV_32FC1, 0..1, 1 = nearest], of the whole photo
    HiddenLayer hidden{}; ///< Method Layered shows it in disocclusions instead of painting them.
    /// Columns that the panel shows, inside the photo; empty: all. Views have these columns only.
    /// The other columns are margins, which views from the side show at the edges of the panel.
    cv::Range shown{};
    DepthEdges edges = DepthEdges::Unknown; ///< What is known about the edges of `depth`.
    /// Px by which refinement extended near objects over the band in which a soft photo mixes them
    /// with the background (DepthFlaws::mixedPixels), 0..7. Method Layered splits colours there.
    int mixedPixels = 0;
};

/// The columns that the panel shows. @param scene a scene @return scene.shown, or all columns
[[nodiscard]] inline cv::Range shownColumns(const Scene& scene) {
    return scene.shown.empty() ? cv::Range(0, scene.photo.cols) : scene.shown;
}
/// The depth that the panel shows. @param scene a fitted scene @return its depth without margins
[[nodiscard]] inline cv::Mat shownDepth(const Scene& scene) {
    return scene.depth.colRange(shownColumns(scene));
}

} // namespace altiro3D
