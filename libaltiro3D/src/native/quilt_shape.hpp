#pragma once

#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"

namespace altiro3D {

/// Fits every view of a quilt to the panel's shape as fitPhoto() and applyFit() do for one picture.
/// The layout does not change.
/// @param quilt [layout.size(), CV_8UC3, BGR]
/// @param layout layout of the quilt, before and after
/// @param viewAspect width : height of a view as it is shown, independent of its px, 0.01..100
/// @param panelAspect width : height of the panel, 0.01..100
/// @param mode crop, bars or distortion
/// @param fitted [layout.size(), CV_8UC3, BGR], newly allocated
/// @throws Error Mismatch (the quilt does not have the layout's size), InvalidArgument (layout,
///         type, aspects), TooLarge (layout)
void applyFitToViews(const cv::Mat& quilt, const QuiltLayout& layout, double viewAspect,
                     double panelAspect, FitMode mode, cv::Mat& fitted);

} // namespace altiro3D
