#include "base/pixel_rows.hpp"

#include "support/processors.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D::test {
namespace {

std::vector<std::uint8_t> randomBytes(std::size_t count, std::uint64_t seed) {
    cv::RNG rng(seed);
    std::vector<std::uint8_t> bytes(count);
    for (std::uint8_t& byte : bytes)
        byte = static_cast<std::uint8_t>(rng.uniform(0, 256));
    return bytes;
}

TEST(PixelRows, PlanesBecomePixelsAndPixelsPlanes) {
    forEachInstructionSet([&](const char* name) {
        for (const std::size_t count : {1, 3, 15, 16, 17, 63, 64, 65, 128, 200}) {
            std::vector<std::uint8_t> planes[3];
            for (std::size_t k = 0; k < 3; ++k)
                planes[k] = randomBytes(count + kRowPadding, k + 1);
            std::vector<std::uint8_t> bgr(3 * count + 1, 77); // nothing is written behind it
            interleaveRow(planes[0].data(), planes[1].data(), planes[2].data(), count, bgr.data());
            for (std::size_t i = 0; i < count; ++i)
                for (std::size_t k = 0; k < 3; ++k)
                    ASSERT_EQ(bgr[3 * i + k], planes[k][i]) << name << " " << count << " " << i;
            EXPECT_EQ(bgr.back(), 77) << name << " " << count;
            std::vector<std::uint8_t> split[3];
            split[0] = split[1] = split[2] = paddedRow<std::uint8_t>(count);
            splitRow(bgr.data(), count, split[0].data(), split[1].data(), split[2].data());
            for (std::size_t k = 0; k < 3; ++k)
                EXPECT_TRUE(std::equal(split[k].begin(),
                                       split[k].begin() + static_cast<std::ptrdiff_t>(count),
                                       planes[k].begin()))
                    << name << " " << count;
        }
    });
}

// Columns that repeat, go on by one, are skipped, and a row that is mirrored.
TEST(PixelRows, PixelsTakeTheValuesOfTheirColumns) {
    forEachInstructionSet([&](const char* name) {
        for (const double step : {0.0, 0.13, 0.27, 1.0, 1.3, 9.0}) {
            for (const std::size_t count : {1, 7, 16, 100, 131}) {
                for (const bool mirrored : {false, true}) {
                    std::vector<std::int32_t> columns(count);
                    for (std::size_t i = 0; i < count; ++i)
                        columns[i] = static_cast<std::int32_t>(step * static_cast<double>(i));
                    if (mirrored) std::reverse(columns.begin(), columns.end());
                    const auto width = static_cast<std::size_t>(
                        *std::max_element(columns.begin(), columns.end()) + 1);
                    std::vector<float> floats = paddedRow<float>(width);
                    std::vector<std::int32_t> numbers = paddedRow<std::int32_t>(width);
                    cv::RNG rng(7);
                    for (std::size_t x = 0; x < width; ++x) {
                        floats[x] = rng.uniform(-1e6F, 1e6F);
                        numbers[x] = rng.uniform(-32768, 32768);
                    }
                    std::vector<float> pickedFloats(count);
                    std::vector<std::int16_t> pickedShorts(count);
                    pickColumns(columns.data(), count, floats.data(), pickedFloats.data());
                    pickColumns(columns.data(), count, numbers.data(), pickedShorts.data());
                    for (std::size_t i = 0; i < count; ++i) {
                        const auto column = static_cast<std::size_t>(columns[i]);
                        ASSERT_EQ(pickedFloats[i], floats[column]) << name << " " << step;
                        ASSERT_EQ(pickedShorts[i], numbers[column]) << name << " " << step;
                    }
                }
            }
        }
    });
}

} // namespace
} // namespace altiro3D::test
