#include "viewer/player/video_player.hpp"

#include "cli/run_tool.hpp"

#include <algorithm>
#include <utility>

namespace altiro3D::viewer {

namespace {

constexpr double kUsualDuration = 0.04; // s, if a picture states none
constexpr double kMinLength = 0.04; // s, of a video, so that a single picture is not read in a loop
constexpr double kMaxGap = 0.25;    // s, after which a late picture is shown as well
constexpr double kLatest = 0.03;    // s; a picture that is later is out of step with the sound
constexpr double kLongestWait = 3600; // s; files may state more than the clock's numbers hold
constexpr double kSoundWait = 0.005;  // s; the sound begins and goes on at times of its own
constexpr double kShortestWait = 0.001;
constexpr double kLongestLead = 0.2; // s
constexpr double kLeadShare = 0.2;   // of a new delay in the smoothed one
constexpr double kFarthest = 1e8;    // s, that can be sought

} // namespace

VideoPlayer::VideoPlayer(std::filesystem::path file,
                         std::function<bool(const cv::Mat&, double)> show,
                         std::function<void(const std::string&)> done, const PlaySettings& settings,
                         const VideoReaderOptions& reading)
    : file_(std::move(file)), reading_(reading), show_(std::move(show)), done_(std::move(done)),
      settings_(settings), thread_([this] { run(); }) {}

void VideoPlayer::end() {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        ending_ = true;
    }
    wake_.notify_one();
    if (thread_.joinable()) thread_.join();
}

void VideoPlayer::setPaused(bool paused) {
    const std::lock_guard<std::mutex> lock(mutex_);
    base_ = now();
    since_ = Clock::now();
    paused_ = paused;
    if (sound_) sound_->setPaused(paused);
    wake_.notify_one();
}

void VideoPlayer::set(const PlaySettings& settings) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const double at = std::max(now(), state_.position); // the sound may not have begun
    const bool begins = settings.speed != settings_.speed || settings.track != settings_.track;
    settings_ = settings;
    if (sound_) sound_->setVolume(settings.muted ? 0 : settings.volume / 100.0);
    if (begins) startClock(at);
    wake_.notify_one();
}

void VideoPlayer::seek(double seconds) {
    const std::lock_guard<std::mutex> lock(mutex_);
    wanted_ = std::clamp(seconds, 0.0, kFarthest);
    wake_.notify_one();
}

void VideoPlayer::noteDelay(double seconds) {
    const std::lock_guard<std::mutex> lock(mutex_);
    lead_ += kLeadShare * (std::clamp(seconds, 0.0, kLongestLead) - lead_);
}

VideoPlayer::Counts VideoPlayer::counts() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return counts_;
}

VideoPlayer::State VideoPlayer::state() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    State state = state_;
    if (wanted_) state.position = *wanted_;
    state.paused = paused_;
    state.sounds = sound_ != nullptr;
    return state;
}

// Called with the mutex held, as is startClock().
double VideoPlayer::now() {
    if (sound_ && sound_->isStuck()) { // the device is lost
        base_ = std::max(sound_->time(), state_.position);
        since_ = Clock::now();
        sound_.reset();
        isSilent_ = true;
    }
    if (sound_) return sound_->time();
    if (paused_) return base_;
    return base_ + settings_.speed * std::chrono::duration<double>(Clock::now() - since_).count();
}

void VideoPlayer::startClock(double from) {
    base_ = from;
    since_ = Clock::now();
    if (sound_) sound_->start(from, settings_.track, settings_.speed);
}

bool VideoPlayer::waitUntil(double seconds, bool leads) {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!isInterrupted()) {
        const double left = (seconds - now()) / settings_.speed - (leads ? lead_ : 0);
        if (!paused_ && left <= 0) return true;
        const std::chrono::duration<double> wait(
            paused_ ? kLongestWait
                    : std::clamp(left, kShortestWait, sound_ ? kSoundWait : kLongestWait));
        wake_.wait_for(lock, wait);
    }
    return false;
}

// Also waits until the sound has been heard.
bool VideoPlayer::waitForEnd(double seconds) {
    if (!waitUntil(seconds)) return false;
    std::unique_lock<std::mutex> lock(mutex_);
    while (sound_ && !sound_->isOver()) {
        if (isInterrupted()) return false;
        state_.position = std::max(state_.position, now()); // notices a lost device
        wake_.wait_for(lock, std::chrono::milliseconds(10));
    }
    return !isInterrupted();
}

