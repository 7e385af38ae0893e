#pragma once

#include "altiro3D/depth_source.hpp"
#include "altiro3D/video_conversion.hpp"
#include "altiro3D/video_depth.hpp"
#include "video/given_depth.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace altiro3D {

/// A stage of a conversion: the depth of frames, estimated and kept steady, or as it was given.
class FrameDepth {
  public:
    /// Takes the depth source of the conversion.
    /// @throws Error
    FrameDepth(VideoConversion& conversion, const VideoFacts& facts);
    FrameDepth(const FrameDepth&) = delete;
    FrameDepth& operator=(const FrameDepth&) = delete;

    /// To be called before the first frame of the video is read. @throws Error
    void begin(VideoReader& video);

    /// Reads `source`, sets `depth` and `step`; of an RGB-D frame the photo stays in `source`.
    void work(PipelineFrame& frame);

    /// What the next frame's depth hangs on, for a run that goes on from here.
    SavedState state() const;
    /// @throws Error BadFormat
    void setState(const SavedState& state);
    /// Size of the photos in frames of a size, and shape of what they show.
    cv::Size photoSize(cv::Size frame) const;
    double photoAspect(double frameAspect) const;
    /// What was remarkable, for people.
    Notes notes() const { return given_ ? given_->notes() : Notes(); }

  private:
    void start();
    void useGiven(PipelineFrame& frame);

    std::unique_ptr<DepthSource> source_; // null: depth is given
    std::optional<DepthSide> side_;
    DepthKind kind_;
    VideoDepthOptions options_;
    double unit_; // s
    std::optional<GivenDepth> given_;
    std::optional<VideoDepth> depth_;
    cv::Mat raw_; // as it was given
    cv::Mat lastPhoto_;
    cv::Mat lastRaw_;
    std::string kept_; // tells the last photo and depth of the run before
};

} // namespace altiro3D
