#include "viewer/model/controller.hpp"

#include "altiro3D/display.hpp"
#include "cli/run_tool.hpp"
#include "viewer/model/depth_maker.hpp"

#include <algorithm>
#include <climits>
#include <cmath>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kReading = 0; // kinds of work
constexpr std::size_t kRendering = 1;
constexpr std::size_t kPresenting = 2;
constexpr int kSwingMilliseconds = 33;
constexpr double kSwingPeriodMilliseconds = 4000;
constexpr int kRestMilliseconds = 200;
constexpr int kStoreMilliseconds = 2000; // a crash loses the settings of this time
constexpr double kPi = 3.14159265358979323846;

bool has(const std::vector<Mode>& modes, Mode mode) {
    return std::find(modes.begin(), modes.end(), mode) != modes.end();
}

QString textOf(const std::exception& error) {
    return QString::fromStdString(tools::sentenceOf(error));
}

// Whether a source is a folder that may hold unrelated files.
bool isFolderOfFiles(const Source& source) {
    return source.reading == Reading::Automatic && tools::isDirectory(source.file);
}

} // namespace

Controller::Controller(Display display, QObject* parent)
    : QObject(parent), display_(std::make_shared<const Display>(std::move(display))),
      depthMaker_(std::make_shared<DepthMaker>()), studio_(std::make_shared<Studio>(depthMaker_)) {
    swingTimer_.setInterval(kSwingMilliseconds);
    connect(&swingTimer_, &QTimer::timeout, this, &Controller::swing);
    restTimer_.setSingleShot(true);
    restTimer_.setInterval(kRestMilliseconds);
    connect(&restTimer_, &QTimer::timeout, this, [this] {
        if (mode_ == Mode::Native || mode_ == Mode::Lens) requestFrame();
        requestNative();
    });
    storeTimer_.setSingleShot(true);
    storeTimer_.setInterval(kStoreMilliseconds);
    connect(&storeTimer_, &QTimer::timeout, this, [this] { store_.save(); });
}

