#include "native/quilt_shape.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/quilt2native.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace fs = std::filesystem;

bool haveSameShape(double aspect, double other) {
    constexpr double kMaxOff = 0.05; // looks right
    return std::abs(aspect / other - 1) <= kMaxOff;
}

void applyFitToViews(const cv::Mat& quilt, const QuiltLayout& layout, double viewAspect,
                     double panelAspect, FitMode mode, cv::Mat& fitted) {
    validate(layout);
    if (quilt.size() != layout.size()) {
        throw Error(ErrorCode::Mismatch, "quilt",
                    "has " + sizeText(quilt.size()) + " px, expected " + sizeText(layout.size()));
    }
    check(viewAspect >= 0.01 && viewAspect <= 100, "viewAspect",
          "is " + numberText(viewAspect) + ", expected 0.01..100");
    // A tile has the shape viewAspect, independent of its px; the fit is computed for that shape.
    const int height = layout.tileSize.height;
    const cv::Size shown(std::max(1, static_cast<int>(std::lround(height * viewAspect))), height);
    const PhotoFit toShown = fitPhoto(layout.tileSize, viewAspect, shown, FitMode::Stretch);
    const PhotoFit toPanel = fitPhoto(shown, panelAspect, layout.tileSize, mode);
    cv::Mat result(quilt.size(), CV_8UC3); // not `fitted`: it may be the quilt itself
    cv::parallel_for_(cv::Range(0, layout.columns * layout.rows), [&](const cv::Range& tiles) {
        cv::Mat view;
        for (int i = tiles.start; i < tiles.end; ++i) {
            applyFit(quilt(layout.tile(i)), toShown, view);
            applyFit(view, toPanel, view);
            view.copyTo(result(layout.tile(i)));
        }
    });
    fitted = result;
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
