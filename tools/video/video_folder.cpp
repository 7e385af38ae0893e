// video2native of a folder.

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/version.hpp"
#include "cli/folder_run.hpp"
#include "cli/outputs.hpp"
#include "video/video_progress.hpp"
#include "video/video_run.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

// .mkv holds more kinds of subtitles than .mp4, so it is kept.
std::string endingOf(const VideoWriterOptions& encoding, const VideoPlan& plan) {
    if (lowerCase(plan.input.extension().string()) == ".mkv") return ".mkv";
    try {
        VideoReader source(plan.input, plan.part);
        return VideoWriter::extensionFor(source, encoding);
    } catch (const Error&) { // its conversion reports it
        return encoding.codec == VideoCodec::ProRes ? ".mov" : ".mp4";
    }
}

std::string suffixOf(VideoProduct product) {
    switch (product) {
    case VideoProduct::Native:
        break;
    case VideoProduct::Quilt:
        return {}; // its name states the layout
    case VideoProduct::Rgbd:
        return "_rgbd";
    }
    return "_native";
}

// The videos of the folder.
std::vector<FolderFile> listVideos(const VideoJob& job, std::vector<LeftOutFile>& leftOut,
                                   Messages& messages) {
    const fs::path& folder = job.plan.input;
    FolderSearch search;
    search.wanted = {FileKind::Video};
    if (job.plan.fromQuilt) search.wanted.insert(FileKind::QuiltVideo);
    search.pairDepth = false;
    search.recursive = job.recursive;
    search.outputs = {job.plan.output};
    std::vector<FolderFile> videos = listFiles(folder, search, leftOut, messages);
    if (videos.empty()) {
        const std::string others =
            leftOut.empty() ? std::string() : " (left out: " + kindsText(leftOut) + ")";
        throw Error(ErrorCode::NotFound, folder.string(),
                    "holds no videos to convert, expected videos" + others);
    }
    return videos;
}

// The plans of all videos, whose outputs do not collide.
std::vector<VideoPlan> planVideos(const VideoRun& run, const std::vector<FolderFile>& videos,
                                  Messages& messages) {
    const VideoPlan& all = run.job.plan;
    const VideoProduct product = all.product;
    std::optional<QuiltLayout> layout;
    if (product == VideoProduct::Quilt) layout = layoutOfViews(run, messages);
    const std::vector<std::string> stems = outputStems(videos);
    std::vector<VideoPlan> plans;
    for (std::size_t i = 0; i < videos.size(); ++i) {
        VideoPlan plan = all;
        plan.input = videos[i].file;
        plan.output = all.output / (stems[i] + suffixOf(product) + endingOf(run.encoding, plan));
        if (layout) plan.output = quiltFileName(plan.output, *layout, run.display.aspect());
        plan.report.clear();
        plan.isFile = true;
        plan.isFromFolder = true;
        plan.isChecked = true;
        plans.push_back(plan);
    }
    return plans;
}

// Checks all names and creates the directories.
void prepareOutputs(const VideoRun& run, const std::vector<VideoPlan>& plans) {
    const VideoJob& job = run.job;
    Outputs outputs(job.replace || job.resume);
    outputs.addInputs(run.display.files);
    outputs.addInputs({job.depth.network, job.depth.profile});
    for (const VideoPlan& plan : plans) {
        outputs.addInputs({plan.input});
        outputs.addDirectory(plan.output.parent_path());
        outputs.addOutputs({plan.output});
    }
    outputs.addOutputs({job.plan.report});
    outputs.check();
    outputs.makeDirectories();
}

} // namespace

int runVideoFolder(const VideoJob& job, Messages& messages) {
    if (job.jsonProgress) messages.leaveStandardOutput();
    std::vector<LeftOutFile> leftOut;
    const std::vector<FolderFile> videos = listVideos(job, leftOut, messages);
    requireDirectoryName(job.plan.output, "videos");
    VideoRun videoRun(job, messages);
    const fs::path& report = job.plan.report;
    std::vector<VideoPlan> plans = planVideos(videoRun, videos, messages);
    prepareOutputs(videoRun, plans);
    openDepth(videoRun, messages);

    const auto isMade = [&job](const VideoPlan& plan) {
        return job.resume && isFileWithContents(plan.output) && !isVideoUnfinished(plan.output);
    };
    const auto made = std::count_if(plans.begin(), plans.end(), isMade);
    FolderRun run("video", plans.size() - static_cast<std::size_t>(made), leftOut, messages);
    Json reports = Json::array();
    for (VideoPlan& plan : plans) {
        if (isStopWanted()) break;
        if (isMade(plan)) {
            run.skip(plan.input, plan.output);
            reports.push_back({{"input", plan.input.string()}, {"skipped", true}});
            continue;
        }
        std::string text; // of the report
        const FolderRun::Outcome outcome = run.convert(plan.input, [&] {
            plan.place = run.place() + " " + oneLine(plan.input.filename().string()) + " ";
            videoRun.plan = plan;
            return makeVideo(videoRun, &text, messages);
        });
        if (!text.empty()) {
            reports.push_back(Json::parse(text));
            reports.back().erase("warnings"); // all are listed once
        }
        if (!outcome.leftOut.empty())
            reports.push_back({{"input", plan.input.string()}, {"leftOut", outcome.leftOut}});
        if (!outcome.error.empty())
            reports.push_back({{"input", plan.input.string()}, {"error", outcome.error}});
    }
    const int status = run.end();
    if (!report.empty()) {
        const Json all = {{"tool", job.tool},
                          {"version", version()},
                          {"videos", reports},
                          {"warnings", messages.warnings()}};
        writeFile(report, all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
    }
    return isStopWanted() ? kExitStopped : status;
}

} // namespace altiro3D::tools
