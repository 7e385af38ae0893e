#include "altiro3D/depth_map.hpp"

#include "depth/refine/depth_fit.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/pixels.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <utility>
#include <vector>

namespace altiro3D::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

DepthNormalization wholeRange(DepthKind kind = DepthKind::NearWhite) {
    DepthNormalization options;
    options.kind = kind;
    options.lowPercentile = 0;
    options.highPercentile = 100;
    return options;
}

cv::Mat row(const std::vector<float>& values) {
    return cv::Mat(values, true).reshape(1, 1);
}

cv::Mat normalized(const cv::Mat& raw, const DepthNormalization& options = {}) {
    cv::Mat depth;
    normalizeDepth(raw, depth, options);
    return depth;
}

cv::Mat inGrey(const cv::Mat& photo) {
    cv::Mat grey;
    cv::cvtColor(photo, grey, cv::COLOR_BGR2GRAY);
    cv::cvtColor(grey, grey, cv::COLOR_GRAY2BGR);
    return grey;
}

// The slow twin: doubles, a full sort, searches in all directions.
cv::Mat slowNormalize(const cv::Mat& raw, const DepthNormalization& options) {
    cv::Mat numbers;
    raw.convertTo(numbers, CV_64F);
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> known;
    bool reachesEnd = raw.depth() != CV_16U; // of the type: its largest number is then a distance
    for (const double v : cv::Mat_<double>(numbers))
        reachesEnd = reachesEnd || (v > 65535 * 0.99 && v < 65535);
    forPixels(raw.size(), [&](int x, int y) {
        double& v = numbers.at<double>(y, x);
        if (options.kind == DepthKind::Metric)
            v = v > 0 && (reachesEnd || v < 65535) ? 1 / v : unknown;
        else if (!std::isfinite(v))
            v = unknown;
        else if (options.kind == DepthKind::FarWhite)
            v = -v;
        if (!std::isnan(v)) known.push_back(v);
    });
    cv::Mat flat(raw.size(), CV_32FC1, cv::Scalar(options.flatDepth));
    if (known.empty()) return flat;
    std::sort(known.begin(), known.end());
    const double last = static_cast<double>(known.size() - 1);
    const double low = known[static_cast<std::size_t>(options.lowPercentile / 100 * last)];
    const double high =
        known[static_cast<std::size_t>(std::ceil(options.highPercentile / 100 * last))];
    if (high - low <= 1e-6 * std::max(std::abs(low), std::abs(high))) return flat;
    const auto at = [&](int y, int x) {
        const double v = numbers.at<double>(y, x);
        return static_cast<float>(std::clamp((v - low) / (high - low), 0.0, 1.0));
    };
    cv::Mat depth(raw.size(), CV_32FC1);
    const auto fillRow = [&](int from, int to) {
        for (int x = 0; x < raw.cols; ++x) {
            std::vector<float> found;
            for (const int step : {-1, 1}) {
                for (int i = x; i >= 0 && i < raw.cols; i += step) {
                    if (std::isnan(numbers.at<double>(from, i))) continue;
                    found.push_back(at(from, i));
                    break;
                }
            }
            if (found.empty()) return false;
            depth.at<float>(to, x) = *std::min_element(found.begin(), found.end());
        }
        return true;
    };
    for (int y = 0; y < raw.rows; ++y) {
        for (int distance = 0; distance < raw.rows; ++distance) {
            if (y - distance >= 0 && fillRow(y - distance, y)) break;
            if (y + distance < raw.rows && fillRow(y + distance, y)) break;
        }
    }
    return depth;
}

TEST(DepthMap, AFullByteRampIsLinearAndMonotonic) {
    cv::Mat ramp(1, 256, CV_8UC1);
    for (int x = 0; x < 256; ++x)
        ramp.at<uchar>(0, x) = static_cast<uchar>(x);
    const cv::Mat depth = normalized(ramp, wholeRange());
    for (int x = 0; x < 256; ++x)
        EXPECT_EQ(depth.at<float>(0, x), static_cast<float>(x / 255.0));
    const cv::Mat clipped = normalized(ramp);
    for (int x = 1; x < 256; ++x)
        EXPECT_GE(clipped.at<float>(0, x), clipped.at<float>(0, x - 1));
    EXPECT_EQ(clipped.at<float>(0, 0), 0);
    EXPECT_EQ(clipped.at<float>(0, 255), 1);
}

TEST(DepthMap, EverySixteenBitValueStaysApart) {
    cv::Mat ramp(256, 256, CV_16UC1);
    for (int i = 0; i < 65536; ++i)
        ramp.at<ushort>(i / 256, i % 256) = static_cast<ushort>(i);
    const cv::Mat depth = normalized(ramp, wholeRange());
    EXPECT_TRUE(samePicture(depthTo16Bit(depth), ramp));
}

