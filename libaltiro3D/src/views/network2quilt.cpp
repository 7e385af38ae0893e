#include "altiro3D/depth2quilt.hpp"

#include "altiro3D/depth_source.hpp"
#include "altiro3D/placement.hpp"

namespace altiro3D {

Network2Quilt::Network2Quilt(DepthNetwork network, const QuiltLayout& layout,
                             const ViewOptions& options, double panelAspect, FitMode fit)
    : source_(depthFromNetwork(std::move(network))), depth2quilt_(layout, options),
      panelAspect_(panelAspect), fit_(fit) {
    // Checks the aspect early.
    static_cast<void>(fitPhoto(layout.tileSize, panelAspect, layout.tileSize, fit));
}

void Network2Quilt::render(const cv::Mat& photo, cv::Mat& quilt) {
    const ViewOptions& views = depth2quilt_.options();
    Scene scene;
    source_->readScene(photo, views.focus, scene);
    depth_ = scene.depth;
    const cv::Size tile = depth2quilt_.layout().tileSize;
    depth2quilt_.render(placeScene(scene, panelAspect_, tile, {views, fit_, {}, {}}).scene, quilt);
}

} // namespace altiro3D
