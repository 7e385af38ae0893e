#include "altiro3D/depth2quilt.hpp"

#include "altiro3D/depth_source.hpp"

namespace altiro3D {

Network2Quilt::Network2Quilt(DepthNetwork network, const QuiltLayout& layout,
                             const ViewOptions& options, double panelAspect, FitMode fit)
    : source_(depthFromNetwork(std::move(network))), depth2quilt_(layout, options),
      panelAspect_(panelAspect), fit_(fit) {
    // Checks the aspect early.
    static_cast<void>(fitPhoto(layout.tileSize, panelAspect, layout.tileSize, fit));
}

void Network2Quilt::render(const cv::Mat& photo, cv::Mat& quilt) {
    const PhotoFit fit =
        withMargins(fitPhoto(photo.size(), panelAspect_, depth2quilt_.layout().tileSize, fit_),
                    photo.size(), depth2quilt_.options());
    const double focus = depth2quilt_.options().focus;
    Scene scene;
    source_->readScene(photo, focus, scene);
    depth_ = scene.depth;
    Scene fitted;
    fitScene(scene, fit, focus, fitted);
    depth2quilt_.render(fitted, quilt);
}

} // namespace altiro3D
