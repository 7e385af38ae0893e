#include "common/video_progress.hpp"

#include "common/console.hpp"
#include "common/video_options.hpp"

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

void VideoProgress::add(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"progress"},
        "bar (default: a line on a terminal) or json (one object a line on standard "
        "output, for programs).",
        "bar|json");
}

bool VideoProgress::json(const CommandLine& commandLine) {
    return commandLine.choice("progress", {"bar", "json"}).value_or(0) == 1;
}

VideoProgress::VideoProgress(bool json, std::optional<std::int64_t> frames,
                             std::optional<double> seconds, std::int64_t done, double doneTime)
    : json_(json), frames_(frames), seconds_(seconds), before_(done), time_(doneTime) {}

VideoProgress::~VideoProgress() {
    clear();
}

void VideoProgress::frame(double end) {
    ++done_;
    time_ = end;
    if (firstTime_ < 0) firstTime_ = end;
    const Clock::time_point now = Clock::now();
    if (shown_ != Clock::time_point{} && between(shown_, now) < kStepSeconds) return;
    shown_ = now;
    show();
}

void VideoProgress::show() {
    if (!json_ && !hasStatusLine()) return;
    const double spent = between(start_, Clock::now());
    std::optional<double> share; // of all
    std::optional<double> left;  // s
    if (seconds_ && *seconds_ > 0) {
        share = std::clamp(time_ / *seconds_, 0.0, 1.0);
        const double made = time_ - firstTime_;
        if (made > 0) left = spent * std::max(*seconds_ - time_, 0.0) / made;
    }
    if (json_) {
        nlohmann::ordered_json line = {{"state", "running"},
                                       {"frames", before_ + done_},
                                       {"time", time_},
                                       {"framesPerSecond", rate()}};
        if (frames_) line["framesInAll"] = *frames_;
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
    text += clockText(time_);
    if (seconds_) text += " of " + clockText(*seconds_);
    char numbers[64];
    std::snprintf(numbers, sizeof numbers, ", frame %lld, %.1f fps",
                  static_cast<long long>(before_ + done_), rate());
    text += numbers;
    if (left) text += ", " + clockText(*left) + " left";
    showStatus(text);
}

double VideoProgress::rate() const {
    const double spent = between(start_, Clock::now());
    return spent > 0 ? static_cast<double>(done_) / spent : 0;
}

void VideoProgress::putLine(const std::string& state) const {
    const nlohmann::ordered_json line = {{"state", state},
                                         {"frames", before_ + done_},
                                         {"time", time_},
                                         {"framesPerSecond", rate()}};
    writeLine(stdout, line.dump());
}

void VideoProgress::finishing() {
    if (json_) {
        putLine("finishing");
    } else {
        showStatus("finishing the file ...");
    }
}

void VideoProgress::end(const std::string& state) {
    clear();
    if (json_) putLine(state);
}

void VideoProgress::clear() {
    clearStatus();
}

} // namespace altiro3D::tools
