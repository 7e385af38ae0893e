#include "video/chunks/chunk_plan.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/state_bytes.hpp"
#include "media/run_settings.hpp"
#include "video/chunks/json_members.hpp"
#include "video/conversion/video_sink.hpp"

#include <cmath>
#include <map>
#include <set>
#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr const char* kPlanFormat = "altiro3D video plan";
constexpr int kVersion = 1;

// The plan's text without its id, from which the id follows.
Json jsonOf(const ChunkPlan& plan, const Fraction& timeBase) {
    Json segments = Json::array();
    for (const SegmentPlan& segment : plan.segments) {
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

// Whether the chunks with pictures are the video, each frame once.
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

} // namespace

const VideoChunk& ChunkPlan::chunk(int number) const {
    check(number >= 1 && static_cast<std::size_t>(number) <= shown.chunks.size(), "chunk",
          "is " + std::to_string(number) + ", expected 1.." + std::to_string(shown.chunks.size()));
    return shown.chunks[static_cast<std::size_t>(number - 1)];
}

void setTimes(ChunkPlan& plan, const Fraction& timeBase) {
    const double unit = timeBase.value();
    plan.shown.frames = 0;
    for (const SegmentPlan& segment : plan.segments)
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
    const std::string text = readFile(file, kMaxChunkJsonBytes);
    const Json json = parseJson(text, file.string(), "a plan", kChunkJsonLimits);
    const JsonMembers all(json, file);
    if (all.text("format") != kPlanFormat || all.whole("version", 0, 1000) != kVersion) {
        throw Error(ErrorCode::BadFormat, file.string(),
                    "is not a plan of this version, expected "
                    "one that this program has made");
    }
    ChunkPlan plan;
    plan.settings = all.at("settings");
    if (!plan.settings.is_object()) all.fail();
    plan.shown.threads = static_cast<int>(all.whole("threads", 1, 1 << 20));
    plan.shown.seconds = static_cast<double>(all.whole("milliseconds", 0, kLatestPts)) / 1000;
    plan.segmentFrames = static_cast<int>(all.whole("segmentFrames", 1, 100000));
    const Json& unit = all.list("timeBase");
    constexpr std::int64_t kMaxInt = std::numeric_limits<int>::max();
    if (unit.size() != 2 || !unit[0].is_number_unsigned() || !unit[1].is_number_unsigned() ||
        unit[0].get<std::int64_t>() < 1 || unit[0].get<std::int64_t>() > kMaxInt ||
        unit[1].get<std::int64_t>() < 1 || unit[1].get<std::int64_t>() > kMaxInt) {
        all.fail();
    }
    const Fraction timeBase{unit[0].get<int>(), unit[1].get<int>()};
    std::int64_t frames = 0;
    for (const Json& entry : all.list("segments")) {
        const JsonMembers of(entry, file);
        const SegmentPlan segment{of.whole("frames", 1, plan.segmentFrames),
                                  of.whole("pts", 0, kLatestPts), of.whole("end", 0, kLatestPts),
                                  of.bits("times")};
        frames += segment.frames;
        plan.segments.push_back(segment);
    }
    if (plan.segments.empty()) all.fail();
    for (const Json& entry : all.list("chunks")) {
        const JsonMembers of(entry, file);
        VideoChunk chunk;
        chunk.begin = of.whole("begin", 0, frames);
        chunk.first = of.whole("first", chunk.begin, frames - 1);
        chunk.frames = of.whole("frames", 0, frames - chunk.first);
        if (chunk.first % plan.segmentFrames != 0) all.fail();
        plan.shown.chunks.push_back(chunk);
        plan.beginPts.push_back(of.whole("beginPts", 0, kLatestPts));
    }
    setTimes(plan, timeBase);
    if (!coversVideo(plan)) all.fail();
    plan.id = checksum(text);
    return plan;
}

void writeChunkPlan(const ChunkPlan& plan, const Fraction& timeBase, const fs::path& directory) {
    writeFile(directory / kChunkPlanFile, chunkJsonText(jsonOf(plan, timeBase)));
}

std::string chunkJsonText(const Json& value) {
    return value.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void requireSettings(const ChunkPlan& plan, const Json& settings, const fs::path& directory) {
    Json without = plan.settings;
    without.erase("length of chunks");
    Json now = settings;
    now.erase("length of chunks");
    const std::string other = differenceOf(without, now);
    if (other.empty()) return;
    throw Error(ErrorCode::Mismatch, directory.string(),
                "was planned with other settings (" + other + "), expected the same");
}

void requireFileInput(const VideoConversion& conversion) {
    check(!conversion.show, "show", "is set, expected an output");
    std::error_code error;
    if (fs::exists(conversion.input, error) && !canReadAgain(conversion.input)) {
        throw Error(ErrorCode::InvalidArgument, conversion.input.string(),
                    "can be read only once, expected a file");
    }
}

void makePlanFolders(const fs::path& directory) {
    static const std::set<std::string> kOurs = {kChunkPlanFile, "arguments", "visual.json", kChunks,
                                                kStates,        "logs",      "joined"};
    std::error_code error;
    if (fs::exists(directory, error) && !fs::is_directory(directory, error)) {
        throw Error(ErrorCode::WriteFailed, directory.string(), "is a file, expected a new folder");
    }
    for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        if (kOurs.count(name) == 0 && name.rfind(".altiro3D-", 0) != 0) {
            throw Error(ErrorCode::WriteFailed, directory.string(),
                        "holds other files (" + name + "), expected a new folder");
        }
    }
    for (const char* name : {"", kChunks, kStates, "logs"}) {
        fs::create_directories(directory / name, error);
        if (error) {
            throw Error(ErrorCode::WriteFailed, (directory / name).string(),
                        "cannot be made: " + error.message() + ", expected a folder to write to");
        }
    }
}

void removePlan(const fs::path& directory) {
    std::error_code error;
    for (const char* name : {kChunkPlanFile, kChunks, kStates, "logs", "joined"}) {
        fs::remove_all(directory / name, error);
        if (error) {
            throw Error(ErrorCode::WriteFailed, (directory / name).string(),
                        "cannot be removed: " + error.message());
        }
    }
}

} // namespace altiro3D
