#include "viewer/model/making.hpp"

#include "altiro3D/altiro3D.hpp"
#include "cli/outputs.hpp"
#include "cli/page_options.hpp"
#include "cli/picture_options.hpp"
#include "viewer/model/knobs.hpp"

#include <algorithm>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

PlacementOptions placementOptions(const Setup& setup) {
    PlacementOptions options = static_cast<const PlacementOptions&>(setup.knobs);
    options.framing = framingOf(setup);
    return options;
}

Scene sceneOf(const Setup& setup) {
    return {setup.document->picture, depthOf(setup), setup.hidden, {}, setup.edges};
}

// Options for the Native of a photo as in photo2native, of a video's frame as in video2native.
NativeOptions nativeOptions(const Setup& setup) {
    NativeOptions options = static_cast<const NativeOptions&>(setup.knobs);
    if (!setup.isDraft && !setup.document->video && options.views.method == ViewMethod::Layered)
        options.showAs(Detail::Lens);
    return options;
}

NativeMaker nativeMaker(const Setup& setup) {
    return {*setup.display, quiltLayout(setup), nativeOptions(setup)};
}

// Width : height of the views of a quilt as they are shown.
double viewAspect(const Setup& setup) {
    const auto name = parseQuiltName(setup.document->source.file);
    const double aspect = setup.display->aspect();
    return name ? name->aspect.value_or(aspect) : aspect;
}

Scene fittedTiles(const Setup& setup) {
    return placed(setup, quiltLayout(setup).tileSize).scene;
}

// Views of two pictures in one directory would be taken for one picture.
void requireNoViews(const fs::path& directory) {
    if (!tools::isDirectory(directory)) return;
    for (const fs::path& picture : listImages(directory)) {
        if (picture.filename().string().rfind("view_", 0) != 0) continue;
        throw Error(ErrorCode::WriteFailed, directory.string(),
                    "holds " + picture.filename().string() +
                        " already, expected a folder without views");
    }
}

bool writeViews(const Setup& setup, const fs::path& directory, const Progress& progress) {
    requireNoViews(directory);
    const QuiltLayout layout = quiltLayout(setup);
    const cv::Mat quilt = makeQuilt(setup, fittedTiles(setup));
    std::error_code error;
    const bool isNew = !fs::exists(directory, error);
    tools::Outputs outputs(true);
    outputs.addDirectory(directory);
    outputs.makeDirectories();
    const auto fileOf = [&](int view) {
        return directory / tools::viewFileName(view, layout.viewCount);
    };
    const auto end = [&] { // of what failed
        if (isNew) fs::remove(directory, error);
    };
    try {
        if (altiro3D::writeViews(fileOf, quilt, layout, progress)) return true;
    } catch (...) {
        end();
        throw;
    }
    end();
    return false;
}

// The part of a photo that the user framed; not set: all of it is shown, as in photo2native.
std::optional<cv::Rect> framedPart(const Setup& setup) {
    const PlacementOptions options = placementOptions(setup);
    if (setup.knobs.isFramingChosen || options.framing == Framing()) return std::nullopt;
    return fitPhoto(setup.document->picture.size(), setup.display->aspect(),
                    quiltLayout(setup).tileSize, options.fit, options.framing)
        .source;
}

// Fits a photo to its sway video.
PhotoFit swayFitOf(const Setup& setup) {
    return altiro3D::swayFitOf(setup.document->picture.size(), placementOptions(setup),
                               framedPart(setup));
}

// The page of a photo or of a quilt, as photo2native and quilt2native make it.
std::string makePage(const Setup& setup) {
    const Document& document = *setup.document;
    const PageText text = tools::PageOptions().text(document.source.file);
    if (document.kind == Kind::Quilt)
        return quiltPage(fitQuilt(document.picture, quiltLayout(setup)), quiltLayout(setup),
                         viewAspect(setup), text);
    return photoPage(sceneOf(setup), placementOptions(setup), text, framedPart(setup));
}

// As photo2native and quilt2video make it: a photo in its own shape.
bool writeSwayVideo(const Setup& setup, const fs::path& file, const Progress& progress) {
    const auto tell = [&progress](const VideoProgress& video) {
        return progress(static_cast<double>(video.frames) /
                        static_cast<double>(*video.framesInAll));
    };
    if (setup.document->kind == Kind::Scene) {
        const PhotoFit fit = swayFitOf(setup);
        return writeSway(file, fit.size, {},
                         swayViewsOf(sceneOf(setup), placementOptions(setup), fit), tell);
    }
    const QuiltLayout layout = quiltLayout(setup);
    const double aspect = viewAspect(setup);
    const cv::Size size = swaySize(layout.tileSize, aspect);
    return writeSway(
        file, size, {},
        quiltViews(makeQuilt(setup, {}), layout, swayFit(layout.tileSize, aspect, size)), tell);
}

} // namespace

