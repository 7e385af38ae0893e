#include "common/video_run.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_io.hpp"
#include "common/display_player.hpp"
#include "common/folder_run.hpp"
#include "common/picture_options.hpp"
#include "common/run_tool.hpp"
#include "common/video_job.hpp"
#include "common/video_progress.hpp"
#include "common/video_report.hpp"

#include <atomic>
#include <csignal>
#include <malloc.h>

namespace altiro3D::tools {

namespace {

std::atomic<bool> stopWanted{false};

// The first signal ends the video with a complete file; a second one ends the process.
extern "C" void stopOnce(int signal) {
    stopWanted.store(true);
    std::signal(signal, SIG_DFL);
}

// Opens the output; errors about an earlier run name this tool's options.
VideoConverter openConverter(const VideoPlan& plan, VideoConversion conversion) {
    const UnfinishedRun unfinished = conversion.unfinished;
    const bool mayBeUnfinished = plan.isFile && unfinished == UnfinishedRun::Refuse;
    if (mayBeUnfinished && ResumableVideoWriter::isUnfinished(plan.output)) {
        throw Error(ErrorCode::WriteFailed, plan.output.string(),
                    "an unfinished run of it is kept in " +
                        ResumableVideoWriter::partsDirectory(plan.output).string() +
                        ", expected --resume to continue it, or -y to start again");
    }
    try {
        return VideoConverter(std::move(conversion));
    } catch (const Error& error) {
        const std::string text = error.what(); // "subject: problem"
        const bool isOfAnother =
            error.code() == ErrorCode::Mismatch || error.code() == ErrorCode::BadFormat;
        if (unfinished != UnfinishedRun::Resume || !isOfAnother ||
            text.rfind(plan.output.string(), 0) != 0)
            throw;
        const std::size_t end = text.find(": ");
        throw Error(error.code(), text.substr(0, end), text.substr(end + 2) + "; -y begins again");
    }
}

// Reports remarks at the end.
void tellRemarks(const CommandLine& commandLine, const VideoJob& job, VideoOutcome& outcome,
                 Messages& messages) {
    Notes notes = outcome.result.notes;
    if (outcome.result.counts.truncated && notes.front().code == NoteCode::CutOff) {
        outcome.cutOff = notes.front().text + "; the readable part was converted";
        notes.erase(notes.begin());
    }
    messages.warn(notes);
    const std::vector<SceneChoice>& choices = outcome.result.choices;
    ViewOptions views = job.native.views;
    if (!choices.empty()) {
        views.focus = choices.front().focus;
        views.strengthPercent = choices.front().strengthPercent;
        const std::string first =
            choices.size() == 1 ? "" : " (first of " + std::to_string(choices.size()) + " scenes)";
        messages.say("auto: " + autoText(autoChoices(commandLine), choices.front().framing, views) +
                     first);
    }
    if (!job.depth || job.plan.product != VideoProduct::Native) return;
    const auto parallaxOf = [&] {
        return adjacentParallax(views, job.layout, job.display.panelSize(), {0, 1});
    };
    AdjacentParallax largest = parallaxOf();
    for (const SceneChoice& choice : choices) {
        views.focus = choice.focus;
        views.strengthPercent = choice.strengthPercent;
        if (parallaxOf().viewPixels > largest.viewPixels) largest = parallaxOf();
    }
    warnAboutParallax(commandLine, largest, messages);
}

// Makes the file.
VideoOutcome convert(const CommandLine& commandLine, const VideoJob& job,
                     VideoConversion conversion, bool jsonProgress, Messages& messages) {
    const VideoPlan& plan = job.plan;
    VideoConverter converter = openConverter(plan, std::move(conversion));
    messages.warn(converter.notes());
    repeatEncoder(job.encoding);
    const VideoProgress begun = converter.progress();
    if (begun.keptFrames > 0) {
        messages.say("continues at " + clockText(begun.end) +
                     "; already made: " + counted(begun.keptFrames, "frame"));
    } else if (commandLine.has("resume")) {
        messages.say("no earlier run was found; starts from the beginning");
    }
    VideoProgressLine progress(jsonProgress, begun,
                               plan.isFromFolder ? plan.input.string() : std::string(), plan.place);
    VideoOutcome outcome;
    outcome.size = converter.size();
    try {
        outcome.result = converter.run([&progress](const VideoProgress& now) {
            progress.update(now);
            return !stopWanted.load();
        });
        if (outcome.result.frames == 0) {
            throw Error(ErrorCode::BadFormat, plan.inputName(),
                        "was stopped before the first frame");
        }
    } catch (...) {
        progress.clear();
        if (converter.keepsWork()) {
            messages.say("the frames so far are kept in " +
                         ResumableVideoWriter::partsDirectory(plan.output).string() +
                         "; --resume continues");
        }
        throw;
    }
    outcome.stopped = outcome.result.cancelled;
    tellRemarks(commandLine, job, outcome, messages);
    progress.end(outcome.state());
    constexpr const char* kProducts[] = {"Native", "quilt", "RGB-D"};
    messages.say(plan.output.string() + ": " + kProducts[static_cast<int>(plan.product)] +
                 " video, " + sizeText(outcome.size) + ", " +
                 counted(outcome.result.frames, "frame") + ", " + clockText(outcome.result.end) +
                 "; " + fixed(outcome.rate(), 1) + " fps");
    return outcome;
}

// Shows the video on the display at its own rate; late frames are dropped.
VideoOutcome show(const CommandLine& commandLine, const VideoJob& job, VideoConversion conversion,
                  Messages& messages) {
    DisplayPlayer screen(commandLine, job.display);
    conversion.show = [&screen](const cv::Mat& native) { return screen.show(native); };
    VideoConverter converter = openConverter(job.plan, std::move(conversion));
    VideoOutcome outcome;
    outcome.size = converter.size();
    outcome.result = converter.run([](const VideoProgress&) { return !stopWanted.load(); });
    const int status = screen.end();
    outcome.stopped = stopWanted.load();
    if (status == DisplayPlayer::kCrashed && !outcome.stopped) {
        throw Error(ErrorCode::WriteFailed, "altiro3Dview",
                    "ended unexpectedly, expected it to show the video");
    }
    outcome.failed = status != kExitDone && !outcome.stopped; // altiro3Dview has reported why
    if (outcome.failed) return outcome;
    tellRemarks(commandLine, job, outcome, messages);
    messages.say(job.plan.inputName() + ": " + counted(outcome.result.frames, "frame") +
                 " shown, " + std::to_string(outcome.result.pipeline.dropped) + " dropped; " +
                 fixed(outcome.rate(), 1) + " fps");
    return outcome;
}

} // namespace

bool isStopWanted() {
    return stopWanted.load();
}

void catchStop() {
    std::signal(SIGINT, stopOnce);
    std::signal(SIGTERM, stopOnce);
}

void repeatEncoder(const VideoWriterOptions& encoding) {
    // sets allocated memory to 0
    if (encoding.preset > EncoderPreset::SuperFast) mallopt(M_PERTURB, 0xff);
}

int runVideo(const CommandLine& commandLine, const VideoPlan& plan, Messages& messages) {
    if (VideoProgressLine::json(commandLine)) messages.leaveStandardOutput();
    VideoJob job;
    job.plan = plan;
    prepareVideo(commandLine, job, messages);
    std::string report;
    const int status =
        makeVideo(commandLine, job, plan.report.empty() ? nullptr : &report, messages);
    if (!report.empty()) writeFile(plan.report, report);
    return status;
}

int makeVideo(const CommandLine& commandLine, VideoJob& job, std::string* report,
              Messages& messages) {
    const VideoPlan& plan = job.plan;
    VideoConversion conversion = openVideo(commandLine, job, messages);
    catchStop();
    const VideoOutcome outcome = plan.show
                                     ? show(commandLine, job, std::move(conversion), messages)
                                     : convert(commandLine, job, std::move(conversion),
                                               VideoProgressLine::json(commandLine), messages);
    if (outcome.failed) return kExitFailed;
    tellVideoDetails(job, outcome, messages);
    if (report != nullptr) *report = videoReport(commandLine, job, outcome, messages);
    if (outcome.stopped) {
        std::string line = "stopped at " + clockText(outcome.result.end);
        if (!plan.show) line += "; " + job.plan.output.string() + " is whole up to there";
        if (outcome.result.keepsWork) line += ", --resume continues";
        messages.warn(line);
        return kExitStopped;
    }
    if (!outcome.cutOff.empty() && !plan.show) {
        messages.flushWarnings();
        messages.fail(outcome.cutOff);
        return kExitFailed;
    }
    return kExitDone;
}

} // namespace altiro3D::tools
