#include "altiro3D/quilt2native.hpp"

#include "altiro3D/error.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/random_pictures.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

const QuiltLayout kLayout{3, 2, {20, 10}, 6};

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
    EXPECT_THROW(shape.apply(randomPhoto({90, 20})), Error);
}

TEST(QuiltShape, ShapesWithinFivePercentAreTheSame) {
    EXPECT_TRUE(haveSameShape(0.75, 0.76));
    EXPECT_FALSE(haveSameShape(0.75, 0.8));
}

} // namespace
} // namespace altiro3D::test
