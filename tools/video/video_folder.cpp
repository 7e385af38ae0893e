// video2native of a folder.

#include "altiro3D/enum_table.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/version.hpp"
#include "cli/folders.hpp"
#include "cli/json_text.hpp"
#include "cli/outputs.hpp"
#include "video/video_progress.hpp"
#include "video/video_run.hpp"

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

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

// Of names, as VideoProduct; that of a quilt states its layout.
constexpr const char* kSuffixes[] = {"_native", "", "_rgbd", "_stereo"};

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
        plan.output = all.output /
                      (stems[i] + entryOf(kSuffixes, product) + endingOf(run.job.encoding, plan));
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
    for (const VideoPlan& plan : plans)
        outputs.addPair(plan.input, plan.output);
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
    const std::vector<VideoPlan> plans = planVideos(videoRun, videos, messages);
    prepareOutputs(videoRun, plans);
    openDepth(videoRun, messages);

    std::vector<FolderItem> files;
    for (const VideoPlan& plan : plans) {
        const bool isMade =
            job.resume && isFileWithContents(plan.output) && !isVideoUnfinished(plan.output);
        files.push_back({plan.input, plan.output, isMade});
    }
    FolderRun run("video", leftOut, messages, job.jsonProgress);
    Json reports = Json::array();
    std::string text; // of the report
    const auto make = [&](std::size_t i) {
        videoRun.job.plan = plans[i];
        videoRun.job.plan.place =
            run.place() + " " + oneLine(plans[i].input.filename().string()) + " ";
        return makeVideo(videoRun, &text, messages);
    };
    const int status = run.convert(files, make, [&](std::size_t i, const FolderEnd& end) {
        if (!text.empty()) {
            reports.push_back(Json::parse(std::exchange(text, {})));
            reports.back().erase("warnings"); // all are listed once
        }
        end.addTo(reports, "input", files[i]);
    });
    if (!report.empty()) {
        const Json all = {{"tool", job.tool},
                          {"version", version()},
                          {"state", stateName(status)},
                          {"videos", reports},
                          {"warnings", messages.warnings()}};
        writeFile(report, jsonText(all, 2) + "\n");
    }
    return status;
}

} // namespace altiro3D::tools
