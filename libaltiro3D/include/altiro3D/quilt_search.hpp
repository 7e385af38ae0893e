#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/quilt.hpp"

#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D {

/// What findQuiltLayout() has found out about a picture.
enum class QuiltVerdict {
    Quilt,  ///< A quilt; its layout is certain enough to be used.
    Unsure, ///< Parts of the picture resemble each other, but the layout is not certain.
    NoQuilt ///< No parts of the picture resemble each other as views do: a photo, for example.
};

/// The layout that a picture seems to have.
struct FoundQuilt {
    QuiltVerdict verdict = QuiltVerdict::NoQuilt; ///< How far the layout can be trusted.
    QuiltLayout layout; ///< The most likely layout; of no use if the confidence is 0. Its tiles
                        ///< have the size of the picture divided by columns and rows, rounded down.
    double confidence = 0; ///< How alike neighbouring views are, 0..1, lowered if another layout
                           ///< fits as well, or if the views hold nothing but a regular pattern.
};

/// Finds the columns and rows of a quilt by comparing parts of the picture.
///
/// Neighbouring views of a quilt resemble each other: those side by side, and the last one of a row
/// and the first one of the row above. The function searches divisions of the picture of up to 20
/// columns and 20 rows, and takes the finest one whose parts resemble each other in this way.
/// Quilts may be scaled, compressed, and cropped by some px. For drawn grids and other regular
/// patterns the verdict is Unsure, because any multiple of their period fits.
///
/// @param picture [rows x cols, CV_8UC3, BGR]
/// @return verdict, layout and confidence; Unsure with confidence 0 for pictures of one colour or
///         with a side below 128 px
/// @throws Error InvalidArgument (empty or wrong type)
[[nodiscard]] ALTIRO3D_EXPORT FoundQuilt findQuiltLayout(const cv::Mat& picture);

/// How much consecutive pictures resemble each other, as views of neighbouring cameras do. Shifts
/// of up to a tenth of the width do not count. Measured: 0.9 and more for rendered and captured
/// views, below 0.1 for unrelated photos.
///
/// @param pictures in the order of the cameras [any size, CV_8UC3, BGR]; small copies are
///        sufficient
/// @return 0..1; 1 if there is nothing to compare: fewer than two pictures, or no contrast
/// @throws Error InvalidArgument (an empty picture or a wrong type)
[[nodiscard]] ALTIRO3D_EXPORT double likenessOfViews(const std::vector<cv::Mat>& pictures);

} // namespace altiro3D
