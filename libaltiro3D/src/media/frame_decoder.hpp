#pragma once

#include "altiro3D/video_io.hpp"
#include "media/ffmpeg.hpp"
#include "media/video_input.hpp"
#include "media/video_packets.hpp"

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

extern "C" {
#include <libavfilter/avfilter.h>
}

namespace altiro3D {

/// A decoded frame and its time, in the stream's unit.
struct DecodedFrame {
    FramePtr frame = newFrame();
    std::int64_t pts = 0;
};

struct FreeGraph {
    void operator()(AVFilterGraph* graph) const;
};

/// Interpolates the lines that interlaced frames lack, by FFmpeg's filter bwdif, and keeps other
/// frames as they are. A frame depends on those before and after it. Up to the first interlaced
/// frame nothing is filtered and nothing is held back.
class Deinterlacer {
  public:
    /// @param unit of the frames' times @param subject name of the video, for errors
    Deinterlacer(AVRational unit, int threads, std::string subject);

    /// Takes a frame. @throws Error Unsupported, OutOfMemory
    void give(DecodedFrame& decoded);
    /// Says that no frame follows.
    void end();
    /// Delivers the next frame. @return false if another one must be given first
    bool take(DecodedFrame& decoded);
    /// Forgets all frames, for a seek.
    void restart();

  private:
    void open(const AVFrame& frame);
    void push(const DecodedFrame* decoded);

    AVRational unit_;
    int threads_;
    std::string subject_;
    std::unique_ptr<AVFilterGraph, FreeGraph> graph_;
    AVFilterContext* source_ = nullptr; // `graph_` owns both
    AVFilterContext* sink_ = nullptr;
    std::optional<DecodedFrame> last_; // given last, while nothing is filtered
    bool skips_ = false;               // the next frame of the graph was delivered before
    std::deque<DecodedFrame> ready_;
};

/// Joins both eyes' pictures: of spatial video, which a decoder delivers one after the other with
/// the same time, of two videos, or of frames that show the eyes alternately.
class EyesJoiner {
  public:
    /// Order of the pictures, and whether only the left ones are wanted.
    struct Turns {
        bool alternate = false;  ///< Frames alternate; a pair has the time of its first one.
        bool rightFirst = false; ///< The right eye's is the first.
        bool leftAlone = false;
        std::size_t mostWaiting = 1;   ///< Pictures of an eye that may wait for the other's.
        std::int64_t mostDistance = 0; ///< Largest difference between the times of a pair.
    };
    EyesJoiner() = default;
    explicit EyesJoiner(const Turns& turns) : turns_(turns) {}

    /// Takes a picture; gives both beside each other, the left one first.
    /// @param frame receives the result @param isOfTwin it is of the right eye's video
    /// @return false if the other eye's picture is missing
    /// @throws Error OutOfMemory
    bool join(AVFrame& frame, bool isOfTwin = false);
    /// Pictures whose other eye is missing, since the last call.
    int takeLost() { return std::exchange(lost_, 0); }
    /// Skips a damaged picture, and the other one of its pair if they alternate.
    void skip();
    /// Forgets the pictures that wait, for a seek or at the end. @return how many there were
    std::size_t restart() {
        skips_ = false;
        return std::exchange(waiting_, {}).size();
    }

  private:
    Turns turns_;
    bool skips_ = false;           // the next picture
    std::deque<FramePtr> waiting_; // pictures of one eye
    bool isRightWaiting_ = false;
    int lost_ = 0;
};

/// Assigns rising times to a video's frames, in the stream's unit: the file's, or repaired ones.
///
/// A few frames in disorder are placed one tick apart until the next valid time. If times start
/// again, as in concatenated files, all following times are shifted.
class FrameTimes {
  public:
    /// @param start of the file in `unit`
    /// @param counts receives the number of repaired times; must outlive this
    FrameTimes(const VideoFacts& facts, AVRational unit, std::int64_t start,
               VideoReadCounts& counts);

    /// The time of the next frame.
    std::int64_t next(const AVFrame& frame);
    /// Resets the state; the next frame is treated as the first.
    void restart();

    /// Whether a frame has a time.
    bool hasBegun() const { return last_.has_value(); }
    /// Whether the file's times start again.
    bool beginsAgain() const { return beginsAgain_; }
    /// Nominal duration of a frame; 0 = unknown.
    std::int64_t frameDuration() const { return frameDuration_; }

  private:
    std::int64_t risingTime(const AVFrame& frame);

    AVRational unit_;
    std::int64_t start_;
    std::int64_t frameDuration_;
    bool countsFirst_; // that the time of the first frame is missing
    VideoReadCounts& counts_;
    std::optional<std::int64_t> last_;
    std::int64_t shift_ = 0;
    int inDisorder_ = 0; // frames in a row
    bool beginsAgain_ = false;
};

/// Decodes the pictures of a video, drops damaged ones and deinterlaces.
class FrameDecoder {
  public:
    /// @param input its decoder is moved here @param packets, counts must outlive this
    FrameDecoder(VideoInput& input, const VideoReaderOptions& options, VideoPackets& packets,
                 VideoReadCounts& counts);

    /// The next undamaged frame.
    /// @return false at the end; the frame's time is then unchanged
    /// @throws Error ReadFailed, OutOfMemory
    bool decode(DecodedFrame& decoded);
    /// Resets the decoder; call it after a seek.
    void restart();

    const FrameTimes& times() const { return times_; }
    /// Whether a frame was interlaced.
    bool hasInterlaced() const { return interlaced_; }
    /// Whether frames may depend on those before them.
    bool deinterlaces() const;

  private:
    bool decodeNext(DecodedFrame& decoded);
    bool feed();
    bool isDamaged(const AVFrame& frame);

    CodecPtr decoder_;
    CodecPtr twinDecoder_;
    const AVStream* twin_; // the right eye's; null: no second video is read
    AVRational unit_;
    VideoPackets& packets_;
    FrameTimes times_;
    std::optional<Deinterlacer> deinterlacer_;
    DecodedFrame given_; // to the deinterlacer
    std::optional<EyesJoiner> joiner_;
    VideoReadCounts& counts_;
    std::set<std::int64_t> corruptPts_; // times of packets that the container marks as damaged
    bool sentEnd_ = false;
    bool interlaced_ = false;
};

} // namespace altiro3D
