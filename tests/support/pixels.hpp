#pragma once

#include <opencv2/core.hpp>

namespace altiro3D::test {

/// Calls use(x, y) for all px of a picture, row by row.
template <class Use>
void forPixels(cv::Size size, const Use& use) {
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x)
            use(x, y);
}

/// A picture of value(x, y). @tparam T type of a px, as float for depth
template <class T, class Value>
cv::Mat pictureOf(cv::Size size, const Value& value) {
    cv::Mat_<T> picture(size);
    forPixels(size, [&](int x, int y) { picture(y, x) = static_cast<T>(value(x, y)); });
    return std::move(picture);
}

} // namespace altiro3D::test
