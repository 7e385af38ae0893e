// Contours of depth, px by px from docs/mathematics.md, 4a.4.

#include "support/pixels.hpp"
#include "support/reference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D::test {

namespace {

// Beyond the border the nearest px is repeated.
template <class T>
T repeatedAt(const cv::Mat& map, int x, int y) {
    return map.at<T>(std::clamp(y, 0, map.rows - 1), std::clamp(x, 0, map.cols - 1));
}

// Depth from lo to hi, and the steepest slope.
struct Window {
    double lo;
    double hi;
    double slope;

    double height() const { return hi - lo; }
};

Window windowAround(const cv::Mat& depth, cv::Point p, int radius) {
    Window window{depth.at<double>(p), depth.at<double>(p), 0};
    for (int j = p.y - radius; j <= p.y + radius; ++j) {
        for (int i = p.x - radius; i <= p.x + radius; ++i) {
            const int x = std::clamp(i, 0, depth.cols - 1);
            const int y = std::clamp(j, 0, depth.rows - 1);
            const double d = depth.at<double>(y, x);
            window.lo = std::min(window.lo, d);
            window.hi = std::max(window.hi, d);
            const double across =
                repeatedAt<double>(depth, x + 1, y) - repeatedAt<double>(depth, x - 1, y);
            const double down =
                repeatedAt<double>(depth, x, y + 1) - repeatedAt<double>(depth, x, y - 1);
            window.slope = std::max(window.slope, std::hypot(across, down) / 2);
        }
    }
    return window;
}

double squaredDistance(const cv::Mat& photo, cv::Point p, cv::Point q) {
    const cv::Vec3i difference =
        cv::Vec3i(photo.at<cv::Vec3b>(p)) - cv::Vec3i(photo.at<cv::Vec3b>(q));
    return difference.dot(difference);
}

// Weighted means over the px of one side of a step.
struct Side {
    double weight = 0;
    double depth = 0;
    double color = 0;
};

class ReferenceContours {
  public:
    ReferenceContours(const cv::Mat& photo, const cv::Mat& depth)
        : photo_(photo), size_(depth.size()), unit_(std::max(depth.cols, depth.rows) / 512.0) {
        depth.convertTo(depth_, CV_64F);
        forAll([&](cv::Point p) { windows_.push_back(windowAround(depth_, p, px(10))); });
        sides_.resize(windows_.size());
        sure_.create(size_, CV_8UC1);
        forAll([&](cv::Point p) { sure_.at<uchar>(p) = belongsToSide(p) ? 1 : 0; });
    }

    cv::Mat result() {
        cv::Mat isInBand(size_, CV_8UC1, cv::Scalar(0));
        cv::Mat own(size_, CV_64F, cv::Scalar(0));
        forAll([&](cv::Point p) {
            if (!isStep(p)) return;
            own.at<double>(p) = place(p) > 0.5 ? 1 : 0;
            if (std::abs(place(p) - 0.5) >= 0.42) return;
            const auto [far, near] = sides_[index(p)] = sidesOf(p);
            if (!(far.weight > 0) || !(near.weight > 0)) return;
            isInBand.at<uchar>(p) = 1;
            const double vote = 1.2 * (2 * place(p) - 1) +
                                0.6 * std::log((near.color + 0.02) / (far.color + 0.02)); // (4.12)
            own.at<double>(p) = (std::clamp(vote, -1.0, 1.0) + 1) / 2;
        });
        cv::Mat share = own.clone();
        for (int pass = 0; pass < 30; ++pass) { // (4.13)
            const cv::Mat before = share.clone();
            forAll([&](cv::Point p) {
                if (isInBand.at<uchar>(p) != 0) share.at<double>(p) = walked(own, before, p);
            });
        }
        const cv::Mat walk = share.clone();
        forAll([&](cv::Point p) {
            if (isInBand.at<uchar>(p) == 0) return;
            for (const cv::Point& q : besides(p))
                share.at<double>(p) = std::max(share.at<double>(p), walk.at<double>(q));
        });
        cv::Mat changed(size_, CV_32FC1);
        forAll([&](cv::Point p) {
            double d = depth_.at<double>(p);
            if (isInBand.at<uchar>(p) != 0) {
                const auto& [far, near] = sides_[index(p)];
                const double side = std::clamp(4 * (share.at<double>(p) - 0.5) + 0.5, 0.0, 1.0);
                const double hard = far.depth + (near.depth - far.depth) * side;
                d += hardness(isInBand, share, p) * (hard - d); // (4.15)
            }
            changed.at<float>(p) = static_cast<float>(d);
        });
        return changed;
    }

