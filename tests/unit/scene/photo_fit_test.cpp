#include "altiro3D/photo_fit.hpp"

#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/pixels.hpp"
#include "support/random_pictures.hpp"

#include <climits>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

TEST(PhotoFit, CoverCutsBothSidesAlike) {
    const PhotoFit wide = fitPhoto({1000, 300}, 0.75, {420, 560});
    EXPECT_EQ(wide.source, cv::Rect(387, 0, 225, 300));
    EXPECT_EQ(wide.target, cv::Rect(0, 0, 420, 560));
    const PhotoFit tall = fitPhoto({300, 1000}, 0.75, {420, 560});
    EXPECT_EQ(tall.source, cv::Rect(0, 300, 300, 400));
    EXPECT_EQ(fitPhoto({1536, 2048}, 0.75, {420, 560}).source, cv::Rect(0, 0, 1536, 2048));
}

TEST(FitScene, OtherNumbersThanThoseOfADepthMapAreRefused) {
    const cv::Mat photo = randomPicture({200, 150}, CV_8UC3, 1);
    cv::Mat depth(photo.size(), CV_32FC1);
    for (int x = 0; x < depth.cols; ++x)
        depth.col(x).setTo(x / (depth.cols - 1.0));
    const auto error = [&](const cv::Mat& given) {
        Scene fitted;
        return errorOf([&] {
            fitScene({photo, given}, fitPhoto(photo.size(), 1, {64, 64}), 0.5, fitted);
        });
    };
    EXPECT_EQ(error(depth * 255),
              "depth: has values of 0..255, expected 0..1, 1 = nearest; "
              "normalizeDepth() (in Python: normalize_depth()) makes such depth "
              "of other numbers");
    EXPECT_TRUE(holds(error(depth - 1), "has values of -1..0, expected"));
    EXPECT_TRUE(holds(error(9 - 8 * depth), "has values of 1..9, expected"));
    cv::Mat wild = depth * 1.2 - 0.1; // of an interpolation
    wild.colRange(0, 30).setTo(std::nan(""));
    wild.colRange(30, 60).setTo(1e30);
    EXPECT_EQ(error(wild), "(no error)");
    EXPECT_EQ(error(cv::Mat(depth.size(), CV_32FC1, cv::Scalar(std::nan("")))), "(no error)");
}

TEST(PhotoFit, ContainLeavesBarsAndStretchTakesAll) {
    const PhotoFit wide = fitPhoto({1000, 500}, 0.75, {420, 560}, FitMode::Contain);
    EXPECT_EQ(wide.source, cv::Rect(0, 0, 1000, 500));
    EXPECT_EQ(wide.target, cv::Rect(0, 175, 420, 210));
    const PhotoFit tall = fitPhoto({100, 1000}, 0.75, {420, 560}, FitMode::Contain);
    EXPECT_EQ(tall.target, cv::Rect(182, 0, 56, 560));
    const PhotoFit stretched = fitPhoto({100, 1000}, 0.75, {420, 560}, FitMode::Stretch);
    EXPECT_EQ(stretched.target, cv::Rect(0, 0, 420, 560));
    EXPECT_EQ(stretched.source, cv::Rect(0, 0, 100, 1000));
}

TEST(PhotoFit, FramingChoosesThePartAndNeverShowsABorder) {
    const auto source = [](Framing framing, FitMode mode = FitMode::Cover) {
        return fitPhoto({1000, 300}, 0.75, {420, 560}, mode, framing).source;
    };
    EXPECT_EQ(source({{0.3, 0.5}, 1}), cv::Rect(187, 0, 225, 300));
    EXPECT_EQ(source({{0, 0}, 1}), cv::Rect(0, 0, 225, 300));
    EXPECT_EQ(source({{1, 1}, 1}), cv::Rect(775, 0, 225, 300));
    EXPECT_EQ(source({{0.5, 0.5}, 3}), cv::Rect(462, 100, 75, 100));
    EXPECT_EQ(source({{1, 0}, 3}), cv::Rect(925, 0, 75, 100));
    EXPECT_EQ(source({{0.25, 1}, 2}, FitMode::Stretch), cv::Rect(0, 150, 500, 150));
}

