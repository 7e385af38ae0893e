#include "viewer/show/slide_presenter.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/products.hpp"
#include "altiro3D/video_io.hpp"
#include "cli/run_tool.hpp"
#include "viewer/model/depth_maker.hpp"

#include <QFile>
#include <QKeyEvent>
#include <QScreen>
#include <algorithm>
#include <utility>

namespace altiro3D::viewer {

namespace {

constexpr int kFadeTick = 15;  // ms
constexpr int kUsualTick = 50; // ms
constexpr int kSoon = 1000;    // ms after a change of a folder
constexpr int kRescan = 10000; // ms otherwise: folders on other machines do not tell of changes

// Makes Natives of the pictures of a flat or RGB-D video, with the window's settings; one thread at
// a time.
std::function<cv::Mat(const cv::Mat&, double)>
sceneConverter(Document first, const Display& display, const std::shared_ptr<DepthMaker>& maker) {
    const Knobs knobs;
    const NativeMaker toNative(display, layoutOf(knobs, display), knobs);
    const auto depth = std::make_shared<PlayedDepth>(maker);
    const DepthEdges edges = first.eyes               ? DepthEdges::Matched
                             : first.rawDepth.empty() ? DepthEdges::Aligned
                                                      : DepthEdges::Unknown;
    if (first.rawDepth.empty())
        first.source.reading = Reading::Photo; // no search for a quilt in each
    return [=, aspect = display.aspect(), scene = 0,
            flaws = std::optional<DepthFlaws>()](const cv::Mat& frame, double seconds) mutable {
        Document document = documentOfFrame(first, frame, display);
        depth->next(document, knobs.depth, seconds);
        if (document.depth.empty()) document.readDepth(document.depth);
        if (document.scene != scene) flaws.reset();
        scene = document.scene;
        cv::Mat native;
        toNative.makeNative(placeFrame({document.picture, document.depth, {}, {}, edges}, aspect,
                                       toNative.workSize(), knobs, flaws),
                            native);
        return native;
    };
}

} // namespace

SlidePresenter::SlidePresenter(const SlideShow::Settings& settings, ShowFiles files,
                               std::shared_ptr<const Display> display,
                               const qt::ScreenFacts& screen,
                               std::function<void(const std::string&)> report,
                               const std::optional<Request>& eyes)
    : files_(std::move(files)), report_(std::move(report)),
      show_(settings, {[this](const Source& source) { make(source); }, report_}),
      maker_(std::make_shared<SlideMaker>(std::move(display), screen, eyes)),
      worker_(std::make_unique<Worker>()) {
    playSettings_.atEnd = AtEnd::Finish;
    show_.setFiles(files_.files());
    widget_.installEventFilter(this);
    connect(&widget_, &qt::NativeWidget::left, this, &SlidePresenter::ended);
    connect(&ticks_, &QTimer::timeout, this, &SlidePresenter::tick);
    rescan_.setSingleShot(true);
    connect(&rescan_, &QTimer::timeout, this, &SlidePresenter::refresh);
    for (const std::filesystem::path& folder : files_.folders())
        watcher_.addPath(QFile::decodeName(folder.string().c_str()));
    connect(&watcher_, &QFileSystemWatcher::directoryChanged, &rescan_,
            [this] { rescan_.start(kSoon); });
    if (!files_.folders().empty()) rescan_.start(kRescan);
    connect(
        &arrivals_, &Arrivals::arrived, this,
        [this] {
            const qint64 delivered = deliveredAt_; // the next one may come after take()
            cv::Mat frame = arrivals_.take();
            if (frame.empty() || !player_) return; // of a video that has been left
            native_ = frame;
            draw();
            player_->noteDelay(static_cast<double>(clock_.elapsed() - delivered) / 1000);
        },
        Qt::QueuedConnection);
}

SlidePresenter::~SlidePresenter() {
    endPlayer();
    worker_.reset();
}

void SlidePresenter::start(QScreen& screen) {
    widget_.showOn(screen);
    clock_.start();
    ticks_.start(kFadeTick);
}

void SlidePresenter::moveEyes(double position) {
    eyesAt_ = position;
    const Slide* const slide = show_.shown();
    if (slide == nullptr || !slide->pictureFrom) return;
    worker_->post(1, [this, make = slide->pictureFrom, position, change = change_] {
        try {
            later(this, [this, picture = make(position), change] {
                if (change != show_.changes()) return;
                native_ = picture;
                draw();
            });
        } catch (const std::exception&) { // the picture stays
        }
    });
}

VideoPlayer::Counts SlidePresenter::counts() const {
    const VideoPlayer::Counts now = player_ ? player_->counts() : VideoPlayer::Counts();
    return {counts_.shown + now.shown, counts_.dropped + now.dropped};
}

bool SlidePresenter::eventFilter(QObject* object, QEvent* event) {
    if (event->type() == QEvent::KeyPress && onKey(*static_cast<QKeyEvent*>(event))) return true;
    return QObject::eventFilter(object, event);
}

void SlidePresenter::setPlaySettings(const PlaySettings& settings) {
    playSettings_ = settings;
    playSettings_.atEnd = AtEnd::Finish;
    if (player_) player_->set(playSettings_);
}

bool SlidePresenter::onKey(const QKeyEvent& event) {
    const int key = event.key();
    if (event.modifiers().testFlag(Qt::ShiftModifier) &&
        (key == Qt::Key_Left || key == Qt::Key_Right)) {
        if (player_)
            player_->seek(player_->state().position + (key == Qt::Key_Left ? -1 : 1) * kSeekStep);
        return true;
    }
    PlaySettings settings = playSettings_;
    switch (key) {
    case Qt::Key_M:
        settings.muted = !settings.muted;
        setPlaySettings(settings);
        return true;
    case Qt::Key_Plus:
    case Qt::Key_Minus:
        settings.volume += key == Qt::Key_Plus ? kVolumeStep : -kVolumeStep;
        settings.volume = std::clamp(settings.volume, 0, 100);
        setPlaySettings(settings);
        return true;
    case Qt::Key_Right:
    case Qt::Key_PageDown:
        show_.next();
        return true;
    case Qt::Key_Left:
    case Qt::Key_PageUp:
        show_.previous();
        return true;
    case Qt::Key_Space:
        show_.setPaused(!show_.isPaused());
        if (player_) player_->setPaused(show_.isPaused());
        return true;
    case Qt::Key_Q:
        widget_.leave();
        return true;
    default:
        return false;
    }
}

void SlidePresenter::make(const Source& source) {
    worker_->post(0, [this, source, maker = maker_, position = eyesAt_] {
        const Slide slide = maker->make(source, position);
        later(this, [this, slide] { show_.put(slide); });
    });
}

void SlidePresenter::tick() {
    const bool wasFading = show_.isFading();
    show_.tick(static_cast<double>(clock_.elapsed()) / 1000);
    if (show_.isOver()) {
        ticks_.stop();
        emit ended();
        return;
    }
    if (show_.changes() != change_) {
        change_ = show_.changes();
        begin(*show_.shown());
        draw();
    } else if (wasFading || show_.isFading()) {
        draw();
    }
    ticks_.setInterval(show_.isFading() ? kFadeTick : kUsualTick);
}

void SlidePresenter::begin(const Slide& slide) {
    endPlayer();
    native_ = slide.native;
    if (slide.madeFrom != eyesAt_) moveEyes(eyesAt_); // the viewer has moved since
    if (!slide.isVideo()) return;
    player_ = std::make_unique<VideoPlayer>(
        slide.source.file,
        [this, convert = slide.nativeOfFrame](const cv::Mat& frame, double seconds) {
            if (!arrivals_.isFree()) return false;
            deliveredAt_ = clock_.elapsed();
            return arrivals_.put(convert(frame, seconds));
        },
        [this, change = change_](const std::string& problem) {
            // what cannot be read further also ends here
            later(this, [this, change, problem] {
                if (change != show_.changes()) return;
                if (!problem.empty()) report_(problem);
                show_.endVideo();
            });
        },
        playSettings_, readingOf(slide.source));
    player_->setPaused(show_.isPaused());
}

void SlidePresenter::endPlayer() {
    if (!player_) return;
    player_->end();
    counts_ = counts();
    player_.reset();
    arrivals_.take();
}

void SlidePresenter::draw() {
    cv::Mat picture;
    show_.blend(native_, picture);
    widget_.setNative(picture);
    widget_.repaint();
}

void SlidePresenter::refresh() {
    const bool isDone = files_.refresh(static_cast<double>(clock_.elapsed()) / 1000);
    show_.setFiles(files_.files());
    for (const std::filesystem::path& folder : files_.folders()) { // one may have come back
        const QString name = QFile::decodeName(folder.string().c_str());
        if (!watcher_.directories().contains(name) && QFile::exists(name)) watcher_.addPath(name);
    }
    rescan_.start(isDone ? kRescan : kSoon);
}

SlideMaker::SlideMaker(std::shared_ptr<const Display> display, qt::ScreenFacts screen,
                       const std::optional<Request>& eyes)
    : screen_(std::move(screen)), request_(eyes.value_or(Request())),
      depthMaker_(std::make_shared<DepthMaker>()), studio_(depthMaker_) {
    request_.display = std::move(display);
    if (!request_.display) return;
    if (!eyes) request_.mode = Mode::Native;
    request_.area = eyes && !eyes->throughLens ? screen_.size : request_.display->panelSize();
}

Slide SlideMaker::make(const Source& source, double position) {
    Slide slide;
    slide.source = source;
    const bool isVideo = isVideoName(source.file);
    const auto asItIs = [](const cv::Mat& frame, double /*seconds*/) { return frame; };
    try {
        if (!request_.display) {
            slide.native = firstPicture(source.file);
            if (!qt::hasSize(screen_, slide.native.size()))
                throw Error(ErrorCode::Mismatch, source.file.string(),
                            "has " + sizeText(slide.native.size()) + ", but the screen shows " +
                                sizeText(screen_.size) +
                                "; expected a Native made for it, or -c with the display's "
                                "calibration");
            if (isVideo) slide.nativeOfFrame = asItIs;
            return slide;
        }
        const Display& display = *request_.display;
        const auto document = std::make_shared<const Document>(readDocument(source, display));
        Request request = request_;
        request.document = document;
        if (request.mode == Mode::Stereo) {
            if (document->kind == Kind::Native || document->video)
                throw Error(ErrorCode::Unsupported, source.file.string(),
                            "is a Native or a video, expected a photo or a quilt for two eyes");
            // a studio of its own keeps the fitted scene
            slide.pictureFrom =
                [request, studio = std::make_shared<Studio>(depthMaker_)](double at) mutable {
                    request.position = at;
                    return studio->render(request).picture;
                };
            slide.native = slide.pictureFrom(position);
            slide.madeFrom = position;
            return slide;
        }
        if (document->video) request.knobs = ofVideo(request.knobs);
        // without the studio's copies of the document
        slide.native = studio_.render(request).picture.clone();
        if (isVideo && document->kind == Kind::Native) slide.nativeOfFrame = asItIs;
        if (isVideo && document->kind == Kind::Quilt)
            slide.nativeOfFrame =
                [convert = quiltConverter(source.file, document->layout, display, true)](
                    const cv::Mat& frame, double /*seconds*/) { return convert(frame); };
        if (isVideo && document->kind == Kind::Scene)
            slide.nativeOfFrame = sceneConverter(*document, display, depthMaker_);
    } catch (const std::exception& error) {
        slide = {source, {}, nullptr, nullptr, tools::sentenceOf(error)};
    }
    return slide;
}

} // namespace altiro3D::viewer
