#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/export.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D {

/// An eye before a display, far enough away to see all lenses under the same angle.
struct LensEye {
    /// The place under the lenses that it sees: 0 = where view 0 begins, 1 = end of the last view.
    /// Any finite number; as lenses repeat, only its fractional part matters.
    double phase = 0.5;
    /// How much of what lies under a lens it takes in, lens periods, 1/4096..1; 0 = the width of
    /// one sub-pixel, which is the least that a lens shows.
    double spot = 0;
};

/// The full horizontal view cone of a display: the calibration's, else its model's, else 40.
///
/// @param calibration the display; not checked
/// @return C in degrees
ALTIRO3D_EXPORT double viewConeDegrees(const Calibration& calibration);

/// The eye at an angle from the panel's normal: z = 1/2 + angle / cone, docs/mathematics.md, (2.4).
///
/// @param calibration tells the view cone, over which the angle becomes a phase; not checked
/// @param angleDegrees 0 = straight ahead, less is to the left, where view 0 is seen; beyond half
///        the cone the views begin again, as they do on a display
/// @return the eye, with a spot of one sub-pixel
/// @throws Error InvalidArgument (angle not finite)
ALTIRO3D_EXPORT LensEye eyeAtAngle(const Calibration& calibration, double angleDegrees);

/// The eye that takes in exactly the sub-pixels that show one view: z = (view + 0.5) / N,
/// docs/mathematics.md, (2.4).
///
/// @param view 0 (leftmost camera) .. viewCount-1
/// @param viewCount N, 1..4096
/// @return the eye, with a spot of 1/N
/// @throws Error InvalidArgument (out of these ranges)
ALTIRO3D_EXPORT LensEye eyeAtView(int view, int viewCount);

/// What an eye sees of a Native through the display's lenses (docs/mathematics.md, 2a, with the
/// bound (2.5) of what is lost).
///
/// The sub-pixels whose lens phase lies within half the spot of the eye's are lit. Each px of the
/// result takes each colour from the lit sub-pixel of that colour whose px is nearest to it (of
/// equally near ones from the row that is nearer, the upper one, then from the left), so it has the
/// panel's size, but only its detail: with a spot of 1/N a lit sub-pixel stands for N px, and what
/// is seen of view k is view k itself with each px up to a few px out of place. Black where no
/// sub-pixel of a colour is lit at all. Mirrored panels are seen unmirrored.
///
/// With a calibration that is not the Native's the views mix, as they do on the display.
///
/// @param native [panel rows x panel cols, CV_8UC3, BGR]
/// @param calibration the display
/// @param eye where it is and how much it takes in
/// @param seen [as native]; may be `native` itself or share memory with it
/// @param invert whether the order of views is reversed
/// @throws Error BadFormat (calibration), InvalidArgument (type, eye), Mismatch (size)
ALTIRO3D_EXPORT void simulateView(const cv::Mat& native, const Calibration& calibration,
                                  const LensEye& eye, cv::Mat& seen,
                                  InvertViews invert = InvertViews::Auto);

} // namespace altiro3D