TEST(PhotoFit, ZoomMakesBarsSmallerBeforeItCrops) {
    const auto fit = [](double zoom) {
        return fitPhoto({1000, 500}, 0.75, {420, 560}, FitMode::Contain, {{0.5, 0.5}, zoom});
    };
    EXPECT_EQ(fit(2).source, cv::Rect(250, 0, 500, 500));
    EXPECT_EQ(fit(2).target, cv::Rect(0, 70, 420, 420));
    const PhotoFit full = fit(4); // 1000 x 1333 px of the panel, a quarter of it
    EXPECT_EQ(full.source, cv::Rect(375, 83, 250, 333));
    EXPECT_EQ(full.target, cv::Rect(0, 0, 420, 560));
}

TEST(PhotoFit, ImpossibleFramingsAreNamed) {
    const auto error = [](cv::Size photo, Framing framing) {
        return errorOf([&] { return fitPhoto(photo, 1, {8, 8}, {}, framing); });
    };
    EXPECT_EQ(error({100, 100}, {{0.5, 0.5}, 6}), "(no error)");
    EXPECT_TRUE(holds(error({100, 100}, {{0.5, 0.5}, 7}), "leaves 14 x 14 px"));
    EXPECT_TRUE(holds(error({100, 100}, {{0.5, 0.5}, 1000}), "zoom"));
    EXPECT_EQ(error({1, 1}, {}), "(no error)");
    EXPECT_TRUE(holds(error({1, 1}, {{0.5, 0.5}, 1.5}), "zoom"));
    EXPECT_TRUE(holds(error({100, 100}, {{-0.1, 0.5}, 1}), "centre"));
    for (const double odd : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
        EXPECT_TRUE(holds(error({100, 100}, {{0.5, odd}, 1}), "centre"));
        EXPECT_TRUE(holds(error({100, 100}, {{0.5, 0.5}, odd}), "zoom"));
    }
}

TEST(PhotoFit, TheShapeThatCountsIsThePanelsNotTheTiles) {
    // a square tile of a 16:9 panel: a 16:9 photo is used whole
    EXPECT_EQ(fitPhoto({1600, 900}, 16.0 / 9, {857, 857}).source, cv::Rect(0, 0, 1600, 900));
    const PhotoFit square = fitPhoto({900, 900}, 16.0 / 9, {800, 800}, FitMode::Contain);
    EXPECT_EQ(square.target, cv::Rect(175, 0, 450, 800));
}

TEST(PhotoFit, ExtremeShapesKeepAtLeastOnePixel) {
    for (const cv::Size photo : {cv::Size(1, 1), cv::Size(1, 20000), cv::Size(20000, 1)}) {
        for (FitMode mode : {FitMode::Cover, FitMode::Contain, FitMode::Stretch}) {
            const PhotoFit fit = fitPhoto(photo, 0.75, {7, 5}, mode);
            EXPECT_GT(fit.source.area(), 0);
            EXPECT_GT(fit.target.area(), 0);
            cv::Mat fitted;
            applyFit(cv::Mat(photo, CV_8UC3, cv::Scalar(10, 20, 30)), fit, fitted);
            EXPECT_EQ(fitted.size(), cv::Size(7, 5));
            EXPECT_EQ(fitted.at<cv::Vec3b>(2, 3), cv::Vec3b(10, 20, 30));
        }
    }
    EXPECT_NE(errorOf([] { fitPhoto({0, 5}, 1, {5, 5}); }), "(no error)");
    EXPECT_TRUE(holds(errorOf([] { fitPhoto({5, 5}, std::nan(""), {5, 5}); }), "panel aspect"));
}

TEST(PhotoFit, EqualSizesAreCopiedAndShrinkingAverages) {
    cv::Mat photo(4, 4, CV_8UC3);
    cv::randu(photo, 0, 256);
    cv::Mat fitted;
    applyFit(photo, fitPhoto(photo.size(), 1, photo.size()), fitted);
    EXPECT_TRUE(samePicture(fitted, photo));
    applyFit(photo, fitPhoto(photo.size(), 1, {2, 2}), fitted);
    forPixels({2, 2}, [&](int x, int y) {
        const cv::Scalar mean = cv::mean(photo(cv::Rect(2 * x, 2 * y, 2, 2)));
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(fitted.at<cv::Vec3b>(y, x)[k], mean[k], 0.51); // rounding
    });
}

