#include "common/video_report.hpp"

#include "altiro3D/version.hpp"
#include "common/picture_options.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace altiro3D::tools {

using Json = nlohmann::ordered_json;

namespace {

double millisecondsPerFrame(const StageReport& stage) {
    return 1000 * stage.seconds / std::max<double>(1, static_cast<double>(stage.frames));
}

Json stagesJson(const PipelineReport& report) {
    Json stages = Json::array();
    for (const StageReport& stage : report.stages) {
        stages.push_back({{"name", stage.name},
                          {"frames", stage.frames},
                          {"millisecondsPerFrame", millisecondsPerFrame(stage)},
                          {"longestMilliseconds", 1000 * stage.longest}});
    }
    return stages;
}

// What auto has chosen for each scene.
Json choicesJson(const VideoConversionResult& result) {
    Json scenes = Json::array();
    for (const SceneChoice& choice : result.choices) {
        scenes.push_back({{"start", choice.start},
                          {"center", {choice.framing.centre.x, choice.framing.centre.y}},
                          {"focus", choice.focus},
                          {"strengthPercent", choice.strengthPercent}});
    }
    return scenes;
}

Json settingsJson(const CommandLine& commandLine, const VideoJob& job) {
    Json settings = {
        {"profile", job.profile.name},
        {"display", job.display.source},
        {"quilt", job.layout.text()},
        {"encoder", {{"preset", presetName(job.encoding.preset)}, {"crf", job.encoding.crf}}}};
    if (job.depth) {
        const NativeOptions& native = job.native;
        settings["method"] = methodName(native.views.method);
        const AutoChoices choices = autoChoices(commandLine); // those are in "choices"
        if (!choices.strength) settings["strengthPercent"] = native.views.strengthPercent;
        if (!choices.focus) settings["focus"] = native.views.focus;
        settings["path"] = job.path;
        settings["continuous"] = native.positions == ViewPositions::Continuous;
        settings["depth"] = job.depth->description();
        settings["depthEvery"] = job.depthOptions.every; // 0: as pictures need it
        if (const DepthNetwork* network = job.depth->network()) {
            settings["networkSize"] = {network->inputSize().width, network->inputSize().height};
            settings["networkEngine"] = engineName(network->engine());
        }
    }
    for (const auto& [option, value] : commandLine.given())
        settings["given"][option] = value;
    return settings;
}

} // namespace

double VideoOutcome::rate() const {
    const double seconds = result.seconds();
    return seconds > 0 ? static_cast<double>(result.made()) / seconds : 0;
}

const char* VideoOutcome::state() const {
    return stopped ? "stopped" : cutOff.empty() ? "done" : "truncated";
}

std::string videoReport(const CommandLine& commandLine, const VideoJob& job,
                        const VideoOutcome& outcome, const Messages& messages) {
    const VideoConversionResult& result = outcome.result;
    const Json json = {{"tool", commandLine.name()},
                       {"version", version()},
                       {"openCv", CV_VERSION},
                       {"threads", cv::getNumThreads()},
                       {"input", job.plan.input.string()},
                       {"output", job.plan.output.string()},
                       {"state", outcome.state()},
                       {"width", outcome.size.width},
                       {"height", outcome.size.height},
                       {"frames", result.frames},
                       {"framesOfThisRun", result.made()},
                       {"duration", result.end},
                       {"seconds", result.seconds()},
                       {"finishSeconds", result.finishSeconds},
                       {"framesPerSecond", outcome.rate()},
                       {"stages", stagesJson(result.pipeline)},
                       {"inferences", result.inferences},
                       {"repeatedFrames", result.repeated},
                       {"droppedFrames", result.pipeline.dropped},
                       {"sceneCuts", result.cuts},
                       {"choices", choicesJson(result)},
                       {"corruptFrames", result.counts.corrupt},
                       {"repairedTimes", result.counts.repairedTimes},
                       {"truncated", result.counts.truncated},
                       {"peakMegabytes", peakMegabytes()},
                       {"settings", settingsJson(commandLine, job)},
                       {"warnings", messages.warnings()}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void tellVideoDetails(const VideoJob& job, const VideoOutcome& outcome, Messages& messages) {
    const VideoConversionResult& result = outcome.result;
    std::string times;
    for (const StageReport& stage : result.pipeline.stages) {
        times += (times.empty() ? "" : ", ") + stage.name + " " +
                 fixed(millisecondsPerFrame(stage), 1) + " ms";
    }
    messages.detail("a frame takes: " + times);
    if (!job.plan.show)
        messages.detail("finishing the file took " + fixed(result.finishSeconds, 1) + " s");
    if (job.depth) {
        messages.detail("depth was inferred for " + std::to_string(result.inferences) + " of " +
                        std::to_string(result.made()) + " frames, " +
                        std::to_string(result.cuts.size()) + " scene cuts, " +
                        std::to_string(result.repeated) + " repeated frames");
    }
    if (!job.plan.show && result.pipeline.dropped > 0) {
        messages.say(counted(result.pipeline.dropped, "frame") +
                     " came too fast and were left out");
    }
}

} // namespace altiro3D::tools
