#include "viewer/controller.hpp"

#include "altiro3D/display.hpp"
#include "altiro3D/video_depth.hpp"
#include "common/run_tool.hpp"
#include "viewer/depth_maker.hpp"

#include <QUndoCommand>
#include <algorithm>
#include <climits>
#include <cmath>
#include <optional>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kReading = 0; // kinds of work
constexpr std::size_t kRendering = 1;
constexpr std::size_t kPresenting = 2;
constexpr int kSwingMilliseconds = 33;
constexpr double kSwingPeriodMilliseconds = 4000;
constexpr double kPi = 3.14159265358979323846;

bool has(const std::vector<Mode>& modes, Mode mode) {
    return std::find(modes.begin(), modes.end(), mode) != modes.end();
}

QString textOf(const std::exception& error) {
    return QString::fromStdString(tools::sentenceOf(error));
}

// Whether a source is a folder that may hold unrelated files.
bool isFolderOfFiles(const Source& source) {
    std::error_code error;
    return source.reading == Reading::Automatic && fs::is_directory(source.file, error);
}

// The depth of a playing flat video: steady, inferred as often as the pictures require.
class PlayedDepth {
  public:
    explicit PlayedDepth(std::shared_ptr<DepthMaker> maker) : maker_(std::move(maker)) {}

    // Sets the depth of the next picture, if it is to be estimated.
    // @param wish Knobs::depth
    void next(Document& document, const std::string& wish) {
        const std::string chosen = maker_->choose(wish, !document.rawDepth.empty());
        if (chosen == kGivenDepth) return;
        if (chosen != chosen_) {
            DepthKind kind = DepthKind::NearWhite;
            maker_->use(chosen, [&](DepthSource& source) { kind = source.kind(); });
            const auto estimate = [maker = maker_, chosen](const cv::Mat& picture, cv::Mat& raw) {
                cv::Mat photo;
                maker->use(chosen, [&](DepthSource& source) { source.read(picture, photo, raw); });
            };
            depth_.emplace(estimate, kind);
            chosen_ = chosen;
        }
        depth_->next(document.picture, document.depth);
    }

  private:
    std::shared_ptr<DepthMaker> maker_;
    std::string chosen_;
    std::optional<VideoDepth> depth_;
};

} // namespace

// A change of settings that can be undone.
class Controller::Turn : public QUndoCommand {
  public:
    Turn(Controller& controller, Knobs before, Knobs after, const QString& what, int gesture)
        : QUndoCommand(what), controller_(controller), before_(std::move(before)),
          after_(std::move(after)), gesture_(gesture) {}

    void undo() override { controller_.setKnobs(before_); }
    void redo() override { controller_.setKnobs(after_); }
    int id() const override { return gesture_ > 0 ? gesture_ : -1; }
    bool mergeWith(const QUndoCommand* other) override {
        after_ = static_cast<const Turn*>(other)->after_;
        return true;
    }

  private:
    Controller& controller_;
    Knobs before_;
    Knobs after_;
    int gesture_;
};

Controller::Controller(Display display, QObject* parent)
    : QObject(parent), display_(std::make_shared<const Display>(std::move(display))),
      depthMaker_(std::make_shared<DepthMaker>()), studio_(std::make_shared<Studio>(depthMaker_)) {
    swingTimer_.setInterval(kSwingMilliseconds);
    connect(&swingTimer_, &QTimer::timeout, this, &Controller::swing);
    connect(this, &Controller::pictureArrived, this, &Controller::takePicture,
            Qt::QueuedConnection); // it comes from the player's thread
}

Controller::~Controller() {
    cancelling_ = true;
}

void Controller::open(const std::vector<fs::path>& files) {
    const std::vector<Source> sources = pairUp(files);
    if (sources.empty()) return;
    const int first = static_cast<int>(sources_.size());
    sources_.insert(sources_.end(), sources.begin(), sources.end());
    emit sourcesChanged();
    select(first);
}

void Controller::open(const Source& source) {
    sources_.push_back(source);
    emit sourcesChanged();
    select(static_cast<int>(sources_.size()) - 1);
}

void Controller::select(int index) {
    if (index < 0 || index >= static_cast<int>(sources_.size())) return;
    current_ = index;
    readCurrent();
}

