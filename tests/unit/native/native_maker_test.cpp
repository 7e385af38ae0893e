#include "altiro3D/native_maker.hpp"

#include "altiro3D/error.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/eye.hpp"
#include "support/random_pictures.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

Display smallDisplay() {
    return sixViewDisplay(150, 97, {50, 32});
}

altiro3D::Scene photoWithDepth() {
    return {randomPhoto({91, 70}), randomDepth({40, 31})};
}

cv::Mat nativeOf(const NativeMaker& maker, const altiro3D::Scene& scene) {
    cv::Mat native;
    maker.makeNative(scene, native);
    return native;
}

// The steps one by one, over the quilt: the reference of every path.
cv::Mat overQuilt(const Display& display, const altiro3D::Scene& scene,
                  const NativeOptions& options) {
    const cv::Size work =
        options.detail == Detail::Panel ? display.panelSize() : display.quilt.tileSize;
    const PhotoFit fit = withMargins(
        fitPhoto(scene.photo.size(), display.aspect(), work, options.fit, options.framing),
        scene.photo.size(), options.views);
    cv::Mat photo;
    cv::Mat depth;
    applyFit(scene.photo, fit, photo);
    applyFitToDepth(scene.depth, scene.photo.size(), fit, photo, options.views.focus, depth);
    cv::Mat inside; // the bars are not refined
    refineDepth(photo(fit.filled()), depth(fit.filled()), inside, options.refine);
    inside.copyTo(depth(fit.filled()));
    cv::Mat quilt;
    cv::Mat native;
    Depth2Quilt(display.quilt, options.views).render({photo, depth, {}, fit.shown()}, quilt);
    Quilt2Native(display.calibration, display.quilt, options.sampling, display.invert)
        .render(quilt, native);
    return native;
}

TEST(NativeMaker, LivePicturesAreThoseOfMethodFastAndOfTheDepthAsItIs) {
    const Display display = smallDisplay();
    const altiro3D::Scene scene = photoWithDepth();
    NativeOptions fast;
    fast.views.method = ViewMethod::Fast;
    fast.refine.flaws = DepthFlaws();
    NativeOptions live;
    live.showAs(Detail::Panel); // of which nothing is left
    live.showLive();
    EXPECT_TRUE(
        samePicture(nativeOf(NativeMaker(display, live), scene), overQuilt(display, scene, fast)));
}

TEST(NativeMaker, GivesWhatTheStepsGiveForEachMethodFitAndSampling) {
    const Display display = smallDisplay();
    const altiro3D::Scene scene = photoWithDepth();
    for (const ViewMethod method : {ViewMethod::Fast, ViewMethod::Real, ViewMethod::Layered}) {
        for (const FitMode fit : {FitMode::Cover, FitMode::Contain, FitMode::Stretch}) {
            for (const ViewFilter filter : {ViewFilter::Nearest, ViewFilter::Linear}) {
                NativeOptions options;
                options.views.method = method;
                options.views.focus = 0.3;
                options.fit = fit;
                options.sampling.views = filter;
                const NativeMaker maker(display, options);
                const bool direct = method != ViewMethod::Real && filter == ViewFilter::Nearest;
                EXPECT_EQ(maker.path(), direct ? NativePath::Direct : NativePath::OverQuilt);
                EXPECT_EQ(NativeMaker::obstacle(display.quilt, options).empty(), direct);
                const cv::Mat native = nativeOf(maker, scene);
                EXPECT_TRUE(samePicture(native, overQuilt(display, scene, options)));
                cv::Mat redFirst;
                maker.makeNative(scene, redFirst, ChannelOrder::Rgb);
                cv::cvtColor(redFirst, redFirst, cv::COLOR_RGB2BGR);
                EXPECT_TRUE(samePicture(redFirst, native));
            }
        }
    }
}

TEST(NativeMaker, FramingIsTheSameOnBothPathsAndShowsThatPartAndItsMarginsAlone) {
    const Display display = smallDisplay();
    const altiro3D::Scene scene = photoWithDepth();
    NativeOptions options;
    cv::Mat usual = nativeOf(NativeMaker(display, options), scene);
    options.framing = {{0.2, 0.7}, 1.7};
    const NativeMaker maker(display, options);
    EXPECT_EQ(maker.path(), NativePath::Direct);
    const cv::Mat native = nativeOf(maker, scene);
    EXPECT_TRUE(samePicture(native, overQuilt(display, scene, options)));
    EXPECT_FALSE(samePicture(native, usual));
    // px outside of the part and its margins do not matter; given whole depth px, nor does depth
    altiro3D::Scene other{scene.photo.clone(), cv::Mat(scene.photo.size(), CV_32FC1, 0.4F)};
    maker.makeNative(other, usual);
    cv::Mat inside;
    const PhotoFit fit =
        fitWithMargins(scene.photo.size(), display.aspect(), maker.workSize(), options);
    const auto columns = [&fit](int margin) {
        return static_cast<int>(std::ceil(1.0 * margin * fit.source.width / fit.size.width));
    };
    cv::Rect used = fit.source;
    used.x -= columns(fit.leftMargin);
    used.width += columns(fit.leftMargin) + columns(fit.rightMargin);
    ASSERT_GT(used.width, fit.source.width);
    other.photo(used).copyTo(inside);
    other.photo.setTo(cv::Scalar(1, 2, 3));
    inside.copyTo(other.photo(used));
    EXPECT_TRUE(samePicture(nativeOf(maker, other), usual));
}

