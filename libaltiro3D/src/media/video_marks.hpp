#pragma once

#include "altiro3D/video_io.hpp"
#include "media/ffmpeg.hpp"

#include <filesystem>
#include <string>
#include <string_view>

extern "C" {
#include <libavutil/spherical.h>
}

/// What a video states of both eyes and of its projection, where FFmpeg does not read it.
namespace altiro3D {

/// What a file says of its streams: of MP4 the beginning of the box "moov", which has the sample
/// entries, of Matroska the beginning of the file. Empty: another format.
/// @param format FFmpeg's name of it
std::string streamHead(const std::filesystem::path& path, std::string_view format);

/// Refuses videos of a sphere or of half of one, because their pictures are bent.
/// @param stated by FFmpeg, or null @param head as of streamHead() @param facts size and eyes
/// @throws Error Unsupported, with the command that makes a flat video
void refuseSpherical(const std::string& subject, const AVSphericalMapping* stated,
                     std::string_view head, const VideoFacts& facts);

/// What the first packet of H.264 or HEVC states of both eyes.
struct EyesInPacket {
    bool isMvc = false;      ///< A second layer of H.264 holds the other eye's pictures.
    bool alternates = false; ///< Frames show the eyes by turns.
    bool rightFirst = false; ///< They begin with the right eye.
};

/// @param stream of the packet @param bytes of the packet; any bytes give a result
EyesInPacket eyesInPacket(const AVCodecParameters& stream, std::string_view bytes);

} // namespace altiro3D