  private:
    // A length that is given for pictures of 512 px.
    int px(double length) const {
        return std::max(1, static_cast<int>(std::lround(length * unit_)));
    }
    template <class Use>
    void forAll(const Use& use) const {
        forPixels(size_, [&](int x, int y) { use(cv::Point(x, y)); });
    }
    std::size_t index(cv::Point p) const {
        return static_cast<std::size_t>(p.y * size_.width + p.x);
    }
    bool contains(cv::Point p) const { return cv::Rect({}, size_).contains(p); }
    std::vector<cv::Point> besides(cv::Point p) const {
        std::vector<cv::Point> result;
        for (const cv::Point& way : {cv::Point(-1, 0), cv::Point(1, 0), {0, -1}, {0, 1}})
            if (contains(p + way)) result.push_back(p + way);
        return result;
    }

    bool isStep(cv::Point p) const {
        const Window& window = windows_[index(p)];
        return window.height() > 0.06 && window.height() < 16 * unit_ * window.slope;
    }
    double place(cv::Point p) const {
        const Window& window = windows_[index(p)];
        return (depth_.at<double>(p) - window.lo) / window.height();
    }
    // Surely.
    bool belongsToSide(cv::Point p) const {
        if (!isStep(p)) return true;
        if (place(p) < 0.15 || place(p) > 0.85) return true;
        return windowAround(depth_, p, px(3)).height() < 0.3 * windows_[index(p)].height();
    }

    // Far and near. The weights are those of (4.8).
    std::array<Side, 2> sidesOf(cv::Point p) const {
        const Window& window = windows_[index(p)];
        const double sigma = 18 * unit_;
        const int stride = px(4);
        const int reach = px(36) / stride * stride;
        std::array<Side, 2> sides;
        for (int j = -reach; j <= reach; j += stride) {
            for (int i = -reach; i <= reach; i += stride) {
                const cv::Point q = p + cv::Point(i, j);
                if (i * i + j * j > reach * reach || !contains(q) || sure_.at<uchar>(q) == 0)
                    continue;
                const double d = depth_.at<double>(q);
                const double a = (2 * d - window.hi - window.lo) / window.height();
                if (std::abs(a) >= 2) continue;
                const double weight = a * a * std::exp(-(i * i + j * j) / (2 * sigma * sigma));
                // in steps of 16, 0 beyond 8192
                const int step = static_cast<int>(squaredDistance(photo_, p, q)) / 16;
                const double similar =
                    step < 512 ? std::exp(-(step + 0.5) * 16 / (2 * 14.0 * 14.0)) : 0;
                Side& side = sides[a > 0 ? 1 : 0];
                side.weight += weight;
                side.depth += weight * d;
                side.color += weight * similar;
            }
        }
        for (Side& side : sides) {
            side.depth /= side.weight;
            side.color /= side.weight;
        }
        return sides;
    }

    double walked(const cv::Mat& own, const cv::Mat& share, cv::Point p) const {
        double sum = 0.15 * own.at<double>(p);
        double weights = 0.15;
        for (const cv::Point& q : besides(p)) {
            if (!isStep(q)) continue;
            const double weight =
                std::exp(-squaredDistance(photo_, p, q) / (2 * 12.0 * 12.0)) + 0.02;
            sum += weight * share.at<double>(q);
            weights += weight;
        }
        return sum / weights;
    }

    // (4.14)
    double hardness(const cv::Mat& isInBand, const cv::Mat& share, cv::Point p) const {
        double sum = 0;
        int count = 0;
        for (int j = -px(7); j <= px(7); ++j) {
            for (int i = -px(7); i <= px(7); ++i) {
                // px at the border are mirrored
                const cv::Point q(
                    cv::borderInterpolate(p.x + i, size_.width, cv::BORDER_REFLECT_101),
                    cv::borderInterpolate(p.y + j, size_.height, cv::BORDER_REFLECT_101));
                if (isInBand.at<uchar>(q) == 0) continue;
                sum += std::log(windows_[index(q)].slope * unit_) / 0.8 +
                       std::abs(share.at<double>(q) - 0.5) / 0.12;
                ++count;
            }
        }
        return std::clamp((sum / count + 0.8) / 0.6 + 0.5, 0.0, 1.0);
    }

    cv::Mat photo_;
    cv::Mat depth_;
    cv::Mat sure_; // CV_8UC1
    cv::Size size_;
    double unit_;
    std::vector<Window> windows_;            // of each px
    std::vector<std::array<Side, 2>> sides_; // of each px of a band
};

} // namespace

cv::Mat referenceDecideContours(const cv::Mat& photo, const cv::Mat& depth) {
    return ReferenceContours(photo, depth).result();
}

} // namespace altiro3D::test
