#pragma once

#include "altiro3D/image_io.hpp"
#include "media/ffmpeg.hpp"
#include "media/other_streams.hpp"

#include <memory>
#include <string>
#include <vector>

namespace altiro3D {

/// Writes the streams other than the video to a container. Packets are copied; text subtitles are
/// converted if the container requires another format.
class StreamCopier {
  public:
    /// The kinds of streams and data to keep.
    struct Wanted {
        bool audio = true;
        bool subtitles = true;
        bool chapters = true;
        bool metadata = true;
    };

    /// Adds the streams to the container, which already has its video stream.
    ///
    /// @param path path of the output, for errors
    /// @param notes receives what is left out or converted
    /// @throws Error Unsupported (names what the container does not support, with advice)
    StreamCopier(std::shared_ptr<OtherStreams> source, AVFormatContext& output,
                 const std::string& path, const Wanted& wanted, Notes& notes);

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
