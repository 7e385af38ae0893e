#pragma once

#include "altiro3D/video_types.hpp"
#include "video/ffmpeg.hpp"
#include "video/video_picture.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D {

class OtherStreams;

/// A video that is open and has not been read from: its container, the stream to deliver and the
/// decoder of that.
struct VideoInput {
    enum class Kind { File, StandardInput, Device };

    std::string subject; ///< its name, for errors
    Kind kind = Kind::File;
    InputPtr format;
    AVStream* stream = nullptr; ///< the one to deliver; `format` owns it
    CodecPtr decoder;
    VideoFacts facts;
    Orientation orientation;   ///< of the stored pictures
    std::int64_t startPts = 0; ///< where the file begins, in the stream's unit
    double end = 0;            ///< where the file says it ends, s from its start; 0 = it does not

    /// A time leads to the same frame whatever was read before: false where nothing can be sought,
    /// and where times may begin again.
    bool hasFixedTimes() const;
};

/// Opens a video and finds out what it says about itself.
///
/// @param options `threads` more than 0
/// @throws Error as VideoReader::VideoReader()
VideoInput openVideoInput(const std::filesystem::path& path, const VideoReaderOptions& options);

/// Counts the frames of a file that come before a time, from its packets alone.
///
/// @param path of a regular file
/// @param from s from the start of the file
/// @return nothing where a packet may hold no frame or several, and where a time is missing
/// @throws Error as openVideoInput()
std::optional<std::int64_t> countPackets(const std::filesystem::path& path,
                                         VideoReaderOptions options, double from);

/// Tells a writer of all that a video holds besides its pictures, clipped to the part that is read.
///
/// @return for each stream of the file its index in `others.streams`; -1 = the delivered one
std::vector<std::int64_t> describeOthers(const VideoInput& input, const VideoReaderOptions& options,
                                         OtherStreams& others);

} // namespace altiro3D
