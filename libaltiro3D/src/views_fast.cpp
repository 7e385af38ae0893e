#include "views_fast.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

// Few enough rows that map and pixels stay in the second-level cache.
constexpr int kRowsAtATime = 16;

// Reads one row of depth, writes one row of map; bound by arithmetic.
void mapRow(const float* depth, int width, double shiftPixels, double focus, float* mapX) {
    const double right = width - 1;
    for (int x = 0; x < width; ++x) {
        double d = depth[x];
        d = d > 0 ? (d < 1 ? d : 1) : 0; // NaN compares false: 0
        const double place = x + shiftPixels * (d - focus);
        mapX[x] = static_cast<float>(std::min(std::max(place, 0.0), right));
    }
}

} // namespace

void renderFast(const cv::Mat& photo, const cv::Mat& depth, double shiftPixels, double focus,
                cv::Mat& view, FastBuffers& buffers) {
    const int rowsAtATime = std::min(kRowsAtATime, photo.rows);
    buffers.mapX.create(rowsAtATime, photo.cols, CV_32FC1);
    buffers.mapY.create(rowsAtATime, photo.cols, CV_32FC1);
    for (int y0 = 0; y0 < photo.rows; y0 += rowsAtATime) {
        const int rows = std::min(rowsAtATime, photo.rows - y0);
        for (int i = 0; i < rows; ++i) {
            mapRow(depth.ptr<float>(y0 + i), photo.cols, shiftPixels, focus,
                   buffers.mapX.ptr<float>(i));
            std::fill_n(buffers.mapY.ptr<float>(i), photo.cols, static_cast<float>(y0 + i));
        }
        cv::Mat target = view.rowRange(y0, y0 + rows);
        cv::remap(photo, target, buffers.mapX.rowRange(0, rows), buffers.mapY.rowRange(0, rows),
                  cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    }
}

} // namespace altiro3D
