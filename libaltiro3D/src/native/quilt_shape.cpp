#include "altiro3D/quilt2native.hpp"

#include <cmath>

namespace altiro3D {

namespace fs = std::filesystem;

bool haveSameShape(double aspect, double other) {
    constexpr double kMaxOff = 0.05; // looks right
    return std::abs(aspect / other - 1) <= kMaxOff;
}

QuiltShape::QuiltShape(const fs::path& file, const QuiltLayout& layout, const Display& display,
                       std::optional<FitMode> fit)
    : layout_(layout), panelAspect_(display.aspect()) {
    const auto name = parseQuiltName(file);
    const bool isStated = name && name->aspect;
    aspect_ = isStated ? *name->aspect
                       : static_cast<double>(layout.tileSize.width) / layout.tileSize.height;
    const bool isUnasked = !fit && !haveSameShape(aspect_, panelAspect_);
    isFittedUnasked_ = isUnasked && isStated;
    isStretchedUnasked_ = isUnasked && !isStated;
    fit_ = fit.value_or(isFittedUnasked_ ? FitMode::Contain : FitMode::Stretch);
}

cv::Mat QuiltShape::apply(const cv::Mat& picture) const {
    cv::Mat quilt = fitQuilt(picture, layout_);
    if (fit_ != FitMode::Stretch)
        applyFitToViews(quilt, layout_, aspect_, panelAspect_, fit_, quilt);
    return quilt;
}

} // namespace altiro3D
