#include "altiro3D/stereo_views.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/pixels.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <utility>

namespace altiro3D::test {
namespace {

cv::Mat joined(const cv::Mat& left, const cv::Mat& right, EyesPicture picture) {
    cv::Mat result;
    joinEyes(left, right, picture, result);
    return result;
}

TEST(JoinEyes, WholePicturesAreTakenApartAgain) {
    const cv::Mat left = randomPhoto({31, 20}, 1);
    const cv::Mat right = randomPhoto({31, 20}, 2);
    const std::pair<EyesPicture, StereoLayout> all[] = {
        {EyesPicture::SideBySide, StereoLayout::LeftRight},
        {EyesPicture::Crossed, StereoLayout::RightLeft},
        {EyesPicture::TopBottom, StereoLayout::TopBottom}};
    for (const auto& [picture, layout] : all) {
        const cv::Mat both = joined(left, right, picture);
        EXPECT_EQ(both.size(), eyesSize(left.size(), picture));
        const StereoPair apart = splitStereoPair(both, layout, StereoHalves::Full);
        EXPECT_TRUE(samePicture(apart.left, left));
        EXPECT_TRUE(samePicture(apart.right, right));
    }
}

TEST(JoinEyes, HalfPicturesAreMeansOfTwoPixels) {
    const cv::Mat left = randomPhoto({30, 20}, 1);
    const cv::Mat right = randomPhoto({30, 20}, 2);
    const cv::Mat beside = joined(left, right, EyesPicture::SideBySideHalf);
    const cv::Mat stacked = joined(left, right, EyesPicture::TopBottomHalf);
    ASSERT_EQ(beside.size(), left.size());
    ASSERT_EQ(stacked.size(), left.size());
    const auto isMean = [](const cv::Vec3b& mean, const cv::Mat& eye, cv::Point a, cv::Point b) {
        const auto sum = cv::Vec3i(eye.at<cv::Vec3b>(a)) + cv::Vec3i(eye.at<cv::Vec3b>(b));
        return cv::norm(2 * cv::Vec3i(mean) - sum, cv::NORM_INF) <= 1; // rounded
    };
    forPixels(left.size(), [&](int x, int y) {
        const cv::Point wide(x % 15 * 2, y);
        const cv::Point high(x, y % 10 * 2);
        EXPECT_TRUE(isMean(beside.at<cv::Vec3b>(y, x), x < 15 ? left : right, wide,
                           wide + cv::Point(1, 0)));
        EXPECT_TRUE(isMean(stacked.at<cv::Vec3b>(y, x), y < 10 ? left : right, high,
                           high + cv::Point(0, 1)));
    });
    EXPECT_EQ(eyesSize({31, 21}, EyesPicture::SideBySideHalf), cv::Size(32, 21));
    EXPECT_EQ(eyesSize({31, 21}, EyesPicture::TopBottomHalf), cv::Size(31, 22));
    EXPECT_EQ(joined(randomPhoto({1, 1}), randomPhoto({1, 1}), EyesPicture::SideBySideHalf).size(),
              cv::Size(2, 1));
}

TEST(JoinEyes, InterlacedPicturesBeginWithTheLeftEye) {
    struct Kind {
        EyesPicture picture;
        int across; // 1: the eyes change from px to px
        int down;
    };
    for (const cv::Size size : {cv::Size(9, 5), cv::Size(1366, 768), cv::Size(2, 1)}) {
        const cv::Mat left = randomPhoto(size, 1);
        const cv::Mat right = randomPhoto(size, 2);
        for (const Kind& kind : {Kind{EyesPicture::Rows, 0, 1}, Kind{EyesPicture::Columns, 1, 0},
                                 Kind{EyesPicture::Checkerboard, 1, 1}}) {
            const cv::Mat expected = pictureOf<cv::Vec3b>(size, [&](int x, int y) {
                const bool isLeft = (kind.across * x + kind.down * y) % 2 == 0;
                return (isLeft ? left : right).at<cv::Vec3b>(y, x);
            });
            EXPECT_TRUE(samePicture(joined(left, right, kind.picture), expected)) << size;
        }
    }
}

// Dubois in double precision, with the curve of IEC 61966-2-1.
TEST(JoinEyes, AnaglyphsAreThoseOfDubois) {
    const cv::Matx33d ofLeft(.437, .449, .164, -.062, -.062, -.024, -.048, -.050, -.017);
    const cv::Matx33d ofRight(-.011, -.032, -.007, .377, .761, .009, -.026, -.093, 1.234);
    const cv::Mat left = randomPhoto({64, 48}, 1);
    const cv::Mat right = randomPhoto({64, 48}, 2);
    const cv::Mat result = joined(left, right, EyesPicture::Anaglyph);
    const auto rgb = [](const cv::Vec3b& bgr) {
        return cv::Vec3d(referenceLight(bgr[2] / 255.0), referenceLight(bgr[1] / 255.0),
                         referenceLight(bgr[0] / 255.0));
    };
    forPixels(left.size(), [&](int x, int y) {
        const cv::Vec3d l = ofLeft * rgb(left.at<cv::Vec3b>(y, x));
        const cv::Vec3d r = ofRight * rgb(right.at<cv::Vec3b>(y, x));
        for (int c = 0; c < 3; ++c) {
            const double light = std::clamp(l[c], 0.0, 1.0) + std::clamp(r[c], 0.0, 1.0);
            const double code = 255 * srgbCode(std::min(light, 1.0));
            ASSERT_NEAR(result.at<cv::Vec3b>(y, x)[2 - c], code, 1) << x << ' ' << y;
        }
    });
}

TEST(JoinEyes, SimpleAnaglyphsTakeLumaForTheLeftEye) {
    const cv::Mat left(2, 2, CV_8UC3, cv::Scalar(10, 200, 100));
    const cv::Mat right(2, 2, CV_8UC3, cv::Scalar(30, 40, 250));
    const double lumaLeft = .299 * 100 + .587 * 200 + .114 * 10;
    const double lumaRight = .299 * 250 + .587 * 40 + .114 * 30;
    const auto half = joined(left, right, EyesPicture::AnaglyphHalf).at<cv::Vec3b>(1, 1);
    EXPECT_EQ(half[0], 30);
    EXPECT_EQ(half[1], 40);
    EXPECT_NEAR(half[2], lumaLeft, .5);
    const auto grey = joined(left, right, EyesPicture::AnaglyphGrey).at<cv::Vec3b>(1, 1);
    EXPECT_NEAR(grey[0], lumaRight, .5);
    EXPECT_EQ(grey[0], grey[1]);
    EXPECT_NEAR(grey[2], lumaLeft, .5);
}

TEST(JoinEyes, WhatIsWrongIsNamed) {
    const cv::Mat eye = randomPhoto({8, 8});
    cv::Mat result;
    const auto error = [&](const cv::Mat& left, const cv::Mat& right, cv::Mat& to) {
        return errorOf([&] { joinEyes(left, right, EyesPicture::SideBySide, to); });
    };
    EXPECT_TRUE(holds(error({}, eye, result), "left: is empty"));
    EXPECT_TRUE(holds(error(eye, cv::Mat(8, 8, CV_8UC1), result), "right: is 8 x 8"));
    EXPECT_TRUE(holds(error(eye, randomPhoto({8, 7}), result), "right: has 8 x 7 px"));
    cv::Mat same = eye;
    EXPECT_TRUE(holds(error(eye, randomPhoto({8, 8}), same), "joined: shares"));
}

TEST(EyesNames, TagsThatPlayersKnowAreFound) {
    const std::pair<const char*, EyesPicture> known[] = {
        {"a_LRF.png", EyesPicture::SideBySide},
        {"a_Full_SBS.mp4", EyesPicture::SideBySide},
        {"a_sbs.jpg", EyesPicture::SideBySide},
        {"a_LR.png", EyesPicture::SideBySideHalf},
        {"a_HSBS.png", EyesPicture::SideBySideHalf},
        {"a_rlf.png", EyesPicture::Crossed},
        {"a_TBF.mkv", EyesPicture::TopBottom},
        {"a_TB.mkv", EyesPicture::TopBottomHalf},
        {"a_redcyan.png", EyesPicture::Anaglyph},
        {"a-Anaglyph.png", EyesPicture::AnaglyphGrey},
        {"a.png", EyesPicture::Rows}};
    for (const auto& [name, picture] : known)
        EXPECT_TRUE(hasEyesTag(name, picture)) << name;
    const std::pair<const char*, EyesPicture> unknown[] = {
        {"a.png", EyesPicture::SideBySide},      {"LRF.png", EyesPicture::SideBySide},
        {"a_HSBS.png", EyesPicture::SideBySide}, {"a_LRF.png", EyesPicture::SideBySideHalf},
        {"a_LRF.png", EyesPicture::Crossed},     {"a_TBF.png", EyesPicture::TopBottomHalf},
        {"a_RGBD.png", EyesPicture::SideBySide}, {"a.png", EyesPicture::Anaglyph}};
    for (const auto& [name, picture] : unknown)
        EXPECT_FALSE(hasEyesTag(name, picture)) << name;
    // our own tags are known
    for (int i = 0; i <= static_cast<int>(EyesPicture::Checkerboard); ++i) {
        const auto picture = static_cast<EyesPicture>(i);
        EXPECT_TRUE(hasEyesTag(std::string("a_") + nameOf(picture).tag + ".png", picture)) << i;
    }
}

// A near square in front of a far wall.
Scene squareScene() {
    Scene scene{randomPhoto({200, 60}), cv::Mat(60, 200, CV_32FC1, cv::Scalar(0))};
    scene.depth(cv::Rect(80, 20, 40, 20)) = 1;
    return scene;
}

TEST(RenderEyes, TheEyesAreTheOutermostOfTwoViews) {
    ViewOptions views;
    views.strengthPercent = 10; // 20 px
    for (const ViewMethod method : {ViewMethod::Fast, ViewMethod::Layered, ViewMethod::Real}) {
        views.method = method;
        const Scene scene = squareScene();
        const StereoPair eyes = renderEyes(scene, views);
        const Depth2Quilt maker({1, 2, {200, 60}, 2}, views);
        cv::Mat quilt;
        maker.render(scene, quilt);
        EXPECT_TRUE(samePicture(eyes.left, quilt(maker.layout().tile(0))));
        EXPECT_TRUE(samePicture(eyes.right, quilt(maker.layout().tile(1))));
    }
}

TEST(RenderEyes, NearThingsAreFurtherRightForTheLeftEye) {
    ViewOptions views;
    views.strengthPercent = 10; // 20 px
    const cv::Rect thing(80, 20, 40, 20);
    for (const EyesFrom from : {EyesFrom::Both, EyesFrom::KeepLeft}) {
        for (const double focus : {0.0, 0.5, 1.0}) {
            views.focus = focus;
            const Scene scene = squareScene();
            const StereoPair eyes = renderEyes(scene, views, from);
            // displacement -p (d - f) S / 2 at d = 1
            const int left = from == EyesFrom::KeepLeft ? 0 : cvRound(10 * (1 - focus));
            const int right = -cvRound((from == EyesFrom::KeepLeft ? 20 : 10) * (1 - focus));
            const cv::Rect inner(thing.x + 4, thing.y, thing.width - 8, thing.height);
            EXPECT_TRUE(samePicture(eyes.left(inner + cv::Point(left, 0)), scene.photo(inner)));
            EXPECT_TRUE(samePicture(eyes.right(inner + cv::Point(right, 0)), scene.photo(inner)));
            if (from == EyesFrom::KeepLeft) {
                EXPECT_TRUE(samePicture(eyes.left, scene.photo));
            }
        }
    }
}

TEST(RenderEyes, MarginsAreNotShown) {
    ViewOptions views;
    views.strengthPercent = 10;
    Scene scene = squareScene();
    scene.shown = cv::Range(20, 180);
    for (const EyesFrom from : {EyesFrom::Both, EyesFrom::KeepLeft}) {
        const StereoPair eyes = renderEyes(scene, views, from);
        EXPECT_EQ(eyes.left.size(), cv::Size(160, 60));
        EXPECT_EQ(eyes.right.size(), cv::Size(160, 60));
    }
    EXPECT_TRUE(samePicture(renderEyes(scene, views, EyesFrom::KeepLeft).left,
                            scene.photo.colRange(20, 180)));
}

TEST(RenderEyes, AreThePhotoWithoutDepthOrStrength) {
    Scene scene = squareScene();
    ViewOptions views;
    views.strengthPercent = 0;
    for (const EyesFrom from : {EyesFrom::Both, EyesFrom::KeepLeft}) {
        const StereoPair eyes = renderEyes(scene, views, from);
        EXPECT_TRUE(samePicture(eyes.left, scene.photo));
        EXPECT_TRUE(samePicture(eyes.right, scene.photo));
    }
}

} // namespace
} // namespace altiro3D::test
