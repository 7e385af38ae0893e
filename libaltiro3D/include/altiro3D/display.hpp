#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/quilt.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

/// Positions of the colours of one pixel relative to its centre, in px; y grows upward.
struct SubpixelCell {
    std::array<double, 3> x{}; ///< Offsets of red, green and blue to the right, -1..1 px.
    std::array<double, 3> y{}; ///< Upward offsets of red, green and blue, -1..1 px.
};

/// Data of a print, or of a lenticular sheet (a "lens sheet") on a screen, that complement its
/// calibration: lens_sheet.hpp.
struct LensSheet {
    bool isPrint = false; ///< True for a print, whose px hold all colours; false for a screen.
    double dpiDown = 0;   ///< Vertical px per inch, > 0; horizontal ones: Calibration::DPI.
    int views = 0;        ///< Number of views, 2..kMaxSheetViews; 0 means as in LensNumbers::views.
    double thickness = 0; ///< Thickness of the sheet in mm, 0.01..100; 0 = unknown.
    double index = 0;     ///< Refractive index of the sheet, 1..3; 0 = unknown.
    double distance = 0;  ///< Viewing distance in mm, 1..1e6; 0 = unknown.
};

/// Largest LensSheet::views.
constexpr int kMaxSheetViews = 1024;

/// Lenses over stripes of red, green and blue, in sub-pixels. A sub-pixel lies at the place t under
/// its lens: docs/mathematics.md, (1.14), or (1.16) with slopeInSubpixels.
struct ALTIRO3D_EXPORT SubpixelLens {
    double period = 0;             ///< I, sub-pixels across one lens, 2..1000.
    double slope = 0;              ///< s, shift per row: -1..1 px, or -3..3 sub-pixels.
    double offset = 0;             ///< X0, -1e4..1e4 sub-pixels.
    bool slopeInSubpixels = false; ///< Slope in sub-pixels, (1.16); else in px, (1.14).

    /// The place t before the modulo. @param x, y px from the top left @param k colour stripe, 0..2
    /// @return sub-pixels
    [[nodiscard]] double wholePlace(int x, int y, int k) const;
};

/// A display's calibration with the names and values of its `visual.json`.
struct Calibration {
    std::string configVersion; ///< Format tag of the file; informative.
    std::string serial;        ///< Serial number ("LKG-PORT-19930"); may be empty.
    double pitch = 0;          ///< Lenses per inch, perpendicular to the lenses, > 0.
    double slope = 0;          ///< Rise over run of a lens in panel px, y counted down, != 0.
    double center = 0;         ///< Phase offset of the lens array in lens periods, -1e6..1e6.
    double fringe = 0;         ///< Colour fringe correction; 0 in every known unit; not used.
    double viewCone = 0;       ///< Full horizontal view cone in degrees, 0..180; 0 = not given.
    double invView = 1;        ///< View order under the lens is reversed if >= 0.5.
    double verticalAngle = 0;  ///< Tilt of the viewing axis in degrees; not used by the mapping.
    double DPI = 0;            ///< Panel px per inch, > 0.
    int screenW = 0;           ///< Panel width in px, 16..16384; of a print up to 40000.
    int screenH = 0;           ///< Panel height in px; same limits as the width.
    double flipImageX = 0;     ///< The picture is mirrored left-right if >= 0.5.
    double flipImageY = 0;     ///< The picture is mirrored upside down if >= 0.5.
    double flipSubp = 0;       ///< The panel is BGR instead of RGB if >= 0.5.
    int CellPatternMode = 0;   ///< How the cells repeat over the panel, 0..4.
    std::vector<SubpixelCell> subpixelCells; ///< At most 16; empty on classic RGB stripe panels.
    std::vector<std::string> missing;        ///< Which of "viewCone", "invView" the file lacks.
    std::optional<LensSheet> sheet;          ///< Set for prints and screens with a lens sheet.
    /// Set if the lenses are known in sub-pixels; setLens() derives pitch, slope and center from
    /// it. Phases and views are then computed from it and not from pitch, slope and center, unless
    /// subpixelCells or flipImageX are set.
    std::optional<SubpixelLens> lens;
    /// The views under a lens from left to right, a permutation of 0..N-1 with N of 2..64, as on
    /// some screens with a parallax barrier; empty: in order.
    std::vector<int> viewOrder;
};