TEST(PhotoFit, OneAxisMayShrinkWhileTheOtherGrows) {
    // columns alternate black and white; averaged they are grey, however tall the result
    cv::Mat photo(4, 64, CV_8UC3);
    for (int x = 0; x < 64; ++x)
        photo.col(x).setTo(cv::Scalar::all(x % 2 == 0 ? 0 : 254));
    cv::Mat fitted;
    applyFit(photo, fitPhoto(photo.size(), 1, {16, 32}, FitMode::Stretch), fitted);
    EXPECT_TRUE(samePicture(fitted, cv::Mat(32, 16, CV_8UC3, cv::Scalar::all(127)), 1));
}

TEST(PhotoFit, BarsAreBlackAndLieAtTheFocus) {
    const cv::Mat photo(20, 40, CV_8UC3, cv::Scalar::all(200));
    const cv::Mat depth(10, 20, CV_32FC1, cv::Scalar::all(0.9));
    const PhotoFit fit = fitPhoto(photo.size(), 1, {40, 40}, FitMode::Contain);
    cv::Mat fittedPhoto;
    cv::Mat fittedDepth;
    applyFit(photo, fit, fittedPhoto);
    EXPECT_EQ(fittedPhoto.at<cv::Vec3b>(5, 20), cv::Vec3b(0, 0, 0));
    EXPECT_EQ(fittedPhoto.at<cv::Vec3b>(20, 20), cv::Vec3b(200, 200, 200));
    for (const cv::Mat& guide : {fittedPhoto, cv::Mat()}) {
        applyFitToDepth(depth, photo.size(), fit, guide, 0.3, fittedDepth);
        EXPECT_EQ(fittedDepth.at<float>(5, 20), 0.3F);
        EXPECT_EQ(fittedDepth.at<float>(20, 20), 0.9F);
    }
}

TEST(PhotoFit, DepthFollowsTheSameCropAsThePhoto) {
    // depth = column / 99 of the photo; after the crop it must still say which column it came from
    cv::Mat depth(30, 100, CV_32FC1);
    for (int x = 0; x < 100; ++x)
        depth.col(x).setTo(x / 99.0);
    const PhotoFit fit = fitPhoto({100, 30}, 1, {30, 30});
    ASSERT_EQ(fit.source, cv::Rect(35, 0, 30, 30));
    for (const cv::Mat& guide : {cv::Mat(30, 30, CV_8UC3, cv::Scalar::all(0)), cv::Mat()}) {
        cv::Mat fitted;
        applyFitToDepth(depth, {100, 30}, fit, guide, 0.5, fitted);
        EXPECT_FLOAT_EQ(fitted.at<float>(3, 0), 35 / 99.0F);
        EXPECT_FLOAT_EQ(fitted.at<float>(3, 29), 64 / 99.0F);
    }
}

// A photo whose blue is twice the column, and whose depth rises along the columns.
altiro3D::Scene columnsScene() {
    altiro3D::Scene scene{cv::Mat(30, 100, CV_8UC3, cv::Scalar::all(0)),
                          cv::Mat(30, 100, CV_32FC1)};
    for (int x = 0; x < 100; ++x) {
        scene.photo.col(x).setTo(cv::Scalar(2 * x, 0, 0));
        scene.depth.col(x).setTo((x + 0.5) / 100);
    }
    return scene;
}

