#include "video/video_progress.hpp"

#include "cli/json_text.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace altiro3D::tools {

namespace {

constexpr double kStepSeconds = 0.25;
constexpr int kBarColumns = 24;

using Clock = std::chrono::steady_clock;

double between(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
}

} // namespace

bool VideoPace::update(const VideoProgress& now) {
    const bool isFrame = !now.finishing && now.frames > now_.frames;
    now_ = now;
    if (isFrame && firstTime_ < 0) firstTime_ = now.end;
    return isFrame;
}

double VideoPace::spent() const {
    return between(start_, Clock::now());
}

double VideoPace::rate() const {
    const double seconds = spent();
    return seconds > 0 ? static_cast<double>(now_.frames - now_.keptFrames) / seconds : 0;
}

std::optional<double> VideoPace::share() const {
    if (!now_.length || *now_.length <= 0) return std::nullopt;
    return std::clamp(now_.end / *now_.length, 0.0, 1.0);
}

std::optional<double> VideoPace::secondsLeft() const {
    const double made = now_.end - firstTime_;
    if (!share() || firstTime_ < 0 || made <= 0) return std::nullopt;
    return spent() * std::max(*now_.length - now_.end, 0.0) / made;
}

VideoProgressLine::VideoProgressLine(bool json, const VideoProgress& start, std::string input,
                                     std::string place)
    : json_(json), input_(std::move(input)), place_(std::move(place)), pace_(start) {}

VideoProgressLine::~VideoProgressLine() {
    clear();
}

void VideoProgressLine::update(const VideoProgress& now) {
    const bool isFrame = pace_.update(now);
    if (now.finishing) {
        if (json_) {
            putLine(stateLine("finishing"));
        } else {
            showStatus(place_ + "finishing the file ...");
        }
        return;
    }
    if (!isFrame) return;
    const Clock::time_point time = Clock::now();
    if (shown_ != Clock::time_point{} && between(shown_, time) < kStepSeconds) return;
    shown_ = time;
    show();
}

void VideoProgressLine::show() {
    if (!json_ && !hasStatusLine()) return;
    const VideoProgress& now = pace_.now();
    const std::optional<double> share = pace_.share();
    const std::optional<double> left = pace_.secondsLeft();
    if (json_) {
        nlohmann::ordered_json line = stateLine("running");
        if (now.framesInAll) line["framesInAll"] = *now.framesInAll;
        if (share) line["share"] = *share;
        if (left) line["secondsLeft"] = *left;
        putLine(line);
        return;
    }
    std::string text = place_;
    if (share) {
        const int full = static_cast<int>(*share * kBarColumns);
        text += "[" + std::string(static_cast<std::size_t>(full), '#') +
                std::string(static_cast<std::size_t>(kBarColumns - full), '.') + "] ";
    }
    text += clockText(now.end);
    if (now.length) text += " of " + clockText(*now.length);
    text += ", frame " + std::to_string(now.frames) + ", " + fixed(pace_.rate(), 1) + " fps";
    if (left) text += ", " + clockText(*left) + " left";
    showStatus(text);
}

nlohmann::ordered_json VideoProgressLine::stateLine(const std::string& state) const {
    const VideoProgress& now = pace_.now();
    return {{"state", state},
            {"frames", now.frames},
            {"time", now.end},
            {"framesPerSecond", pace_.rate()}};
}

void VideoProgressLine::putLine(nlohmann::ordered_json line) const {
    if (!input_.empty()) line["input"] = input_;
    writeProgress(line);
}

void VideoProgressLine::end(const std::string& state) {
    clear();
    if (json_) putLine(stateLine(state));
}

} // namespace altiro3D::tools
