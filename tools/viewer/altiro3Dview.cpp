// altiro3Dview: view light-field pictures, change their settings, show them on the display.

#include "altiro3D/display.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/qt/display_search.hpp"
#include "cli/bridge.hpp"
#include "cli/display_options.hpp"
#include "cli/eyes_options.hpp"
#include "cli/quilt_options.hpp"
#include "cli/run_tool.hpp"
#include "viewer/model/depth_maker.hpp"
#include "viewer/show/presentation.hpp"
#include "viewer/window/main_window.hpp"
#include "viewer/window/window_words.hpp"

#include <QApplication>
#include <QScreen>
#include <chrono>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

using namespace altiro3D;
using namespace altiro3D::tools;
using namespace altiro3D::viewer;

namespace {

// Qt ends the process with its own message if it cannot connect to the desktop.
void onQtMessage(QtMsgType type, const QMessageLogContext& /*context*/, const QString& text) {
    if (type == QtFatalMsg) {
        std::fprintf(stderr, "altiro3Dview: error: no desktop: %s\n",
                     text.simplified().toUtf8().constData());
        std::_Exit(kExitFailed);
    }
    if (type == QtCriticalMsg) std::fprintf(stderr, "%s\n", text.toUtf8().constData());
}

// Refuses options that would otherwise be ignored.
void requireUsage(const CommandLine& commandLine) {
    commandLine.exclude("show", "list-displays");
    commandLine.exclude("test-picture", {"show", "list-displays"});
    for (const char* option : {"d", "m", "q", "r"})
        commandLine.exclude(option, {"show", "list-displays", "test-picture"});
    commandLine.exclude("invert", {"show", "list-displays"});
    if (!commandLine.has("test-picture"))
        commandLine.refuseWithout("show", {"screen"},
                                  " applies to --show and --test-picture, expected one of them");
    if (!commandLine.has("list-displays"))
        commandLine.refuseWithout("show", {"bridge"},
                                  " applies to --show and --list-displays, expected one of them");
    commandLine.refuseWithout(
        "show", {"each", "shuffle", "loop", "player", "view-from", "stereo-layout", "stereo-swap"},
        " applies to --show, expected both");
    commandLine.refuseWithout("list-displays", {"json"},
                              " applies to --list-displays, expected --list-displays with it");
    if (!commandLine.files().empty())
        commandLine.refuse({"list-displays", "test-picture"},
                           " takes no names, got " + commandLine.files().front().string());
    if (commandLine.has("d") && commandLine.files().size() != 2)
        throw UsageError("-d takes PHOTO DEPTH; see altiro3Dview --help");
}

// The display's name for people; empty if none was found.
QString nameOf(const ChosenDisplay& display) {
    if (display.isSample) return {};
    const DisplayModel* const model = findDisplayModel(display.calibration);
    const std::string serial = display.calibration.serial;
    const std::string name = model != nullptr ? model->name : std::string("light-field display");
    return QString::fromStdString(serial.empty() ? name : name + ", " + serial);
}

// Moves a window from the display, where it cannot be read, to another screen.
void leaveDisplay(QWidget& window) {
    const QList<QScreen*> all = QGuiApplication::screens();
    const int own = all.indexOf(window.screen());
    if (own < 0 || all.size() < 2) return;
    const auto displays = qt::findDisplays(screenFacts(), calibrations());
    if (const auto other = screenBeside(displays, static_cast<std::size_t>(own),
                                        static_cast<std::size_t>(all.size())))
        window.move(all[static_cast<int>(*other)]->availableGeometry().topLeft());
}

// @param job files to open @param isPair a photo and its depth image
int runWindow(int& argc, char** argv, const ShowJob& job, const QuiltRequest& layout, bool isPair,
              Messages& messages) {
    requireDesktop();
    // calibrations() also finds volumes that are mounted elsewhere. If there are several displays,
    // the first one is taken, as the user can choose another one in the window.
    ChosenDisplay display = findDisplay(job.display, messages, {calibrations, true, true});
    if (display.isMapOnly) throw UsageError("a map is not enough, expected the calibration -c");
    display.quilt = chooseQuilt(layout, display, messages);
    QApplication application(argc, argv);
    std::setlocale(LC_NUMERIC, "C"); // Qt takes the user's; numbers in files have a point
    QApplication::setOrganizationName("altiro3D");
    QApplication::setApplicationName("altiro3Dview");
    QApplication::setDesktopFileName("altiro3Dview");
    MainWindow window(display, messages.warnings());
    messages.dropWarnings(); // the window shows them
    window.model().files.setPlaySettings(job.play);
    if (messages.verbose()) detailSilence(messages);
    leaveDisplay(window);
    window.show();
    const std::vector<std::filesystem::path>& files = job.files;
    if (files.empty()) window.welcome(nameOf(display));
    if (isPair) {
        window.model().files.open(std::vector<Source>{Source{files[0], files[1], Reading::Photo}});
    } else {
        window.model().files.open(files);
    }
    const int status = QApplication::exec();
    // a file may never be read to its end, as on a server that has gone; exports end cleanly
    if (!window.model().exports.areRunning()) {
        std::thread([status] {
            std::this_thread::sleep_for(std::chrono::milliseconds(700));
            std::_Exit(status);
        }).detach();
    }
    return status;
}

} // namespace

