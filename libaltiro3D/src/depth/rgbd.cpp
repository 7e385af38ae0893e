// Photo and depth in one picture: splitRgbd() and joinRgbd() of depth_map.hpp.

#include "altiro3D/depth_map.hpp"
#include "base/checks.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

namespace altiro3D {

namespace {

bool isBeside(DepthSide side) {
    return side == DepthSide::Right || side == DepthSide::Left;
}

// Rectangles of the halves, from the size of a half and of the whole.
struct Halves {
    cv::Rect photo;
    cv::Rect depth;
};
Halves halvesOf(DepthSide side, cv::Size half, cv::Size whole) {
    const cv::Rect first(cv::Point(0, 0), half);
    const cv::Rect last(cv::Point(whole.width - half.width, whole.height - half.height), half);
    const bool isDepthLast = side == DepthSide::Right || side == DepthSide::Bottom;
    return isDepthLast ? Halves{first, last} : Halves{last, first};
}

template <typename T>
void greyOf(const cv::Mat& bgr, cv::Mat& grey) {
    for (int y = 0; y < bgr.rows; ++y)
        greyRow(bgr.ptr<T>(y), grey.ptr<float>(y), bgr.cols);
}

} // namespace

void splitRgbd(const cv::Mat& picture, DepthSide side, cv::Mat& photo, cv::Mat& rawDepth) {
    checkType(picture, {CV_8UC3, CV_16UC3}, "RGB-D image", "three channels of 8 or 16 bits");
    const cv::Mat source = picture;
    const cv::Size half(isBeside(side) ? source.cols / 2 : source.cols,
                        isBeside(side) ? source.rows : source.rows / 2);
    check(!half.empty(), "RGB-D image",
          shapeText(source) + ", too small to split, expected at least 2 px " +
              (isBeside(side) ? "across" : "down"));
    const Halves halves = halvesOf(side, half, source.size());
    const cv::Mat photoHalf = source(halves.photo);
    const cv::Mat depthHalf = source(halves.depth);
    rawDepth.create(half, CV_32FC1);
    photo.create(half, CV_8UC3);
    if (source.depth() == CV_8U) {
        greyOf<std::uint8_t>(depthHalf, rawDepth);
        photoHalf.copyTo(photo);
    } else {
        greyOf<std::uint16_t>(depthHalf, rawDepth);
        for (int y = 0; y < half.height; ++y) {
            const std::uint16_t* from = photoHalf.ptr<std::uint16_t>(y);
            std::transform(from, from + 3 * half.width, photo.ptr<std::uint8_t>(y),
                           [](std::uint16_t value) { return toEightBits(value); });
        }
    }
}

void joinRgbd(const cv::Mat& photo, const cv::Mat& depth, DepthSide side, cv::Mat& picture) {
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3");
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    check(photo.size() == depth.size(), "depth",
          shapeText(depth) + ", expected the photo's " + std::to_string(photo.cols) + " x " +
              std::to_string(photo.rows) + " px");
    const cv::Size half = photo.size();
    const cv::Size whole(isBeside(side) ? 2 * half.width : half.width,
                         isBeside(side) ? half.height : 2 * half.height);
    const Halves halves = halvesOf(side, half, whole);
    const cv::Mat first = photo; // keeps the samples if photo and picture are the same object
    picture.create(whole, CV_8UC3);
    first.copyTo(picture(halves.photo));
    for (int y = 0; y < half.height; ++y) {
        const float* from = depth.ptr<float>(y);
        std::uint8_t* to = picture.ptr<std::uint8_t>(halves.depth.y + y) + 3 * halves.depth.x;
        for (int x = 0; x < half.width; ++x, to += 3) {
            std::fill_n(to, 3, toWhole<std::uint8_t>(from[x], 255.0f));
        }
    }
}

} // namespace altiro3D
