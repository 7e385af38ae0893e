#include "native/lens_filter.hpp"

#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/eye.hpp"
#include "support/pixels.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

// 247 lenses across 1536 px, one per 6.22 px; lines of one phase move by 0.139 px per row.
LensGeometry portrait() {
    return lensGeometry(stripePanel(1536, 2048));
}

double light(int code) {
    static const cv::Mat lights = [] {
        cv::Mat codes(1, 256, CV_8UC3);
        for (int i = 0; i < 256; ++i)
            codes.at<cv::Vec3b>(i) = cv::Vec3b::all(static_cast<uchar>(i));
        return lightOf(codes);
    }();
    return static_cast<double>(lights.at<cv::Vec3f>(code)[0]);
}

// The weights of the px around a place.
cv::Mat weightsOf(const LensFilter& filter, int channel) {
    const SeparableWeights& parts = filter.weights(channel);
    cv::Mat columns;
    cv::hconcat(parts.columns, columns);
    return columns * parts.rows;
}

double codeOf(double light) {
    return 255 * srgbCode(light);
}

cv::Mat filtered(const LensFilter& filter, const cv::Mat& photo) {
    cv::Mat result;
    filter.apply(photo, result);
    return result;
}

// A wave of grey light, in cycles per px of the photo.
cv::Mat wave(cv::Size size, double fx, double fy) {
    return pictureOf<cv::Vec3b>(size, [&](int x, int y) {
        return cv::Vec3b::all(
            cv::saturate_cast<uchar>(codeOf(0.4 + 0.3 * std::cos(2 * kPi * (fx * x + fy * y)))));
    });
}

// Amplitude of the wave in green light, away from the borders.
double amplitude(const cv::Mat& photo, double fx, double fy) {
    double cosine = 0;
    double sine = 0;
    int count = 0;
    for (int y = 20; y < photo.rows - 20; ++y) {
        for (int x = 20; x < photo.cols - 20; ++x) {
            const double v = light(photo.at<cv::Vec3b>(y, x)[1]) - 0.4;
            cosine += v * std::cos(2 * kPi * (fx * x + fy * y));
            sine += v * std::sin(2 * kPi * (fx * x + fy * y));
            ++count;
        }
    }
    return 2 * std::hypot(cosine, sine) / count;
}

double passed(const LensFilter& filter, double fx, double fy) {
    const cv::Mat photo = wave({240, 240}, fx, fy);
    return amplitude(filtered(filter, photo), fx, fy) / amplitude(photo, fx, fy);
}

TEST(LensFilter, KeepsEveryColourThatFillsThePhoto) {
    const LensFilter filter(portrait(), {768, 1024});
    for (int code = 0; code < 256; ++code) {
        const cv::Mat photo(9, 40, CV_8UC3, cv::Scalar(code, 255 - code, 0.5 * code));
        ASSERT_TRUE(samePicture(filtered(filter, photo), photo)) << code;
    }
}

// In panel px: detail of three lens periods and more is shown; that of the order of the sub-pixels'
// colours, which lenses turn into colour (6.2 - 6 px in x, 1 row of 7.2 in y), is not.
TEST(LensFilter, PassesWhatTheLensesShowAndNothingElse) {
    for (const int times : {1, 2}) {
        const LensFilter filter(portrait(), {1536 / times, 2048 / times});
        SCOPED_TRACE(times);
        EXPECT_NEAR(passed(filter, times / 24.0, 0), 1, 0.15);
        EXPECT_NEAR(passed(filter, 0, times / 24.0), 1, 0.15);
        EXPECT_NEAR(passed(filter, times / 18.0, 0), 1, 0.15);
        EXPECT_LT(passed(filter, times * 0.0356, times * 0.1395), 0.3);
        EXPECT_LT(passed(filter, times / 6.2217, 0), 0.1) << "one lens period";
        EXPECT_LT(passed(filter, 0, times / 5.0), 0.1);
    }
}

double sinc(double x) {
    return x == 0 ? 1 : std::sin(kPi * x) / (kPi * x);
}

