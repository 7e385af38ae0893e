#include "video/chunks/chunk_record.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/state_bytes.hpp"
#include "video/chunks/json_members.hpp"

#include <fstream>
#include <string_view>
#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr const char* kChunkFormat = "altiro3D video chunk";
constexpr int kVersion = 1;
constexpr const char* kChunkFile = "chunk.json";

// A checksum of the bytes of a file, read in blocks.
std::uint64_t fileChecksum(const fs::path& file) {
    constexpr std::size_t kBlock = std::size_t{1} << 20;
    std::ifstream stream(file, std::ios::binary);
    std::string block(kBlock, '\0');
    std::uint64_t sum = 0;
    while (stream) {
        stream.read(block.data(), static_cast<std::streamsize>(block.size()));
        const auto count = static_cast<std::size_t>(stream.gcount());
        if (count == 0) break;
        sum = mixIn(sum, checksum(std::string_view(block).substr(0, count)));
    }
    if (stream.bad()) {
        throw Error(ErrorCode::ReadFailed, file.string(),
                    "cannot be read, expected a whole segment");
    }
    return sum;
}

Json recordOf(const ChunkPlan& plan, std::uint64_t processor,
              const std::vector<VideoSegment>& segments) {
    Json list = Json::array();
    for (const VideoSegment& segment : segments) {
        list.push_back({{"file", segment.file.filename().string()},
                        {"frames", segment.frames},
                        {"pts", segment.pts},
                        {"end", segment.end},
                        {"times", segment.times},
                        {"bytes", segment.bytes},
                        {"reorderedPlaces", segment.reorderedPlaces},
                        {"sum", fileChecksum(segment.file)}});
    }
    return {{"format", kChunkFormat}, {"version", kVersion},    {"plan", plan.id},
            {"host", hostName()},     {"processor", processor}, {"segments", list}};
}

} // namespace

fs::path chunkFolder(const fs::path& directory, int number) {
    return directory / kChunks / numberedName(static_cast<std::size_t>(number - 1), "");
}

std::optional<ChunkRecord> readChunkRecord(const ChunkPlan& plan, const fs::path& directory,
                                           int number) {
    const VideoChunk& chunk = plan.chunk(number);
    const fs::path folder = chunkFolder(directory, number);
    const fs::path file = folder / kChunkFile;
    std::error_code error;
    if (!fs::exists(file, error)) return std::nullopt;
    const Json json = parseJson(readFile(file, kMaxChunkJsonBytes), file.string(),
                                "a record of a chunk", kChunkJsonLimits);
    const JsonMembers all(json, file);
    if (all.text("format") != kChunkFormat || all.whole("version", 0, 1000) != kVersion) all.fail();
    if (all.bits("plan") != plan.id) return std::nullopt;
    ChunkRecord record;
    record.host = all.text("host");
    record.processor = all.bits("processor");
    const Json& list = all.list("segments");
    const std::size_t first = plan.segmentOf(chunk);
    if (list.size() != plan.segmentCount(chunk)) all.fail();
    for (std::size_t i = 0; i < list.size(); ++i) {
        const JsonMembers of(list[i], file);
        const SegmentPlan& planned = plan.segments[first + i];
        const std::string name = of.text("file");
        if (fs::path(name).stem() != numberedName(first + i, "") ||
            fs::path(name).filename() != name) {
            all.fail();
        }
        VideoSegment segment;
        segment.file = folder / name;
        segment.frames = of.whole("frames", 1, plan.segmentFrames);
        segment.pts = of.whole("pts", 0, kLatestPts);
        segment.end = of.whole("end", 0, kLatestPts);
        segment.times = of.bits("times");
        segment.bytes = static_cast<std::uintmax_t>(of.whole("bytes", 0, kLatestPts));
        segment.reorderedPlaces =
            static_cast<int>(of.whole("reorderedPlaces", 0, plan.segmentFrames));
        if (segment.frames != planned.frames || segment.pts != planned.pts ||
            segment.end != planned.end || segment.times != planned.times) {
            all.fail();
        }
        const std::uintmax_t bytes = fs::file_size(segment.file, error);
        if (error || bytes != segment.bytes) {
            throw Error(ErrorCode::BadFormat, segment.file.string(),
                        std::string(error ? "is missing" : "has another size") +
                            ", expected the file as chunk " + std::to_string(number) +
                            " wrote it; make this chunk again");
        }
        record.segments.push_back(segment);
        record.sums.push_back(of.bits("sum"));
    }
    return record;
}

void writeChunkRecord(const ChunkPlan& plan, std::uint64_t processor,
                      const std::vector<VideoSegment>& segments, const fs::path& folder) {
    writeFile(folder / kChunkFile, chunkJsonText(recordOf(plan, processor, segments)));
}

void requireChecksum(const VideoSegment& segment, std::uint64_t sum, int number) {
    if (fileChecksum(segment.file) == sum) return;
    throw Error(ErrorCode::BadFormat, segment.file.string(),
                "is damaged, expected the bytes that chunk " + std::to_string(number) +
                    " wrote; make this chunk again");
}

bool isChunkWhole(const ChunkPlan& plan, const fs::path& directory, int number) {
    try {
        const std::optional<ChunkRecord> record = readChunkRecord(plan, directory, number);
        if (!record) return false;
        for (std::size_t i = 0; i < record->segments.size(); ++i)
            requireChecksum(record->segments[i], record->sums[i], number);
        return true;
    } catch (const Error&) {
        return false;
    }
}

void dropIfDamaged(const ChunkPlan& plan, const fs::path& directory, int number) {
    try {
        const std::optional<ChunkRecord> record = readChunkRecord(plan, directory, number);
        if (!record) return;
        bool isRight = true;
        for (std::size_t i = 0; i < record->segments.size(); ++i)
            isRight = isRight && fileChecksum(record->segments[i].file) == record->sums[i];
        std::error_code error; // the join has failed anyway
        if (!isRight) fs::remove(chunkFolder(directory, number) / kChunkFile, error);
    } catch (const Error&) { // not a chunk that counts, or a file that cannot be read now
    }
}

} // namespace altiro3D
