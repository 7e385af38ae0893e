#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

/// Padding at the end of rows for kernels, so whole vectors can be read and written.
constexpr std::size_t kRowPadding = 64;

/// A row of `count` zeros, padded.
template <class T>
std::vector<T> paddedRow(std::size_t count) {
    return std::vector<T>(count + kRowPadding);
}

/// Calls work(row) for the rows 0..rows-1, on all threads.
template <class Work>
void overRows(int rows, const Work& work) {
    cv::parallel_for_(cv::Range(0, rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y)
            work(y);
    });
}

/// Calls body(range) for parts of 0..rows-1, on all threads. Unlike overRows(), it makes few parts,
/// because `body` prepares what its rows need once per part.
inline void forRows(int rows, const std::function<void(const cv::Range&)>& body) {
    constexpr int kPartsPerThread = 8;
    cv::parallel_for_(cv::Range(0, rows), body, kPartsPerThread * cv::getNumThreads());
}

/// Rows of a band of a picture that is too large for memory: some MB.
inline int rowsInBand(int columns, int rows) {
    constexpr int kBandBytes = 1 << 23;
    return std::min(rows, std::max(64, kBandBytes / (3 * columns)));
}

/// The picture of function(sample) for all samples, on all threads.
/// @tparam From type of the samples @tparam To type of the result's samples
template <class From, class To, class Function>
cv::Mat mapped(const cv::Mat& picture, const Function& function) {
    cv::Mat result(picture.size(), CV_MAKETYPE(cv::DataType<To>::depth, picture.channels()));
    overRows(picture.rows, [&](int y) {
        const From* const from = picture.ptr<From>(y);
        std::transform(from, from + picture.cols * picture.channels(), result.ptr<To>(y), function);
    });
    return result;
}

/// On a side of `samples` px, the pixel under the centre of pixel `index` of a side of `count` px:
/// floor((index + 0.5) / count * samples), exact.
inline int nearestSample(int index, int count, int samples) {
    return static_cast<int>((2 * std::int64_t{index} + 1) * samples / (2 * std::int64_t{count}));
}

/// Values of columns for the pixels that show them: out[i] = values[columns[i]]. Reads up to
/// kRowPadding values beyond the last column.
/// @param columns of `count` pixels, in order (ascending or descending)
void pickColumns(const std::int32_t* columns, std::size_t count, const float* values, float* out);
/// The same for values that fit into 16 bits.
void pickColumns(const std::int32_t* columns, std::size_t count, const std::int32_t* values,
                 std::int16_t* out);

/// Planes to B G R pixels. Reads up to kRowPadding beyond `count`, writes 3 * count bytes.
void interleaveRow(const std::uint8_t* blue, const std::uint8_t* green, const std::uint8_t* red,
                   std::size_t count, std::uint8_t* bgr);

/// B G R pixels to planes. Reads 3 * count bytes, writes `count` bytes per plane.
void splitRow(const std::uint8_t* bgr, std::size_t count, std::uint8_t* blue, std::uint8_t* green,
              std::uint8_t* red);

} // namespace altiro3D
