#pragma once

#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

class QScreen;

namespace altiro3D::qt {

/// Properties of a screen as the desktop reports them.
struct ScreenFacts {
    std::string name;         ///< Name of the connector ("HDMI-1"); on some systems the model.
    std::string model;        ///< From the screen's EDID: "LKG-P00655".
    std::string serialNumber; ///< From the screen's EDID; often empty.
    /// Mode in px: desktop size times `scale`. If `scale` is not 1, off by up to `scale` px.
    cv::Size size;
    double scale = 1;     ///< Px of the screen per px of the desktop (device pixel ratio).
    double refreshHz = 0; ///< Refresh rate in Hz; 0 = unknown.
};

/// Reads the properties of one screen of the application.
/// @param screen one of QGuiApplication::screens()
/// @return its properties
[[nodiscard]] ALTIRO3D_EXPORT ScreenFacts factsOf(const QScreen& screen);

/// How a screen was paired with a calibration volume.
enum class PairedBy {
    Nothing, ///< Not paired: one of the two is missing.
    Serial,  ///< The screen's name matches the volume's name or the calibration's serial number.
    Size     ///< Only one screen and one volume of this panel size were left.
};

/// A light-field display; parts that were not found are empty.
struct FoundDisplay {
    std::optional<std::size_t> screen;      ///< Index into the screens.
    std::filesystem::path calibrationFile;  ///< Path of its visual.json; empty if missing.
    std::string volume;                     ///< Name of its volume; empty if missing.
    std::optional<Calibration> calibration; ///< Absent if the file is missing or invalid.
    PairedBy pairedBy = PairedBy::Nothing;  ///< How screen and volume were paired.
    std::vector<std::string> problems;      ///< What keeps it from showing Natives correctly.

    /// "LKG-P00655": the volume's name, else the word that begins with LKG or CubeVi in the
    /// screen's name, model or serial number, in upper case.
    std::string name;
};

/// Whether a screen has a size: exactly, or if the desktop scales it, within the rounding of its
/// size to whole px of the desktop.
/// @param screen from factsOf()
/// @param size in px
/// @return true if it has this size
[[nodiscard]] ALTIRO3D_EXPORT bool hasSize(const ScreenFacts& screen, cv::Size size);

/// What keeps a screen from showing Natives of a panel px by px: the desktop scales the screen, or
/// its size differs from the panel's.
/// @param screen from factsOf()
/// @param panel size of the panel in px
/// @return one sentence each, with what to do; empty if there is no problem
[[nodiscard]] ALTIRO3D_EXPORT std::vector<std::string> problemsOf(const ScreenFacts& screen,
                                                                  cv::Size panel);

/// Finds the light-field displays among screens and mounted volumes and pairs the two.
///
/// A screen is a light-field display if a word of its name, model or serial number begins with LKG
/// or CubeVi. It is paired with the volume of the same name or serial number. The remaining volumes
/// are paired by size where the panel size equals the mode and the pair is unambiguous; the screen
/// may then have any name. A display without screen or volume is listed with a problem that states
/// this.
/// @param screens from factsOf()
/// @param volumes from findVolumes(); invalid files become problems
/// @return displays with screens in the order of `screens`, then the others in that of `volumes`
[[nodiscard]] ALTIRO3D_EXPORT std::vector<FoundDisplay>
findDisplays(const std::vector<ScreenFacts>& screens,
             const std::vector<MountedCalibration>& volumes);

/// As findMountedCalibrations(); for "/" also finds volumes that are mounted elsewhere.
/// @param fileSystemRoot "/" except in tests
/// @return those of findMountedCalibrations(), then the others
[[nodiscard]] ALTIRO3D_EXPORT std::vector<MountedCalibration>
findVolumes(const std::filesystem::path& fileSystemRoot = "/");

/// Chooses the display for a Native of this size and calibration: the one whose calibration has the
/// same fingerprint, else the only one with a screen of that size, else the only one with a screen.
/// @param displays from findDisplays()
/// @param screens the screens that findDisplays() was given
/// @param calibration calibration of the Native, if known
/// @param native size of the Native in px
/// @return index into `displays`; nothing if no display has a screen or the choice is ambiguous
[[nodiscard]] ALTIRO3D_EXPORT std::optional<std::size_t>
chooseDisplay(const std::vector<FoundDisplay>& displays, const std::vector<ScreenFacts>& screens,
              const std::optional<Calibration>& calibration, cv::Size native);

} // namespace altiro3D::qt
