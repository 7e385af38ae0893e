#include "altiro3D/video_io.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/json_reader.hpp"
#include "base/posix_file.hpp"
#include "base/text.hpp"
#include "video/ffmpeg.hpp"
#include "video/video_container.hpp"

#include <algorithm>
#include <cerrno>
#include <deque>
#include <fcntl.h>
#include <functional>
#include <limits>
#include <system_error>
#include <unistd.h>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFormat = "altiro3D video run";
constexpr int kVersion = 1;
constexpr const char* kState = ".state"; // extension of saved states
constexpr int kMaxSegmentFrames = 100000;
constexpr std::uintmax_t kMaxRunBytes = std::uintmax_t{64} << 20;
constexpr JsonLimits kRunLimits{8, 1000, false};                               // ours has 3 levels
constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max() / 8; // of any time
constexpr std::int64_t kToTheEnd = std::numeric_limits<std::int64_t>::max(); // later than any time
constexpr std::uintmax_t kMaxStateBytes = std::uintmax_t{1} << 30;

// Frames that were written at a time.
struct Segment {
    std::string file;
    std::int64_t frames = 0;
    std::int64_t pts = 0; // of the first one
    std::int64_t end = 0; // of the last one
    std::uintmax_t bytes = 0;
    std::string stateFile;
};

// A container that holds the codec and keeps times exactly, but for Matroska, which keeps ms.
const char* segmentExtension(VideoCodec codec) {
    switch (codec) {
    case VideoCodec::Ffv1:
        return ".mkv";
    case VideoCodec::ProRes:
        return ".mov";
    default:
        return ".mp4";
    }
}

std::string numbered(std::size_t number, const std::string& ending) {
    const std::string digits = std::to_string(number);
    return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits + ending;
}

// Locks a directory against other processes while the handle is open.
FileHandle lockDirectory(const fs::path& directory) {
    FileHandle handle = openFile(directory, O_RDONLY | O_DIRECTORY);
    if (!handle.isOpen()) {
        throw Error(ErrorCode::WriteFailed, directory.string(),
                    "cannot be opened: " + std::generic_category().message(errno));
    }
    if (!lockFile(handle)) {
        throw Error(ErrorCode::WriteFailed, directory.string(),
                    "is in use by another process, expected one run at a time");
    }
    return handle;
}

// The first setting that differs, as a sentence; empty if none does. Settings that only one run has
// come first, because other differences may follow from them.
std::string difference(const Json& before, const Json& now) {
    const auto text = [](const Json& all, const std::string& name) {
        if (!all.contains(name)) return std::string("not set");
        if (!all[name].is_string()) return all[name].dump();
        const auto given = all[name].get<std::string>();
        return given.empty() ? std::string("set") : given;
    };
    for (const bool inBoth : {false, true}) {
        for (const Json* all : {&before, &now}) {
            for (const auto& item : all->items()) {
                const std::string& name = item.key();
                if ((before.contains(name) && now.contains(name)) != inBoth) continue;
                if (text(before, name) != text(now, name))
                    return name + " was " + text(before, name) + " and is " + text(now, name);
            }
        }
    }
    return {};
}

std::uintmax_t sizeOf(const fs::path& file) {
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(file, error);
    if (error) {
        throw Error(ErrorCode::WriteFailed, file.string(),
                    "cannot be examined: " + error.message() + ", expected a whole segment");
    }
    return bytes;
}

// The packets of one segment, in the order in which they are decoded.
class SegmentReader {
  public:
    explicit SegmentReader(const fs::path& file) : file_(file) {
        AVFormatContext* raw = nullptr;
        const int result =
            avformat_open_input(&raw, ("file:" + file.string()).c_str(), nullptr, nullptr);
        if (result < 0) fail(result);
        input_.reset(raw);
        if (raw->nb_streams != 1) fail(AVERROR_INVALIDDATA);
    }

    const AVStream& stream() const { return *input_->streams[0]; }

    // False at the end.
    bool read(AVPacket& packet) {
        const int result = av_read_frame(input_.get(), &packet);
        if (result < 0 && result != AVERROR_EOF) fail(result);
        return result >= 0;
    }

