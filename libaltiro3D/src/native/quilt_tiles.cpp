#include "native/quilt_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

// Sums are of whole numbers or of doubles in a fixed order, as quilt_search.cpp says.

namespace altiro3D {

namespace {

constexpr double kFeature = 32; // size of a feature at the local contrast

// The mean of each of `count` equal parts of a row of `length` samples; parts need not be whole.
template <class Sample>
void averageParts(const Sample* row, int length, int count, std::vector<double>& sums,
                  double* means) {
    sums.resize(static_cast<std::size_t>(length) + 1);
    sums[0] = 0;
    for (int i = 0; i < length; ++i)
        sums[static_cast<std::size_t>(i) + 1] = sums[static_cast<std::size_t>(i)] + row[i];
    const auto sumTo = [&](double place) {
        const int whole = std::min(static_cast<int>(place), length - 1);
        return sums[static_cast<std::size_t>(whole)] + (place - whole) * row[whole];
    };
    const double part = static_cast<double>(length) / count;
    double before = 0;
    for (int i = 0; i < count; ++i) {
        const double to =
            i + 1 < count ? sumTo((i + 1) * part) : sums[static_cast<std::size_t>(length)];
        means[i] = (to - before) / part;
        before = to;
    }
}

// What a tile shows, whatever its brightness and contrast: (v - mean) / (deviation + kNoise), mean
// and deviation of the window around the px, as far as it lies in the tile.
void findFeatures(const Grey& tile, int radius, Features& features) {
    const int rows = tile.rows;
    const int cols = tile.cols;
    cv::Mat_<double> sums; // whole numbers
    cv::Mat_<double> squares;
    cv::integral(tile, sums, squares, CV_64F, CV_64F);
    for (int y = 0; y < rows; ++y) {
        const int top = std::max(0, y - radius);
        const int bottom = std::min(rows, y + radius + 1);
        for (int x = 0; x < cols; ++x) {
            const int left = std::max(0, x - radius);
            const int right = std::min(cols, x + radius + 1);
            const double count = (bottom - top) * (right - left);
            const auto windowSum = [&](const cv::Mat_<double>& of) {
                return of[bottom][right] - of[bottom][left] - of[top][right] + of[top][left];
            };
            const double mean = windowSum(sums) / count;
            const double variance = std::max(0.0, windowSum(squares) / count - mean * mean);
            const double value =
                kFeature * (tile(y, x) - mean) / (std::sqrt(variance) + kNoise * kUnit);
            features(y, x) = static_cast<std::int16_t>(std::lround(value));
        }
    }
}

} // namespace

template <class Sample>
Grey scaleRows(const cv::Mat_<Sample>& picture, int width, double factor) {
    Grey scaled(picture.rows, width);
    std::vector<double> sums;
    std::vector<double> means(static_cast<std::size_t>(width));
    for (int y = 0; y < picture.rows; ++y) {
        averageParts(picture[y], picture.cols, width, sums, means.data());
        for (int x = 0; x < width; ++x) {
            scaled(y, x) =
                static_cast<std::uint16_t>(means[static_cast<std::size_t>(x)] * factor + 0.5);
        }
    }
    return scaled;
}

template Grey scaleRows(const cv::Mat_<std::uint8_t>& picture, int width, double factor);
template Grey scaleRows(const cv::Mat_<std::uint16_t>& picture, int width, double factor);

Tiles::Tiles(const Grey& picture, cv::Size size, int radius) : size_(size) {
    const int columns = picture.cols / size.width;
    const int rows = picture.rows / size.height;
    for (int row = rows - 1; row >= 0; --row) { // in the order of the views
        for (int column = 0; column < columns; ++column) {
            Features features(size);
            findFeatures(
                picture(cv::Rect(column * size.width, row * size.height, size.width, size.height)),
                radius, features);
            std::vector<std::int64_t> energy(static_cast<std::size_t>(size.width));
            for (int y = 0; y < size.height; ++y) {
                for (int x = 0; x < size.width; ++x) {
                    const std::int64_t v = features(y, x);
                    energy[static_cast<std::size_t>(x)] += v * v;
                }
            }
            features_.push_back(features);
            energy_.push_back(std::move(energy));
        }
    }
}

double Tiles::likeness(const std::vector<std::pair<int, int>>& pairs, cv::Range shifts) const {
    double best = -1;
    for (int shift = shifts.start; shift < shifts.end; ++shift) {
        std::int64_t product = 0;
        std::int64_t first = 0;
        std::int64_t second = 0;
        const int begin = std::max(0, shift);
        const int end = size_.width + std::min(0, shift);
        for (const auto& [a, b] : pairs) {
            const Features& from = features_[static_cast<std::size_t>(a)];
            const Features& to = features_[static_cast<std::size_t>(b)];
            for (int y = 0; y < size_.height; ++y) {
                const std::int16_t* left = from[y];
                const std::int16_t* right = to[y];
                std::int32_t sum = 0;
                for (int x = begin; x < end; ++x)
                    sum += left[x] * right[x - shift];
                product += sum;
            }
            const auto energyOf = [&](int tile, int offset) {
                const auto& energy = energy_[static_cast<std::size_t>(tile)];
                std::int64_t sum = 0;
                for (int x = begin; x < end; ++x)
                    sum += energy[static_cast<std::size_t>(x - offset)];
                return sum;
            };
            first += energyOf(a, 0);
            second += energyOf(b, shift);
        }
        const double norm =
            std::sqrt(static_cast<double>(first)) * std::sqrt(static_cast<double>(second));
        if (norm > 0) best = std::max(best, static_cast<double>(product) / norm);
    }
    return best;
}

double Tiles::detail() const {
    cv::Mat_<double> mean(size_, 0.0);
    for (const Features& features : features_) {
        for (int y = 0; y < size_.height; ++y) {
            for (int x = 0; x < size_.width; ++x)
                mean(y, x) += features(y, x);
        }
    }
    cv::Mat_<double> values;
    cv::SVD::compute(mean, values, cv::SVD::NO_UV);
    double all = 0;
    double rest = 0;
    for (int i = 0; i < values.rows; ++i) {
        const double energy = values(i, 0) * values(i, 0);
        all += energy;
        if (i >= 2) rest += energy;
    }
    return all > 0 ? rest / all : 0;
}

} // namespace altiro3D
