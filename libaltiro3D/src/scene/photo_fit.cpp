#include "altiro3D/photo_fit.hpp"

#include "altiro3D/depth_map.hpp"
#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"
#include "depth/refine/depth_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

// `part` of `whole`, at least 1 px, around `centre` as far as the ends allow.
cv::Range around(int whole, double part, double centre) {
    const int length = static_cast<int>(std::lround(std::clamp<double>(part, 1, whole)));
    constexpr double kRounding = 1e-6; // px; so that a centre made of whole px gives the same ones
    const double start = std::floor(centre * whole - length / 2.0 + kRounding);
    const int first = static_cast<int>(std::clamp<double>(start, 0, whole - length));
    return {first, first + length};
}

// One axis of a fit.
struct Axis {
    cv::Range source; // part of the picture
    cv::Range target; // part of the result
};

// @param window length of the picture that fills the panel, in its px; may exceed it
Axis placed(int picture, double window, double centre, int result) {
    return {around(picture, window, centre), around(result, result * (picture / window), 0.5)};
}

void checkFraming(const Framing& framing) {
    for (const double part : {framing.centre.x, framing.centre.y}) {
        checkNumber(part >= 0 && part <= 1, "centre", part,
                    "0 (left or top edge) .. 1 (right or bottom edge)");
    }
    checkRange("zoom", framing.zoom, 1, 1000);
}

bool isInside(const cv::Rect& part, cv::Size whole) {
    const auto fits = [](std::int64_t start, std::int64_t length, int all) {
        return start >= 0 && length >= 1 && start + length <= all;
    };
    return fits(part.x, part.width, whole.width) && fits(part.y, part.height, whole.height);
}

// Fits what is known about the hidden background. Colours are means of the known px only; a px is
// known if at least half of it is.
void fitHidden(const HiddenLayer& hidden, cv::Size photo, const PhotoFit& fit,
               HiddenLayer& fitted) {
    checkType(hidden.photo, {CV_8UC3}, "hidden photo", "CV_8UC3 (8-bit BGR)");
    checkType(hidden.depth, {CV_32FC1}, "hidden depth", "CV_32FC1");
    checkSize(hidden.depth.size(), hidden.photo.size(), "hidden depth");
    cv::Mat known;
    cv::compare(hidden.depth, hidden.depth, known, cv::CMP_EQ); // NaN differs from itself
    cv::Mat planes[5]; // blue, green, red, depth, share that is known; 0 where unknown
    cv::Mat colours;
    hidden.photo.convertTo(colours, CV_32F);
    cv::split(colours, planes);
    planes[3] = hidden.depth.clone();
    known.convertTo(planes[4], CV_32F, 1.0 / 255);
    // First shrinks by area average; then an exact affine map, with linear interpolation.
    const cv::Size2d zoom(static_cast<double>(fit.target.width) / fit.source.width,
                          static_cast<double>(fit.target.height) / fit.source.height);
    const cv::Rect filled = fit.filled();
    const cv::Size smaller(std::clamp(cvRound(photo.width * zoom.width), 1, hidden.photo.cols),
                           std::clamp(cvRound(photo.height * zoom.height), 1, hidden.photo.rows));
    const double scaleX = static_cast<double>(smaller.width) / photo.width;
    const double scaleY = static_cast<double>(smaller.height) / photo.height;
    const cv::Matx23d from(
        scaleX / zoom.width, 0,
        fit.source.x * scaleX + (0.5 - fit.leftMargin) * scaleX / zoom.width - 0.5, 0,
        scaleY / zoom.height, fit.source.y * scaleY + 0.5 * scaleY / zoom.height - 0.5);
    for (cv::Mat& plane : planes) {
        if (&plane != &planes[4]) plane.setTo(0, ~known);
        if (smaller != plane.size()) cv::resize(plane, plane, smaller, 0, 0, cv::INTER_AREA);
        cv::warpAffine(plane.clone(), plane, from, filled.size(),
                       cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_CONSTANT);
    }
    fitted.photo = cv::Mat(fit.fittedSize(), CV_8UC3, cv::Scalar::all(0));
    fitted.depth = cv::Mat(fit.fittedSize(), CV_32FC1);
    fitted.depth.setTo(std::numeric_limits<float>::quiet_NaN());
    for (int y = 0; y < filled.height; ++y) {
        auto* const bgr = fitted.photo.ptr<cv::Vec3b>(filled.y + y) + filled.x;
        auto* const depth = fitted.depth.ptr<float>(filled.y + y) + filled.x;
        for (int x = 0; x < filled.width; ++x) {
            const float share = planes[4].ptr<float>(y)[x];
            if (share < 0.5F) continue;
            for (int c = 0; c < 3; ++c)
                bgr[x][c] = cv::saturate_cast<std::uint8_t>(planes[c].ptr<float>(y)[x] / share);
            depth[x] = planes[3].ptr<float>(y)[x] / share;
        }
    }
}

