// The common behaviour of all methods, tested through the public interface.

#include "altiro3D/depth2quilt.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/memory_limit.hpp"
#include "support/pixels.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

const cv::Size kSizes[] = {{1, 1},   {2, 1},   {1, 2},   {1, 23}, {23, 1},
                           {61, 37}, {64, 48}, {101, 3}, {3, 101}};

cv::Mat smoothNoise(cv::Size size) {
    cv::Mat photo = randomPhoto(size, 5, 0);
    cv::GaussianBlur(photo, photo, {5, 5}, 1.2);
    return photo;
}

cv::Mat flat(cv::Size size, float value) {
    return {size, CV_32FC1, cv::Scalar::all(static_cast<double>(value))};
}

// A ramp with a near board in it.
cv::Mat boardDepth(cv::Size size) {
    cv::Mat depth(size, CV_32FC1);
    for (int x = 0; x < size.width; ++x)
        depth.col(x).setTo(0.1 + 0.3 * x / size.width);
    depth(cv::Rect(size.width / 3, size.height / 4, (size.width + 2) / 3, (size.height + 1) / 2))
        .setTo(0.9);
    return depth;
}

constexpr double kInpaintingNoise = 8;

// Depth that no camera gives, but a broken file or network might.
std::vector<std::pair<std::string, cv::Mat>> wildDepths(cv::Size size) {
    using Limits = std::numeric_limits<float>;
    std::vector<std::pair<std::string, cv::Mat>> depths;
    const std::pair<const char*, float> kValues[] = {{"NaN", Limits::quiet_NaN()},
                                                     {"inf", Limits::infinity()},
                                                     {"-inf", -Limits::infinity()},
                                                     {"negative", -3},
                                                     {"denormal", Limits::denorm_min()},
                                                     {"huge", Limits::max()},
                                                     {"-0", -0.0F}};
    for (const auto& [name, value] : kValues)
        depths.emplace_back(name, flat(size, value));
    depths.emplace_back("checkerboard", pictureOf<float>(size, [](int x, int y) {
                            return static_cast<float>((x + y) % 2);
                        }));
    depths.emplace_back("spikes", pictureOf<float>(size, [](int x, int y) {
                            return (x * 7 + y * 3) % 11 == 0 ? 1.0F : 0.3F;
                        }));
    depths.emplace_back(
        "all of them", pictureOf<float>(size, [&](int x, int y) {
            return kValues[static_cast<std::size_t>(x * 5 + y) % std::size(kValues)].second;
        }));
    const int middle = size.width / 2;
    depths.emplace_back(
        "one step", pictureOf<float>(size, [=](int x, int) { return x < middle ? 1.0F : 0.0F; }));
    depths.emplace_back("step of 1e-7", pictureOf<float>(size, [=](int x, int) {
                            return x < middle ? 0.5F : 0.5F + 1e-7F;
                        }));
    return depths;
}

class ViewMethods : public ::testing::TestWithParam<ViewMethod> {
  protected:
    ViewOptions options(double strength = 20, double focus = 0.4) const {
        ViewOptions result;
        result.method = GetParam();
        result.strengthPercent = strength;
        result.focus = focus;
        return result;
    }
    // strength in px: S/2 is how far depth 1 moves in the outermost view for focus 0
    cv::Mat viewOf(const cv::Mat& photo, const cv::Mat& depth, double position,
                   const ViewOptions& options) const {
        cv::Mat view;
        Depth2Quilt({1, 1, {9, 9}, 1}, options).renderView({photo, depth}, position, view);
        return view;
    }
    cv::Mat quiltOf(const cv::Mat& photo, const cv::Mat& depth, const QuiltLayout& layout,
                    const ViewOptions& options) const {
        cv::Mat quilt;
        Depth2Quilt(layout, options).render({photo, depth}, quilt);
        return quilt;
    }
};

INSTANTIATE_TEST_SUITE_P(All, ViewMethods,
                         ::testing::Values(ViewMethod::Fast, ViewMethod::Real, ViewMethod::Layered),
                         [](const auto& method) -> std::string {
                             if (method.param == ViewMethod::Fast) return "Fast";
                             return method.param == ViewMethod::Real ? "Real" : "Layered";
                         });

TEST_P(ViewMethods, TheMiddleAndNoStrengthGiveThePhotoBitForBit) {
    for (const cv::Size size : kSizes) {
        const cv::Mat photo = smoothNoise(size);
        std::vector<std::pair<std::string, cv::Mat>> depths = wildDepths(size);
        depths.emplace_back("board", boardDepth(size));
        for (const auto& [name, depth] : depths) {
            for (const auto& [position, strength] :
                 {std::pair(0.0, 20.0), {-0.0, 20.0}, {-1.0, 0.0}, {0.3, 0.0}, {1.0, 0.0}})
                EXPECT_TRUE(samePicture(viewOf(photo, depth, position, options(strength)), photo))
                    << name << size;
        }
    }
}

