#include "viewer/model/video_export.hpp"

#include "altiro3D/error.hpp"
#include "cli/run_tool.hpp"
#include "video/video_progress.hpp"
#include "video/video_run.hpp"

#include <chrono>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

// Ends a run at once: its parts stay, and no file is written.
struct Cancelled {};

double bytesIn(const fs::path& folder) {
    double bytes = 0;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        const auto size = entry.file_size(error); // a part may just have got its name
        if (!error) bytes += static_cast<double>(size);
    }
    return bytes;
}

// Tells the state, and ends the run if it is to be cancelled.
class Teller {
  public:
    Teller(const VideoProgress& start, const fs::path& file,
           const std::function<bool(const VideoExportState&)>& goOn)
        : pace_(start), folder_(unfinishedVideoDirectory(file)), goOn_(goOn) {}

    void tell(const VideoProgress& now) {
        constexpr std::chrono::milliseconds kStep(250);
        pace_.update(now);
        const Clock::time_point time = Clock::now();
        if (!now.finishing && time < next_) return;
        next_ = time + kStep;
        VideoExportState state;
        state.share = pace_.share().value_or(0);
        state.end = now.end;
        state.length = now.length;
        state.framesPerSecond = pace_.rate();
        state.secondsLeft = pace_.secondsLeft();
        if (now.length && now.end > 0) state.bytes = bytesIn(folder_) * *now.length / now.end;
        state.finishing = now.finishing;
        if (!goOn_(state) && !now.finishing) throw Cancelled();
    }
    double end() const { return pace_.now().end; }

  private:
    tools::VideoPace pace_;
    fs::path folder_;
    const std::function<bool(const VideoExportState&)>& goOn_;
    Clock::time_point next_{};
};

} // namespace

std::string videoExportObstacle(const Document& document, const Knobs& knobs) {
    const Source& source = document.source;
    if (document.kind == Kind::Native) return "This is a Native video, which is finished";
    if (!tools::isFile(source.file)) return "Only videos in files can be exported";
    if (document.hasDepth() && !document.depthTrack && knobs.depth != kGivenDepth)
        return "This video brings its own depth: choose \"Depth from its file\" to export it";
    return {};
}

tools::VideoJob videoJobOf(const Document& document, const Knobs& knobs, const Display& display,
                           const fs::path& file, bool goesOn) {
    tools::VideoJob job;
    job.tool = "altiro3Dview";
    job.input = document.source.file;
    job.output = file;
    job.fromQuilt = document.kind == Kind::Quilt;
    job.canReadAgain = true;
    job.isChecked = true; // the converter refuses its own input
    job.resume = goesOn;
    job.replace = !goesOn;
    job.profile = tools::standardVideoProfile();
    job.encoding.crf = job.profile.crf;
    job.encoding.preset = job.profile.preset;
    if (job.fromQuilt) {
        job.quilt.grid = QuiltGrid{document.layout.columns, document.layout.rows};
        return job;
    }
    job.scene.recipe = static_cast<const Recipe&>(knobs);
    if (!knobs.choices.framing)
        job.scene.recipe.framing =
            allowed(knobs.framing, {document.picture.size(), display.aspect(), knobs.fit});
    job.depth.medium = tools::Medium::Video;
    job.depth.isFlat = document.source.reading == Reading::Photo;
    if (document.eyes && document.source.reading != Reading::Automatic)
        job.depth.stereo = StereoInput{document.eyes->layout, document.eyes->halves, {}};
    job.depthOptions.every = job.profile.depthEvery;
    if (const auto side = depthSideOf(document.source)) {
        job.depth.rgbd = *side;
        job.depth.given = "depth half of the picture";
        job.depthOptions.every = 1;
    } else if (knobs.depth != kBestDepth && knobs.depth != kGivenDepth) {
        job.depth.network = knobs.depth;
    }
    job.depth.isDefault = job.depth.given.empty() && job.depth.network.empty();
    return job;
}

VideoExportResult exportVideo(const tools::VideoJob& job, const Display& display,
                              const std::function<bool(const VideoExportState&)>& goOn) {
    tools::Messages messages(job.tool, false); // the window says what matters
    messages.leaveStandardOutput();
    tools::ChosenDisplay chosen;
    static_cast<Display&>(chosen) = display;
    tools::VideoRun run(job, std::move(chosen));
    VideoConverter converter(tools::openVideo(run, messages));
    tools::repeatEncoder(run.job.encoding);
    Teller teller(converter.progress(), job.output, goOn);
    VideoExportResult result;
    try {
        const VideoConversionResult made = converter.run([&teller](const VideoProgress& now) {
            teller.tell(now);
            return true;
        });
        result.file = job.output.string();
        result.bytes = static_cast<double>(fs::file_size(job.output));
        result.end = made.end;
        for (const Notes& notes : {made.notes, converter.notes()}) {
            for (const Note& note : notes)
                result.notes.push_back(note.text);
        }
    } catch (const Cancelled&) {
        result.end = teller.end();
        result.keepsParts = converter.keepsWork();
    }
    return result;
}

} // namespace altiro3D::viewer
