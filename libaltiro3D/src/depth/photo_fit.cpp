#include "altiro3D/photo_fit.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

// `part` of `whole`, at least 1 px, centred.
cv::Range centred(int whole, double part) {
    const int length = std::clamp(static_cast<int>(std::lround(part)), 1, whole);
    const int start = (whole - length) / 2;
    return {start, start + length};
}

bool isInside(const cv::Rect& part, cv::Size whole) {
    const auto fits = [](std::int64_t start, std::int64_t length, int all) {
        return start >= 0 && length >= 1 && start + length <= all;
    };
    return fits(part.x, part.width, whole.width) && fits(part.y, part.height, whole.height);
}

// A fit may not come from fitPhoto(), or belong to another photo.
void checkFit(const PhotoFit& fit, cv::Size photo) {
    if (!isInside(fit.source, photo)) {
        throw Error(ErrorCode::Mismatch, "photo",
                    "has " + sizeText(photo) + " px, expected the size that the fit was made for");
    }
    check(isInside(fit.target, fit.size), "fit",
          "puts " + sizeText(fit.target.size()) + " px at (" + std::to_string(fit.target.x) + ", " +
              std::to_string(fit.target.y) + "), expected a place inside of its result of " +
              sizeText(fit.size) + " px");
}

} // namespace

PhotoFit fitPhoto(cv::Size picture, double panelAspect, cv::Size result, FitMode mode) {
    if (picture.width < 1 || picture.height < 1 || result.width < 1 || result.height < 1) {
        throw Error(ErrorCode::InvalidArgument, "picture",
                    "of " + sizeText(picture) + " px cannot be brought to " + sizeText(result) +
                        " px, expected at least 1 x 1");
    }
    checkNumber(panelAspect >= 0.01 && panelAspect <= 100, "panel aspect", panelAspect,
                "0.01..100");
    PhotoFit fit;
    fit.size = result;
    cv::Range columns(0, picture.width);
    cv::Range rows(0, picture.height);
    cv::Range targetColumns(0, result.width);
    cv::Range targetRows(0, result.height);
    const double aspect = static_cast<double>(picture.width) / picture.height;
    const bool wider = aspect > panelAspect;
    if (mode == FitMode::Cover) {
        if (wider) {
            columns = centred(picture.width, picture.height * panelAspect);
        } else {
            rows = centred(picture.height, picture.width / panelAspect);
        }
    } else if (mode == FitMode::Contain) {
        if (wider) {
            targetRows = centred(result.height, result.height * panelAspect / aspect);
        } else {
            targetColumns = centred(result.width, result.width * aspect / panelAspect);
        }
    }
    fit.source = {columns.start, rows.start, columns.size(), rows.size()};
    fit.target = {targetColumns.start, targetRows.start, targetColumns.size(), targetRows.size()};
    return fit;
}

void applyFit(const cv::Mat& picture, const PhotoFit& fit, cv::Mat& fitted) {
    checkType(picture, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    checkFit(fit, picture.size());
    const cv::Mat source = picture(fit.source);
    cv::Mat result(fit.size, CV_8UC3); // not `fitted`: it may be the picture itself
    if (fit.target.size() != fit.size) result.setTo(cv::Scalar::all(0));
    cv::Mat target = result(fit.target);
    // First shrinks by area average, then enlarges by interpolation; each may affect one axis only.
    const cv::Size smaller(std::min(source.cols, target.cols), std::min(source.rows, target.rows));
    cv::Mat shrunk = source;
    if (smaller != source.size()) cv::resize(source, shrunk, smaller, 0, 0, cv::INTER_AREA);
    if (smaller == target.size()) {
        shrunk.copyTo(target);
    } else {
        cv::resize(shrunk, target, target.size(), 0, 0, cv::INTER_CUBIC);
    }
    fitted = result;
}

void applyFitToDepth(const cv::Mat& depth, cv::Size photoSize, const PhotoFit& fit,
                     const cv::Mat& fittedPhoto, double focus, cv::Mat& fitted) {
    checkFit(fit, photoSize);
    checkNumber(focus >= 0 && focus <= 1, "focus", focus, "a depth of 0 (farthest) .. 1 (nearest)");
    if (fittedPhoto.size() != fit.size) {
        throw Error(ErrorCode::Mismatch, "photo",
                    "has " + sizeText(fittedPhoto.size()) + " px, expected " + sizeText(fit.size));
    }
    const double scaleX = static_cast<double>(depth.cols) / photoSize.width;
    const double scaleY = static_cast<double>(depth.rows) / photoSize.height;
    const cv::Rect2d part(fit.source.x * scaleX, fit.source.y * scaleY, fit.source.width * scaleX,
                          fit.source.height * scaleY);
    cv::Mat inside;
    fitDepth(depth, part, fittedPhoto(fit.target), inside);
    if (fit.target.size() == fit.size) {
        fitted = inside;
        return;
    }
    fitted.create(fit.size, CV_32FC1);
    fitted.setTo(focus);
    inside.copyTo(fitted(fit.target));
}

void fitScene(const Scene& scene, const PhotoFit& fit, double focus, Scene& fitted,
              const DepthRefineOptions& refine) {
    const cv::Size photoSize = scene.photo.size(); // scene and fitted may be one
    applyFit(scene.photo, fit, fitted.photo);
    applyFitToDepth(scene.depth, photoSize, fit, fitted.photo, focus, fitted.depth);
    if (!refine.enabled) return;
    cv::Mat refined;
    refineDepth(fitted.photo(fit.target), fitted.depth(fit.target), refined, refine);
    if (fit.target.size() == fit.size) {
        fitted.depth = refined;
    } else {
        refined.copyTo(fitted.depth(fit.target));
    }
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

} // namespace altiro3D