/// Largest panel side in px.
constexpr int kMaxPanelSide = 16384;
/// Largest side of a print in px. Beyond kMaxPanelSide there are no look-up tables.
constexpr int kMaxPrintSide = 40000;

/// Checks a calibration: the range of each field, and that pitch, DPI and slope describe a possible
/// lens array of at least 0.001 lens periods across the panel and at most one per sub-pixel.
/// @param calibration the calibration to check
/// @param source its name in the error message, for example the file name
/// @throws Error BadFormat that names source, field, value and what is expected
ALTIRO3D_EXPORT void validate(const Calibration& calibration,
                              const std::string& source = "calibration");

/// Sets the lens of a calibration, and pitch, slope and center by it: docs/mathematics.md, (1.15).
/// @param calibration with DPI, screenW and screenH
/// @param lens its lens; not checked
ALTIRO3D_EXPORT void setLens(Calibration& calibration, const SubpixelLens& lens);

/// Reads a `visual.json` in any of its variants: wrapped (`{"value": x}`) or bare numbers, integers
/// or floats, missing optional fields, a byte order mark, the calibration nested up to three
/// containers deep or held in a string. Unknown keys are ignored. A CubeVi C1's file is also read:
/// lineNumber, obliquity and deviation, or interval, slope and x0. If the file holds several
/// calibrations, the first is returned and all must be valid.
/// @param file the file, at most 4 MiB
/// @return the calibration; it is valid
/// @throws Error NotFound, ReadFailed, TooLarge, BadFormat (file, field, value, what is expected),
///         OutOfMemory
[[nodiscard]] ALTIRO3D_EXPORT Calibration readCalibration(const std::filesystem::path& file);

/// Reads all calibrations in a file. Services that list several devices write such files.
/// @param file as for readCalibration()
/// @return one or more, in the file's order; all are valid
/// @throws Error as readCalibration()
[[nodiscard]] ALTIRO3D_EXPORT std::vector<Calibration>
readCalibrations(const std::filesystem::path& file);

/// Parses the calibrations in a text, as readCalibrations() does in a file.
/// @param text the file's contents
/// @param source the file's name, for errors
/// @return one or more, in the text's order; all are valid
/// @throws Error BadFormat (source, field, value, what is expected)
[[nodiscard]] ALTIRO3D_EXPORT std::vector<Calibration> parseCalibrations(const std::string& text,
                                                                         const std::string& source);

/// Hashes all fields that enter the sub-pixel mapping; the serial number does not. Calibrations
/// with the same fingerprint give the same picture. The converse does not always hold: `invView` is
/// part of the hash also on panels with cells, where InvertViews::Auto ignores it.
/// @param calibration the calibration; need not be valid
/// @return 64-bit FNV-1a hash
[[nodiscard]] ALTIRO3D_EXPORT std::uint64_t fingerprint(const Calibration& calibration);

/// Formats a fingerprint as text.
/// @param fingerprint from fingerprint()
/// @return 16 hexadecimal digits in lower case
[[nodiscard]] ALTIRO3D_EXPORT std::string fingerprintText(std::uint64_t fingerprint);

/// Whether the order of views under a lens is reversed.
enum class InvertViews {
    Auto, ///< `invView` decides on stripe panels; reversed on panels with sub-pixel cells.
    On,   ///< Reversed.
    Off   ///< Not reversed.
};

/// The quantities of a calibration that map sub-pixels to views (docs/mathematics.md, 1). They are
/// derived in double precision and never stored in a file.
struct ALTIRO3D_EXPORT LensGeometry {
    int panelWidth = 0;         ///< Panel width in px.
    int panelHeight = 0;        ///< Panel height in px.
    double periodsPerWidth = 0; ///< P: lens periods across the panel's width (1.1).
    /// T: shift of the lenses over the panel's height in panel widths; negated if mirrored (1.2).
    double tilt = 0;
    double subpixelStep = 0;         ///< One sub-pixel in panel widths; negative if mirrored (1.3).
    double center = 0;               ///< c: phase offset in lens periods.
    double lensPeriodSubpixels = 0;  ///< Lens period in sub-pixels, 3 W / P (1.11).
    double offsetSubpixels = 0;      ///< i_off, sub-pixels (1.11).
    bool inverted = true;            ///< View order under the lens is reversed.
    bool mirrorX = false;            ///< The views are sampled mirrored left-right.
    bool mirrorY = false;            ///< The views are sampled mirrored upside down.
    bool blueFirst = false;          ///< The positions of red and blue are exchanged.
    int cellPattern = 0;             ///< CellPatternMode; 0 if there are no cells.
    std::vector<SubpixelCell> cells; ///< Empty on stripe panels.
    std::optional<SubpixelLens> lens; ///< Calibration::lens; not set with cells or mirrorX.
    std::vector<int> viewOrder;       ///< Calibration::viewOrder.

