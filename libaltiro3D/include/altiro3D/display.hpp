#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/quilt.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace altiro3D {

/// A display model and its maker's recommendations.
struct DisplayModel {
    std::string name;           ///< "Looking Glass Portrait".
    std::string serialPrefix;   ///< Prefix of its serial numbers, upper or lower case.
    cv::Size panelSize;         ///< Panel in px.
    double dpi = 0;             ///< Panel px per inch.
    double viewConeDegrees = 0; ///< Full horizontal view cone in degrees.
    QuiltLayout quilt;          ///< Default quilt.
};

/// Finds the model of a display by its serial number, else by its panel.
/// @param calibration the display
/// @return the model, which stays until the program ends; null if it is unknown
[[nodiscard]] ALTIRO3D_EXPORT const DisplayModel* findDisplayModel(const Calibration& calibration);

/// The default quilt for a display: its model's. For an unknown model: 48 views of the panel's
/// shape, 6 columns x 8 rows (upright panels 8 x 6), in a quilt whose longer side has about 4096
/// px.
///
/// @param calibration the display; must be valid
/// @return the layout
[[nodiscard]] ALTIRO3D_EXPORT QuiltLayout defaultQuilt(const Calibration& calibration);

/// Remarks about a calibration that is valid but unusual: the serial number and the panel belong to
/// different models, fringe correction is set, which altiro3D ignores, a flag is set that no known
/// unit sets.
///
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
        return static_cast<double>(calibration.screenW) / calibration.screenH;
    }
};

/// Makes a display from a calibration, with defaultQuilt().
/// @param calibration the display
/// @param source where the calibration comes from, for people
/// @return the display
/// @throws Error BadFormat as validate() (calibration)
[[nodiscard]] ALTIRO3D_EXPORT Display displayOf(Calibration calibration,
                                                const std::string& source = {});

/// Reads a display from its calibration.
///
/// @param calibrationFile its `visual.json`
/// @param serial serial number of the display if the file holds several; empty: the first one
/// @return the display, with defaultQuilt()
/// @throws Error as readCalibrations(); NotFound (no display with that serial number)
[[nodiscard]] ALTIRO3D_EXPORT Display readDisplay(const std::filesystem::path& calibrationFile,
                                                  const std::string& serial = {});

/// A calibration found on a display's own volume.
struct MountedCalibration {
    std::filesystem::path file; ///< Its visual.json.
    std::string volume;         ///< Name of the volume ("LKG-P00655").
};

/// Finds mounted volumes of displays: `LKG*/LKG_calibration/visual.json` (upper or lower case) in
/// `media`, `run/media`, `mnt` and `Volumes` and in their subdirectories, such as `media/<user>`.
///
/// @param fileSystemRoot "/" except in tests
/// @return sorted by path; unreadable directories are skipped
[[nodiscard]] ALTIRO3D_EXPORT std::vector<MountedCalibration>
findMountedCalibrations(const std::filesystem::path& fileSystemRoot = "/");

} // namespace altiro3D