Controller::~Controller() {
    cancelling_ = true;
    store_.save();
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
    if (current_ >= 0) return readCurrent();
    ++readings_;
    changeKnobs();
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
    changeKnobs();
    emit documentChanged();
    const Source source = sources_[static_cast<std::size_t>(current_)];
    endPlayer([this, number, source, display = display_, notes = std::exchange(folderNotes_, {})] {
        std::shared_ptr<Document> document;
        QString problem;
        try {
            if (isFolderOfFiles(source)) {
                const FolderFiles found = filesOfFolder(source.file);
                if (found.files.size() != 1 || found.files.front().file != source.file) {
                    later(this, [this, number, source, found] {
                        if (number == readings_) takeFiles(source, found);
                    });
                    return;
                }
            }
            document = std::make_shared<Document>(readDocument(source, *display));
            document->notes.insert(document->notes.end(), notes.begin(), notes.end());
        } catch (const std::exception& error) {
            problem = textOf(error);
        }
        later(this, [this, number, document, problem] {
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
        });
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

void Controller::setDisplay(Display display) {
    display_ = std::make_shared<const Display>(std::move(display));
    emit displayChanged();
    if (current_ >= 0) readCurrent(); // the kind of a picture depends on the display
}

void Controller::findNetworks() {
    depthMaker_->findNetworks();
    waiting_ = document_ != nullptr && !area_.empty();
    emit documentChanged();
    requestFrame();
    requestNative();
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
    emit playingChanged(playing);
}

void Controller::setPlaySettings(const PlaySettings& settings) {
    playSettings_ = settings;
    if (player_) player_->set(settings);
    emit playSettingsChanged();
}

void Controller::play() {
    const quint64 number = readings_;
    const Source source = document_->source;
    const auto depth =
        std::make_shared<PlayedDepth>(depthMaker_); // used by the player's thread alone
    const auto show = [this, number, source, depth, display = display_, eyes = document_->eyes,
                       origin = document_->depthOrigin](const cv::Mat& picture) {
        if (pictureWaits_.exchange(true)) return false; // the one before is still being made
        const auto since = std::chrono::steady_clock::now();
        auto document = std::make_shared<Document>(documentOf(source, picture, *display, eyes));
        if (eyes) document->depthOrigin = origin;
        if (document->kind == Kind::Scene) {
            std::string wish;
            {
                const std::lock_guard<std::mutex> lock(wishMutex_);
                wish = depthWish_;
            }
            depth->next(*document, wish);
        }
        later(this, [this, number, document, since] {
            if (number == readings_) takePicture(document, since);
        });
        return true;
    };
    const auto fail = [this, number](const std::string& problem) {
        later(this, [this, number, problem] {
            if (number != readings_) return;                  // of another file
            playerProblem_ = QString::fromStdString(problem); // frames in the making leave it
            emit documentChanged();
        });
    };
    pictureWaits_ = false; // the player before has ended
    playSettings_.track = -1;
    player_ =
        std::make_shared<VideoPlayer>(source.file, show, fail, playSettings_, readingOf(source));
    player_->setPaused(!playing_);
}

void Controller::takePicture(const std::shared_ptr<const Document>& document,
                             std::chrono::steady_clock::time_point since) {
    document_ = document;
    shownSince_ = since;
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

void Controller::requestFrame() {
    // no frames of the previous file while another one is read: they would be taken for frames of
    // the new file
    if (opening_ || !document_ || area_.empty()) return;
    const bool isDraft = restTimer_.isActive() && (mode_ == Mode::Native || mode_ == Mode::Lens);
    const Request request{document_, knobs_,
                          display_,  paintedNow(),
                          eyes_,     mode_,
                          position_, area_,
                          pan_,      isDraft || (canvas_ && canvas_->isPainting())};
    if (!has(modesOf(document_->kind), mode_)) return;
    worker_.post(kRendering, [this, request, studio = studio_, number = readings_] {
        Frame frame;
        QString problem;
        try {
            frame = studio->render(request);
        } catch (const std::exception& error) {
            problem = textOf(error);
            frame.setup = {request};
            frame.knobs = request.knobs;
        }
        later(this, [this, frame, problem, number] {
            if (number != readings_) return; // overtaken by another file
            frameReading_ = number;
            if (frame.setup.document == document_) pictureWaits_ = false;
            const bool changed = waiting_ || problem != problem_;
            waiting_ = frame.knobs.depth != knobs_.depth;
            problem_ = problem;
            takeFrame(frame);
            noteShown(frame);
            if (changed) emit documentChanged();
        });
    });
}

void Controller::setPresenting(bool presenting, cv::Size eyesScreen) {
    presenting_ = presenting;
    eyesScreen_ = eyesScreen;
    requestNative();
}

void Controller::setEyes(const tools::EyesOptions& eyes) {
    eyes_ = eyes;
    emit eyesChanged();
    if (mode_ == Mode::Stereo) requestFrame();
    if (!eyesScreen_.empty()) requestNative();
}

void Controller::requestNative() {
    if (!presenting_ || opening_ || !document_) return;
    const bool areEyes = !eyesScreen_.empty();
    const Mode mode = areEyes ? Mode::Stereo : Mode::Native;
    if (!has(modesOf(document_->kind), mode)) return;
    const cv::Size area = areEyes ? eyesScreen_ : cv::Size(INT_MAX, INT_MAX);
    const Request request{document_, knobs_, display_, paintedNow(),          eyes_,  mode,
                          0,         area,   {},       restTimer_.isActive(), areEyes};
    worker_.post(kPresenting, [this, studio = studio_, request] {
        cv::Mat native;
        try {
            native = studio->render(request).picture;
        } catch (const std::exception&) {
            return; // the picture in the window says why
        }
        later(this, [this, native, document = request.document] {
            if (presenting_ && document == document_) emit nativeReady(native);
        });
    });
}

// The time that the picture took to the window leads the next ones.
void Controller::noteShown(const Frame& frame) {
    if (!player_ || !shownSince_ || frame.setup.document != document_) return;
    const auto now = std::chrono::steady_clock::now();
    player_->noteDelay(std::chrono::duration<double>(now - *shownSince_).count());
    shownSince_.reset();
}

void Controller::takeFrame(const Frame& frame) {
    frame_ = frame;
    if (frame.setup.mode == Mode::Native && mode_ == Mode::Native) pan_ = frame.setup.pan;
    emit frameReady();
}

} // namespace altiro3D::viewer
