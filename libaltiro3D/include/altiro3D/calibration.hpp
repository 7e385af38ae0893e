#pragma once

#include "altiro3D/export.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace altiro3D {

/// Where the colours of one pixel sit, relative to the pixel's centre, in px; y grows upward.
struct SubpixelCell {
    std::array<double, 3> x{}; ///< Offsets to the right of red, green, blue, -1..1 px.
    std::array<double, 3> y{}; ///< Offsets upward of red, green, blue, -1..1 px.
};

/// A display's calibration as its `visual.json` gives it: the file's names, the file's values.
struct Calibration {
    std::string configVersion; ///< Format tag of the file; informative.
    std::string serial;        ///< Serial number ("LKG-PORT-19930"); may be empty.
    double pitch = 0;          ///< Lenses per inch, perpendicular to the lenses, > 0.
    double slope = 0;          ///< Rise over run of a lens in panel px, y counted down, != 0.
    double center = 0;         ///< Phase offset of the lens array in lens periods, +-1e6 at most.
    double fringe = 0;         ///< Colour fringe correction; 0 in every known unit, not used.
    double viewCone = 0;       ///< Full horizontal view cone in degrees, 0..180; 0 = not given.
    double invView = 1;        ///< View order under the lens is reversed if >= 0.5.
    double verticalAngle = 0;  ///< Tilt of the viewing axis in degrees; not used by the mapping.
    double DPI = 0;            ///< Panel px per inch, > 0.
    int screenW = 0;           ///< Panel width in px, 16..16384.
    int screenH = 0;           ///< Panel height in px, 16..16384.
    double flipImageX = 0;     ///< The picture is mirrored left-right if >= 0.5.
    double flipImageY = 0;     ///< The picture is mirrored upside down if >= 0.5.
    double flipSubp = 0;       ///< The panel is BGR instead of RGB if >= 0.5.
    int CellPatternMode = 0;   ///< How the cells repeat over the panel, 0..4.
    std::vector<SubpixelCell> subpixelCells; ///< Empty on classic RGB stripe panels; at most 16.
};

/// Largest panel side in px.
constexpr int kMaxPanelSide = 16384;

/// Checks a calibration: each field by its range, and that pitch, DPI and slope together make a
/// lens array, of 0.001 lens periods across the panel to one per sub-pixel.
///
/// @param calibration what to check
/// @param source its name in the error message, for instance the file's
/// @throws Error BadFormat that names source, field, value and what is expected
ALTIRO3D_EXPORT void validate(const Calibration& calibration,
                              const std::string& source = "calibration");

/// Reads a `visual.json` in any of its variants: wrapped (`{"value": x}`) or bare numbers, integers
/// or floats, missing optional fields, a byte order mark, the calibration nested up to three
/// containers deep or held in a string. Unknown keys are passed over. Of several calibrations the
/// first is taken; the others must be valid, too.
///
/// @param file the file, at most 4 MiB
/// @return the calibration, valid
/// @throws Error NotFound, ReadFailed, TooLarge, BadFormat (file, field, value, what is expected),
///         OutOfMemory
ALTIRO3D_EXPORT Calibration readCalibration(const std::filesystem::path& file);

/// All calibrations in a file. Files with several come from services that list the devices they
/// know.
///
/// @param file as for readCalibration()
/// @return at least one, in the file's order, all of them valid
/// @throws Error as readCalibration()
ALTIRO3D_EXPORT std::vector<Calibration> readCalibrations(const std::filesystem::path& file);

/// readCalibration() of a text.
/// @param text the file's contents
/// @param source the file's name, for errors
/// @return the calibration, valid
/// @throws Error BadFormat (source, field, value, what is expected)
ALTIRO3D_EXPORT Calibration parseCalibration(const std::string& text, const std::string& source);

