#include "altiro3D/depth_source.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/video_conversion.hpp"
#include "base/state_bytes.hpp"
#include "media/run_settings.hpp"
#include "video/chunks/chunk_plan.hpp"
#include "video/chunks/chunk_record.hpp"
#include "video/chunks/chunk_states.hpp"
#include "video/chunks/work_folder.hpp"
#include "video/conversion/conversion_run.hpp"
#include "video/conversion/conversion_stamp.hpp"
#include "video/motion/picture_tracker.hpp"

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <utility>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// The depth of a fixed picture: processors whose arithmetic differs give another one.
std::uint64_t processorOf(VideoConversion& conversion) {
    if (conversion.fromQuilt || conversion.given) return 0;
    if (!conversion.depth) conversion.depth = estimatedDepth();
    constexpr int kSide = 192;
    cv::Mat picture(kSide, kSide, CV_8UC3);
    std::uint64_t noise = 1;
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
            noise = mixIn(noise, static_cast<std::uint64_t>(x));
            const int grain = static_cast<int>(noise >> 60U);
            const bool inside = (x - 90) * (x - 90) + (y - 110) * (y - 110) < 50 * 50;
            picture.at<cv::Vec3b>(y, x) =
                cv::Vec3b(static_cast<std::uint8_t>(y + grain),
                          static_cast<std::uint8_t>((inside ? 200 : x / 2) + grain),
                          static_cast<std::uint8_t>((inside ? 60 : 220 - y) + grain));
        }
    }
    cv::Mat photo;
    cv::Mat raw;
    conversion.depth->readFrame(picture, photo, raw);
    return pictureHash(raw) | 1U; // 0: depth is not estimated
}

// The frames of a chunk, and the last state that another chunk has left for it.
ChunkRange rangeOf(const ChunkPlan& plan, int number, const ChunkStates& states) {
    const VideoChunk& chunk = plan.chunk(number);
    ChunkRange range;
    range.begin = chunk.begin;
    range.beginPts = plan.beginPts[static_cast<std::size_t>(number - 1)];
    range.first = chunk.first;
    range.frames = chunk.frames;
    range.segmentFrames = plan.segmentFrames;
    for (const VideoChunk& other : plan.shown.chunks) {
        const bool isInside = other.begin < other.first;
        if (isInside && other.first > chunk.begin && other.first <= range.end())
            range.borders.insert(other.first);
    }
    for (auto border = range.borders.rbegin(); border != range.borders.rend(); ++border) {
        if (*border > chunk.first) continue;
        std::optional<SavedState> state = states.take(*border);
        if (!state) continue;
        range.begin = *border;
        range.beginPts = plan.segments[static_cast<std::size_t>(*border / plan.segmentFrames)].pts;
        range.state = std::move(*state);
        break;
    }
    range.keep = [states](std::int64_t frame, const SavedState& state) {
        states.keep(frame, state);
    };
    return range;
}

} // namespace

bool isVideoChunkMade(const fs::path& directory, int number) {
    const ChunkPlan plan = readChunkPlan(directory);
    static_cast<void>(plan.chunk(number));
    try {
        return readChunkRecord(plan, directory, number).has_value();
    } catch (const Error&) {
        return false;
    }
}

VideoConversionResult makeVideoChunk(VideoConversion conversion, const fs::path& directory,
                                     int number, const VideoProgressFunction& goOn) {
    const ChunkPlan plan = readChunkPlan(directory);
    const VideoChunk& chunk = plan.chunk(number);
    requireFileInput(conversion);
    const std::uint64_t processor = processorOf(conversion);
    const ChunkStates states(directory, plan, processor);
    ChunkRange range = rangeOf(plan, number, states);
    const fs::path target = chunkFolder(directory, number);
    WorkFolder work(target);
    work.removeStale(target.filename().string());
    range.directory = work.path();
    takeDepthRange(conversion, plan.settings);
    ConversionRun run(std::move(conversion), range);
    requireSettings(plan, settingsJson(run.stamp), directory);
    if (isChunkWhole(plan, directory, number)) {
        VideoConversionResult result;
        result.frames = result.keptFrames = chunk.frames;
        result.end = chunk.end;
        return result;
    }
    VideoConversionResult result = run.run([&](const VideoProgress& progress) {
        work.showLife();
        return !goOn || goOn(progress);
    });
    if (result.cancelled) return result;
    const std::vector<VideoSegment>& segments = run.sink->chunk();
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const SegmentPlan& planned = plan.segments[plan.segmentOf(chunk) + i];
        if (segments[i].times == planned.times && segments[i].pts == planned.pts) continue;
        throw Error(ErrorCode::Mismatch, run.conversion.input.string(),
                    "has frames at other times than when the plan was made, expected the same "
                    "file and the same FFmpeg");
    }
    writeChunkRecord(plan, processor, segments, work.path());
    if (!work.finish() && !isChunkWhole(plan, directory, number)) {
        work.moveAway();
        if (!work.finish() && !isChunkWhole(plan, directory, number)) {
            throw Error(ErrorCode::WriteFailed, target.string(),
                        "is in use, expected a folder that can be replaced");
        }
    }
    return result;
}

} // namespace altiro3D