TEST(DepthMap, PercentilesAgreeWithSortingEverything) {
    for (const int type : {CV_8UC1, CV_16UC1, CV_32FC1, CV_64FC1}) {
        for (const DepthKind kind :
             {DepthKind::NearWhite, DepthKind::FarWhite, DepthKind::Metric}) {
            for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 1), cv::Size(1, 7),
                                        cv::Size(13, 29), cv::Size(300, 220)}) {
                cv::Mat raw = randomPicture(size, type, 5, type == CV_32FC1 ? -50 : 0, 200);
                if (raw.depth() >= CV_32F) { // holes of every sort
                    for (int i = 0; i < size.area(); i += 3) {
                        const double hole = i % 2 != 0 ? kNan : i % 4 != 0 ? kInfinity : 0;
                        raw.row(i / size.width).col(i % size.width).setTo(hole);
                    }
                }
                if (size.height > 8) raw.rowRange(2, 5).setTo(0); // rows without any, for metric
                DepthNormalization options;
                options.kind = kind;
                options.lowPercentile = 2.5;
                options.highPercentile = 90;
                EXPECT_TRUE(samePicture(normalized(raw, options), slowNormalize(raw, options)))
                    << cv::typeToString(type) << " " << size << " kind " << static_cast<int>(kind);
            }
        }
    }
}

TEST(DepthMap, SingleWildValuesDoNotSqueezeTheRest) {
    cv::Mat raw = randomPicture({100, 100}, CV_32FC1, 3, 0, 1);
    const cv::Mat calm = normalized(raw);
    raw.at<float>(50, 50) = 1e30f;
    raw.at<float>(20, 70) = -1e30f;
    const cv::Mat wild = normalized(raw);
    EXPECT_EQ(wild.at<float>(50, 50), 1);
    EXPECT_EQ(wild.at<float>(20, 70), 0);
    // One rank more at either end: neighbouring order statistics of 10000 uniform numbers.
    EXPECT_LT(compare(wild(cv::Rect(0, 0, 100, 20)), calm(cv::Rect(0, 0, 100, 20))).largest, 2e-3);
}

TEST(DepthMap, WhereThereIsNoRangeTheResultIsFlat) {
    DepthNormalization options;
    options.flatDepth = 0.25;
    std::vector<cv::Mat> pictures = {cv::Mat(3, 4, CV_32FC1, cv::Scalar(7)),
                                     cv::Mat(3, 4, CV_32FC1, cv::Scalar(0)),
                                     cv::Mat(3, 4, CV_32FC1, cv::Scalar(-2)),
                                     cv::Mat(3, 4, CV_32FC1, cv::Scalar(kNan)),
                                     cv::Mat(3, 4, CV_32FC1, cv::Scalar(kInfinity)),
                                     cv::Mat(3, 4, CV_32FC1, cv::Scalar(-kInfinity)),
                                     cv::Mat(3, 4, CV_8UC1, cv::Scalar(255)),
                                     cv::Mat(3, 4, CV_16UC1, cv::Scalar(65535)),
                                     cv::Mat(1, 1, CV_32FC1, cv::Scalar(3)),
                                     cv::Mat(1, 1, CV_8UC1, cv::Scalar(0)),
                                     row({1e-40f, 2e-40f, 3e-40f}),
                                     row({0, 1e-42f}),
                                     row({1e6f, 1e6f + 0.0625f, 1e6f - 0.0625f}),
                                     row({-0.0f, 0.0f}),
                                     row({kNan, 4, kInfinity, 4})};
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        for (const DepthKind kind : {DepthKind::NearWhite, DepthKind::FarWhite}) {
            options.kind = kind;
            const cv::Mat expected(pictures[i].size(), CV_32FC1, cv::Scalar(0.25));
            EXPECT_TRUE(samePicture(normalized(pictures[i], options), expected)) << "picture " << i;
        }
    }
    options.kind = DepthKind::Metric;
    for (const cv::Mat& raw :
         {row({0, 0, 0}), row({-1, -2, kNan}), row({kInfinity, kInfinity}), row({3, 3, 0})}) {
        const cv::Mat expected(raw.size(), CV_32FC1, cv::Scalar(0.25));
        EXPECT_TRUE(samePicture(normalized(raw, options), expected)) << raw;
    }
}

TEST(DepthMap, TinyAndHugeHonestRangesWork) {
    const cv::Mat expected = row({0, 0.5f, 1});
    EXPECT_TRUE(samePicture(normalized(row({1e-30f, 1.5e-30f, 2e-30f}), wholeRange()), expected,
                            1e-6)); // 1.5e-30f is not exactly in the middle
    EXPECT_TRUE(samePicture(normalized(row({-3e38f, 0, 3e38f}), wholeRange()), expected));
    EXPECT_TRUE(samePicture(normalized(row({1000, 1000.5f, 1001}), wholeRange()), expected));
    const double huge = std::numeric_limits<double>::max();
    const cv::Mat doubles = (cv::Mat_<double>(1, 3) << -huge, 0, huge);
    EXPECT_TRUE(samePicture(normalized(doubles, wholeRange()), expected));
    const double denormal = std::numeric_limits<double>::denorm_min();
    const cv::Mat distances = (cv::Mat_<double>(1, 2) << denormal, 1);
    EXPECT_TRUE(samePicture(normalized(distances, wholeRange(DepthKind::Metric)), row({1, 0})));
}

TEST(DepthMap, TheResultIsAlwaysWithinZeroAndOne) {
    const std::vector<float> values = {kNan,    kInfinity, -kInfinity, 0,  -0.0f,  1e-42f, -1e-42f,
                                       3.4e38f, -3.4e38f,  1,          -1, 1e-30f, 2,      0.5f};
    cv::RNG random(11);
    for (int trial = 0; trial < 600; ++trial) {
        cv::Mat raw(random.uniform(1, 5), random.uniform(1, 8), CV_32FC1);
        for (int i = 0; i < static_cast<int>(raw.total()); ++i) {
            raw.at<float>(i / raw.cols, i % raw.cols) = values[static_cast<std::size_t>(
                random.uniform(0, static_cast<int>(values.size())))];
        }
        DepthNormalization options;
        options.kind = static_cast<DepthKind>(trial % 3);
        const cv::Mat depth = normalized(raw, options);
        ASSERT_TRUE(cv::checkRange(depth, true, nullptr, 0, 1.0000001)) << raw << depth;
    }
}

