#include "altiro3D/video_chunks.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/json_reader.hpp"
#include "base/posix_file.hpp"
#include "base/text.hpp"
#include "video/conversion_run.hpp"
#include "video/picture_tracker.hpp"
#include "video/run_settings.hpp"
#include "video/state_bytes.hpp"
#include "video/video_segments.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fcntl.h>
#include <fstream>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kPlanFormat = "altiro3D video plan";
constexpr const char* kChunkFormat = "altiro3D video chunk";
constexpr int kVersion = 1;
constexpr const char* kPlanFile = "plan.json";
constexpr const char* kChunkFile = "chunk.json";
constexpr const char* kChunks = "chunks";
constexpr const char* kStates = "states";
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{64} << 20;
constexpr std::uintmax_t kMaxStateBytes = std::uintmax_t{1} << 30;
constexpr std::size_t kMaxChunks = 1000000;
constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max() / 8;
constexpr JsonLimits kLimits{8, 1000, false};
// Chunks that begin inside the same scene get a chunk that makes its depth, if they are as many.
constexpr int kManyInScene = 3;
// Depth alone takes about this share of the time of depth and picture.
constexpr double kDepthShare = 0.3;

std::string hostName() {
    std::array<char, 256> name{};
    if (gethostname(name.data(), name.size() - 1) != 0) return "unknown";
    return name.data();
}

