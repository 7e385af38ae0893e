#include "video/video_run.hpp"

#include "altiro3D/enum_table.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/version.hpp"
#include "cli/folders.hpp"
#include "cli/json_text.hpp"
#include "cli/system.hpp"
#include "video/video_progress.hpp"

#include <QCoreApplication>
#include <QFile>
#include <QProcess>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace altiro3D::tools {

using Json = nlohmann::ordered_json;

namespace {

// Shows Natives on the display with altiro3Dview, which is installed beside the tool.
class DisplayPlayer {
  public:
    static constexpr int kCrashed = -1; // of end(): a signal ended the viewer

    DisplayPlayer(const VideoJob& job, const ChosenDisplay& display) {
        QStringList arguments{"--show", "-"};
        if (!display.isMapOnly && !display.files.empty()) { // the last file is the calibration
            arguments << "-c" << QFile::decodeName(display.files.back().string().c_str());
        }
        for (const auto& [option, value] :
             {std::pair("--serial", job.display.serial), std::pair("--screen", job.screen)}) {
            if (!value.empty()) arguments << option << QString::fromLocal8Bit(value.c_str());
        }
        viewer_.setProcessChannelMode(QProcess::ForwardedChannels);
        viewer_.start(QCoreApplication::applicationDirPath() + "/altiro3Dview", arguments);
        if (!viewer_.waitForStarted()) {
            throw Error(ErrorCode::NotFound, "altiro3Dview",
                        "cannot be started, expected it beside video2native");
        }
    }

    // Sends a Native [CV_8UC3, BGR] to the viewer and waits until all of it is written.
    // @return false if the viewer has ended
    bool show(const cv::Mat& native) {
        const std::string head =
            "P6\n" + std::to_string(native.cols) + " " + std::to_string(native.rows) + "\n255\n";
        cv::cvtColor(native, rgb_, cv::COLOR_BGR2RGB);
        const auto bytes = static_cast<qint64>(rgb_.total() * rgb_.elemSize());
        viewer_.write(head.data(), static_cast<qint64>(head.size()));
        viewer_.write(reinterpret_cast<const char*>(rgb_.data), bytes);
        while (viewer_.state() == QProcess::Running && viewer_.bytesToWrite() > 0)
            viewer_.waitForBytesWritten(100);
        return viewer_.state() == QProcess::Running;
    }

    // Waits until the viewer has ended. @return its exit status, or kCrashed
    int end() {
        viewer_.closeWriteChannel();
        viewer_.waitForFinished(-1);
        if (viewer_.exitStatus() == QProcess::NormalExit) return viewer_.exitCode();
        return kCrashed;
    }

  private:
    QProcess viewer_;
    cv::Mat rgb_;
};

double megabits(double bytes, double seconds) {
    return seconds > 0 ? 8e-6 * bytes / seconds : 0;
}

// Result of a run.
struct VideoOutcome {
    VideoConversionResult result;
    cv::Size size;        // of the pictures
    bool stopped = false; // by the user
    bool failed = false;  // of show(): altiro3Dview has said why
    std::string cutOff;   // warning that the input is cut off; empty if it is not
    double bytes = 0;     // of the file, with its sound; 0: standard output