TEST(NativeMaker, ShowsWhatIsHiddenOnBothPaths) {
    const Display display = smallDisplay();
    altiro3D::Scene scene = photoWithDepth();
    scene.depth = cv::Mat(scene.photo.size(), CV_32FC1, 0.1F);
    scene.depth(cv::Rect(30, 10, 30, 50)).setTo(0.9);
    NativeOptions options;
    options.views.strengthPercent = 40;
    const cv::Mat painted = nativeOf(NativeMaker(display, options), scene);
    scene.hidden = {randomPhoto(scene.photo.size(), 77),
                    cv::Mat(scene.photo.size(), CV_32FC1, 0.1F)};
    cv::Mat direct = nativeOf(NativeMaker(display, options), scene);
    EXPECT_FALSE(samePicture(direct, painted));
    const NativeMaker over(NativeLut(display.calibration, display.quilt, display.invert), options);
    ASSERT_EQ(over.path(), NativePath::OverQuilt);
    const cv::Mat native = nativeOf(over, scene);
    EXPECT_TRUE(samePicture(native, direct));
    // only method Layered shows it
    options.views.method = ViewMethod::Fast;
    direct = nativeOf(NativeMaker(display, options), scene);
    scene.hidden = {};
    EXPECT_TRUE(samePicture(nativeOf(NativeMaker(display, options), scene), direct));
}

TEST(NativeMaker, KeepsThePanelsResolutionAndTakesContinuousPositions) {
    const Display display = smallDisplay();
    const altiro3D::Scene scene = photoWithDepth();
    NativeOptions options;
    options.detail = Detail::Panel;
    options.positions = ViewPositions::Continuous;
    const NativeMaker maker(display, options);
    EXPECT_EQ(maker.workSize(), display.panelSize());
    const cv::Mat native = nativeOf(maker, scene);
    altiro3D::Scene fitted;
    fitScene(scene, fitPhoto(scene.photo.size(), display.aspect(), display.panelSize()),
             options.views.focus, fitted);
    cv::Mat expected;
    NativeRenderer(display.calibration, 6, options.views, ViewPositions::Continuous)
        .render(fitted, expected);
    EXPECT_TRUE(samePicture(native, expected));
}

// With a Portrait's lenses, 6.2 px wide.
Display portraitOf240Pixels() {
    Display display;
    display.calibration = stripePanel(240, 320);
    display.quilt = {8, 6, {66, 88}, 48};
    return display;
}

// Seen as an eye sees them, for photos with detail of all sizes.
TEST(NativeMaker, WhatIsShownForTheLensesIsNearerToThePhotoForAnEye) {
    const Display display = portraitOf240Pixels();
    const LensTwin lens(lensGeometry(display.calibration, display.invert));
    for (const int seed : {1, 2}) {
        const cv::Mat photo = randomPhoto({480, 640}, seed);
        const altiro3D::Scene scene{photo, cv::Mat(photo.size(), CV_32FC1, 0.5F)};
        cv::Mat truth;
        applyFit(photo, fitPhoto(photo.size(), display.aspect(), display.panelSize()), truth);
        const EyePicture wanted = blurredByEye(lightOf(truth));
        const auto difference = [&](const NativeOptions& options) {
            const cv::Mat native = nativeOf(NativeMaker(display, options), scene);
            return eyeDifference(blurredByEye(lens.seen(lightOf(native), 0.4)), wanted);
        };
        NativeOptions shown;
        shown.showAs(Detail::Lens);
        NativeOptions panel;
        panel.detail = Detail::Panel;
        panel.positions = ViewPositions::Continuous;
        const EyeDifference best = difference(shown);
        for (const NativeOptions& other : {NativeOptions(), panel}) {
            const EyeDifference plain = difference(other);
            EXPECT_GT(best.luminancePsnr[1], plain.luminancePsnr[1] + 1);
            EXPECT_LT(best.chroma, 0.9 * plain.chroma);
        }
    }
}

TEST(NativeMaker, WorksOnTwoToThreePixelsPerLensAndNotOnAllOfAnEightK) {
    Display display = portraitOf240Pixels();
    const auto sizeAt = [&](cv::Size panel, double lensesPerInch) {
        display.calibration.screenW = panel.width;
        display.calibration.screenH = panel.height;
        display.calibration.DPI = 280;
        display.calibration.pitch = lensesPerInch;
        NativeOptions options;
        options.showAs(Detail::Lens);
        return NativeMaker(display, options).workSize();
    };
    EXPECT_EQ(sizeAt({1536, 2048}, 45), cv::Size(768, 1024));
    EXPECT_EQ(sizeAt({3840, 2160}, 75), cv::Size(3840, 2160));
    EXPECT_EQ(sizeAt({7680, 4320}, 38), cv::Size(3840, 2160));
    EXPECT_EQ(sizeAt({7680, 4320}, 75), cv::Size(3840, 2160)); // 33 million px otherwise
    const cv::Size wall = sizeAt({12800, 16000}, 75);          // a quarter of it is 51 million px
    EXPECT_NEAR(wall.area(), 12e6, 1e4);
    EXPECT_NEAR(1.25 * wall.width, wall.height, 2);
}

