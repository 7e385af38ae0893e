// Straight lines of depth, from docs/mathematics.md, 4a.5.

#include "support/reference.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D::test {

namespace {

// A px beside a line.
struct Beside {
    cv::Point place;
    double along; // 0..1
    double missing = 0;
    double weight = 1;
};

// (4.16): what the px lack of the affine function that fits them best.
void fitLine(const cv::Mat& depth, std::vector<Beside>& pixels) {
    for (int fit = 0; fit < 5; ++fit) {
        cv::Mat normal = cv::Mat::zeros(2, 2, CV_64F);
        cv::Mat right = cv::Mat::zeros(2, 1, CV_64F);
        for (const Beside& px : pixels) {
            const cv::Mat basis = (cv::Mat_<double>(2, 1) << 1, px.along);
            normal += px.weight * basis * basis.t();
            right += px.weight * depth.at<double>(px.place) * basis;
        }
        cv::Mat line; // DECOMP_SVD: a level line where there is one place only
        cv::solve(normal, right, line, cv::DECOMP_SVD);
        std::vector<double> sizes;
        for (Beside& px : pixels) {
            px.missing =
                line.at<double>(0) + line.at<double>(1) * px.along - depth.at<double>(px.place);
            sizes.push_back(std::abs(px.missing));
        }
        std::sort(sizes.begin(), sizes.end());
        const double scale = std::max(0.01, 1.48 * sizes[sizes.size() / 2]);
        for (Beside& px : pixels)
            px.weight = 1 / (1 + std::pow(px.missing / scale, 2));
    }
}

// The px beside a line in parts, which end where the depth has a step.
std::vector<std::vector<Beside>> partsBeside(const cv::Vec4f& line, double aside,
                                             const cv::Mat& depth) {
    const cv::Point2d from(line[0], line[1]);
    const cv::Point2d way = cv::Point2d(line[2], line[3]) - from;
    const double length = std::hypot(way.x, way.y);
    const cv::Point2d across(-way.y / length, way.x / length);
    const int last = static_cast<int>(length);
    std::vector<std::vector<Beside>> parts(1);
    for (int i = 0; i <= last; ++i) {
        const double along = last > 0 ? static_cast<double>(i) / last : 0;
        const cv::Point2d exact = from + along * way + aside * across;
        const cv::Point place(cvRound(exact.x), cvRound(exact.y));
        if (!cv::Rect({}, depth.size()).contains(place)) continue;
        if (!parts.back().empty()) {
            const double before = depth.at<double>(parts.back().back().place);
            if (std::abs(depth.at<double>(place) - before) > 0.02) parts.emplace_back();
        }
        parts.back().push_back({place, along});
    }
    return parts;
}

} // namespace

cv::Mat referenceStraightenLines(const std::vector<cv::Vec4f>& lines, const cv::Mat& given,
                                 int passes) {
    cv::Mat depth;
    given.convertTo(depth, CV_64F);
    cv::Mat weights(depth.size(), CV_64F, cv::Scalar(0));
    cv::Mat wanted = weights.clone();
    const double side = std::max(depth.cols, depth.rows);
    for (const cv::Vec4f& line : lines) {
        for (const double aside : {-3.0, -1.5, 0.0, 1.5, 3.0}) {
            for (std::vector<Beside>& pixels : partsBeside(line, aside, depth)) {
                const auto length = static_cast<double>(pixels.size());
                if (length < 0.07 * side) continue;
                fitLine(depth, pixels);
                std::vector<Beside> close;
                for (const Beside& px : pixels)
                    if (std::abs(px.missing) < 0.1) close.push_back(px);
                if (static_cast<double>(close.size()) < 0.7 * length) continue;
                const double weight = std::min(1.0, length / (0.16 * side));
                for (const Beside& px : close) {
                    wanted.at<double>(px.place) += weight * px.missing;
                    weights.at<double>(px.place) += weight;
                }
            }
        }
    }
    // (4.17), every other px by turns
    cv::Mat correction(depth.size(), CV_64F, cv::Scalar(0));
    for (int turn = 0; turn < 2 * passes; ++turn) {
        for (int y = 0; y < depth.rows; ++y) {
            for (int x = 0; x < depth.cols; ++x) {
                if ((x + y + turn) % 2 != 0) continue;
                double sum = wanted.at<double>(y, x);
                double hold = weights.at<double>(y, x) + 0.002;
                for (const cv::Point& way : {cv::Point(-1, 0), cv::Point(1, 0), {0, -1}, {0, 1}}) {
                    const cv::Point q = cv::Point(x, y) + way;
                    if (!cv::Rect({}, depth.size()).contains(q)) continue;
                    const double step = (depth.at<double>(q) - depth.at<double>(y, x)) / 0.02;
                    sum += std::exp(-step * step) * correction.at<double>(q);
                    hold += std::exp(-step * step);
                }
                double& c = correction.at<double>(y, x);
                c += 1.75 * (sum / hold - c);
            }
        }
    }
    cv::Mat result;
    cv::Mat(depth + correction).convertTo(result, CV_32F);
    return result;
}

} // namespace altiro3D::test