    double framesPerSecond() const {
        const double seconds = result.seconds();
        return seconds > 0 ? static_cast<double>(result.made()) / seconds : 0;
    }
    double megabitsPerSecond() const { return megabits(bytes, result.end); }
    const char* state() const {
        return stopped ? "stopped" : cutOff.empty() ? "done" : "truncated";
    }
};

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

Json settingsJson(const VideoRun& run) {
    const VideoJob& job = run.job;
    Json settings = {{"profile", job.profile.name},
                     {"display", run.display.source},
                     {"quilt", run.layout.text()},
                     {"encoder",
                      {{"preset", presetName(run.job.encoding.preset)},
                       {"crf", run.job.encoding.crf},
                       {"maxRate", run.job.encoding.maxRate}}}};
    if (run.depth) {
        const NativeOptions& native = run.job.scene.recipe;
        settings["method"] = methodName(native.views.method);
        const AutoChoices& choices = job.scene.recipe.choices; // those are in "choices"
        if (!choices.strength) settings["strengthPercent"] = native.views.strengthPercent;
        if (!choices.focus) settings["focus"] = native.views.focus;
        settings["path"] = run.path;
        settings["continuous"] = native.positions == ViewPositions::Continuous;
        settings["depth"] = run.depth->description();
        settings["depthEvery"] = job.depthOptions.every; // 0: as pictures need it
        if (const DepthNetwork* network = run.depth->network()) {
            settings["networkSize"] = {network->inputSize().width, network->inputSize().height};
            settings["networkEngine"] = engineName(network->engine());
        }
    }
    for (const auto& [option, value] : job.given)
        settings["given"][option] = value;
    return settings;
}

// 0 means that a number is not known.
template <typename Number>
Json known(Number number) {
    return number > 0 ? Json(number) : Json(nullptr);
}

// Settings, counts and times of a run, for programs.
std::string videoReport(const VideoRun& run, const VideoOutcome& outcome,
                        const Messages& messages) {
    const VideoConversionResult& result = outcome.result;
    const Json json = {{"tool", run.job.tool},
                       {"version", version()},
                       {"openCv", CV_VERSION},
                       {"threads", cv::getNumThreads()},
                       {"input", run.job.input.string()},
                       {"output", run.job.output.string()},
                       {"state", outcome.state()},
                       {"width", outcome.size.width},
                       {"height", outcome.size.height},
                       {"frames", result.frames},
                       {"framesOfThisRun", result.made()},
                       {"duration", result.end},
                       {"seconds", result.seconds()},
                       {"finishSeconds", result.finishSeconds},
                       {"framesPerSecond", outcome.framesPerSecond()},
                       {"bytes", known(static_cast<std::int64_t>(outcome.bytes))},
                       {"megabitsPerSecond", known(outcome.megabitsPerSecond())},
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
                       {"settings", settingsJson(run)},
                       {"warnings", messages.warnings()}};
    return jsonText(json, 2) + "\n";
}

// The same of a run that has failed.
std::string failedReport(const VideoRun& run, const std::exception& error,
                         const Messages& messages) {
    const Json json = {{"tool", run.job.tool},
                       {"version", version()},
                       {"input", run.job.input.string()},
                       {"output", run.job.output.string()},
                       {"state", stateName(kExitFailed)},
                       {"error", sentenceOf(error)},
                       {"code", codeOf(error)},
                       {"warnings", messages.warnings()}};
    return jsonText(json, 2) + "\n";
}

// Says what a preview lets expect of the whole, what --max-rate did, and what plays the Natives of
// a large panel.
void tellRate(const VideoRun& run, const VideoOutcome& outcome, Messages& messages) {
    const double rate = outcome.megabitsPerSecond();
    const std::optional<double> whole = run.inputFacts.duration;
    if (run.job.isPreview && whole && outcome.result.end > 0) {
        messages.say("the whole video (" + clockText(*whole) + ") becomes about " +
                     bytesText(outcome.bytes * *whole / outcome.result.end) + " at this rate");
    }
    constexpr double kNear = 0.9;
    if (run.job.encoding.maxRate > 0 && rate > kNear * run.job.encoding.maxRate) {
        messages.say("the quality is lowered where it would take more than " +
                     fixed(run.job.encoding.maxRate, 0) +
                     " Mbit/s; --max-rate sets another limit, 0 none");
    }
    tellDecoding(run, rate, messages);
}

// The details of -v, and the number of frames that came too fast.
void tellVideoDetails(const VideoRun& run, const VideoOutcome& outcome, Messages& messages) {
    const VideoConversionResult& result = outcome.result;
    std::string times;
    for (const StageReport& stage : result.pipeline.stages) {
        times += (times.empty() ? "" : ", ") + stage.name + " " +
                 fixed(millisecondsPerFrame(stage), 1) + " ms";
    }
    messages.detail("a frame takes: " + times);
    if (!run.job.show)
        messages.detail("finishing the file took " + fixed(result.finishSeconds, 1) + " s");
    if (run.depth) {
        messages.detail("depth was inferred for " + std::to_string(result.inferences) + " of " +
                        std::to_string(result.made()) + " frames, " +
                        std::to_string(result.cuts.size()) + " scene cuts, " +
                        std::to_string(result.repeated) + " repeated frames");
    }
    if (!run.job.show && result.pipeline.dropped > 0) {
        messages.say(counted(result.pipeline.dropped, "frame") +
                     " came too fast and were left out");
    }
}

// Opens the output; errors about an earlier run name this tool's options.
VideoConverter openConverter(const VideoJob& job, VideoConversion conversion) {
    const UnfinishedRun unfinished = conversion.unfinished;
    const bool mayBeUnfinished = job.canReadAgain && unfinished == UnfinishedRun::Refuse;
    if (mayBeUnfinished && isVideoUnfinished(job.output)) {
        throw Error(ErrorCode::WriteFailed, job.output.string(),
                    "an unfinished run of it is kept in " +
                        unfinishedVideoDirectory(job.output).string() +
                        ", expected --resume to continue it, or -y to start again");
    }
    try {
        return VideoConverter(std::move(conversion));
    } catch (const Error& error) {
        const std::string text = error.what(); // "subject: problem"
        const bool isOfAnother =
            error.code() == ErrorCode::Mismatch || error.code() == ErrorCode::BadFormat;
        if (unfinished != UnfinishedRun::Resume || !isOfAnother ||
            text.rfind(job.output.string(), 0) != 0)
            throw;
        const std::size_t end = text.find(": ");
        throw Error(error.code(), text.substr(0, end), text.substr(end + 2) + "; -y begins again");
    }
}

// Reports remarks at the end.
void tellRemarks(const VideoRun& run, VideoOutcome& outcome, Messages& messages) {
    Notes notes = outcome.result.notes;
    if (outcome.result.counts.truncated && notes.front().code == NoteCode::CutOff) {
        outcome.cutOff = notes.front().text + "; the readable part was converted";
        notes.erase(notes.begin());
    }
    messages.warn(notes);
    const std::vector<SceneChoice>& choices = outcome.result.choices;
    ViewOptions views = run.job.scene.recipe.views;
    if (!choices.empty()) {
        views.focus = choices.front().focus;
        views.strengthPercent = choices.front().strengthPercent;
        const std::string first =
            choices.size() == 1 ? "" : " (first of " + std::to_string(choices.size()) + " scenes)";
        messages.say(
            "auto: " + autoText(run.job.scene.recipe.choices, choices.front().framing, views) +
            first);
    }
    if (!run.depth || run.job.product != VideoProduct::Native) return;
    const auto parallaxOf = [&] {
        return adjacentParallax(views, run.layout, run.display.panelSize(), {0, 1});
    };
    AdjacentParallax largest = parallaxOf();
    for (const SceneChoice& choice : choices) {
        views.focus = choice.focus;
        views.strengthPercent = choice.strengthPercent;
        if (parallaxOf().viewPixels > largest.viewPixels) largest = parallaxOf();
    }
    warnAboutParallax(largest, messages);
}

// Makes the file.
VideoOutcome convert(const VideoRun& run, VideoConversion conversion, Messages& messages) {
    const VideoJob& job = run.job;
    VideoConverter converter = openConverter(job, std::move(conversion));
    messages.warn(converter.notes());
    repeatEncoder(run.job.encoding); // the same bytes in every run
    const VideoProgress begun = converter.progress();
    if (begun.keptFrames > 0) {
        messages.say("continues at " + clockText(begun.end) +
                     "; already made: " + counted(begun.keptFrames, "frame"));
    } else if (run.job.resume) {
        messages.say("no earlier run was found; starts from the beginning");
    }
    VideoProgressLine progress(run.job.jsonProgress, begun,
                               job.isFromFolder ? job.input.string() : std::string(), job.place);
    VideoOutcome outcome;
    outcome.size = converter.size();
    try {
        outcome.result = converter.run([&progress](const VideoProgress& now) {
            progress.update(now);
            return !isStopWanted();
        });
        if (outcome.result.frames == 0) {
            throw Error(ErrorCode::BadFormat, job.inputName(),
                        "was stopped before the first frame");
        }
    } catch (...) {
        progress.end(stateName(kExitFailed));
        if (converter.keepsWork()) {
            messages.say("the frames so far are kept in " +
                         unfinishedVideoDirectory(job.output).string() + "; --resume continues");
        }
        throw;
    }
    outcome.stopped = outcome.result.cancelled;
    const bool isStream = isStandardStream(job.output);
    if (!isStream) outcome.bytes = static_cast<double>(std::filesystem::file_size(job.output));
    tellRemarks(run, outcome, messages);
    progress.end(outcome.state());
    constexpr const char* kProducts[] = {"Native", "quilt", "RGB-D", "stereo"};
    messages.say(job.outputName() + ": " + entryOf(kProducts, job.product) + " video, " +
                 sizeText(outcome.size) + ", " + counted(outcome.result.frames, "frame") + ", " +
                 clockText(outcome.result.end) +
                 (isStream ? "" : ", " + bytesAndRateText(outcome.bytes, outcome.result.end)) +
                 "; " + fixed(outcome.framesPerSecond(), 1) + " fps");
    if (!isStream) tellRate(run, outcome, messages);
    return outcome;
}

// Shows the video on the display at its own rate; late frames are dropped.
VideoOutcome show(const VideoRun& run, VideoConversion conversion, Messages& messages) {
    DisplayPlayer screen(run.job, run.display);
    conversion.show = [&screen](const cv::Mat& native) { return screen.show(native); };
    VideoConverter converter = openConverter(run.job, std::move(conversion));
    VideoOutcome outcome;
    outcome.size = converter.size();
    outcome.result = converter.run([](const VideoProgress&) { return !isStopWanted(); });
    const int status = screen.end();
    outcome.stopped = isStopWanted();
    if (status == DisplayPlayer::kCrashed && !outcome.stopped) {
        throw Error(ErrorCode::WriteFailed, "altiro3Dview",
                    "ended unexpectedly, expected it to show the video");
    }
    outcome.failed = status != kExitDone && !outcome.stopped; // altiro3Dview has reported why
    if (outcome.failed) return outcome;
    tellRemarks(run, outcome, messages);
    messages.say(run.job.inputName() + ": " + counted(outcome.result.frames, "frame") + " shown, " +
                 std::to_string(outcome.result.pipeline.dropped) + " dropped; " +
                 fixed(outcome.framesPerSecond(), 1) + " fps");
    return outcome;
}

} // namespace

