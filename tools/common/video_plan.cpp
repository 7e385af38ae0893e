#include "common/video_plan.hpp"

#include "altiro3D/altiro3D.hpp"
#include "common/outputs.hpp"
#include "common/video_options.hpp"

#include <QCryptographicHash>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

std::string shortText(const QCryptographicHash& hash) {
    return hash.result().toHex().left(16).toStdString();
}

// Tells a file, or a directory of pictures, from a later state of it.
std::string stampOf(const fs::path& path) {
    std::error_code error; // opening it reports what is wrong
    const auto stamp = [&](const fs::path& file) {
        const std::uintmax_t bytes = fs::file_size(file, error);
        const auto time = fs::last_write_time(file, error).time_since_epoch().count();
        return std::to_string(bytes) + " bytes of " + std::to_string(time);
    };
    if (!fs::is_directory(path, error)) return stamp(path);
    QCryptographicHash all(QCryptographicHash::Sha256);
    const std::vector<fs::path> files = listPictures(path);
    for (const fs::path& file : files) // the name decides which frame it belongs to
        all.addData(
            QByteArray::fromStdString(file.filename().string() + '\0' + stamp(file) + '\n'));
    return std::to_string(files.size()) + " files, " + shortText(all);
}

std::string contentsOf(const NativeLut& map) {
    QCryptographicHash all(QCryptographicHash::Sha256);
    for (int colour = 0; colour < 3; ++colour) {
        const cv::Mat& table = map.channel(colour);
        const std::size_t bytes = static_cast<std::size_t>(table.cols) * table.elemSize();
        for (int y = 0; y < table.rows; ++y)
            all.addData(table.ptr<char>(y), static_cast<int>(bytes));
    }
    return shortText(all);
}

// What a network makes of pictures, besides what its file holds.
std::string feedingOf(const DepthNetwork& network) {
    const NetworkProfile& profile = network.profile();
    const Json fields = {{"size", sizeText(network.inputSize())},
                         {"channels", profile.channelOrder},
                         {"scale", profile.scale},
                         {"mean", profile.mean},
                         {"std", profile.std},
                         {"resize", static_cast<int>(profile.resizeKernel)},
                         {"output", static_cast<int>(profile.output)},
                         {"processor", static_cast<int>(network.target())}};
    return fields.dump();
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
    commandLine.exclude("quilt-out", "rgbd-out");
    if (commandLine.has("quilt-out")) plan.product = VideoProduct::Quilt;
    if (commandLine.has("rgbd-out")) plan.product = VideoProduct::Rgbd;
    plan.fromQuilt = commandLine.has("from-quilt");
    if (plan.fromQuilt) {
        for (const char* option :
             {"quilt-out",   "rgbd-out", "d",           "depth",        "rgbd",
              "n",           "l",        "net-profile", "network-size", "depth-every",
              "k",           "g",        "method",      "continuous",   "best",
              "strength",    "focus",    "soft-edges",  "fill",         "refine",
              "inpaint-from"})
            commandLine.exclude("from-quilt", option);
    }
    plan.part = videoReaderOptions(commandLine);
    if (show) {
        for (const char* option :
             {"quilt-out", "rgbd-out", "resume", "codec", "crf", "preset", "compat", "progress"})
            commandLine.exclude("show", option);
        return plan;
    }
    requireVideoName(plan.output);
    std::error_code error;
    plan.isFile = fs::is_regular_file(plan.input, error);
    return plan;
}

void checkOutputs(const CommandLine& commandLine, const VideoPlan& plan,
                  const ChosenDisplay& display) {
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
                         const QuiltLayout& layout, const ChosenDisplay& display,
                         const ChosenDepth* source) {
    Json settings = Json::object();
    if (!plan.isFile) return settings.dump();
    for (const auto& [option, value] : commandLine.given()) {
        // What the last ones choose is below.
        constexpr std::array<const char*, 9> kOthers = {"y", "v", "resume", "progress", "report",
                                                        "c", "m", "serial", "j"};
        if (std::find(kOthers.begin(), kOthers.end(), option) != kOthers.end()) continue;
        settings["-" + std::string(option.size() > 1 ? "-" : "") + option] = value;
    }
    settings["video"] = stampOf(plan.input);
    if (!plan.depth.empty()) settings["depth video"] = stampOf(plan.depth);
    if (source != nullptr) settings["depth"] = source->description();
    if (source != nullptr && source->network() != nullptr) {
        settings["network"] = stampOf(source->network()->file());
        settings["network profile"] = feedingOf(*source->network());
    }
    settings["quilt"] = layout.text(); // the model's own is chosen by the serial
    if (plan.fromQuilt) {              // a file's name may state it
        const auto name = parseQuiltName(plan.input);
        settings["shape of the views"] =
            name && name->aspect ? fixed(*name->aspect, 6) : std::string("not stated");
    }
    if (display.map) settings["map"] = contentsOf(*display.map);
    settings["display"] = fingerprintText(display.map ? display.map->calibrationFingerprint()
                                                      : fingerprint(display.calibration));
    settings["threads"] = std::to_string(cv::getNumThreads()); // encoders divide frames by them
    settings["version"] = version();
    return settings.dump(-1, ' ', false, Json::error_handler_t::replace);
}

} // namespace altiro3D::tools
