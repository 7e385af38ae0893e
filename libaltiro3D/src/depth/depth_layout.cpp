#include "depth/depth_layout.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

void putLayoutUnder(cv::Mat layout, double share, cv::Mat& detail) {
    constexpr double kSigma = 1.0 / 80; // of the longer side
    cv::resize(layout, layout, detail.size(), 0, 0, cv::INTER_LINEAR);
    const double sigma = kSigma * std::max(detail.cols, detail.rows);
    cv::Mat smooth;
    cv::GaussianBlur(detail, smooth, {}, sigma, sigma, cv::BORDER_REPLICATE);
    cv::addWeighted(layout, share, smooth, -share, 0, smooth);
    cv::add(detail, smooth, detail);
}

} // namespace altiro3D
