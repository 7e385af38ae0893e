#pragma once

#include "altiro3D/video_depth.hpp"
#include "viewer/model/document.hpp"

#include <memory>
#include <optional>
#include <string>

namespace altiro3D::viewer {

class DepthMaker;

/// The depth of a playing flat video: steady, inferred as often as the pictures require.
class PlayedDepth {
  public:
    explicit PlayedDepth(std::shared_ptr<DepthMaker> maker);

    /// Sets the depth of the next picture, if it is to be estimated, and its scene. As in
    /// video2native, given depth has no scenes; its flaws are measured now and then.
    /// @param wish Knobs::depth
    void next(Document& document, const std::string& wish);

  private:
    std::shared_ptr<DepthMaker> maker_;
    std::string chosen_;
    int scene_ = 0;
    int pictures_ = 0; // with given depth
    std::optional<VideoDepth> depth_;
};

} // namespace altiro3D::viewer