std::string bytesText(double bytes) {
    return bytes < 1e9 ? fixed(bytes / 1e6, 1) + " MB" : fixed(bytes / 1e9, 1) + " GB";
}

std::string bytesAndRateText(double bytes, double seconds) {
    return bytesText(bytes) + ", " + fixed(megabits(bytes, seconds), 1) + " Mbit/s";
}

void tellDecoding(const VideoRun& run, double rate, Messages& messages) {
    const VideoWriterOptions& encoding = run.job.encoding;
    if (run.job.product != VideoProduct::Native || encoding.codec != VideoCodec::H264 ||
        encoding.compatible)
        return;
    // Measured: docs/performance.md.
    const bool isQuick = encoding.preset < EncoderPreset::Medium;
    const double secondsPerMegapixel = isQuick ? 0.0011 : 0.0022;
    const double secondsPerMegabit = isQuick ? 0.0027 : 0.009;
    constexpr double kEasy = 0.75; // of a core
    const cv::Size panel = run.display.panelSize();
    const double frames =
        run.inputFacts.averageRate.isKnown() ? run.inputFacts.averageRate.value() : 30;
    const double cores =
        secondsPerMegapixel * 1e-6 * panel.area() * frames + secondsPerMegabit * rate;
    if (cores <= kEasy) return;
    messages.say("to play " + sizeText(panel) + " at " + fixed(frames, 0) + " fps and " +
                 fixed(rate, 0) + " Mbit/s takes about " + fixed(std::ceil(cores + 0.25), 0) +
                 " cores of a processor, as graphics hardware decodes no H.264 in 4:4:4; with "
                 "--codec hevc it may");
}