    /// Whether the lenses are nearer to horizontal than to vertical, as in prints that change when
    /// tilted.
    /// @return true for an absolute slope below 1
    [[nodiscard]] bool isLying() const { return std::abs(tilt) * panelWidth > panelHeight; }

    /// Index of the cell of a pixel (docs/mathematics.md, 1).
    /// @param x column, 0..panelWidth-1
    /// @param y row from the top, 0..panelHeight-1
    /// @return index into `cells`; 0 without cells
    [[nodiscard]] int cellIndex(int x, int y) const;

    /// Position of a sub-pixel under its lens: docs/mathematics.md, (1.4) to (1.9). This is the
    /// readable reference; NativeLut is the fast path.
    /// @param x column, 0..panelWidth-1
    /// @param y row from the top, 0..panelHeight-1
    /// @param colour 0 red, 1 green, 2 blue
    /// @return z, 0..1: 0 = start of view 0, 1 = end of the last view
    [[nodiscard]] double phase(int x, int y, int colour) const;

    /// The view that a sub-pixel shows, with `viewOrder` taken into account. If `lens` is set, its
    /// formula, (1.14) or (1.16), gives the view instead of phase().
    /// @param x, y, colour as for phase()
    /// @param views N, number of views, 1 or more
    /// @return 0..views-1
    [[nodiscard]] int view(int x, int y, int colour, int views) const;

    /// View that a phase belongs to: min(floor(phase * views), views - 1), docs/mathematics.md,
    /// (1.10). Arguments are not checked.
    /// @param phase z, 0..1, from phase()
    /// @param views N, number of views, 1 or more
    /// @return 0..views-1
    [[nodiscard]] static int viewOfPhase(double phase, int views);
};

/// Derives the lens geometry: docs/mathematics.md, (1.1) to (1.3) and (1.11).
/// @param calibration the display
/// @param invert whether the order of views is reversed
/// @return the geometry
/// @throws Error BadFormat if the calibration is not valid
[[nodiscard]] ALTIRO3D_EXPORT LensGeometry lensGeometry(const Calibration& calibration,
                                                        InvertViews invert = InvertViews::Auto);

/// A display model and its maker's recommendations.
struct DisplayModel {
    std::string name;           ///< "Looking Glass Portrait".
    std::string serialPrefix;   ///< Prefix of serial numbers, in any case; empty if unknown.
    cv::Size panelSize;         ///< Panel in px; empty if it is not known.
    double dpi = 0;             ///< Panel px per inch; 0 if it is not known.
    double viewConeDegrees = 0; ///< Full horizontal view cone in degrees.
    QuiltLayout quilt;          ///< Default quilt.
    std::optional<QuiltLayout> earlierQuilt = {}; ///< Default in the maker's older documents.
};

/// Finds the model of a display by its serial number, else by its panel. The table of models, with
/// the source of each, is in display.cpp.
/// @param calibration the display
/// @return the model, which stays until the program ends; null if it is unknown, and for prints
///         and screens with a lens sheet
[[nodiscard]] ALTIRO3D_EXPORT const DisplayModel* findDisplayModel(const Calibration& calibration);

/// The default quilt of a display: its model's, or for an unknown model 48 views of the panel's
/// shape, 6 columns x 8 rows (upright panels 8 x 6), in a quilt of about the area of 4096 x 4096
/// px. Prints and screens with a lens sheet have LensSheet::views; if these are not 48, there are
/// about as many columns as rows. Views of a print have two px per lens, but its quilt has at most
/// about the area of 8192 x 8192 px.
/// @param calibration the display; must be valid
/// @return the layout
[[nodiscard]] ALTIRO3D_EXPORT QuiltLayout defaultQuilt(const Calibration& calibration);

/// Remarks about a calibration that is valid but unusual: the serial number and the panel belong to
/// different models; the model's sub-pixel cells are missing; fringe correction is set, which
/// altiro3D ignores; a flag is set that no known unit sets.
/// @param calibration the display
/// @return one sentence each, for people; usually empty
[[nodiscard]] ALTIRO3D_EXPORT Notes calibrationWarnings(const Calibration& calibration);

