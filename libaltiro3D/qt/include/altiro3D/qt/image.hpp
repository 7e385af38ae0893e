#pragma once

#include "altiro3D/export.hpp"

#include <QImage>
#include <opencv2/core/mat.hpp>

/// @namespace altiro3D::qt
/// What programs with Qt need besides: displays among the screens, pictures as QImage, a widget.

namespace altiro3D::qt {

/// A picture as a QImage that shares its memory; nothing is copied, and the memory lives as long as
/// either of them. What is drawn into the image goes to a copy of its own;
/// what is written to the picture shows in the image.
///
/// @param picture [rows x cols, CV_8UC3 BGR or CV_8UC1 grey]; sub-matrices are fine
/// @return Format_BGR888 or Format_Grayscale8, of device pixel ratio 1; null if `picture` is empty
/// @throws Error InvalidArgument (type)
ALTIRO3D_EXPORT QImage toImage(const cv::Mat& picture);

/// An image as a picture of its own, in one copy; what is transparent becomes black.
///
/// @param image of any format; its device pixel ratio does not count
/// @return [rows x cols, CV_8UC3, BGR]; empty if `image` is null
ALTIRO3D_EXPORT cv::Mat toPicture(const QImage& image);

} // namespace altiro3D::qt
