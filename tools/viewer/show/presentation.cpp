#include "viewer/show/presentation.hpp"

#include "altiro3D/altiro3D.hpp"
#include "altiro3D/qt/display_search.hpp"
#include "altiro3D/qt/native_widget.hpp"
#include "cli/display_options.hpp"
#include "viewer/model/arrivals.hpp"
#include "viewer/show/display_list.hpp"
#include "viewer/show/pixmap_stream.hpp"
#include "viewer/show/slide_presenter.hpp"
#include "viewer/show/test_picture.hpp"

#include <QApplication>
#include <QScreen>
#include <atomic>
#include <chrono>
#include <clocale>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <stdexcept>
#include <thread>

namespace altiro3D::viewer {

namespace {

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
    const std::vector<qt::FoundDisplay> displays = qt::findDisplays(screens, qt::findVolumes());
    std::optional<std::size_t> chosen;
    if (const std::string& serial = job.display.serial; !serial.empty()) {
        for (std::size_t i = 0; i < displays.size(); ++i) {
            const bool named =
                displays[i].name == serial || displays[i].volume == serial ||
                (displays[i].calibration && displays[i].calibration->serial == serial);
            if (named && displays[i].screen) chosen = i;
        }
    } else {
        std::optional<Calibration> calibration;
        if (!job.display.calibration.empty())
            calibration = readCalibration(tools::calibrationFile(job.display.calibration));
        chosen = qt::chooseDisplay(displays, screens, calibration, native);
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

void requireDesktop() {
    if (hasDesktop()) return;
    throw Error(ErrorCode::NotFound, "desktop", "not found, expected $DISPLAY or $WAYLAND_DISPLAY");
}

// Delivers the pictures of a stream on standard input as they arrive; the writer sets the pace.
class PictureStream {
  public:
    PictureStream() {
        if (!readPixmap(*stdin, first_))
            throw Error(ErrorCode::BadFormat, "standard input",
                        "is empty, expected pictures (PPM of 8 bits, P6)");
    }
    ~PictureStream() { end(); }
    PictureStream(const PictureStream&) = delete;
    PictureStream& operator=(const PictureStream&) = delete;

    const cv::Mat& first() const { return first_; }
    void end() {
        ending_ = true;
        if (thread_.joinable()) thread_.join();
    }
    // Both functions are called by a thread of the stream's own.
    void start(const std::function<bool(const cv::Mat&)>& show, const std::function<void()>& end) {
        thread_ = std::thread([this, show, end] {
            try {
                for (cv::Mat picture; !ending_ && readPixmap(*stdin, picture);) {
                    while (!show(picture) && !ending_)
                        std::this_thread::sleep_for(std::chrono::milliseconds(1));
                }
            } catch (const std::exception&) { // the writer has ended in the middle of a picture
            }
            end();
        });
    }

  private:
    cv::Mat first_;
    std::atomic<bool> ending_{false};
    std::thread thread_;
};

// Refuses a picture that does not fit the screen px by px.
void requireSize(const std::string& what, cv::Size size, const qt::ScreenFacts& screen) {
    if (screen.size == size) return;
    throw Error(ErrorCode::Mismatch, what,
                "has " + tools::sizeText(size) + ", but the screen shows " +
                    tools::sizeText(screen.size) +
                    "; expected the display's own resolution and a Native made for it");
}

// The screen of the display that a run shows its pictures on.
QScreen& screenFor(const ShowJob& job, const std::string& what, cv::Size native, bool requiresSize,
                   tools::Messages& messages) {
    const std::vector<qt::ScreenFacts> screens = screenFacts();
    const std::size_t screen = chooseScreen(job, screens, native, messages);
    if (requiresSize) requireSize(what, native, screens[screen]);
    messages.detail("screen " + std::to_string(screen) + ": " + textOf(screens[screen]));
    return *QGuiApplication::screens()[static_cast<int>(screen)];
}

int presentStream(int& argc, char** argv, const ShowJob& job, tools::Messages& messages) {
    PictureStream stream;
    requireDesktop();
    const QApplication application(argc, argv);
    qt::NativeWidget widget;
    QObject::connect(&widget, &qt::NativeWidget::left, &QApplication::quit);
    widget.setNative(stream.first());
    widget.showOn(screenFor(job, "-", stream.first().size(), true, messages));
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
    stream.start([&arrivals](const cv::Mat& picture) { return arrivals.put(picture); },
                 [&arrivals] { emit arrivals.ended(); });
    const int status = QApplication::exec();
    stream.end();
    return status;
}

int presentFiles(int& argc, char** argv, const ShowJob& job, tools::Messages& messages) {
    ShowFiles files(job.files);
    for (const Note& note : files.notes())
        messages.warn(note.text);
    const bool isSingle = files.files().size() == 1 && files.folders().empty();
    SlideShow::Settings settings = job.slides;
    settings.loops = settings.loops || isSingle;
    requireDesktop();
    const QApplication application(argc, argv);
    std::setlocale(LC_NUMERIC, "C");                // Qt takes the user's
    QApplication::setQuitOnLastWindowClosed(false); // an unplugged display has no window
    const tools::ChosenDisplay found = tools::findDisplay(
        job.display, messages, {[] { return qt::findVolumes(); }, true}, tools::DisplayUse::None);
    QScreen& screen =
        screenFor(job, found.files.empty() ? "calibration" : found.files.front().string(),
                  found.isSample ? cv::Size() : found.panelSize(), !found.isSample, messages);
    messages.flushWarnings();
    std::string problem;
    SlidePresenter presenter(settings, files,
                             found.isSample ? nullptr : std::make_shared<const Display>(found),
                             qt::factsOf(screen).size, [&](const std::string& why) {
                                 problem = why;
                                 if (isSingle) return;
                                 messages.warn(why);
                                 messages.flushWarnings();
                             });
    QObject::connect(&presenter, &SlidePresenter::ended, &application, &QApplication::quit,
                     Qt::QueuedConnection);
    if (messages.verbose()) detailSilence(messages);
    presenter.setPlaySettings(job.play);
    presenter.start(screen);
    const int status = QApplication::exec();
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

} // namespace

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
    return job;
}

void detailSilence(tools::Messages& messages) {
    if (const std::string why = soundProblem(); !why.empty())
        messages.detail("videos are shown without sound: " + why);
}

int present(int& argc, char** argv, const ShowJob& job, tools::Messages& messages) {
    const bool isStream = job.files.front() == "-";
    return (isStream ? presentStream : presentFiles)(argc, argv, job, messages);
}

int presentTestPicture(int& argc, char** argv, const ShowJob& job, tools::Messages& messages) {
    requireDesktop();
    const QApplication application(argc, argv);
    std::setlocale(LC_NUMERIC, "C"); // Qt takes the user's
    const tools::ChosenDisplay display =
        tools::findDisplay(job.display, messages, {[] { return qt::findVolumes(); }, true});
    if (display.isMapOnly)
        throw tools::UsageError("a map is not enough, expected the calibration -c");
    const cv::Mat native = makeTestPicture(display);
    qt::NativeWidget widget;
    QObject::connect(&widget, &qt::NativeWidget::left, &QApplication::quit);
    widget.setNative(native);
    widget.showOn(screenFor(job, display.isSample ? "calibration" : display.source, native.size(),
                            true, messages));
    for (const std::string& sentence : testPictureAdvice())
        messages.say(sentence);
    messages.flushWarnings();
    return QApplication::exec();
}

} // namespace altiro3D::viewer
