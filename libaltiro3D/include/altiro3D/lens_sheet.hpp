#pragma once

#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"

#include <string>

namespace altiro3D {

/// How the colours of a px lie under a lens.
enum class SubpixelOrder {
    None,       ///< At one place: a print.
    Rgb,        ///< Stripes side by side, red at the left: most screens.
    Bgr,        ///< Stripes side by side, blue at the left.
    VerticalRgb ///< Stripes one above the other, red at the top.
};

/// Gives a calibration an order of colours; its lenses stay where they are.
/// @param calibration of any display; not checked
/// @param order how the colours of its px lie
ALTIRO3D_EXPORT void setSubpixels(Calibration& calibration, SubpixelOrder order);

/// A sheet of lenses on a print or a screen, by its numbers: docs/mathematics.md, (1.12), (1.13).
struct LensNumbers {
    double lpi = 0;            ///< Lenses per inch, perpendicular to them, as they appear; > 0.
    double dpi = 0;            ///< Px per inch across, 10..10000.
    double dpiDown = 0;        ///< Px per inch down, 10..10000; 0 = as across.
    double width = 0;          ///< Of the picture, mm, > 0.
    double height = 0;         ///< Of the picture, mm, > 0.
    bool isHorizontal = false; ///< The lenses lie, for pictures that change with a tilt.
    double angle = 0;          ///< Of the lenses, -45..45 degrees to the right going up, from the
                               ///< vertical; of lying ones, upwards going right.
    int views = 0;             ///< Number of views, 2..1024; 0 = as LensFacts::usefulViews.
    SubpixelOrder subpixels = SubpixelOrder::None; ///< None: a print; else a screen.
    double thickness = 0;                          ///< Of the sheet, mm, 0.01..100; 0 = unknown.
    double index = 0;    ///< Refractive index of the sheet, 1..3; 0 = unknown.
    double distance = 0; ///< Of the eye, mm, 1..1e6; 0 = unknown.
};

/// The calibration of a print or a screen by its numbers, which its `sheet` keeps.
///
/// @param numbers of the sheet
/// @return the calibration; it is valid. A vertical lens has slope 1e9.
/// @throws Error InvalidArgument (the field of `numbers`, its value, what is expected)
[[nodiscard]] ALTIRO3D_EXPORT Calibration calibrationOf(const LensNumbers& numbers);

/// The text of a `visual.json`, which readCalibration() reads.
/// @param calibration any valid one
/// @return JSON
/// @throws Error BadFormat if the calibration is not valid
[[nodiscard]] ALTIRO3D_EXPORT std::string calibrationText(const Calibration& calibration);

/// What follows from the numbers of a lens.
struct LensFacts {
    double width = 0;       ///< Of the picture, mm.
    double height = 0;      ///< Of the picture, mm.
    double lpi = 0;         ///< Lenses per inch, perpendicular to them.
    double usefulViews = 0; ///< Px (screens: sub-pixels) under a lens; more views blend.
    // 0 unless thickness and index are known
    double viewCone = 0;   ///< Full angle, degrees.
    double visualLpi = 0;  ///< As `lpi` appears at the distance, if it is the sheet's own; or 0.
    double sharpDepth = 0; ///< Between the nearest and the farthest plane without blur, mm.
    /// The ViewOptions::strengthPercent of it: two lenses between neighbouring views.
    double sharpStrength = 0;
};

/// @param calibration of a print, or of any display
/// @return what follows from it
/// @throws Error BadFormat if the calibration is not valid
[[nodiscard]] ALTIRO3D_EXPORT LensFacts lensFacts(const Calibration& calibration);

} // namespace altiro3D
