#include "scene/framing.hpp"

#include "altiro3D/placement.hpp"
#include "altiro3D/sway.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

const cv::Size kPhoto(600, 400);

// A border of these widths around a photo, with the noise of a scanner.
cv::Mat scanned(const cv::Mat& photo, const cv::Rect& inside, int level) {
    cv::Mat result(photo.size(), CV_8UC3);
    cv::theRNG().state = 7;
    cv::randn(result, cv::Scalar::all(level), cv::Scalar::all(3));
    photo(inside).copyTo(result(inside));
    return result;
}

TEST(ScanBorder, IsFoundOfAnyColourAndWidth) {
    const cv::Mat photo = scenery(kPhoto, 3);
    for (const int level : {0, 20, 99, 235, 255}) {
        // left, right, top and bottom; at most 3 % are 18 columns and 12 rows
        for (const cv::Vec4i& widths :
             {cv::Vec4i(4, 3, 2, 5), cv::Vec4i(16, 0, 0, 1), cv::Vec4i(0, 0, 10, 0)}) {
            const cv::Rect inside(widths[0], widths[2], kPhoto.width - widths[0] - widths[1],
                                  kPhoto.height - widths[2] - widths[3]);
            const cv::Rect found = withoutScanBorder(scanned(photo, inside, level));
            EXPECT_EQ(found & inside, found) << level << ' ' << found;
            // one line more at most, where a scan has a soft edge
            EXPECT_EQ(found.x > 0, widths[0] > 0) << level << ' ' << found;
            EXPECT_EQ(found.y > 0, widths[2] > 0) << level << ' ' << found;
            EXPECT_LE(inside.width - found.width, 2) << level << ' ' << found;
            EXPECT_LE(inside.height - found.height, 2) << level << ' ' << found;
        }
    }
}

TEST(ScanBorder, APhotoIsNotCut) {
    const cv::Rect all({}, kPhoto);
    EXPECT_EQ(withoutScanBorder(randomPhoto(kPhoto)), all);
    EXPECT_EQ(withoutScanBorder(cv::Mat(kPhoto, CV_8UC3, cv::Scalar::all(8))), all);
    EXPECT_EQ(withoutScanBorder(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(8))), cv::Rect(0, 0, 1, 1));
    // bars that are wider than what may be cut
    const cv::Rect middle(19, 13, kPhoto.width - 38, kPhoto.height - 26);
    EXPECT_EQ(withoutScanBorder(scanned(randomPhoto(kPhoto), middle, 0)), all);
    // a night sky with stars that fades into the light of a town behind a roof
    cv::Mat night(kPhoto, CV_8UC3);
    cv::theRNG().state = 11;
    for (int y = 0; y < night.rows; ++y) {
        cv::randn(night.row(y), cv::Scalar::all(6 + y / 20.0), cv::Scalar::all(2));
        night.at<cv::Vec3b>(y, (y * 131) % night.cols) = {255, 255, 255};
    }
    night(cv::Rect(0, 300, 600, 100)) = cv::Scalar::all(0);
    EXPECT_EQ(withoutScanBorder(night), all);
    // its horizon lies near the rim: soft from row to row
    for (const int rows : {4, 8, 11}) {
        cv::Mat dusk(kPhoto, CV_8UC3);
        for (int y = 0; y < dusk.rows; ++y) {
            const double light = 200 / (1 + std::exp((rows - y) / 3.0));
            cv::randn(dusk.row(y), cv::Scalar::all(light), cv::Scalar::all(2));
        }
        EXPECT_EQ(withoutScanBorder(dusk), all) << rows;
    }
}

// A photo with columns at its rims that only views beside the photo would show, and its depth.
altiro3D::Scene framedScene(cv::Size size) {
    altiro3D::Scene scene{cv::Mat(size, CV_8UC3, cv::Scalar(0, 90, 0)), cv::Mat(size, CV_32FC1)};
    for (int y = 0; y < size.height; ++y) // a floor in front of a wall, nearer at the left
        for (int x = 0; x < size.width; ++x)
            scene.depth.at<float>(y, x) =
                static_cast<float>(std::max(0.1, 1.0 * y / size.height - 0.4 * x / size.width));
    for (const int x : {0, size.width - 1})
        scene.photo.col(x).setTo(cv::Scalar(0, 0, 255));
    return scene;
}