void Controller::close(int index) {
    if (index < 0 || index >= static_cast<int>(sources_.size())) return;
    sources_.erase(sources_.begin() + index);
    const bool wasCurrent = index == current_;
    if (index < current_) --current_;
    const int count = static_cast<int>(sources_.size());
    if (current_ >= count) current_ = count - 1;
    emit sourcesChanged();
    if (!wasCurrent) return;
    if (current_ >= 0) {
        readCurrent();
        return;
    }
    ++readings_;
    endPlayer([] {});
    opening_ = waiting_ = false;
    document_.reset();
    problem_.clear();
    playerProblem_.clear();
    frame_ = {};
    emit documentChanged();
    emit frameReady();
}

void Controller::reopen(Reading reading, const fs::path& depth) {
    if (current_ < 0) return;
    Source& source = sources_[static_cast<std::size_t>(current_)];
    source.reading = reading;
    source.depth = depth;
    readCurrent();
}

void Controller::endPlayer(std::function<void()> then) {
    // the player may be running an inference; it must outlive a task that is replaced
    endingPlayers_.add(std::exchange(player_, nullptr));
    worker_.post(kReading, [this, then = std::move(then)] {
        endingPlayers_.endAll();
        then();
    });
}

void Controller::readCurrent() {
    const quint64 number = ++readings_;
    opening_ = true;
    playerProblem_.clear();
    emit documentChanged();
    const Source source = sources_[static_cast<std::size_t>(current_)];
    endPlayer([this, number, source, display = display_, notes = std::exchange(folderNotes_, {})] {
        std::shared_ptr<Document> document;
        QString problem;
        try {
            if (isFolderOfFiles(source)) {
                const FolderFiles found = filesOfFolder(source.file);
                if (found.files.size() != 1 || found.files.front().file != source.file) {
                    QMetaObject::invokeMethod(
                        this,
                        [this, number, source, found] {
                            if (number == readings_) takeFiles(source, found);
                        },
                        Qt::QueuedConnection);
                    return;
                }
            }
            document = std::make_shared<Document>(readDocument(source, *display));
            document->notes.insert(document->notes.end(), notes.begin(), notes.end());
        } catch (const std::exception& error) {
            problem = textOf(error);
        }
        QMetaObject::invokeMethod(
            this,
            [this, number, document, problem] {
                if (number != readings_) return; // overtaken
                opening_ = false;
                document_ = document;
                problem_ = problem;
                pan_ = {};
                const std::vector<Mode> modes =
                    document ? modesOf(document->kind) : std::vector<Mode>();
                if (document && !has(modes, mode_)) {
                    mode_ = modes.front();
                    emit modeChanged();
                }
                waiting_ = document != nullptr && !area_.empty();
                if (!document) frame_ = {};
                emit documentChanged();
                if (!document) emit frameReady();
                requestFrame();
                requestNative();
                if (document && document->video) play();
            },
            Qt::QueuedConnection);
    });
}

void Controller::takeFiles(const Source& folder, const FolderFiles& found) {
    const auto at = sources_.begin() + current_;
    if (at->file != folder.file) return; // cannot be: such a change begins another reading
    sources_.insert(sources_.erase(at), found.files.begin(), found.files.end());
    folderNotes_ = found.notes;
    emit sourcesChanged();
    readCurrent();
}

void Controller::turn(const Knobs& knobs, const QString& what, int gesture) {
    if (knobs != knobs_) undoStack_.push(new Turn(*this, knobs_, knobs, what, gesture));
}

void Controller::resetKnobs() {
    turn(Knobs(), tr("reset of all settings"));
}

void Controller::restoreKnobs(const Knobs& knobs) {
    setKnobs(knobs);
}

void Controller::setKnobs(const Knobs& knobs) {
    if (knobs == knobs_) return;
    const bool depthTurned = knobs.depth != knobs_.depth;
    if (depthTurned && document_ && document_->kind == Kind::Scene) {
        waiting_ = true; // new depth may take long
        emit documentChanged();
    }
    knobs_ = knobs;
    {
        const std::lock_guard<std::mutex> lock(arrivalMutex_);
        depthWish_ = knobs.depth;
    }
    emit knobsChanged();
    if (depthTurned && !playerProblem_.isEmpty() && !opening_) {
        readCurrent(); // the video may have stopped because the previous depth failed
        return;
    }
    requestFrame();
    requestNative();
}

void Controller::setDisplay(Display display) {
    display_ = std::make_shared<const Display>(std::move(display));
    emit displayChanged();
    if (current_ >= 0) readCurrent(); // the kind of a picture depends on the display
}