std::vector<Mode> modesOf(const std::shared_ptr<const Document>& document) {
    if (document && document->kind == Kind::Native) return {Mode::Lens, Mode::Native};
    if (document && document->kind == Kind::Quilt && !document->splats)
        return {Mode::Sway, Mode::Quilt, Mode::Native, Mode::Lens, Mode::Stereo};
    return {Mode::Sway, Mode::Depth, Mode::Quilt, Mode::Native, Mode::Lens, Mode::Stereo};
}

cv::Mat depthOf(const Setup& setup) {
    return setup.flat ? cv::Mat(setup.depth.size(), CV_32FC1, cv::Scalar(setup.knobs.views.focus))
                      : setup.depth;
}

QuiltLayout quiltLayout(const Setup& setup) {
    return setup.document->kind == Kind::Quilt ? setup.document->layout
                                               : layoutOf(setup.knobs, *setup.display);
}

Framing framingOf(const Setup& setup) {
    return allowed(setup.knobs.framing,
                   {setup.document->picture.size(), setup.display->aspect(), setup.knobs.fit});
}

PhotoFit fitOf(const Setup& setup, cv::Size size) {
    return fitWithMargins(setup.document->picture.size(), setup.display->aspect(), size,
                          placementOptions(setup));
}

Placement placed(const Setup& setup, cv::Size size) {
    std::optional<DepthFlaws> unknown;
    return placed(setup, size, unknown);
}

Placement placed(const Setup& setup, cv::Size size, std::optional<DepthFlaws>& kept) {
    if (setup.document->kind != Kind::Scene) return {}; // quilts and Natives need none
    return placeFrame(sceneOf(setup), setup.display->aspect(), size, placementOptions(setup), kept);
}

cv::Mat fittedPhoto(const Setup& setup, cv::Size size) {
    cv::Mat photo;
    applyFit(setup.document->picture, fitOf(setup, size), photo);
    return photo;
}

Scene fitted(const Setup& setup, cv::Size size, const cv::Mat& fittedPhoto) {
    const PhotoFit fit = fitOf(setup, size);
    Scene scene{fittedPhoto, {}, {}, fit.shown(), setup.edges};
    applyFitToDepth(bendDepth(depthOf(setup), setup.knobs.depthCurve),
                    setup.document->picture.size(), fit, fittedPhoto, setup.knobs.views.focus,
                    scene.depth);
    refineScene(scene, {}, fit.filled());
    return scene;
}

cv::Mat makeQuilt(const Setup& setup, const Scene& fitted) {
    if (setup.document->kind == Kind::Quilt) return setup.document->picture;
    cv::Mat quilt;
    nativeMaker(setup).makeQuilt(fitted, quilt);
    return quilt;
}

cv::Size nativeFitSize(const Setup& setup) {
    return nativeMaker(setup).workSize();
}

cv::Mat makeNative(const Setup& setup, const Scene& fitted) {
    if (setup.document->kind == Kind::Native) return setup.document->picture;
    if (setup.document->kind == Kind::Quilt) {
        if (setup.document->splats) { // as splat2native
            QuiltSampling sampling;
            sampling.inTile = TileSampling::Linear;
            const QuiltLayout layout = quiltLayout(setup);
            const Calibration& calibration = setup.display->calibration;
            cv::Mat native;
            Quilt2Native(calibration, layout, sampling, setup.display->invert)
                .render(filterForLens(setup.document->picture, layout, calibration), native);
            return native;
        }
        return quiltConverter(setup.document->source.file, quiltLayout(setup), *setup.display,
                              static_cast<bool>(setup.document->video))(setup.document->picture);
    }
    cv::Mat native;
    nativeMaker(setup).makeNative(Placement{fitted, {}, {}}, native);
    return native;
}

// The views get the panel's shape as in quilt2native. Those of a directory have it.
std::function<cv::Mat(const cv::Mat&)> quiltConverter(const fs::path& file,
                                                      const QuiltLayout& layout,
                                                      const Display& display, bool isVideo) {
    std::optional<QuiltShape> shape;
    if (!tools::isDirectory(file)) shape.emplace(file, layout, display);
    QuiltSampling sampling; // as in quilt2native
    if (!isVideo) sampling.inTile = TileSampling::Linear;
    const auto converter =
        std::make_shared<const Quilt2Native>(display.calibration, layout, sampling, display.invert);
    return [shape, converter, layout](const cv::Mat& picture) {
        const cv::Mat quilt = fitQuilt(picture, layout);
        cv::Mat native;
        converter->render(shape ? shape->apply(quilt) : quilt, native);
        return native;
    };
}

