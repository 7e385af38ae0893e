#include "video/motion/motion.hpp"

#include "base/state_bytes.hpp"
#include "image/pixel_values.hpp"

#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

namespace {

// Grey levels added to both pictures for gains, so dark, noisy cells have little weight.
constexpr float kBlack = 8;

// Brightness of `now` relative to `before`: the median over cells of 4 x 4 px.
float gainBetween(const cv::Mat& before, const cv::Mat& now) {
    const cv::Mat a = halved(halved(before));
    const cv::Mat b = halved(halved(now));
    std::vector<float> ratios;
    ratios.reserve(a.total());
    for (int y = 0; y < a.rows; ++y) {
        const uchar* rowA = a.ptr(y);
        const uchar* rowB = b.ptr(y);
        for (int x = 0; x < a.cols; ++x)
            ratios.push_back((static_cast<float>(rowB[x]) + kBlack) /
                             (static_cast<float>(rowA[x]) + kBlack));
    }
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return std::clamp(*middle, 0.5F, 2.0F);
}

cv::Mat brightened(const cv::Mat& grey, float gain) {
    cv::Mat table(1, 256, CV_8UC1);
    for (int i = 0; i < table.cols; ++i) {
        const float value = gain * (static_cast<float>(i) + kBlack) - kBlack;
        table.at<uchar>(i) = static_cast<uchar>(std::clamp(std::lround(value), 0L, 255L));
    }
    cv::Mat result;
    cv::LUT(grey, table, result);
    return result;
}

// Where the centres of `count` px are among `values` px of the same length.
std::vector<Between> places(int count, int values) {
    const float scale = static_cast<float>(values) / static_cast<float>(count);
    std::vector<Between> result(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i)
        result[static_cast<std::size_t>(i)] =
            between((static_cast<float>(i) + 0.5F) * scale - 0.5F, values);
    return result;
}

// Standard deviation of grey levels below which a picture is blank.
constexpr double kBlank = 3;

// Standard deviation of a picture's brightness.
double contrastOf(const cv::Mat& grey) {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(grey, mean, deviation);
    return deviation[0];
}

} // namespace

cv::Mat halved(const cv::Mat& grey) {
    cv::Mat half((grey.rows + 1) / 2, (grey.cols + 1) / 2, CV_8UC1);
    for (int y = 0; y < half.rows; ++y) {
        const uchar* above = grey.ptr(2 * y);
        const uchar* below = grey.ptr(std::min(2 * y + 1, grey.rows - 1));
        uchar* out = half.ptr(y);
        for (int x = 0; x < half.cols; ++x) {
            const int left = 2 * x;
            const int right = std::min(left + 1, grey.cols - 1);
            out[x] = static_cast<uchar>(
                (above[left] + above[right] + below[left] + below[right] + 2) / 4);
        }
    }
    return half;
}

cv::Mat matchedBrightness(const cv::Mat& grey, const cv::Mat& now) {
    return brightened(grey, gainBetween(grey, now));
}

cv::Mat joinMotion(const cv::Mat& earlier, const cv::Mat& later) {
    CV_Assert(earlier.size() == later.size());
    cv::Mat joined(later.size(), CV_32FC2);
    for (int y = 0; y < later.rows; ++y) {
        const auto* same = earlier.ptr<cv::Vec2f>(y);
        const auto* last = later.ptr<cv::Vec2f>(y);
        auto* out = joined.ptr<cv::Vec2f>(y);
        for (int x = 0; x < later.cols; ++x) {
            if (isStill(last[x])) {
                out[x] = same[x];
                continue;
            }
            const Between right = between(static_cast<float>(x) + last[x][0], earlier.cols);
            const Between down = between(static_cast<float>(y) + last[x][1], earlier.rows);
            out[x] = last[x] + sampled<cv::Vec2f>(earlier, right, down);
        }
    }
    return joined;
}

