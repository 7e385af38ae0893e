#include "altiro3D/video_depth.hpp"

#include "base/checks.hpp"
#include "video/picture_tracker.hpp"

namespace altiro3D {

struct SceneCuts::Impl {
    PictureTracker tracker;
};

SceneCuts::SceneCuts() : impl_(std::make_unique<Impl>()) {}
SceneCuts::~SceneCuts() = default;
SceneCuts::SceneCuts(SceneCuts&&) noexcept = default;
SceneCuts& SceneCuts::operator=(SceneCuts&&) noexcept = default;

bool SceneCuts::next(const cv::Mat& picture) {
    checkType(picture, {CV_8UC3}, "picture", "CV_8UC3");
    return impl_->tracker.next(picture).cut;
}

} // namespace altiro3D
