#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/quilt2native.hpp"
#include "altiro3D/quilt_search.hpp"
#include "common/run_tool.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace altiro3D::tools {

/// The display that a run is for. With a map its quilt is the map's.
struct ChosenDisplay : Display {
    std::vector<std::filesystem::path> files; ///< What was read: map, calibration.
    std::optional<NativeLut> map;             ///< Present with `-m`.
    bool isMapOnly = false; ///< Of the calibration only serial number and panel are known.
    bool isSample = false;  ///< No display was given or found.
};

/// Where look-up tables and measured costs are kept from run to run; empty if the user has no such
/// place. It need not exist.
std::filesystem::path cacheDirectory();

/// -m -c --serial --invert, -q -r
void addDisplayOptions(CommandLine& commandLine);
/// -q -r as such, for the tool that makes maps
void addQuiltOptions(CommandLine& commandLine);
/// --view-filter --sampling
void addSamplingOptions(CommandLine& commandLine);
/// @throws UsageError
QuiltSampling samplingOption(const CommandLine& commandLine);
/// Sub-pixels mix views or px of views.
bool blends(const QuiltSampling& sampling);
/// --invert as such, for the tool that makes maps
void addInvertOption(CommandLine& commandLine);
InvertViews invertOption(const CommandLine& commandLine);

/// The display of a calibration: its panel, and the quilt of its model.
/// @param file that it was read from
ChosenDisplay chosenDisplay(Calibration calibration, const std::filesystem::path& file,
                            InvertViews invert = InvertViews::Auto);

/// The mounted volumes among which findDisplay() looks.
struct VolumeSearch {
    /// Finds them.
    std::function<std::vector<MountedCalibration>()> find = [] {
        return findMountedCalibrations();
    };
    /// Of several, without `--serial`, the first is taken with a warning, as another can be chosen
    /// later; else that is an error.
    bool firstWillDo = false;
};

/// What a run makes of a display's calibration.
enum class DisplayUse {
    Show,     ///< A picture for this panel.
    Simulate, ///< What an eye sees of such a picture.
    Quilt,    ///< A quilt of the display's shape and layout.
    Describe, ///< A text about it.
    None      ///< Nothing: there is nothing to say about it.
};

/// Finds the display: `-m` and `-c`, else `$LKG_CALIBRATION`, `./visual.json`, a mounted display
/// volume, and at last the sample calibration. Says which one it is (tellDisplay()).
/// @throws UsageError, Error
ChosenDisplay findDisplay(const CommandLine& commandLine, Messages& messages,
                          const VolumeSearch& volumes = {}, DisplayUse use = DisplayUse::Show);
/// As findDisplay(), where -m is not a table to read.
ChosenDisplay findCalibration(const CommandLine& commandLine, Messages& messages,
                              const VolumeSearch& volumes = {}, DisplayUse use = DisplayUse::Show);

/// Says which display a run is for: "display: ...". Warns where that is the sample only, and of
/// what is odd about the calibration.
void tellDisplay(const ChosenDisplay& display, DisplayUse use, Messages& messages);

/// The file that is meant: in a display's volume, or its folder, the calibration.
/// @throws Error BadFormat (a look-up table)
std::filesystem::path calibrationFile(const std::filesystem::path& given);

/// Reads one calibration; of several, `--serial` chooses, or the first is taken with a warning.
Calibration readChosenCalibration(const std::filesystem::path& file, const CommandLine& commandLine,
                                  Messages& messages);

/// Says that black bars keep the shape of a quilt's views, where nobody asked for them.
void tellShape(const QuiltShape& shape, Messages& messages);

/// What a quilt is understood to be, for people: QuiltLayout::text(), and the shape that its views
/// are shown in where their px are not square.
/// @param aspect width : height of a view as it is shown
std::string quiltText(const QuiltLayout& layout, double aspect);

/// resolveQuilt() for a request of the command line: errors and warnings name `-q` and `-r`.
ResolvedQuilt resolveLayout(const QuiltRequest& request, const QuiltLayout& standard,
                            double panelAspect);
/// `-q`. @throws UsageError
std::optional<QuiltGrid> gridOption(const CommandLine& commandLine);

/// Whether the layout of a quilt file is stated: by `-q` and `-r`, or by its name.
bool isLayoutStated(const CommandLine& commandLine, const std::filesystem::path& quiltFile);

/// The layout that was found in a picture, if it is certain; none if it is not, but the picture has
/// the size of `usual`, which is then the best guess.
/// @throws Error BadFormat (no quilt), UsageError (not certain)
std::optional<QuiltGrid> certainLayout(const FoundQuilt& found, const std::filesystem::path& file,
                                       cv::Size size, const QuiltLayout& usual);

/// "; found in the picture, 97 % sure"
std::string foundText(const FoundQuilt& found);

/// The quilt's layout from `-q`, `-r`, a quilt's file name, its size, and what was found in it.
/// Tell the user what was understood (quiltText(), foundText()).
/// @param quiltFile the quilt that is read, if one is
/// @param quiltSize its size in px
/// @param found what was found in it; only if its layout is not stated
QuiltLayout chooseQuilt(const CommandLine& commandLine, const ChosenDisplay& display,
                        Messages& messages,
                        const std::optional<std::filesystem::path>& quiltFile = std::nullopt,
                        std::optional<cv::Size> quiltSize = std::nullopt,
                        const std::optional<FoundQuilt>& found = std::nullopt);

/// The look-up table of a display: the map of `-m`, else one that is kept in the user's cache
/// directory.
NativeLut lookUpTable(const ChosenDisplay& display, const QuiltLayout& layout, Messages& messages);

/// The renderer for a display: through lookUpTable(), or by blending if `--view-filter` or
/// `--sampling` ask for it.
Quilt2Native makeQuilt2Native(const CommandLine& commandLine, const ChosenDisplay& display,
                              const QuiltLayout& layout, Messages& messages);

} // namespace altiro3D::tools