void showByBridge(const VideoRun& run, const std::vector<std::filesystem::path>& files,
                  Messages& messages) {
    if (run.job.bridge)
        showOnBridge(*run.job.bridge, files, run.job.product == VideoProduct::Rgbd,
                     run.display.aspect(), messages);
}

void repeatEncoder(const VideoWriterOptions& encoding) {
    if (encoding.preset > EncoderPreset::SuperFast) fillNewMemory();
}

int runVideo(const VideoJob& job, Messages& messages) {
    if (job.jsonProgress) messages.leaveStandardOutput();
    if (isStandardStream(job.output)) messages.useStandardError();
    VideoRun run(job, messages);
    std::string report;
    int status = kExitFailed;
    try {
        status = makeVideo(run, job.report.empty() ? nullptr : &report, messages);
    } catch (const std::exception& error) {
        // before its name is checked, the report may replace a file
        if (run.job.isChecked && !job.report.empty())
            writeFile(job.report, failedReport(run, error, messages));
        throw;
    }
    if (!report.empty()) writeFile(job.report, report);
    if (status == kExitDone) showByBridge(run, {run.job.output}, messages);
    if (status != kExitDone || job.native.empty()) return status;
    VideoJob other = job;
    other.product = VideoProduct::Native;
    other.output = std::exchange(other.native, {});
    other.report.clear();
    return runVideo(other, messages);
}