/// A display that Natives are made for.
struct Display {
    Calibration calibration;                ///< Contents of its visual.json.
    QuiltLayout quilt;                      ///< Default layout of its quilts.
    InvertViews invert = InvertViews::Auto; ///< Whether the order of views is reversed.
    std::string source;                     ///< Where the calibration comes from, for people.

    /// Size of the panel. @return columns x rows in px
    [[nodiscard]] cv::Size panelSize() const { return {calibration.screenW, calibration.screenH}; }
    /// Shape of the panel. @return width : height
    [[nodiscard]] double aspect() const {
        const double pixel = calibration.sheet ? calibration.sheet->dpiDown / calibration.DPI : 1;
        return pixel * calibration.screenW / calibration.screenH;
    }
};

/// Makes a display from a calibration, with defaultQuilt().
/// @param calibration the display
/// @param source where the calibration comes from, for people
/// @return the display
/// @throws Error BadFormat as validate() (calibration)
[[nodiscard]] ALTIRO3D_EXPORT Display displayOf(Calibration calibration,
                                                const std::string& source = {});

/// The layout that a request without a view size refers to: DisplayModel::earlierQuilt if the
/// request has the grid of earlierQuilt (or no grid, but the size of such a quilt); else the
/// display's default layout.
/// @param display the display
/// @param request what is known
/// @return the layout, for resolveQuilt()
[[nodiscard]] ALTIRO3D_EXPORT QuiltLayout usualQuilt(const Display& display,
                                                     const QuiltRequest& request);

/// Reads a display from its calibration.
/// @param calibrationFile its `visual.json`
/// @param serial serial number of the display if the file holds several; empty: the first one
/// @return the display, with defaultQuilt()
/// @throws Error as readCalibrations(); NotFound (no display with that serial number)
[[nodiscard]] ALTIRO3D_EXPORT Display readDisplay(const std::filesystem::path& calibrationFile,
                                                  const std::string& serial = {});

/// A calibration found on a display's own volume, or in its USB memory.
struct MountedCalibration {
    std::filesystem::path file;        ///< Its visual.json, or the device if there is a problem.
    std::string volume;                ///< Name of the volume ("LKG-P00655"), or the serial number.
    std::optional<Error> problem = {}; ///< Why a USB memory could not be read.
};

/// Reads the calibration that was found.
/// @param found from findMountedCalibrations() or of a USB memory
/// @return the calibration; it is valid
/// @throws Error as readCalibration() of the file; the problem, if there is one
[[nodiscard]] ALTIRO3D_EXPORT Calibration readCalibration(const MountedCalibration& found);

/// Finds mounted volumes of displays: `LKG*/LKG_calibration/visual.json` (upper or lower case) in
/// `media`, `run/media`, `mnt` and `Volumes` and in their subdirectories, such as `media/<user>`.
/// @param fileSystemRoot "/" except in tests
/// @return sorted by path; unreadable directories are skipped
[[nodiscard]] ALTIRO3D_EXPORT std::vector<MountedCalibration>
findMountedCalibrations(const std::filesystem::path& fileSystemRoot = "/");

/// A display of the first generation (8.9", 15.6", 8K), connected by USB.
struct UsbDisplay {
    std::filesystem::path device; ///< "/dev/hidraw3".
    std::string id;               ///< Identifies the unit and its port, 16 hexadecimal digits.
};

/// Finds displays of the first generation; on Linux only.
/// @param fileSystemRoot "/" except in tests
/// @return sorted by device; usually empty
[[nodiscard]] ALTIRO3D_EXPORT std::vector<UsbDisplay>
findUsbDisplays(const std::filesystem::path& fileSystemRoot = "/");

/// Reads the calibration in the memory of a display of the first generation. Waits up to 2 s.
/// @param display from findUsbDisplays()
/// @param cached result of an earlier call; if the first 64 bytes of the memory (length and
///        beginning of the text) fit it, the rest is not read and `cached` is returned
/// @return JSON for parseCalibrations(), at most 4096 bytes
/// @throws Error ReadFailed (no permission, no answer), BadFormat (an empty memory, damaged JSON),
///         TooLarge, Unsupported (a Portrait, which has a volume)
[[nodiscard]] ALTIRO3D_EXPORT std::string readUsbCalibration(const UsbDisplay& display,
                                                             const std::string& cached = {});

} // namespace altiro3D
