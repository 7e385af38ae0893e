// video2native of a folder.

#include "altiro3D/enum_table.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/version.hpp"
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
std::string endingOf(const VideoJob& job, const fs::path& input) {
    if (lowerExtension(input) == ".mkv") return ".mkv";
    try {
        VideoReader source(input, job.part);
        return VideoWriter::extensionFor(source, job.encoding);
    } catch (const Error&) { // its conversion reports it
        return job.encoding.codec == VideoCodec::ProRes ? ".mov" : ".mp4";
    }
}

// What names end with, by VideoProduct; the name of a quilt states its layout.
constexpr const char* kSuffixes[] = {"_native", "", "_rgbd", "_stereo"};

std::vector<FolderFile> listVideos(const VideoJob& job, std::vector<LeftOutFile>& leftOut,
                                   Messages& messages) {
    const fs::path& folder = job.input;
    FolderSearch search;
    search.wanted = {FileKind::Video};
    if (job.fromQuilt) search.wanted.insert(FileKind::QuiltVideo);
    search.pairDepth = false;
    search.recursive = job.recursive;
    search.outputs = {job.output};
    std::vector<FolderFile> videos = listFiles(folder, search, leftOut, messages);
    if (videos.empty()) {
        const std::string others =
            leftOut.empty() ? std::string() : " (left out: " + kindsText(leftOut) + ")";
        throw Error(ErrorCode::NotFound, folder.string(),
                    "holds no videos to convert, expected videos" + others);
    }
    return videos;
}

// The videos and their outputs, whose names are checked; makes the directories.
std::vector<FolderItem> planFiles(const VideoRun& run, const std::vector<FolderFile>& videos,
                                  Messages& messages) {
    const VideoJob& job = run.job;
    std::optional<QuiltLayout> layout;
    if (job.product == VideoProduct::Quilt) layout = layoutOfViews(run, messages);
    const std::vector<std::string> stems = outputStems(videos);
    Outputs outputs(job.replace || job.resume);
    outputs.addInputs(run.display.files);
    outputs.addInputs({job.depth.network, job.depth.profile});
    std::vector<FolderItem> files;
    for (std::size_t i = 0; i < videos.size(); ++i) {
        const fs::path& input = videos[i].file;
        fs::path output =
            job.output / (stems[i] + entryOf(kSuffixes, job.product) + endingOf(job, input));
        if (layout) output = quiltFileName(output, *layout, run.display.aspect());
        outputs.addPair(input, output);
        const bool isMade = job.resume && isFileWithContents(output) && !isVideoUnfinished(output);
        files.push_back({input, output, isMade});
    }
    outputs.addOutputs({job.report});
    outputs.check();
    outputs.makeDirectories();
    return files;
}

} // namespace

int makeVideo(VideoRun& run, const FolderItem& file, const std::string& place, std::string* report,
              Messages& messages) {
    VideoJob& job = run.job;
    job.input = file.input;
    job.output = file.output;
    job.report.clear();
    job.canReadAgain = job.isFromFolder = job.isChecked = true;
    job.place = place;
    return makeVideo(run, report, messages);
}

int runVideoFolder(const VideoJob& job, Messages& messages) {
    if (job.jsonProgress) messages.leaveStandardOutput();
    std::vector<LeftOutFile> leftOut;
    const std::vector<FolderFile> videos = listVideos(job, leftOut, messages);
    requireDirectoryName(job.output, "videos");
    VideoRun videoRun(job, messages);
    const std::vector<FolderItem> files = planFiles(videoRun, videos, messages);
    openDepth(videoRun, messages);
    FolderRun run("video", leftOut, messages, job.jsonProgress);
    Json reports = Json::array();
    std::string text; // of the report
    std::vector<fs::path> made;
    const auto make = [&](std::size_t i) {
        const std::string name = oneLine(files[i].input.filename().string());
        const int status =
            makeVideo(videoRun, files[i], run.place() + " " + name + " ", &text, messages);
        if (status == kExitDone) made.push_back(files[i].output);
        return status;
    };
    const int status = run.convert(files, make, [&](std::size_t i, const FolderEnd& end) {
        if (!text.empty()) {
            reports.push_back(Json::parse(std::exchange(text, {})));
            reports.back().erase("warnings"); // all are listed once
        }
        end.addTo(reports, "input", files[i]);
    });
    if (const fs::path& report = job.report; !report.empty()) {
        const Json all = {{"tool", job.tool},
                          {"version", version()},
                          {"state", stateName(status)},
                          {"videos", reports},
                          {"warnings", messages.warnings()}};
        writeFile(report, jsonText(all, 2) + "\n");
    }
    if (status != kExitStopped) showByBridge(videoRun, made, messages);
    return status;
}

} // namespace altiro3D::tools
