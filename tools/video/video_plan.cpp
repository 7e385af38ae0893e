#include "video/video_plan.hpp"

#include "altiro3D/video_io.hpp"
#include "video/video_progress.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

// Whether the input is a folder of videos.
bool takesFolder(const CommandLine& commandLine) {
    const std::vector<fs::path>& names = commandLine.files();
    std::error_code error;
    return names.size() == 2 && fs::is_directory(names.front(), error);
}

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
        for (const char* option : {"quilt-out", "rgbd-out", "resume", "codec", "crf", "preset",
                                   "max-rate", "compat", "progress"})
            commandLine.exclude("show", option);
        return plan;
    }
    if (takesFolder(commandLine)) return plan;
    requireVideoName(plan.output);
    std::error_code error;
    plan.isFile = fs::is_regular_file(plan.input, error);
    return plan;
}

std::optional<DepthRange> depthRangeOption(const CommandLine& commandLine) {
    const auto text = commandLine.value("depth-range");
    if (!text) return std::nullopt;
    if (!commandLine.has("depth") && !commandLine.has("d"))
        throw UsageError("--depth-range goes with --depth, expected a depth video or images");
    DepthRange range;
    char rest = 0;
    const bool isRead =
        std::sscanf(text->c_str(), "%lf:%lf%c", &range.low, &range.high, &rest) == 2;
    if (!isRead || !(range.low >= 0) || !(range.high > range.low) || !(range.high <= 65535)) {
        throw UsageError("--depth-range is \"" + *text +
                         "\", expected two numbers of 0..65535, as 0:4095");
    }
    return range;
}

RunSettings settingsOf(const std::vector<std::pair<std::string, std::string>>& given) {
    RunSettings settings;
    for (const auto& [option, value] : given) {
        // The last four are left out because their effect is compared, not their text.
        constexpr std::array<const char*, 12> kOthers = {
            "y", "v", "resume", "recursive", "progress", "report", "plan", "chunk-seconds",
            "c", "m", "serial", "j"};
        if (std::find(kOthers.begin(), kOthers.end(), option) != kOthers.end()) continue;
        settings["-" + std::string(option.size() > 1 ? "-" : "") + option] = value;
    }
    return settings;
}

} // namespace

VideoJob videoJob(const CommandLine& commandLine) {
    const bool isFolder = takesFolder(commandLine);
    for (const char* option : {"show", "d", "depth"}) {
        if (isFolder && commandLine.has(option)) {
            throw UsageError((option[1] == '\0' ? "-" : "--") + std::string(option) +
                             " applies to one video, expected a single video instead of a folder");
        }
    }
    VideoJob job = videoJob(commandLine, planVideo(commandLine));
    job.isFolder = isFolder;
    return job;
}

VideoJob videoJob(const CommandLine& commandLine, const VideoPlan& plan) {
    VideoJob job;
    job.plan = plan;
    job.tool = commandLine.name();
    job.replace = commandLine.has("y");
    job.resume = commandLine.has("resume");
    job.recursive = commandLine.has("recursive");
    job.jsonProgress = VideoProgressLine::json(commandLine);
    job.isPreview = commandLine.has("preview");
    job.isMaxRateGiven = commandLine.has("max-rate");
    job.profile = videoProfile(commandLine, plan.show);
    job.scene = sceneOptions(commandLine, AutoUse::Named, job.profile.method);
    NativeOptions& native = job.scene.native;
    if ((native.framing != Framing() || job.scene.choices.any()) &&
        (plan.fromQuilt || plan.product == VideoProduct::Rgbd)) {
        throw UsageError(
            std::string(
                "--center, --zoom and auto apply to views that are made of frames, expected no ") +
            (plan.fromQuilt ? "--from-quilt" : "--rgbd-out") + " with them");
    }
    if (job.profile.keep) native.detail = Detail::Panel;
    if (plan.product != VideoProduct::Native) native.positions = ViewPositions::Discrete;
    if (commandLine.has("fit")) job.fit = native.fit;
    job.display = displayOptions(commandLine);
    job.screen = commandLine.value("screen").value_or("");
    job.quilt = quiltRequest(commandLine);
    job.encoding = encoderOptions(commandLine, job.profile);
    if (!plan.fromQuilt) {
        job.depth = depthOptions(commandLine, Medium::Video);
        job.depthRange = depthRangeOption(commandLine);
        const auto every = commandLine.value("depth-every");
        const bool isGiven = !job.depth.given.empty();
        job.depthOptions.every = isGiven ? 1 : job.profile.depthEvery;
        if (every) {
            job.depthOptions.every =
                *every == "auto" ? 0 : *commandLine.wholeNumber("depth-every", 1, 1000);
            if (isGiven)
                throw UsageError("--depth-every says how often depth is estimated, but here it is "
                                 "given; leave it out");
        }
    }
    job.given = commandLine.given();
    job.settings = settingsOf(job.given);
    return job;
}

void checkOutputs(const VideoJob& job, const VideoPlan& plan, const ChosenDisplay& display) {
    if (plan.isChecked) return;
    if (job.resume && !plan.isFile) {
        throw UsageError("--resume reads the input again, expected a file, not " +
                         plan.inputName());
    }
    // The interrupted run may have left these files; without any, --resume starts a new run.
    std::error_code error;
    const bool goesOn = job.resume && !plan.show && isVideoUnfinished(plan.output);
    Outputs outputs(job.replace || goesOn);
    if (job.resume && !goesOn)
        outputs.explainExisting(plan.output,
                                "and no unfinished run of it is kept, so it may be complete");
    outputs.addInputs(display.files);
    outputs.addInputs({job.depth.network, job.depth.profile});
    if (plan.input != "-") outputs.addInputs({plan.input});
    if (plan.depth != "-") outputs.addInputs({plan.depth});
    if (!plan.show) outputs.addOutputs({plan.output});
    outputs.addOutputs({plan.report});
    outputs.check();
}

} // namespace altiro3D::tools