  private:
    [[noreturn]] void fail(int result) const {
        if (result == AVERROR(ENOMEM)) checkMemory(nullptr);
        throw Error(ErrorCode::BadFormat, file_.string(),
                    "cannot be read: " + ffmpegText(result) + ", expected a whole segment");
    }

    fs::path file_;
    InputPtr input_;
};

// Display times of the pictures of a segment, in the segment's unit, in decoding order.
std::vector<std::int64_t> timesShown(const fs::path& file) {
    SegmentReader reader(file);
    const PacketPtr packet = newPacket();
    std::vector<std::int64_t> times;
    while (reader.read(*packet)) {
        times.push_back(packet->pts);
        av_packet_unref(packet.get());
    }
    return times;
}

// The largest number of places by which a picture is decoded before its turn.
int reorderedPlaces(const std::vector<std::int64_t>& times) {
    std::vector<std::int64_t> sorted = times;
    std::sort(sorted.begin(), sorted.end());
    std::ptrdiff_t most = 0;
    for (std::size_t i = 0; i < times.size(); ++i) {
        const auto place = std::lower_bound(sorted.begin(), sorted.end(), times[i]);
        most = std::max(most, static_cast<std::ptrdiff_t>(i) - (place - sorted.begin()));
    }
    return static_cast<int>(most);
}

} // namespace

struct ResumableVideoWriter::Impl {
    Impl(const fs::path& givenPath, const VideoWriterOptions& givenOptions,
         const ResumableVideoOptions& givenResumable, VideoReader* source);
    ~Impl();
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void write(const VideoFrame& frame, const SavedState& state);
    bool keepsWork() const { return listed_ > 0; }
    // @param pass reads the source's other streams up to a time in the options' time base; false at
    //        its end
    void finish(const std::shared_ptr<OtherStreams>& others,
                const std::function<bool(std::int64_t)>& pass, bool complete);

    fs::path path;
    fs::path directory;
    VideoWriterOptions options;
    int segmentFrames;
    KeptVideo kept;
    Notes notes;

  private:
    void readRun(const Json& settings);
    void writeRun();
    void closeSegment(const SavedState& state, bool listed);
    void join(VideoContainer& container, const std::shared_ptr<OtherStreams>& others,
              const std::function<bool(std::int64_t)>& pass);

    Json settings_;
    FileHandle lock_;
    std::vector<Segment> segments_; // whole ones
    std::size_t listed_ = 0;        // of them, in run.json
    int reordered_ = 0;             // see reorderedPlaces(), over all segments
    Segment current_;
    std::unique_ptr<VideoWriter> writer_; // of the current segment
    bool finished_ = false;
    bool complete_ = false; // and nothing is kept
};

ResumableVideoWriter::Impl::Impl(const fs::path& givenPath, const VideoWriterOptions& givenOptions,
                                 const ResumableVideoOptions& givenResumable, VideoReader* source)
    : path(givenPath), directory(partsDirectory(givenPath)), options(givenOptions),
      segmentFrames(givenResumable.segmentFrames) {
    check(segmentFrames >= 1 && segmentFrames <= kMaxSegmentFrames, "segmentFrames",
          "is " + std::to_string(segmentFrames) + ", expected 1.." +
              std::to_string(kMaxSegmentFrames));
    if (source != nullptr && !options.colour) options.colour = source->facts().colour;
    // Outputs that cannot be written must fail now, not after all frames are made.
    notes = VideoWriter(path, options, source).notes();
    // As run.json holds them: bytes that are not UTF-8 are replaced.
    settings_ = Json::parse(
        Json(givenResumable.settings).dump(-1, ' ', false, Json::error_handler_t::replace));
    const bool there = isUnfinished(path);
    if (there && !givenResumable.resume) {
        throw Error(ErrorCode::WriteFailed, path.string(),
                    "an unfinished run of it is kept in " + directory.string() +
                        ", expected it to be resumed or discarded");
    }
    std::error_code error;
    fs::create_directory(directory, error);
    if (error) {
        throw Error(ErrorCode::WriteFailed, directory.string(),
                    "cannot be made: " + error.message());
    }
    lock_ = lockDirectory(directory);
    // Removes small files that an interrupted run left incomplete.
    for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        std::error_code ignored;
        if (name.rfind(".altiro3D-", 0) == 0) fs::remove(entry->path(), ignored);
    }
    if (there) {
        readRun(settings_);
    } else {
        writeRun();
    }
}

