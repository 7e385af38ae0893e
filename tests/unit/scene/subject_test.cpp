#include "scene/framing.hpp"

#include "altiro3D/placement.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

// A wide scene: flat background at 0.2, a sharp near disc at `column`.
altiro3D::Scene sceneWithSubject(int column) {
    altiro3D::Scene scene{cv::Mat(150, 400, CV_8UC3, cv::Scalar::all(90)),
                          cv::Mat(150, 400, CV_32FC1, cv::Scalar(0.2))};
    for (int y = 0; y < 150; ++y) {
        for (int x = 0; x < 400; ++x) {
            if (std::hypot(x - column, y - 75) > 35) continue;
            scene.photo.at<cv::Vec3b>(y, x) = cv::Vec3b::all((x / 4 + y / 4) % 2 == 0 ? 20 : 230);
            scene.depth.at<float>(y, x) = 0.8F;
        }
    }
    return scene;
}

cv::Mat weightsOf(const altiro3D::Scene& scene) {
    cv::Mat weights;
    subjectWeights(scene.photo, scene.depth, weights);
    return weights;
}

double chosenStrength(double focus, const QuiltLayout& layout, const cv::Mat& depth,
                      bool isLimitAlone = false) {
    altiro3D::Scene scene{cv::Mat(depth.size(), CV_8UC3, cv::Scalar::all(90)), depth};
    scene.edges = DepthEdges::Aligned;
    PlacementOptions options;
    options.views.focus = focus;
    options.views.strengthPercent = 10000;
    AutoChoices choices;
    (isLimitAlone ? choices.limit : choices.strength) = true;
    const double aspect = static_cast<double>(depth.cols) / depth.rows;
    return chooseFromScene(scene, aspect, layout, options, choices).options.views.strengthPercent;
}

TEST(Subject, TheWindowFollowsTheSubjectAndStaysInside) {
    for (const int column : {40, 100, 200, 290, 360}) {
        const Framing framing = frameSubject(weightsOf(sceneWithSubject(column)), {400, 150}, 0.75);
        const double expected = std::clamp(column / 400.0, 0.14, 0.86); // 113 of 400 px are shown
        EXPECT_NEAR(framing.centre.x, expected, 0.02) << column;
        EXPECT_EQ(framing.centre.y, 0.5);
        EXPECT_EQ(framing.zoom, 1);
    }
}

TEST(Subject, ItsDepthIsChosenWhateverSurroundsIt) {
    for (const int column : {40, 200, 360}) {
        const altiro3D::Scene scene = sceneWithSubject(column);
        EXPECT_FLOAT_EQ(static_cast<float>(subjectDepth(weightsOf(scene), scene.depth)), 0.8F);
        // without the subject in the part, the background remains
        const cv::Rect2d other =
            column < 200 ? cv::Rect2d(0.5, 0, 0.5, 1) : cv::Rect2d(0, 0, 0.3, 1);
        EXPECT_FLOAT_EQ(static_cast<float>(subjectDepth(weightsOf(scene), scene.depth, other)),
                        0.2F);
    }
}

TEST(Subject, NothingToChooseGivesTheMiddle) {
    for (const double depth : {0.0, 0.5, 1.0, std::nan("")}) {
        const altiro3D::Scene flat{cv::Mat(150, 400, CV_8UC3, cv::Scalar::all(90)),
                                   cv::Mat(30, 20, CV_32FC1, cv::Scalar(depth))};
        const Framing framing = frameSubject(weightsOf(flat), {400, 150}, 0.75);
        EXPECT_NEAR(framing.centre.x, 0.5, 0.01) << depth;
        EXPECT_EQ(subjectDepth(weightsOf(flat), flat.depth), std::isnan(depth) ? 0 : depth);
    }
    const altiro3D::Scene tiny{cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(9)),
                               cv::Mat(1, 1, CV_32FC1, cv::Scalar(1))};
    EXPECT_EQ(frameSubject(weightsOf(tiny), {1, 1}, 0.75), Framing());
    EXPECT_EQ(subjectDepth(weightsOf(tiny), tiny.depth), 1);
}