void Controller::setMode(Mode mode) {
    if (mode == mode_ || !has(modesOf(document_ ? document_->kind : Kind::Scene), mode)) return;
    mode_ = mode;
    pan_ = {};
    emit modeChanged();
    requestFrame();
}

void Controller::setPosition(double position) {
    position_ = std::clamp(position, -1.0, 1.0);
    if (mode_ == Mode::Sway || mode_ == Mode::Lens) requestFrame();
}

void Controller::setSwinging(bool swinging) {
    if (swinging == swinging_) return;
    swinging_ = swinging;
    if (swinging) {
        swingClock_.start();
        swingTimer_.start();
    } else {
        swingTimer_.stop();
    }
    emit swingingChanged(swinging);
    if (!swinging) setPosition(0);
}

void Controller::swing() {
    if (!document_ || (mode_ != Mode::Sway && mode_ != Mode::Lens)) return;
    const double turns = static_cast<double>(swingClock_.elapsed()) / kSwingPeriodMilliseconds;
    setPosition(std::sin(2 * kPi * turns));
}

void Controller::setPlaying(bool playing) {
    playing_ = playing;
    if (player_) player_->setPaused(!playing);
}

VideoPlayer::Counts Controller::videoCounts() const {
    return player_ ? player_->counts() : VideoPlayer::Counts();
}

void Controller::play() {
    const quint64 number = readings_;
    const Source source = document_->source;
    const auto depth =
        std::make_shared<PlayedDepth>(depthMaker_); // used by the player's thread alone
    const auto show = [this, number, source, depth, display = display_](const cv::Mat& picture) {
        if (pictureWaits_.exchange(true)) return false; // the one before is still being made
        auto document = std::make_shared<Document>(documentOf(source, picture, *display));
        document->video = true;
        if (document->kind == Kind::Scene) {
            std::string wish;
            {
                const std::lock_guard<std::mutex> lock(arrivalMutex_);
                wish = depthWish_;
            }
            depth->next(*document, wish);
        }
        {
            const std::lock_guard<std::mutex> lock(arrivalMutex_);
            arrival_ = {number, document, {}};
        }
        emit pictureArrived();
        return true;
    };
    const auto fail = [this, number](const std::string& problem) {
        {
            const std::lock_guard<std::mutex> lock(arrivalMutex_);
            arrival_ = {number, nullptr, QString::fromStdString(problem)};
        }
        emit pictureArrived();
    };
    pictureWaits_ = false; // the player before has ended
    player_ = std::make_shared<VideoPlayer>(source.file, show, fail);
    player_->setPaused(!playing_);
}

void Controller::takePicture() {
    Arrival arrival;
    {
        const std::lock_guard<std::mutex> lock(arrivalMutex_);
        std::swap(arrival, arrival_);
    }
    if (arrival.reading != readings_) return; // of another file
    if (!arrival.document) {
        playerProblem_ = arrival.problem; // frames that are still made do not take it away
        emit documentChanged();
        return;
    }
    document_ = arrival.document;
    requestFrame();
    requestNative();
}

void Controller::setArea(cv::Size area) {
    if (area == area_) return;
    area_ = area;
    requestFrame();
}

void Controller::panBy(cv::Point by) {
    if (mode_ != Mode::Native) return;
    pan_ += by;
    requestFrame();
}

void Controller::focusAt(double x, double y) {
    const cv::Mat& depth = frame_.depth;
    if (depth.empty() || frameReading_ != readings_) return;
    const cv::Point at(static_cast<int>(x * depth.cols), static_cast<int>(y * depth.rows));
    Knobs knobs = knobs_;
    const double position = frame_.request.mode == Mode::Sway ? frame_.request.position : 0;
    const double seen = depthSeenAt(depth, frame_.setup.knobs.views, position, at);
    knobs.views.focus = std::round(seen * 100) / 100; // as the knob has it
    knobs.automatic.focus = false;
    turn(knobs, tr("focus"));
}

bool Controller::canFrame() const {
    const Request& shown = frame_.request;
    return document_ && frameReading_ == readings_ && !frame_.picture.empty() &&
           document_->kind == Kind::Scene &&
           (shown.mode == Mode::Sway || shown.mode == Mode::Depth || shown.mode == Mode::Lens);
}

FramedPhoto Controller::framedPhoto() const {
    return {document_->picture.size(), display_->aspect(), knobs_.fit};
}

Knobs Controller::withFrame() const {
    Knobs knobs = knobs_;
    if (knobs.automatic.framing) knobs.framing = frame_.setup.knobs.framing;
    knobs.automatic.framing = false;
    return knobs;
}

