#include "depth/depth_planes.hpp"

#include "base/pixel_rows.hpp"
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
void readKnot(const cv::Mat& photo, const cv::Mat& depth, const cv::Mat& smooth, float sameSurface,
              cv::Point at, Knots& knots) {
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
    const auto& color = photo.at<cv::Vec3b>(middle);
    for (int i = 0; i < 3; ++i)
        knots.color[static_cast<std::size_t>(i)].at<float>(at) = color[i];
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

// The rows of knots around a row of the picture, repeated for the px of their cells.
class WideRows {
  public:
    explicit WideRows(const Knots& knots)
        : knots_(knots), padding_(static_cast<std::size_t>(kPlaneNear * knots.side) + kRowPadding) {
        const auto width = static_cast<std::size_t>(knots.guide.cols * knots.side) + 2 * padding_;
        for (Wide& row : rows_) {
            row.guide.assign(width, kNoKnot);
            for (std::vector<float>* const plane :
                 {&row.slopeX, &row.slopeY, row.color.data(), &row.color[1], &row.color[2]})
                plane->assign(width, 0);
        }
    }

    // @param y a row of knots; valid until kRows others were asked for
    KnotRow row(int y) {
        Wide& wide = rows_[static_cast<std::size_t>(y % kRows)];
        if (wide.y != y) {
            wide.y = y;
            repeat(knots_.guide, y, wide.guide);
            repeat(knots_.slopeX, y, wide.slopeX);
            repeat(knots_.slopeY, y, wide.slopeY);
            for (std::size_t i = 0; i < wide.color.size(); ++i)
                repeat(knots_.color[i], y, wide.color[i]);
        }
        const auto begin = [&](const std::vector<float>& plane) { return plane.data() + padding_; };
        return {nullptr,
                begin(wide.guide),
                begin(wide.slopeX),
                begin(wide.slopeY),
                {begin(wide.color[0]), begin(wide.color[1]), begin(wide.color[2])}};
    }

  private:
    static constexpr int kRows = 2 * kPlaneNear + 1;
    struct Wide {
        int y = -1;
        std::vector<float> guide;
        std::vector<float> slopeX;
        std::vector<float> slopeY;
        std::array<std::vector<float>, 3> color;
    };

    void repeat(const cv::Mat& from, int y, std::vector<float>& to) const {
        float* cell = to.data() + padding_;
        for (int x = 0; x < from.cols; ++x, cell += knots_.side)
            std::fill_n(cell, knots_.side, from.at<float>(y, x));
    }

    const Knots& knots_;
    std::size_t padding_;
    std::array<Wide, kRows> rows_;
};

// Each px becomes the mean of the planes around it. Where none fits it stays nearly as it is.
void blend(const cv::Mat& photo, const Knots& knots, const PlaneWeights& weights, cv::Mat& depth) {
    const float middle = static_cast<float>(knots.side - 1) / 2;
    const auto width = static_cast<std::size_t>(depth.cols);
    auto inCell = paddedRow<float>(width);
    for (int x = 0; x < depth.cols; ++x)
        inCell[static_cast<std::size_t>(x)] = static_cast<float>(x % knots.side) - middle;
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        WideRows wide(knots);
        auto own = paddedRow<float>(width); // depth and colours of the row
        std::array<std::vector<float>, 3> color;
        auto blended = paddedRow<float>(width);
        PlanePixels pixels;
        pixels.side = knots.side;
        pixels.depth = own.data();
        for (std::size_t i = 0; i < color.size(); ++i) {
            color[i] = paddedRow<float>(width);
            pixels.color[i] = color[i].data();
        }
        pixels.inCell = inCell.data();
        for (int y = range.start; y < range.end; ++y) {
            auto* const row = depth.ptr<float>(y);
            std::copy_n(row, depth.cols, own.begin());
            const std::uint8_t* pixel = photo.ptr(y);
            for (std::size_t x = 0; x < width; ++x)
                for (auto& channel : color)
                    channel[x] = *pixel++;
            const int cell = y / knots.side;
            const int end = std::min(knots.guide.rows, cell + kPlaneNear + 1);
            pixels.count = 0;
            for (int other = std::max(0, cell - kPlaneNear); other < end; ++other) {
                const auto at = static_cast<std::size_t>(pixels.count++);
                pixels.others[at] = wide.row(other);
                pixels.down[at] = static_cast<float>(y - other * knots.side) - middle;
            }
            blendPlanes(pixels, depth.cols, weights, blended.data());
            std::copy_n(blended.begin(), depth.cols, row);
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
    Knots knots(depth.size(), std::max(8, std::max(depth.cols, depth.rows) / 64) / 2);
    const auto sameSurface = static_cast<float>(2 * deviation);
    cv::parallel_for_(cv::Range(0, knots.guide.rows), [&](const cv::Range& range) {
        for (int row = range.start; row < range.end; ++row)
            for (int column = 0; column < knots.guide.cols; ++column)
                readKnot(soft, measured, depth, sameSurface, {column, row}, knots);
    });
    const float color = factorOf(20);
    for (const double depths : {2.5, 1.5})
        fitKnots({factorOf(6.0 * knots.side), factorOf(depths * deviation), color, 2}, knots);
    blend(soft, knots, {factorOf(1.5 * knots.side), factorOf(1.2 * deviation), color, 3}, depth);
    returnDetail(measured, depth);
}

} // namespace altiro3D