// Largest share of the width by which a view shows what lies beyond the photo, by (3.2).
double beyond(const altiro3D::Scene& scene, const Framing& framing, const ViewOptions& options,
              double panelAspect) {
    const double width = scene.photo.rows * panelAspect / framing.zoom; // wide photos only
    double most = -1;
    for (int y = 0; y < scene.depth.rows; ++y) {
        for (const int side : {0, 1}) {
            const int x = side == 0 ? 0 : scene.depth.cols - 1;
            const double shift = options.strengthPercent / 200 *
                                 std::abs(scene.depth.at<float>(y, x) - options.focus);
            const double edge = (side - framing.centre.x) * scene.photo.cols / width + 0.5;
            most = std::max(most, side == 0 ? edge + shift : 1 - (edge - shift));
        }
    }
    return most;
}

TEST(PhotoSides, NoViewLooksBeyondThePhoto) {
    const cv::Size size(420, 560);
    const altiro3D::Scene scene = framedScene(size);
    const double aspect = 0.75;
    for (const double focus : {0.2, 0.5}) {
        for (const double strength : {4.0, 8.0}) {
            ViewOptions options;
            options.focus = focus;
            options.strengthPercent = strength;
            options.method = ViewMethod::Fast;
            const Framing framing =
                insideViews(scene, cv::Rect({}, size), aspect, Framing(), options);
            EXPECT_GT(framing.zoom, 1);
            EXPECT_LE(framing.zoom, 1 + kMaxSideZoom / 100);
            EXPECT_GT(beyond(scene, Framing(), options, aspect), 0.005);
            EXPECT_NEAR(beyond(scene, framing, options, aspect), 0, 1e-9); // and not more
            // the views themselves: the rims are not in them
            for (const bool isInside : {false, true}) {
                const PhotoFit fit = withMargins(
                    fitPhoto(size, aspect, size, FitMode::Cover, isInside ? framing : Framing()),
                    size, options);
                altiro3D::Scene fitted;
                DepthRefineOptions exact;
                exact.flaws = DepthFlaws();
                fitScene(scene, fit, focus, fitted, exact);
                int widest = 0; // px of the rims in a row
                const auto view = photoViews(fitted, options);
                for (const double position : {-1.0, 1.0}) {
                    cv::Mat picture;
                    view(position, picture);
                    for (int y = 0; y < picture.rows; ++y) {
                        int red = 0;
                        for (int x = 0; x < picture.cols; ++x)
                            red += picture.at<cv::Vec3b>(y, x)[2] > 128;
                        widest = std::max(widest, red);
                    }
                }
                // one at each side, as the window is rounded to px of the photo
                EXPECT_EQ(widest > 2, !isInside) << focus << ' ' << strength << ' ' << widest;
            }
        }
    }
}

TEST(PhotoSides, TheZoomIsLimitedAndWhatHasRoomStays) {
    const altiro3D::Scene scene = framedScene(kPhoto);
    const cv::Rect all({}, kPhoto);
    ViewOptions options;
    const Framing middle;
    EXPECT_EQ(insideViews(scene, all, 0.75, middle, options), middle); // photo beside it
    // at the rim it moves aside, without zoom
    const Framing rim{{0.25, 0.5}, 1};
    const Framing moved = insideViews(scene, all, 0.75, rim, options);
    EXPECT_EQ(moved.zoom, 1);
    EXPECT_NEAR(beyond(scene, moved, options, 0.75), 0, 1e-9);
    // too much
    options.strengthPercent = 30;
    const Framing limited = insideViews(scene, all, 1.5, middle, options);
    EXPECT_DOUBLE_EQ(limited.zoom, 1 + kMaxSideZoom / 100);
    // a border of a scan stands out: what strength 10 needs with any depth and focus
    options.strengthPercent = 10;
    options.focus = 1;
    const cv::Rect scan(6, 0, kPhoto.width - 12, kPhoto.height);
    const Framing kept = insideViews(scene, scan, 1.5, middle, options);
    EXPECT_GT(kept.zoom, 1 + kMaxSideZoom / 100);
    EXPECT_LT(beyond(scene, kept, options, 1.5), -0.0099); // the border is 1 % of the photo
    // it is left out on all sides, whatever the strength
    options.strengthPercent = 0;
    const cv::Rect inside(6, 4, 591, 390);
    const Framing cut = insideViews(scene, inside, 1.5, middle, options);
    const cv::Rect shown = fitPhoto(kPhoto, 1.5, {60, 40}, FitMode::Cover, cut).source;
    EXPECT_EQ(shown & inside, shown) << shown;
    EXPECT_GE(shown.width, 584);
    // few px
    const altiro3D::Scene tiny = framedScene({12, 8});
    EXPECT_EQ(insideViews(tiny, {0, 0, 12, 8}, 1.5, middle, ViewOptions()), middle);
    EXPECT_TRUE(holds(errorOf([&] {
                          static_cast<void>(insideViews(tiny, {3, 0, 12, 8}, 1.5, middle, options));
                      }),
                      "is not inside the photo"));
}

} // namespace
} // namespace altiro3D::test