int makeVideo(VideoRun& run, std::string* report, Messages& messages) {
    VideoConversion conversion = openVideo(run, messages);
    const VideoJob& job = run.job;
    catchStop();
    const VideoOutcome outcome = job.show ? show(run, std::move(conversion), messages)
                                          : convert(run, std::move(conversion), messages);
    if (outcome.failed) return kExitFailed;
    tellVideoDetails(run, outcome, messages);
    if (report != nullptr) *report = videoReport(run, outcome, messages);
    if (outcome.stopped) {
        std::string line = "stopped at " + clockText(outcome.result.end);
        const bool isLost = !job.show && !isStandardStream(job.output) && !outcome.result.keepsWork;
        if (isLost && job.isFromFolder) { // else --resume would take it for complete
            std::filesystem::remove(job.output);
            line += "; " + job.outputName() +
                    " is removed, as nothing is kept before the first 6 s: --resume makes it again";
        } else if (!job.show) {
            line += "; " + job.outputName() + " is whole up to there";
            line += outcome.result.keepsWork ? ", --resume continues"
                    : isLost && job.canReadAgain
                        ? "; nothing more is kept before the first 6 s: -y makes "
                          "it again"
                        : "";
        }
        messages.warn(line);
        return kExitStopped;
    }
    if (!outcome.cutOff.empty() && !job.show) {
        messages.flushWarnings();
        messages.fail(outcome.cutOff);
        return kExitFailed;
    }
    return kExitDone;
}

} // namespace altiro3D::tools
