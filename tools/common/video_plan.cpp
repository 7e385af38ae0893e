#include "common/video_plan.hpp"

#include "altiro3D/video_io.hpp"
#include "common/video_options.hpp"

#include <algorithm>
#include <array>
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
        const std::string in = pair ? "IN DEPTH" : "IN";
        commandLine.failNames(show ? in : in + (pair ? " OUT" : " and OUT"), expected);
    }
    VideoPlan plan;
    plan.input = names.front();
    plan.show = show;
    if (!show) plan.output = names.back();
    if (pair) plan.depth = names[1];
    if (const auto depth = commandLine.value("depth")) plan.depth = *depth;
    plan.report = commandLine.value("report").value_or("");
    commandLine.exclude("quilt-out", "rgbd-out");
    if (commandLine.has("quilt-out")) plan.product = VideoProduct::Quilt;
    if (commandLine.has("rgbd-out")) plan.product = VideoProduct::Rgbd;
    plan.fromQuilt = commandLine.has("from-quilt");
    if (plan.fromQuilt) {
        for (const char* option : {"quilt-out",    "rgbd-out",    "d",       "depth",
                                   "rgbd",         "n",           "l",       "net-profile",
                                   "network-size", "depth-every", "k",       "g",
                                   "method",       "continuous",  "best",    "strength",
                                   "focus",        "fill",        "borders", "refine",
                                   "inpaint-from", "exact-depth"})
            commandLine.exclude("from-quilt", option);
    }
    plan.part = videoReaderOptions(commandLine);
    if (show) {
        for (const char* option :
             {"quilt-out", "rgbd-out", "resume", "codec", "crf", "preset", "compat", "progress"})
            commandLine.exclude("show", option);
        return plan;
    }
    if (takesFolder(commandLine)) return plan;
    requireVideoName(plan.output);
    std::error_code error;
    plan.isFile = fs::is_regular_file(plan.input, error);
    return plan;
}

bool takesFolder(const CommandLine& commandLine) {
    const std::vector<fs::path>& names = commandLine.files();
    std::error_code error;
    return names.size() == 2 && fs::is_directory(names.front(), error);
}

void addCommonInputs(const CommandLine& commandLine, const ChosenDisplay& display,
                     Outputs& outputs) {
    for (const fs::path& file : display.files)
        outputs.addInput(file);
    for (const char* option : {"n", "net-profile"}) {
        if (const auto file = commandLine.value(option)) outputs.addInput(*file);
    }
}

void checkOutputs(const CommandLine& commandLine, const VideoPlan& plan,
                  const ChosenDisplay& display) {
    if (plan.isChecked) return;
    if (commandLine.has("resume") && !plan.isFile) {
        throw UsageError("--resume reads the input again, expected a file, not " +
                         plan.inputName());
    }
    // The interrupted run may have left these files; without any, --resume starts a new run.
    std::error_code error;
    const bool goesOn =
        commandLine.has("resume") && !plan.show && ResumableVideoWriter::isUnfinished(plan.output);
    Outputs outputs(commandLine.has("y") || goesOn);
    if (commandLine.has("resume") && !goesOn)
        outputs.explainExisting(plan.output,
                                "and no unfinished run of it is kept, so it may be complete");
    addCommonInputs(commandLine, display, outputs);
    for (const fs::path& file : {plan.input, plan.depth}) {
        if (!file.empty() && file != "-") outputs.addInput(file);
    }
    if (!plan.show) outputs.addOutput(plan.output);
    if (!plan.report.empty()) outputs.addOutput(plan.report);
    outputs.check();
}

RunSettings settingsOf(const CommandLine& commandLine) {
    RunSettings settings;
    for (const auto& [option, value] : commandLine.given()) {
        // The last four are left out because their effect is compared, not their text.
        constexpr std::array<const char*, 12> kOthers = {
            "y", "v", "resume", "recursive", "progress", "report", "plan", "chunk-seconds",
            "c", "m", "serial", "j"};
        if (std::find(kOthers.begin(), kOthers.end(), option) != kOthers.end()) continue;
        settings["-" + std::string(option.size() > 1 ? "-" : "") + option] = value;
    }
    return settings;
}

} // namespace altiro3D::tools