TEST_P(ViewMethods, DepthAtTheFocusGivesThePhotoInEveryView) {
    const QuiltLayout layout{3, 2, {61, 37}, 5};
    const cv::Mat photo = smoothNoise(layout.tileSize);
    for (const double focus : {0.0, 0.25, 0.3, 1.0}) { // 0.3F is not 0.3
        const cv::Mat depth = flat(photo.size(), static_cast<float>(focus));
        const cv::Mat quilt = quiltOf(photo, depth, layout, options(50, focus));
        for (int i = 0; i < layout.viewCount; ++i)
            EXPECT_TRUE(samePicture(quilt(layout.tile(i)), photo)) << focus << " view " << i;
    }
}

TEST_P(ViewMethods, WildDepthGivesTheViewOfTheDepthItStandsFor) {
    using Limits = std::numeric_limits<float>;
    const std::pair<float, float> kMeanings[] = {
        {Limits::quiet_NaN(), 0}, {-3, 0}, {-Limits::infinity(), 0}, {-0.0F, 0},
        {Limits::infinity(), 1},  {7, 1},  {Limits::max(), 1}};
    const cv::Size size(61, 37);
    const cv::Mat photo = smoothNoise(size);
    for (const auto& [value, meaning] : kMeanings) {
        const cv::Rect patch(20, 10, 15, 12);
        cv::Mat wild = boardDepth(size);
        wild(patch).setTo(static_cast<double>(value));
        cv::Mat clean = boardDepth(size);
        clean(patch).setTo(static_cast<double>(meaning));
        for (const double position : {-1.0, 0.7}) {
            EXPECT_TRUE(samePicture(viewOf(photo, wild, position, options()),
                                    viewOf(photo, clean, position, options())))
                << value;
        }
    }
}

TEST_P(ViewMethods, AnySizeAndDepthIsDefined) {
    const cv::Vec3b colour{10, 120, 200};
    for (const cv::Size size : kSizes) {
        const cv::Mat photo = smoothNoise(size);
        const cv::Mat plain(size, CV_8UC3, cv::Scalar(colour));
        for (const auto& [name, depth] : wildDepths(size)) {
            for (const double position : {-1.0, 0.01, 1.0, 40.0}) {
                const cv::Mat view = viewOf(photo, depth, position, options(80));
                EXPECT_EQ(view.size(), size);
                EXPECT_TRUE(samePicture(viewOf(photo, depth, position, options(80)), view))
                    << name << size << position;
                // what has one colour has it in every view: nothing comes from elsewhere
                // (inpainting adds noise: real_test.cpp)
                const double noise = GetParam() == ViewMethod::Real ? kInpaintingNoise : 0;
                EXPECT_TRUE(samePicture(viewOf(plain, depth, position, options(80)), plain, noise))
                    << name << size << position;
            }
        }
    }
}

// The rule of signs.
TEST_P(ViewMethods, NearThingsMoveAgainstTheCamera) {
    cv::Mat photo(9, 200, CV_8UC3, cv::Scalar::all(0));
    photo.colRange(100, 104).setTo(cv::Scalar::all(255)); // a bright bar
    const auto barAt = [&](float depth, double position) {
        cv::Mat grey;
        cv::cvtColor(viewOf(photo, flat(photo.size(), depth), position, options(10, 0.5)), grey,
                     cv::COLOR_BGR2GRAY);
        const cv::Moments moments = cv::moments(grey);
        return moments.m10 / moments.m00;
    };
    // S = 10 % of 200 = 20 px; shift = -p (d - f) S/2 = -p * 0.5 * 10 = 5 px against the camera
    for (const double position : {1.0, -1.0, 0.45}) {
        EXPECT_NEAR(barAt(1, position), 101.5 - 5 * position, 0.01);
        EXPECT_NEAR(barAt(0, position), 101.5 + 5 * position, 0.01);
    }
}

TEST_P(ViewMethods, AnyFinitePositionIsDefined) {
    const cv::Mat photo = smoothNoise({23, 5});
    for (const double position : {1e-300, 1e3, -1e12, 1e300, -1e300}) {
        const cv::Mat view = viewOf(photo, boardDepth(photo.size()), position, options(10000));
        EXPECT_TRUE(
            samePicture(viewOf(photo, boardDepth(photo.size()), position, options(10000)), view));
    }
}

