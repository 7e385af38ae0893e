#pragma once

#include "altiro3D/image_io.hpp"
#include "video/ffmpeg.hpp"
#include "video/other_streams.hpp"

#include <memory>
#include <string>
#include <vector>

namespace altiro3D {

/// Brings the streams beside the video into a container: copied packet by packet, text subtitles
/// converted where the container asks for another form of them.
class StreamCopier {
  public:
    /// What is to be kept.
    struct Wanted {
        bool audio = true;
        bool subtitles = true;
        bool chapters = true;
        bool metadata = true;
    };

    /// Adds the streams to the container; its video stream is there already.
    ///
    /// @param path of the output, for errors
    /// @param notes what is left out or converted is added
    /// @throws Error Unsupported: what the container cannot hold, by name, with advice
    StreamCopier(std::shared_ptr<OtherStreams> source, AVFormatContext& output,
                 const std::string& path, const Wanted& wanted, Notes& notes);

    /// Writes the packets that begin before a time, or all that are there.
    /// @return 0 or FFmpeg's error number
    int copy(std::optional<std::int64_t> before, AVRational unit);

    /// The reader has delivered all.
    bool sourceHasEnded() const { return source_->hasEnded(); }

  private:
    struct Route {
        std::size_t from = 0; // of the source's streams
        AVStream* to = nullptr;
        CodecPtr decoder; // of subtitles that are converted
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
