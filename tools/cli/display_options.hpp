#pragma once

#include "altiro3D/display.hpp"
#include "altiro3D/native_lut.hpp"
#include "cli/run_tool.hpp"

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

/// How the command line names a display.
struct DisplayOptions {
    std::filesystem::path map; ///< `-m`; empty: none.
    /// `-c`, also a display's volume, or "bridge"; empty: one is found.
    std::filesystem::path calibration;
    std::string serial; ///< `--serial`; empty: none.
    InvertViews invert = InvertViews::Auto;
    std::string bridge = "auto"; ///< Where `-c bridge` asks: `--bridge`.
};

/// -m -c --serial --invert, -q -r
void addDisplayOptions(CommandLine& commandLine);
/// --invert alone, for the tool that makes maps
void addInvertOption(CommandLine& commandLine);
InvertViews invertOption(const CommandLine& commandLine);
/// @throws UsageError
DisplayOptions displayOptions(const CommandLine& commandLine);

/// Adds the connected displays of the first generation, which have no volumes. Their calibrations
/// are kept in the user's cache. A display that cannot be read is added with its `problem`, but
/// only if there are no volumes.
std::vector<MountedCalibration> withUsbDisplays(std::vector<MountedCalibration> volumes);

/// How findDisplay() searches mounted volumes.
struct VolumeSearch {
    /// Finds the volumes and the displays without any.
    std::function<std::vector<MountedCalibration>()> find = [] {
        return withUsbDisplays(findMountedCalibrations());
    };
    /// If several volumes are found and `--serial` is not given: true takes the first one with a
    /// warning, because the user can choose another one later; false is an error.
    bool firstWillDo = false;
    bool isWindow = false; ///< Warnings name a menu of the viewer instead of options.
};

/// What a run uses the display for; decides which messages about it are shown.
enum class DisplayUse {
    Show,     ///< A picture for this panel.
    Simulate, ///< What an eye sees of such a picture.
    Quilt,    ///< A quilt of the display's shape and layout.
    Describe, ///< A description of the display.
    None      ///< Nothing; no messages.
};

/// Finds the display: `-m` and `-c` (a file, or Bridge), else `$LKG_CALIBRATION`, `./visual.json`,
/// a mounted display volume, a display's memory on USB, or finally the sample calibration. Reports
/// it, and warns if it is the sample or if the calibration is unusual. If a file holds several
/// calibrations, `--serial` chooses; without it, the first is taken with a warning.
/// @throws UsageError, Error
ChosenDisplay findDisplay(const DisplayOptions& options, Messages& messages,
                          const VolumeSearch& volumes = {}, DisplayUse use = DisplayUse::Show);

/// Whether `-c` names Looking Glass Bridge.
inline bool isBridge(const std::filesystem::path& calibration) {
    return calibration == "bridge";
}

/// The calibration file that a path stands for; the path may be a display's volume or its folder.
/// @throws Error BadFormat (a look-up table)
std::filesystem::path calibrationFile(const std::filesystem::path& given);

} // namespace altiro3D::tools
