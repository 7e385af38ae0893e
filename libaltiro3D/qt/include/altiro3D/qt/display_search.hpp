#pragma once

#include "altiro3D/calibration.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/export.hpp"

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

class QScreen;

namespace altiro3D::qt {

/// What the desktop says about a screen.
struct ScreenFacts {
    std::string name;         ///< Of the connector ("HDMI-1"); on some systems that of the model.
    std::string model;        ///< From the screen itself (EDID): "LKG-P00655".
    std::string serialNumber; ///< From the screen itself; often empty.
    /// Its mode in px: desktop size times `scale`, so where that is not 1 off by up to `scale` px.
    cv::Size size;
    double scale = 1;     ///< Px of the screen for one of the desktop (device pixel ratio).
    double refreshHz = 0; ///< Pictures a second; 0 = not known.
};

/// The facts about one screen of the application.
/// @param screen one of QGuiApplication::screens()
/// @return what the desktop says of it
ALTIRO3D_EXPORT ScreenFacts factsOf(const QScreen& screen);

/// How a screen and a calibration volume were found to belong together.
enum class PairedBy {
    Nothing, ///< They were not: one of the two is missing.
    Serial,  ///< The screen's name is the volume's, or the calibration's serial number.
    Size     ///< Only one screen and one volume of this panel size are left.
};

/// A light-field display, as far as it was found.
struct FoundDisplay {
    std::optional<std::size_t> screen;      ///< Index into the screens.
    std::filesystem::path calibrationFile;  ///< Its visual.json; empty if there is none.
    std::string volume;                     ///< Name of its volume; empty if there is none.
    std::optional<Calibration> calibration; ///< Absent without a file, or if that is broken.
    PairedBy pairedBy = PairedBy::Nothing;  ///< Why the two belong together.
    std::vector<std::string> problems;      ///< What keeps it from showing Natives rightly.

    /// "LKG-P00655": the volume's name, else what begins so in the screen's name, model or serial
    /// number.
    std::string name;
};

/// What keeps a screen from showing a panel's Natives px by px: the desktop scales it, or it has
/// another size.
///
/// @param screen from factsOf()
/// @param panel size of the panel in px
/// @return one sentence each, with what to do; none if all is well
ALTIRO3D_EXPORT std::vector<std::string> problemsOf(const ScreenFacts& screen, cv::Size panel);

/// Finds the light-field displays among screens and mounted volumes and puts them together.
///
/// A screen is one if a word of its name, model or serial number begins with LKG. Each takes the
/// volume of its own name or serial number; what is left over is put together where panel size and
/// mode agree and no other pair could be meant; a volume may take a screen of another name so.
/// Displays that lack either part are listed with a problem that says so.
///
/// @param screens as factsOf() gives them
/// @param volumes as findVolumes() gives them; broken files become problems
/// @return those with screens in the screens' order, then the others in the volumes'
ALTIRO3D_EXPORT std::vector<FoundDisplay>
findDisplays(const std::vector<ScreenFacts>& screens,
             const std::vector<MountedCalibration>& volumes);

/// findMountedCalibrations(), and for "/" also volumes that are mounted anywhere else.
///
/// @param fileSystemRoot "/" outside of tests
/// @return as findMountedCalibrations(), then the others
ALTIRO3D_EXPORT std::vector<MountedCalibration>
findVolumes(const std::filesystem::path& fileSystemRoot = "/");

/// The display that a Native of this size and calibration is for: the one whose calibration has the
/// same fingerprint, else the only one with a screen of that size, else the only one with a screen.
///
/// @param displays as findDisplays() gives them
/// @param screens those that it was given
/// @param calibration the Native's, if it is known
/// @param native size of the Native in px
/// @return index into `displays`; nothing if no display has a screen, or several could be meant
ALTIRO3D_EXPORT std::optional<std::size_t>
chooseDisplay(const std::vector<FoundDisplay>& displays, const std::vector<ScreenFacts>& screens,
              const std::optional<Calibration>& calibration, cv::Size native);

} // namespace altiro3D::qt
