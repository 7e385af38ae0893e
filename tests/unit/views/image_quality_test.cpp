#include "altiro3D/trade.hpp"

#include "support/compare.hpp"
#include "support/files.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

cv::Mat noise(cv::Size size, int type, std::uint64_t seed) {
    cv::RNG rng(seed);
    cv::Mat picture(size, type);
    rng.fill(picture, cv::RNG::UNIFORM, 0, 256);
    return picture;
}

int reflected(int index, int count) {
    while (index < 0 || index >= count) {
        index = index < 0 ? -index : 2 * (count - 1) - index;
    }
    return index;
}

// SSIM from its definition, window by window.
double slowSsim(const cv::Mat& a, const cv::Mat& b) {
    double weights[11][11];
    double total = 0;
    for (int i = 0; i < 11; ++i) {
        for (int j = 0; j < 11; ++j) {
            weights[i][j] = std::exp(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / (2 * 1.5 * 1.5));
            total += weights[i][j];
        }
    }
    double sum = 0;
    for (int c = 0; c < a.channels(); ++c) {
        for (int y = 0; y < a.rows; ++y) {
            for (int x = 0; x < a.cols; ++x) {
                double mx = 0, my = 0, xx = 0, yy = 0, xy = 0;
                for (int i = 0; i < 11; ++i) {
                    for (int j = 0; j < 11; ++j) {
                        const int row = reflected(y + i - 5, a.rows);
                        const int column = reflected(x + j - 5, a.cols) * a.channels() + c;
                        const double w = weights[i][j] / total;
                        const double va = a.ptr(row)[column];
                        const double vb = b.ptr(row)[column];
                        mx += w * va;
                        my += w * vb;
                        xx += w * va * va;
                        yy += w * vb * vb;
                        xy += w * va * vb;
                    }
                }
                const double c1 = 2.55 * 2.55;
                const double c2 = 7.65 * 7.65;
                sum += (2 * mx * my + c1) * (2 * (xy - mx * my) + c2) /
                       ((mx * mx + my * my + c1) * (xx - mx * mx + yy - my * my + c2));
            }
        }
    }
    return sum / (static_cast<double>(a.total()) * a.channels());
}

TEST(PictureQuality, PsnrIsTheClosedForm) {
    const cv::Mat a(4, 5, CV_8UC3, cv::Scalar::all(100));
    const cv::Mat b(4, 5, CV_8UC3, cv::Scalar::all(110));
    EXPECT_NEAR(psnr(a, b), 20 * std::log10(255.0 / 10), 1e-9);
    EXPECT_TRUE(std::isinf(psnr(a, a)));
    cv::Mat oneOff = a.clone();
    oneOff.at<cv::Vec3b>(1, 1)[2] = 101;
    EXPECT_NEAR(psnr(oneOff, a), 10 * std::log10(255.0 * 255 * 60), 1e-9);
}

TEST(PictureQuality, SsimIsItsDefinition) {
    for (const cv::Size size : {cv::Size(23, 17), cv::Size(12, 40), cv::Size(7, 6)}) {
        const cv::Mat a = noise(size, CV_8UC3, 1);
        cv::Mat b;
        cv::addWeighted(a, 0.7, noise(size, CV_8UC3, 2), 0.3, 0, b);
        EXPECT_NEAR(altiro3D::ssim(a, b), slowSsim(a, b), 1e-9) << size;
    }
    const cv::Mat a = noise({20, 20}, CV_8UC1, 3);
    EXPECT_NEAR(altiro3D::ssim(a, a), 1, 1e-12);
}

// Two constant pictures: only the luminance term is left.
TEST(PictureQuality, SsimOfConstantPicturesIsTheLuminanceTerm) {
    const cv::Mat a(20, 20, CV_8UC3, cv::Scalar::all(50));
    const cv::Mat b(20, 20, CV_8UC3, cv::Scalar::all(150));
    const double c1 = 2.55 * 2.55;
    EXPECT_NEAR(altiro3D::ssim(a, b), (2 * 50 * 150 + c1) / (50 * 50 + 150 * 150 + c1), 1e-9);
}

TEST(PictureQuality, DifferentShapesAndTypesAreRefused) {
    const cv::Mat a(4, 5, CV_8UC3);
    EXPECT_NE(errorOf([&] { altiro3D::psnr(a, cv::Mat(5, 4, CV_8UC3)); }).find("expected"),
              std::string::npos);
    const cv::Mat five(4, 5, CV_8UC(5), cv::Scalar::all(0));
    EXPECT_EQ(altiro3D::psnr(five, five), std::numeric_limits<double>::infinity());
    EXPECT_EQ(errorOf([&] { altiro3D::ssim(five, five); }),
              "picture: has 5 channels, expected at most 4");
    EXPECT_NE(errorOf([&] { altiro3D::ssim(cv::Mat(4, 5, CV_16UC3), a); }).find("8-bit"),
              std::string::npos);
}

} // namespace
} // namespace altiro3D::test
