#include "image/orientation.hpp"

#include <algorithm>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

// cv::rotate() by a quarter turn, in bands that fit into the cache and on all threads.
void turn(const cv::Mat& picture, bool clockwise, cv::Mat& result) {
    constexpr int kBandRows = 64;
    result.create(picture.cols, picture.rows, picture.type());
    const int bands = (result.rows + kBandRows - 1) / kBandRows;
    cv::parallel_for_(cv::Range(0, bands), [&](const cv::Range& range) {
        for (int band = range.start; band < range.end; ++band) {
            const cv::Range to(band * kBandRows, std::min((band + 1) * kBandRows, result.rows));
            const cv::Range from =
                clockwise ? to : cv::Range(picture.cols - to.end, picture.cols - to.start);
            cv::Mat rows = result.rowRange(to);
            cv::rotate(picture.colRange(from), rows,
                       clockwise ? cv::ROTATE_90_CLOCKWISE : cv::ROTATE_90_COUNTERCLOCKWISE);
        }
    });
}

} // namespace

cv::Mat upright(const cv::Mat& picture, int orientation) {
    cv::Mat result;
    switch (orientation) { // EXIF: the sides on which row 0 and column 0 of the file appear
    case 2:
        cv::flip(picture, result, 1);
        return result; // top, right
    case 3:
        cv::flip(picture, result, -1);
        return result; // bottom, right
    case 4:
        cv::flip(picture, result, 0);
        return result; // bottom, left
    case 5:
        cv::transpose(picture, result);
        return result; // left, top
    case 6:
        turn(picture, true, result);
        return result; // right, top
    case 7:            // right, bottom
        cv::transpose(picture, result);
        cv::flip(result, result, -1);
        return result;
    case 8:
        turn(picture, false, result);
        return result;
    default:
        return picture;
    }
}

} // namespace altiro3D