// (2.10), term by term.
double gainOf(const LensGeometry& lens, double fx, double fy) {
    const double period = lens.lensPeriodSubpixels / 3;
    const double slant = lens.tilt * lens.panelWidth / lens.panelHeight;
    const double white[3] = {0.95047, 1, 1.08883};
    const double xyz[3][3] = {{0.4124564, 0.3575761, 0.1804375},
                              {0.2126729, 0.7151522, 0.0721750},
                              {0.0193339, 0.1191920, 0.9503041}};
    const auto strength = [&](int k, const auto& ofColour) { // |c_k|²
        double re = 0;
        double im = 0;
        for (int c = 0; c < 3; ++c) {
            re += ofColour(c) * std::cos(2 * kPi * k * c / 3);
            im -= ofColour(c) * std::sin(2 * kPi * k * c / 3);
        }
        return re * re + im * im;
    };
    const auto seen = [&](double x, double y, double sigma) {
        return std::exp(-4 * kPi * kPi * sigma * sigma * (x * x + y * y));
    };
    const double sigma = period / 3.1;
    double noise = 0;
    for (int k = -8; k <= 8; ++k) {
        const double luminance = strength(k, [&](int c) { return xyz[1][c]; });
        const double colour =
            strength(k, [&](int c) { return 500.0 / 116 * (xyz[0][c] / white[0] - xyz[1][c]); }) +
            strength(k, [&](int c) { return 200.0 / 116 * (xyz[1][c] - xyz[2][c] / white[2]); });
        for (int m = -80; m <= 80; ++m) {
            if (k == 0 && m == 0) continue;
            const double gx = fx + k + m / period;
            const double gy = std::remainder(fy - m * slant / period, 1);
            const double power = std::pow(sinc((fx + k) / 3) * sinc(period * gx), 2);
            noise += power * (luminance * seen(gx, gy, sigma) + colour * seen(gx, gy, 3 * sigma));
        }
    }
    const double pass = sinc(fx / 3) * sinc(period * fx);
    const double wanted = seen(fx, fy, sigma);
    return pass * wanted / (pass * pass * wanted + noise);
}

// The last products are left out, and the sum of the others is made 1.
TEST(LensFilter, WeightsAreThoseOfTheBestGain) {
    const LensGeometry lens = portrait();
    const LensFilter filter(lens, {lens.panelWidth / 2, lens.panelHeight / 2});
    constexpr int kReach = 8;
    constexpr int kSize = 4 * kReach;
    cv::Mat gains(kSize, kSize, CV_64FC1);
    for (int v = 0; v < kSize; ++v) {
        for (int u = 0; u < kSize; ++u) {
            const double fx = std::remainder(1.0 * u / kSize, 1);
            const double fy = std::remainder(1.0 * v / kSize, 1);
            gains.at<double>(v, u) = gainOf(lens, fx / 2, fy / 2) /
                                     std::max(std::pow(sinc(fx), 3) * std::pow(sinc(fy), 2), 0.3);
        }
    }
    cv::Mat expected(2 * kReach + 1, 2 * kReach + 1, CV_64FC1);
    for (int y = -kReach; y <= kReach; ++y) {
        for (int x = -kReach; x <= kReach; ++x) {
            double sum = 0;
            for (int v = 0; v < kSize; ++v)
                for (int u = 0; u < kSize; ++u)
                    sum += gains.at<double>(v, u) * std::cos(2 * kPi * (u * x + v * y) / kSize);
            expected.at<double>(y + kReach, x + kReach) =
                sum * sinc(1.0 * x / (kReach + 1)) * sinc(1.0 * y / (kReach + 1));
        }
    }
    expected /= cv::sum(expected)[0];
    cv::Mat weights;
    weightsOf(filter, 1).convertTo(weights, CV_64F);
    EXPECT_LT(cv::norm(weights, expected), 5e-3);
    EXPECT_GT(cv::norm(expected), 0.2);
    EXPECT_LT(filter.weights(1).columns.size(), 5U);
}