TEST(Subject, WeightsAndWindowEqualTheSlowTwin) {
    for (const cv::Size size :
         {cv::Size(1, 1), cv::Size(2, 37), cv::Size(61, 40), cv::Size(40, 3)}) {
        const altiro3D::Scene scene{randomPhoto(size), randomDepth({23, 17})};
        const cv::Mat weights = weightsOf(scene);
        cv::Mat slow;
        slow = referenceSubjectWeights(scene.photo, scene.depth);
        ASSERT_EQ(weights.size(), slow.size());
        EXPECT_LE(cv::norm(weights, slow, cv::NORM_INF), 1) << size;
        for (const double aspect : {0.3, 0.75, 1.0, 2.2}) {
            const cv::Rect shown = fitPhoto(size, aspect, {1, 1}).source;
            const cv::Rect expected = referenceBestWindow(weights, shown.size());
            const Framing framing = frameSubject(weights, size, aspect);
            EXPECT_EQ(fitPhoto(size, aspect, {1, 1}, FitMode::Cover, framing).source, expected)
                << size << ' ' << aspect;
        }
    }
}

TEST(Subject, StrengthKeepsTheWarningSilentAndUsesWhatIsThere) {
    QuiltLayout layout;
    const cv::Size panel(1536, 2048);
    for (const int views : {2, 5, 9, 48}) {
        layout.viewCount = views;
        for (const double focus : {0.0, 0.3, 0.5, 1.0}) {
            for (const cv::Vec2d& range :
                 {cv::Vec2d(0, 1), cv::Vec2d(0.25, 0.75), cv::Vec2d(0.5, 0.5)}) {
                ViewOptions options;
                options.focus = focus;
                cv::Mat depth(4, 100, CV_32FC1, cv::Scalar(range[0])); // falls little per row
                depth.at<float>(0, 0) = static_cast<float>(range[1]);
                options.strengthPercent = chosenStrength(focus, layout, depth);
                const double reach =
                    std::max(std::abs(range[0] - focus), std::abs(range[1] - focus));
                const double pixels = adjacentParallax(options, layout, panel, range).viewPixels;
                const double moved = options.strengthPercent * reach;
                EXPECT_LE(pixels, kParallaxBudgetPixels * (1 + 1e-12));
                EXPECT_LE(moved, kMaxAutoParallax * (1 + 1e-12));
                EXPECT_LE(options.strengthPercent, kMaxAutoStrength);
                // one of the limits is reached
                EXPECT_TRUE(pixels > kParallaxBudgetPixels * 0.999999 ||
                            moved > kMaxAutoParallax * 0.999999 ||
                            options.strengthPercent == kMaxAutoStrength);
            }
        }
    }
}

TEST(Subject, StrengthGivesWayWhereMuchWasHidden) {
    QuiltLayout layout;
    layout.viewCount = 48;
    for (const int bars : {1, 2, 5, 20}) {
        // bars that hide a part of what is behind them in every row, from both sides
        cv::Mat depth = cv::Mat::zeros(30, 400, CV_32FC1);
        for (int i = 0; i < bars; ++i)
            depth.colRange(20 * i + 5, 20 * i + 10).setTo(0.75);
        const double strength = chosenStrength(0.5, layout, depth);
        // each bar of height 0.75 uncovers 0.75 * strength / 2 percent of an outermost view
        const double hidden = bars * 0.75 * strength / 2;
        EXPECT_NEAR(chosenStrength(0.5, layout, depth, true) * hidden / strength, kMaxAutoHidden,
                    1e-9)
            << bars;
        EXPECT_LE(hidden, kMaxAutoHidden * (1 + 1e-12)) << bars;
        EXPECT_TRUE(hidden > kMaxAutoHidden * 0.999999 || bars == 1) << bars;
        cv::Mat soft;
        cv::blur(depth, soft, {3, 1}); // in doubt: stretched instead
        EXPECT_NEAR(chosenStrength(0.5, layout, soft), strength, 1e-4 * strength) << bars;
    }
}

TEST(Subject, WrongInputsAreNamed) {
    cv::Mat weights;
    EXPECT_TRUE(holds(errorOf([&] { subjectWeights({}, {}, weights); }), "photo"));
    EXPECT_TRUE(
        holds(errorOf([&] { return frameSubject(cv::Mat(), cv::Size(4, 4), 1); }), "weights"));
    PlacementOptions options;
    options.fit = FitMode::Contain;
    AutoChoices choices;
    choices.framing = true;
    EXPECT_TRUE(holds(errorOf([&] {
                          static_cast<void>(chooseFromScene(sceneWithSubject(200), 1, QuiltLayout(),
                                                            options, choices));
                      }),
                      "expected cover"));
}

} // namespace
} // namespace altiro3D::test
