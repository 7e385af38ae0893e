#include "altiro3D/depth2quilt.hpp"

#include "support/compare.hpp"
#include "support/files.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <set>

namespace altiro3D::test {
namespace {

TEST(StereoScene, UnknownDisparityTakesTheSmallerNeighbourInItsRow) {
    const float nan = std::nanf("");
    const float inf = std::numeric_limits<float>::infinity();
    const cv::Mat raw = (cv::Mat_<float>(4, 6) << 0, 0, 8, nan, 4, 0, //
                         2, inf, inf, 6, -1, 2,                       //
                         0, 0, 0, 0, 0, 0,                            //
                         8, 8, 8, 8, 8, 8);
    const cv::Mat photo(4, 6, CV_8UC3, cv::Scalar::all(9));
    const StereoScene scene = makeStereoScene("s", photo, raw, 2, photo);
    EXPECT_EQ(scene.largestDisparity, 4);
    EXPECT_EQ(scene.band(), 6);
    const cv::Mat expected = (cv::Mat_<float>(4, 6) << 4, 4, 4, 2, 2, 2, //
                              1, 1, 1, 3, 1, 1,                          //
                              0, 0, 0, 0, 0, 0,                          //
                              4, 4, 4, 4, 4, 4) /
                             4;
    EXPECT_TRUE(samePicture(scene.depth, expected));
}

TEST(StereoScene, ViewAtTheRightIsMovedByTheDisparity) {
    cv::Mat photo(3, 40, CV_8UC3, cv::Scalar::all(0));
    photo.col(20).setTo(cv::Scalar::all(250));
    const cv::Mat raw(3, 40, CV_32FC1, cv::Scalar::all(10)); // 5 px everywhere
    const StereoScene scene = makeStereoScene("s", photo, raw, 2, photo);
    for (const NamedViewOptions& method : defaultSettings()) {
        cv::Mat view;
        Depth2Quilt({1, 1, photo.size(), 1}, scene.options(method.options))
            .renderView({photo, scene.depth}, 1, view);
        EXPECT_EQ(view.at<cv::Vec3b>(1, 15)[1], 250) << method.name;
        EXPECT_EQ(view.at<cv::Vec3b>(1, 20)[1], 0) << method.name;
    }
}

TEST(StereoScene, WrongPicturesAreNamed) {
    const cv::Mat photo(4, 6, CV_8UC3);
    const cv::Mat disparity(4, 6, CV_32FC1, cv::Scalar::all(1));
    EXPECT_TRUE(holds(errorOf([&] { makeStereoScene("s", photo, disparity, 0, photo); }),
                      "disparity scale"));
    EXPECT_TRUE(holds(
        errorOf([&] { makeStereoScene("cones", photo, disparity, 1, cv::Mat(4, 5, CV_8UC3)); }),
        "cones: truth: has 5 x 4 px, expected the photo's 6 x 4 px"));
}

TEST(Trade, InsideLeavesTheBandsOut) {
    cv::Mat truth(30, 60, CV_8UC3, cv::Scalar::all(100));
    cv::Mat view = truth.clone();
    view.colRange(0, 10).setTo(cv::Scalar::all(0));
    view.colRange(50, 60).setTo(cv::Scalar::all(0));
    const ViewAccuracy accuracy = compareViews(view, truth, 10);
    EXPECT_TRUE(std::isinf(accuracy.psnrInside));
    EXPECT_NEAR(accuracy.ssimInside, 1, 1e-12);
    EXPECT_NEAR(accuracy.psnrWhole, 10 * std::log10(255.0 * 255 / (100.0 * 100 / 3)), 1e-9);
    const ViewAccuracy narrow = compareViews(view, truth, 30); // nothing would be left: whole
    EXPECT_EQ(narrow.psnrInside, accuracy.psnrWhole);
    EXPECT_EQ(narrow.ssimInside, accuracy.ssimWhole);
}

TEST(Trade, SettingsHaveNamesOfTheirOwnAndKeepStrengthAndFocus) {
    ViewOptions base;
    base.strengthPercent = 7;
    base.focus = 0.3;
    std::set<std::string> names;
    for (const NamedViewOptions& setting : tradeSettings(base)) {
        EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
        EXPECT_EQ(setting.options.strengthPercent, 7);
        EXPECT_EQ(setting.options.focus, 0.3);
        EXPECT_NO_THROW(validate(setting.options));
    }
}

TEST(Trade, MeasuredTimesArePositiveAndBadCountsAreRefused) {
    const cv::Mat photo(20, 30, CV_8UC3, cv::Scalar::all(50));
    const cv::Mat depth(20, 30, CV_32FC1, cv::Scalar::all(0.2));
    // preparation is done for one view as well, and is a part of the whole
    for (const int views : {5, 1}) {
        const ViewCost cost = measureViews({photo, depth}, {}, views, 2);
        EXPECT_GT(cost.preparationMilliseconds, 0);
        EXPECT_LE(cost.preparationMilliseconds, 1.001 * views * cost.millisecondsPerView);
    }
    EXPECT_TRUE(holds(errorOf([&] { measureViews({photo, depth}, {}, 0, 1); }), "views: is 0"));
    EXPECT_TRUE(holds(errorOf([&] {
                          measureViews({photo, depth}, {}, 1, 0);
                      }),
                      "repetitions: is 0"));
}

} // namespace
} // namespace altiro3D::test
