#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/quilt.hpp"

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace altiro3D {

/// How a picture of one shape is brought to another.
enum class FitMode {
    Cover,   ///< Fills the panel; what does not fit is cut off on both sides alike.
    Contain, ///< All of it is seen; black bars fill the rest.
    Stretch  ///< All of it is seen, distorted to the panel's shape.
};

/// Which part of a picture goes where.
struct PhotoFit {
    cv::Rect source; ///< Part of the picture that is used, in its px.
    cv::Rect target; ///< Where it goes in the result, in px; the rest is black.
    cv::Size size;   ///< Size of the result in px.
};

/// Computes the fit. The shape that counts is the panel's; the result may have another one (square
/// tiles for a wide panel) and is then stretched by the display.
///
/// @param picture size of the picture in px, at least 1 x 1
/// @param panelAspect width : height of what the viewer will see, 0.01..100
/// @param result size of the result in px, at least 1 x 1
/// @param mode see FitMode
/// @return the fit
/// @throws Error InvalidArgument (out of these ranges)
ALTIRO3D_EXPORT PhotoFit fitPhoto(cv::Size picture, double panelAspect, cv::Size result,
                                  FitMode mode = FitMode::Cover);

/// Resamples a picture as a fit says: area average when shrinking, cubic when enlarging.
///
/// @param picture [rows x cols, CV_8UC3, BGR], of the size the fit was made for
/// @param fit from fitPhoto()
/// @param fitted [fit.size, CV_8UC3, BGR], in memory of its own; may be `picture` itself
/// @throws Error Mismatch (the fit is for another size), InvalidArgument (type, a fit whose target
///         leaves its result)
ALTIRO3D_EXPORT void applyFit(const cv::Mat& picture, const PhotoFit& fit, cv::Mat& fitted);

/// Resamples a depth map along with its photo; bars lie at the focus, so that they do not move.
///
/// @param depth [any size of the photo's extent, CV_32FC1, 0..1]
/// @param photoSize size of the photo that the fit was made for, in px
/// @param fit from fitPhoto()
/// @param fittedPhoto [fit.size, CV_8UC3, BGR], the photo after applyFit(): depth edges follow it
/// @param focus depth of the bars, 0..1
/// @param fitted [fit.size, CV_32FC1, 0..1]
/// @throws Error Mismatch (the fit is for another size, or the photo of another one),
///         InvalidArgument (types, focus, a fit whose target leaves its result)
ALTIRO3D_EXPORT void applyFitToDepth(const cv::Mat& depth, cv::Size photoSize, const PhotoFit& fit,
                                     const cv::Mat& fittedPhoto, double focus, cv::Mat& fitted);

/// A photo and its depth map.
struct Scene {
    cv::Mat photo; ///< [rows x cols, CV_8UC3, BGR]
    cv::Mat depth; ///< [CV_32FC1, 0..1, 1 = nearest], shows all of the photo
};

/// Fits a photo and its depth map to the panel's shape: applyFit() and applyFitToDepth().
///
/// @param scene the photo, of the size that the fit was made for, and its depth map of any size
/// @param fit from fitPhoto()
/// @param focus depth of the bars, 0..1
/// @param fitted both of fit.size; reused if they fit
/// @throws Error as applyFit() and applyFitToDepth()
ALTIRO3D_EXPORT void fitScene(const Scene& scene, const PhotoFit& fit, double focus, Scene& fitted);

/// Fits every view of a quilt to the panel's shape, as fitPhoto() and applyFit() do for one
/// picture; the quilt keeps its layout.
///
/// @param quilt [layout.size(), CV_8UC3, BGR]
/// @param layout of the quilt, before and after
/// @param viewAspect width : height of what a view shows, whatever its px are, 0.01..100
/// @param panelAspect width : height of the panel, 0.01..100
/// @param mode see FitMode
/// @param fitted [layout.size(), CV_8UC3, BGR], in memory of its own
/// @throws Error Mismatch (the quilt has not the layout's size), InvalidArgument (layout, type,
///         aspects), TooLarge (layout)
ALTIRO3D_EXPORT void applyFitToViews(const cv::Mat& quilt, const QuiltLayout& layout,
                                     double viewAspect, double panelAspect, FitMode mode,
                                     cv::Mat& fitted);

} // namespace altiro3D
