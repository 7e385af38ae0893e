#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/quilt2native.hpp"
#include "video/conversion/video_pipeline.hpp"

#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D {

/// The target of the pictures of a conversion.
struct VideoTarget {
    QuiltLayout layout; ///< layout of the quilts
    cv::Size panelSize; ///< size of the display's panel, px

    /// width : height of the panel
    double aspect() const { return static_cast<double>(panelSize.width) / panelSize.height; }
};

/// The stage of a conversion that makes the picture to write.
class FrameRenderer {
  public:
    virtual ~FrameRenderer() = default;
    /// Size of the written pictures.
    virtual cv::Size size() const = 0;
    /// Reads `source` and `depth`, sets the picture of `result`: the last one if it is repeated.
    void work(PipelineFrame& frame);
    /// Passes a frame without making its picture: remembers what work() would.
    virtual void pass(PipelineFrame& /*frame*/) {}
    /// Prepends what the next frame's picture depends on, besides that frame, to the state.
    virtual void keepState(SavedState& /*state*/) const {}
    /// Removes what keepState() has put in front and continues from it. @throws Error BadFormat
    virtual void takeState(SavedState& /*state*/) {}
    /// The choices for the scenes of this run; `start` is in units of the frames' times.
    virtual std::vector<SceneChoice> choices() const { return {}; }
    virtual Notes notes() const { return {}; }

  protected:
    virtual void make(const PipelineFrame& frame, cv::Mat& picture) = 0;
    /// Whether the picture equals the last one, provided that the shape of px is the same.
    virtual bool isRepeated(PipelineFrame& frame) { return frame.step.repeated; }

  private:
    cv::Mat last_;
    double lastPixelAspect_ = 0;
};

/// The stage for frames with depth.
/// @param photo size of the photos @param seenAspect width : height of the photos as displayed
/// @param edges what is known about the edges of the depth
std::unique_ptr<FrameRenderer> makePhotoRenderer(const VideoConversion& conversion,
                                                 const VideoTarget& target, cv::Size photo,
                                                 double seenAspect, DepthEdges edges);

/// The stage for frames with both eyes' pictures, which are laid out anew.
std::unique_ptr<FrameRenderer> makeEyesRenderer(const VideoConversion& conversion,
                                                const VideoFacts& facts);

/// The stage for frames that are quilts. @throws Error
std::unique_ptr<FrameRenderer> makeQuiltRenderer(const VideoConversion& conversion,
                                                 const VideoTarget& target);

} // namespace altiro3D
