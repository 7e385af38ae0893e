#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/native_lut.hpp"
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

/// -m -c --serial --invert, -q -r
void addDisplayOptions(CommandLine& commandLine);
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

} // namespace altiro3D::tools
