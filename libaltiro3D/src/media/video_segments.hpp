#pragma once

#include "altiro3D/video_io.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

/// Videos in segments: short files that are made on their own and joined without encoding again.
namespace altiro3D {

/// A whole segment: frames that were encoded on their own.
struct VideoSegment {
    std::filesystem::path file;
    std::int64_t frames = 0;
    std::int64_t pts = 0;     ///< time of the first frame
    std::int64_t end = 0;     ///< end of the last frame
    std::uintmax_t bytes = 0; ///< size of the file
    int reorderedPlaces = 0;  ///< the most places by which a picture is decoded before its turn
    std::uint64_t times = 0;  ///< sum over the times of all frames, see mixTime()
};

/// Adds the time of a frame to a sum that tells sequences of times apart.
std::uint64_t mixTime(std::uint64_t sum, const VideoFrame& frame);

/// The file name of a segment. @param number from 0
std::string segmentName(std::size_t number, VideoCodec codec);
/// Six digits or more and an ending. @param number from 0; the names count from 1
std::string numberedName(std::size_t number, const std::string& ending);

/// Encodes frames into segments of a fixed number of frames.
class SegmentWriter {
  public:
    /// @param directory exists; receives the files
    /// @param number of the first segment, from 0
    /// @param earliest lowest time that the first frame may have
    SegmentWriter(std::filesystem::path directory, VideoWriterOptions options, int segmentFrames,
                  std::size_t number = 0, std::int64_t earliest = 0);
    ~SegmentWriter();
    SegmentWriter(const SegmentWriter&) = delete;
    SegmentWriter& operator=(const SegmentWriter&) = delete;

    /// Encodes a frame. @return whether a segment is full; end() must follow
    /// @throws Error InvalidArgument, WriteFailed
    bool write(const VideoFrame& frame);
    bool hasBegun() const { return writer_ != nullptr; }
    /// Closes the segment. @throws Error WriteFailed, BadFormat
    VideoSegment end();
    /// Removes the segment that has been begun, if there is one.
    void drop();

  private:
    std::filesystem::path directory_;
    VideoWriterOptions options_;
    int segmentFrames_;
    std::size_t number_;
    std::int64_t earliest_;
    VideoSegment current_;
    std::unique_ptr<VideoWriter> writer_;
};

/// Joins segments to a video.
class SegmentJoiner {
  public:
    /// Joins without encoding again.
    /// @param options of the encoder and the file; `timeBase` is that of the segments' times
    /// @param segments in order, at least one
    /// @param source new reader of the source video, for sound and the other streams; may be null
    /// @param toTheEnd copy the other streams to their end, else to the end of the last segment
    /// @param before called before each segment is copied; false cancels. May be empty.
    /// @param notes receives what was left out
    /// @return false if it was cancelled; the file was then not made
    /// @throws Error as ResumableVideoWriter::finish()
    static bool join(const std::filesystem::path& path, const VideoWriterOptions& options,
                     const std::vector<VideoSegment>& segments, VideoReader* source, bool toTheEnd,
                     const std::function<bool(const VideoSegment&)>& before, Notes& notes);
};

} // namespace altiro3D
