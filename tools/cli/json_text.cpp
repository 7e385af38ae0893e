#include "cli/json_text.hpp"

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
    // of one number in a thousand dump() does not write the shortest text: 1.5213699999999999
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
    return commandLine.choice("progress", {"bar", "json"}).value_or(0) == 1;
}

void writeProgress(const Json& line) {
    hasWrittenProgress = true;
    writeLine(stdout, jsonText(line));
}

void tellEarlyFailure(const CommandLine& commandLine, const std::exception& error) {
    if (hasWrittenProgress || !commandLine.has("progress") || !wantsJsonProgress(commandLine))
        return;
    writeProgress(
        {{"state", stateName(kExitFailed)}, {"error", sentenceOf(error)}, {"code", codeOf(error)}});
}

} // namespace altiro3D::tools
