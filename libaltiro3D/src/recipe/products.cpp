#include "altiro3D/products.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/image_io.hpp"
#include "base/checks.hpp"

#include <algorithm>
#include <mutex>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// The photo, shrunk if its longer side exceeds a length.
cv::Mat smallerPhoto(const cv::Mat& photo, int longerSide) {
    const double scale = static_cast<double>(longerSide) / std::max(photo.cols, photo.rows);
    if (scale >= 1) return photo;
    const auto scaled = [scale](int side) { return std::max(1, cvRound(side * scale)); };
    cv::Mat smaller;
    cv::resize(photo, smaller, {scaled(photo.cols), scaled(photo.rows)}, 0, 0, cv::INTER_AREA);
    return smaller;
}

} // namespace

Placement placeFrame(const Scene& frame, double aspect, cv::Size size,
                     const PlacementOptions& options, std::optional<DepthFlaws>& kept) {
    PlacementOptions known = options;
    if (!known.refine.flaws) known.refine.flaws = kept;
    Placement placed = placeScene(frame, aspect, size, known);
    kept = placed.flaws;
    return placed;
}

cv::Mat savedDepth(Scene scene, int longerSide) try {
    checkType(scene.photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    checkDepthRange(scene.depth);
    checkNumber(longerSide > 0, "longerSide", longerSide, "1 px or more");
    const cv::Mat guide = smallerPhoto(scene.photo, longerSide);
    scene.photo.release();
    cv::Mat depth;
    fitDepth(scene.depth, {0, 0, double(scene.depth.cols), double(scene.depth.rows)}, guide, depth);
    cv::patchNaNs(depth, 0);
    return cv::min(cv::max(depth, 0), 1);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

StereoPair photoEyes(const Scene& scene, const PlacementOptions& options, double strengthPercent,
                     EyesFrom from) {
    PlacementOptions whole = options;
    whole.fit = FitMode::Stretch; // to its own shape
    whole.framing = {};
    whole.views.strengthPercent = strengthPercent;
    const cv::Size size = scene.photo.size();
    const double aspect = static_cast<double>(size.width) / size.height;
    return renderEyes(placeScene(scene, aspect, size, whole).scene, whole.views, from);
}

PhotoFit swayFitOf(cv::Size photo, const PlacementOptions& options,
                   const std::optional<cv::Rect>& part, cv::Size size) {
    const cv::Rect shown = part.value_or(cv::Rect({}, photo));
    const double aspect = shown.empty() ? 1.0 : static_cast<double>(shown.width) / shown.height;
    if (size.empty()) size = swaySize(shown.size(), aspect);
    PhotoFit fit = swayFit(shown.size(), std::clamp(aspect, 0.01, 100.0), size, options.fit);
    fit.source += shown.tl();
    return withMargins(fit, photo, options.views);
}

SwayView swayViewsOf(const Scene& scene, const PlacementOptions& options, const PhotoFit& fit) {
    Scene fitted;
    fitScene(withDepthCurve(scene, options.depthCurve), fit, options.views.focus, fitted,
             options.refine);
    return photoViews(fitted, options.views);
}

SplatScene photoSplats(const Scene& scene, const PlacementOptions& options,
                       const std::optional<cv::Rect>& part, int side, double focalLength) {
    constexpr double kFilmDiagonal = 43.267; // mm
    const cv::Rect shown = part.value_or(cv::Rect({}, scene.photo.size()));
    check(!shown.empty() && (shown & cv::Rect({}, scene.photo.size())) == shown, "part",
          "is not inside the photo, expected a part of its px");
    checkRange("side", side, 16, 8192, " px");
    checkRange("focalLength", focalLength, 0, 5000, " mm");
    const double scale =
        std::min(1.0, static_cast<double>(side) / std::max(shown.width, shown.height));
    const cv::Size size(std::max(1, cvRound(shown.width * scale)),
                        std::max(1, cvRound(shown.height * scale)));
    PhotoFit fit;
    fit.size = size;
    fit.source = shown;
    fit.target = {{}, size};
    Scene fitted;
    fitScene(withDepthCurve(scene, options.depthCurve), fit, options.views.focus, fitted,
             options.refine);
    const double millimetres = focalLength > 0 ? focalLength : kUsualFocalLength;
    const double diagonal = std::hypot(scene.photo.cols, scene.photo.rows);
    const double focal = millimetres / kFilmDiagonal * diagonal; // px of the photo
    PhotoSplatOptions splats;
    splats.focus = options.views.focus;
    splats.viewDegrees =
        std::clamp(2 * std::atan(shown.height / 2.0 / focal) * 180 / CV_PI, 1.0, 150.0);
    return splatsOf(fitted, splats);
}

bool writeViews(const std::function<fs::path(int)>& fileOf, const cv::Mat& quilt,
                const QuiltLayout& layout, const std::function<bool(double)>& goOn) try {
    checkFunction(fileOf, "fileOf");
    validate(layout);
    checkType(quilt, {CV_8UC3}, "quilt", "CV_8UC3 (8-bit BGR)");
    checkSize(quilt.size(), layout.size(), "quilt");
    std::mutex mutex;
    std::vector<fs::path> written;
    bool isCancelled = false;
    const auto removeAll = [&] {
        std::error_code ignored;
        for (const fs::path& file : written)
            fs::remove(file, ignored);
    };
    try {
        cv::parallel_for_(cv::Range(0, layout.viewCount), [&](const cv::Range& range) {
            for (int view = range.start; view < range.end; ++view) {
                {
                    const std::lock_guard<std::mutex> lock(mutex);
                    const double done = static_cast<double>(written.size()) / layout.viewCount;
                    isCancelled = isCancelled || (goOn && !goOn(done));
                    if (isCancelled) return;
                }
                const fs::path file = fileOf(view);
                writeImage(file, quilt(layout.tile(view)));
                const std::lock_guard<std::mutex> lock(mutex);
                written.push_back(file);
            }
        });
    } catch (...) {
        removeAll();
        throw;
    }
    if (isCancelled) removeAll();
    return !isCancelled;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