TEST(PhotoFit, MarginsShowWhatThePhotoHasBesideThePart) {
    const altiro3D::Scene scene = columnsScene();
    const DepthRefineOptions asItIs{DepthFlaws()};
    struct Case {
        double centre;
        cv::Range source, left, right; // columns of the photo
    };
    for (const Case& one :
         {Case{0.5, {35, 65}, {25, 35}, {65, 75}}, Case{0.2, {5, 35}, {0, 5}, {35, 45}},
          Case{1, {70, 100}, {60, 70}, {}}}) {
        const PhotoFit plain =
            fitPhoto(scene.photo.size(), 1, {30, 30}, FitMode::Cover, {{one.centre, 0.5}, 1});
        ASSERT_EQ(cv::Range(plain.source.x, plain.source.br().x), one.source);
        const PhotoFit fit = withMargins(plain, scene.photo.size(), 10);
        EXPECT_EQ(fit.source, plain.source);
        EXPECT_EQ(fit.leftMargin, one.left.size());
        EXPECT_EQ(fit.rightMargin, one.right.size());
        altiro3D::Scene fitted;
        fitScene(scene, fit, 0.5, fitted, asItIs);
        const cv::Range all(one.left.start, one.source.end + one.right.size());
        EXPECT_TRUE(samePicture(fitted.photo, scene.photo.colRange(all)));
        EXPECT_LT(cv::norm(fitted.depth, scene.depth.colRange(all), cv::NORM_INF), 1e-6);
        EXPECT_EQ(fitted.shown, cv::Range(one.left.size(), one.left.size() + 30));
        EXPECT_EQ(shownColumns(fitted), fitted.shown);
        EXPECT_EQ(shownDepth(fitted).cols, 30);
    }
    EXPECT_EQ(shownColumns(scene), cv::Range(0, 100));
}

TEST(PhotoFit, AnErrorLeavesTheSceneAsItWas) {
    altiro3D::Scene scene = columnsScene();
    scene.mixedPixels = 1;
    const altiro3D::Scene before = scene; // shares its memory
    const PhotoFit fit = fitPhoto(scene.photo.size(), 1, {30, 30}, FitMode::Cover);
    DepthRefineOptions wrong;
    wrong.flaws = DepthFlaws();
    wrong.flaws->growthPixels = 9;
    EXPECT_NE(errorOf([&] { refineScene(scene, wrong); }), "(no error)");
    EXPECT_NE(errorOf([&] { fitScene(scene, fit, 0.5, scene, wrong); }), "(no error)");
    EXPECT_NE(errorOf([&] { fitScene(scene, fit, 2, scene); }), "(no error)");
    EXPECT_EQ(scene.photo.data, before.photo.data);
    EXPECT_EQ(scene.depth.data, before.depth.data);
    EXPECT_EQ(scene.mixedPixels, 1);
}

TEST(PhotoFit, MarginsHaveTheScaleOfThePartAndDoNotChangeIt) {
    const altiro3D::Scene scene = columnsScene();
    const DepthRefineOptions asItIs{DepthFlaws()};
    for (const cv::Size size :
         {cv::Size(11, 11), cv::Size(30, 30), cv::Size(71, 71), cv::Size(300, 7)}) {
        const PhotoFit plain = fitPhoto(scene.photo.size(), 1, size);
        const PhotoFit fit = withMargins(plain, scene.photo.size(), 9);
        ASSERT_GE(fit.leftMargin, 8);
        ASSERT_GE(fit.rightMargin, 8);
        altiro3D::Scene fitted;
        fitScene(scene, fit, 0.5, fitted, asItIs);
        cv::Mat shown;
        applyFit(scene.photo, plain, shown);
        EXPECT_TRUE(samePicture(fitted.photo.colRange(fitted.shown), shown));
        const double perPixel = static_cast<double>(plain.source.width) / size.width;
        for (int x = 0; x < fitted.photo.cols; ++x) {
            // the column of the photo at the middle of this px
            const double place = plain.source.x + (x + 0.5 - fit.leftMargin) * perPixel;
            EXPECT_NEAR(fitted.depth.at<float>(3, x), place / 100, 0.5 / 100 + 1e-6) << size << x;
            // a column at most from the place, as margins are made of whole columns
            EXPECT_NEAR(fitted.photo.at<cv::Vec3b>(3, x)[0], 2 * (place - 0.5), 2.5) << size << x;
        }
    }
}