void chooseAutomatic(Setup& setup) {
    Knobs& knobs = setup.knobs;
    AutoChoices choices = std::exchange(knobs.choices, {});
    if (setup.document->kind != Kind::Scene || !choices.any()) return;
    knobs.isFramingChosen = knobs.isFramingChosen || choices.framing;
    choices.framing = choices.framing && knobs.fit == FitMode::Cover;
    choices.isVideo = setup.document->video;
    if (choices.focus) knobs.views.focus = ViewOptions().focus; // of depth without a range
    if (choices.strength) knobs.views.strengthPercent = ViewOptions().strengthPercent;
    const PlacementOptions chosen =
        chooseFromScene(sceneOf(setup), setup.display->aspect(), quiltLayout(setup),
                        placementOptions(setup), choices)
            .options;
    knobs.views = chosen.views;
    knobs.framing = chosen.framing;
}

double hiddenPercent(const Setup& setup) {
    Scene scene = sceneOf(setup);
    scene.edges = DepthEdges::Aligned; // as of estimated depth, to which the limit applies
    AutoChoices limit;
    limit.limit = true;
    // The other picture of a pair shows a part.
    const double known = setup.hidden.photo.empty() ? 0 : ViewOptions().strengthPercent;
    const double most =
        std::max(known, chooseFromScene(scene, setup.display->aspect(), quiltLayout(setup),
                                        placementOptions(setup), limit)
                            .options.views.strengthPercent);
    const double strength = setup.knobs.views.strengthPercent;
    return most < strength ? kMaxAutoHidden * strength / most : 0;
}

Setup forEyes(Setup setup) {
    setup.knobs.fit = FitMode::Stretch; // to its own shape
    setup.knobs.framing = {};
    setup.knobs.views.strengthPercent = setup.eyes.strengthPercent;
    return setup;
}

double eyesAspect(const Setup& setup) {
    const cv::Size size = setup.document->picture.size();
    return setup.document->kind == Kind::Quilt ? viewAspect(setup)
                                               : static_cast<double>(size.width) / size.height;
}

StereoPair makeEyes(const Setup& setup) {
    if (setup.document->kind == Kind::Quilt)
        return tools::eyesOfQuilt(setup.document->picture, quiltLayout(setup), viewAspect(setup));
    return photoEyes(sceneOf(setup), placementOptions(setup), setup.eyes.strengthPercent,
                     setup.eyes.from);
}

std::vector<Product> productsOf(Kind kind) {
    switch (kind) {
    case Kind::Native:
        return {Product::Native};
    case Kind::Quilt:
        return {Product::Native,    Product::Quilt, Product::Views,
                Product::SwayVideo, Product::Eyes,  Product::Page};
    case Kind::Scene:
        break;
    }
    return {Product::Native,    Product::Quilt, Product::Views, Product::Depth,
            Product::SwayVideo, Product::Eyes,  Product::Page};
}

fs::path productFile(const Setup& setup, Product product, const fs::path& target) {
    if (product != Product::Quilt) return target;
    const bool isQuilt = setup.document->kind == Kind::Quilt;
    return quiltFileName(target, quiltLayout(setup),
                         isQuilt ? viewAspect(setup) : setup.display->aspect());
}

std::vector<std::string> lossesOf(Product product, const fs::path& file) {
    tools::Messages messages("altiro3Dview", false);
    if (product == Product::Native) tools::warnAboutNativeFormat(file, messages);
    if (product == Product::Depth) tools::warnAboutDepthFormat(file, messages);
    return messages.warnings();
}

std::string writeProduct(Setup setup, Product product, const fs::path& target,
                         const Progress& progress) {
    if (!progress(0)) return {};
    chooseAutomatic(setup);
    const fs::path file = productFile(setup, product, target);
    switch (product) {
    case Product::Native: {
        const cv::Mat native = makeNative(setup, placed(setup, nativeFitSize(setup)).scene);
        if (!progress(0.5)) return {};
        // a picture that was opened as a Native may be a photo of that size
        const bool made =
            setup.document->kind != Kind::Native || isMarkedNative(setup.document->source.file);
        writeImage(file, native, made ? ImageMark::Native : ImageMark::None);
        break;
    }
    case Product::Quilt: {
        const cv::Mat quilt = makeQuilt(setup, fittedTiles(setup));
        if (!progress(0.5)) return {};
        writeImage(file, quilt);
        break;
    }
    case Product::Views:
        if (!writeViews(setup, file, progress)) return {};
        break;
    case Product::Depth:
        writeImage(file, depthTo16Bit(savedDepth(sceneOf(setup))));
        break;
    case Product::SwayVideo:
        if (!writeSwayVideo(setup, file, progress)) return {};
        break;
    case Product::Page: {
        const std::string page = makePage(setup);
        if (!progress(0.5)) return {};
        writeFile(file, page);
        break;
    }
    case Product::Eyes: {
        const StereoPair eyes = makeEyes(setup);
        if (!progress(0.5)) return {};
        writeEyes(file, tools::joinedEyes(eyes, setup.eyes), setup.eyes.picture,
                  setup.eyes.swapped);
        const std::string advice = tools::eyesTagAdvice(file, setup.eyes);
        return file.string() + (advice.empty() ? "" : "\n" + advice);
    }
    }
    return file.string();
}

} // namespace altiro3D::viewer
