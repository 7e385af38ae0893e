#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/quilt2native.hpp"
#include "common/run_tool.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace altiro3D::tools {

/// The display of a run. With a map, the quilt is the map's.
struct ChosenDisplay : Display {
    std::vector<std::filesystem::path> files; ///< Files that were read: map, calibration.
    std::optional<NativeLut> map;             ///< Set with `-m`.
    bool isMapOnly = false; ///< Only serial number and panel of the calibration are known.
    bool isSample = false;  ///< No display was given or found; this is the sample.
};

/// The user's directory for cached look-up tables and measured costs. It need not exist. Empty if
/// the environment does not define one.
std::filesystem::path cacheDirectory();

/// -m -c --serial --invert, -q -r
void addDisplayOptions(CommandLine& commandLine);
/// -q -r alone, for the tool that makes maps
void addQuiltOptions(CommandLine& commandLine);
/// --view-filter --sampling
void addSamplingOptions(CommandLine& commandLine);
/// @throws UsageError
QuiltSampling samplingOption(const CommandLine& commandLine);
/// True if sub-pixels blend views or px of views.
bool blends(const QuiltSampling& sampling);
/// --invert alone, for the tool that makes maps
void addInvertOption(CommandLine& commandLine);
InvertViews invertOption(const CommandLine& commandLine);

/// The display of a calibration, with the quilt of its model.
/// @param file the file that it was read from
ChosenDisplay chosenDisplay(Calibration calibration, const std::filesystem::path& file,
                            InvertViews invert = InvertViews::Auto);

/// How findDisplay() searches mounted volumes.
struct VolumeSearch {
    /// Finds the volumes.
    std::function<std::vector<MountedCalibration>()> find = [] {
        return findMountedCalibrations();
    };
    /// If several volumes are found and `--serial` is not given: true takes the first one with a
    /// warning, because the user can choose another one later; false is an error.
    bool firstWillDo = false;
};

/// What a run uses the display for; decides which messages about it are shown.
enum class DisplayUse {
    Show,     ///< A picture for this panel.
    Simulate, ///< What an eye sees of such a picture.
    Quilt,    ///< A quilt of the display's shape and layout.
    Describe, ///< A description of the display.
    None      ///< Nothing; no messages.
};

/// Finds the display: `-m` and `-c`, else `$LKG_CALIBRATION`, `./visual.json`, a mounted display
/// volume, or finally the sample calibration. Reports it with tellDisplay().
/// @throws UsageError, Error
ChosenDisplay findDisplay(const CommandLine& commandLine, Messages& messages,
                          const VolumeSearch& volumes = {}, DisplayUse use = DisplayUse::Show);
/// As findDisplay(), for tools whose -m does not name a look-up table to read.
ChosenDisplay findCalibration(const CommandLine& commandLine, Messages& messages,
                              const VolumeSearch& volumes = {}, DisplayUse use = DisplayUse::Show);

/// Reports the display of a run: "display: ...". Warns if it is the sample or if the calibration is
/// unusual.
void tellDisplay(const ChosenDisplay& display, DisplayUse use, Messages& messages);

/// The calibration file that a path stands for; the path may be a display's volume or its folder.
/// @throws Error BadFormat (a look-up table)
std::filesystem::path calibrationFile(const std::filesystem::path& given);

/// Reads one calibration. If the file holds several, `--serial` chooses; without it, the first is
/// taken with a warning.
Calibration readChosenCalibration(const std::filesystem::path& file, const CommandLine& commandLine,
                                  Messages& messages);

/// Reports black bars that keep the shape of a quilt's views, unless the user asked for them.
void tellShape(const QuiltShape& shape, Messages& messages);

/// A quilt's layout as text for people: QuiltLayout::text(), followed by the shape of the views if
/// their px are not square.
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

/// Whether a picture is a quilt, by what was found in it; if that is unsure, by its size.
/// @param usual the layout that it would have
bool isQuiltPicture(const FoundQuilt& found, cv::Size picture, const QuiltLayout& usual);

/// "; found in the picture, 97 % sure"
std::string foundText(const FoundQuilt& found);

/// The quilt's layout from `-q`, `-r`, a quilt's file name, its size, and what was found in it. The
/// caller reports it with quiltText() and foundText().
/// @param quiltFile the input quilt, if there is one
/// @param quiltSize its size in px
/// @param found what was found in it; only if its layout is not stated
QuiltLayout chooseQuilt(const CommandLine& commandLine, const ChosenDisplay& display,
                        Messages& messages,
                        const std::optional<std::filesystem::path>& quiltFile = std::nullopt,
                        std::optional<cv::Size> quiltSize = std::nullopt,
                        const std::optional<FoundQuilt>& found = std::nullopt);

/// The look-up table of a display: the map of `-m`, else one from the user's cache directory, where
/// a new table is kept.
NativeLut lookUpTable(const ChosenDisplay& display, const QuiltLayout& layout, Messages& messages);

/// The renderer for a display: it uses lookUpTable(), or blends if `--view-filter` or `--sampling`
/// ask for it.
Quilt2Native makeQuilt2Native(const CommandLine& commandLine, const ChosenDisplay& display,
                              const QuiltLayout& layout, Messages& messages);

} // namespace altiro3D::tools
