#include "altiro3D/depth2quilt.hpp"

#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/pixels.hpp"
#include "support/random_pictures.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D::test {
namespace {

int reflected(int index, int count) {
    while (index < 0 || index >= count)
        index = index < 0 ? -index : 2 * (count - 1) - index;
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
        forPixels(a.size(), [&](int x, int y) {
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
        });
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
        const cv::Mat a = randomPicture(size, CV_8UC3, 1);
        cv::Mat b;
        cv::addWeighted(a, 0.7, randomPicture(size, CV_8UC3, 2), 0.3, 0, b);
        EXPECT_NEAR(altiro3D::ssim(a, b), slowSsim(a, b), 1e-9) << size;
    }
    const cv::Mat a = randomPicture({20, 20}, CV_8UC1, 3);
    EXPECT_NEAR(altiro3D::ssim(a, a), 1, 1e-12);
}

TEST(PictureQuality, DifferentShapesAndTypesAreRefused) {
    const cv::Mat a(4, 5, CV_8UC3);
    EXPECT_TRUE(holds(errorOf([&] { altiro3D::psnr(a, cv::Mat(5, 4, CV_8UC3)); }), "expected"));
    const cv::Mat five(4, 5, CV_8UC(5), cv::Scalar::all(0));
    EXPECT_EQ(altiro3D::psnr(five, five), std::numeric_limits<double>::infinity());
    EXPECT_EQ(errorOf([&] { altiro3D::ssim(five, five); }),
              "picture: has 5 channels, expected at most 4");
    EXPECT_TRUE(holds(errorOf([&] { altiro3D::ssim(cv::Mat(4, 5, CV_16UC3), a); }), "8-bit"));
}

// The rank of each value by counting: those below it, and half of its equals.
double slowRankCorrelation(const std::vector<float>& a, const std::vector<float>& b) {
    const auto ranks = [](const std::vector<float>& values) {
        std::vector<long double> result;
        for (const float value : values) {
            long double rank = -0.5L;
            for (const float other : values)
                rank += other < value ? 1.0L : other == value ? 0.5L : 0.0L;
            result.push_back(rank);
        }
        return result;
    };
    const std::vector<long double> ra = ranks(a);
    const std::vector<long double> rb = ranks(b);
    const long double mean = (static_cast<long double>(a.size()) - 1) / 2;
    long double ab = 0;
    long double aa = 0;
    long double bb = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ab += (ra[i] - mean) * (rb[i] - mean);
        aa += (ra[i] - mean) * (ra[i] - mean);
        bb += (rb[i] - mean) * (rb[i] - mean);
    }
    return static_cast<double>(ab / std::sqrt(aa * bb));
}

TEST(RankCorrelation, IsThatOfTheDefinition) {
    cv::Mat a = randomDepth({17, 13});
    cv::Mat b = randomDepth({17, 13}, 5);
    b = 0.5 * a + 0.5 * b;
    a.rowRange(3, 6).setTo(0.25F); // equal values
    std::vector<float> all[2];
    std::vector<float> masked[2];
    cv::Mat mask(a.size(), CV_8UC1, cv::Scalar(1));
    mask.colRange(2, 7).setTo(0);
    forPixels(a.size(), [&](int x, int y) {
        const float values[] = {a.at<float>(y, x), b.at<float>(y, x)};
        for (std::size_t i = 0; i < 2; ++i) {
            all[i].push_back(values[i]);
            if (mask.at<uchar>(y, x) != 0) masked[i].push_back(values[i]);
        }
    });
    EXPECT_NEAR(rankCorrelation(a, b), slowRankCorrelation(all[0], all[1]), 1e-12);
    EXPECT_NEAR(rankCorrelation(a, b, mask), slowRankCorrelation(masked[0], masked[1]), 1e-12);
    EXPECT_NEAR(rankCorrelation(b, b.mul(b)), 1, 1e-12) << "any rising function";
    EXPECT_NEAR(rankCorrelation(b, -b), -1, 1e-12);
    EXPECT_EQ(rankCorrelation(b, cv::Mat(b.size(), CV_32FC1, cv::Scalar(1))), 0);
    EXPECT_EQ(errorOf([&] { rankCorrelation(a, cv::Mat(2, 3, CV_32FC1)); }),
              "b: has 3 x 2 px, expected 17 x 13 px");
    EXPECT_TRUE(holds(errorOf([&] { rankCorrelation(cv::Mat(), a); }), "a: "));
    cv::Mat unknown = a.clone();
    unknown.at<float>(2, 3) = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(errorOf([&] { rankCorrelation(a, unknown); }),
              "b: holds NaN or infinity, expected finite values");
    cv::Mat some(a.size(), CV_8UC1, cv::Scalar(1));
    some.at<uchar>(2, 3) = 0;
    EXPECT_NEAR(rankCorrelation(a, unknown, some), 1, 1e-12);
    EXPECT_TRUE(holds(errorOf([&] { rankCorrelation(a, a, a); }), "mask: "));
}

TEST(AlignedDepth, UndoesScaleAndShift) {
    const cv::Mat truth = 0.2 + 0.6 * randomDepth({30, 20});
    cv::Mat aligned;
    alignDepth(0.2 + 0.7 * truth, truth, aligned);
    EXPECT_TRUE(samePicture(aligned, truth, 1e-5)); // floats
    const cv::Mat mean(truth.size(), CV_32FC1, cv::Scalar(cv::mean(truth)[0]));
    alignDepth(cv::Mat(3, 3, CV_32FC1, cv::Scalar(0.3)), truth, aligned);
    EXPECT_TRUE(samePicture(aligned, mean, 1e-6));
    alignDepth(0.9 - 0.7 * truth, truth, aligned); // near and far exchanged
    EXPECT_TRUE(samePicture(aligned, mean, 1e-6));
    cv::Mat steep(1, 4, CV_32FC1, cv::Scalar(0));
    steep.at<float>(0, 3) = 1;
    cv::Mat other(1, 4, CV_32FC1, cv::Scalar(0));
    other.at<float>(0, 0) = 1;
    alignDepth(steep, other, aligned); // leaves 0..1 only where it is clamped
    EXPECT_TRUE(cv::checkRange(aligned, true, nullptr, 0, 1.0001));
    steep.at<float>(0, 1) = std::nanf("");
    EXPECT_EQ(codeOf([&] { alignDepth(steep, other, aligned); }), ErrorCode::InvalidArgument);
}

} // namespace
} // namespace altiro3D::test
