#include "viewer/show/presentation.hpp"

#include "altiro3D/altiro3D.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/qt/native_widget.hpp"
#include "cli/folders.hpp"
#include "viewer/model/worker.hpp"
#include "viewer/show/slide_presenter.hpp"

#include <QApplication>
#include <QGuiApplication>
#include <QScreen>
#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <clocale>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <stdexcept>
#include <thread>

namespace altiro3D::viewer {

namespace {

// The known properties of a screen: "HDMI-1, LKG-P00655, 1536 x 2048 px".
std::string textOf(const qt::ScreenFacts& screen) {
    std::string text;
    if (!screen.name.empty()) text += screen.name + ", ";
    if (!screen.model.empty() && screen.model != screen.name) text += screen.model + ", ";
    text += sizeText(screen.size);
    if (std::abs(screen.scale - 1) > 1e-3)
        text += ", scaled to " + std::to_string(std::lround(screen.scale * 100)) + " %";
    return text;
}

// --screen: by number as --list-displays counts, or by any of its names.
std::size_t namedScreen(const std::string& wanted, const std::vector<qt::ScreenFacts>& screens) {
    std::string list;
    for (std::size_t i = 0; i < screens.size(); ++i) {
        const qt::ScreenFacts& screen = screens[i];
        if (wanted == std::to_string(i) || wanted == screen.name || wanted == screen.model ||
            wanted == screen.serialNumber) {
            return i;
        }
        list += (i == 0 ? "" : ", ") + std::to_string(i) + " (" + textOf(screen) + ")";
    }
    throw tools::UsageError("--screen is " + wanted + ", expected one of " + list);
}

// The screen for a Native: that of --screen, of --serial, or of the display that it is for.
std::size_t chooseScreen(const ShowJob& job, const std::vector<qt::ScreenFacts>& screens,
                         cv::Size native, tools::Messages& messages) {
    if (!job.screen.empty()) return namedScreen(job.screen, screens);
    if (job.eyes && screens.size() == 1) return 0; // any screen can show them
    std::optional<Calibration> given;
    std::filesystem::path file;
    if (!job.display.calibration.empty()) {
        file = tools::calibrationFile(job.display.calibration);
        given = readCalibration(file);
    }
    const std::vector<qt::FoundDisplay> displays =
        qt::findDisplays(screens, given ? calibrationsAnd(*given, file) : calibrations());
    std::optional<std::size_t> chosen;
    if (const std::string& serial = job.display.serial; !serial.empty()) {
        for (std::size_t i = 0; i < displays.size(); ++i) {
            const qt::FoundDisplay& found = displays[i];
            if (found.screen && (found.name == serial || found.volume == serial ||
                                 (found.calibration && found.calibration->serial == serial)))
                chosen = i;
        }
    } else {
        chosen = qt::chooseDisplay(displays, screens, given, native);
    }
    if (!chosen) {
        std::string found;
        for (const qt::FoundDisplay& display : displays) {
            found += (found.empty() ? "" : "; ") + display.name;
            for (const std::string& problem : display.problems)
                found += ": " + problem;
        }
        throw Error(ErrorCode::NotFound, "display",
                    (found.empty() ? "no light-field display was found"
                                   : "none could be chosen (" + found + ")") +
                        ", expected one that is connected, or --serial or --screen to choose "
                        "(--list-displays shows them)");
    }
    messages.warn(displays[*chosen].problems);
    messages.detail("display: " + displays[*chosen].name);
    return *displays[*chosen].screen;
}

// The screen of the display that a run shows its pictures on.
// @param requiresSize refuses a picture that does not fit the screen px by px
QScreen& screenFor(const ShowJob& job, const std::string& what, cv::Size native, bool requiresSize,
                   tools::Messages& messages) {
    const std::vector<qt::ScreenFacts> screens = screenFacts();
    const std::size_t screen = chooseScreen(job, screens, native, messages);
    if (requiresSize && !qt::hasSize(screens[screen], native))
        throw Error(ErrorCode::Mismatch, what,
                    "has " + sizeText(native) + ", but the screen shows " +
                        sizeText(screens[screen].size) +
                        "; expected the display's own resolution and a Native made for it");
    messages.detail("screen " + std::to_string(screen) + ": " + textOf(screens[screen]));
    return *QGuiApplication::screens()[static_cast<int>(screen)];
}

int presentStream(int& argc, char** argv, const ShowJob& job, tools::Messages& messages) {
    cv::Mat first;
    if (!readPixmap(*stdin, first))
        throw Error(ErrorCode::BadFormat, "standard input",
                    "is empty, expected pictures (PPM of 8 bits, P6)");
    requireDesktop();
    const QApplication application(argc, argv);
    QApplication::setQuitOnLastWindowClosed(false); // an unplugged display has no window
    qt::NativeWidget widget;
    QObject::connect(&widget, &qt::NativeWidget::left, &QApplication::quit);
    widget.setNative(first);
    widget.showOn(screenFor(job, "-", first.size(), true, messages));
    messages.flushWarnings();
    Arrivals arrivals;
    QObject::connect(
        &arrivals, &Arrivals::arrived, &widget,
        [&] {
            widget.setNative(arrivals.take());
            widget.repaint();
        },
        Qt::QueuedConnection);
    QObject::connect(&arrivals, &Arrivals::ended, &widget, &QApplication::quit,
                     Qt::QueuedConnection);
    std::atomic<bool> ending{false};
    std::thread reader([&] { // the writer sets the pace
        try {
            for (cv::Mat picture; !ending && readPixmap(*stdin, picture);)
                while (!arrivals.put(picture) && !ending)
                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
        } catch (const std::exception&) { // the writer has ended in the middle of a picture
        }
        emit arrivals.ended();
    });
    const int status = QApplication::exec();
    ending = true;
    reader.join();
    return status;
}

int presentByMpv(int& argc, char** argv, const ShowJob& job, tools::Messages& messages) {
    const ShowFiles files(job.files);
    messages.warn(files.notes());
    requireDesktop();
    std::filesystem::path shader;
    std::string screen;
    {
        const QGuiApplication application(argc, argv);
        std::setlocale(LC_NUMERIC, "C"); // Qt takes the user's
        const tools::ChosenDisplay display =
            tools::findDisplay(job.display, messages, {[] { return qt::findVolumes(); }, true});
        if (display.isSample)
            throw Error(ErrorCode::NotFound, "calibration",
                        "none was given or found, expected the display's with -c visual.json");
        shader = writeMpvShader(display, files.files(), messages);
        screen = screenFor(job, display.source, display.panelSize(), true, messages)
                     .name()
                     .toStdString();
    }
    messages.flushWarnings();
    becomeMpv(job, files.files(), shader, screen);
}

int presentByBridge(const ShowJob& job, tools::Messages& messages) {
    const ShowFiles files(job.files);
    messages.warn(files.notes());
    const tools::ChosenDisplay display =
        tools::findDisplay(job.display, messages, {}, tools::DisplayUse::Quilt);
    std::vector<tools::BridgeEntry> entries;
    for (const Source& source : files.files()) {
        entries.push_back(tools::bridgeEntry(source.file, display.aspect()));
        if (!tools::isVideoFileName(source.file)) entries.back().seconds = job.slides.each;
    }
    messages.flushWarnings();
    tools::BridgeJob bridge = *job.bridge;
    bridge.loops = bridge.loops || entries.size() == 1;
    tools::showOnBridge(bridge, entries, messages);
    return tools::kExitDone;
}

int presentFiles(int& argc, char** argv, const ShowJob& job, tools::Messages& messages) {
    ShowFiles files(job.files);
    messages.warn(files.notes());
    const bool isSingle = files.files().size() == 1 && files.folders().empty();
    SlideShow::Settings settings = job.slides;
    settings.loops = settings.loops || isSingle;
    requireDesktop();
    const QApplication application(argc, argv);
    std::setlocale(LC_NUMERIC, "C");                // Qt takes the user's
    QApplication::setQuitOnLastWindowClosed(false); // an unplugged display has no window
    const tools::ChosenDisplay found =
        tools::findDisplay(job.display, messages, {calibrations, true}, tools::DisplayUse::None);
    const bool hasLens = !found.isSample && !job.eyes;
    if (job.viewFrom && !job.eyes && !hasLens)
        throw Error(ErrorCode::NotFound, "calibration",
                    "none was given or found, expected the display's with -c, or --stereo-layout");
    QScreen& screen =
        screenFor(job, found.files.empty() ? "calibration" : found.files.front().string(),
                  hasLens ? found.panelSize() : cv::Size(), hasLens, messages);
    messages.flushWarnings();
    std::optional<Request> eyes;
    if (job.eyes || job.viewFrom) {
        eyes.emplace().mode = Mode::Stereo;
        eyes->eyes = job.eyes.value_or(tools::EyesOptions());
        eyes->throughLens = !job.eyes;
        eyes->fills = eyes->follows = true;
    }
    std::string problem;
    SlidePresenter presenter(
        settings, files, hasLens || eyes ? std::make_shared<const Display>(found) : nullptr,
        qt::factsOf(screen),
        [&](const std::string& why) {
            problem = why;
            if (isSingle) return;
            messages.warn(why);
            messages.flushWarnings();
        },
        eyes);
    std::unique_ptr<EyeSource> source;
    if (job.viewFrom) {
        source = std::make_unique<EyeSource>(*job.viewFrom);
        QObject::connect(source.get(), &EyeSource::moved, &presenter, &SlidePresenter::moveEyes);
    }
    QObject::connect(&presenter, &SlidePresenter::ended, &application, &QApplication::quit,
                     Qt::QueuedConnection);
    if (messages.verbose()) detailSilence(messages);
    presenter.setPlaySettings(job.play);
    presenter.start(screen);
    const int status = QApplication::exec();
    if (source && source->ignoredLines() > 0) {
        messages.warn("--view-from: " + tools::counted(source->ignoredLines(), "line") +
                      " ignored, expected x, or x and y, in each");
        messages.flushWarnings();
    }
    const VideoPlayer::Counts counts = presenter.counts();
    if (counts.shown + counts.dropped > 0) {
        messages.detail(std::to_string(counts.shown) + " pictures of videos shown, " +
                        std::to_string(counts.dropped) + " dropped");
    }
    if (presenter.show().hasShown() || problem.empty()) return status;
    if (isSingle) throw std::runtime_error(problem);
    throw Error(ErrorCode::NotFound, job.files.front().string(),
                "holds nothing that can be shown, expected photos, quilts or Natives");
}

std::string panelText(const Calibration& calibration) {
    return ", panel " + sizeText({calibration.screenW, calibration.screenH});
}

using Json = nlohmann::ordered_json;

std::string pairedByText(qt::PairedBy by) {
    if (by == qt::PairedBy::Serial) return "serial";
    return by == qt::PairedBy::Size ? "size" : "nothing";
}

void addPanel(Json& entry, const Calibration& calibration) {
    entry["serial"] = calibration.serial;
    entry["panelWidth"] = calibration.screenW;
    entry["panelHeight"] = calibration.screenH;
}

Json jsonOf(const std::vector<qt::FoundDisplay>& displays,
            const std::vector<qt::ScreenFacts>& screens) {
    Json json = {{"displays", Json::array()}, {"screens", Json::array()}};
    for (const qt::FoundDisplay& display : displays) {
        Json entry = {{"name", display.name},
                      {"screen", nullptr},
                      {"volume", display.volume},
                      {"calibrationFile", display.calibrationFile.string()},
                      {"pairedBy", pairedByText(display.pairedBy)},
                      {"problems", display.problems}};
        if (display.screen) entry["screen"] = *display.screen;
        if (display.calibration) addPanel(entry, *display.calibration);
        json["displays"].push_back(std::move(entry));
    }
    for (const qt::ScreenFacts& screen : screens) {
        json["screens"].push_back({{"name", screen.name},
                                   {"model", screen.model},
                                   {"serialNumber", screen.serialNumber},
                                   {"width", screen.size.width},
                                   {"height", screen.size.height},
                                   {"scale", screen.scale},
                                   {"refreshHz", screen.refreshHz}});
    }
    return json;
}

[[noreturn]] void fail() {
    throw Error(ErrorCode::BadFormat, "standard input",
                "holds something else, expected whole pictures (PPM of 8 bits, P6)");
}

// A number of the head and the character after it.
int readNumber(std::FILE& file) {
    constexpr int kMaxSide = 16384;
    int next = std::fgetc(&file);
    while (std::isspace(next) != 0)
        next = std::fgetc(&file);
    int number = 0;
    for (; std::isdigit(next) != 0 && number <= kMaxSide; next = std::fgetc(&file))
        number = 10 * number + next - '0';
    if (number < 1 || number > kMaxSide || std::isspace(next) == 0) fail();
    return number;
}

} // namespace

void requireDesktop() {
    if (tools::hasDesktop()) return;
    throw Error(ErrorCode::NotFound, "desktop", "not found, expected $DISPLAY or $WAYLAND_DISPLAY");
}

ShowJob showJob(const tools::CommandLine& commandLine) {
    ShowJob job;
    if (const auto show = commandLine.value("show")) job.files.emplace_back(*show);
    if (!job.files.empty() && job.files.front() == "-" && !commandLine.files().empty())
        throw tools::UsageError("--show - takes no further names");
    job.files.insert(job.files.end(), commandLine.files().begin(), commandLine.files().end());
    job.display = tools::displayOptions(commandLine);
    job.screen = commandLine.value("screen").value_or("");
    job.slides.each = commandLine.number("each", 0.1, 1e6).value_or(job.slides.each);
    job.slides.loops = commandLine.has("loop");
    job.slides.shuffles = commandLine.has("shuffle");
    job.slides.seed = std::random_device()();
    if (const auto volume = commandLine.number("volume", 0, 100))
        job.play.volume = static_cast<int>(std::lround(*volume));
    job.play.muted = commandLine.has("mute");
    job.bridge = tools::bridgeJob(commandLine);
    if (job.bridge) {
        job.bridge->loops = job.slides.loops;
        commandLine.exclude("bridge", {"shuffle", "screen", "player", "volume", "mute"});
    }
    job.byMpv =
        commandLine.oneOf<bool>("player", {{"viewer", false}, {"mpv", true}}).value_or(false);
    if (commandLine.has("stereo-layout") || commandLine.has("stereo-swap"))
        job.eyes = tools::eyesOptions(commandLine, "show");
    if (const auto from = commandLine.value("view-from")) job.viewFrom = eyePort(*from);
    const bool isStream = !job.files.empty() && job.files.front() == "-";
    if (job.byMpv || job.bridge || isStream)
        commandLine.refuse({"view-from", "stereo-layout", "stereo-swap"},
                           " needs the viewer and files, expected no --player mpv, --bridge or -");
    if ((job.byMpv || job.bridge) && isStream)
        throw tools::UsageError((job.byMpv ? "--player mpv" : "--bridge") +
                                std::string(" plays files, expected names instead of -"));
    return job;
}

void detailSilence(tools::Messages& messages) {
    if (const std::string why = soundProblem(); !why.empty())
        messages.detail("videos are shown without sound: " + why);
}

int present(int& argc, char** argv, const ShowJob& job, tools::Messages& messages) {
    if (job.files.front() == "-") return presentStream(argc, argv, job, messages);
    if (job.bridge) return presentByBridge(job, messages);
    return (job.byMpv ? presentByMpv : presentFiles)(argc, argv, job, messages);
}

int presentTestPicture(int& argc, char** argv, const ShowJob& job, tools::Messages& messages) {
    requireDesktop();
    const QApplication application(argc, argv);
    QApplication::setQuitOnLastWindowClosed(false); // an unplugged display has no window
    std::setlocale(LC_NUMERIC, "C");                // Qt takes the user's
    const tools::ChosenDisplay display =
        tools::findDisplay(job.display, messages, {calibrations, true});
    if (display.isMapOnly)
        throw tools::UsageError("a map is not enough, expected the calibration -c");
    qt::NativeWidget widget;
    QObject::connect(&widget, &qt::NativeWidget::left, &QApplication::quit);
    widget.setNative(makeTestPicture(display));
    widget.showOn(screenFor(job, display.isSample ? "calibration" : display.source,
                            display.panelSize(), true, messages));
    for (const std::string& sentence : testPictureAdvice())
        messages.say(sentence);
    messages.flushWarnings();
    return QApplication::exec();
}

std::vector<qt::ScreenFacts> screenFacts() {
    std::vector<qt::ScreenFacts> facts;
    for (const QScreen* screen : QGuiApplication::screens())
        facts.push_back(qt::factsOf(*screen));
    return facts;
}

std::optional<std::size_t> screenBeside(const std::vector<qt::FoundDisplay>& displays,
                                        std::size_t own, std::size_t count) {
    const auto isDisplay = [&displays](std::size_t screen) {
        return std::any_of(displays.begin(), displays.end(),
                           [screen](const auto& display) { return display.screen == screen; });
    };
    if (!isDisplay(own)) return std::nullopt;
    for (std::size_t screen = 0; screen < count; ++screen)
        if (!isDisplay(screen)) return screen;
    return std::nullopt;
}

std::vector<MountedCalibration> calibrations() {
    return tools::withUsbDisplays(qt::findVolumes());
}

std::vector<MountedCalibration> calibrationsAnd(const Calibration& given,
                                                const std::filesystem::path& file) {
    std::vector<MountedCalibration> all = calibrations();
    if (given.lens && !file.empty())
        all.push_back({file, given.serial.empty() ? file.stem().string() : given.serial});
    return all;
}

int listDisplays(int& argc, char** argv, bool json, const std::string& bridge,
                 tools::Messages& messages) {
    std::unique_ptr<QGuiApplication> application;
    std::vector<qt::ScreenFacts> screens;
    if (tools::hasDesktop()) {
        application = std::make_unique<QGuiApplication>(argc, argv);
        screens = screenFacts();
    } else {
        messages.warn("no desktop was found: screens are not known");
    }
    const std::vector<qt::FoundDisplay> displays = qt::findDisplays(screens, calibrations());
    std::vector<tools::BridgeDevice> ofBridge;
    try {
        ofBridge = tools::devicesOfBridge(bridge.empty() ? "auto" : bridge);
    } catch (const Error& error) {
        if (!bridge.empty()) throw;
        messages.detail(error.what()); // none runs, mostly
    }
    const std::string bridgeName = tools::bridgeName(bridge.empty() ? "auto" : bridge);
    if (json) {
        Json list = jsonOf(displays, screens);
        for (const tools::BridgeDevice& device : ofBridge) {
            Json entry = {
                {"name", device.name}, {"bridge", bridgeName}, {"problems", Json::array()}};
            if (device.problem.empty())
                addPanel(entry, device.calibration);
            else
                entry["problems"].push_back(device.problem);
            list["displays"].push_back(std::move(entry));
        }
        messages.print(list.dump(2, ' ', false, Json::error_handler_t::replace));
        return tools::kExitDone;
    }
    for (const qt::FoundDisplay& display : displays) {
        std::string line = "display " + display.name;
        if (display.screen) line += ", screen " + std::to_string(*display.screen);
        if (display.calibration) line += panelText(*display.calibration);
        if (!display.calibrationFile.empty()) line += ", " + display.calibrationFile.string();
        messages.say(line);
        for (const std::string& problem : display.problems)
            messages.say("  " + problem);
    }
    for (const tools::BridgeDevice& device : ofBridge) {
        const bool isGood = device.problem.empty();
        messages.say("display " + device.name + ", " + bridgeName +
                     (isGood ? panelText(device.calibration) : ""));
        if (!isGood) messages.say("  " + device.problem);
    }
    if (displays.empty() && ofBridge.empty()) messages.say("no light-field display was found");
    for (std::size_t i = 0; i < screens.size(); ++i)
        messages.say("screen " + std::to_string(i) + ": " + textOf(screens[i]));
    return tools::kExitDone;
}

bool readPixmap(std::FILE& file, cv::Mat& picture) {
    const int first = std::fgetc(&file);
    if (first == EOF) return false;
    if (first != 'P' || std::fgetc(&file) != '6') fail();
    const int width = readNumber(file);
    const int height = readNumber(file);
    if (readNumber(file) != 255) fail();
    picture = cv::Mat(height, width, CV_8UC3);
    const std::size_t bytes = picture.total() * picture.elemSize();
    if (std::fread(picture.data, 1, bytes, &file) != bytes) fail();
    cv::cvtColor(picture, picture, cv::COLOR_RGB2BGR);
    return true;
}

} // namespace altiro3D::viewer
