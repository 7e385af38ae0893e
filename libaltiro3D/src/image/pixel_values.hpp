#pragma once

#include "base/pixel_rows.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

/// The value with a rank, 0 = the smallest. Reorders the values.
template <typename T>
T valueOfRank(std::vector<T>& values, std::size_t rank) {
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

/// The value at a share of the sorted values, 0 = the smallest, 1 = the largest; 0 if none.
template <typename T>
T percentileOf(std::vector<T> values, double share) {
    if (values.empty()) return 0;
    const double rank = share * static_cast<double>(values.size() - 1);
    return valueOfRank(values, static_cast<std::size_t>(rank));
}

/// Converts 16 to 8 bits: v / 257, rounded, so 0 and 65535 become 0 and 255.
inline std::uint8_t toEightBits(std::uint16_t value) {
    return static_cast<std::uint8_t>((value + 128u) / 257u);
}

/// Converts a 16-bit picture to 8 bits. [rows x cols, CV_16UCn -> CV_8UCn]
inline cv::Mat toEightBits(const cv::Mat& picture) {
    return mapped<std::uint16_t, std::uint8_t>(
        picture, [](std::uint16_t value) { return toEightBits(value); });
}

/// Converts 0..1 (clamped, NaN is 0) to a whole number 0..largest, rounded.
template <typename T>
T toWhole(float value, float largest) {
    const float inRange = value > 0 ? (value < 1 ? value : 1.0f) : 0.0f;
    return static_cast<T>(inRange * largest + 0.5f);
}

/// OpenCV's grey of a picture. [rows x cols, CV_8UC3 -> CV_8UC1]
inline cv::Mat greyOf(const cv::Mat& picture) {
    cv::Mat grey;
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    return grey;
}

/// Rec. 601 luma of a px, BGR, in whole numbers.
inline std::uint8_t brightnessOf(const std::uint8_t* bgr) {
    return static_cast<std::uint8_t>((29 * bgr[0] + 150 * bgr[1] + 77 * bgr[2] + 128) / 256);
}

/// Rec. 601 luma of a picture in whole numbers. [rows x cols, CV_8UC3 -> CV_8UC1]
inline cv::Mat brightnessOf(const cv::Mat& picture) {
    cv::Mat result(picture.size(), CV_8UC1);
    for (int y = 0; y < picture.rows; ++y) {
        const std::uint8_t* from = picture.ptr(y);
        std::uint8_t* const to = result.ptr(y);
        for (int x = 0; x < picture.cols; ++x, from += 3)
            to[x] = brightnessOf(from);
    }
    return result;
}

/// The grey values of a picture: the value itself where the channels agree, else Rec. 601 luma.
/// @param picture [rows x cols, 3 channels of T, BGR] @return [CV_32FC1]
template <typename T>
cv::Mat greyValues(const cv::Mat& picture) {
    cv::Mat result(picture.size(), CV_32FC1);
    for (int y = 0; y < picture.rows; ++y) {
        const T* bgr = picture.ptr<T>(y);
        for (int x = 0; x < picture.cols; ++x, bgr += 3) {
            const double blue = static_cast<double>(bgr[0]);
            const double green = static_cast<double>(bgr[1]);
            const double red = static_cast<double>(bgr[2]);
            const bool isGrey = blue == green && green == red;
            result.ptr<float>(y)[x] =
                static_cast<float>(isGrey ? green : 0.114 * blue + 0.587 * green + 0.299 * red);
        }
    }
    return result;
}

/// The size of downscale()'s result. @param size >= 1 px a side @param longestSide >= 1
cv::Size downscaledSize(cv::Size size, int longestSide);

/// The photo's area average with at most `longestSide` px per side; a copy if it is small enough.
/// It uses whole numbers only, so the result is exact on any processor and for any number of
/// threads. The mirrored photo gives the mirrored result.
/// @param photo [rows x cols, CV_8UC3] @param longestSide >= 1 @return [CV_8UC3]
cv::Mat downscale(const cv::Mat& photo, int longestSide);

} // namespace altiro3D
