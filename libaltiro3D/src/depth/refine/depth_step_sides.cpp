#include "depth/refine/depth_step_sides.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace altiro3D {

namespace {

constexpr double kColorSigma = 14; // levels; 8 to 20 give the same within 0.05 dB

// Similarity of colours by their squared distance >> kStepColorShift.
std::vector<float> makeColorWeights() {
    std::vector<float> weights;
    for (int i = 0; i < kStepColors; ++i) {
        const double square = (i + 0.5) * (1 << kStepColorShift);
        weights.push_back(static_cast<float>(std::exp(-square / (2 * kColorSigma * kColorSigma))));
    }
    weights.push_back(0);
    return weights;
}

// Squared slope.
void findSlopes(const cv::Mat& depth, cv::Mat& result) {
    result.create(depth.size(), CV_32FC1);
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            const auto* const above = depth.ptr<float>(std::max(y - 1, 0));
            const auto* const row = depth.ptr<float>(y);
            const auto* const below = depth.ptr<float>(std::min(y + 1, depth.rows - 1));
            auto* const to = result.ptr<float>(y);
            for (int x = 0; x < depth.cols; ++x) {
                const float across = row[std::min(x + 1, depth.cols - 1)] - row[std::max(x - 1, 0)];
                const float down = below[x] - above[x];
                to[x] = (across * across + down * down) / 4;
            }
        }
    });
}

// A filter that reads the rows around each part of the picture. OpenCV's filters use one thread.
template <class Filter>
void inParts(const cv::Mat& from, cv::Mat& to, const Filter& filter) {
    to.create(from.size(), from.type());
    // no columns beside it
    const cv::Mat alone(from.size(), from.type(), const_cast<uchar*>(from.data), from.step);
    cv::parallel_for_(
        cv::Range(0, from.rows),
        [&](const cv::Range& rows) {
            cv::Mat part = to.rowRange(rows);
            filter(alone.rowRange(rows), part);
        },
        cv::getNumThreads());
}

cv::Mat windowOf(int radius) {
    return cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8UC1);
}

void findLeast(const cv::Mat& from, int radius, cv::Mat& to) {
    inParts(from, to, [window = windowOf(radius)](const cv::Mat& part, cv::Mat& result) {
        cv::erode(part, result, window, {-1, -1}, 1, cv::BORDER_REPLICATE);
    });
}

void findMost(const cv::Mat& from, int radius, cv::Mat& to) {
    inParts(from, to, [window = windowOf(radius)](const cv::Mat& part, cv::Mat& result) {
        cv::dilate(part, result, window, {-1, -1}, 1, cv::BORDER_REPLICATE);
    });
}

} // namespace

void findExtremes(const cv::Mat& depth, int radius, cv::Mat& least, cv::Mat& most) {
    findLeast(depth, radius, least);
    findMost(depth, radius, most);
}

void Surroundings::find(const cv::Mat& depth, int radius) {
    findExtremes(depth, radius, least, most);
    findSlopes(depth, slopes);
    findMost(slopes, radius, steepest);
}

StepSides::StepSides(const cv::Mat& photo, std::vector<StepNeighbour> neighbours)
    : size_(photo.size()), neighbours_(std::move(neighbours)), margin_(0) {
    for (const StepNeighbour& neighbour : neighbours_)
        margin_ = std::max(margin_, std::abs(neighbour.x));
    blueGreen_ = padded(CV_32SC1);
    red_ = padded(CV_32SC1);
    cv::parallel_for_(cv::Range(0, photo.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            const auto* bgr = photo.ptr<std::uint8_t>(y);
            auto* const blueGreen = blueGreen_.ptr<std::int32_t>(y) + margin_;
            auto* const red = red_.ptr<std::int32_t>(y) + margin_;
            for (int x = 0; x < photo.cols; ++x, bgr += 3) {
                blueGreen[x] = bgr[0] | (bgr[1] << 16);
                red[x] = bgr[2];
            }
        }
    });
}

cv::Mat StepSides::padded(int type) const {
    const int columns = size_.width + 2 * margin_ + static_cast<int>(kRowPadding);
    return cv::Mat::zeros(size_.height, columns, type);
}

cv::Mat StepSides::inside(const cv::Mat& plane) const {
    return plane(cv::Rect({margin_, 0}, size_));
}

void StepSides::setDepth(const cv::Mat& depth, const cv::Mat& sure) {
    if (depthPlane_.empty()) {
        depthPlane_ = padded(CV_32FC1);
        depth_ = inside(depthPlane_);
    }
    depth.copyTo(depth_);
    surePlane_.release();
    if (sure.empty()) return;
    surePlane_ = padded(CV_32FC1);
    cv::Mat to = inside(surePlane_);
    sure.copyTo(to);
}

void StepSides::sum(int y, StepBuffers& buffers) const {
    static const std::vector<float> colorWeights = makeColorWeights();
    const auto stride = static_cast<std::ptrdiff_t>(depthPlane_.step1());
    buffers.taps.clear();
    for (const StepNeighbour& neighbour : neighbours_) {
        if (y + neighbour.y >= 0 && y + neighbour.y < size_.height)
            buffers.taps.push_back(
                {neighbour.x, neighbour.y * stride + neighbour.x, neighbour.weight});
    }
    StepRow row;
    row.count = static_cast<std::size_t>(size_.width);
    row.depth = depthPlane_.ptr<float>(y) + margin_;
    if (!surePlane_.empty()) row.sure = surePlane_.ptr<float>(y) + margin_;
    row.blueGreen = blueGreen_.ptr<std::int32_t>(y) + margin_;
    row.red = red_.ptr<std::int32_t>(y) + margin_;
    row.wanted = buffers.wanted.data();
    row.middle = buffers.middle.data();
    row.scale = buffers.scale.data();
    row.taps = buffers.taps.data();
    row.tapCount = buffers.taps.size();
    row.reach = margin_;
    sumStepSides(row, colorWeights.data(), buffers.nearSide.sums(), buffers.farSide.sums());
}

} // namespace altiro3D
