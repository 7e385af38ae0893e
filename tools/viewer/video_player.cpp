#include "viewer/video_player.hpp"

#include "altiro3D/video_io.hpp"
#include "common/run_tool.hpp"

#include <algorithm>
#include <utility>

namespace altiro3D::viewer {

namespace {

constexpr double kUsualDuration = 0.04; // s, if a picture states none
constexpr double kMinLength = 0.04; // s, of a video, so that a single picture is not read in a loop
constexpr double kMaxGap = 0.25;    // s, after which a late picture is shown as well
constexpr double kFarthest = 1e9;   // s, that fit into the clock's numbers; files may state more

} // namespace

VideoPlayer::VideoPlayer(std::filesystem::path file, std::function<bool(const cv::Mat&)> show,
                         std::function<void(const std::string&)> done, bool loops)
    : file_(std::move(file)), show_(std::move(show)), done_(std::move(done)), loops_(loops),
      thread_([this] { run(); }) {}

VideoPlayer::~VideoPlayer() {
    end();
}

void VideoPlayer::end() {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        ending_ = true;
    }
    wake_.notify_one();
    if (thread_.joinable()) thread_.join();
}

void VideoPlayer::setPaused(bool paused) {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        paused_ = paused;
    }
    wake_.notify_one();
}

VideoPlayer::Counts VideoPlayer::counts() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return counts_;
}

bool VideoPlayer::waitUntil(double seconds) {
    std::unique_lock<std::mutex> lock(mutex_);
    const std::chrono::duration<double> wait(std::clamp(seconds, -kFarthest, kFarthest));
    const auto due = [&] { return start_ + std::chrono::duration_cast<Clock::duration>(wait); };
    while (!ending_) {
        if (paused_) {
            const Clock::time_point began = Clock::now();
            wake_.wait(lock, [this] { return ending_ || !paused_; });
            start_ += Clock::now() - began; // the video's clock was paused
        } else if (Clock::now() >= due()) {
            return true;
        } else {
            wake_.wait_until(lock, due(), [this] { return ending_ || paused_; });
        }
    }
    return false;
}

void VideoPlayer::playOnce() {
    VideoReader reader(file_);
    const double unit = reader.facts().timeBase.value();
    start_ = Clock::now();
    Clock::time_point last = start_ - std::chrono::hours(1);
    VideoFrame frame;
    double end = kMinLength;
    while (reader.read(frame)) {
        const double time = static_cast<double>(frame.pts) * unit;
        if (!waitUntil(time)) return;
        const Clock::time_point now = Clock::now();
        const double late = std::chrono::duration<double>(now - start_).count() - time;
        const double gap = std::chrono::duration<double>(now - last).count();
        const double duration =
            frame.duration > 0 ? static_cast<double>(frame.duration) * unit : kUsualDuration;
        end = std::max(end, time + duration);
        const bool shown = (late < duration || gap > kMaxGap) && show_(frame.picture);
        if (shown) {
            last = now;
            frame.picture = cv::Mat(); // its receiver may keep it
        }
        const std::lock_guard<std::mutex> lock(mutex_);
        ++(shown ? counts_.shown : counts_.dropped);
        if (ending_) return;
    }
    waitUntil(end);
}

void VideoPlayer::run() {
    try {
        do {
            playOnce();
            const std::lock_guard<std::mutex> lock(mutex_);
            if (ending_) return;
        } while (loops_);
        done_({});
    } catch (const std::exception& error) {
        done_(tools::sentenceOf(error));
    }
}

void EndingPlayers::add(std::shared_ptr<VideoPlayer> player) {
    if (!player) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    players_.push_back(std::move(player));
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