// A board in front of a wall at the focus moves by whole px; the content away from its borders is
// known.
TEST_P(ViewMethods, StepsOfOneAndOfAsManyPixelsAsThereAreMoveThings) {
    const cv::Size size(90, 9);
    const cv::Mat photo = smoothNoise(size);
    cv::Mat depth = flat(size, 0);
    const cv::Rect board(40, 0, 25, 9);
    depth(board).setTo(1);
    for (const int direction : {1, -1}) {
        // S/2 = 1 px: 2 of 90 px
        const cv::Mat one = viewOf(photo, depth, direction, options(200.0 / 90, 0));
        const cv::Rect inner(board.x + 4, 0, board.width - 8, size.height);
        EXPECT_TRUE(samePicture(one(inner - cv::Point(direction, 0)), photo(inner))) << direction;
        for (const cv::Rect& wall : {cv::Rect(0, 0, 35, 9), cv::Rect(70, 0, 20, 9)})
            EXPECT_TRUE(samePicture(one(wall), photo(wall))) << direction;
        // S/2 = 90 px: the board leaves the frame, the wall stays; Fast leaves nothing of the wall
        // where the board was
        const cv::Mat all = viewOf(photo, depth, direction, options(200, 0));
        for (const cv::Rect& wall : {cv::Rect(0, 0, 35, 9), cv::Rect(70, 0, 20, 9)})
            EXPECT_TRUE(samePicture(all(wall), photo(wall))) << direction;
    }
}

TEST_P(ViewMethods, WhatGoesOutOfTheFrameByManyWidthsLeavesItsLastColour) {
    const cv::Vec3b left{10, 120, 200};
    const cv::Vec3b right{220, 30, 90};
    cv::Mat photo(7, 50, CV_8UC3, cv::Scalar(left));
    photo.colRange(25, 50).setTo(cv::Scalar(right));
    const cv::Mat near = flat(photo.size(), 1);
    const ViewOptions wide = options(10000, 0); // S/2 = 50 widths
    for (const double position : {0.1, 1.0, 3.0, 1e6, 1e300}) {
        const auto plain = [&](const cv::Vec3b& colour) {
            return cv::Mat(photo.size(), CV_8UC3, cv::Scalar(colour));
        };
        EXPECT_TRUE(samePicture(viewOf(photo, near, position, wide), plain(right))) << position;
        EXPECT_TRUE(samePicture(viewOf(photo, near, -position, wide), plain(left))) << position;
    }
}

TEST_P(ViewMethods, TilesAreTheSingleViewsForAnyNumberOfThem) {
    const std::pair<int, cv::Size> cases[] = {
        {1, {61, 37}}, {2, {61, 37}}, {3, {61, 37}}, {512, {13, 7}}};
    for (const auto& [views, size] : cases) {
        const int columns = views == 512 ? 23 : 2;
        const QuiltLayout layout{columns, (views + columns - 1) / columns, size, views};
        const cv::Mat photo = smoothNoise(size);
        const cv::Mat depth = boardDepth(size);
        const cv::Mat quilt = quiltOf(photo, depth, layout, options());
        for (int i = 0; i < views; ++i) {
            ASSERT_TRUE(samePicture(quilt(layout.tile(i)),
                                    viewOf(photo, depth, viewPosition(i, views), options())))
                << i << " of " << views;
        }
        for (int i = views; i < layout.columns * layout.rows; ++i) // no view: black
            EXPECT_EQ(cv::norm(quilt(layout.tile(i)), cv::NORM_INF), 0) << i;
    }
}

TEST_P(ViewMethods, ViewsOfAnotherSizeThanTheTileAreAveraged) {
    const QuiltLayout layout{2, 1, {31, 17}, 2};
    const cv::Mat photo = smoothNoise({97, 61});
    const cv::Mat depth = boardDepth(photo.size());
    const cv::Mat quilt = quiltOf(photo, depth, layout, options());
    for (int i = 0; i < 2; ++i) {
        cv::Mat tile;
        cv::resize(viewOf(photo, depth, i == 0 ? -1 : 1, options()), tile, layout.tileSize, 0, 0,
                   cv::INTER_AREA);
        EXPECT_TRUE(samePicture(quilt(layout.tile(i)), tile)) << i;
    }
}

TEST_P(ViewMethods, AnyNumberOfThreadsGivesTheSameBytes) {
    const QuiltLayout layout{4, 2, {61, 37}, 7};
    const cv::Mat photo = smoothNoise(layout.tileSize);
    std::vector<std::pair<std::string, cv::Mat>> depths = wildDepths(photo.size());
    depths.emplace_back("board", boardDepth(photo.size()));
    for (const auto& one : depths) {
        SCOPED_TRACE(one.first);
        expectSameForAnyThreads([&] { return quiltOf(photo, one.second, layout, options(60)); });
    }
}