TEST(LensFilter, EqualsItsFormula) {
    LensGeometry geometry = portrait();
    for (const cv::Size size : {cv::Size(1536, 2048), {768, 1024}, {420, 560}, {5000, 7000}}) {
        const LensFilter filter(geometry, size);
        const cv::Mat photo = randomPhoto({61, 43}, 5);
        const cv::Mat result = filtered(filter, photo);
        const double perPixel = std::max(1.0, 1536.0 / size.width);
        const int near = std::max(1, static_cast<int>(std::lround(2 / perPixel)));
        double worst = 0;
        for (int c = 0; c < 3; ++c) {
            const cv::Mat weights = weightsOf(filter, c);
            EXPECT_NEAR(cv::sum(weights)[0], 1, 1e-5);
            const auto lightAt = [&](int y, int x) {
                return light(photo.at<cv::Vec3b>(std::clamp(y, 0, photo.rows - 1),
                                                 std::clamp(x, 0, photo.cols - 1))[2 - c]);
            };
            forPixels(photo.size(), [&](int x, int y) {
                double sum = 0;
                for (int v = 0; v < weights.rows; ++v)
                    for (int u = 0; u < weights.cols; ++u)
                        sum += static_cast<double>(weights.at<float>(v, u)) *
                               lightAt(y + v - weights.rows / 2, x + u - weights.cols / 2);
                double least = 1;
                double most = 0;
                for (int v = -near; v <= near; ++v) {
                    for (int u = -near; u <= near; ++u) {
                        least = std::min(least, lightAt(y + v, x + u));
                        most = std::max(most, lightAt(y + v, x + u));
                    }
                }
                const double expected = codeOf(std::clamp(sum, least, most));
                worst = std::max(worst, std::abs(expected - result.at<cv::Vec3b>(y, x)[2 - c]));
            });
        }
        EXPECT_LT(worst, 0.51 + 0.15) << size << ": steps of light are coarser than codes at black";
    }
}

// Red and blue lie a third of a panel px to the left and right of green.
TEST(LensFilter, FiltersEachColourToThePlaceOfItsSubpixels) {
    const auto centre = [](const cv::Mat& weights) {
        double sum = 0;
        for (int v = 0; v < weights.rows; ++v)
            for (int u = 0; u < weights.cols; ++u)
                sum += static_cast<double>(weights.at<float>(v, u)) * u;
        return sum - 0.5 * (weights.cols - 1);
    };
    LensGeometry geometry = portrait();
    for (const bool reversed : {false, true}) {
        geometry.blueFirst = reversed;
        const LensFilter filter(geometry, {768, 1024});
        const double sign = reversed ? -1 : 1;
        EXPECT_NEAR(centre(weightsOf(filter, 0)), -sign / 6, 0.03);
        EXPECT_NEAR(centre(weightsOf(filter, 1)), 0, 1e-4);
        EXPECT_NEAR(centre(weightsOf(filter, 2)), sign / 6, 0.03);
    }
}

TEST(LensFilter, ReverseLensesGiveReverseWeights) {
    LensGeometry geometry = portrait();
    const LensFilter filter(geometry, {768, 1024});
    geometry.tilt = -geometry.tilt;
    const LensFilter leaning(geometry, {768, 1024});
    cv::Mat flipped;
    cv::flip(weightsOf(leaning, 1), flipped, 0);
    EXPECT_LT(cv::norm(weightsOf(filter, 1), flipped, cv::NORM_INF), 1e-6);
    EXPECT_GT(cv::norm(weightsOf(filter, 1), weightsOf(leaning, 1), cv::NORM_INF), 1e-3);
}

TEST(LensFilter, GivesTheSameBytesOnEveryProcessor) {
    const LensFilter filter(portrait(), {768, 1024});
    const cv::Mat photo = randomPhoto({333, 70}, 8);
    const cv::Mat expected = filtered(filter, photo);
    const RestoredThreads restored;
    forEachInstructionSet([&](const char* name) {
        for (const int threads : {1, 2}) {
            cv::setNumThreads(threads);
            EXPECT_TRUE(samePicture(filtered(filter, photo), expected)) << name;
        }
    });
}

TEST(LensFilter, TakesDegenerateLensesAndPhotos) {
    LensGeometry geometry = portrait();
    for (const double period : {0.01, 1.0, 3.0, 300.0, 1e6}) { // sub-pixels
        geometry.lensPeriodSubpixels = period;
        for (const double tilt : {0.0, 1e-9, 500.0}) {
            geometry.tilt = tilt;
            for (const cv::Size size : {cv::Size(1, 1), {768, 1}, {1536, 2048}}) {
                const LensFilter filter(geometry, size);
                EXPECT_TRUE(cv::checkRange(weightsOf(filter, 0))) << period << " " << tilt;
                const cv::Mat photo = randomPhoto({2, 3}, 8);
                EXPECT_EQ(filtered(filter, photo).size(), photo.size());
            }
        }
    }
}

} // namespace
} // namespace altiro3D::test