void carry(const cv::Mat& before, const cv::Mat& motion, cv::Mat& moved) {
    CV_Assert(moved.data != before.data || before.empty());
    moved.create(before.size(), CV_32FC1);
    const float perX = static_cast<float>(motion.cols) / static_cast<float>(before.cols);
    const float perY = static_cast<float>(motion.rows) / static_cast<float>(before.rows);
    const std::vector<Between> columns = places(before.cols, motion.cols);
    cv::parallel_for_(cv::Range(0, before.rows), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            const Between down = between((static_cast<float>(y) + 0.5F) * perY - 0.5F, motion.rows);
            const auto* same = before.ptr<float>(y);
            auto* out = moved.ptr<float>(y);
            for (int x = 0; x < before.cols; ++x) {
                const auto vector =
                    sampled<cv::Vec2f>(motion, columns[static_cast<std::size_t>(x)], down);
                if (isStill(vector)) {
                    out[x] = same[x];
                    continue;
                }
                out[x] = sampled<float>(
                    before, between(static_cast<float>(x) + vector[0] / perX, before.cols),
                    between(static_cast<float>(y) + vector[1] / perY, before.rows));
            }
        }
    });
}

cv::Mat stretched(const cv::Mat& values, int rows, int cols) {
    cv::Mat result(rows, cols, CV_32FC1);
    const float perY = static_cast<float>(values.rows) / static_cast<float>(rows);
    const std::vector<Between> columns = places(cols, values.cols);
    for (int y = 0; y < rows; ++y) {
        const Between down = between((static_cast<float>(y) + 0.5F) * perY - 0.5F, values.rows);
        auto* out = result.ptr<float>(y);
        for (int x = 0; x < cols; ++x) {
            out[x] = sampled<float>(values, columns[static_cast<std::size_t>(x)], down);
        }
    }
    return result;
}

cv::Mat misfit(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion) {
    CV_Assert(before.size() == now.size());
    cv::Mat moved(now.size(), CV_8UC1);
    for (int y = 0; y < now.rows; ++y) {
        const uchar* same = before.ptr(y);
        const auto* vector = motion.ptr<cv::Vec2f>(y);
        uchar* out = moved.ptr(y);
        for (int x = 0; x < now.cols; ++x) {
            if (isStill(vector[x])) {
                out[x] = same[x];
                continue;
            }
            const Between right = between(static_cast<float>(x) + vector[x][0], before.cols);
            const Between down = between(static_cast<float>(y) + vector[x][1], before.rows);
            const uchar* above = before.ptr(down.low);
            const uchar* below = before.ptr(down.high);
            const auto mix = [](uchar a, uchar b, float share) {
                return mixed(static_cast<float>(a), static_cast<float>(b), share);
            };
            out[x] = static_cast<uchar>(mixed(mix(above[right.low], above[right.high], right.share),
                                              mix(below[right.low], below[right.high], right.share),
                                              down.share) +
                                        0.5F);
        }
    }
    cv::Mat difference;
    cv::absdiff(matchedBrightness(moved, now), now, difference);
    cv::Mat result;
    cv::boxFilter(difference, result, CV_32F, cv::Size(3, 3), cv::Point(-1, -1), false,
                  cv::BORDER_REPLICATE);
    for (int y = 0; y < result.rows; ++y) {
        auto* row = result.ptr<float>(y);
        for (int x = 0; x < result.cols; ++x)
            row[x] /= 9;
    }
    return result;
}

