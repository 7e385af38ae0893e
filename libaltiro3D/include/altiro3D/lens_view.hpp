#pragma once

#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// An eye in front of a display, far enough away to see all lenses at the same angle.
struct LensEye {
    /// The position under the lenses that it sees: 0 = start of view 0, 1 = end of the last view.
    /// Any finite number; lenses repeat, so only its fractional part matters.
    double phase = 0.5;
    /// The width that it sees under each lens in lens periods, 1/4096..1; 0 = the smallest width
    /// that a lens shows: one sub-pixel, or 1.5 px of a print.
    double spot = 0;
    /// How far it blurs luminance: the standard deviation in px, 0..64; see eyeBlur(). Colour is
    /// blurred twice as far. 0 = as sharp as the picture, as for prints.
    double blur = 0;
};

/// Full horizontal view cone of a display: the calibration's, else its model's, else 40 degrees.
/// @param calibration the display; not checked
/// @return C in degrees
[[nodiscard]] ALTIRO3D_EXPORT double viewConeDegrees(const Calibration& calibration);

/// The eye at an angle from the panel's normal: z = 1/2 + angle / cone, docs/mathematics.md, (2.4).
/// @param calibration gives the view cone, which converts the angle to a phase; not checked
/// @param angleDegrees 0 = straight ahead, negative = left, where view 0 is seen; beyond half the
///        cone the views repeat, as they do on a display
/// @return the eye, with LensEye::spot 0
/// @throws Error InvalidArgument (angle not finite)
[[nodiscard]] ALTIRO3D_EXPORT LensEye eyeAtAngle(const Calibration& calibration,
                                                 double angleDegrees);

/// Eye that sees exactly the sub-pixels of one view: z = (view + 0.5) / N, docs/mathematics.md,
/// (2.4).
/// @param view 0 (leftmost camera) .. viewCount-1
/// @param viewCount N, 1..4096
/// @return the eye, with a spot of 1/N
/// @throws Error InvalidArgument (out of these ranges)
[[nodiscard]] ALTIRO3D_EXPORT LensEye eyeAtView(int view, int viewCount);

/// The blur of an eye in front of a display: 1.6 arc minutes, 3 px of a Portrait at 50 cm.
/// @param calibration gives the size of a px; not checked
/// @param distanceCentimetres between eye and panel, 10..1000
/// @return the standard deviation in px for LensEye::blur, at most 64
/// @throws Error InvalidArgument (distance)
[[nodiscard]] ALTIRO3D_EXPORT double eyeBlur(const Calibration& calibration,
                                             double distanceCentimetres = 50);

/// Simulates what an eye sees of a Native through the display's lenses (docs/mathematics.md, 2a;
/// (2.5) bounds the loss).
///
/// Without blur, a sub-pixel is lit if its lens phase differs from the eye's by at most half the
/// spot. Each px of the result takes each colour from the nearest px with a lit sub-pixel of that
/// colour. Ties go to the nearer row, then to the upper row, then to the left. The result has the
/// panel's size but less detail: with a spot of 1/N, one lit sub-pixel stands for N px, and the px
/// of view k are up to a few px out of place. A colour without any lit sub-pixel is black. Mirrored
/// panels are seen unmirrored.
///
/// With LensEye::blur, the result is the light that comes through the lenses, as the eye blurs it.
/// In each row, a lens shows one sub-pixel, and so one colour, over its whole width: the one whose
/// phase is nearest to the eye's. The spot has no effect. The eye blurs in linear light: luminance
/// by the blur, colour by twice the blur.
///
/// If the calibration is not the Native's, the views mix, as they do on the display.
/// @param native [panel rows x panel cols, CV_8UC3, BGR]
/// @param calibration the display
/// @param eye position and width of what is seen
/// @param seen [as native]; may be `native` itself or share memory with it
/// @param invert whether the order of views is reversed
/// @throws Error BadFormat (calibration), InvalidArgument (type, eye, blur for a print), Mismatch
///         (size), TooLarge (a print above kMaxPanelSide)
ALTIRO3D_EXPORT void simulateView(const cv::Mat& native, const Calibration& calibration,
                                  const LensEye& eye, cv::Mat& seen,
                                  InvertViews invert = InvertViews::Auto);

} // namespace altiro3D
