#include "altiro3D/depth2quilt.hpp"

namespace altiro3D {

Network2Quilt::Network2Quilt(DepthNetwork network, const QuiltLayout& layout,
                             const ViewOptions& options, double panelAspect, FitMode fit)
    : network_(std::move(network)), depth2quilt_(layout, options), panelAspect_(panelAspect),
      fit_(fit) {
    // Checks the aspect early.
    static_cast<void>(fitPhoto(layout.tileSize, panelAspect, layout.tileSize, fit));
}

void Network2Quilt::render(const cv::Mat& photo, cv::Mat& quilt) {
    const PhotoFit fit =
        withMargins(fitPhoto(photo.size(), panelAspect_, depth2quilt_.layout().tileSize, fit_),
                    photo.size(), depth2quilt_.options());
    network_.estimate(photo, depth_);
    Scene fitted;
    fitScene({photo, depth_}, fit, depth2quilt_.options().focus, fitted);
    depth2quilt_.render(fitted, quilt);
}

} // namespace altiro3D