// Removes the directory of a run that has kept nothing.
ResumableVideoWriter::Impl::~Impl() {
    if (complete_ || keepsWork()) return;
    writer_.reset();
    std::error_code ignored;
    for (const std::string& file : {current_.file, current_.stateFile}) {
        if (!file.empty()) fs::remove(directory / file, ignored);
    }
    fs::remove(directory / "run.json", ignored);
    fs::remove(directory, ignored); // fails if other files are in it
}

void ResumableVideoWriter::Impl::readRun(const Json& settings) {
    const fs::path file = directory / "run.json";
    const auto fail = [&](const std::string& problem) {
        throw Error(ErrorCode::BadFormat, file.string(), problem + ", expected an unfinished run");
    };
    const std::string text = readFile(file, kMaxRunBytes);
    const Json run = parseJson(text, file.string(), "an unfinished run", kRunLimits);
    const auto whole = [&](const Json& value, std::int64_t least, std::int64_t most) {
        if (!value.is_number_integer() || value.get<std::int64_t>() < least ||
            value.get<std::int64_t>() > most) {
            fail("is damaged");
        }
        return value.get<std::int64_t>();
    };
    try {
        if (run.at("format") != kFormat || run.at("version") != kVersion) fail("is not a run");
        const std::string other = difference(run.at("settings"), settings);
        if (!other.empty()) {
            throw Error(ErrorCode::Mismatch, path.string(),
                        "was begun with other settings (" + other + "), expected the same");
        }
        if (run.at("segmentFrames") != segmentFrames ||
            run.at("timeBase") !=
                Json({options.timeBase.numerator, options.timeBase.denominator})) {
            fail("was begun for another video");
        }
        reordered_ = static_cast<int>(whole(run.at("reorderedPlaces"), 0, segmentFrames));
        std::string stateFile;
        for (const Json& entry : run.at("segments")) {
            Segment segment{entry.at("file"),
                            whole(entry.at("frames"), 1, segmentFrames),
                            whole(entry.at("pts"), 0, kLatest),
                            whole(entry.at("end"), 0, kLatest),
                            static_cast<std::uintmax_t>(whole(entry.at("bytes"), 0, kLatest)),
                            entry.at("state")};
            // Each has a fixed name; any other name could lead out of the directory.
            const std::size_t number = segments_.size() + 1;
            const auto checkName = [&](const std::string& name, const std::string& expected) {
                if (name != expected) fail("lists \"" + name + "\" in place of " + expected);
            };
            checkName(segment.file, numbered(number, segmentExtension(options.codec)));
            if (!segment.stateFile.empty()) checkName(segment.stateFile, numbered(number, kState));
            std::error_code error;
            if (fs::file_size(directory / segment.file, error) != segment.bytes || error) {
                fail("lists " + segment.file + ", which is missing or damaged");
            }
            if (segment.pts < kept.nextPts || segment.end <= segment.pts) {
                fail("lists " + segment.file + " with impossible times");
            }
            kept.frames += segment.frames;
            kept.nextPts = segment.end;
            stateFile = segment.stateFile;
            segments_.push_back(std::move(segment));
        }
        listed_ = segments_.size();
        if (!stateFile.empty()) kept.state.bytes = readFile(directory / stateFile, kMaxStateBytes);
    } catch (const Json::exception&) {
        fail("is damaged");
    }
}

