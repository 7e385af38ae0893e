#include "viewer/making.hpp"

#include "altiro3D/altiro3D.hpp"
#include "common/outputs.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

constexpr int kSwayFrames = 96; // 4 s, there and back
constexpr int kSwayFps = 24;
constexpr double kSwayPixels = 1.2e6;

Fitted fittedTiles(const Scene& scene) {
    if (scene.document->kind != Kind::Scene) return {};
    return fitScene(scene, quiltLayout(scene).tileSize);
}

// One view of the scene, of the fitted photo or of a quilt.
cv::Mat viewAt(const Scene& scene, const Fitted& fitted, const cv::Mat& quilt, double position) {
    cv::Mat view;
    if (scene.document->kind == Kind::Scene) {
        const QuiltLayout alone{1, 1, fitted.photo.size(), 1};
        Depth2Quilt(alone, scene.knobs.views)
            .renderView(fitted.photo, fitted.depth, position, view);
        return view;
    }
    const QuiltLayout layout = quiltLayout(scene);
    const int number = static_cast<int>(std::lround((position + 1) / 2 * (layout.viewCount - 1)));
    return quilt(layout.tile(std::clamp(number, 0, layout.viewCount - 1)));
}

void writeViews(const Scene& scene, const fs::path& directory, const Progress& progress) {
    const QuiltLayout layout = quiltLayout(scene);
    const cv::Mat quilt = makeQuilt(scene, fittedTiles(scene));
    std::error_code error;
    const bool isNew = !fs::exists(directory, error);
    tools::Outputs outputs(true);
    outputs.addDirectory(directory);
    outputs.makeDirectories();
    std::vector<fs::path> written;
    try {
        for (int i = 0; i < layout.viewCount; ++i) {
            progress(static_cast<double>(i) / layout.viewCount);
            const fs::path file = directory / tools::viewFileName(i, layout.viewCount);
            writePicture(file, quilt(layout.tile(i)));
            written.push_back(file);
        }
    } catch (...) {
        for (const fs::path& file : written)
            fs::remove(file, error);
        if (isNew) fs::remove(directory, error);
        throw;
    }
}

void writeSway(const Scene& scene, const fs::path& file, const Progress& progress) {
    const QuiltLayout layout = quiltLayout(scene);
    const double aspect = scene.display->panelAspect();
    cv::Size size = layout.tileSize;
    if (scene.document->kind == Kind::Scene) {
        const double width =
            std::min<double>(std::sqrt(kSwayPixels * aspect), scene.document->picture.cols);
        size = {static_cast<int>(width), static_cast<int>(width / aspect)};
    } else {
        size.width = static_cast<int>(std::lround(size.height * aspect));
    }
    size = {std::max(size.width & ~1, 16), std::max(size.height & ~1, 16)}; // as 4:2:0 wants it
    Fitted fitted;
    cv::Mat quilt;
    if (scene.document->kind == Kind::Scene)
        fitted = fitScene(scene, size);
    else
        quilt = makeQuilt(scene, {});
    VideoWriterOptions options;
    options.size = size;
    options.compatible = true; // views, not Natives: any player will do
    options.timeBase = {1, kSwayFps};
    options.frameRate = {kSwayFps, 1};
    options.constantRate = true;
    VideoWriter writer(file, options);
    for (int i = 0; i < kSwayFrames; ++i) {
        progress(static_cast<double>(i) / kSwayFrames);
        const cv::Mat view = viewAt(scene, fitted, quilt, std::sin(2 * CV_PI * i / kSwayFrames));
        VideoFrame frame;
        applyFit(view, fitPhoto(view.size(), aspect, size, FitMode::Stretch), frame.picture);
        frame.pts = i;
        frame.duration = 1;
        writer.write(frame);
    }
    writer.finish();
}

void writeDepth(const Scene& scene, const fs::path& file) {
    const cv::Mat& photo = scene.document->picture;
    cv::Mat depth;
    fitDepth(scene.depth, {0, 0, double(scene.depth.cols), double(scene.depth.rows)}, photo, depth);
    writePicture(file, depthTo16Bit(depth));
}

} // namespace

QuiltLayout quiltLayout(const Scene& scene) {
    return scene.document->kind == Kind::Quilt ? scene.document->layout
                                               : layoutOf(scene.knobs, *scene.display);
}

Fitted fitScene(const Scene& scene, cv::Size size) {
    const cv::Mat& photo = scene.document->picture;
    const PhotoFit fit =
        fitPhoto(photo.size(), scene.display->panelAspect(), size, scene.knobs.fit);
    Fitted fitted;
    applyFit(photo, fit, fitted.photo);
    applyFitToDepth(scene.depth, photo.size(), fit, fitted.photo, scene.knobs.views.focus,
                    fitted.depth);
    return fitted;
}

cv::Mat makeQuilt(const Scene& scene, const Fitted& fitted) {
    if (scene.document->kind == Kind::Quilt) return scene.document->picture;
    cv::Mat quilt;
    Depth2Quilt(quiltLayout(scene), scene.knobs.views).render(fitted.photo, fitted.depth, quilt);
    return quilt;
}

cv::Mat makeNative(const Scene& scene, const Fitted& fitted) {
    if (scene.document->kind == Kind::Native) return scene.document->picture;
    const QuiltLayout layout = quiltLayout(scene);
    const Calibration& calibration = *scene.display->calibration;
    const InvertViews invert = scene.display->invert;
    cv::Mat native;
    if (scene.document->kind == Kind::Scene && scene.knobs.views.method != ViewMethod::Real) {
        NativeRenderer(calibration, layout.viewCount, scene.knobs.views, ViewPositions::Discrete,
                       invert)
            .render(fitted.photo, fitted.depth, native);
    } else {
        Quilt2Native(NativeLut(calibration, layout, invert))
            .render(makeQuilt(scene, fitted), native);
    }
    return native;
}

std::vector<Product> productsOf(Kind kind) {
    switch (kind) {
    case Kind::Native:
        return {Product::Native};
    case Kind::Quilt:
        return {Product::Native, Product::Quilt, Product::Views, Product::SwayVideo};
    case Kind::Scene:
        break;
    }
    return {Product::Native, Product::Quilt, Product::Views, Product::Depth, Product::SwayVideo};
}

std::string writeProduct(const Scene& scene, Product product, const fs::path& target,
                         const Progress& progress) {
    progress(0);
    fs::path file = target;
    switch (product) {
    case Product::Native: {
        const cv::Mat native = makeNative(scene, fittedTiles(scene));
        progress(0.5);
        writePicture(file, native);
        break;
    }
    case Product::Quilt: {
        file = quiltFileName(target, quiltLayout(scene), scene.display->panelAspect());
        const cv::Mat quilt = makeQuilt(scene, fittedTiles(scene));
        progress(0.5);
        writePicture(file, quilt);
        break;
    }
    case Product::Views:
        writeViews(scene, file, progress);
        break;
    case Product::Depth:
        writeDepth(scene, file);
        break;
    case Product::SwayVideo:
        writeSway(scene, file, progress);
        break;
    }
    return file.string();
}

} // namespace altiro3D::viewer