TEST(PhotoFit, BarsAndWholePhotosHaveNoMargins) {
    const auto margins = [](cv::Size photo, FitMode mode, double zoom) {
        const PhotoFit fit =
            withMargins(fitPhoto(photo, 1, {40, 40}, mode, {{0.5, 0.5}, zoom}), photo, 10);
        return cv::Vec2i(fit.leftMargin, fit.rightMargin);
    };
    EXPECT_EQ(margins({90, 90}, FitMode::Cover, 1), cv::Vec2i(0, 0));
    EXPECT_EQ(margins({60, 90}, FitMode::Cover, 1), cv::Vec2i(0, 0));
    EXPECT_EQ(margins({90, 60}, FitMode::Stretch, 1), cv::Vec2i(0, 0));
    EXPECT_EQ(margins({90, 60}, FitMode::Contain, 1), cv::Vec2i(0, 0));
    EXPECT_EQ(margins({60, 90}, FitMode::Contain, 1), cv::Vec2i(0, 0));   // bars at the sides
    EXPECT_EQ(margins({90, 60}, FitMode::Contain, 2), cv::Vec2i(10, 10)); // bars above and below
    EXPECT_EQ(margins({90, 90}, FitMode::Cover, 2), cv::Vec2i(10, 10));
}

TEST(PhotoFit, MarginsThatThePhotoDoesNotHaveAreNamed) {
    const altiro3D::Scene scene = columnsScene();
    const PhotoFit plain = fitPhoto(scene.photo.size(), 1, {30, 30});
    const auto problem = [](const PhotoFit& fit, cv::Size picture, int pixels) {
        return errorOf([&] { return withMargins(fit, picture, pixels); });
    };
    EXPECT_EQ(problem(plain, {100, 30}, 0), "(no error)");
    EXPECT_TRUE(holds(problem(plain, {100, 30}, -1), "margin: is -1 px"));
    EXPECT_TRUE(holds(problem(plain, {50, 30}, 5), "photo: has 50 x 30 px"));
    EXPECT_NE(problem({}, {100, 40}, 5), "(no error)");
    cv::Mat out;
    for (const cv::Vec2i& margins : {cv::Vec2i(36, 0), cv::Vec2i(0, 36), cv::Vec2i(-1, 0)}) {
        PhotoFit fit = plain;
        fit.leftMargin = margins[0];
        fit.rightMargin = margins[1];
        EXPECT_TRUE(
            holds(errorOf([&] { applyFit(scene.photo, fit, out); }), "fit: has margins of "))
            << margins;
    }
}

// A layer of half the photo's size, known in its right half, whose depth rises from left to right.
TEST(PhotoFit, WhatIsHiddenIsFittedAsThePhoto) {
    altiro3D::Scene scene{
        cv::Mat(80, 120, CV_8UC3, cv::Scalar::all(9)),
        cv::Mat(80, 120, CV_32FC1, cv::Scalar(0.5)),
        {cv::Mat(40, 60, CV_8UC3, cv::Scalar(10, 20, 200)), cv::Mat(40, 60, CV_32FC1)}};
    for (int x = 0; x < 60; ++x)
        scene.hidden.depth.col(x).setTo(x < 30 ? std::numeric_limits<float>::quiet_NaN()
                                               : static_cast<float>(x + 0.5) / 60);
    scene.hidden.photo.colRange(0, 30).setTo(cv::Scalar::all(255)); // unknown: must not mix in
    for (const cv::Size size : {cv::Size(30, 30), cv::Size(160, 160), cv::Size(41, 80)}) {
        const PhotoFit fit = fitPhoto(scene.photo.size(), 1, size); // columns 20..99
        ASSERT_EQ(fit.source, cv::Rect(20, 0, 80, 80));
        altiro3D::Scene fitted;
        fitScene(scene, fit, 0.5, fitted);
        ASSERT_EQ(fitted.hidden.photo.size(), size);
        ASSERT_EQ(fitted.hidden.depth.size(), size);
        for (int x = 0; x < size.width; ++x) {
            const double place = 20 + 80 * (x + 0.5) / size.width; // column of the photo
            const float depth = fitted.hidden.depth.at<float>(size.height / 2, x);
            const double px = 80.0 / size.width;
            if (place < 60 - 2 - px) {
                EXPECT_TRUE(std::isnan(depth)) << x << ' ' << size;
            } else if (place > 60 + 2 + px) {
                EXPECT_NEAR(depth, place / 120, 0.002) << x << ' ' << size;
                EXPECT_EQ(fitted.hidden.photo.at<cv::Vec3b>(size.height / 2, x),
                          cv::Vec3b(10, 20, 200));
            }
        }
    }
    scene.hidden.depth = scene.hidden.depth.colRange(0, 59).clone();
    altiro3D::Scene fitted;
    EXPECT_TRUE(holds(errorOf([&] {
                          fitScene(scene, fitPhoto(scene.photo.size(), 1, {30, 30}), 0.5, fitted);
                      }),
                      "hidden depth: has 59 x 40 px, expected 60 x 40"));
}

