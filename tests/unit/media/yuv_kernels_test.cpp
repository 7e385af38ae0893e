#include "media/yuv_kernels.hpp"

#include "altiro3D/video_io.hpp"
#include "support/processors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D::test {
namespace {

const ColourMatrix kMatrices[] = {ColourMatrix::Bt601, ColourMatrix::Bt709, ColourMatrix::Bt2020};
const ColourRange kRanges[] = {ColourRange::Limited, ColourRange::Full};

// Y, U and V by the book, not rounded.
std::array<double, 3> exactYuv(const std::uint8_t* bgr, ColourMatrix matrix, ColourRange range,
                               int bits) {
    const double kr = matrix == ColourMatrix::Bt601   ? 0.299
                      : matrix == ColourMatrix::Bt709 ? 0.2126
                                                      : 0.2627;
    const double kb = matrix == ColourMatrix::Bt601   ? 0.114
                      : matrix == ColourMatrix::Bt709 ? 0.0722
                                                      : 0.0593;
    const double b = bgr[0] / 255.0;
    const double g = bgr[1] / 255.0;
    const double r = bgr[2] / 255.0;
    const double y = kr * r + (1 - kr - kb) * g + kb * b;
    const double u = (b - y) / (2 * (1 - kb));
    const double v = (r - y) / (2 * (1 - kr));
    const double step = 1 << (bits - 8);
    if (range == ColourRange::Limited)
        return {(16 + 219 * y) * step, (128 + 224 * u) * step, (128 + 224 * v) * step};
    const double most = 256 * step - 1;
    return {most * y, 128 * step + most * u, 128 * step + most * v};
}

std::vector<std::uint8_t> randomBytes(std::size_t count) {
    std::vector<std::uint8_t> bytes(count);
    cv::RNG random(7);
    for (auto& byte : bytes)
        byte = static_cast<std::uint8_t>(random.uniform(0, 256));
    return bytes;
}

template <class T>
void expectNearExact(int bits, double tolerance) {
    const std::size_t count = 20011; // an odd prime, so that rests are met
    const std::vector<std::uint8_t> bgr = randomBytes(3 * count);
    std::vector<T> planes[3];
    for (auto& plane : planes)
        plane.resize(count);
    for (const ColourMatrix matrix : kMatrices) {
        for (const ColourRange range : kRanges) {
            bgrToYuv(bgr.data(), count, yuvWeights(matrix, range, bits), planes[0].data(),
                     planes[1].data(), planes[2].data());
            double worst = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const auto exact = exactYuv(&bgr[3 * i], matrix, range, bits);
                const double most = (1 << bits) - 1;
                for (std::size_t k = 0; k < 3; ++k)
                    worst = std::max(worst, std::abs(planes[k][i] - std::min(exact[k], most)));
            }
            // 0.5 is what rounding alone does.
            EXPECT_LE(worst, 0.5 + tolerance);
        }
    }
}

TEST(YuvKernels, EightBitsAreWithinRoundingOfTheBook) {
    expectNearExact<std::uint8_t>(8, 0.05);
}

TEST(YuvKernels, TenBitsAreWithinRoundingOfTheBook) {
    expectNearExact<std::uint16_t>(10, 0.2);
}

TEST(YuvKernels, GreyStaysGreyAndBlackAndWhiteAreExact) {
    std::vector<std::uint8_t> bgr;
    for (int grey = 0; grey < 256; ++grey)
        bgr.insert(bgr.end(), 3, static_cast<std::uint8_t>(grey));
    std::vector<std::uint8_t> y(256), u(256), v(256);
    for (const ColourMatrix matrix : kMatrices) {
        for (const ColourRange range : kRanges) {
            bgrToYuv(bgr.data(), 256, yuvWeights(matrix, range, 8), y.data(), u.data(), v.data());
            const bool limited = range == ColourRange::Limited;
            EXPECT_EQ(y[0], limited ? 16 : 0);
            EXPECT_EQ(y[255], limited ? 235 : 255);
            for (std::size_t i = 0; i < 256; ++i) {
                EXPECT_EQ(u[i], 128);
                EXPECT_EQ(v[i], 128);
            }
            std::vector<std::uint8_t> back(768);
            yuvToBgr(y.data(), u.data(), v.data(), 256, bgrWeights(matrix, range), back.data());
            for (std::size_t i = 0; i < 256; ++i) {
                EXPECT_EQ(back[3 * i], back[3 * i + 1]);
                EXPECT_EQ(back[3 * i], back[3 * i + 2]);
                EXPECT_NEAR(back[3 * i], bgr[3 * i], limited ? 1 : 0);
            }
        }
    }
}

// The rest at the end of a row goes through plain code: each length must give the same pixels.
TEST(YuvKernels, PixelsDoNotDependOnTheirPlaceInTheRow) {
    const std::size_t count = 131;
    const std::vector<std::uint8_t> bgr = randomBytes(3 * count);
    const YuvWeights weights = yuvWeights(ColourMatrix::Bt709, ColourRange::Limited, 8);
    const YuvWeights weights10 = yuvWeights(ColourMatrix::Bt709, ColourRange::Limited, 10);
    const BgrWeights bgrOf = bgrWeights(ColourMatrix::Bt709, ColourRange::Limited);
    forEachInstructionSet([&](const char* name) {
        SCOPED_TRACE(name);
        for (std::size_t i = 0; i < count; ++i) {
            std::uint8_t one[3];
            std::uint16_t one10[3];
            bgrToYuv(&bgr[3 * i], 1, weights, one, one + 1, one + 2);
            bgrToYuv(&bgr[3 * i], 1, weights10, one10, one10 + 1, one10 + 2);
            std::vector<std::uint8_t> y(count), u(count), v(count), back(3 * count);
            std::vector<std::uint16_t> y10(count), u10(count), v10(count);
            const std::size_t length = i + 1;
            bgrToYuv(bgr.data(), length, weights, y.data(), u.data(), v.data());
            bgrToYuv(bgr.data(), length, weights10, y10.data(), u10.data(), v10.data());
            ASSERT_EQ(y[i], one[0]);
            ASSERT_EQ(u[i], one[1]);
            ASSERT_EQ(v[i], one[2]);
            ASSERT_EQ(y10[i], one10[0]);
            ASSERT_EQ(u10[i], one10[1]);
            ASSERT_EQ(v10[i], one10[2]);
            std::uint8_t pixel[3];
            // any three bytes are a colour here
            yuvToBgr(&bgr[3 * i], &bgr[3 * i + 1], &bgr[3 * i + 2], 1, bgrOf, pixel);
            for (std::size_t k = 0; k < count; ++k) {
                y[k] = bgr[3 * k];
                u[k] = bgr[3 * k + 1];
                v[k] = bgr[3 * k + 2];
            }
            yuvToBgr(y.data(), u.data(), v.data(), length, bgrOf, back.data());
            ASSERT_TRUE(
                std::equal(pixel, pixel + 3, back.begin() + static_cast<std::ptrdiff_t>(3 * i)));
        }
    });
}

} // namespace
} // namespace altiro3D::test
