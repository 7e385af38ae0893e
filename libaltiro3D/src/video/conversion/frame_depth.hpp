#pragma once

#include "altiro3D/depth_source.hpp"
#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_depth.hpp"
#include "image/picture_halves.hpp"
#include "video/conversion/video_pipeline.hpp"
#include "video/motion/motion.hpp"

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace altiro3D {

/// Measures GivenVideoDepth::range for 16-bit depth, if needed and the source can be read again.
/// @throws Error
void measureRange(GivenVideoDepth& given);

/// Where the right eye's picture is, as if it were the depth half of an RGB-D image.
inline RgbdLayout halvesOf(const StereoVideo& video) {
    return {liesBeside(video.layout) ? DepthSide::Right : DepthSide::Bottom, video.halves};
}

class EyesDepth;
class GivenDepth;

/// A stage of a conversion: the depth of frames, either estimated and kept steady, or given.
class FrameDepth {
  public:
    /// Takes the depth source of the conversion. @throws Error
    FrameDepth(VideoConversion& conversion, const VideoFacts& facts);
    ~FrameDepth();
    FrameDepth(const FrameDepth&) = delete;
    FrameDepth& operator=(const FrameDepth&) = delete;

    /// Call it before the first frame of the video is read. @throws Error
    void begin(VideoReader& video);

    /// Reads `source`, sets `depth` and `step`. For an RGB-D frame, `source` becomes the photo; for
    /// a frame with both eyes, the left one's, and `hidden` may be set.
    void work(PipelineFrame& frame);

    /// The state that the next frame's depth depends on, for a resumed run.
    SavedState state() const;
    /// @throws Error BadFormat
    void setState(const SavedState& state);
    /// Size of the photos in frames of a given size, and the shape of the scene that they show.
    cv::Size photoSize(cv::Size frame) const;
    double photoAspect(cv::Size frame, double frameAspect) const;
    /// What is known about the edges of the depth.
    DepthEdges edges() const {
        if (eyes_) return DepthEdges::Matched;
        return source_ ? source_->edges() : DepthEdges::Unknown;
    }
    Notes notes() const;

  private:
    void start();
    void useGiven(PipelineFrame& frame);

    std::shared_ptr<DepthSource> source_; // null: depth is given
    std::optional<RgbdLayout> rgbd_;      // also where the right eye's picture is
    std::unique_ptr<EyesDepth> eyes_;
    DepthKind kind_;
    DepthRange range_; // range of given depth of 16 bits
    double flatDepth_; // if the range is empty
    VideoDepthOptions options_;
    double unit_; // s
    std::unique_ptr<GivenDepth> given_;
    std::optional<VideoDepth> depth_;
    PictureTracker cuts_;         // finds the scenes of given depth
    cv::Mat raw_;                 // given depth, unchanged
    std::uint64_t lastPhoto_ = 0; // identify the last photo and its given depth, or its right eye
    std::uint64_t lastRaw_ = 0;
    Notes notes_; // about RGB-D frames
};

} // namespace altiro3D
