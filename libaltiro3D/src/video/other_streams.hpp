#pragma once

#include "altiro3D/video_types.hpp"
#include "video/ffmpeg.hpp"

#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

namespace altiro3D {

/// A stream beside the video, as its reader found it.
struct OtherStream {
    int index = 0; ///< in the file
    ParametersPtr parameters;
    AVRational timeBase{0, 1};
    VideoTags tags;
    int disposition = 0;
    bool isCover = false;
};

/// All of a video file but its pictures, handed from its reader to a writer, which may be in
/// another thread. What the reader sets before the first packet does not change afterwards.
class OtherStreams {
  public:
    std::vector<OtherStream> streams;
    std::vector<VideoChapter> chapters; ///< Times from the start of what is read, clipped to it.
    VideoTags tags;
    VideoColour colour;
    std::string subject; ///< the file, for errors
    std::string format;  ///< FFmpeg's name of the container

    /// The writer asks for packets. @return false if the reader has begun without it
    bool want();
    /// The reader begins. @return true if packets are wanted
    bool begin();
    /// The writer takes the packets of `streams[index]`; said before the reader begins.
    void take(std::size_t index);
    bool isTaken(std::size_t index) const;
    /// The reader hands a packet of `streams[index]` over, times as in the file. What nobody takes
    /// is dropped: it would pile up.
    void push(std::size_t index, PacketPtr packet);
    /// Begins again: what was handed over is dropped.
    void clear();
    /// @param origin file time that is 0, in `unit`
    /// @param end file time where what is wanted ends, in `unit`
    /// @param clip what lies before the origin is not wanted
    void setRange(std::int64_t origin, std::optional<std::int64_t> end, AVRational unit, bool clip);
    /// The reader has come to its end.
    void end();
    bool hasEnded() const;

    /// The next packet of a stream that begins before a time, moved so that the origin is 0; null
    /// if none is there yet.
    ///
    /// @param before in `unit`, from the origin; none: any
    PacketPtr pop(std::size_t index, std::optional<std::int64_t> before, AVRational unit);

  private:
    mutable std::mutex mutex_;
    std::vector<std::deque<PacketPtr>> packets_; // by stream
    std::set<std::size_t> taken_;
    std::int64_t origin_ = 0;
    std::optional<std::int64_t> end_;
    AVRational unit_{1, AV_TIME_BASE};
    bool clip_ = false; // what lies before the origin is dropped or shortened
    bool wanted_ = false;
    bool begun_ = false;
    bool ended_ = false;
};

} // namespace altiro3D