// Depth of stereo pairs: near things may look too large, but their edges stay. Soft ones become
// hard.
TEST(PhotoFit, MatchedDepthIsNeitherShrunkNorShifted) {
    altiro3D::Scene scene{cv::Mat(120, 160, CV_8UC3, cv::Scalar(90, 130, 60)),
                          cv::Mat(120, 160, CV_32FC1, cv::Scalar(0.2))};
    for (const cv::Point at : {cv::Point(30, 30), cv::Point(110, 40), cv::Point(70, 85)}) {
        cv::circle(scene.photo, at, 18, {200, 40, 20}, cv::FILLED);
        cv::circle(scene.depth, at, 21, cv::Scalar(0.8), cv::FILLED);
    }
    const PhotoFit fit = fitPhoto(scene.photo.size(), 4.0 / 3, scene.photo.size());
    altiro3D::Scene fitted;
    fitScene(scene, fit, 0.5, fitted);
    EXPECT_LT(cv::mean(fitted.depth)[0], cv::mean(scene.depth)[0] - 0.02);
    altiro3D::Scene matched = scene;
    matched.edges = altiro3D::DepthEdges::Matched;
    fitScene(matched, fit, 0.5, fitted);
    EXPECT_TRUE(samePicture(fitted.depth, scene.depth));
    DepthRefineOptions known; // what is known is used
    known.flaws = DepthFlaws();
    known.flaws->growthPixels = 3;
    fitScene(matched, fit, 0.5, fitted, known);
    EXPECT_LT(cv::mean(fitted.depth)[0], cv::mean(scene.depth)[0] - 0.02);
    cv::Mat hard; // fits the photo
    altiro3D::refineDepth(scene.photo, scene.depth, hard);
    matched.depth = cv::Mat();
    cv::GaussianBlur(hard, matched.depth, {}, 2);
    fitScene(matched, fit, 0.5, fitted);
    const auto onTheWrongSide = [&](const cv::Mat& depth) {
        return cv::countNonZero(cv::abs(depth - hard) > 0.1);
    };
    EXPECT_LT(onTheWrongSide(fitted.depth), onTheWrongSide(matched.depth) / 10);
}

// Three discs, by the formula of the circle.
Scene discs(cv::Size size) {
    const double unit = size.width / 160.0;
    Scene scene{cv::Mat(size, CV_8UC3, cv::Scalar(90, 130, 60)),
                cv::Mat(size, CV_32FC1, cv::Scalar(0.2))};
    for (const cv::Point2d at : {cv::Point2d(34, 30), cv::Point2d(110, 44), cv::Point2d(70, 88)}) {
        forPixels(size, [&](int x, int y) {
            if (std::hypot(x + 0.5 - at.x * unit, y + 0.5 - at.y * unit) >= 20 * unit) return;
            scene.photo.at<cv::Vec3b>(y, x) = {200, 40, 20};
            scene.depth.at<float>(y, x) = 0.8F;
        });
    }
    return scene;
}

TEST(PhotoFit, DepthOfAnEnlargedPhotoHasHardStepsAtTheEdgesOfThePhoto) {
    Scene scene = discs({160, 120});
    cv::GaussianBlur(scene.depth.clone(), scene.depth, {}, 2);
    for (const int times : {2, 3}) {
        const cv::Size size = scene.photo.size() * times;
        const cv::Mat truth = discs(size).depth;
        Scene fitted;
        const PhotoFit fit = fitPhoto(scene.photo.size(), 4.0 / 3, size);
        const DepthFlaws flaws = fitScene(scene, fit, 0.5, fitted);
        EXPECT_NEAR(flaws.softnessPixels, 4, 1) << times; // of the photo's own px
        const cv::Mat wrong = cv::abs(fitted.depth - truth);
        const double contours = 3 * 2 * CV_PI * 20 * times; // px along the three contours
        // half a px of the photo; one as soft as the photo's px would have twice as many
        EXPECT_LT(cv::countNonZero(wrong > 0.1), contours * times / 2) << times;
        EXPECT_LT(cv::countNonZero((wrong > 0.1) & (wrong < 0.5)), contours * times / 20) << times;
    }
}