/// readCalibrations() of a text.
/// @param text the file's contents
/// @param source the file's name, for errors
/// @return at least one, in the text's order, all of them valid
/// @throws Error BadFormat (source, field, value, what is expected)
ALTIRO3D_EXPORT std::vector<Calibration> parseCalibrations(const std::string& text,
                                                           const std::string& source);

/// A hash of all fields that enter the sub-pixel mapping (the serial number is not among them):
/// calibrations of the same fingerprint give the same picture. The other way round it need not be
/// so: `invView` counts also on panels with cells, where InvertViews::Auto does not look at it.
///
/// @param calibration need not be valid
/// @return 64-bit FNV-1a hash
ALTIRO3D_EXPORT std::uint64_t fingerprint(const Calibration& calibration);

/// A fingerprint as text.
/// @param fingerprint from fingerprint()
/// @return 16 hexadecimal digits in lower case
ALTIRO3D_EXPORT std::string fingerprintText(std::uint64_t fingerprint);

/// Whether the order of views under a lens is reversed.
enum class InvertViews {
    Auto, ///< As `invView` says on stripe panels; always on panels with sub-pixel cells.
    On,   ///< Reversed.
    Off   ///< Not reversed.
};

/// What a calibration means for the mapping from sub-pixels to views (docs/mathematics.md, 1).
/// Derived, never stored. All in double precision.
struct ALTIRO3D_EXPORT LensGeometry {
    int panelWidth = 0;         ///< Panel width in px.
    int panelHeight = 0;        ///< Panel height in px.
    double periodsPerWidth = 0; ///< P: lens periods across the panel's width (1.1).
    /// T: shift of the lenses over the panel's height, panel widths; negated if mirrored (1.2).
    double tilt = 0;
    double subpixelStep = 0;         ///< One sub-pixel in panel widths; negative if mirrored (1.3).
    double center = 0;               ///< c: phase offset in lens periods.
    double lensPeriodSubpixels = 0;  ///< Px: lens period in sub-pixels, 3 W / P (1.11).
    double offsetSubpixels = 0;      ///< i_off of the published Eq. (1), in sub-pixels (1.11).
    bool inverted = true;            ///< View order under the lens is reversed.
    bool mirrorX = false;            ///< Sample the views mirrored left-right.
    bool mirrorY = false;            ///< Sample the views mirrored upside down.
    bool blueFirst = false;          ///< Red and blue swap their sub-pixel positions.
    int cellPattern = 0;             ///< CellPatternMode; 0 if there are no cells.
    std::vector<SubpixelCell> cells; ///< Empty on stripe panels.

    /// Index of the cell of a pixel (docs/mathematics.md, 1).
    /// @param x column, 0..panelWidth-1
    /// @param y row from the top, 0..panelHeight-1
    /// @return index into `cells`; 0 without cells
    int cellIndex(int x, int y) const;

    /// Position under the lens of a sub-pixel: docs/mathematics.md, (1.4) to (1.9). Written for
    /// clarity; the fast way is NativeLut.
    /// @param x column, 0..panelWidth-1
    /// @param y row from the top, 0..panelHeight-1
    /// @param channel 0 red, 1 green, 2 blue
    /// @return z, 0..1: 0 = where view 0 begins, 1 = end of the last view
    double phase(int x, int y, int channel) const;

    /// View that a phase belongs to: min(floor(phase * views), views - 1), docs/mathematics.md,
    /// (1.10). Nothing is checked.
    /// @param phase z, 0..1, from phase()
    /// @param views N, number of views, 1 or more
    /// @return 0..views-1
    static int viewOfPhase(double phase, int views);
};

/// Derives the lens geometry: docs/mathematics.md, (1.1) to (1.3) and (1.11).
///
/// @param calibration the display
/// @param invert whether the order of views is reversed
/// @return the geometry
/// @throws Error BadFormat if the calibration is not valid
ALTIRO3D_EXPORT LensGeometry lensGeometry(const Calibration& calibration,
                                          InvertViews invert = InvertViews::Auto);

} // namespace altiro3D
