#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/quilt.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace altiro3D {

/// A model of display and what its maker recommends for it.
struct DisplayModel {
    std::string name;           ///< "Looking Glass Portrait".
    std::string serialPrefix;   ///< Serial numbers begin with this, without regard to case.
    cv::Size panelSize;         ///< Panel in px.
    double dpi = 0;             ///< Panel px per inch.
    double viewConeDegrees = 0; ///< Full horizontal view cone in degrees.
    QuiltLayout quilt;          ///< Default quilt.
};

/// All known models. @return in the order in which serial prefixes are tried; lives on
ALTIRO3D_EXPORT const std::vector<DisplayModel>& displayModels();

/// The model of a display, by its serial number, else by its panel.
/// @param calibration the display
/// @return one of displayModels(), or null if it is unknown
ALTIRO3D_EXPORT const DisplayModel* findDisplayModel(const Calibration& calibration);

/// The default quilt for a display: its model's; for an unknown panel 48 views (6 columns x 8 rows,
/// or 8 x 6 for an upright one) of the panel's shape in a quilt of about 4096 px.
///
/// @param calibration the display, valid
/// @return the layout
ALTIRO3D_EXPORT QuiltLayout defaultQuilt(const Calibration& calibration);

/// Remarks about a calibration that is valid but odd: a serial number of another model than the
/// panel's, fringe correction that is not applied, flags that no known unit has set.
///
/// @param calibration the display
/// @return one sentence each, for people; mostly none
ALTIRO3D_EXPORT std::vector<std::string> remarks(const Calibration& calibration);

/// A display that Natives are made for.
struct Display {
    Calibration calibration;                ///< What its visual.json says.
    QuiltLayout quilt;                      ///< Default layout of quilts.
    InvertViews invert = InvertViews::Auto; ///< Whether the order of views is reversed.
    std::string source;                     ///< Where the calibration comes from, for people.

    /// Size of the panel. @return columns x rows in px
    cv::Size panelSize() const { return {calibration.screenW, calibration.screenH}; }
    /// Shape of the panel. @return width : height
    double aspect() const { return static_cast<double>(calibration.screenW) / calibration.screenH; }
};

/// The display of a calibration, with the default quilt of its model.
/// @param calibration the display, valid
/// @param source where the calibration comes from, for people
/// @return the display
ALTIRO3D_EXPORT Display displayOf(Calibration calibration, const std::string& source = {});

/// Reads a display from its calibration.
///
/// @param calibrationFile its `visual.json`
/// @param serial which display, where the file holds several; empty: the first
/// @return the display, with the default quilt of its model
/// @throws Error as readCalibrations(); NotFound (no display of that serial number)
ALTIRO3D_EXPORT Display readDisplay(const std::filesystem::path& calibrationFile,
                                    const std::string& serial = {});

/// A calibration found on a display's own volume.
struct MountedCalibration {
    std::filesystem::path file; ///< Its visual.json.
    std::string volume;         ///< Name of the volume ("LKG-P00655").
};

/// Looks for displays' volumes that are mounted: `LKG*/LKG_calibration/visual.json` (without regard
/// to case of `LKG`) in `media`, `run/media`, `mnt` and `Volumes` and in the directories there, as
/// `media/<user>`.
///
/// @param fileSystemRoot "/" outside of tests
/// @return in order of their paths; unreadable directories are passed over
ALTIRO3D_EXPORT std::vector<MountedCalibration>
findMountedCalibrations(const std::filesystem::path& fileSystemRoot = "/");

} // namespace altiro3D