TEST(DepthMap, TheLargestDistanceOf16BitsIsUnknownUnlessOthersReachIt) {
    const auto millimetres = [](std::vector<std::uint16_t> values) {
        return cv::Mat(values, true).reshape(1, 1);
    };
    const DepthNormalization metric = wholeRange(DepthKind::Metric);
    EXPECT_TRUE(samePicture(normalized(millimetres({1000, 65535, 2000, 4000, 65535}), metric),
                            normalized(millimetres({1000, 0, 2000, 4000, 0}), metric)));
    EXPECT_TRUE(samePicture(normalized(millimetres({1000, 65535, 65000}), metric),
                            normalized(row({1000, 65535, 65000}), metric)));
    EXPECT_TRUE(samePicture(normalized(millimetres({1000, 65535, 2000}), wholeRange()),
                            normalized(row({1000, 65535, 2000}), wholeRange())));
}

TEST(DepthMap, NormalizingInPlaceGivesTheSame) {
    for (const int type : {CV_32FC1, CV_8UC1}) {
        cv::Mat depth = randomPicture({37, 23}, type, 9, -3, 200);
        const cv::Mat expected = normalized(depth.clone());
        normalizeDepth(depth, depth);
        EXPECT_TRUE(samePicture(depth, expected));
    }
}

TEST(DepthMap, WrongOptionsAndTypesAreNamed) {
    const auto problem = [](const cv::Mat& raw, const DepthNormalization& options = {}) {
        return errorOf([&] { normalized(raw, options); });
    };
    const cv::Mat raw(2, 2, CV_32FC1, cv::Scalar(1));
    DepthNormalization low, high, flat;
    low.lowPercentile = 51;
    high.highPercentile = std::nan("");
    flat.flatDepth = 2;
    EXPECT_EQ(problem(raw, low), "lowPercentile: is 51, expected 0..50 %");
    EXPECT_EQ(problem(raw, high), "highPercentile: is nan, expected 50..100 %");
    EXPECT_EQ(problem(raw, flat), "flatDepth: is 2, expected 0..1");
    const std::string kinds = "expected one channel of 8-bit, 16-bit, float or double numbers";
    EXPECT_EQ(problem({}), "depth: is empty, " + kinds);
    EXPECT_EQ(problem(cv::Mat(2, 3, CV_8UC3)), "depth: is 3 x 2 px of CV_8UC3, " + kinds);
}

// ------------------------------------------------------------------------------------ fitDepth

cv::Mat fitted(const cv::Mat& depth, const cv::Mat& guide, cv::Rect2d part = {}) {
    if (part.empty()) part = cv::Rect2d(0, 0, depth.cols, depth.rows);
    cv::Mat result;
    fitDepth(depth, part, guide, result);
    return result;
}

struct FitCase {
    cv::Size depth;
    cv::Rect2d part;
    cv::Size guide;
};

// The last ones have fewer columns than samples, or rows.
const FitCase kFitCases[] = {
    {{1, 1}, {0, 0, 1, 1}, {5, 3}},          {{2, 2}, {0, 0, 2, 2}, {7, 4}},
    {{9, 7}, {0, 0, 9, 7}, {31, 29}},        {{9, 7}, {1.25, 0.5, 5.5, 6.125}, {37, 43}},
    {{20, 4}, {2, 1, 17, 2}, {23, 19}},      {{67, 53}, {0, 0, 67, 53}, {131, 61}},
    {{97, 5}, {1.5, 0, 90.25, 5}, {41, 17}}, {{5, 97}, {0, 1.5, 5, 90.25}, {17, 41}}};

TEST(DepthMap, FittingAgreesWithTheSlowReference) {
    for (const FitCase& c : kFitCases) {
        const cv::Mat depth = randomPicture(c.depth, CV_32FC1, 3, 0, 1);
        const cv::Mat guide = randomPicture(c.guide, CV_8UC3, 4, 90, 160);
        // float sums of 16 weighed samples against double
        const cv::Mat best = fitted(depth, guide, c.part);
        EXPECT_TRUE(samePicture(best, referenceFit(depth, c.part, guide), 2e-6))
            << c.depth << c.part << c.guide;
        forEachInstructionSet([&](const char* name) {
            EXPECT_TRUE(samePicture(fitted(depth, guide, c.part), best)) << name << c.depth;
        });
    }
}

cv::Mat fittedRefined(const cv::Mat& depth, const cv::Mat& guide, const cv::Rect2d& part) {
    cv::Mat result;
    fitRefinedDepth(depth, part, guide, result);
    return result;
}