int main(int argc, char** argv) {
    if (argc == 3 && std::strcmp(argv[1], kTryNetwork) == 0) return tryNetwork(argv[2]);
    qInstallMessageHandler(onQtMessage);
    CommandLine commandLine("altiro3Dview",
                            "Shows photos, videos, quilts and Natives as they will look on a "
                            "light-field display, with or without one, and lets you change their "
                            "settings.");
    commandLine.addUsage("[options] [FILE...]");
    commandLine.addUsage("[options] -d PHOTO DEPTH");
    commandLine.addUsage("[options] --show FILE|FOLDER...");
    commandLine.addUsage("[options] --test-picture");
    commandLine.addUsage("--list-displays [--json]");
    commandLine.addSection("What to do");
    commandLine.add({"d", "depthmode"}, "Open a photo with its depth image.");
    commandLine.add(
        {"show"},
        "Show photos, quilts, Natives and their videos full screen on the light-field "
        "display, one after the other; Escape ends it. New files in a folder are also shown. "
        "With -: PPM pictures from standard input, each as soon as it arrives.",
        "FILE");
    commandLine.add({"each"}, "With --show: show each picture for S seconds (default 20).", "S");
    commandLine.add({"shuffle"}, "With --show: in random order.");
    commandLine.add({"loop"}, "With --show: begin again after the last file.");
    commandLine.add({"volume"}, "Volume of videos, 0..100 % (default 100).", "PERCENT");
    commandLine.add({"mute"}, "Play videos without sound.");
    commandLine.addAdvanced(
        {"screen"},
        "Screen for --show and --test-picture, by its name or number, instead of the display's "
        "own.",
        "NAME");
    commandLine.addAdvanced({"player"},
                            "With --show: the program that plays. mpv plays quilts and videos of "
                            "quilts, whose names state their layout, on the graphics card.",
                            "viewer|mpv");
    commandLine.addAdvanced(
        {"view-from"},
        "With --show, for screens that follow one viewer: show what two eyes see from the "
        "viewer's position. Another program sends it, one line of text at a time: x, or x and y (y "
        "is not used). As the viewer sees it, x is -1 at the left edge of the view cone, 0 in the "
        "middle and 1 at the right edge. A port accepts programs on this computer only.",
        "udp:PORT|stdin");
    addEyesOptions(commandLine, "show", false, false);
    addBridgeOptions(commandLine,
                     "With --show: show quilts and RGB-D files, whose names state what they are, "
                     "by; with --list-displays: also list the displays of");
    commandLine.add({"test-picture"},
                    "Show a picture on the display that distinguishes faults of the calibration, "
                    "the screen and its colours, and print how to read it.");
    commandLine.add({"list-displays"}, "List the displays, screens and volumes found.");
    commandLine.addAdvanced({"json"}, "With --list-displays: write JSON, for programs.");
    addDisplayOptions(commandLine);
    commandLine.addNote("A photo and its depth image, a.jpg and a-depth.png, are opened as one. "
                        "FILE may be a folder: views of one scene are opened as a quilt, other "
                        "files each on its own.");
    commandLine.addNote("Photos and depth images may be " + readableFormats() + ".");
    commandLine.addExample("holiday.jpg", "Open a photo.");
    commandLine.addExample("-d holiday.jpg painted.png", "Open a photo with its depth.");
    commandLine.addExample("--show native.png", "Show a Native on the display.");
    commandLine.addExample("--show holiday --shuffle --loop",
                           "Show all pictures of a folder, for as long as it runs.");
    commandLine.addExample("--list-displays", "List the displays found and the problems of each.");
    for (const KeyWords& key : kKeys)
        commandLine.addTerm(CommandLine::Chapter::Keys, key.keys, key.text);
    for (const char* variable : {"DISPLAY", "WAYLAND_DISPLAY"}) {
        commandLine.addTerm(CommandLine::Chapter::Environment, variable,
                            "The desktop on which the window opens.");
    }
    return runBody(argc, argv, commandLine, [&](const CommandLine& given, Messages& messages) {
        requireUsage(given);
        if (given.has("list-displays"))
            return listDisplays(argc, argv, given.has("json"), given.value("bridge").value_or(""),
                                messages);
        const ShowJob job = showJob(given);
        if (given.has("show")) return present(argc, argv, job, messages);
        if (given.has("test-picture")) return presentTestPicture(argc, argv, job, messages);
        return runWindow(argc, argv, job, quiltRequest(given), given.has("d"), messages);
    });
}