void Controller::moveFrame(cv::Point2d by, int gesture) {
    if (!canFrame()) return;
    Knobs knobs = withFrame();
    knobs.framing = moved(knobs.framing, framedPhoto(), by);
    turn(knobs, tr("frame"), gesture);
}

void Controller::zoomFrame(cv::Point2d at, double factor, int gesture) {
    if (!canFrame()) return;
    Knobs knobs = withFrame();
    knobs.framing = zoomed(knobs.framing, framedPhoto(), at, factor);
    turn(knobs, tr("zoom"), gesture);
}

void Controller::resetFrame() {
    Knobs knobs = knobs_;
    knobs.framing = {};
    knobs.automatic.framing = false;
    turn(knobs, tr("frame"));
}

void Controller::requestFrame() {
    // no frames of the previous file while another one is read: they would be taken for frames of
    // the new file
    if (opening_ || !document_ || area_.empty()) return;
    Request request{document_, knobs_, display_, mode_, position_, area_, pan_};
    if (!has(modesOf(document_->kind), mode_)) return;
    worker_.post(kRendering,
                 [this, request = std::move(request), studio = studio_, number = readings_] {
                     Frame frame;
                     QString problem;
                     try {
                         frame = studio->render(request);
                     } catch (const std::exception& error) {
                         problem = textOf(error);
                         frame.request = request;
                     }
                     QMetaObject::invokeMethod(
                         this,
                         [this, frame, problem, number] {
                             if (number != readings_) return; // overtaken by another file
                             frameReading_ = number;
                             if (frame.request.document == document_) pictureWaits_ = false;
                             const bool changed = waiting_ || problem != problem_;
                             waiting_ = frame.request.knobs.depth != knobs_.depth;
                             problem_ = problem;
                             takeFrame(frame);
                             if (changed) emit documentChanged();
                         },
                         Qt::QueuedConnection);
                 });
}

void Controller::setPresenting(bool presenting) {
    presenting_ = presenting;
    requestNative();
}

void Controller::requestNative() {
    if (!presenting_ || !document_) return;
    const cv::Size all(INT_MAX, INT_MAX);
    worker_.post(kPresenting,
                 [this, studio = studio_,
                  request = Request{document_, knobs_, display_, Mode::Native, 0, all, {}}] {
                     cv::Mat native;
                     try {
                         native = studio->render(request).picture;
                     } catch (const std::exception&) {
                         return; // the picture in the window says why
                     }
                     QMetaObject::invokeMethod(
                         this,
                         [this, native, document = request.document] {
                             if (presenting_ && document == document_) emit nativeReady(native);
                         },
                         Qt::QueuedConnection);
                 });
}

void Controller::takeFrame(const Frame& frame) {
    frame_ = frame;
    if (frame.request.mode == Mode::Native && mode_ == Mode::Native) pan_ = frame.request.pan;
    emit frameReady();
}

QString Controller::exportObstacle() const {
    if (exporting_) return tr("Another export is under way; export again when it is done");
    if (!document_) return tr("Nothing is open that could be exported");
    if (!frame_.setup.document || frameReading_ != readings_)
        return tr("The file is still being opened; export again when its picture is shown");
    if (frame_.request.knobs.depth != knobs_.depth)
        return tr("The depth is still being estimated; export again when the picture shows it");
    return {};
}

Setup Controller::exportSetup() const {
    Setup setup = frame_.setup;
    setup.knobs = knobs_;
    setup.isChosen = false;
    layFlatDepth(setup);
    return setup;
}

bool Controller::startExport(Product product, const fs::path& target) {
    if (!exportObstacle().isEmpty()) return false;
    Setup setup = exportSetup();
    exporting_ = true;
    cancelling_ = false;
    exporter_.post(0, [this, setup = std::move(setup), product, target] {
        QString file;
        QString problem;
        try {
            file = QString::fromStdString(writeProduct(setup, product, target, [this](double done) {
                QMetaObject::invokeMethod(
                    this, [this, done] { emit exportProgress(done); }, Qt::QueuedConnection);
                return !cancelling_;
            }));
        } catch (const std::exception& error) {
            problem = textOf(error);
        }
        QMetaObject::invokeMethod(
            this,
            [this, file, problem] {
                exporting_ = false;
                emit exportEnded(file, problem);
            },
            Qt::QueuedConnection);
    });
    return true;
}

} // namespace altiro3D::viewer