// Columns of the picture for each column of the result.
double columnsPerPixel(const PhotoFit& fit) {
    return static_cast<double>(fit.source.width) / fit.target.width;
}

// Columns of the picture that a margin shows, at least 1 and at most all beside the source.
int marginColumns(const PhotoFit& fit, int margin, int beside) {
    return std::clamp(cvRound(margin * columnsPerPixel(fit)), 1, beside);
}

// Resamples to the target's size: shrinks by area average, then enlarges; each may affect one axis.
void resample(const cv::Mat& source, cv::Mat target) {
    const cv::Size smaller(std::min(source.cols, target.cols), std::min(source.rows, target.rows));
    cv::Mat shrunk = source;
    if (smaller != source.size()) cv::resize(source, shrunk, smaller, 0, 0, cv::INTER_AREA);
    if (smaller == target.size()) {
        shrunk.copyTo(target);
    } else {
        cv::resize(shrunk, target, target.size(), 0, 0, cv::INTER_CUBIC);
    }
}

// A fit may not come from fitPhoto(), or belong to another photo.
void checkFit(const PhotoFit& fit, cv::Size photo) {
    if (!isInside(fit.source, photo)) {
        throw Error(ErrorCode::Mismatch, "photo",
                    "has " + sizeText(photo) + ", expected the size that the fit was made for");
    }
    check(isInside(fit.target, fit.size), "fit",
          "puts " + sizeText(fit.target.size()) + " at (" + std::to_string(fit.target.x) + ", " +
              std::to_string(fit.target.y) + "), expected a place inside of its result of " +
              sizeText(fit.size));
    const auto exists = [&fit](int margin, bool isBar, int beside) {
        return margin == 0 ||
               (margin > 0 && !isBar && margin * columnsPerPixel(fit) <= beside + 1e-6);
    };
    check(exists(fit.leftMargin, fit.target.x > 0, fit.source.x) &&
              exists(fit.rightMargin, fit.target.br().x < fit.size.width,
                     photo.width - fit.source.br().x),
          "fit",
          "has margins of " + std::to_string(fit.leftMargin) + " and " +
              std::to_string(fit.rightMargin) + " px, expected those of withMargins()");
}

// The body of applyFitToDepth(). @param resize fitDepth() or fitRefinedDepth()
void resampleDepth(const cv::Mat& depth, cv::Size photoSize, const PhotoFit& fit,
                   const cv::Mat& fittedPhoto, double focus, decltype(fitDepth) resize,
                   cv::Mat& fitted) {
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    checkFit(fit, photoSize);
    checkNumber(focus >= 0 && focus <= 1, "focus", focus, "a depth of 0 (farthest) .. 1 (nearest)");
    const cv::Size size = fit.fittedSize();
    const bool isGuided = !fittedPhoto.empty();
    if (isGuided) checkSize(fittedPhoto.size(), size, "photo");
    const double scaleX = static_cast<double>(depth.cols) / photoSize.width;
    const double scaleY = static_cast<double>(depth.rows) / photoSize.height;
    const double perPixel = columnsPerPixel(fit);
    const double left = fit.leftMargin * perPixel; // columns of the photo
    const double right = fit.rightMargin * perPixel;
    const cv::Rect2d part((fit.source.x - left) * scaleX, fit.source.y * scaleY,
                          (left + fit.source.width + right) * scaleX, fit.source.height * scaleY);
    const cv::Rect filled = fit.filled();
    cv::Mat inside;
    if (isGuided) {
        resize(depth, part, fittedPhoto(filled), inside);
    } else {
        interpolateDepth(depth, part, filled.size(), inside);
    }
    if (filled.size() == size) {
        fitted = inside;
        return;
    }
    fitted.create(size, CV_32FC1);
    fitted.setTo(focus);
    inside.copyTo(fitted(filled));
}

// Whether the fit enlarges the photo and its depth by so much that refinement before it pays. Views
// of a quilt's size seldom do; their depth, above all from networks, is better refined afterwards.
bool isEnlarged(const Scene& scene, const PhotoFit& fit) {
    constexpr double kLeast = 1.25;
    return fit.target.width >= kLeast * fit.source.width &&
           fit.target.height >= kLeast * fit.source.height &&
           scene.depth.cols <= scene.photo.cols && scene.depth.rows <= scene.photo.rows;
}