// The rule of fitRefinedDepth(), from its definition.
cv::Mat slowlyHardened(const cv::Mat& depth, const cv::Rect2d& part, const cv::Mat& soft) {
    cv::Mat result = soft.clone();
    const auto last = [](double end, int count) {
        return std::min(static_cast<int>(std::ceil(end)) - 1, count - 1);
    };
    const cv::Point first(static_cast<int>(part.x), static_cast<int>(part.y));
    const cv::Point end(last(part.br().x, depth.cols), last(part.br().y, depth.rows));
    for (int y = 0; y < soft.rows; ++y) {
        for (int x = 0; x < soft.cols; ++x) {
            const auto before = [](double start, double length, int at, int count) {
                return static_cast<int>(std::floor(start + (at + 0.5) * (length / count) - 0.5));
            };
            const cv::Point at(before(part.x, part.width, x, soft.cols),
                               before(part.y, part.height, y, soft.rows));
            const auto range = [&](int from, int to) {
                std::vector<float> values;
                for (int j = from; j <= to; ++j) {
                    for (int i = from; i <= to; ++i)
                        values.push_back(depth.at<float>(std::clamp(at.y + j, first.y, end.y),
                                                         std::clamp(at.x + i, first.x, end.x)));
                }
                const auto [least, most] = std::minmax_element(values.begin(), values.end());
                return std::pair(*least, *most);
            };
            const auto [least, most] = range(0, 1);
            const auto [lowest, highest] = range(-1, 2);
            float& value = result.at<float>(y, x);
            if (most - least >= 0.03F && most - least >= 0.6F * (highest - lowest))
                value = value > (least + most) / 2 ? most : least;
            value = std::clamp(value, least, most);
        }
    }
    return result;
}

TEST(DepthMap, RefinedDepthFitsAsItsSlowTwin) {
    for (const FitCase& c : kFitCases) {
        if (c.guide.width <= c.part.width && c.guide.height <= c.part.height) continue;
        for (const double threshold : {0.0, 0.5}) { // 0.5: many hard steps
            cv::Mat depth = randomPicture(c.depth, CV_32FC1, 3, 0, 1);
            if (threshold > 0) cv::threshold(depth, depth, threshold, 0.75, cv::THRESH_BINARY);
            const cv::Mat guide = randomPicture(c.guide, CV_8UC3, 4, 90, 160);
            const cv::Mat soft = fitted(depth, guide, c.part);
            EXPECT_TRUE(samePicture(fittedRefined(depth, guide, c.part),
                                    slowlyHardened(depth, c.part, soft)))
                << c.depth << c.part << c.guide;
        }
    }
}

TEST(DepthMap, StepsOfRefinedDepthStayHardAndSlopesStaySmooth) {
    const cv::Rect2d all(0, 0, 8, 6);
    cv::Mat depth(6, 8, CV_32FC1, cv::Scalar(0.2));
    depth.colRange(4, 8).setTo(0.8);
    // 5 px per sample: the centres of the samples 3 and 4 are at 17.5 and 22.5
    for (const int edge : {0, 19, 20, 21}) { // of the picture; 0: none
        cv::Mat guide(30, 40, CV_8UC3, cv::Scalar(40, 60, 50));
        guide.colRange(edge, 40).setTo(cv::Scalar(180, 150, 200));
        cv::Mat truth(guide.size(), CV_32FC1, cv::Scalar(0.2));
        truth.colRange(edge == 0 ? 20 : edge, 40).setTo(0.8);
        // 1e-4: px beside the step have a little of the colour that is far from theirs
        EXPECT_TRUE(samePicture(fittedRefined(depth, guide, all), truth, 1e-4)) << edge;
        if (edge == 0) {
            EXPECT_GT(compare(fitted(depth, guide), truth).largest, 0.2);
        }
    }
    for (int x = 0; x < 8; ++x)
        depth.col(x).setTo(0.1 + 0.1 * x);
    const cv::Mat slope = fittedRefined(depth, cv::Mat(30, 40, CV_8UC3, cv::Scalar::all(9)), all);
    for (int x = 8; x < 32; ++x) // not at the ends, where samples are repeated
        EXPECT_NEAR(slope.at<float>(15, x), 0.1 + 0.1 * ((x + 0.5) / 5 - 0.5), 1e-6) << x;
}

TEST(DepthMap, InterpolationAgreesWithTheSlowReference) {
    for (const FitCase& c : kFitCases) {
        const cv::Mat depth = randomPicture(c.depth, CV_32FC1, 3, 0, 1);
        const auto sample = [&](int y, int x) -> long double {
            return depth.at<float>(std::clamp(y, 0, depth.rows - 1),
                                   std::clamp(x, 0, depth.cols - 1));
        };
        cv::Mat expected(c.guide, CV_32FC1);
        for (int y = 0; y < expected.rows; ++y) {
            for (int x = 0; x < expected.cols; ++x) {
                const long double u = c.part.x + (x + 0.5L) * c.part.width / c.guide.width - 0.5L;
                const long double v = c.part.y + (y + 0.5L) * c.part.height / c.guide.height - 0.5L;
                const int column = static_cast<int>(std::floor(u));
                const int row = static_cast<int>(std::floor(v));
                const auto along = [&](int r) {
                    return (1 - (u - column)) * sample(r, column) +
                           (u - column) * sample(r, column + 1);
                };
                expected.at<float>(y, x) =
                    static_cast<float>((1 - (v - row)) * along(row) + (v - row) * along(row + 1));
            }
        }
        const RestoredThreads restored;
        for (const int threads : {1, 3}) {
            cv::setNumThreads(threads);
            cv::Mat result;
            interpolateDepth(depth, c.part, c.guide, result);
            EXPECT_TRUE(samePicture(result, expected, 1e-6)) << c.depth << c.part << c.guide;
        }
    }
}

