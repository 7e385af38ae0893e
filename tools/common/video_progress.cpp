#include "common/video_progress.hpp"

#include "common/console.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace altiro3D::tools {

namespace {

constexpr double kStepSeconds = 0.25;
constexpr int kBarColumns = 24;

using Clock = std::chrono::steady_clock;

double between(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
}

} // namespace

void VideoProgressLine::add(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"progress"},
        "Show the progress as bar (default: a line on a terminal) or json (one object per line "
        "on standard output, for programs).",
        "bar|json");
}

bool VideoProgressLine::json(const CommandLine& commandLine) {
    return commandLine.choice("progress", {"bar", "json"}).value_or(0) == 1;
}

VideoProgressLine::VideoProgressLine(bool json, const VideoProgress& start)
    : json_(json), now_(start) {}

VideoProgressLine::~VideoProgressLine() {
    clear();
}

void VideoProgressLine::update(const VideoProgress& now) {
    const bool isFrame = now.frames > now_.frames;
    now_ = now;
    if (now.finishing) {
        if (json_) {
            putLine("finishing");
        } else {
            showStatus("finishing the file ...");
        }
        return;
    }
    if (!isFrame) return;
    if (firstTime_ < 0) firstTime_ = now.end;
    const Clock::time_point time = Clock::now();
    if (shown_ != Clock::time_point{} && between(shown_, time) < kStepSeconds) return;
    shown_ = time;
    show();
}

void VideoProgressLine::show() {
    if (!json_ && !hasStatusLine()) return;
    const double spent = between(start_, Clock::now());
    std::optional<double> share; // of all
    std::optional<double> left;  // s
    if (now_.length && *now_.length > 0) {
        share = std::clamp(now_.end / *now_.length, 0.0, 1.0);
        const double made = now_.end - firstTime_;
        if (made > 0) left = spent * std::max(*now_.length - now_.end, 0.0) / made;
    }
    if (json_) {
        nlohmann::ordered_json line = {{"state", "running"},
                                       {"frames", now_.frames},
                                       {"time", now_.end},
                                       {"framesPerSecond", rate()}};
        if (now_.framesInAll) line["framesInAll"] = *now_.framesInAll;
        if (share) line["share"] = *share;
        if (left) line["secondsLeft"] = *left;
        writeLine(stdout, line.dump());
        return;
    }
    std::string text;
    if (share) {
        const int full = static_cast<int>(*share * kBarColumns);
        text += "[" + std::string(static_cast<std::size_t>(full), '#') +
                std::string(static_cast<std::size_t>(kBarColumns - full), '.') + "] ";
    }
    text += clockText(now_.end);
    if (now_.length) text += " of " + clockText(*now_.length);
    char numbers[64];
    std::snprintf(numbers, sizeof numbers, ", frame %lld, %.1f fps",
                  static_cast<long long>(now_.frames), rate());
    text += numbers;
    if (left) text += ", " + clockText(*left) + " left";
    showStatus(text);
}

double VideoProgressLine::rate() const {
    const double spent = between(start_, Clock::now());
    return spent > 0 ? static_cast<double>(now_.frames - now_.keptFrames) / spent : 0;
}

void VideoProgressLine::putLine(const std::string& state) const {
    const nlohmann::ordered_json line = {
        {"state", state}, {"frames", now_.frames}, {"time", now_.end}, {"framesPerSecond", rate()}};
    writeLine(stdout, line.dump());
}

void VideoProgressLine::end(const std::string& state) {
    clear();
    if (json_) putLine(state);
}

void VideoProgressLine::clear() {
    clearStatus();
}

} // namespace altiro3D::tools