double dissimilarity(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion,
                     const cv::Mat& misfits) {
    constexpr double kNoise = 4;      // grey levels; uniform pictures differ only by noise
    constexpr float kWild = 3;        // px from one cell to the next
    constexpr double kWildShare = .5; // weight of wild motion relative to the misfit
    double sum = 0;
    int pairs = 0;
    int wild = 0;
    for (int y = 0; y < now.rows; ++y) {
        const auto* row = misfits.ptr<float>(y);
        for (int x = 0; x < now.cols; ++x)
            sum += static_cast<double>(row[x]);
        if (y % kMotionCell != 0 || y + kMotionCell >= now.rows) continue;
        const auto* vectors = motion.ptr<cv::Vec2f>(y);
        const auto* below = motion.ptr<cv::Vec2f>(y + kMotionCell);
        const auto differ = [](const cv::Vec2f& a, const cv::Vec2f& b) {
            const cv::Vec2f d = a - b;
            return d[0] * d[0] + d[1] * d[1] > kWild * kWild;
        };
        for (int x = 0; x + kMotionCell < now.cols; x += kMotionCell, pairs += 2) {
            wild += static_cast<int>(differ(vectors[x], vectors[x + kMotionCell]));
            wild += static_cast<int>(differ(vectors[x], below[x]));
        }
    }
    const double contrast = std::min(contrastOf(before), contrastOf(now));
    const double wildness = pairs == 0 ? 0.0 : static_cast<double>(wild) / pairs;
    return sum / static_cast<double>(now.total()) / (kNoise + contrast) + kWildShare * wildness;
}

std::uint64_t pictureHash(const cv::Mat& picture) {
    const std::size_t rowBytes = static_cast<std::size_t>(picture.cols) * picture.elemSize();
    std::vector<std::uint64_t> rows(static_cast<std::size_t>(picture.rows));
    cv::parallel_for_(cv::Range(0, picture.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            const char* row = reinterpret_cast<const char*>(picture.ptr(y));
            rows[static_cast<std::size_t>(y)] = checksum({row, rowBytes});
        }
    });
    std::uint64_t total = 0;
    for (const std::uint64_t row : rows)
        total = mixIn(total, row);
    return total;
}

bool areEqual(const cv::Mat& a, const cv::Mat& b) {
    return a.size() == b.size() && a.type() == b.type() && a.isContinuous() && b.isContinuous() &&
           std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

PictureTracker::Step PictureTracker::next(const cv::Mat& picture) {
    Step step;
    const std::uint64_t hash = pictureHash(picture);
    const bool sameSize = picture.rows == rows_ && picture.cols == cols_;
    step.repeated = sameSize && hash == hash_;
    if (step.repeated) return step;
    hash_ = hash;
    rows_ = picture.rows;
    cols_ = picture.cols;

    const cv::Mat grey = brightnessOf(downscale(picture, kSmallSide));
    step.cut = !sameSize;
    step.blank = sameSize && contrastOf(grey) < kBlank;
    if (step.blank) return step;
    if (!step.cut) {
        findMotion(grey_, grey, step.motion);
        const cv::Mat misfits = misfit(grey_, grey, step.motion);
        step.cut = dissimilarity(grey_, grey, step.motion, misfits) > kNewScene;
    }
    if (step.cut) step.motion = cv::Mat();
    grey_ = grey;
    return step;
}

void PictureTracker::save(std::string& bytes) const {
    append(bytes, static_cast<std::uint64_t>(rows_));
    append(bytes, static_cast<std::uint64_t>(cols_));
    append(bytes, hash_);
    append(bytes, grey_);
}

bool PictureTracker::load(std::string_view& bytes) {
    std::uint64_t rows = 0;
    std::uint64_t cols = 0;
    constexpr std::uint64_t kMax = std::numeric_limits<int>::max();
    if (!take(bytes, rows) || !take(bytes, cols) || !take(bytes, hash_) ||
        !take(bytes, CV_8UC1, grey_)) {
        return false;
    }
    if (rows > kMax || cols > kMax || (rows == 0) != (cols == 0)) return false;
    rows_ = static_cast<int>(rows);
    cols_ = static_cast<int>(cols);
    // The grey copy of the next picture has that size and is compared with it px by px.
    return grey_.size() == downscaledSize({cols_, rows_}, kSmallSide);
}

} // namespace altiro3D
