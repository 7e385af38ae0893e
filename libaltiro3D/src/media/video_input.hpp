#pragma once

#include "altiro3D/video_io.hpp"
#include "base/system_file.hpp"
#include "media/ffmpeg.hpp"

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

namespace altiro3D {

/// An open, unread video: its container, the stream to deliver and its decoder.
struct VideoInput {
    enum class Kind { File, Stream, Device };

    std::string subject; ///< name of the file, for errors
    Kind kind = Kind::File;
    FileHandle file;  ///< the pipe, which is opened once, or its copy; else none
    std::string head; ///< MP4: its box "moov"; Matroska: its beginning; else empty
    InputPtr format;
    AVStream* stream = nullptr; ///< the one to deliver; `format` owns it
    AVStream* twin = nullptr;   ///< the right eye's video, if it is joined to `stream`
    CodecPtr decoder;
    CodecPtr twinDecoder;
    std::set<int> encrypted; ///< indices of streams
    bool joinsEyes = false;  ///< both eyes' pictures are decoded, to be joined
    bool alternates = false; ///< frames show the eyes alternately; without joinsEyes only the left
                             ///< one's are delivered
    bool isMvc = false;      ///< a layer of H.264 that FFmpeg does not decode has the other eye
    bool rightFirst = false; ///< they begin with the right one
    std::deque<PacketPtr> ahead; ///< packets that were read to see what they state
    VideoFacts facts;
    Notes notes;               ///< remarks on what cannot be read
    std::int64_t startPts = 0; ///< start of the file, in the stream's unit
    double end = 0;            ///< stated end of the file, s from its start; 0 = not stated

    /// Whether a time leads to the same frame regardless of what was read before: false where the
    /// input cannot be sought, and where times may start again.
    bool hasFixedTimes() const;
    /// Whether the frames after a seek are known. They are not in a bare stream, which has no
    /// times, with alternating eyes, and with two videos, whose key frames may differ.
    bool canSeek() const;
    /// Reads the next packet. @return FFmpeg's number of an error, or at least 0
    int readPacket(AVPacket& packet);
};

/// Opens a video and reads its properties. @param options with `threads` > 0
/// @throws Error as VideoReader::VideoReader()
VideoInput openVideoInput(const std::filesystem::path& path, const VideoReaderOptions& options);

/// Counts the frames of a file that come before a time, from its packets alone.
/// @param path of a regular file @param from s from the start of the file
/// @return nothing where a packet may hold no frame or several, and where a time is missing
/// @throws Error as openVideoInput()
std::optional<std::int64_t> countPackets(const std::filesystem::path& path,
                                         VideoReaderOptions options, double from);

/// Opens a container and reads what its streams are. Sets all up to `format`, and `encrypted`.
/// @throws Error as VideoReader::VideoReader()
void openContainer(VideoInput& input, const std::filesystem::path& path,
                   const VideoReaderOptions& options);

} // namespace altiro3D
