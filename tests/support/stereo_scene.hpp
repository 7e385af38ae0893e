#pragma once

#include "support/random_pictures.hpp"

#include <opencv2/core.hpp>

namespace altiro3D::test {

/// The pictures of two eyes.
struct Eyes {
    cv::Mat left;
    cv::Mat right;
};

/// Size of wallAndThing().
inline cv::Size eyesSize() {
    return {400, 300};
}

/// Where the left eye sees the thing of wallAndThing().
inline cv::Rect thingInLeft() {
    return {150, 90, 120, 110};
}

/// A dark wall, and before it a bright thing, both full of detail. The point at x of the left
/// picture is at x - disparity of the right one.
/// @param wall, thing their disparities in whole px
inline Eyes wallAndThing(int wall, int thing) {
    constexpr int kMargin = 150;
    const cv::Size size = eyesSize();
    cv::Mat behind = randomPhoto({size.width + 2 * kMargin, size.height}, 5);
    cv::Mat before = randomPhoto(thingInLeft().size(), 6);
    behind.convertTo(behind, -1, 0.4, 0);
    before.convertTo(before, -1, 0.4, 150);
    Eyes eyes;
    eyes.left = behind.colRange(kMargin, kMargin + size.width).clone();
    eyes.right = behind.colRange(kMargin + wall, kMargin + wall + size.width).clone();
    before.copyTo(eyes.left(thingInLeft()));
    before.copyTo(eyes.right(thingInLeft() - cv::Point(thing, 0)));
    return eyes;
}

/// A ceiling: what is higher is nearer, as if near and far of a floor were exchanged. It is darker.
inline Eyes ceiling() {
    constexpr int kMargin = 60;
    const cv::Size size = eyesSize();
    cv::Mat behind = randomPhoto({size.width + kMargin, size.height}, 5);
    for (int y = 0; y < size.height; ++y)
        behind.row(y) *= 0.25 + 0.75 * y / size.height;
    Eyes eyes{behind.colRange(0, size.width).clone(), cv::Mat(size, behind.type())};
    for (int y = 0; y < size.height; ++y) {
        const int disparity = 40 * (size.height - y) / size.height;
        behind.row(y).colRange(disparity, disparity + size.width).copyTo(eyes.right.row(y));
    }
    return eyes;
}

} // namespace altiro3D::test