// Refines the depth of what the fit shows of a photo at the photo's own size, then enlarges it:
// nearly always more accurate than refinement of the enlarged depth, and quicker
// (docs/lab/edges.md). The mixed px are those of the enlarged photo.
// @param result with the fitted photo; receives depth and mixed px
DepthFlaws refineAndEnlarge(const Scene& scene, const PhotoFit& fit, double focus,
                            const DepthRefineOptions& refine, Scene& result) {
    const double perPixel = columnsPerPixel(fit);
    const cv::Size photo = scene.photo.size();
    const int first = std::max(0, cvFloor(fit.source.x - fit.leftMargin * perPixel));
    const int end = std::min(photo.width, cvCeil(fit.source.br().x + fit.rightMargin * perPixel));
    const cv::Rect shown(first, fit.source.y, end - first, fit.source.height);
    Scene own;
    own.photo = scene.photo(shown);
    own.edges = scene.edges;
    resampleDepth(scene.depth, photo, {shown, {{}, shown.size()}, shown.size()}, own.photo, focus,
                  fitDepth, own.depth);
    DepthFlaws flaws = refine.flaws ? *refine.flaws : measureDepthFlaws(own);
    DepthRefineOptions mixed;
    if (refine.flaws) mixed.flaws.emplace().mixedPixels = flaws.mixedPixels;
    flaws.mixedPixels = 0;
    refineScene(own, {flaws});
    PhotoFit inOwn = fit;
    inOwn.source -= shown.tl();
    resampleDepth(own.depth, shown.size(), inOwn, result.photo, focus, fitRefinedDepth,
                  result.depth);
    result.edges = DepthEdges::Aligned; // so that only mixed px are measured
    flaws.mixedPixels = refineScene(result, mixed, fit.filled()).mixedPixels;
    result.edges = scene.edges;
    return flaws;
}

} // namespace

PhotoFit fitPhoto(cv::Size picture, double panelAspect, cv::Size result, FitMode mode,
                  const Framing& framing) {
    check(picture.width >= 1 && picture.height >= 1, "photo",
          "has " + sizeText(picture) + ", expected at least 1 x 1");
    check(result.width >= 1 && result.height >= 1, "fitted photo",
          "has " + sizeText(result) + ", expected at least 1 x 1");
    checkRange("panel aspect", panelAspect, 0.01, 100);
    checkFraming(framing);
    // Sides of the window that fills the panel, in px of the picture; larger than it if bars show.
    cv::Size2d window = picture;
    const bool wider = static_cast<double>(picture.width) / picture.height > panelAspect;
    if (mode != FitMode::Stretch) {
        if (wider == (mode == FitMode::Cover)) {
            window.width = picture.height * panelAspect;
        } else {
            window.height = picture.width / panelAspect;
        }
    }
    const Axis columns =
        placed(picture.width, window.width / framing.zoom, framing.centre.x, result.width);
    const Axis rows =
        placed(picture.height, window.height / framing.zoom, framing.centre.y, result.height);
    const PhotoFit fit{
        {columns.source.start, rows.source.start, columns.source.size(), rows.source.size()},
        {columns.target.start, rows.target.start, columns.target.size(), rows.target.size()},
        result};
    const int least = std::min(fit.source.width, fit.source.height);
    if (framing.zoom > 1 && least < kMinFramedPixels) {
        throw Error(ErrorCode::InvalidArgument, "zoom",
                    numberText(framing.zoom) + " leaves " + sizeText(fit.source.size()) +
                        " of a picture of " + sizeText(picture) +
                        ", expected a smaller one that leaves at least " +
                        std::to_string(kMinFramedPixels) + " px on each side");
    }
    return fit;
}

PhotoFit withMargins(const PhotoFit& fit, cv::Size picture, int pixels) {
    checkFit(fit, picture);
    check(pixels >= 0, "margin", "is " + std::to_string(pixels) + " px, expected 0 or more");
    const double perPixel = columnsPerPixel(fit);
    // Whole px of the picture where it is enlarged, and of the result where it is shrunk.
    const auto margin = [&](int beside) {
        constexpr double kRounding = 1e-9;
        const double columns = std::min<double>(
            perPixel < 1 ? std::ceil(pixels * perPixel) : pixels * perPixel, beside);
        return static_cast<int>(columns / perPixel + kRounding);
    };
    PhotoFit result = fit;
    if (fit.target.x == 0) result.leftMargin = margin(fit.source.x);
    if (fit.target.br().x == fit.size.width)
        result.rightMargin = margin(picture.width - fit.source.br().x);
    return result;
}

