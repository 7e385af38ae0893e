#include "common/quilt_shape.hpp"

#include "altiro3D/quilt2native.hpp"

namespace altiro3D::tools {

namespace fs = std::filesystem;

QuiltShape::QuiltShape(const fs::path& file, const QuiltLayout& layout, const Display& display,
                       std::optional<FitMode> fit)
    : layout_(layout), panelAspect_(display.aspect()) {
    const auto name = parseQuiltName(file);
    const bool isStated = name && name->aspect;
    aspect_ = isStated ? *name->aspect
                       : static_cast<double>(layout.tileSize.width) / layout.tileSize.height;
    isFittedUnasked_ = !fit && isStated && !haveSameShape(aspect_, panelAspect_);
    fit_ = fit.value_or(isFittedUnasked_ ? FitMode::Contain : FitMode::Stretch);
}

cv::Mat QuiltShape::apply(const cv::Mat& picture, Notes* notes) const {
    cv::Mat quilt = fitQuilt(picture, layout_, notes);
    if (fit_ != FitMode::Stretch)
        applyFitToViews(quilt, layout_, aspect_, panelAspect_, fit_, quilt);
    return quilt;
}

void QuiltShape::tell(Messages& messages) const {
    if (!isFittedUnasked_) return;
    messages.say("fit: the file name says that the views are meant for another shape than the "
                 "panel's; black bars keep it (--fit cover or stretch fills the panel)");
}

} // namespace altiro3D::tools
