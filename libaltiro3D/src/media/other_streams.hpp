#pragma once

#include "altiro3D/image_io.hpp"
#include "altiro3D/video_io.hpp"
#include "media/ffmpeg.hpp"

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace altiro3D {

/// A stream of the file other than the video.
struct OtherStream {
    int index = 0; ///< in the file
    ParametersPtr parameters;
    AVRational timeBase{0, 1};
    VideoTags tags;
    int disposition = 0;
    bool isCover = false;
    bool isEncrypted = false;
};

/// Everything in a video file except its pictures, passed from its reader to a writer, which may be
/// in another thread. Data that the reader sets before the first packet does not change afterwards.
class OtherStreams {
  public:
    std::vector<OtherStream> streams;
    /// Times from the start of the part that is read, clipped to it.
    std::vector<VideoChapter> chapters;
    VideoTags tags;
    VideoColour colour;
    std::string subject; ///< name of the file, for errors

    /// Called by the writer to request packets. @return false if the reader has already begun
    bool want() {
        const Lock lock(mutex_);
        wanted_ = wanted_ || !begun_;
        return !begun_;
    }
    /// Called by the reader at its start. @return true if packets are wanted
    bool begin() {
        const Lock lock(mutex_);
        begun_ = true;
        packets_.resize(streams.size());
        return wanted_;
    }
    /// Called by the writer before the reader begins: requests the packets of `streams[index]`.
    void take(std::size_t index) {
        const Lock lock(mutex_);
        taken_.insert(index);
    }
    bool isTaken(std::size_t index) const {
        const Lock lock(mutex_);
        return taken_.count(index) != 0;
    }
    /// Called by the reader to pass a packet of `streams[index]`, times as in the file. Packets
    /// that were not requested are dropped.
    void push(std::size_t index, PacketPtr packet) {
        const Lock lock(mutex_);
        if (taken_.count(index) != 0) packets_[index].push_back(std::move(packet));
    }
    /// Drops all packets, for a restart.
    void clear() {
        const Lock lock(mutex_);
        for (auto& queue : packets_)
            queue.clear();
    }
    /// @param origin file time that is 0, in `unit`
    /// @param end file time of the end of the part, in `unit`
    /// @param clip whether packets before the origin are dropped or shortened
    void setRange(std::int64_t origin, std::optional<std::int64_t> end, AVRational unit,
                  bool clip) {
        const Lock lock(mutex_);
        std::tie(origin_, end_, unit_, clip_) = std::tie(origin, end, unit, clip);
    }
    /// Called by the reader at its end.
    void end() { ended_ = true; }
    bool hasEnded() const { return ended_; }

    /// The next packet of a stream that begins before a time, with times relative to the origin;
    /// null if there is none yet. @param before in `unit`, from the origin; none = no limit
    PacketPtr pop(std::size_t index, std::optional<std::int64_t> before, AVRational unit);

  private:
    using Lock = std::lock_guard<std::mutex>;

    mutable std::mutex mutex_;
    std::vector<std::deque<PacketPtr>> packets_; // by stream
    std::set<std::size_t> taken_;
    std::int64_t origin_ = 0;
    std::optional<std::int64_t> end_;
    AVRational unit_{1, AV_TIME_BASE};
    bool clip_ = false; // packets before the origin are dropped or shortened
    bool wanted_ = false;
    bool begun_ = false;
    std::atomic<bool> ended_ = false;
};

/// Writes the streams other than the video to a container. Packets are copied; text subtitles are
/// converted if the container requires another format.
class StreamCopier {
  public:
    /// Adds the streams to the container, which already has its video stream.
    /// @param path path of the output, for errors
    /// @param wanted says which kinds of streams and data are kept
    /// @param notes receives what is left out or converted
    /// @throws Error Unsupported (names what the container does not support, with advice)
    StreamCopier(std::shared_ptr<OtherStreams> source, AVFormatContext& output,
                 const std::string& path, const VideoWriterOptions& wanted, Notes& notes);

    /// Writes the packets that begin before a time, or all available packets.
    /// @return 0 or FFmpeg's error number
    int copy(std::optional<std::int64_t> before, AVRational unit);

    /// Whether the reader has delivered all packets.
    bool sourceHasEnded() const { return source_->hasEnded(); }

  private:
    struct Route {
        std::size_t from = 0; // index into the source's streams
        AVStream* to = nullptr;
        CodecPtr decoder; // for subtitles that are converted
        CodecPtr encoder;
        std::int64_t lastDts = AV_NOPTS_VALUE;
    };

    Route& addRoute(std::size_t index);
    void addChapters();
    void addCopy(std::size_t index);
    bool addConversion(std::size_t index, AVCodecID to);
    bool canHold(const AVCodecParameters& parameters) const;
    PacketPtr convert(Route& route, AVPacket& packet);
    int writePacket(Route& route, PacketPtr packet);

    std::shared_ptr<OtherStreams> source_;
    AVFormatContext& output_;
    std::vector<Route> routes_;
};

} // namespace altiro3D
