#include "altiro3D/depth_source.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/video_conversion.hpp"
#include "base/checks.hpp"
#include "base/state_bytes.hpp"
#include "media/resumable_video.hpp"
#include "media/video_segments.hpp"
#include "video/chunks/chunk_files.hpp"
#include "video/conversion/conversion_run.hpp"
#include "video/motion/motion.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// Requires the settings of the plan, except for the length of chunks.
// @throws Error Mismatch (names the first that differs)
void requireSettings(const ChunkPlan& plan, const RunSettings& settings,
                     const fs::path& directory) {
    Json before = plan.settings;
    before.erase("length of chunks");
    const std::string other = differenceOf(before, settingsJson(settings));
    if (other.empty()) return;
    throw Error(ErrorCode::Mismatch, directory.string(),
                "was planned with other settings (" + other + "), expected the same");
}

// The depth of a fixed picture: processors whose arithmetic differs give another one.
std::uint64_t processorOf(VideoConversion& conversion) {
    if (conversion.fromQuilt || conversion.given || conversion.eyes.filmed) return 0;
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

std::string listed(const std::vector<int>& numbers) {
    constexpr std::size_t kMost = 10;
    std::string text;
    for (std::size_t i = 0; i < std::min(numbers.size(), kMost); ++i)
        text += (i == 0 ? "" : ", ") + std::to_string(numbers[i]);
    if (numbers.size() > kMost) text += " and " + std::to_string(numbers.size() - kMost) + " more";
    return text;
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
                                     int number, const VideoProgressFunction& goOn) try {
    const ChunkPlan plan = readChunkPlan(directory);
    const VideoChunk& chunk = plan.chunk(number);
    const std::uint64_t processor = processorOf(conversion);
    const ChunkStates states(directory, plan, processor);
    ChunkRange range = rangeOf(plan, number, states);
    const fs::path target = chunkFolder(directory, number);
    WorkFolder work(target);
    work.removeStale(target.filename().string());
    range.directory = work.path();
    takeDepthRange(conversion, plan.settings);
    ConversionRun run(std::move(conversion), range);
    requireSettings(plan, run.stamp, directory);
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
    const std::vector<VideoSegment>& segments = run.chunk();
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const VideoSegment& planned = plan.segments[plan.segmentOf(chunk) + i];
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
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

VideoConversionResult joinVideoChunks(VideoConversion conversion, const fs::path& directory,
                                      const VideoProgressFunction& goOn) try {
    const ChunkPlan plan = readChunkPlan(directory);
    const auto start = std::chrono::steady_clock::now();
    const fs::path output = conversion.output;
    takeDepthRange(conversion, plan.settings);
    ConversionRun run(std::move(conversion), ChunkRange());
    requireSettings(plan, run.stamp, directory);

    // Numbers of the chunks with pictures; those without come first in the plan.
    std::vector<int> order;
    for (std::size_t i = 0; i < plan.shown.chunks.size(); ++i) {
        if (plan.shown.chunks[i].frames > 0) order.push_back(static_cast<int>(i) + 1);
    }
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return plan.chunk(a).first < plan.chunk(b).first; });
    std::vector<VideoSegment> segments;
    std::vector<std::pair<std::uint64_t, int>> sums; // and the chunk
    std::vector<int> missing;
    std::optional<std::pair<ChunkRecord, int>> first;
    for (const int number : order) {
        std::optional<ChunkRecord> record = readChunkRecord(plan, directory, number);
        if (!record) {
            missing.push_back(number);
            continue;
        }
        if (!first) first.emplace(*record, number);
        if (record->processor != first->first.processor) {
            throw Error(ErrorCode::Mismatch, directory.string(),
                        "has chunks from processors that estimate different depth (chunk " +
                            std::to_string(first->second) + " on " + first->first.host +
                            ", chunk " + std::to_string(number) + " on " + record->host +
                            "), expected one kind of processor");
        }
        for (std::size_t i = 0; i < record->segments.size(); ++i) {
            segments.push_back(record->segments[i]);
            sums.emplace_back(record->sums[i], number);
        }
    }
    if (!missing.empty()) {
        std::sort(missing.begin(), missing.end());
        throw Error(ErrorCode::NotFound, directory.string(),
                    "has no " + std::string(missing.size() == 1 ? "chunk " : "chunks ") +
                        listed(missing) + " yet, expected chunks " +
                        std::to_string(*std::min_element(order.begin(), order.end())) + ".." +
                        std::to_string(plan.shown.chunks.size()));
    }

    VideoConversionResult result;
    VideoProgress progress;
    progress.framesInAll = plan.shown.frames;
    std::size_t at = 0;
    const auto before = [&](const VideoSegment& segment) {
        if (goOn && !goOn(progress)) return false;
        try {
            requireChecksum(segment, sums[at].first, sums[at].second);
        } catch (const Error& error) {
            if (error.code() == ErrorCode::BadFormat) {
                for (const int number : order) // so that all that must be made again is known
                    dropIfDamaged(plan, directory, number);
            }
            throw;
        }
        ++at;
        progress.frames += segment.frames;
        return true;
    };
    VideoReader source(run.conversion.input, run.conversion.part);
    result.cancelled =
        !SegmentJoiner::join(output, run.encoding, segments, &source, true, before, result.notes);
    if (result.cancelled) return result;
    try {
        WorkFolder(directory / kChunks / "join").removeStale({});
    } catch (const Error&) { // the folder of the plan cannot be written
    }
    result.frames = result.keptFrames = plan.shown.frames;
    result.end = plan.shown.end;
    result.finishSeconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
