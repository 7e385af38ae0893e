#include "common/video_plan.hpp"

#include "altiro3D/altiro3D.hpp"
#include "common/outputs.hpp"
#include "common/video_options.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

// Tells a file, or a directory of pictures, from a later state of it.
std::string stampOf(const fs::path& path) {
    std::uintmax_t files = 0;
    std::uintmax_t bytes = 0;
    fs::file_time_type newest = fs::file_time_type::min();
    std::error_code error; // whoever opens it says what is wrong
    const auto add = [&](const fs::path& file) {
        ++files;
        bytes += fs::file_size(file, error);
        newest = std::max(newest, fs::last_write_time(file, error));
    };
    if (fs::is_directory(path, error)) {
        for (const fs::path& file : listPictures(path))
            add(file);
    } else {
        add(path);
    }
    return (files == 1 ? "" : std::to_string(files) + " files, ") + std::to_string(bytes) +
           " bytes of " + std::to_string(newest.time_since_epoch().count());
}

} // namespace

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
    commandLine.exclude("quilt", "rgbd-out");
    if (commandLine.has("quilt")) plan.product = VideoProduct::Quilt;
    if (commandLine.has("rgbd-out")) plan.product = VideoProduct::Rgbd;
    plan.fromQuilt = commandLine.has("from-quilt");
    if (plan.fromQuilt) {
        for (const char* option :
             {"quilt",    "rgbd-out", "d",           "depth",        "rgbd",
              "n",        "l",        "net-profile", "network-size", "depth-every",
              "k",        "g",        "method",      "continuous",   "best",
              "strength", "focus",    "dilate",      "soft-edges",   "fill",
              "refine",   "inpaint",  "inpaint-from"})
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
    plan.isFile = fs::is_regular_file(plan.input, error);
    return plan;
}

void checkOutputs(const CommandLine& commandLine, const VideoPlan& plan, const Display& display) {
    if (commandLine.has("resume") && !plan.isFile) {
        throw UsageError("--resume reads the input once more, expected a file, not " +
                         plan.inputName());
    }
    // What --resume goes on with may have left these files; where nothing is left it is a new run.
    std::error_code error;
    const bool goesOn =
        commandLine.has("resume") && !plan.show && ResumableVideoWriter::isUnfinished(plan.output);
    Outputs outputs(commandLine.has("y") || goesOn);
    if (commandLine.has("resume") && !goesOn)
        outputs.explainExisting(plan.output,
                                "and no unfinished run of it is kept, so it may be complete");
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
                         const QuiltLayout& layout, const Display& display,
                         const DepthSource* source) {
    Json settings = Json::object();
    if (!plan.isFile) return settings.dump();
    for (const auto& [option, value] : commandLine.given()) {
        const bool shapes = option != "y" && option != "v" && option != "resume" &&
                            option != "progress" && option != "report" && option != "c" &&
                            option != "serial"; // the display's own is below
        if (shapes) settings["-" + std::string(option.size() > 1 ? "-" : "") + option] = value;
    }
    settings["video"] = stampOf(plan.input);
    if (!plan.depth.empty()) settings["depth video"] = stampOf(plan.depth);
    if (source != nullptr) settings["depth"] = source->description();
    if (source != nullptr && source->network() != nullptr)
        settings["network"] = stampOf(source->network()->file());
    if (const auto profile = commandLine.value("net-profile"))
        settings["network profile"] = stampOf(*profile);
    settings["quilt"] = layout.text(); // the model's own is chosen by the serial
    settings["display"] =
        fingerprintText(display.calibration ? fingerprint(*display.calibration)
                                            : display.map->calibrationFingerprint());
    settings["version"] = version();
    return settings.dump(-1, ' ', false, Json::error_handler_t::replace);
}

} // namespace altiro3D::tools