std::string dump(const Json& value) {
    return value.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

// A frame and its time.
struct Place {
    std::int64_t frame = 0;
    std::int64_t pts = 0;
};

// The frames of a segment of the output.
struct SegmentPlan {
    std::int64_t frames = 0;
    std::int64_t pts = 0;
    std::int64_t end = 0;
    std::uint64_t times = 0;
};

struct Plan { // NOLINT(bugprone-exception-escape): the library of JSON states no noexcept
    VideoChunkPlan shown;
    Json settings;
    int segmentFrames = 1;
    std::vector<SegmentPlan> segments;
    std::vector<std::int64_t> beginPts; // of the chunks
    std::uint64_t id = 0;               // differs between plans

    std::size_t segmentOf(const VideoChunk& chunk) const {
        return static_cast<std::size_t>(chunk.first / segmentFrames);
    }
    std::size_t segmentCount(const VideoChunk& chunk) const {
        return static_cast<std::size_t>((chunk.frames + segmentFrames - 1) / segmentFrames);
    }
    const VideoChunk& chunk(int number) const {
        check(number >= 1 && static_cast<std::size_t>(number) <= shown.chunks.size(), "chunk",
              "is " + std::to_string(number) + ", expected 1.." +
                  std::to_string(shown.chunks.size()));
        return shown.chunks[static_cast<std::size_t>(number - 1)];
    }
};

// Reads the members of an object and refuses numbers out of range.
class Members {
  public:
    Members(const Json& object, const fs::path& file) : object_(object), file_(file) {}

    std::int64_t whole(const char* name, std::int64_t least, std::int64_t most) const {
        const Json& value = at(name);
        if (!value.is_number_integer()) fail();
        if (value.is_number_unsigned() &&
            value.get<std::uint64_t>() > static_cast<std::uint64_t>(kLatest)) {
            fail();
        }
        const auto number = value.get<std::int64_t>();
        if (number < least || number > most) fail();
        return number;
    }
    std::uint64_t bits(const char* name) const {
        const Json& value = at(name);
        if (!value.is_number_unsigned()) fail();
        return value.get<std::uint64_t>();
    }
    std::string text(const char* name) const {
        const Json& value = at(name);
        if (!value.is_string()) fail();
        return value.get<std::string>();
    }
    const Json& list(const char* name) const {
        const Json& value = at(name);
        if (!value.is_array() || value.size() > kMaxChunks) fail();
        return value;
    }
    const Json& at(const char* name) const {
        if (!object_.is_object() || !object_.contains(name)) fail();
        return object_[name];
    }
    [[noreturn]] void fail() const {
        throw Error(ErrorCode::BadFormat, file_.string(),
                    "is damaged, expected the file as it was written");
    }

  private:
    const Json& object_;
    const fs::path& file_;
};

// The plan's text without its id, from which the id follows.
Json jsonOf(const Plan& plan, const Fraction& timeBase) {
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

// Sets the times of the chunks from the segments.
void setTimes(Plan& plan, const Fraction& timeBase) {
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

// Whether the chunks with pictures are the video, each frame once.
bool coversVideo(const Plan& plan) {
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

Plan readPlan(const fs::path& directory) {
    const fs::path file = directory / kPlanFile;
    std::error_code error;
    if (!fs::exists(file, error)) {
        throw Error(ErrorCode::NotFound, directory.string(),
                    "holds no plan, expected the folder of a plan");
    }
    const std::string text = readFile(file, kMaxFileBytes);
    const Json json = parseJson(text, file.string(), "a plan", kLimits);
    const Members all(json, file);
    if (all.text("format") != kPlanFormat || all.whole("version", 0, 1000) != kVersion) {
        throw Error(ErrorCode::BadFormat, file.string(),
                    "is not a plan of this version, expected "
                    "one that this program has made");
    }
    Plan plan;
    plan.settings = all.at("settings");
    if (!plan.settings.is_object()) all.fail();
    plan.shown.threads = static_cast<int>(all.whole("threads", 1, 1 << 20));
    plan.shown.seconds = static_cast<double>(all.whole("milliseconds", 0, kLatest)) / 1000;
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
        const Members of(entry, file);
        const SegmentPlan segment{of.whole("frames", 1, plan.segmentFrames),
                                  of.whole("pts", 0, kLatest), of.whole("end", 0, kLatest),
                                  of.bits("times")};
        frames += segment.frames;
        plan.segments.push_back(segment);
    }
    if (plan.segments.empty()) all.fail();
    for (const Json& entry : all.list("chunks")) {
        const Members of(entry, file);
        VideoChunk chunk;
        chunk.begin = of.whole("begin", 0, frames);
        chunk.first = of.whole("first", chunk.begin, frames - 1);
        chunk.frames = of.whole("frames", 0, frames - chunk.first);
        if (chunk.first % plan.segmentFrames != 0) all.fail();
        plan.shown.chunks.push_back(chunk);
        plan.beginPts.push_back(of.whole("beginPts", 0, kLatest));
    }
    setTimes(plan, timeBase);
    if (!coversVideo(plan)) all.fail();
    plan.id = checksum(text);
    return plan;
}

void requireSettings(const Plan& plan, const Json& settings, const fs::path& directory) {
    Json without = plan.settings;
    without.erase("length of chunks");
    Json now = settings;
    now.erase("length of chunks");
    const std::string other = differenceOf(without, now);
    if (other.empty()) return;
    throw Error(ErrorCode::Mismatch, directory.string(),
                "was planned with other settings (" + other + "), expected the same");
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

// --- planning ----------------------------------------------------------------------------------

// What a chunk's first frame depends on.
struct Dependence {
    bool onScene = false; // depth or choices, which begin anew at a cut
    bool onFlaws = false; // flaws of given depth, measured every kFramesPerMeasurement frames
    std::optional<DepthSide> side; // of RGB-D frames
};

Dependence dependenceOf(const VideoConversion& conversion) {
    Dependence on;
    if (conversion.fromQuilt) return on;
    on.onScene = true;
    if (!conversion.given) return on;
    const GivenVideoDepth& given = *conversion.given;
    std::error_code error;
    on.side = given.side;
    on.onFlaws = true;
    // Pictures of a directory may be distances or floats, which get a range that follows them.
    on.onScene = conversion.choices.any() || given.kind == DepthKind::Metric ||
                 (!given.side && fs::is_directory(given.source, error));
    return on;
}

// Frames of the input, read once.
struct Survey {
    std::vector<SegmentPlan> segments;
    std::vector<Place> firsts; // of the segments
    std::vector<Place> cuts;
    std::vector<Place> measured; // frames at which flaws of given depth are measured
    std::int64_t frames = 0;
    bool cancelled = false;
};

Survey surveyOf(VideoReader& reader, int segmentFrames, const Dependence& on,
                const VideoProgressFunction& goOn, VideoProgress progress) {
    Survey survey;
    PictureTracker tracker;
    const double unit = reader.facts().timeBase.value();
    std::vector<PipelineStage> stages;
    stages.push_back({"decode", [&](PipelineFrame& frame) {
                          if (goOn && !goOn(progress)) {
                              survey.cancelled = true;
                              return false;
                          }
                          if (!reader.read(frame.source)) return false;
                          ++progress.frames;
                          progress.end = static_cast<double>(frame.source.pts) * unit;
                          return true;
                      }});
    stages.push_back({"cuts", [&](PipelineFrame& frame) {
                          const VideoFrame& source = frame.source;
                          const Place place{survey.frames, source.pts};
                          if (survey.frames % segmentFrames == 0) {
                              survey.segments.push_back({0, source.pts, 0, 0});
                              survey.firsts.push_back(place);
                          }
                          SegmentPlan& segment = survey.segments.back();
                          ++segment.frames;
                          segment.end = source.pts + std::max<std::int64_t>(source.duration, 1);
                          segment.times = mixTime(segment.times, source);
                          if (survey.frames % kFramesPerMeasurement == 0)
                              survey.measured.push_back(place);
                          if (on.onScene) {
                              cv::Mat photo = source.picture;
                              cv::Mat depth;
                              if (on.side) splitRgbd(source.picture, *on.side, photo, depth);
                              if (tracker.next(photo).cut) survey.cuts.push_back(place);
                          }
                          ++survey.frames;
                          return true;
                      }});
    runPipeline(stages);
    return survey;
}

// The last place at or before a frame.
Place lastBefore(const std::vector<Place>& places, std::int64_t frame) {
    const auto after = std::upper_bound(
        places.begin(), places.end(), frame,
        [](std::int64_t value, const Place& place) { return value < place.frame; });
    return after == places.begin() ? Place() : *(after - 1);
}

// The frame from which depth must be made so that the one at `first` is right.
Place beginOf(const Survey& survey, const Dependence& on, const Place& first) {
    Place begin = first;
    for (const auto& [isNeeded, places] :
         {std::pair(on.onScene, &survey.cuts), std::pair(on.onFlaws, &survey.measured)}) {
        if (!isNeeded) continue;
        const Place place = lastBefore(*places, first.frame);
        if (place.frame < begin.frame) begin = place;
    }
    return begin;
}

// The segments that begin chunks. Frames whose depth is repeated count as much as frames by which a
// chunk differs from its length.
std::vector<std::size_t> bordersOf(const Survey& survey, const Dependence& on, int segmentFrames,
                                   std::size_t wanted) {
    std::vector<std::size_t> borders = {0};
    const std::size_t count = survey.segments.size();
    while (count - borders.back() > wanted + wanted / 2) {
        const std::size_t at = borders.back();
        std::size_t best = at + wanted;
        auto least = std::numeric_limits<std::int64_t>::max();
        for (std::size_t s = at + (wanted + 1) / 2; s <= at + wanted + wanted / 2; ++s) {
            const Place& first = survey.firsts[s];
            const auto length = static_cast<std::int64_t>(wanted) * segmentFrames;
            const std::int64_t repeated =
                std::min(first.frame - beginOf(survey, on, first).frame, length);
            const std::size_t off = std::max(s, at + wanted) - std::min(s, at + wanted);
            const std::int64_t cost = repeated + static_cast<std::int64_t>(off) * segmentFrames;
            if (cost > least || (cost == least && s > at + wanted)) continue;
            least = cost;
            best = s;
        }
        borders.push_back(best);
    }
    return borders;
}

void divide(Plan& plan, const Survey& survey, const Dependence& on, double seconds,
            double videoSeconds) {
    const double segmentSeconds =
        videoSeconds * plan.segmentFrames / static_cast<double>(survey.frames);
    const double most = static_cast<double>(survey.segments.size());
    const auto wanted = static_cast<std::size_t>(
        std::clamp(std::round(seconds / std::max(segmentSeconds, 1e-9)), 1.0, most));
    const std::vector<std::size_t> borders = bordersOf(survey, on, plan.segmentFrames, wanted);
    struct Made {
        VideoChunk chunk;
        std::int64_t beginPts;
    };
    std::vector<Made> all;
    std::map<std::int64_t, std::vector<std::size_t>> inScene; // by first frame of the scene
    for (std::size_t i = 0; i < borders.size(); ++i) {
        const Place& first = survey.firsts[borders[i]];
        const std::int64_t end =
            i + 1 < borders.size() ? survey.firsts[borders[i + 1]].frame : survey.frames;
        const Place begin = beginOf(survey, on, first);
        VideoChunk chunk;
        chunk.begin = begin.frame;
        chunk.first = first.frame;
        chunk.frames = end - first.frame;
        if (chunk.begin < chunk.first) inScene[chunk.begin].push_back(all.size());
        all.push_back({chunk, begin.pts});
    }
    for (const auto& [begin, members] : inScene) {
        if (members.size() < static_cast<std::size_t>(kManyInScene)) continue;
        Made depth = all[members.back()];
        depth.chunk.frames = 0;
        all.push_back(depth);
    }
    const auto work = [](const Made& made) {
        return static_cast<double>(made.chunk.frames) +
               kDepthShare * static_cast<double>(made.chunk.first - made.chunk.begin);
    };
    std::stable_sort(all.begin(), all.end(), [&](const Made& a, const Made& b) {
        if ((a.chunk.frames == 0) != (b.chunk.frames == 0)) return a.chunk.frames == 0;
        return work(a) > work(b);
    });
    for (const Made& made : all) {
        plan.shown.chunks.push_back(made.chunk);
        plan.beginPts.push_back(made.beginPts);
    }
}

// Makes the folders of a plan.
void makeFolders(const fs::path& directory) {
    static const std::set<std::string> kOurs = {kPlanFile, "arguments", "visual.json", kChunks,
                                                kStates,   "logs",      "joined"};
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
    for (const char* name : {kPlanFile, kChunks, kStates, "logs", "joined"}) {
        fs::remove_all(directory / name, error);
        if (error) {
            throw Error(ErrorCode::WriteFailed, (directory / name).string(),
                        "cannot be removed: " + error.message());
        }
    }
}

void requireFileInput(const VideoConversion& conversion) {
    check(!conversion.show, "show", "is set, expected an output");
    std::error_code error;
    if (fs::exists(conversion.input, error) && !canReadAgain(conversion.input)) {
        throw Error(ErrorCode::InvalidArgument, conversion.input.string(),
                    "can be read only once, expected a file");
    }
}

// --- chunks ------------------------------------------------------------------------------------

// The depth of a fixed picture: processors whose arithmetic differs give another one.
std::uint64_t processorOf(VideoConversion& conversion) {
    if (conversion.fromQuilt || conversion.given) return 0;
    if (!conversion.depth) conversion.depth = depthFromCues();
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
    conversion.depth->read(picture, photo, raw);
    return pictureHash(raw) | 1U; // 0: depth is not estimated
}

// A chunk that is made.
struct ChunkRecord {
    std::string host;
    std::uint64_t processor = 0;
    std::vector<VideoSegment> segments;
    std::vector<std::uint64_t> sums; // of their bytes
};

fs::path folderOf(const fs::path& directory, int number) {
    return directory / kChunks / numberedName(static_cast<std::size_t>(number - 1), "");
}

// The record of a chunk, whose files have the right size. Nothing if the chunk is not made or not
// of this plan.
// @throws Error BadFormat, ReadFailed (damaged)
std::optional<ChunkRecord> readRecord(const Plan& plan, const fs::path& directory, int number) {
    const VideoChunk& chunk = plan.chunk(number);
    const fs::path folder = folderOf(directory, number);
    const fs::path file = folder / kChunkFile;
    std::error_code error;
    if (!fs::exists(file, error)) return std::nullopt;
    const Json json =
        parseJson(readFile(file, kMaxFileBytes), file.string(), "a record of a chunk", kLimits);
    const Members all(json, file);
    if (all.text("format") != kChunkFormat || all.whole("version", 0, 1000) != kVersion) all.fail();
    if (all.bits("plan") != plan.id) return std::nullopt;
    ChunkRecord record;
    record.host = all.text("host");
    record.processor = all.bits("processor");
    const Json& list = all.list("segments");
    const std::size_t first = plan.segmentOf(chunk);
    if (list.size() != plan.segmentCount(chunk)) all.fail();
    for (std::size_t i = 0; i < list.size(); ++i) {
        const Members of(list[i], file);
        const SegmentPlan& planned = plan.segments[first + i];
        const std::string name = of.text("file");
        if (fs::path(name).stem() != numberedName(first + i, "") ||
            fs::path(name).filename() != name) {
            all.fail();
        }
        VideoSegment segment;
        segment.file = folder / name;
        segment.frames = of.whole("frames", 1, plan.segmentFrames);
        segment.pts = of.whole("pts", 0, kLatest);
        segment.end = of.whole("end", 0, kLatest);
        segment.times = of.bits("times");
        segment.bytes = static_cast<std::uintmax_t>(of.whole("bytes", 0, kLatest));
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

void requireSum(const VideoSegment& segment, std::uint64_t sum, int number) {
    if (fileChecksum(segment.file) == sum) return;
    throw Error(ErrorCode::BadFormat, segment.file.string(),
                "is damaged, expected the bytes that chunk " + std::to_string(number) +
                    " wrote; make this chunk again");
}

// Whether a chunk is made and every byte of it is right.
bool isWhole(const Plan& plan, const fs::path& directory, int number) {
    try {
        const std::optional<ChunkRecord> record = readRecord(plan, directory, number);
        if (!record) return false;
        for (std::size_t i = 0; i < record->segments.size(); ++i)
            requireSum(record->segments[i], record->sums[i], number);
        return true;
    } catch (const Error&) {
        return false;
    }
}

// The states that chunks leave for others. A state that cannot be used is as if it were not there,
// because depth can always be made from the start of the scene.
class States {
  public:
    States(const fs::path& directory, const Plan& plan, std::uint64_t processor)
        : directory_(directory / kStates), id_(plan.id), processor_(processor) {}

    void keep(std::int64_t frame, const SavedState& state) const {
        if (take(frame)) return;
        std::string bytes;
        append(bytes, id_);
        append(bytes, processor_);
        append(bytes, static_cast<std::uint64_t>(frame));
        bytes += state.bytes;
        append(bytes, checksum(bytes));
        writeFile(nameOf(frame), bytes);
    }

    std::optional<SavedState> take(std::int64_t frame) const {
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
            for (const std::uint64_t expected :
                 {id_, processor_, static_cast<std::uint64_t>(frame)}) {
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

  private:
    fs::path nameOf(std::int64_t frame) const {
        return directory_ / (std::to_string(frame) + ".state");
    }

    fs::path directory_;
    std::uint64_t id_;
    std::uint64_t processor_;
};

// A folder that is removed unless it is renamed.
class WorkFolder {
  public:
    explicit WorkFolder(const fs::path& target) : target_(target) {
        const auto now = Clock::now().time_since_epoch().count();
        path_ = target;
        path_ += "." + hostName() + "-" + std::to_string(getpid()) + "-" + std::to_string(now);
        std::error_code error;
        fs::create_directory(path_, error);
        if (error) {
            throw Error(ErrorCode::WriteFailed, path_.string(),
                        "cannot be made: " + error.message() +
                            ", expected the folder of the plan to be shared and writable");
        }
    }
    ~WorkFolder() { remove(); }
    WorkFolder(const WorkFolder&) = delete;
    WorkFolder& operator=(const WorkFolder&) = delete;

    const fs::path& path() const { return path_; }
    // Renames the folder to its target. False if the target exists.
    bool finish() {
        std::error_code error;
        fs::rename(path_, target_, error);
        if (error == std::errc::directory_not_empty || error == std::errc::file_exists)
            return false;
        if (error) {
            throw Error(ErrorCode::WriteFailed, target_.string(),
                        "cannot be made: " + error.message());
        }
        path_.clear();
        flushDirectoryOf(target_);
        return true;
    }
    // Moves another folder out of the way of finish().
    void moveAway() {
        std::error_code ignored;
        fs::path aside = path_;
        aside += "-old";
        fs::rename(target_, aside, ignored);
        fs::remove_all(aside, ignored);
    }

  private:
    void remove() {
        std::error_code ignored;
        if (!path_.empty()) fs::remove_all(path_, ignored);
    }

    fs::path target_;
    fs::path path_;
};

Json recordOf(const Plan& plan, std::uint64_t processor,
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

// The frames of a chunk, and the last state that another chunk has left for it.
ChunkRange rangeOf(const Plan& plan, int number, const States& states) {
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

VideoChunkPlan planVideoChunks(VideoConversion conversion, const fs::path& directory,
                               const VideoChunkOptions& options,
                               const VideoProgressFunction& goOn) {
    checkNumber(options.seconds >= 1 && options.seconds <= 86400, "seconds", options.seconds,
                "1..86400");
    requireFileInput(conversion);
    const Clock::time_point start = Clock::now();
    const UnfinishedRun unfinished = conversion.unfinished;
    const Dependence on = dependenceOf(conversion);
    const fs::path output = conversion.output;
    ConversionRun run(std::move(conversion), ChunkRange());
    Plan plan;
    {
        // Outputs that cannot be written must fail now, not after all chunks are made.
        VideoReader source(run.conversion.input, run.conversion.part);
        plan.shown.notes = VideoWriter(output, run.encoding, &source).notes();
    }
    plan.settings = settingsJson(run.stamp);
    plan.settings["length of chunks"] = numberText(options.seconds);
    std::error_code error;
    if (unfinished == UnfinishedRun::Discard) removePlan(directory);
    if (fs::exists(directory / kPlanFile, error)) {
        const Plan there = readPlan(directory);
        const std::string other = differenceOf(there.settings, plan.settings);
        if (!other.empty()) {
            throw Error(ErrorCode::Mismatch, directory.string(),
                        "holds a plan with other settings (" + other + "), expected a new folder");
        }
        makeFolders(directory);
        return there.shown;
    }
    makeFolders(directory);
    plan.segmentFrames = segmentFramesFor(run.encoding.frameRate);
    plan.shown.threads = cv::getNumThreads();
    VideoProgress progress;
    progress.framesInAll = run.reader->facts().frameCount;
    const Survey survey = surveyOf(*run.reader, plan.segmentFrames, on, goOn, progress);
    if (survey.cancelled) {
        plan.shown.cancelled = true;
        return plan.shown;
    }
    if (survey.frames == 0) {
        throw Error(ErrorCode::BadFormat, run.conversion.input.string(),
                    "holds no frames in this part, expected at least one");
    }
    const Notes notes = run.reader->notes();
    plan.shown.notes.insert(plan.shown.notes.end(), notes.begin(), notes.end());
    const Fraction timeBase = run.reader->facts().timeBase;
    plan.segments = survey.segments;
    divide(plan, survey, on, options.seconds,
           static_cast<double>(survey.segments.back().end) * timeBase.value());
    setTimes(plan, timeBase);
    plan.shown.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    writeFile(directory / kPlanFile, dump(jsonOf(plan, timeBase)));
    return plan.shown;
}

VideoChunkPlan readVideoChunks(const fs::path& directory) {
    return readPlan(directory).shown;
}

bool isVideoChunkMade(const fs::path& directory, int number) {
    const Plan plan = readPlan(directory);
    static_cast<void>(plan.chunk(number));
    try {
        return readRecord(plan, directory, number).has_value();
    } catch (const Error&) {
        return false;
    }
}

VideoConversionResult makeVideoChunk(VideoConversion conversion, const fs::path& directory,
                                     int number, const VideoProgressFunction& goOn) {
    const Plan plan = readPlan(directory);
    const VideoChunk& chunk = plan.chunk(number);
    requireFileInput(conversion);
    const std::uint64_t processor = processorOf(conversion);
    const States states(directory, plan, processor);
    ChunkRange range = rangeOf(plan, number, states);
    const fs::path target = folderOf(directory, number);
    WorkFolder work(target);
    range.directory = work.path();
    ConversionRun run(std::move(conversion), range);
    requireSettings(plan, settingsJson(run.stamp), directory);
    if (isWhole(plan, directory, number)) {
        VideoConversionResult result;
        result.frames = result.keptFrames = chunk.frames;
        result.end = chunk.end;
        return result;
    }
    VideoConversionResult result = run.run(goOn);
    if (result.cancelled) return result;
    const std::vector<VideoSegment>& segments = run.sink->chunk();
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const SegmentPlan& planned = plan.segments[plan.segmentOf(chunk) + i];
        if (segments[i].times == planned.times && segments[i].pts == planned.pts) continue;
        throw Error(ErrorCode::Mismatch, run.conversion.input.string(),
                    "has frames at other times than when the plan was made, expected the same "
                    "file and the same FFmpeg");
    }
    writeFile(work.path() / kChunkFile, dump(recordOf(plan, processor, segments)));
    if (!work.finish() && !isWhole(plan, directory, number)) {
        work.moveAway();
        if (!work.finish() && !isWhole(plan, directory, number)) {
            throw Error(ErrorCode::WriteFailed, target.string(),
                        "is in use, expected a folder that can be replaced");
        }
    }
    return result;
}

VideoConversionResult joinVideoChunks(VideoConversion conversion, const fs::path& directory,
                                      const VideoProgressFunction& goOn) {
    const Plan plan = readPlan(directory);
    requireFileInput(conversion);
    const Clock::time_point start = Clock::now();
    const fs::path output = conversion.output;
    ConversionRun run(std::move(conversion), ChunkRange());
    requireSettings(plan, settingsJson(run.stamp), directory);

    std::vector<int> order; // numbers of the chunks with pictures
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
        std::optional<ChunkRecord> record = readRecord(plan, directory, number);
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
                        listed(missing) + " yet, expected all " + std::to_string(order.size()));
    }

    VideoConversionResult result;
    VideoProgress progress;
    progress.framesInAll = plan.shown.frames;
    std::size_t at = 0;
    const auto before = [&](const VideoSegment& segment) {
        if (goOn && !goOn(progress)) return false;
        requireSum(segment, sums[at].first, sums[at].second);
        ++at;
        progress.frames += segment.frames;
        return true;
    };
    VideoReader source(run.conversion.input, run.conversion.part);
    result.cancelled =
        !SegmentJoiner::join(output, run.encoding, segments, &source, true, before, result.notes);
    if (result.cancelled) return result;
    result.frames = result.keptFrames = plan.shown.frames;
    result.end = plan.shown.end;
    result.finishSeconds = std::chrono::duration<double>(Clock::now() - start).count();
    return result;
}

} // namespace altiro3D