TEST(PhotoFit, RefinementOfASceneKeepsItsMixedPixels) {
    const cv::Size size(60, 40);
    cv::Mat depth(size, CV_32FC1, cv::Scalar(0.2));
    depth(cv::Rect(20, 10, 20, 20)).setTo(0.8);
    const cv::Mat given = depth.clone();
    Scene scene{randomPhoto(size), depth};
    DepthRefineOptions options{DepthFlaws()};
    options.flaws->mixedPixels = 2;
    EXPECT_EQ(refineScene(scene, options).mixedPixels, 2);
    EXPECT_EQ(scene.mixedPixels, 2);
    EXPECT_TRUE(samePicture(depth, given));         // others may share it
    EXPECT_EQ(scene.depth.at<float>(20, 18), 0.8F); // the board is larger
    EXPECT_EQ(scene.depth.at<float>(20, 17), 0.2F);

    scene.depth = given;
    refineScene(scene, options, {30, 0, 30, 40}); // the left half is a bar
    EXPECT_EQ(scene.depth.at<float>(20, 18), 0.2F);
    EXPECT_EQ(scene.depth.at<float>(20, 41), 0.8F);
    EXPECT_TRUE(holds(errorOf([&] { refineScene(scene, options, {31, 0, 30, 40}); }), "part: "));

    scene.depth = given;
    EXPECT_FALSE(refineScene(scene, {DepthFlaws()}).any()); // as it is
    EXPECT_EQ(scene.mixedPixels, 0);
    EXPECT_EQ(scene.depth.data, given.data);

    Scene fitted;
    fitScene({scene.photo, given}, fitPhoto(size, 1, {40, 40}), 0.5, fitted, options);
    EXPECT_EQ(fitted.mixedPixels, 2);
    fitScene({scene.photo, given}, fitPhoto(size, 1, {40, 40}), 0.5, fitted, {DepthFlaws()});
    EXPECT_EQ(fitted.mixedPixels, 0);
}

TEST(PhotoFit, WrongInputsAreNamed) {
    const PhotoFit fit = fitPhoto({40, 40}, 1, {20, 20});
    cv::Mat out;
    const auto problem = [&](const cv::Mat& photo, const PhotoFit& of) {
        return errorOf([&] { applyFit(photo, of, out); });
    };
    const cv::Mat photo(40, 40, CV_8UC3, cv::Scalar::all(0));
    const cv::Mat depth(10, 10, CV_32FC1, cv::Scalar::all(0));
    const auto problemOfDepth = [&](cv::Size size, const PhotoFit& of, double focus) {
        const cv::Mat fittedPhoto(20, 20, CV_8UC3, cv::Scalar::all(0));
        return errorOf([&] { applyFitToDepth(depth, size, of, fittedPhoto, focus, out); });
    };
    EXPECT_TRUE(holds(problem(cv::Mat(30, 30, CV_8UC3), fit), "photo: has 30"));
    EXPECT_TRUE(holds(problem(cv::Mat(40, 40, CV_8UC1), fit), "CV_8UC1"));
    const cv::Rect kOutside[] = {
        {5, 0, 20, 20}, {0, -1, 20, 20}, {0, 0, 0, 20}, {INT_MAX, 0, INT_MAX, 1}};
    for (const cv::Rect& target : kOutside) {
        PhotoFit made = fit;
        made.target = target;
        EXPECT_TRUE(holds(problem(photo, made), "fit: puts "));
        EXPECT_TRUE(holds(problemOfDepth(photo.size(), made, 0.5),
                          "expected a place inside of its result of 20 x 20 px"));
    }
    for (const double focus : {-0.1, 1.1, std::nan("")})
        EXPECT_TRUE(holds(problemOfDepth(photo.size(), fit, focus), "focus: is "));
    EXPECT_EQ(problemOfDepth({0, 40}, fit, 0.5),
              "photo: has 0 x 40 px, expected the size that the fit was made for");
}

} // namespace
} // namespace altiro3D::test
