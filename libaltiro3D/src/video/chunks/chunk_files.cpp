#include "video/chunks/chunk_files.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/state_bytes.hpp"
#include "base/system_file.hpp"
#include "base/system_process.hpp"
#include "media/resumable_video.hpp"

#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <regex>
#include <set>
#include <string_view>
#include <system_error>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr const char* kPlanFormat = "altiro3D video plan";
constexpr const char* kChunkFormat = "altiro3D video chunk";
constexpr int kVersion = 1;
constexpr const char* kChunkFile = "chunk.json";
constexpr std::uintmax_t kMaxStateBytes = std::uintmax_t{1} << 30;

// The plan's text without its id, from which the id follows.
Json jsonOf(const ChunkPlan& plan, const Fraction& timeBase) {
    Json segments = Json::array();
    for (const VideoSegment& segment : plan.segments) {
        segments.push_back({{"frames", segment.frames},
                            {"pts", segment.pts},
                            {"end", segment.end},
                            {"times", segment.times}});
    }
    Json chunks = Json::array();
    for (std::size_t i = 0; i < plan.shown.chunks.size(); ++i) {
        const VideoChunk& chunk = plan.shown.chunks[i];
        chunks.push_back({{"begin", chunk.begin},
                          {"beginPts", plan.beginPts[i]},
                          {"first", chunk.first},
                          {"frames", chunk.frames}});
    }
    return {{"format", kPlanFormat},
            {"version", kVersion},
            {"settings", plan.settings},
            {"threads", plan.shown.threads},
            {"milliseconds", std::llround(plan.shown.seconds * 1000)},
            {"timeBase", {timeBase.numerator, timeBase.denominator}},
            {"segmentFrames", plan.segmentFrames},
            {"segments", segments},
            {"chunks", chunks}};
}

// Whether the chunks with pictures cover the video, each frame exactly once.
bool coversVideo(const ChunkPlan& plan) {
    std::map<std::int64_t, std::int64_t> ends; // by first frame
    for (const VideoChunk& chunk : plan.shown.chunks) {
        if (chunk.frames > 0 && !ends.emplace(chunk.first, chunk.first + chunk.frames).second)
            return false;
    }
    std::int64_t at = 0;
    for (const auto& [first, end] : ends) {
        if (first != at) return false;
        at = end;
    }
    return at == plan.shown.frames;
}

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

// Whether every segment has the bytes that were written.
bool isUndamaged(const ChunkRecord& record) {
    for (std::size_t i = 0; i < record.segments.size(); ++i) {
        if (fileChecksum(record.segments[i].file) != record.sums[i]) return false;
    }
    return true;
}

constexpr const char* kAside = "-old";
constexpr auto kBetweenSigns = std::chrono::minutes(1);
constexpr auto kLongest = std::chrono::hours(1);

} // namespace

const VideoChunk& ChunkPlan::chunk(int number) const {
    check(number >= 1 && static_cast<std::size_t>(number) <= shown.chunks.size(), "chunk",
          "is " + std::to_string(number) + ", expected 1.." + std::to_string(shown.chunks.size()));
    return shown.chunks[static_cast<std::size_t>(number - 1)];
}

void setTimes(ChunkPlan& plan, const Fraction& timeBase) {
    const double unit = timeBase.value();
    plan.shown.frames = 0;
    for (const VideoSegment& segment : plan.segments)
        plan.shown.frames += segment.frames;
    plan.shown.end = static_cast<double>(plan.segments.back().end) * unit;
    std::set<std::int64_t> scenes; // whose depth is made alone
    for (const VideoChunk& chunk : plan.shown.chunks) {
        if (chunk.frames == 0) scenes.insert(chunk.begin);
    }
    plan.shown.repeatedFrames = 0;
    for (VideoChunk& chunk : plan.shown.chunks) {
        if (chunk.frames == 0 || scenes.count(chunk.begin) == 0)
            plan.shown.repeatedFrames += chunk.first - chunk.begin;
        const std::size_t first = plan.segmentOf(chunk);
        const std::size_t count = plan.segmentCount(chunk);
        chunk.start = static_cast<double>(plan.segments[first].pts) * unit;
        chunk.end = count == 0 ? chunk.start
                               : static_cast<double>(plan.segments[first + count - 1].end) * unit;
    }
}

