#pragma once

#include "altiro3D/export.hpp"

#include <QImage>
#include <opencv2/core/mat.hpp>

/// @namespace altiro3D::qt
/// Additions for Qt programs: search for displays among the screens, conversion to QImage, a
/// widget.

namespace altiro3D::qt {

/// Wraps a picture in a QImage that shares its memory. The memory lives as long as either of them.
/// Drawing into the image detaches it to a copy; changes of the picture show in the image.
/// @param picture [rows x cols, CV_8UC3 BGR or CV_8UC1 grey]; sub-matrices are accepted
/// @return Format_BGR888 or Format_Grayscale8, device pixel ratio 1; null if `picture` is empty
/// @throws Error InvalidArgument (type)
[[nodiscard]] ALTIRO3D_EXPORT QImage toImage(const cv::Mat& picture);

/// Copies an image to a picture; transparent areas become black.
/// @param image image of any format; its device pixel ratio is ignored
/// @return [rows x cols, CV_8UC3, BGR]; empty if `image` is null
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat toPicture(const QImage& image);

} // namespace altiro3D::qt
