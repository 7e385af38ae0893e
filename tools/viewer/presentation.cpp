#include "viewer/presentation.hpp"

#include "altiro3D/altiro3D.hpp"
#include "altiro3D/qt/display_search.hpp"
#include "altiro3D/qt/native_widget.hpp"
#include "common/display_options.hpp"
#include "common/picture_options.hpp"
#include "viewer/display_list.hpp"
#include "viewer/document.hpp"
#include "viewer/video_player.hpp"

#include <QApplication>
#include <QScreen>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
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
std::size_t chooseScreen(const tools::CommandLine& commandLine,
                         const std::vector<qt::ScreenFacts>& screens, cv::Size native,
                         tools::Messages& messages) {
    if (const auto wanted = commandLine.value("screen")) return namedScreen(*wanted, screens);
    const std::vector<qt::FoundDisplay> displays = qt::findDisplays(screens, qt::findVolumes());
    std::optional<std::size_t> chosen;
    if (const auto serial = commandLine.value("serial")) {
        for (std::size_t i = 0; i < displays.size(); ++i) {
            const bool named =
                displays[i].name == *serial || displays[i].volume == *serial ||
                (displays[i].calibration && displays[i].calibration->serial == *serial);
            if (named && displays[i].screen) chosen = i;
        }
    } else {
        std::optional<Calibration> calibration;
        if (const auto file = commandLine.value("c"))
            calibration = readCalibration(tools::calibrationFile(*file));
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

// Pictures of a video on their way from the player's thread to the widget, one at a time.
class Arrivals : public QObject {
    Q_OBJECT
  public:
    // False while the one before has not been shown.
    bool put(const cv::Mat& picture) {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            if (!next_.empty()) return false;
            next_ = picture;
        }
        emit pictureArrived();
        return true;
    }
    void showNext(qt::NativeWidget& widget) {
        cv::Mat picture;
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            std::swap(picture, next_);
        }
        widget.setNative(picture);
        widget.repaint();
    }

  signals:
    void pictureArrived();
    void failed();

  private:
    std::mutex mutex_;
    cv::Mat next_;
};

// Delivers the pictures of a stream on standard input as they arrive; the writer sets the pace.
class PictureStream {
  public:
    PictureStream() : reader_("-", options()) {
        if (const auto first = reader_.next()) first_ = first->picture;
    }
    ~PictureStream() {
        ending_ = true;
        if (thread_.joinable()) thread_.join();
    }
    PictureStream(const PictureStream&) = delete;
    PictureStream& operator=(const PictureStream&) = delete;

    const cv::Mat& first() const { return first_; }
    // Both functions are called by a thread of the stream's own.
    void start(const std::function<bool(const cv::Mat&)>& show, const std::function<void()>& end) {
        thread_ = std::thread([this, show, end] {
            try {
                for (VideoFrame frame; !ending_ && reader_.read(frame); frame.picture = cv::Mat()) {
                    while (!show(frame.picture) && !ending_)
                        std::this_thread::sleep_for(std::chrono::milliseconds(1));
                }
            } catch (const std::exception&) { // the writer has ended in the middle of a picture
            }
            end();
        });
    }

  private:
    static VideoReaderOptions options() {
        VideoReaderOptions options;
        options.format = "ppm_pipe";
        options.threads = 1; // more would hold pictures back
        return options;
    }

    VideoReader reader_;
    cv::Mat first_;
    std::atomic<bool> ending_{false};
    std::thread thread_;
};

} // namespace

int present(int& argc, char** argv, const tools::CommandLine& commandLine,
            tools::Messages& messages) {
    const std::filesystem::path file = *commandLine.value("show");
    if (!commandLine.files().empty())
        throw tools::UsageError("--show takes one Native and no further names");
    const bool video = isVideoName(file);
    std::unique_ptr<PictureStream> stream;
    cv::Mat native;
    if (file == "-") {
        stream = std::make_unique<PictureStream>();
        native = stream->first();
    } else if (!video)
        native = tools::readPhotoFile(file, messages);
    else if (auto first = VideoReader(file).next())
        native = first->picture;
    if (!hasDesktop()) {
        throw Error(ErrorCode::NotFound, "desktop",
                    "not found, expected $DISPLAY or $WAYLAND_DISPLAY");
    }
    const QApplication application(argc, argv);
    const std::vector<qt::ScreenFacts> screens = screenFacts();
    const std::size_t screen = chooseScreen(commandLine, screens, native.size(), messages);
    if (screens[screen].size != native.size()) {
        throw Error(ErrorCode::Mismatch, file.string(),
                    "has " + tools::sizeText(native.size()) + ", but the screen shows " +
                        tools::sizeText(screens[screen].size) +
                        "; expected the display's own resolution and a Native made for it");
    }
    messages.detail("screen " + std::to_string(screen) + ": " + textOf(screens[screen]));
    qt::NativeWidget widget;
    QObject::connect(&widget, &qt::NativeWidget::left, &QApplication::quit);
    widget.setNative(native);
    widget.showOn(*QGuiApplication::screens()[static_cast<int>(screen)]);
    messages.flushWarnings();
    if (!video && !stream) return QApplication::exec();

    std::string problem;
    int status = tools::kExitDone;
    {
        Arrivals arrivals;
        QObject::connect(
            &arrivals, &Arrivals::pictureArrived, &widget, [&] { arrivals.showNext(widget); },
            Qt::QueuedConnection);
        QObject::connect(&arrivals, &Arrivals::failed, &widget, &QApplication::quit,
                         Qt::QueuedConnection);
        if (stream) {
            stream->start([&arrivals](const cv::Mat& picture) { return arrivals.put(picture); },
                          [&arrivals] { emit arrivals.failed(); });
            status = QApplication::exec();
            stream.reset();
            return status;
        }
        VideoPlayer player(
            file, [&arrivals](const cv::Mat& picture) { return arrivals.put(picture); },
            [&](const std::string& text) {
                problem = text;
                emit arrivals.failed();
            });
        status = QApplication::exec();
        const VideoPlayer::Counts counts = player.counts();
        messages.detail(std::to_string(counts.shown) + " pictures shown, " +
                        std::to_string(counts.dropped) + " dropped");
    }
    if (!problem.empty()) throw std::runtime_error(problem);
    return status;
}

} // namespace altiro3D::viewer

#include "presentation.moc"