ChunkPlan readChunkPlan(const fs::path& directory) {
    const fs::path file = directory / kChunkPlanFile;
    std::error_code error;
    if (!fs::exists(file, error)) {
        throw Error(ErrorCode::NotFound, directory.string(),
                    "holds no plan, expected the folder of a plan");
    }
    const std::string text = readFile(file, kMaxRunBytes);
    const Json json = parseJson(text, file.string(), "a plan", kRunLimits);
    return readingMembers(file, [&] {
        if (json.at("format") != kPlanFormat || json.at("version") != kVersion) {
            throw Error(ErrorCode::BadFormat, file.string(),
                        "is not a plan of this version, expected one that this program has made");
        }
        ChunkPlan plan;
        plan.settings = json.at("settings");
        require(plan.settings.is_object());
        plan.shown.threads = static_cast<int>(wholeNumber(json.at("threads"), 1, 1 << 20));
        plan.shown.seconds =
            static_cast<double>(wholeNumber(json.at("milliseconds"), 0, kLatestPts)) / 1000;
        plan.segmentFrames = static_cast<int>(wholeNumber(json.at("segmentFrames"), 1, 100000));
        const auto unit = [&](std::size_t i) {
            constexpr std::int64_t kMost = std::numeric_limits<int>::max();
            return static_cast<int>(wholeNumber(json.at("timeBase").at(i), 1, kMost));
        };
        std::int64_t frames = 0;
        for (const Json& entry : json.at("segments")) {
            VideoSegment segment;
            segment.frames = wholeNumber(entry.at("frames"), 1, plan.segmentFrames);
            segment.pts = wholeNumber(entry.at("pts"), 0, kLatestPts);
            segment.end = wholeNumber(entry.at("end"), 0, kLatestPts);
            segment.times = bitsOf(entry.at("times"));
            frames += segment.frames;
            plan.segments.push_back(segment);
        }
        require(!plan.segments.empty());
        for (const Json& entry : json.at("chunks")) {
            VideoChunk chunk;
            chunk.begin = wholeNumber(entry.at("begin"), 0, frames);
            chunk.first = wholeNumber(entry.at("first"), chunk.begin, frames - 1);
            chunk.frames = wholeNumber(entry.at("frames"), 0, frames - chunk.first);
            require(chunk.first % plan.segmentFrames == 0);
            plan.shown.chunks.push_back(chunk);
            plan.beginPts.push_back(wholeNumber(entry.at("beginPts"), 0, kLatestPts));
        }
        setTimes(plan, {unit(0), unit(1)});
        require(coversVideo(plan));
        plan.id = checksum(text);
        return plan;
    });
}

void writeChunkPlan(const ChunkPlan& plan, const Fraction& timeBase, const fs::path& directory) {
    writeFile(directory / kChunkPlanFile, runFileText(jsonOf(plan, timeBase)));
}

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
    const Json json =
        parseJson(readFile(file, kMaxRunBytes), file.string(), "a record of a chunk", kRunLimits);
    return readingMembers(file, [&]() -> std::optional<ChunkRecord> {
        require(json.at("format") == kChunkFormat && json.at("version") == kVersion);
        if (bitsOf(json.at("plan")) != plan.id) return std::nullopt;
        ChunkRecord record;
        record.host = json.at("host");
        record.processor = bitsOf(json.at("processor"));
        std::size_t place = plan.segmentOf(chunk);
        const Json& list = json.at("segments");
        require(list.size() == plan.segmentCount(chunk));
        for (const Json& entry : list) {
            const VideoSegment segment = segmentOf(entry, folder, plan.segmentFrames);
            const VideoSegment& planned = plan.segments[place];
            // Any other name could lead out of the folder.
            require(segment.file.filename() == entry.at("file").get<std::string>() &&
                    segment.file.stem() == numberedName(place, ""));
            require(segment.frames == planned.frames && segment.pts == planned.pts &&
                    segment.end == planned.end && segment.times == planned.times);
            const std::uintmax_t bytes = fs::file_size(segment.file, error);
            if (error || bytes != segment.bytes) {
                throw Error(ErrorCode::BadFormat, segment.file.string(),
                            std::string(error ? "is missing" : "has another size") +
                                ", expected the file as chunk " + std::to_string(number) +
                                " wrote it; make this chunk again");
            }
            record.segments.push_back(segment);
            record.sums.push_back(bitsOf(entry.at("sum")));
            ++place;
        }
        return record;
    });
}

void writeChunkRecord(const ChunkPlan& plan, std::uint64_t processor,
                      const std::vector<VideoSegment>& segments, const fs::path& folder) {
    Json list = Json::array();
    for (const VideoSegment& segment : segments) {
        list.push_back(jsonOf(segment));
        list.back()["sum"] = fileChecksum(segment.file);
    }
    writeFile(folder / kChunkFile, runFileText({{"format", kChunkFormat},
                                                {"version", kVersion},
                                                {"plan", plan.id},
                                                {"host", hostName()},
                                                {"processor", processor},
                                                {"segments", list}}));
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
        return record && isUndamaged(*record);
    } catch (const Error&) {
        return false;
    }
}

