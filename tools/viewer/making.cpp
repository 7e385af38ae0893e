#include "viewer/making.hpp"

#include "altiro3D/altiro3D.hpp"
#include "common/outputs.hpp"
#include "common/picture_options.hpp"
#include "common/quilt_shape.hpp"

#include <algorithm>
#include <opencv2/core.hpp>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

// Of a photo; else nothing, which quilts and Natives need.
Fitted fitted(const Scene& scene, cv::Size size) {
    return scene.document->kind == Kind::Scene ? fitScene(scene, size) : Fitted();
}

Fitted fittedTiles(const Scene& scene) {
    return fitted(scene, quiltLayout(scene).tileSize);
}

// Views of two pictures in one directory would be taken for one picture.
void requireNoViews(const fs::path& directory) {
    std::error_code error;
    if (!fs::is_directory(directory, error)) return;
    for (const fs::path& picture : listPictures(directory)) {
        if (picture.filename().string().rfind("view_", 0) != 0) continue;
        throw Error(ErrorCode::WriteFailed, directory.string(),
                    "holds " + picture.filename().string() +
                        " already, expected a folder without views");
    }
}

void writeViews(const Scene& scene, const fs::path& directory, const Progress& progress) {
    requireNoViews(directory);
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

// As photo2native and quilt2video make it: a photo in its own shape.
void writeSwayVideo(const Scene& scene, const fs::path& file, const Progress& progress) {
    const auto tell = [&progress](int frame, int frames) {
        progress(static_cast<double>(frame) / frames);
    };
    if (scene.document->kind == Kind::Scene) {
        const cv::Mat& photo = scene.document->picture;
        const double aspect = static_cast<double>(photo.cols) / photo.rows;
        const cv::Size size = swaySize(photo.size(), aspect);
        const PhotoFit fit =
            swayFit(photo.size(), std::clamp(aspect, 0.01, 100.0), size, scene.knobs.fit);
        Fitted fitted;
        applyFit(photo, fit, fitted.photo);
        applyFitToDepth(scene.depth, photo.size(), fit, fitted.photo, scene.knobs.views.focus,
                        fitted.depth);
        writeSway(file, size, {}, photoViews(fitted.photo, fitted.depth, scene.knobs.views), tell);
        return;
    }
    const QuiltLayout layout = quiltLayout(scene);
    const auto name = parseQuiltName(scene.document->source.file);
    const double aspect =
        name ? name->aspect.value_or(scene.display->aspect()) : scene.display->aspect();
    const cv::Size size = swaySize(layout.tileSize, aspect);
    writeSway(file, size, {},
              quiltViews(makeQuilt(scene, {}), layout, swayFit(layout.tileSize, aspect, size)),
              tell);
}

void writeDepth(const Scene& scene, const fs::path& file) {
    const cv::Mat& photo = scene.document->picture;
    cv::Mat depth;
    fitDepth(scene.depth, {0, 0, double(scene.depth.cols), double(scene.depth.rows)}, photo, depth);
    writePicture(file, depthTo16Bit(depth));
}

} // namespace

void layFlatDepth(Scene& scene) {
    if (scene.flat)
        scene.depth = cv::Mat(scene.depth.size(), CV_32FC1, cv::Scalar(scene.knobs.views.focus));
}

QuiltLayout quiltLayout(const Scene& scene) {
    return scene.document->kind == Kind::Quilt ? scene.document->layout
                                               : layoutOf(scene.knobs, *scene.display);
}

Fitted fitScene(const Scene& scene, cv::Size size) {
    const cv::Mat& photo = scene.document->picture;
    const PhotoFit fit = fitPhoto(photo.size(), scene.display->aspect(), size, scene.knobs.fit);
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

cv::Size nativeFitSize(const Scene& scene) {
    return makesBestNative(scene.knobs) ? scene.display->panelSize() : quiltLayout(scene).tileSize;
}

cv::Mat makeNative(const Scene& scene, const Fitted& fitted) {
    if (scene.document->kind == Kind::Native) return scene.document->picture;
    const QuiltLayout layout = quiltLayout(scene);
    const Calibration& calibration = scene.display->calibration;
    const InvertViews invert = scene.display->invert;
    cv::Mat native;
    if (scene.document->kind == Kind::Scene && scene.knobs.views.method != ViewMethod::Real) {
        const ViewPositions positions =
            makesBestNative(scene.knobs) ? ViewPositions::Continuous : ViewPositions::Discrete;
        NativeRenderer(calibration, layout.viewCount, scene.knobs.views, positions, invert)
            .render(fitted.photo, fitted.depth, native);
    } else {
        cv::Mat quilt = makeQuilt(scene, fitted);
        const fs::path& file = scene.document->source.file;
        std::error_code error;
        // a quilt's views get the panel's shape as in quilt2native; those of a directory have it
        if (scene.document->kind == Kind::Quilt && !fs::is_directory(file, error)) {
            quilt =
                tools::QuiltShape(file, layout, *scene.display, std::nullopt).apply(quilt, nullptr);
        }
        Quilt2Native(NativeLut(calibration, layout, invert)).render(quilt, native);
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

fs::path productFile(const Scene& scene, Product product, const fs::path& target) {
    if (product != Product::Quilt) return target;
    double aspect = scene.display->aspect();
    if (scene.document->kind == Kind::Quilt) {
        const auto name = parseQuiltName(scene.document->source.file);
        if (name) aspect = name->aspect.value_or(aspect);
    }
    return quiltFileName(target, quiltLayout(scene), aspect);
}

std::vector<std::string> lossesOf(Product product, const fs::path& file) {
    tools::Messages messages("altiro3Dview", false);
    if (product == Product::Native) tools::warnAboutNativeFormat(file, messages);
    if (product == Product::Depth) tools::warnAboutDepthFormat(file, messages);
    return messages.warnings();
}

std::string writeProduct(const Scene& scene, Product product, const fs::path& target,
                         const Progress& progress) {
    progress(0);
    const fs::path file = productFile(scene, product, target);
    switch (product) {
    case Product::Native: {
        const cv::Mat native = makeNative(scene, fitted(scene, nativeFitSize(scene)));
        progress(0.5);
        // a picture that was opened as a Native may be a photo of that size
        const bool made =
            scene.document->kind != Kind::Native || isMarkedNative(scene.document->source.file);
        writePicture(file, native, made ? PictureMark::Native : PictureMark::None);
        break;
    }
    case Product::Quilt: {
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
        writeSwayVideo(scene, file, progress);
        break;
    }
    return file.string();
}

} // namespace altiro3D::viewer
