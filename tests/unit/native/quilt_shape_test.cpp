#include "native/quilt_shape.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/quilt2native.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

const QuiltLayout kLayout{3, 2, {20, 10}, 6};

TEST(QuiltShape, ViewsAreFittedOneByOneInTheShapeTheyShow) {
    QuiltLayout layout;
    layout.columns = 3;
    layout.rows = 2;
    layout.tileSize = {20, 24};
    layout.viewCount = 6;
    // Views of 20 x 24 px that show something twice as wide as high, for a square panel: of what
    // they show the middle half fills it.
    cv::Mat quilt(layout.size(), CV_8UC3, cv::Scalar::all(0));
    for (int i = 0; i < 6; ++i) {
        cv::Mat view = quilt(layout.tile(i));
        view.colRange(5, 15).setTo(cv::Scalar::all(40 * i + 15)); // the middle half of its columns
    }
    cv::Mat fitted;
    applyFitToViews(quilt, layout, 2, 1, FitMode::Cover, fitted);
    ASSERT_EQ(fitted.size(), layout.size());
    for (int i = 0; i < 6; ++i) {
        const cv::Mat inner = fitted(layout.tile(i)).colRange(4, 16); // cubic next to the cut
        EXPECT_TRUE(
            samePicture(inner, cv::Mat(inner.size(), CV_8UC3, cv::Scalar::all(40 * i + 15))))
            << i;
    }
    // bars above and below: a view fills half of the square's height
    applyFitToViews(quilt, layout, 2, 1, FitMode::Contain, fitted);
    for (int i = 0; i < 6; ++i) {
        const cv::Mat view = fitted(layout.tile(i));
        EXPECT_EQ(cv::norm(view.rowRange(0, 6), cv::NORM_INF), 0);
        EXPECT_EQ(cv::norm(view.rowRange(18, 24), cv::NORM_INF), 0);
        EXPECT_EQ(view.at<cv::Vec3b>(12, 10), cv::Vec3b::all(static_cast<uchar>(40 * i + 15)));
    }
    EXPECT_TRUE(holds(errorOf([&] {
                          applyFitToViews(quilt.colRange(0, 59), layout, 2, 1, FitMode::Cover,
                                          fitted);
                      }),
                      "quilt: has 59 x 48 px, expected 60 x 48"));
    EXPECT_TRUE(holds(
        errorOf([&] { applyFitToViews(quilt, layout, std::nan(""), 1, FitMode::Cover, fitted); }),
        "viewAspect: is nan"));
}

TEST(QuiltShape, BarsKeepAShapeThatTheNameTells) {
    const Display display = displayOf(stripePanel(150, 100)); // 1.5
    const cv::Mat quilt = randomPhoto(kLayout.size());
    const QuiltShape stated("a_qs3x2a2.png", kLayout, display);
    EXPECT_TRUE(stated.fitsUnasked());
    EXPECT_EQ(stated.shownAspect(), 2);
    cv::Mat bars;
    applyFitToViews(quilt, kLayout, 2, 1.5, FitMode::Contain, bars);
    EXPECT_TRUE(samePicture(stated.apply(quilt), bars));

    for (const char* name : {"a.png", "a_qs3x2a1.5.png", "a_qs3x2.png"}) {
        const QuiltShape own(name, kLayout, display);
        EXPECT_FALSE(own.fitsUnasked()) << name;
        EXPECT_EQ(own.stretchesUnasked(), std::string(name) != "a_qs3x2a1.5.png") << name; // 2 : 1
        EXPECT_EQ(own.shownAspect(), 1.5) << name;
        EXPECT_TRUE(samePicture(own.apply(quilt), quilt)) << name;
    }
}

TEST(QuiltShape, AGivenFitIsUsed) {
    const Display display = displayOf(stripePanel(150, 100));
    const cv::Mat quilt = randomPhoto(kLayout.size());
    for (const FitMode fit : {FitMode::Cover, FitMode::Contain, FitMode::Stretch}) {
        const QuiltShape shape("a_qs3x2a2.png", kLayout, display, fit);
        EXPECT_FALSE(shape.fitsUnasked());
        EXPECT_FALSE(QuiltShape("a.png", kLayout, display, fit).stretchesUnasked());
        cv::Mat expected;
        applyFitToViews(quilt, kLayout, 2, 1.5, fit, expected);
        EXPECT_TRUE(samePicture(shape.apply(quilt), fit == FitMode::Stretch ? quilt : expected));
    }
}

TEST(QuiltShape, ViewsGetWholePixels) {
    const QuiltShape shape("a.png", kLayout, displayOf(stripePanel(150, 100)));
    const cv::Mat quilt = randomPhoto({61, 20});
    EXPECT_TRUE(samePicture(shape.apply(quilt), fitQuilt(quilt, kLayout)));
    EXPECT_THROW(static_cast<void>(shape.apply(randomPhoto({90, 20}))), Error);
}

TEST(QuiltShape, ShapesWithinFivePercentAreTheSame) {
    EXPECT_TRUE(haveSameShape(0.75, 0.76));
    EXPECT_FALSE(haveSameShape(0.75, 0.8));
}

} // namespace
} // namespace altiro3D::test
