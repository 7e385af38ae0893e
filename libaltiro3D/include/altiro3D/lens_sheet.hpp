#pragma once

#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"

#include <string>
#include <vector>

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

/// Numbers of a lens sheet on a print or a screen: docs/mathematics.md, (1.12), (1.13). The picture
/// has 16..kMaxPrintSide px a side (screens: up to kMaxPanelSide), and a lens covers at least two
/// px (screens: sub-pixels). Thickness and index are given together.
struct LensNumbers {
    double lpi = 0;            ///< Lenses per inch at the picture, perpendicular to them, > 0.
    double dpi = 0;            ///< Px per inch across, 10..10000.
    double dpiDown = 0;        ///< Px per inch down, 10..10000; 0 = as across.
    double width = 0;          ///< Width of the picture in mm, > 0.
    double height = 0;         ///< Height of the picture in mm, > 0.
    bool isHorizontal = false; ///< Horizontal lenses, for pictures that change when tilted.
    double angle = 0;          ///< Angle of the lenses in degrees, -45..45. Vertical lenses: from
                               ///< the vertical, > 0 if they lean to the right. Horizontal ones:
                               ///< from the horizontal, > 0 if they rise to the right.
    int views = 0; ///< Number of views, 2..1024; 0 = LensFacts::usefulViews (screens: 48).
    SubpixelOrder subpixels = SubpixelOrder::None; ///< None: a print; else a screen.
    double thickness = 0;                          ///< Thickness in mm, 0.01..100; 0 = unknown.
    double index = 0;    ///< Refractive index of the sheet, 1..3; 0 = unknown.
    double distance = 0; ///< Viewing distance in mm, 1..1e6; 0 = unknown.
};

/// A screen with lenses or a parallax barrier, in px and sub-pixels. Counted from 0 at the left,
/// sub-pixel i of row j (from 0 at the top) lies at (i + 1/2 - slope j - offset) mod pitch: (1.16).
struct BarrierNumbers {
    cv::Size panel;     ///< Px of the panel, 16..kMaxPanelSide.
    double dpi = 100;   ///< Px per inch, 10..10000; for sizes in mm only.
    double pitch = 0;   ///< Sub-pixels across one lens, 2..1000.
    double slope = 0;   ///< Sub-pixels to the right per row, -3..3.
    double offset = 0;  ///< Left edge of a lens in the top row, -10000..10000 sub-pixels.
    bool isBgr = false; ///< Blue is the leftmost colour.
    int views = 0; ///< Number of views, 2..1024; 0 = 48. If `order` is given: its length, or 0.
    /// Views under a lens from left to right, 0 the leftmost camera; a permutation of 0..N-1 with N
    /// of 2..64. Empty: the rightmost first, as lenses show them.
    std::vector<int> order;
};

/// Makes the calibration of such a screen. @param numbers the screen @return it; it is valid
/// @throws Error InvalidArgument (the field of `numbers`, its value, what is expected), BadFormat
///         (panel, order)
[[nodiscard]] ALTIRO3D_EXPORT Calibration calibrationOf(const BarrierNumbers& numbers);

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
    double visualLpi = 0;  ///< `lpi` as it appears from the distance; 0 = unknown.
    double sharpDepth = 0; ///< Depth between the nearest and the farthest sharp plane in mm.
    /// ViewOptions::strengthPercent for sharpDepth: a parallax of two lenses between adjacent
    /// views; at most 100.
    double sharpStrength = 0;
};

/// Computes the properties of a lens sheet.
/// @param calibration a print or any display
/// @return its properties
/// @throws Error BadFormat if the calibration is not valid
[[nodiscard]] ALTIRO3D_EXPORT LensFacts lensFacts(const Calibration& calibration);

} // namespace altiro3D
