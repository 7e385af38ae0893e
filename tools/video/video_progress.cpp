#include "video/video_progress.hpp"

#include <algorithm>
#include <cstdio>
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

VideoProgressLine::VideoProgressLine(bool json, const VideoProgress& start, std::string input,
                                     std::string place)
    : json_(json), input_(std::move(input)), place_(std::move(place)), now_(start) {}

VideoProgressLine::~VideoProgressLine() {
    clear();
}

void VideoProgressLine::update(const VideoProgress& now) {
    const bool isFrame = now.frames > now_.frames;
    now_ = now;
    if (now.finishing) {
        if (json_) {
            putLine(stateLine("finishing"));
        } else {
            showStatus(place_ + "finishing the file ...");
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
        nlohmann::ordered_json line = stateLine("running");
        if (now_.framesInAll) line["framesInAll"] = *now_.framesInAll;
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

nlohmann::ordered_json VideoProgressLine::stateLine(const std::string& state) const {
    return {
        {"state", state}, {"frames", now_.frames}, {"time", now_.end}, {"framesPerSecond", rate()}};
}

void VideoProgressLine::putLine(nlohmann::ordered_json line) const {
    if (!input_.empty()) line["input"] = input_;
    writeLine(stdout, line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

void VideoProgressLine::end(const std::string& state) {
    clear();
    if (json_) putLine(stateLine(state));
}

} // namespace altiro3D::tools
