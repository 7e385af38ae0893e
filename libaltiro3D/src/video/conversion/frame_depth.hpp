#pragma once

#include "altiro3D/depth_source.hpp"
#include "altiro3D/video_depth.hpp"
#include "video/conversion/given_depth.hpp"
#include "video/conversion/video_pipeline.hpp"
#include "video/motion/picture_tracker.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace altiro3D {

/// A stage of a conversion: the depth of frames, either estimated and kept steady, or given.
class FrameDepth {
  public:
    /// Takes the depth source of the conversion.
    /// @throws Error
    FrameDepth(VideoConversion& conversion, const VideoFacts& facts);
    FrameDepth(const FrameDepth&) = delete;
    FrameDepth& operator=(const FrameDepth&) = delete;

    /// Call it before the first frame of the video is read. @throws Error
    void begin(VideoReader& video);

    /// Reads `source`, sets `depth` and `step`. For an RGB-D frame, `source` becomes the photo.
    void work(PipelineFrame& frame);

    /// The state that the next frame's depth depends on, for a resumed run.
    SavedState state() const;
    /// @throws Error BadFormat
    void setState(const SavedState& state);
    /// Size of the photos in frames of a given size, and the shape of the scene that they show.
    cv::Size photoSize(cv::Size frame) const;
    double photoAspect(cv::Size frame, double frameAspect) const;
    /// What is known of the edges of the depth.
    DepthEdges edges() const { return source_ ? source_->edges() : DepthEdges::Unknown; }
    /// Remarks, for people.
    Notes notes() const { return given_ ? given_->notes() : notes_; }

  private:
    void start();
    void useGiven(PipelineFrame& frame);

    std::unique_ptr<DepthSource> source_; // null: depth is given
    std::optional<RgbdLayout> rgbd_;
    DepthKind kind_;
    DepthRange range_; // of given depth of 16 bits
    double flatDepth_; // if the range is empty
    VideoDepthOptions options_;
    double unit_; // s
    std::optional<GivenDepth> given_;
    std::optional<VideoDepth> depth_;
    std::optional<PictureTracker> cuts_; // finds the scenes of given depth, for choices by scene
    cv::Mat raw_;                        // given depth, unchanged
    cv::Mat lastPhoto_;
    cv::Mat lastRaw_;
    Notes notes_;      // about RGB-D frames
    std::string kept_; // identifies the last photo and depth of the interrupted run
};

} // namespace altiro3D