void ResumableVideoWriter::Impl::writeRun() {
    Json list = Json::array();
    for (const Segment& segment : segments_) {
        list.push_back({{"file", segment.file},
                        {"frames", segment.frames},
                        {"pts", segment.pts},
                        {"end", segment.end},
                        {"bytes", segment.bytes},
                        {"state", segment.stateFile}});
    }
    const Json run = {{"format", kFormat},
                      {"version", kVersion},
                      {"settings", settings_},
                      {"timeBase", {options.timeBase.numerator, options.timeBase.denominator}},
                      {"segmentFrames", segmentFrames},
                      {"reorderedPlaces", reordered_},
                      {"segments", list}};
    writeFile(directory / "run.json",
              run.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
    listed_ = segments_.size();
}

void ResumableVideoWriter::Impl::write(const VideoFrame& frame, const SavedState& state) {
    check(!finished_, "write", "comes after finish()");
    if (!writer_) {
        const std::int64_t earliest = segments_.empty() ? 0 : segments_.back().end;
        check(frame.pts >= earliest, "frame",
              "has the time " + std::to_string(frame.pts) + ", expected " +
                  std::to_string(earliest) + " or more");
        current_ = Segment();
        current_.file = numbered(segments_.size() + 1, segmentExtension(options.codec));
        current_.pts = frame.pts;
        VideoWriterOptions ofSegment = options;
        ofSegment.tags.clear();
        writer_ = std::make_unique<VideoWriter>(directory / current_.file, ofSegment);
    }
    VideoFrame moved = frame;
    moved.pts -= current_.pts;
    writer_->write(moved);
    current_.end = frame.pts + std::max<std::int64_t>(frame.duration, 1);
    if (++current_.frames == segmentFrames) closeSegment(state, true);
}

void ResumableVideoWriter::Impl::closeSegment(const SavedState& state, bool listed) {
    writer_->finish();
    writer_.reset();
    const fs::path file = directory / current_.file;
    current_.bytes = sizeOf(file);
    reordered_ = std::max(reordered_, reorderedPlaces(timesShown(file)));
    if (listed && !state.bytes.empty()) {
        current_.stateFile = numbered(segments_.size() + 1, kState);
        writeFile(directory / current_.stateFile, state.bytes);
    }
    segments_.push_back(current_);
    if (!listed) return;
    writeRun();
    // Earlier states are no longer needed.
    if (segments_.size() < 2) return;
    const std::string& old = segments_[segments_.size() - 2].stateFile;
    std::error_code ignored;
    if (!old.empty()) fs::remove(directory / old, ignored);
}

// Copies the packets of all segments. In each of them pictures are decoded up to `reordered_`
// places before their turn, so the time to decode the i-th picture is the time of picture
// i - reordered_ in the order of display: earlier than its own, and always rising.
void ResumableVideoWriter::Impl::join(VideoContainer& container,
                                      const std::shared_ptr<OtherStreams>& others,
                                      const std::function<bool(std::int64_t)>& pass) {
    const AVRational timeBase = rational(options.timeBase);
    const auto reordered = static_cast<std::size_t>(reordered_);
    std::deque<std::int64_t> decodeTimes; // of the pictures to come, in display order
    bool begun = false;
    const PacketPtr packet = newPacket();
    for (const Segment& segment : segments_) {
        const fs::path file = directory / segment.file;
        std::vector<std::int64_t> shown = timesShown(file);
        if (shown.size() != static_cast<std::size_t>(segment.frames)) {
            throw Error(ErrorCode::BadFormat, file.string(),
                        "holds " + std::to_string(shown.size()) + " frames, expected " +
                            std::to_string(segment.frames));
        }
        SegmentReader reader(file);
        const auto moved = [&](std::int64_t pts) { // AV_NOPTS_VALUE stays far outside
            const std::int64_t after = av_rescale_q(pts, reader.stream().time_base, timeBase);
            if (after < -kLatest || after > kLatest) {
                throw Error(ErrorCode::BadFormat, file.string(),
                            "has frames without a time, expected a whole segment");
            }
            return segment.pts + after;
        };
        std::transform(shown.begin(), shown.end(), shown.begin(), moved);
        std::sort(shown.begin(), shown.end());
        if (!begun) {
            begun = true;
            const ParametersPtr parameters(avcodec_parameters_alloc());
            checkMemory(parameters.get());
            if (avcodec_parameters_copy(parameters.get(), reader.stream().codecpar) < 0) {
                checkMemory(nullptr);
            }
            if (container.isMatroska()) parameters->codec_tag = 0;
            Notes known; // from the beginning
            container.open(*parameters, options, others, known);
            for (std::size_t i = 0; i < reordered; ++i) { // as much before the first as after it
                const std::size_t mirror = std::min(reordered - i, shown.size() - 1);
                const auto missing = static_cast<std::int64_t>(reordered - i - mirror);
                decodeTimes.push_back(2 * shown.front() - shown[mirror] - missing);
            }
        }
        decodeTimes.insert(decodeTimes.end(), shown.begin(), shown.end());
        while (reader.read(*packet)) {
            packet->pts = moved(packet->pts);
            const auto next = std::upper_bound(shown.begin(), shown.end(), packet->pts);
            packet->duration = (next != shown.end() ? *next : segment.end) - packet->pts;
            packet->dts = decodeTimes.front();
            decodeTimes.pop_front();
            const std::int64_t end = packet->pts + packet->duration;
            container.write(*packet);
            if (pass) pass(end);
            container.copyOthers(end);
        }
    }
}

void ResumableVideoWriter::Impl::finish(const std::shared_ptr<OtherStreams>& others,
                                        const std::function<bool(std::int64_t)>& pass,
                                        bool complete) {
    check(!finished_, "finish", "comes twice");
    const std::size_t whole = segments_.size();
    if (writer_) closeSegment({}, complete);
    check(!segments_.empty(), "finish", "comes before the first frame");
    VideoContainer container(path);
    join(container, others, pass);
    const std::int64_t end = segments_.back().end;
    while (complete && pass && pass(kToTheEnd)) {
    }
    container.finish(end, notes);
    finished_ = true;
    if (complete) {
        std::error_code ignored; // the file is there
        fs::remove_all(directory, ignored);
        complete_ = true;
        listed_ = 0;
    } else if (segments_.size() > whole) {
        std::error_code ignored;
        fs::remove(directory / segments_.back().file, ignored);
        segments_.pop_back();
    }
}

fs::path ResumableVideoWriter::partsDirectory(const fs::path& path) {
    fs::path directory = path;
    directory += ".parts";
    return directory;
}

bool ResumableVideoWriter::isUnfinished(const fs::path& path) {
    std::error_code error;
    return fs::exists(partsDirectory(path) / "run.json", error);
}

void ResumableVideoWriter::discard(const fs::path& path) {
    if (!isUnfinished(path)) return; // not our directory
    const fs::path directory = partsDirectory(path);
    const FileHandle lock = lockDirectory(directory);
    std::error_code error;
    fs::remove_all(directory, error);
    if (error) {
        throw Error(ErrorCode::WriteFailed, directory.string(),
                    "cannot be removed: " + error.message());
    }
}

ResumableVideoWriter::ResumableVideoWriter(const fs::path& path, const VideoWriterOptions& options,
                                           const ResumableVideoOptions& resumable,
                                           VideoReader* source)
    : impl_(std::make_unique<Impl>(path, options, resumable, source)) {}
ResumableVideoWriter::~ResumableVideoWriter() = default;
ResumableVideoWriter::ResumableVideoWriter(ResumableVideoWriter&&) noexcept = default;
ResumableVideoWriter& ResumableVideoWriter::operator=(ResumableVideoWriter&&) noexcept = default;

const KeptVideo& ResumableVideoWriter::kept() const {
    return impl_->kept;
}

bool ResumableVideoWriter::keepsWork() const {
    return impl_->keepsWork();
}

bool ResumableVideoWriter::endsSegment(std::int64_t frameNumber) const {
    return (frameNumber + 1) % impl_->segmentFrames == 0;
}

void ResumableVideoWriter::write(const VideoFrame& frame, const SavedState& state) {
    impl_->write(frame, state);
}

void ResumableVideoWriter::finish(VideoReader* source, bool complete) {
    if (source == nullptr) {
        impl_->finish(nullptr, {}, complete);
        return;
    }
    const std::shared_ptr<OtherStreams> others = source->otherStreams();
    check(others->want(), "source", "has delivered a frame already, expected one opened anew");
    const AVRational unit = rational(impl_->options.timeBase);
    const AVRational ofSource = rational(source->facts().timeBase);
    const auto pass = [&](std::int64_t until) {
        return source->pass(until < kToTheEnd ? av_rescale_q(until, unit, ofSource) : until);
    };
    impl_->finish(others, pass, complete);
}

const Notes& ResumableVideoWriter::notes() const {
    return impl_->notes;
}

} // namespace altiro3D
