#include "depth/depth_planes.hpp"

#include "depth/depth_detail.hpp"
#include "depth/depth_planes_row.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kNear = 2; // knots around a px on each side that decide on it

// A plane of numbers with padding on both sides of its rows.
cv::Mat padded(cv::Size size, float value) {
    const cv::Mat all(size.height, size.width + 2 * kKnotPadding, CV_32FC1, cv::Scalar(value));
    return all.colRange(kKnotPadding, kKnotPadding + size.width);
}

// One knot per cell of the picture, in its middle. All are [rows x columns of cells, CV_32FC1].
struct Knots {
    int side; // px per cell
    cv::Mat depth;
    cv::Mat guide;
    cv::Mat slopeX;
    cv::Mat slopeY;
    std::array<cv::Mat, 3> color;

    Knots(cv::Size picture, int cellSide) : side(cellSide) {
        const cv::Size size((picture.width - 1) / side + 1, (picture.height - 1) / side + 1);
        guide = padded(size, kNoKnot);
        for (cv::Mat* const plane : {&depth, &slopeX, &slopeY, color.data(), &color[1], &color[2]})
            *plane = padded(size, 0);
    }
    KnotRow row(int y) const {
        return {depth.ptr<float>(y),
                guide.ptr<float>(y),
                slopeX.ptr<float>(y),
                slopeY.ptr<float>(y),
                {color[0].ptr<float>(y), color[1].ptr<float>(y), color[2].ptr<float>(y)}};
    }
};

// The colour and the smooth depth of a knot are those of the middle of its cell. Its measured depth
// is the mean of the px that belong to the same surface.
void readKnot(const std::array<cv::Mat, 3>& photo, const cv::Mat& depth, const cv::Mat& smooth,
              float sameSurface, cv::Point at, Knots& knots) {
    const cv::Rect cell =
        cv::Rect(at * knots.side, cv::Size(knots.side, knots.side)) & cv::Rect({}, depth.size());
    const cv::Point middle(std::min(cell.x + knots.side / 2, depth.cols - 1),
                           std::min(cell.y + knots.side / 2, depth.rows - 1));
    const float guide = smooth.at<float>(middle);
    float sum = 0;
    float weights = 0;
    for (int y = cell.y; y < cell.br().y; ++y) {
        for (int x = cell.x; x < cell.br().x; ++x) {
            const float away = (smooth.at<float>(y, x) - guide) / sameSurface;
            const float weight = std::max(0.0F, 1 - away * away);
            sum += weight * depth.at<float>(y, x);
            weights += weight;
        }
    }
    knots.depth.at<float>(at) = sum / weights;
    knots.guide.at<float>(at) = guide;
    for (std::size_t i = 0; i < photo.size(); ++i)
        knots.color[i].at<float>(at) = static_cast<float>(photo[i].at<std::uint8_t>(middle));
}

// Fits a plane around each knot; its value becomes the guide of the next pass.
void fitKnots(const PlaneWeights& weights, Knots& knots) {
    const cv::Size size = knots.guide.size();
    cv::Mat fitted = padded(size, kNoKnot);
    cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& range) {
        std::vector<float> guide(static_cast<std::size_t>(size.width + kKnotPadding));
        for (int row = range.start; row < range.end; ++row) {
            PlaneRow rows;
            rows.side = knots.side;
            rows.mine = knots.row(row);
            for (int away = -kPlaneReach; away <= kPlaneReach; away += kPlaneStep) {
                if (row + away < 0 || row + away >= size.height) continue;
                const auto at = static_cast<std::size_t>(rows.count++);
                rows.others[at] = knots.row(row + away);
                rows.down[at] = static_cast<float>(away * knots.side);
            }
            fitPlaneRow(rows, size.width, weights, guide.data(), knots.slopeX.ptr<float>(row),
                        knots.slopeY.ptr<float>(row));
            std::copy_n(guide.begin(), size.width, fitted.ptr<float>(row));
        }
    });
    knots.guide = fitted;
}