void VideoPlayer::openSound(const VideoFacts& facts) {
    std::unique_lock<std::mutex> lock(mutex_);
    state_.tracks.clear();
    for (const VideoStreamFacts& stream : facts.streams)
        if (stream.kind == StreamKind::Audio) state_.tracks.push_back(stream);
    state_.duration = facts.isDevice ? 0 : facts.duration.value_or(0);
    if (sound_ || isSilent_) return;
    isSilent_ = true;
    if (state_.tracks.empty() || facts.isDevice) return;
    lock.unlock(); // opening takes time
    std::unique_ptr<SoundPlayer> sound;
    try {
        sound = std::make_unique<SoundPlayer>(file_);
    } catch (const std::exception&) { // no output
        return;
    }
    lock.lock();
    isSilent_ = false;
    sound_ = std::move(sound);
    sound_->setVolume(settings_.muted ? 0 : settings_.volume / 100.0);
    sound_->setPaused(paused_);
}

bool VideoPlayer::playFrom(double from) {
    VideoReaderOptions options = reading_;
    options.from = from;
    VideoReader reader(file_, options);
    const double unit = reader.facts().timeBase.value();
    openSound(reader.facts());
    Clock::time_point last = Clock::now() - std::chrono::hours(1);
    VideoFrame frame;
    double end = from + kMinLength;
    bool isFirst = true;
    while (reader.read(frame)) {
        const double time = from + static_cast<double>(frame.pts) * unit;
        bool showsNow = false;
        if (isFirst) {
            const std::lock_guard<std::mutex> lock(mutex_);
            showsNow = paused_ && !isInterrupted(); // the place that was sought
            startClock(from);
        }
        isFirst = false;
        if (!showsNow && !waitUntil(time, true)) return false;
        const Clock::time_point since = Clock::now();
        std::unique_lock<std::mutex> lock(mutex_);
        const double speed = settings_.speed;
        const double late = now() + lead_ * speed - time;
        lock.unlock();
        const double gap = std::chrono::duration<double>(since - last).count();
        const double duration =
            frame.duration > 0 ? static_cast<double>(frame.duration) * unit : kUsualDuration;
        end = std::max(end, time + duration);
        const bool shown = (late < std::min(duration, kLatest * speed) || gap > kMaxGap) &&
                           show_(frame.picture, time);
        if (shown) {
            last = since;
            frame.picture = cv::Mat(); // its receiver may keep it
        }
        lock.lock();
        ++(shown ? counts_.shown : counts_.dropped);
        state_.position = time;
        if (isInterrupted()) return false;
    }
    if (isFirst) { // there may be sound after the last picture
        const std::lock_guard<std::mutex> lock(mutex_);
        startClock(from);
    }
    return waitForEnd(end);
}

// Waits, paused, until it has to play again.
void VideoPlayer::rest(std::unique_lock<std::mutex>& lock) {
    base_ = now();
    paused_ = true;
    if (sound_) sound_->setPaused(true);
    wake_.wait(lock,
               [this] { return isInterrupted() || !paused_ || settings_.atEnd != AtEnd::Stop; });
    if (settings_.atEnd == AtEnd::Loop && paused_ && !isInterrupted()) {
        paused_ = false;
        if (sound_) sound_->setPaused(false);
    }
}

void VideoPlayer::run() {
    try {
        for (double from = 0;;) {
            const bool atEnd = playFrom(from);
            std::unique_lock<std::mutex> lock(mutex_);
            if (atEnd && !ending_ && settings_.atEnd == AtEnd::Finish) break;
            if (atEnd && !ending_ && settings_.atEnd == AtEnd::Stop) rest(lock);
            if (ending_) return;
            from = wanted_.value_or(0);
            wanted_.reset();
        }
        done_({});
    } catch (const std::exception& error) {
        done_(tools::sentenceOf(error));
    }
}

void EndingPlayers::add(std::shared_ptr<VideoPlayer> player) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (player) players_.push_back(std::move(player));
}

void EndingPlayers::endAll() {
    std::vector<std::shared_ptr<VideoPlayer>> players;
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        players.swap(players_);
    }
    for (const auto& player : players)
        player->end();
}

} // namespace altiro3D::viewer