TEST(DepthMap, EqualSizesAreCopiedExactly) {
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 1), cv::Size(13, 7)}) {
        const cv::Mat depth = randomPicture(size, CV_32FC1, 2, 0, 1);
        EXPECT_TRUE(samePicture(fitted(depth, randomPicture(size, CV_8UC3, 3)), depth));
    }
    const cv::Mat whole = randomPicture({20, 20}, CV_32FC1, 2, 0, 1);
    EXPECT_TRUE(samePicture(fitted(whole, cv::Mat(7, 5, CV_8UC3, cv::Scalar()), {3, 4, 5, 7}),
                            whole(cv::Rect(3, 4, 5, 7))));
}

TEST(DepthMap, ShrinkingTakesTheSampleUnderEachPixelCentre) {
    cv::Mat depth(3, 9, CV_32FC1);
    for (int i = 0; i < 27; ++i)
        depth.at<float>(i / 9, i % 9) = static_cast<float>(i) / 27;
    const cv::Mat expected = (cv::Mat_<float>(1, 3) << depth.at<float>(1, 1), depth.at<float>(1, 4),
                              depth.at<float>(1, 7));
    EXPECT_TRUE(samePicture(fitted(depth, cv::Mat(1, 3, CV_8UC3, cv::Scalar())), expected));
    cv::Mat inPlace = depth.clone();
    fitDepth(inPlace, cv::Rect2d(0, 0, 9, 3), cv::Mat(1, 3, CV_8UC3, cv::Scalar()), inPlace);
    EXPECT_TRUE(samePicture(inPlace, expected));
}

TEST(DepthMap, AStepInDepthMovesToThePicturesEdge) {
    // 16 samples over 128 px: 8 px each. The true edge is at px 69, inside sample 8 (px 64..71);
    // the coarse depth can only say 64 or 72.
    constexpr int kEdge = 69;
    cv::Mat truth(64, 128, CV_32FC1, cv::Scalar(0.2));
    truth.colRange(kEdge, 128).setTo(0.8);
    cv::Mat guide(truth.size(), CV_8UC3, cv::Scalar(40, 60, 50));
    guide.colRange(kEdge, 128).setTo(cv::Scalar(180, 150, 200));
    for (const int coarseEdge : {8, 9}) {
        cv::Mat depth(8, 16, CV_32FC1, cv::Scalar(0.2));
        depth.colRange(coarseEdge, 16).setTo(0.8);
        cv::Mat bilinear;
        cv::resize(depth, bilinear, truth.size(), 0, 0, cv::INTER_LINEAR);
        const cv::Mat result = fitted(depth, guide);
        const double error = compare(result, truth).mean;
        EXPECT_LT(error, 0.25 * compare(bilinear, truth).mean) << coarseEdge;
        // The half-way value is crossed exactly at the edge.
        EXPECT_LT(result.at<float>(32, kEdge - 1), 0.5f) << coarseEdge;
        EXPECT_GT(result.at<float>(32, kEdge), 0.5f) << coarseEdge;
    }
}

TEST(DepthMap, ThreadsAndSubMatricesDoNotMatter) {
    const cv::Mat depth = randomPicture({64, 48}, CV_32FC1, 3, 0, 1);
    const cv::Mat guide = randomPicture({301, 211}, CV_8UC3, 4);
    const cv::Mat raw = randomPicture({1201, 997}, CV_32FC1, 4, -5, 5);
    expectSameForAnyThreads([&] { return fitted(depth, guide); });
    expectSameForAnyThreads([&] { return normalized(raw); });
    const cv::Mat part = depth(cv::Rect(3, 2, 11, 17));
    const cv::Mat photo = guide(cv::Rect(5, 7, 61, 67));
    EXPECT_TRUE(samePicture(normalized(part), normalized(part.clone())));
    EXPECT_TRUE(samePicture(fitted(part, photo), fitted(part.clone(), photo.clone())));
}

TEST(DepthMap, PartsOutsideTheDepthMapAreRefused) {
    const cv::Mat depth(8, 10, CV_32FC1, cv::Scalar(0.5));
    const cv::Mat guide(20, 20, CV_8UC3, cv::Scalar());
    for (const cv::Rect2d& part :
         {cv::Rect2d(-1, 0, 5, 5), cv::Rect2d(0, 0, 10.1, 8), cv::Rect2d(6, 0, 5, 5),
          cv::Rect2d(0, 0, -1, 4), cv::Rect2d(std::nan(""), 0, 5, 5)}) {
        cv::Mat result;
        const std::string said = errorOf([&] { fitDepth(depth, part, guide, result); });
        EXPECT_TRUE(startsWith(said, "part: is "));
        EXPECT_EQ(errorOf([&] { interpolateDepth(depth, part, guide.size(), result); }), said);
        EXPECT_TRUE(holds(said, "expected a part of the depth map of 10 x 8 px"));
    }
    EXPECT_EQ(errorOf([&] { fitted(depth, cv::Mat(3, 3, CV_8UC1)); }),
              "guide: is 3 x 3 px of CV_8UC1, expected CV_8UC3");
    EXPECT_EQ(errorOf([&] { fitted(cv::Mat(3, 3, CV_8UC1), guide); }),
              "depth: is 3 x 3 px of CV_8UC1, expected CV_32FC1");
}

// ---------------------------------------------------------------------------------------- RGB-D

constexpr DepthSide kSides[] = {DepthSide::Right, DepthSide::Left, DepthSide::Top,
                                DepthSide::Bottom};

cv::Mat joined(const cv::Mat& photo, const cv::Mat& depth, const RgbdLayout& layout) {
    cv::Mat picture;
    joinRgbd(photo, depth, layout, picture);
    return picture;
}

