#pragma once

#include "altiro3D/qt/display_search.hpp"
#include "cli/bridge.hpp"
#include "cli/display_options.hpp"
#include "cli/eyes_options.hpp"
#include "viewer/player/video_player.hpp"
#include "viewer/show/eye_source.hpp"
#include "viewer/show/slide_show.hpp"

#include <cstdio>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D::viewer {

/// What is shown on a display, and how.
struct ShowJob {
    std::vector<std::filesystem::path> files; ///< And folders; "-" alone: standard input.
    tools::DisplayOptions display;
    std::string screen; ///< By its name or number; empty: the display's own.
    SlideShow::Settings slides;
    PlaySettings play;
    std::optional<tools::EyesOptions> eyes; ///< `--stereo-layout` of --show
    std::optional<quint16> viewFrom;        ///< See eyePort().
    bool byMpv = false;                     ///< `--player mpv`
    std::optional<tools::BridgeJob> bridge;
};
/// Reads --show and what belongs to it. @throws UsageError
ShowJob showJob(const tools::CommandLine& commandLine);

/// Says why videos have no sound, if the computer has no sound output.
void detailSilence(tools::Messages& messages);

/// Shows files one after the other, or the Natives from standard input, on the display until the
/// user closes it or, without --loop, several files have been shown.
/// @throws UsageError, Error
int present(int& argc, char** argv, const ShowJob& job, tools::Messages& messages);

/// Writes the shader with which mpv shows quilts on a display to the user's cache. Warns of quilts
/// of another shape.
/// @param files quilts of one layout, which their names state
/// @throws Error BadFormat, Mismatch (names), NotFound (no cache), WriteFailed
std::filesystem::path writeMpvShader(const Display& display, const std::vector<Source>& files,
                                     tools::Messages& messages);

/// Replaces this process by mpv, which plays files on a screen. @param screen its name
/// @throws Error NotFound (mpv is not installed)
[[noreturn]] void becomeMpv(const ShowJob& job, const std::vector<Source>& files,
                            const std::filesystem::path& shader, const std::string& screen);

/// Shows the test picture on the display until the user closes it, and says how to read it.
/// @throws UsageError, Error
int presentTestPicture(int& argc, char** argv, const ShowJob& job, tools::Messages& messages);

/// Requires a desktop to open windows on. @throws Error NotFound
void requireDesktop();

/// The screens of the application, in its order.
std::vector<qt::ScreenFacts> screenFacts();

/// A screen for a window that would open on a light-field display, where it cannot be read.
/// @param displays from qt::findDisplays()
/// @param own the window's screen @param count of screens
/// @return nothing if `own` is not of a display, or all are
std::optional<std::size_t> screenBeside(const std::vector<qt::FoundDisplay>& displays,
                                        std::size_t own, std::size_t count);

/// The calibrations of volumes, wherever they are mounted, and of USB memories.
std::vector<MountedCalibration> calibrations();

/// The same, and a calibration without a volume, of another maker's screen.
std::vector<MountedCalibration> calibrationsAnd(const Calibration& given,
                                                const std::filesystem::path& file);

/// Prints the displays, screens and volumes found, for people or (JSON) for programs.
/// @param bridge address of Looking Glass Bridge; empty: one on this computer, if it runs
int listDisplays(int& argc, char** argv, bool json, const std::string& bridge,
                 tools::Messages& messages);

/// Reads the next of the 8-bit colour pictures (PPM, P6, without comments) that follow each other
/// in a file. It returns as soon as the last byte of the picture has arrived: FFmpeg waits for
/// bytes of the next one.
///
/// @param file a pipe, mostly
/// @param picture new memory [CV_8UC3, BGR]
/// @return false at the end of the file
/// @throws Error BadFormat (no such picture, a cut off one)
bool readPixmap(std::FILE& file, cv::Mat& picture);

/// A Native by which the eye tells faults of a display apart.
///
/// The views are red on the left, green in the middle and blue on the right; one fifth of them is
/// green. Up to 16 views show their numbers. A strip of panel px, the same for all
/// views, has a square of lines of 1 px beside a square of the grey that is as bright as their mean
/// (188), and steps of grey. A line of 1 px runs along all four edges.
/// @param display its calibration, quilt and order of views
/// @return [panel, CV_8UC3, BGR]
/// @throws Error as of NativeLut and TooLarge
cv::Mat makeTestPicture(const Display& display);

/// The squares of the strip, px of the panel.
struct TestPictureParts {
    cv::Rect lines;
    cv::Rect grey;
    cv::Rect steps; ///< Eight steps from black to white.
};
TestPictureParts testPictureParts(cv::Size panel);

/// How to read it, a sentence each.
std::vector<std::string> testPictureAdvice();

} // namespace altiro3D::viewer