// Stripes of one px, which no lens shows, stand behind a near bar.
TEST(NativeMaker, WhatIsHiddenIsFilteredAsWell) {
    const Display display = portraitOf240Pixels();
    NativeOptions options;
    options.views.strengthPercent = 60;
    options.showAs(Detail::Lens);
    const cv::Size size = NativeMaker(display, options).workSize();
    altiro3D::Scene scene{cv::Mat(size, CV_8UC3, cv::Scalar::all(128)),
                          cv::Mat(size, CV_32FC1, 0.2F)};
    scene.depth(cv::Rect(50, 0, 20, size.height)).setTo(0.9F);
    scene.hidden = {cv::Mat(size, CV_8UC3, cv::Scalar::all(0)), cv::Mat(size, CV_32FC1, 0.2F)};
    for (int x = 0; x < size.width; x += 2)
        scene.hidden.photo.col(x).setTo(cv::Scalar::all(255));
    const auto range = [&] {
        const cv::Mat native = nativeOf(NativeMaker(display, options), scene);
        double least = 0;
        double most = 0;
        cv::minMaxLoc(native.reshape(1), &least, &most);
        return most - least;
    };
    EXPECT_LT(range(), 130);
    options.lensFilter = false;
    EXPECT_GT(range(), 200);
}

TEST(NativeMaker, FiltersOverAQuiltAtTheSizeOfItsViews) {
    const Display display = portraitOf240Pixels();
    const altiro3D::Scene scene = photoWithDepth();
    NativeOptions options;
    options.lensFilter = true;
    options.sampling.inTile = TileSampling::Linear;
    const cv::Mat ofViews = nativeOf(NativeMaker(display, options), scene);
    options.detail = Detail::Panel;
    const NativeMaker maker(display, options);
    EXPECT_EQ(maker.quiltSize(), display.quilt.tileSize);
    EXPECT_TRUE(samePicture(nativeOf(maker, scene), ofViews));
}

TEST(NativeMaker, AMapGivesWhatItsCalibrationGives) {
    Display display = smallDisplay();
    display.invert = InvertViews::Off;
    const altiro3D::Scene scene = photoWithDepth();
    const NativeOptions options;
    const NativeMaker mapped(NativeLut(display.calibration, display.quilt, display.invert),
                             options);
    EXPECT_EQ(mapped.path(), NativePath::OverQuilt);
    EXPECT_TRUE(samePicture(nativeOf(mapped, scene), overQuilt(display, scene, options)));
}

TEST(NativeMaker, OtherViewsShareTheRest) {
    const Display display = smallDisplay();
    const altiro3D::Scene scene = photoWithDepth();
    for (const ViewMethod method : {ViewMethod::Real, ViewMethod::Layered}) {
        NativeOptions options;
        options.views.method = method;
        const NativeMaker maker(display, options);
        options.views.strengthPercent = 3;
        options.views.focus = 0.8;
        EXPECT_TRUE(samePicture(nativeOf(maker.withViews(options.views), scene),
                                overQuilt(display, scene, options)));
        EXPECT_EQ(maker.options().views.strengthPercent, 10) << "the first one stays as it was";
    }
}

TEST(NativeMaker, RefusesContinuousPositionsOverAQuilt) {
    const Display display = smallDisplay();
    NativeOptions options;
    options.positions = ViewPositions::Continuous;
    options.views.method = ViewMethod::Real;
    EXPECT_THROW(NativeMaker(display, options), Error);
    options.views.method = ViewMethod::Fast;
    options.sampling.inTile = TileSampling::Linear;
    EXPECT_THROW(NativeMaker(display, options), Error);
    options.sampling = {};
    EXPECT_NO_THROW(NativeMaker(display, options));
    const NativeLut map(display.calibration, display.quilt);
    EXPECT_THROW(NativeMaker(map, options), Error);
}

TEST(NativeMaker, RefusesPhotosThatAreNotFitted) {
    const NativeMaker maker(smallDisplay());
    ASSERT_EQ(maker.path(), NativePath::Direct);
    const altiro3D::Scene unfitted{randomPhoto({91, 70}), randomDepth({91, 70})};
    cv::Mat quilt;
    cv::Mat native;
    EXPECT_THROW(maker.makeQuilt(unfitted, quilt), Error);
    EXPECT_THROW(maker.makeNative(unfitted, {}, native), Error);
    EXPECT_TRUE(quilt.empty() && native.empty());
}

} // namespace
} // namespace altiro3D::test