struct Halves {
    cv::Mat photo;
    cv::Mat depth;
    Notes notes;
};
Halves halvesOf(const cv::Mat& picture, const RgbdLayout& layout) {
    Halves halves;
    splitRgbd(picture, layout, halves.photo, halves.depth, &halves.notes);
    return halves;
}

cv::Mat floats(const cv::Mat& picture) {
    cv::Mat result;
    picture.convertTo(result, CV_32F);
    return result;
}

TEST(DepthMap, JoinedPicturesSplitIntoWhatTheyWereMadeOf) {
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 1), cv::Size(13, 7), cv::Size(6, 17)}) {
        const cv::Mat photo = randomPicture(size, CV_8UC3, 3);
        const cv::Mat depth = randomPicture(size, CV_32FC1, 4, 0, 1);
        cv::Mat bytes;
        depth.convertTo(bytes, CV_8U, 255);
        for (const DepthSide side : kSides) {
            const Halves again = halvesOf(joined(photo, depth, side), side);
            EXPECT_TRUE(samePicture(again.photo, photo));
            EXPECT_TRUE(samePicture(again.depth, floats(bytes)));
        }
    }
}

TEST(DepthMap, PhotoAndDepthAreJoinedInTheirPlace) {
    for (const DepthSide side : kSides) {
        for (const StereoHalves halves : {StereoHalves::Full, StereoHalves::Squeezed}) {
            const cv::Mat photo = randomPicture({20, 24}, CV_8UC3, 3);
            const cv::Mat depth = randomPicture({20, 24}, CV_32FC1, 4, 0, 1);
            cv::Mat apart;
            joinRgbd(photo, depth, {side, halves}, apart);
            cv::Mat place = photo.clone();
            joinRgbd(place, depth, {side, halves}, place);
            EXPECT_TRUE(samePicture(place, apart));
            place = depth.clone();
            joinRgbd(photo, place, {side, halves}, place);
            EXPECT_TRUE(samePicture(place, apart));
        }
    }
}

TEST(DepthMap, TheHalvesLieWhereTheSideSays) {
    cv::Mat picture(4, 5, CV_8UC3); // odd: the column in the middle belongs to neither
    for (int i = 0; i < 20; ++i)
        picture.at<cv::Vec3b>(i / 5, i % 5) = cv::Vec3b::all(static_cast<uchar>(10 * i));
    cv::Mat grey;
    cv::extractChannel(picture, grey, 0);
    const cv::Rect left(0, 0, 2, 4), right(3, 0, 2, 4), top(0, 0, 5, 2), bottom(0, 2, 5, 2);
    const std::tuple<DepthSide, cv::Rect, cv::Rect> cases[] = {{DepthSide::Right, left, right},
                                                               {DepthSide::Left, right, left},
                                                               {DepthSide::Top, bottom, top},
                                                               {DepthSide::Bottom, top, bottom}};
    for (const auto& [side, photo, depth] : cases) {
        const Halves halves = halvesOf(picture, side);
        EXPECT_TRUE(samePicture(halves.photo, picture(photo)));
        EXPECT_TRUE(samePicture(halves.depth, floats(grey(depth))));
    }
}

TEST(DepthMap, SqueezedHalvesOfRgbdAreStretched) {
    const cv::Mat whole = randomPhoto({32, 18}, 4); // of 16:9
    for (const DepthSide side : kSides) {
        const Halves narrow = halvesOf(whole, side);
        for (const StereoHalves halves : {StereoHalves::Squeezed, StereoHalves::Automatic}) {
            const Halves wide = halvesOf(whole, {side, halves});
            EXPECT_EQ(wide.photo.size(), whole.size());
            EXPECT_EQ(RgbdLayout(side, halves).photoSize(whole.size()), whole.size());
            cv::Mat expected; // numbers of the file, not means of two
            cv::resize(narrow.depth, expected, whole.size(), 0, 0, cv::INTER_NEAREST);
            EXPECT_TRUE(samePicture(wide.depth, expected));
            EXPECT_LT(cv::norm(cv::mean(wide.photo), cv::mean(narrow.photo)), 1);
        }
        EXPECT_TRUE(samePicture(halvesOf(whole, {side, StereoHalves::Full}).photo, narrow.photo));
        EXPECT_EQ(RgbdLayout(side).photoSize(whole.size()), narrow.photo.size());
    }
    EXPECT_EQ(halvesOf(randomPhoto({32, 30}, 4), {DepthSide::Right, StereoHalves::Automatic})
                  .photo.size(),
              cv::Size(16, 30));
}

TEST(DepthMap, TheGreyHalfOfAnRgbdImageIsFound) {
    const cv::Mat photo = randomPhoto({60, 40});
    cv::Mat ramp(photo.size(), CV_32FC1);
    for (int x = 0; x < ramp.cols; ++x)
        ramp.col(x).setTo(x / 59.0);
    cv::Mat map;
    ramp.convertTo(map, CV_8U, 255);
    cv::applyColorMap(map, map, cv::COLORMAP_TURBO);
    for (const DepthSide side : kSides) {
        cv::Mat picture = joined(photo, ramp, side);
        EXPECT_EQ(findDepthHalf(picture), side);
        EXPECT_EQ(findDepthHalf(picture, true), side);
        picture.convertTo(picture, CV_16U, 257);
        EXPECT_EQ(findDepthHalf(picture), side);
        picture = joined(inGrey(photo), ramp, side);
        const bool isBeside = side == DepthSide::Right || side == DepthSide::Left;
        const bool isLast = side == DepthSide::Right || side == DepthSide::Bottom;
        const cv::Point at(isBeside && isLast ? 60 : 0, !isBeside && isLast ? 40 : 0);
        map.copyTo(picture(cv::Rect(at, photo.size()))); // in colours beside a grey photo
        EXPECT_EQ(findDepthHalf(picture), side);
    }
    EXPECT_FALSE(findDepthHalf(randomPhoto({120, 40}))); // a photo
}