TEST_P(ViewMethods, MirroredInputGivesTheMirroredViewOfTheOtherSide) {
    const cv::Size size(163, 127);
    const cv::Mat photo = smoothNoise(size);
    cv::Mat mirroredPhoto;
    cv::flip(photo, mirroredPhoto, 1);
    const cv::Mat slope =
        pictureOf<float>(size, [](int x, int) { return static_cast<float>(x) / 163; });
    for (const bool step : {false, true}) {
        const cv::Mat depth = step ? boardDepth(size) : slope;
        cv::Mat mirroredDepth;
        cv::flip(depth, mirroredDepth, 1);
        const cv::Mat view = viewOf(photo, depth, 0.7, options(15));
        cv::Mat mirrored = viewOf(mirroredPhoto, mirroredDepth, -0.7, options(15));
        cv::flip(mirrored, mirrored, 1);
        const cv::Rect inside(20, 0, size.width - 40, size.height);
        switch (GetParam()) {
        case ViewMethod::Layered:
            EXPECT_TRUE(samePicture(mirrored, view));
            break;
        case ViewMethod::Fast:
            // cv::remap rounds 1/32 px halves to one side: weights may differ by one step
            EXPECT_TRUE(samePicture(mirrored, view, 255 / 32.0 + 1));
            EXPECT_LT(compare(mirrored, view).mean, 0.2);
            break;
        case ViewMethod::Real:
            if (!step) { // places halfway between two steps of 1/256 px, and the result's rounding
                EXPECT_TRUE(samePicture(mirrored(inside), view(inside), 2));
                break;
            }
            // inpainting takes ties in the order of columns: what it paints may differ
            const Difference difference = compare(mirrored, view, 2);
            EXPECT_LT(static_cast<double>(difference.count),
                      0.15 * static_cast<double>(difference.samples))
                << difference.report;
            EXPECT_LT(difference.mean, 1) << difference.report;
            break;
        }
    }
}

TEST_P(ViewMethods, SubMatricesGiveTheSameBytesAndNothingAroundThemCounts) {
    const cv::Rect part(11, 7, 61, 37);
    cv::Mat largePhoto(60, 90, CV_8UC3, cv::Scalar::all(77));
    cv::Mat largeDepth(60, 90, CV_32FC1, cv::Scalar::all(0.95));
    const cv::Mat photo = smoothNoise(part.size());
    const cv::Mat depth = boardDepth(part.size());
    photo.copyTo(largePhoto(part));
    depth.copyTo(largeDepth(part));
    const QuiltLayout layout{2, 2, part.size(), 3};
    const cv::Mat expected = quiltOf(photo, depth, layout, options());
    EXPECT_TRUE(
        samePicture(quiltOf(largePhoto(part), largeDepth(part), layout, options()), expected));
    cv::Mat around(2 * 37 + 5, 2 * 61 + 9, CV_8UC3, cv::Scalar::all(9)); // a quilt in a larger one
    cv::Mat quilt = around(cv::Rect(4, 3, 2 * 61, 2 * 37));
    Depth2Quilt(layout, options()).render({largePhoto(part), largeDepth(part)}, quilt);
    EXPECT_TRUE(samePicture(around(cv::Rect(4, 3, 2 * 61, 2 * 37)), expected));
    quilt.setTo(cv::Scalar::all(9));
    EXPECT_EQ(cv::countNonZero(around.clone().reshape(1) != 9), 0);
}

TEST(ViewMethods, LackOfMemoryIsNamed) {
    ALTIRO3D_REQUIRE_MEMORY_LIMITS();
    const cv::Size size(8000, 6000);
    const cv::Mat photo = cv::Mat::zeros(size, CV_8UC3);
    const cv::Mat depth = cv::Mat::zeros(size, CV_32FC1);
    for (const ViewMethod method : {ViewMethod::Layered, ViewMethod::Real}) {
        ViewOptions options;
        options.method = method;
        const Depth2Quilt maker(QuiltLayout(), options);
        cv::Mat quilt(maker.layout().size(), CV_8UC3);
        const MemoryLimit limit(40);
        EXPECT_EQ(errorOf([&] {
                      maker.render({photo, depth}, quilt);
                  }),
                  "photo: no memory for views of 8000 x 6000 px, expected a smaller photo");
    }
}

} // namespace
} // namespace altiro3D::test
