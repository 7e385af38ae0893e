#include "common/quilt_shape.hpp"

#include "altiro3D/quilt2native.hpp"

#include <cmath>

namespace altiro3D::tools {

namespace fs = std::filesystem;

QuiltShape::QuiltShape(const fs::path& file, const QuiltLayout& layout, const Display& display,
                       FitMode fit)
    : layout_(layout), panelAspect_(display.panelAspect()), fit_(fit) {
    const auto name = parseQuiltName(file);
    isStated_ = name && name->aspect;
    aspect_ = isStated_ ? *name->aspect
                        : static_cast<double>(layout.tileSize.width) / layout.tileSize.height;
}

cv::Mat QuiltShape::apply(const cv::Mat& picture, Notes* notes) const {
    cv::Mat quilt = fitQuilt(picture, layout_, notes);
    if (fit_ != FitMode::Stretch)
        applyFitToViews(quilt, layout_, aspect_, panelAspect_, fit_, quilt);
    return quilt;
}

void QuiltShape::warnIfStretched(Messages& messages) const {
    if (fit_ != FitMode::Stretch || !isStated_) return;
    if (std::abs(aspect_ / panelAspect_ - 1) <= 0.05) return;
    messages.warn("the file name says that the views are meant for another shape than the "
                  "panel's; they are stretched to it (--fit contain or cover keep theirs)");
}

} // namespace altiro3D::tools