// A box and a ball before a wall, as wide as high.
struct GreyScene {
    cv::Mat photo;
    cv::Mat depth;
};
GreyScene greyScene(int side) {
    GreyScene scene = {inGrey(randomPhoto({side, side}, 6)), cv::Mat(side, side, CV_32FC1)};
    for (int y = 0; y < side; ++y)
        scene.depth.row(y).setTo(0.5 * y / side);
    const cv::Rect box(side / 6, side / 3, side / 4, side / 2);
    scene.depth(box).setTo(0.9);
    scene.photo(box) += cv::Scalar::all(120);
    const cv::Point centre(side * 2 / 3, side / 2);
    cv::circle(scene.depth, centre, side / 5, 0.7, cv::FILLED);
    cv::circle(scene.photo, centre, side / 5, cv::Scalar::all(30), cv::FILLED);
    return scene;
}

TEST(DepthMap, TheDepthHalfBesideAGreyPhotoIsFoundByItsEdges) {
    for (const int side : {80, 400}) {
        const GreyScene scene = greyScene(side);
        cv::Mat other; // smooth, but of another scene
        cv::flip(scene.depth, other, -1);
        for (const DepthSide at : kSides) {
            EXPECT_EQ(findDepthHalf(joined(scene.photo, scene.depth, at)), at);
            EXPECT_FALSE(findDepthHalf(joined(scene.photo, other, at)));
        }
        EXPECT_FALSE(findDepthHalf(scene.photo)); // grey photos
        cv::Mat sky(side, side, CV_32FC1);
        for (int y = 0; y < side; ++y)
            sky.row(y).setTo(0.3 + 0.6 * y / side);
        for (const DepthSide at : {DepthSide::Right, DepthSide::Top}) {
            cv::Mat picture = joined(scene.photo, sky, at);
            EXPECT_FALSE(findDepthHalf(picture));
            picture.row(0) = cv::Scalar(0, 0, 200); // a little colour
            EXPECT_FALSE(findDepthHalf(picture));
        }
    }
    for (const bool isStacked : {false, true})
        EXPECT_FALSE(findDepthHalf(cv::Mat(80, 120, CV_8UC3, cv::Scalar::all(0)), isStacked));
}

TEST(DepthMap, SixteenBitRgbdKeepsItsDepthValues) {
    const cv::Mat picture =
        (cv::Mat_<cv::Vec3w>(1, 4) << cv::Vec3w(0, 257, 65535), cv::Vec3w(128, 129, 385),
         cv::Vec3w::all(12345), cv::Vec3w::all(65535));
    const Halves halves = halvesOf(picture, DepthSide::Right);
    EXPECT_EQ(halves.photo.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 1, 255));
    EXPECT_EQ(halves.photo.at<cv::Vec3b>(0, 1), cv::Vec3b(0, 1, 1));
    EXPECT_TRUE(samePicture(halves.depth, row({12345, 65535})));
}

// What Depth-Anything's program writes: photo, white gap, depth.
TEST(DepthMap, AWhiteGapBetweenPhotoAndDepthIsLeftOut) {
    const cv::Mat photo = randomPicture({96, 64}, CV_8UC3, 3, 0, 200);
    const cv::Mat depth = randomPicture({96, 64}, CV_8UC1, 4, 20, 200);
    cv::Mat grey;
    cv::cvtColor(depth, grey, cv::COLOR_GRAY2BGR);
    for (const int width : {8, 50, 51}) {
        SCOPED_TRACE(width);
        const cv::Mat gap(64, width, CV_8UC3, cv::Scalar::all(255));
        cv::Mat picture;
        for (const DepthSide side : {DepthSide::Right, DepthSide::Left}) {
            const bool isRight = side == DepthSide::Right;
            cv::hconcat(std::vector<cv::Mat>{isRight ? photo : grey, gap, isRight ? grey : photo},
                        picture);
            const Halves again = halvesOf(picture, side);
            EXPECT_TRUE(samePicture(again.photo, photo));
            EXPECT_TRUE(samePicture(again.depth, floats(depth)));
            EXPECT_EQ(only(again.notes).text, "a white gap of " + std::to_string(width) +
                                                  " px between photo and depth is left out");
        }
    }
}

// A box on white: its far-white depth is white around it as well.
TEST(DepthMap, WhiteBordersOfPhotoAndDepthAreNoGap) {
    for (const int width : {60, 40}) {
        const cv::Rect box((100 - width) / 2, 20, width, 50);
        cv::Mat half(80, 100, CV_8UC3, cv::Scalar::all(255));
        half(cv::Rect(box.x - 8, 20, width, 50)).setTo(cv::Scalar::all(90));
        cv::Mat picture;
        cv::hconcat(half, half, picture);
        const Halves halves = halvesOf(picture, DepthSide::Right);
        EXPECT_EQ(halves.photo.size(), half.size());
        EXPECT_TRUE(halves.notes.empty());
    }
}

