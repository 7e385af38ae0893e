#include "media/video_segments.hpp"

#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/state_bytes.hpp"
#include "media/ffmpeg.hpp"
#include "media/video_container.hpp"

#include <algorithm>
#include <deque>
#include <limits>
#include <system_error>
#include <utility>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max() / 8; // limit of any time
constexpr std::int64_t kToTheEnd = std::numeric_limits<std::int64_t>::max(); // later than any time

// A container that holds the codec and keeps times exactly, except Matroska, which keeps ms.
const char* segmentExtension(VideoCodec codec) {
    return codec == VideoCodec::Ffv1 ? ".mkv" : codec == VideoCodec::ProRes ? ".mov" : ".mp4";
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

std::uint64_t mixTime(std::uint64_t sum, const VideoFrame& frame) {
    return mixIn(mixIn(sum, static_cast<std::uint64_t>(frame.pts)),
                 static_cast<std::uint64_t>(frame.duration));
}

std::string numberedName(std::size_t number, const std::string& ending) {
    const std::string digits = std::to_string(number + 1);
    return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits + ending;
}

std::string segmentName(std::size_t number, VideoCodec codec) {
    return numberedName(number, segmentExtension(codec));
}

SegmentWriter::SegmentWriter(fs::path directory, VideoWriterOptions options, int segmentFrames,
                             std::size_t number, std::int64_t earliest)
    : directory_(std::move(directory)), options_(std::move(options)), segmentFrames_(segmentFrames),
      number_(number), earliest_(earliest) {
    options_.tags.clear(); // they describe the whole file
}

SegmentWriter::~SegmentWriter() = default;

bool SegmentWriter::write(const VideoFrame& frame) {
    if (!writer_) {
        check(frame.pts >= earliest_, "frame",
              "has the time " + std::to_string(frame.pts) + ", expected " +
                  std::to_string(earliest_) + " or more");
        current_ = VideoSegment();
        current_.file = directory_ / segmentName(number_, options_.codec);
        current_.pts = frame.pts;
        writer_ = std::make_unique<VideoWriter>(current_.file, options_);
    }
    VideoFrame moved = frame;
    moved.pts -= current_.pts;
    writer_->write(moved);
    current_.end = frame.pts + std::max<std::int64_t>(frame.duration, 1);
    current_.times = mixTime(current_.times, frame);
    return ++current_.frames == segmentFrames_;
}

VideoSegment SegmentWriter::end() {
    writer_->finish();
    writer_.reset();
    std::error_code error;
    current_.bytes = fs::file_size(current_.file, error);
    if (error) {
        throw Error(ErrorCode::WriteFailed, current_.file.string(),
                    "cannot be examined: " + error.message() + ", expected a whole segment");
    }
    current_.reorderedPlaces = reorderedPlaces(timesShown(current_.file));
    earliest_ = current_.end;
    ++number_;
    return current_;
}

void SegmentWriter::drop() {
    writer_.reset();
    std::error_code ignored;
    if (!current_.file.empty()) fs::remove(current_.file, ignored);
}

// Copies the packets of all segments. In each of them pictures are decoded up to `reordered` places
// before their turn, so the time to decode the i-th picture is the time of picture i - reordered in
// the order of display: earlier than its own, and always rising.
bool SegmentJoiner::join(const fs::path& path, const VideoWriterOptions& options,
                         const std::vector<VideoSegment>& segments, VideoReader* source,
                         bool toTheEnd, const std::function<bool(const VideoSegment&)>& before,
                         Notes& notes) {
    const AVRational timeBase = rational(options.timeBase);
    std::shared_ptr<OtherStreams> others;
    if (source != nullptr) {
        others = source->otherStreams();
        check(others->want(), "source", "has delivered a frame already, expected one opened anew");
    }
    // Reads the source's other streams up to a time; false at its end.
    const auto pass = [&](std::int64_t until) {
        if (source == nullptr) return false;
        const AVRational ofSource = rational(source->facts().timeBase);
        return source->pass(until < kToTheEnd ? av_rescale_q(until, timeBase, ofSource) : until);
    };
    std::size_t reordered = 0;
    for (const VideoSegment& segment : segments)
        reordered = std::max(reordered, static_cast<std::size_t>(segment.reorderedPlaces));
    VideoContainer container(path);
    std::deque<std::int64_t> decodeTimes; // times of the pictures to come, in display order
    bool begun = false;
    const PacketPtr packet = newPacket();
    for (const VideoSegment& segment : segments) {
        if (before && !before(segment)) return false;
        const fs::path& file = segment.file;
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
            const ParametersPtr parameters = copyOf(*reader.stream().codecpar);
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
            pass(end);
            container.copyOthers(end);
        }
    }
    while (toTheEnd && pass(kToTheEnd)) {
    }
    container.finish(segments.back().end, notes);
    return true;
}

} // namespace altiro3D
