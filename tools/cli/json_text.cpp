#include "cli/json_text.hpp"

#include "altiro3D/file_io.hpp"
#include "altiro3D/version.hpp"
#include "cli/run_tool.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace altiro3D::tools {

using Json = nlohmann::ordered_json;

namespace {

bool hasWrittenProgress = false;

void roundNumbers(Json& value) {
    if (value.is_structured()) {
        for (Json& part : value)
            roundNumbers(part);
        return;
    }
    if (!value.is_number_float()) return;
    const double number = value.get<double>();
    const double size = std::abs(number);
    if (!(size > 0) || size >= 1e9) return; // also what is not finite
    constexpr int kSignificant = 6;
    constexpr int kLeast = 3;
    constexpr int kMost = 12;
    const int whole = static_cast<int>(std::floor(std::log10(size))) + 1;
    // dump() writes about one number in a thousand with too many digits: 1.5213699999999999
    constexpr std::size_t kLong = 16;
    for (int decimals = std::clamp(kSignificant - whole, kLeast, kMost); decimals > 0; --decimals) {
        const double unit = std::pow(10.0, decimals);
        value = std::round(number * unit) / unit;
        if (value.dump().size() < kLong) return;
    }
}

} // namespace

std::string jsonText(Json value, int indent) {
    roundNumbers(value);
    return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

void addProgressOption(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"progress"},
        "Show the progress as bar (default: a line on a terminal) or json (one object per line "
        "on standard output, for programs).",
        "bar|json");
}

bool wantsJsonProgress(const CommandLine& commandLine) {
    constexpr std::pair<const char*, bool> kWords[] = {{"bar", false}, {"json", true}};
    bool isJson = false;
    commandLine.take({{"progress", isJson, kWords}});
    return isJson;
}

void writeProgress(const Json& line) {
    hasWrittenProgress = true;
    writeLine(stdout, jsonText(line));
}

void tellEarlyFailure(const CommandLine& commandLine, const std::exception& error) {
    if (hasWrittenProgress || !wantsJsonProgress(commandLine)) return;
    writeProgress(
        {{"state", stateName(kExitFailed)}, {"error", sentenceOf(error)}, {"code", codeOf(error)}});
}

void outdateReport(const CommandLine& commandLine, const std::string& before, int exitStatus,
                   const std::exception* error) try {
    std::filesystem::path file;
    bool mayReplace = false;
    commandLine.take({{"report", file},
                      {"y", mayReplace},
                      {"resume", mayReplace},
                      {"skip-existing", mayReplace}});
    if (!mayReplace || !isFile(file)) return;
    const Json old = Json::parse(readFile(file, std::size_t{1} << 28));
    if (old.at("tool") != commandLine.name()) return;
    if (fileStamp(file) != before && old.value("state", "") != stateName(kExitDone)) return;
    Json json = {
        {"tool", commandLine.name()}, {"version", version()}, {"state", stateName(exitStatus)}};
    if (error != nullptr) {
        json["error"] = sentenceOf(*error);
        json["code"] = codeOf(*error);
    }
    writeFile(file, jsonText(json, 2) + "\n");
} catch (const std::exception&) { // another file, or one that cannot be written
}

Progress::Progress(std::size_t steps, std::string unit) : steps_(steps), unit_(std::move(unit)) {}

Progress::~Progress() {
    clear();
}

double Progress::secondsLeft() const {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start_;
    return spent.count() / static_cast<double>(done_) * static_cast<double>(steps_ - done_);
}

void Progress::step(const std::string& what, const std::filesystem::path& input) {
    if (!unit_.empty()) {
        Json line = {{"state", "running"},
                     {unit_ + "s", done_},
                     {unit_ + "sInAll", steps_},
                     {"share", static_cast<double>(done_) / static_cast<double>(steps_)}};
        if (done_ > 0) line["secondsLeft"] = secondsLeft();
        line["input"] = input.string();
        writeProgress(line);
    } else if (steps_ > 1) {
        std::string text = "[" + std::to_string(done_ + 1) + "/" + std::to_string(steps_) + "] ";
        if (done_ > 0) text += "(" + fixed(secondsLeft(), 0) + " s left) ";
        showStatus(text + oneLine(what));
    }
    ++done_;
}

void Progress::end(int exitStatus, std::size_t ended) {
    clear();
    if (!unit_.empty()) writeProgress({{"state", stateName(exitStatus)}, {unit_ + "s", ended}});
}

} // namespace altiro3D::tools