TEST(DepthMap, ColouredDepthHalvesAreUndone) {
    cv::Mat depth(64, 96, CV_8UC1);
    for (int y = 0; y < depth.rows; ++y)
        depth.row(y).setTo(20 + 3 * y);
    const cv::Mat photo = randomPicture({96, 64}, CV_8UC3, 3);
    cv::Mat colours;
    cv::applyColorMap(depth, colours, cv::COLORMAP_TURBO);
    cv::Mat picture;
    cv::hconcat(photo, colours, picture);
    for (const int times : {1, 257}) {
        cv::Mat deep = picture;
        if (times > 1) picture.convertTo(deep, CV_16U, times);
        const Halves again = halvesOf(deep, DepthSide::Right);
        EXPECT_TRUE(samePicture(again.photo, photo));
        EXPECT_TRUE(samePicture(again.depth, floats(depth) * times, times));
        EXPECT_TRUE(holds(only(again.notes).text, "turbo"));
    }
    EXPECT_EQ(only(halvesOf(picture, DepthSide::Left).notes).text,
              "the depth half has colours, and depth has none: their grey value is taken");
}

TEST(DepthMap, PicturesTooSmallToSplitAndUnequalHalvesAreRefused) {
    const auto problem = [](const cv::Mat& picture, DepthSide side) {
        return errorOf([&] { halvesOf(picture, side); });
    };
    EXPECT_EQ(problem(cv::Mat(5, 1, CV_8UC3), DepthSide::Left),
              "RGB-D image: is 1 x 5 px of CV_8UC3, too small to split, expected at least 2 px "
              "across");
    EXPECT_EQ(problem(cv::Mat(1, 5, CV_8UC3), DepthSide::Top),
              "RGB-D image: is 5 x 1 px of CV_8UC3, too small to split, expected at least 2 px "
              "down");
    EXPECT_EQ(problem(cv::Mat(4, 4, CV_8UC1), DepthSide::Top),
              "RGB-D image: is 4 x 4 px of CV_8UC1, expected three channels of 8 or 16 bits");
    EXPECT_EQ(errorOf([] { joined(cv::Mat(2, 3, CV_8UC3), cv::Mat(3, 2, CV_32FC1), {}); }),
              "depth: is 2 x 3 px of CV_32FC1, expected the photo's 3 x 2 px");
}

TEST(DepthMap, SqueezedHalvesAreReadBackAtTheirShape) {
    const cv::Mat photo = randomPhoto({40, 30}, 1);
    const cv::Mat depth = randomDepth({40, 30}, 2);
    for (const DepthSide side : {DepthSide::Right, DepthSide::Bottom}) {
        const RgbdLayout layout(side, StereoHalves::Squeezed);
        const cv::Mat picture = joined(photo, depth, layout);
        ASSERT_EQ(picture.size(), photo.size());
        const Halves again = halvesOf(picture, layout);
        ASSERT_EQ(again.photo.size(), photo.size());
        const bool isWide = side == DepthSide::Right;
        for (int y = 0; y < 30; ++y) {
            for (int x = 0; x < 40; ++x) { // depth of one of the two px that became one
                const float value = again.depth.at<float>(y, x) / 255;
                const float first = depth.at<float>(isWide ? y : y / 2 * 2, isWide ? x / 2 * 2 : x);
                const float other =
                    depth.at<float>(isWide ? y : y / 2 * 2 + 1, isWide ? x / 2 * 2 + 1 : x);
                EXPECT_LT(std::min(std::abs(value - first), std::abs(value - other)), 0.0021)
                    << x << ' ' << y;
            }
        }
        cv::Mat smooth;
        const cv::Size half = isWide ? cv::Size(20, 30) : cv::Size(40, 15);
        cv::resize(photo, smooth, half, 0, 0, cv::INTER_AREA);
        EXPECT_TRUE(samePicture(picture(cv::Rect({0, 0}, half)), smooth));
    }
}

TEST(DepthMap, BentDepthIsAPower) {
    for (const double exponent : {0.5, 0.8, 1.3, 2.0}) {
        cv::Mat depth(1, 1001, CV_32FC1);
        for (int x = 0; x <= 1000; ++x)
            depth.at<float>(x) = static_cast<float>(x) / 1000;
        const cv::Mat bent = bendDepth(depth, exponent);
        for (int x = 0; x <= 1000; ++x)
            EXPECT_NEAR(bent.at<float>(x), std::pow(x / 1000.0, exponent), 1e-5) << x;
    }
    const cv::Mat ends = bendDepth(row({-1, 0, 1, 7, kNan, 1e-30F}), 0.5);
    EXPECT_TRUE(samePicture(ends.colRange(0, 5), row({0, 0, 1, 1, kNan})));
    EXPECT_GE(ends.at<float>(5), 0);
    EXPECT_TRUE(samePicture(bendDepth(row({0.25F}), 1), row({0.25F})));
    EXPECT_EQ(errorOf([] { return bendDepth(row({0}), 3); }), "exponent: is 3, expected 0.5..2");
}

TEST(DepthMap, SixteenBitPicturesSpanZeroToOne) {
    const cv::Mat expected = (cv::Mat_<ushort>(1, 6) << 0, 0, 32768, 65535, 65535, 0);
    EXPECT_TRUE(samePicture(depthTo16Bit(row({-1, 0, 0.5f, 1, 7, kNan})), expected));
}

} // namespace
} // namespace altiro3D::test
