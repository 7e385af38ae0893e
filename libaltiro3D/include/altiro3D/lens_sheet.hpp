#pragma once

#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"

#include <string>

namespace altiro3D {

/// How the colours of a px lie under a lens.
enum class SubpixelOrder {
    None,       ///< At one place, as in prints.
    Rgb,        ///< Stripes side by side, red at the left: most screens.
    Bgr,        ///< Stripes side by side, blue at the left.
    VerticalRgb ///< Stripes one above the other, red at the top.
};

/// Gives a calibration an order of colours; its lenses stay where they are.
/// @param calibration of any display; not checked
/// @param order how the colours of its px lie
ALTIRO3D_EXPORT void setSubpixels(Calibration& calibration, SubpixelOrder order);

/// Numbers of a lens sheet on a print or a screen: docs/mathematics.md, (1.12), (1.13).
struct LensNumbers {
    double lpi = 0;            ///< Lenses per inch, perpendicular to them, as they appear; > 0.
    double dpi = 0;            ///< Px per inch across, 10..10000.
    double dpiDown = 0;        ///< Px per inch down, 10..10000; 0 = as across.
    double width = 0;          ///< Width of the picture in mm, > 0.
    double height = 0;         ///< Height of the picture in mm, > 0.
    bool isHorizontal = false; ///< Horizontal lenses, for pictures that change when tilted.
    double angle = 0;          ///< Angle of the lenses in degrees, -45..45. Vertical lenses: from
                               ///< the vertical, > 0 if they lean to the right. Horizontal ones:
                               ///< from the horizontal, > 0 if they rise to the right.
    int views = 0;             ///< Number of views, 2..1024; 0 = LensFacts::usefulViews.
    SubpixelOrder subpixels = SubpixelOrder::None; ///< None: a print; else a screen.
    double thickness = 0;                          ///< Thickness in mm, 0.01..100; 0 = unknown.
    double index = 0;    ///< Refractive index of the sheet, 1..3; 0 = unknown.
    double distance = 0; ///< Viewing distance in mm, 1..1e6; 0 = unknown.
};

/// Makes the calibration of a print or a lens sheet on a screen; its `sheet` keeps the numbers.
/// @param numbers the sheet, its picture and its viewing distance
/// @return the calibration; it is valid. A vertical lens has slope 1e9.
/// @throws Error InvalidArgument (the field of `numbers`, its value, what is expected)
[[nodiscard]] ALTIRO3D_EXPORT Calibration calibrationOf(const LensNumbers& numbers);

/// The text of a `visual.json`, which readCalibration() reads.
/// @param calibration any valid one
/// @return JSON
/// @throws Error BadFormat if the calibration is not valid
[[nodiscard]] ALTIRO3D_EXPORT std::string calibrationText(const Calibration& calibration);

/// Properties of a lens sheet that follow from its numbers.
struct LensFacts {
    double width = 0;       ///< Width of the picture in mm.
    double height = 0;      ///< Height of the picture in mm.
    double lpi = 0;         ///< Lenses per inch, perpendicular to them.
    double usefulViews = 0; ///< Px (on screens: sub-pixels) under a lens; more views blend.
    // The following are 0 unless thickness and index are known.
    double viewCone = 0;   ///< Full view cone in degrees.
    double visualLpi = 0;  ///< The sheet's `lpi` as seen from the distance; 0 = unknown.
    double sharpDepth = 0; ///< Depth between the nearest and the farthest sharp plane in mm.
    /// ViewOptions::strengthPercent for sharpDepth: neighbouring views differ by two lenses.
    double sharpStrength = 0;
};

/// Computes the properties of a lens sheet.
/// @param calibration a print or any display
/// @return its properties
/// @throws Error BadFormat if the calibration is not valid
[[nodiscard]] ALTIRO3D_EXPORT LensFacts lensFacts(const Calibration& calibration);

} // namespace altiro3D
