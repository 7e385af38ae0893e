#include "altiro3D/error.hpp"
#include "altiro3D/video_conversion.hpp"
#include "media/run_settings.hpp"
#include "media/video_segments.hpp"
#include "video/chunks/chunk_plan.hpp"
#include "video/chunks/chunk_record.hpp"
#include "video/chunks/work_folder.hpp"
#include "video/conversion/conversion_run.hpp"
#include "video/conversion/conversion_stamp.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

std::string listed(const std::vector<int>& numbers) {
    constexpr std::size_t kMost = 10;
    std::string text;
    for (std::size_t i = 0; i < std::min(numbers.size(), kMost); ++i)
        text += (i == 0 ? "" : ", ") + std::to_string(numbers[i]);
    if (numbers.size() > kMost) text += " and " + std::to_string(numbers.size() - kMost) + " more";
    return text;
}

} // namespace

VideoConversionResult joinVideoChunks(VideoConversion conversion, const fs::path& directory,
                                      const VideoProgressFunction& goOn) {
    const ChunkPlan plan = readChunkPlan(directory);
    requireFileInput(conversion);
    const auto start = std::chrono::steady_clock::now();
    const fs::path output = conversion.output;
    takeDepthRange(conversion, plan.settings);
    ConversionRun run(std::move(conversion), ChunkRange());
    requireSettings(plan, settingsJson(run.stamp), directory);

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
                for (const int number : order) // whoever starts chunks sees all that must be made
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
}

} // namespace altiro3D
