#include "common/video_plan.hpp"

#include "altiro3D/altiro3D.hpp"
#include "common/outputs.hpp"
#include "common/video_options.hpp"

#include <nlohmann/json.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

VideoPlan planVideo(const CommandLine& commandLine) {
    const std::vector<fs::path>& names = commandLine.files();
    const bool pair = commandLine.has("d");
    const bool show = commandLine.has("show");
    const std::size_t expected = (pair ? 3 : 2) - (show ? 1 : 0);
    if (names.size() != expected) {
        throw UsageError(std::string("expected ") + (pair ? "IN DEPTH" : "IN") +
                         (show   ? ""
                          : pair ? " OUT"
                                 : " and OUT") +
                         ", got " + std::to_string(names.size()) +
                         " names; see video2native --help");
    }
    VideoPlan plan;
    plan.input = names.front();
    plan.show = show;
    if (!show) plan.output = names.back();
    if (pair) plan.depth = names[1];
    if (const auto depth = commandLine.value("depth")) plan.depth = *depth;
    plan.report = commandLine.value("report").value_or("");
    commandLine.exclude("quilt", "rgbd-out");
    if (commandLine.has("quilt")) plan.product = VideoProduct::Quilt;
    if (commandLine.has("rgbd-out")) plan.product = VideoProduct::Rgbd;
    plan.fromQuilt = commandLine.has("from-quilt");
    if (plan.fromQuilt) {
        for (const char* option :
             {"quilt", "rgbd-out", "d", "depth", "rgbd", "n", "l", "net-profile", "network-size",
              "depth-every", "k", "g", "method", "continuous", "strength", "focus"})
            commandLine.exclude("from-quilt", option);
    }
    plan.part = videoReaderOptions(commandLine);
    if (show) {
        for (const char* option :
             {"quilt", "rgbd-out", "resume", "codec", "crf", "preset", "compat", "progress"})
            commandLine.exclude("show", option);
        return plan;
    }
    requireVideoName(plan.output);
    std::error_code error;
    plan.resumable = fs::is_regular_file(plan.input, error) && plan.part.format.empty();
    if (commandLine.has("resume") && !plan.resumable) {
        throw UsageError("--resume reads IN once more, expected a file, not " +
                         plan.input.string());
    }
    return plan;
}

void checkOutputs(const CommandLine& commandLine, const VideoPlan& plan, const Display& display) {
    Outputs outputs(commandLine.has("y") || commandLine.has("resume"));
    for (const fs::path& file : display.files)
        outputs.addInput(file);
    for (const fs::path& file : {plan.input, plan.depth}) {
        if (!file.empty() && file != "-") outputs.addInput(file);
    }
    for (const char* option : {"n", "net-profile"}) {
        if (const auto file = commandLine.value(option)) outputs.addInput(*file);
    }
    if (!plan.show) outputs.addOutput(plan.output);
    if (!plan.report.empty()) outputs.addOutput(plan.report);
    outputs.check();
}

std::string settingsText(const CommandLine& commandLine, const VideoPlan& plan,
                         const Display& display) {
    Json settings = Json::object();
    if (!plan.resumable) return settings.dump();
    for (const auto& [option, value] : commandLine.given()) {
        const bool shapes = option != "y" && option != "v" && option != "resume" &&
                            option != "progress" && option != "report";
        if (shapes) settings["-" + std::string(option.size() > 1 ? "-" : "") + option] = value;
    }
    for (const fs::path& file : {plan.input, plan.depth}) {
        if (file.empty() || fs::is_directory(file)) continue;
        settings[file.filename().string()] =
            std::to_string(fs::file_size(file)) + " bytes of " +
            std::to_string(fs::last_write_time(file).time_since_epoch().count());
    }
    settings["display"] =
        fingerprintText(display.calibration ? fingerprint(*display.calibration)
                                            : display.map->calibrationFingerprint());
    settings["version"] = ALTIRO3D_VERSION;
    return settings.dump(-1, ' ', false, Json::error_handler_t::replace);
}

} // namespace altiro3D::tools
