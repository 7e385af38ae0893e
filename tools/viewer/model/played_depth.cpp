#include "viewer/model/played_depth.hpp"

#include "viewer/model/depth_maker.hpp"

#include <utility>

namespace altiro3D::viewer {

PlayedDepth::PlayedDepth(std::shared_ptr<DepthMaker> maker) : maker_(std::move(maker)) {}

void PlayedDepth::next(Document& document, const std::string& wish) {
    const std::string chosen = maker_->choose(wish, !document.rawDepth.empty());
    if (chosen == kGivenDepth) {
        constexpr int kPicturesPerMeasurement = 100;
        document.scene = pictures_++ / kPicturesPerMeasurement;
        return;
    }
    if (chosen != chosen_) {
        DepthKind kind = DepthKind::NearWhite;
        maker_->use(chosen, [&](DepthSource& source) { kind = source.kind(); });
        const auto estimate = [maker = maker_, chosen](const cv::Mat& picture, cv::Mat& raw) {
            cv::Mat photo;
            maker->use(chosen, [&](DepthSource& source) { source.readFrame(picture, photo, raw); });
        };
        depth_.emplace(estimate, kind);
        chosen_ = chosen;
    }
    if (depth_->next(document.picture, document.depth).cut) ++scene_;
    document.scene = scene_;
}

} // namespace altiro3D::viewer