void applyFit(const cv::Mat& picture, const PhotoFit& fit, cv::Mat& fitted) try {
    checkType(picture, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    checkFit(fit, picture.size());
    cv::Mat result(fit.fittedSize(), CV_8UC3); // not `fitted`: it may be the picture itself
    const cv::Rect filled = fit.filled();
    if (filled.size() != result.size()) result.setTo(cv::Scalar::all(0));
    // The margins apart, so that they do not change what the panel shows.
    const auto part = [&](cv::Range columns, int from, int width) {
        const cv::Rect source(columns.start, fit.source.y, columns.size(), fit.source.height);
        resample(picture(source), result(cv::Rect(from, filled.y, width, filled.height)));
    };
    const int begin = fit.source.x;
    const int end = fit.source.br().x;
    if (fit.leftMargin > 0)
        part({begin - marginColumns(fit, fit.leftMargin, begin), begin}, 0, fit.leftMargin);
    part({begin, end}, fit.leftMargin + fit.target.x, fit.target.width);
    if (fit.rightMargin > 0) {
        const int columns = marginColumns(fit, fit.rightMargin, picture.cols - end);
        part({end, end + columns}, result.cols - fit.rightMargin, fit.rightMargin);
    }
    fitted = result;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void applyFitToDepth(const cv::Mat& depth, cv::Size photoSize, const PhotoFit& fit,
                     const cv::Mat& fittedPhoto, double focus, cv::Mat& fitted) try {
    resampleDepth(depth, photoSize, fit, fittedPhoto, focus, fitDepth, fitted);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

DepthFlaws measureDepthFlaws(const Scene& scene) try {
    DepthFlaws flaws = measureDepthFlaws(scene.photo, scene.depth);
    if (scene.edges == DepthEdges::Aligned) { // by estimatePhoto(), which leaves mixed px
        DepthFlaws mixed;
        mixed.mixedPixels = flaws.mixedPixels;
        return mixed;
    }
    if (scene.edges == DepthEdges::Matched) {
        // Matching widens near things where the background is plain. Correction would erode all.
        flaws.growthPixels = 0;
        flaws.shiftPixels = {};
    }
    return flaws;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

DepthFlaws refineScene(Scene& scene, const DepthRefineOptions& options, const cv::Rect& part) try {
    checkPhotoAndDepth(scene.photo, scene.depth, "depth", "CV_32FC1");
    const cv::Rect all({}, scene.photo.size());
    check(part.empty() || (part & all) == part, "part",
          "is not inside the photo, expected a part of its " + sizeText(all.size()));
    const cv::Rect inside = part.empty() ? all : part;
    if (options.keepsDepth()) {
        scene.mixedPixels = 0;
        return {};
    }
    const cv::Mat photo = scene.photo(inside);
    const cv::Mat whole = scene.depth.clone(); // others may share its memory
    cv::Mat depth = whole(inside);
    DepthRefineOptions refine = options;
    if (!refine.flaws && scene.edges != DepthEdges::Unknown)
        refine.flaws = measureDepthFlaws(Scene{photo, depth, {}, {}, scene.edges});
    const DepthFlaws flaws = refineDepth(photo, depth, depth, refine);
    scene.depth = whole;
    scene.mixedPixels = flaws.mixedPixels;
    return flaws;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

DepthFlaws fitScene(const Scene& scene, const PhotoFit& fit, double focus, Scene& fitted,
                    const DepthRefineOptions& refine) try {
    if (scene.depth.type() == CV_32FC1) checkDepthRange(scene.depth);
    const cv::Size photoSize = scene.photo.size();
    Scene result;
    if (!scene.hidden.photo.empty()) fitHidden(scene.hidden, photoSize, fit, result.hidden);
    applyFit(scene.photo, fit, result.photo);
    result.shown = fit.shown();
    result.edges = scene.edges;
    DepthFlaws flaws;
    if (!refine.keepsDepth() && isEnlarged(scene, fit)) {
        flaws = refineAndEnlarge(scene, fit, focus, refine, result);
    } else {
        applyFitToDepth(scene.depth, photoSize, fit, result.photo, focus, result.depth);
        flaws = refineScene(result, refine, fit.filled());
    }
    fitted = result;
    return flaws;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