void dropIfDamaged(const ChunkPlan& plan, const fs::path& directory, int number) {
    try {
        const std::optional<ChunkRecord> record = readChunkRecord(plan, directory, number);
        std::error_code error; // the join has failed anyway
        if (record && !isUndamaged(*record))
            fs::remove(chunkFolder(directory, number) / kChunkFile, error);
    } catch (const Error&) { // not a chunk that counts, or a file that cannot be read now
    }
}

void ChunkStates::keep(std::int64_t frame, const SavedState& state) const {
    if (take(frame)) return;
    std::string bytes;
    append(bytes, id_);
    append(bytes, processor_);
    append(bytes, static_cast<std::uint64_t>(frame));
    bytes += state.bytes;
    append(bytes, checksum(bytes));
    writeFile(nameOf(frame), bytes);
}

std::optional<SavedState> ChunkStates::take(std::int64_t frame) const {
    std::error_code error;
    if (!fs::exists(nameOf(frame), error)) return std::nullopt;
    try {
        const std::string bytes = readFile(nameOf(frame), kMaxStateBytes);
        constexpr std::size_t kNumber = sizeof(std::uint64_t);
        if (bytes.size() < 4 * kNumber) return std::nullopt;
        std::string_view rest(bytes);
        std::string_view end = rest.substr(rest.size() - kNumber);
        rest.remove_suffix(kNumber);
        const std::uint64_t sum = checksum(rest);
        for (const std::uint64_t expected : {id_, processor_, static_cast<std::uint64_t>(frame)}) {
            std::uint64_t value = 0;
            if (!altiro3D::take(rest, value) || value != expected) return std::nullopt;
        }
        std::uint64_t written = 0;
        if (!altiro3D::take(end, written) || written != sum) return std::nullopt;
        return SavedState{std::string(rest)};
    } catch (const Error&) {
        return std::nullopt;
    }
}

fs::path ChunkStates::nameOf(std::int64_t frame) const {
    return directory_ / (std::to_string(frame) + ".state");
}

WorkFolder::WorkFolder(const fs::path& target)
    : target_(target), path_(target), shown_(std::chrono::steady_clock::now()) {
    path_ += "." + hostName() + "-" + std::to_string(processNumber()) + "-" +
             std::to_string(shown_.time_since_epoch().count());
    std::error_code error;
    fs::create_directory(path_, error);
    if (error) {
        throw Error(ErrorCode::WriteFailed, path_.string(),
                    "cannot be made: " + error.message() +
                        ", expected the folder of the plan to be shared and writable");
    }
}

WorkFolder::~WorkFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
}

void WorkFolder::showLife() {
    const auto now = std::chrono::steady_clock::now();
    if (now - shown_ < kBetweenSigns) return;
    shown_ = now;
    touch(path_); // the time of the file system, not ours
}

bool WorkFolder::finish() {
    const int error = moveFile(path_, target_);
    if (error == ENOTEMPTY || error == EEXIST) return false;
    if (error != 0)
        throw Error(ErrorCode::WriteFailed, target_.string(), "cannot be made: " + reasonOf(error));
    path_.clear();
    flushDirectoryOf(target_);
    return true;
}

void WorkFolder::moveAway() {
    std::error_code ignored;
    fs::path aside = path_;
    aside += kAside;
    fs::rename(target_, aside, ignored);
    fs::remove_all(aside, ignored);
}

void WorkFolder::removeStale(const std::string& target) const {
    std::error_code error;
    const auto now = fs::last_write_time(path_, error);
    if (error) return;
    const std::string host = hostName();
    static const std::regex kName("([0-9]+|join)\\.(.+)-([1-9][0-9]{0,17})-[0-9]{1,19}(-old)?");
    std::vector<fs::path> stale;
    for (fs::directory_iterator entry(target_.parent_path(), error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string text = entry->path().filename().string();
        std::smatch name;
        if (!std::regex_match(text, name, kName) || (!target.empty() && name[1] != target))
            continue;
        std::error_code failure;
        const bool isKilled =
            name[2] == host && host != "unknown" && !isRunning(std::stoll(name[3]));
        const auto shown = fs::last_write_time(entry->path(), failure);
        if (isKilled || (!failure && now - shown > kLongest)) stale.push_back(entry->path());
    }
    for (const fs::path& folder : stale)
        fs::remove_all(folder, error);
}

} // namespace altiro3D
