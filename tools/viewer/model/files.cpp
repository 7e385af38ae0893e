#include "viewer/model/files.hpp"

#include "altiro3D/display.hpp"
#include "cli/run_tool.hpp"

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

// Whether a source is a folder that may hold unrelated files.
bool isFolderOfFiles(const Source& source) {
    return source.reading == Reading::Automatic && tools::isDirectory(source.file);
}

} // namespace

Files::Files(Display display, Settings& settings)
    : settings_(settings), display_(std::make_shared<const Display>(std::move(display))) {
    connect(&settings, &Settings::knobsChanged, this, &Files::takeDepthWish);
}

void Files::open(const std::vector<fs::path>& files) {
    open(pairUp(files));
}

void Files::open(const std::vector<Source>& sources) {
    if (sources.empty()) return;
    const int first = static_cast<int>(sources_.size());
    sources_.insert(sources_.end(), sources.begin(), sources.end());
    emit sourcesChanged();
    select(first);
}

void Files::select(int index) {
    if (index < 0 || index >= static_cast<int>(sources_.size())) return;
    current_ = index;
    readCurrent();
}

void Files::close(int index) {
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
    reading_ = false;
    document_.reset();
    problem_.clear();
    settings_.use({});
    endPlayer([] {});
    emit opened();
}

void Files::reopen(Reading reading, const fs::path& depth) {
    if (current_ < 0) return;
    Source& source = sources_[static_cast<std::size_t>(current_)];
    source.reading = reading;
    source.depth = depth;
    readCurrent();
}

void Files::endPlayer(std::function<void()> then) {
    // the player may be running an inference; it must outlive a task that is replaced
    endingPlayers_.add(std::exchange(player_, nullptr));
    worker_.post(0, [this, then = std::move(then)] {
        endingPlayers_.endAll();
        then();
    });
}

void Files::readCurrent() {
    const quint64 number = ++readings_;
    reading_ = true;
    if (document_) problem_.clear(); // of a video
    const Source source = sources_[static_cast<std::size_t>(current_)];
    settings_.use(source.file);
    emit stateChanged();
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
            problem = QString::fromStdString(tools::sentenceOf(error));
        }
        later(this, [this, number, document, problem] {
            if (number != readings_) return; // overtaken
            reading_ = false;
            document_ = document;
            problem_ = problem;
            emit opened();
            if (document && document->video) play();
        });
    });
}

void Files::takeFiles(const Source& folder, const FolderFiles& found) {
    const auto at = sources_.begin() + current_;
    if (at->file != folder.file) return; // cannot be: such a change begins another reading
    sources_.insert(sources_.erase(at), found.files.begin(), found.files.end());
    folderNotes_ = found.notes;
    emit sourcesChanged();
    readCurrent();
}

void Files::setDisplay(Display display) {
    display_ = std::make_shared<const Display>(std::move(display));
    emit stateChanged();
    if (current_ >= 0) readCurrent(); // the kind of a picture depends on the display
}

void Files::takeDepthWish() {
    {
        const std::lock_guard<std::mutex> lock(wishMutex_);
        if (depthWish_ == settings_.knobs().depth) return;
        depthWish_ = settings_.knobs().depth;
    }
    // the video may have stopped because the previous depth failed
    if (document_ && !problem_.isEmpty() && !reading_) readCurrent();
}

void Files::setPlaying(bool playing) {
    playing_ = playing;
    if (player_) player_->setPaused(!playing);
    emit playingChanged(playing);
}

void Files::setPlaySettings(const PlaySettings& settings) {
    playSettings_ = settings;
    if (player_) player_->set(settings);
    emit playSettingsChanged();
}

void Files::play() {
    const quint64 number = readings_;
    const Source source = document_->source;
    const auto depth =
        std::make_shared<PlayedDepth>(depthMaker_); // used by the player's thread alone
    const auto show = [this, number, depth, display = display_,
                       video = document_](const cv::Mat& picture, double seconds) {
        if (pictureWaits_.exchange(true)) return false; // the one before is still being made
        const auto since = std::chrono::steady_clock::now();
        auto document = std::make_shared<Document>(documentOfFrame(*video, picture, *display));
        if (document->kind == Kind::Scene) {
            std::string wish;
            {
                const std::lock_guard<std::mutex> lock(wishMutex_);
                wish = depthWish_;
            }
            depth->next(*document, wish, seconds);
        }
        later(this, [this, number, document, since] {
            if (number != readings_) return;
            document_ = document;
            shownSince_ = since;
            emit pictureCame();
        });
        return true;
    };
    const auto fail = [this, number](const std::string& problem) {
        later(this, [this, number, problem] {
            if (number != readings_) return; // of another file
            problem_ = QString::fromStdString(problem);
            emit stateChanged();
        });
    };
    pictureWaits_ = false; // the player before has ended
    playSettings_.track = -1;
    player_ =
        std::make_shared<VideoPlayer>(source.file, show, fail, playSettings_, readingOf(source));
    player_->setPaused(!playing_);
}

void Files::noteShown(const std::shared_ptr<const Document>& picture) {
    if (picture != document_) return;
    pictureWaits_ = false;
    if (!player_ || !shownSince_) return;
    // by the time that this picture took to the window, the next ones are delivered earlier
    const auto now = std::chrono::steady_clock::now();
    player_->noteDelay(std::chrono::duration<double>(now - *shownSince_).count());
    shownSince_.reset();
}

} // namespace altiro3D::viewer
