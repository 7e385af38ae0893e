#include "altiro3D/depth_map.hpp"

#include "depth/map/depth_values.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <queue>

namespace altiro3D::test {
namespace {

const cv::Size kSize(120, 90);
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

cv::Mat flatDepth(double level = 0.2, cv::Size size = kSize) {
    return {size, CV_32FC1, cv::Scalar(level)};
}

cv::Mat grey(cv::Size size = kSize) {
    return {size, CV_8UC3, cv::Scalar::all(100)};
}

// Two surfaces with a border between columns 59 and 60, and noise that is less than an edge.
cv::Mat twoSurfaces() {
    cv::Mat photo(kSize, CV_8UC3, cv::Scalar(40, 60, 50));
    photo.colRange(60, kSize.width).setTo(cv::Scalar(120, 160, 140));
    return photo + randomPicture(kSize, CV_8UC3, 3, 0, 4);
}

DepthBrushOptions options(DepthBrush brush, double radius, double amount, bool keepsEdges = true) {
    DepthBrushOptions result;
    result.brush = brush;
    result.radius = radius;
    result.amount = amount;
    result.keepsEdges = keepsEdges;
    return result;
}

// The effect of a place at a distance, written from the documentation.
long double effect(long double distance, long double radius) {
    if (distance <= radius / 2) return 1;
    if (distance >= radius) return 0;
    const long double t = 2 * (radius - distance) / radius;
    return 3 * t * t - 2 * t * t * t;
}

cv::Mat strokeOf(const cv::Mat& photo, const cv::Mat& depth, const DepthBrushOptions& how,
                 const std::vector<cv::Point2d>& places) {
    DepthStroke stroke(photo, depth, how);
    for (const cv::Point2d& place : places)
        static_cast<void>(stroke.moveTo(place));
    return stroke.depth().clone();
}

TEST(DepthStroke, OnePlaceChangesAllByTheFormula) {
    const cv::Point2d at(40.3, 51.8);
    for (const double radius : {0.5, 3.0, 17.5, 400.0}) {
        for (const bool keeps : {false, true}) {
            for (const DepthBrush brush :
                 {DepthBrush::Nearer, DepthBrush::Farther, DepthBrush::Level}) {
                DepthBrushOptions how = options(brush, radius, 0.15, keeps);
                how.level = 0.8;
                const cv::Mat painted = strokeOf(grey(), flatDepth(0.3), how, {at});
                cv::Mat expected = flatDepth(0.3);
                for (int y = 0; y < kSize.height; ++y) {
                    for (int x = 0; x < kSize.width; ++x) {
                        const long double share = effect(hypotl(x - at.x, y - at.y), radius);
                        long double change = 0.15L * (0.8L - 0.3L);
                        if (brush == DepthBrush::Nearer) change = 0.15L;
                        if (brush == DepthBrush::Farther) change = -0.15L;
                        expected.at<float>(y, x) = static_cast<float>(0.3L + share * change);
                    }
                }
                EXPECT_TRUE(samePicture(painted, expected, 2e-6)) << radius; // floats
            }
        }
    }
}

TEST(DepthStroke, StopsAtEdgesOfThePhoto) {
    const cv::Mat photo = twoSurfaces();
    const cv::Rect right(61, 0, kSize.width - 61, kSize.height);
    const cv::Point2d at(50, 40);
    const cv::Mat kept = strokeOf(photo, flatDepth(), options(DepthBrush::Nearer, 30, 0.5), {at});
    EXPECT_TRUE(samePicture(kept(right), flatDepth()(right)));
    EXPECT_FLOAT_EQ(kept.at<float>(40, 50), 0.7F);
    EXPECT_FLOAT_EQ(kept.at<float>(40, 57), 0.7F); // as on a grey photo, close to the edge
    const cv::Mat over =
        strokeOf(photo, flatDepth(), options(DepthBrush::Nearer, 30, 0.5, false), {at});
    EXPECT_FLOAT_EQ(over.at<float>(40, 62), 0.7F);
    EXPECT_TRUE(samePicture(
        over, strokeOf(grey(), flatDepth(), options(DepthBrush::Nearer, 30, 0.5), {at}), 1e-6));
}

TEST(DepthStroke, ALineIsChangedOnce) {
    const DepthBrushOptions how = options(DepthBrush::Nearer, 12, 0.3);
    const cv::Mat once = strokeOf(grey(), flatDepth(), how, {{20, 45}, {100, 45}});
    const cv::Mat thrice =
        strokeOf(grey(), flatDepth(), how, {{20, 45}, {100, 45}, {20, 45}, {100, 45}});
    EXPECT_TRUE(samePicture(once, thrice, 0.02)); // places of the way back lie between
    double most = 0;
    cv::minMaxLoc(thrice, nullptr, &most);
    EXPECT_FLOAT_EQ(static_cast<float>(most), 0.5F);
    // all of the line is covered, and its sides have the profile of one place
    for (int x = 20; x <= 97; ++x) {
        EXPECT_FLOAT_EQ(once.at<float>(45, x), 0.5F) << x;
        EXPECT_NEAR(once.at<float>(45 + 9, x), static_cast<double>(0.2L + 0.3L * effect(9, 12)),
                    0.02)
            << x;
        EXPECT_FLOAT_EQ(once.at<float>(45 + 12, x), 0.2F) << x;
    }
}

TEST(DepthStroke, SaysWhatChanged) {
    DepthStroke stroke(twoSurfaces(), flatDepth(), options(DepthBrush::Nearer, 9, 0.3));
    cv::Mat before = stroke.depth().clone();
    for (const cv::Point2d& place : {cv::Point2d(10, 10), {60, 30}, {60.5, 30}, {200, 95}}) {
        const cv::Rect changed = stroke.moveTo(place);
        EXPECT_EQ(changed & cv::Rect({0, 0}, kSize), changed);
        cv::Mat differs = stroke.depth() != before;
        differs(changed).setTo(0);
        EXPECT_EQ(cv::countNonZero(differs), 0) << place;
        before = stroke.depth().clone();
    }
}

TEST(DepthStroke, SmoothTakesNoiseAndKeepsTheStep) {
    const cv::Mat photo = twoSurfaces();
    cv::Mat depth = flatDepth(0.3);
    depth.colRange(60, kSize.width).setTo(0.7);
    cv::Mat noise(kSize, CV_32FC1);
    cv::RNG random(9);
    random.fill(noise, cv::RNG::NORMAL, 0, 0.02);
    depth += noise;
    cv::Mat smooth = depth;
    for (int x = 5; x < kSize.width; x += 10) // on both surfaces
        smooth = strokeOf(photo, smooth, options(DepthBrush::Smooth, 16, 1), {{x + 0.0, 45}});
    for (const int begin : {20, 62}) {
        const cv::Rect part(begin, 38, 36, 14);
        cv::Scalar mean;
        cv::Scalar deviation;
        cv::meanStdDev(smooth(part), mean, deviation);
        EXPECT_LT(deviation[0], 0.006) << begin;
        EXPECT_NEAR(mean[0], begin < 60 ? 0.3 : 0.7, 0.005) << begin;
    }
    const cv::Mat level = flatDepth(0.6);
    EXPECT_TRUE(
        samePicture(strokeOf(photo, level, options(DepthBrush::Smooth, 30, 1), {{0, 0}, {110, 80}}),
                    level, 1e-6));
}

TEST(DepthStroke, ExtremesAreDefined) {
    const cv::Mat depth = (cv::Mat_<float>(1, 4) << NAN, -3.0F, 1e30F, 0.5F);
    const cv::Mat within = (cv::Mat_<float>(1, 4) << 0.0F, 0.0F, 1.0F, 0.5F);
    const cv::Mat photo = grey({4, 1});
    EXPECT_TRUE(samePicture(
        strokeOf(photo, depth, options(DepthBrush::Nearer, 4096, 0), {{0, 0}, {3, 0}}), within));
    EXPECT_TRUE(samePicture(strokeOf(photo, depth, options(DepthBrush::Farther, 4096, 1),
                                     {{-1e300, 1e300}, {1e300, -1e300}, {0, 0}}),
                            cv::Mat::zeros(1, 4, CV_32FC1)));
    EXPECT_TRUE(samePicture(strokeOf(photo, depth, options(DepthBrush::Smooth, 0.5, 1), {{-90, 0}}),
                            within));
    EXPECT_TRUE(samePicture(strokeOf(grey({1, 1}), flatDepth(0.4, {1, 1}),
                                     options(DepthBrush::Nearer, 0.5, 1), {{0, 0}}),
                            cv::Mat::ones(1, 1, CV_32FC1)));
    DepthStroke stroke(photo, depth, {});
    EXPECT_EQ(errorOf([&] { return stroke.moveTo(cv::Point2d(kNan, 0)); }),
              "place: is not finite, expected px of the photo");
}

TEST(DepthStroke, ArgumentsAreChecked) {
    const auto problem = [](const std::function<void(DepthBrushOptions&)>& change) {
        DepthBrushOptions how;
        change(how);
        return errorOf([&] { DepthStroke(grey(), flatDepth(), how); });
    };
    EXPECT_EQ(problem([](auto& how) { how.radius = 0.25; }), "radius: is 0.25, expected 0.5..4096");
    EXPECT_EQ(problem([](auto& how) { how.radius = kNan; }), "radius: is nan, expected 0.5..4096");
    EXPECT_EQ(problem([](auto& how) { how.amount = -1; }), "amount: is -1, expected 0..1");
    EXPECT_EQ(problem([](auto& how) { how.level = 2; }), "level: is 2, expected 0..1");
    EXPECT_EQ(
        errorOf([] { DepthStroke(grey(), flatDepth(0, cv::Size(3, 3)), DepthBrushOptions()); }),
        "depth: has 3 x 3 px, expected the photo's 120 x 90 px");
}

TEST(LiftDepth, FindsTheThingThatIsCircled) {
    cv::Mat photo = twoSurfaces();
    cv::Mat thing = cv::Mat::zeros(kSize, CV_8UC1);
    cv::circle(thing, {32, 44}, 20, cv::Scalar(255), cv::FILLED);
    photo.setTo(cv::Scalar(30, 30, 200), thing);
    std::vector<cv::Point2d> around; // 3 px outside of it
    for (int i = 0; i < 24; ++i)
        around.emplace_back(32 + 23 * std::cos(i * CV_PI / 12), 44 + 23 * std::sin(i * CV_PI / 12));
    for (const double amount : {0.4, -0.15}) {
        cv::Mat lifted;
        const cv::Rect changed = liftDepth(photo, flatDepth(), around, amount, lifted);
        cv::Mat expected = flatDepth();
        expected.setTo(0.2 + amount, thing);
        cv::Mat differs = cv::abs(lifted - expected) > std::abs(amount) / 2;
        EXPECT_LE(cv::countNonZero(differs), 70); // half a px of the circle's 126
        differs = lifted != flatDepth();
        differs(changed).setTo(0);
        EXPECT_EQ(cv::countNonZero(differs), 0);
    }
}

TEST(LiftDepth, WithoutEdgesTheOutlineIsTheBorder) {
    const std::vector<cv::Point2d> outline = {{20, 15}, {95, 15}, {95, 70}, {20, 70}};
    cv::Mat lifted;
    liftDepth(grey(), flatDepth(), outline, 0.5, lifted);
    for (int y = 0; y < kSize.height; ++y) {
        for (int x = 0; x < kSize.width; ++x) {
            const int in = std::min({x - 20, 95 - x, y - 15, 70 - y}); // > 0 inside
            if (std::abs(in) < 3) continue;                            // the border is soft
            ASSERT_FLOAT_EQ(lifted.at<float>(y, x), in > 0 ? 0.7F : 0.2F) << x << " " << y;
        }
    }
}

TEST(LiftDepth, ExtremesAreDefined) {
    cv::Mat depth = flatDepth();
    const cv::Mat before = depth.clone();
    EXPECT_TRUE(liftDepth(grey(), depth, {}, 1, depth).empty());
    EXPECT_TRUE(liftDepth(grey(), depth, {{1, 1}, {50, 50}}, 1, depth).empty());
    EXPECT_TRUE(samePicture(depth, before));
    // all of it, by an outline far outside
    liftDepth(grey(), depth, {{-1e9, -1e9}, {1e9, -1e9}, {1e9, 1e9}, {-1e9, 1e9}}, 1, depth);
    EXPECT_TRUE(samePicture(depth, cv::Mat::ones(kSize, CV_32FC1)));
    cv::Mat one = cv::Mat(1, 1, CV_32FC1, cv::Scalar(kNan));
    liftDepth(grey({1, 1}), one, {{0, 0}, {0, 0}, {0, 0}}, 0.5, one);
    EXPECT_TRUE(std::isfinite(one.at<float>(0)));
    EXPECT_EQ(errorOf([&] {
                  liftDepth(grey(), before, {{kNan, 0}}, 0, depth);
              }),
              "outline: has a point that is not finite, expected px of the photo");
    EXPECT_EQ(errorOf([&] { liftDepth(grey(), before, {}, kNan, depth); }),
              "amount: is nan, expected -1..1");
}

// Dijkstra's algorithm.
cv::Mat exactCosts(const cv::Mat& photo, float perPixel, cv::Point from) {
    cv::Mat costs(photo.size(), CV_64FC1, cv::Scalar(1e9));
    using Entry = std::tuple<double, int, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    costs.at<double>(from) = 0;
    open.emplace(0, from.y, from.x);
    while (!open.empty()) {
        const auto [cost, y, x] = open.top();
        open.pop();
        if (cost > costs.at<double>(y, x)) continue;
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                const cv::Point to(x + dx, y + dy);
                if (!cv::Rect({0, 0}, photo.size()).contains(to)) continue;
                double difference = 0;
                for (int c = 0; c < 3; ++c)
                    difference =
                        std::max(difference, std::abs(double(photo.at<cv::Vec3b>(y, x)[c]) -
                                                      photo.at<cv::Vec3b>(to)[c]));
                const double next =
                    cost + std::hypot(dx, dy) * perPixel + std::max(0.0, difference - 3);
                if (next >= costs.at<double>(to)) continue;
                costs.at<double>(to) = next;
                open.emplace(next, to.y, to.x);
            }
        }
    }
    return costs;
}

TEST(PhotoPaths, AreTheCheapestOrNearly) {
    const cv::Mat photo = randomPhoto(kSize, 5, 3);
    for (const float perPixel : {0.0F, 0.25F}) {
        const cv::Point from(70, 30);
        cv::Mat costs(kSize, CV_32FC1, cv::Scalar(kFarAway));
        costs.at<float>(from) = 0;
        pathCosts(photo, perPixel, costs);
        cv::Mat found;
        costs.convertTo(found, CV_64F);
        const cv::Mat more = found - exactCosts(photo, perPixel, from);
        double least = 0;
        double most = 0;
        cv::minMaxLoc(more, &least, &most);
        EXPECT_GE(least, -1e-3); // floats
        EXPECT_LT(cv::mean(more)[0], 0.5);
        EXPECT_LT(most, 12); // less than what makes another surface
    }
}

} // namespace
} // namespace altiro3D::test