// Repeats the knots of each row for the px of their cells.
Knots repeated(const Knots& knots) {
    Knots wide(knots);
    const cv::Size size(knots.guide.cols * knots.side, knots.guide.rows);
    const auto repeat = [&](const cv::Mat& from, cv::Mat& to) {
        to = cv::Mat(size, CV_32FC1);
        for (int y = 0; y < size.height; ++y)
            for (int x = 0; x < from.cols; ++x)
                std::fill_n(to.ptr<float>(y) + static_cast<std::ptrdiff_t>(x) * knots.side,
                            knots.side, from.at<float>(y, x));
    };
    repeat(knots.guide, wide.guide);
    repeat(knots.slopeX, wide.slopeX);
    repeat(knots.slopeY, wide.slopeY);
    for (std::size_t i = 0; i < wide.color.size(); ++i)
        repeat(knots.color[i], wide.color[i]);
    return wide;
}

// Each px becomes the mean of the planes around it. Where none fits it stays nearly as it is.
void blend(const std::array<cv::Mat, 3>& photo, const Knots& wide, const PlaneWeights& weights,
           cv::Mat& depth) {
    constexpr float kOwn = 0.05F;
    const float middle = static_cast<float>(wide.side - 1) / 2;
    std::vector<float> inCell;
    for (int x = 0; x < depth.cols; ++x)
        inCell.push_back(static_cast<float>(x % wide.side) - middle);
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        std::vector<float> sum(inCell.size());
        std::vector<float> weight(inCell.size());
        for (int y = range.start; y < range.end; ++y) {
            auto* const row = depth.ptr<float>(y);
            const PlanePixels pixels{row,
                                     {photo[0].ptr(y), photo[1].ptr(y), photo[2].ptr(y)},
                                     inCell.data(),
                                     depth.cols};
            for (std::size_t x = 0; x < sum.size(); ++x)
                sum[x] = kOwn * row[x];
            std::fill(weight.begin(), weight.end(), kOwn);
            const int cell = y / wide.side;
            const int end = std::min(wide.guide.rows, cell + kNear + 1);
            for (int other = std::max(0, cell - kNear); other < end; ++other) {
                const float dy = static_cast<float>(y - other * wide.side) - middle;
                for (int away = -kNear; away <= kNear; ++away)
                    blendPlanes(pixels, wide.row(other), wide.guide.cols, away * wide.side, dy,
                                weights, sum.data(), weight.data());
            }
            for (std::size_t x = 0; x < sum.size(); ++x)
                row[x] = std::clamp(sum[x] / weight[x], 0.0F, 1.0F);
        }
    });
}

float factorOf(double sigma) {
    return static_cast<float>(1 / (2 * sigma * sigma));
}

} // namespace

void fitPlanes(const cv::Mat& photo, double noise, const cv::Mat& measured, cv::Mat& depth) {
    const double deviation = std::max(noise, 1e-6); // so that all weights are numbers
    returnDetail(measured, depth);
    cv::Mat soft;
    cv::blur(photo, soft, {3, 3}, {-1, -1}, cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
    std::array<cv::Mat, 3> channels;
    cv::split(soft, channels.data());

    Knots knots(depth.size(), std::max(8, std::max(depth.cols, depth.rows) / 64) / 2);
    const auto sameSurface = static_cast<float>(2 * deviation);
    cv::parallel_for_(cv::Range(0, knots.guide.rows), [&](const cv::Range& range) {
        for (int row = range.start; row < range.end; ++row)
            for (int column = 0; column < knots.guide.cols; ++column)
                readKnot(channels, measured, depth, sameSurface, {column, row}, knots);
    });
    const float color = factorOf(20);
    for (const double depths : {2.5, 1.5})
        fitKnots({factorOf(6.0 * knots.side), factorOf(depths * deviation), color, 2}, knots);
    blend(channels, repeated(knots),
          {factorOf(1.5 * knots.side), factorOf(1.2 * deviation), color, 3}, depth);
    returnDetail(measured, depth);
}

} // namespace altiro3D
