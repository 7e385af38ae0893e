#include "views/depth_offsets.hpp"

#include "base/pixel_rows.hpp"
#include "support/processors.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

// Depth of each kind, for rows that are no multiple of a vector.
std::vector<float> depths(std::size_t count, double focus) {
    using Limits = std::numeric_limits<float>;
    std::vector<float> row = {Limits::quiet_NaN(),
                              Limits::infinity(),
                              -Limits::infinity(),
                              -0.0F,
                              0,
                              1,
                              1.5F,
                              -2,
                              Limits::denorm_min(),
                              Limits::max(),
                              static_cast<float>(focus),
                              std::nextafter(static_cast<float>(focus), 2.0F)};
    cv::RNG rng(count);
    while (row.size() < count)
        row.push_back(rng.uniform(-0.1F, 1.1F));
    row.resize(count);
    return row;
}

TEST(DepthOffsets, AreThoseOfSingleDepths) {
    forEachInstructionSet([&](const char* name) {
        for (const double focus : {0.0, 0.3, 0.5, 1.0}) {
            for (const std::size_t count : {1, 2, 7, 12, 16, 33, 100}) {
                const std::vector<float> depth = depths(count, focus);
                std::vector<float> offsets(count + 1, 77.0F);
                offsetsFromFocus(depth.data(), count, focus, offsets.data());
                std::vector<std::int32_t> whole = paddedRow<std::int32_t>(count);
                const bool still = wholeOffsets(depth.data(), count, focus, whole.data());
                const auto end = whole.begin() + static_cast<std::ptrdiff_t>(count);
                EXPECT_EQ(still, std::count(whole.begin(), end, 0) == end - whole.begin());
                for (std::size_t i = 0; i < count; ++i) {
                    const float offset = offsetFromFocus(depth[i], focus);
                    ASSERT_EQ(offsets[i], offset) << name << " " << focus << " " << i;
                    ASSERT_NEAR(whole[i], 8192 * offset, 0.501) << name << " " << focus << " " << i;
                }
                EXPECT_EQ(offsets[count], 77.0F); // nothing is written behind the row
            }
        }
    });
}

TEST(DepthOffsets, OfARowAtTheFocusAreZero) {
    forEachInstructionSet([&](const char* name) {
        for (const double focus : {0.0, 0.3, 1.0}) {
            const std::vector<float> depth(37, static_cast<float>(focus));
            std::vector<std::int32_t> whole = paddedRow<std::int32_t>(37);
            EXPECT_TRUE(wholeOffsets(depth.data(), 37, focus, whole.data())) << name;
            for (std::size_t i = 0; i < 37; ++i)
                EXPECT_EQ(whole[i], 0) << name << " " << focus;
        }
    });
}

TEST(DepthOffsets, StepsAreThoseAboveTheTear) {
    cv::RNG rng(3);
    std::vector<float> offsets(101);
    for (float& offset : offsets)
        offset = 0.01F * static_cast<float>(rng.uniform(0, 9)); // steps that equal the tear
    forEachInstructionSet([&](const char* name) {
        for (const double tear : {0.0, 0.01, 0.03, static_cast<double>(0.03F), 1.0}) {
            for (const std::size_t count : {std::size_t{1}, std::size_t{2}, std::size_t{17},
                                            std::size_t{33}, offsets.size()}) {
                std::vector<int> expected;
                for (std::size_t x = 0; x + 1 < count; ++x) {
                    const double right = static_cast<double>(offsets[x + 1]);
                    if (std::abs(right - static_cast<double>(offsets[x])) > tear)
                        expected.push_back(static_cast<int>(x));
                }
                std::vector<int> steps = {7};
                findSteps(offsets.data(), count, tear, steps);
                EXPECT_EQ(steps, expected) << name << " " << tear << " " << count;
            }
        }
    });
}

} // namespace
} // namespace altiro3D::test
