#include "support/reference.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

namespace altiro3D::test {

long double referencePhase(const Calibration& c, bool inverted, int x, int y, int channel) {
    using Real = long double;
    const Real W = c.screenW;
    const Real H = c.screenH;
    const Real mirror = c.flipImageX >= 0.5 ? -1 : 1;
    const Real P = Real(c.pitch) * W / Real(c.DPI) * std::cos(std::atan(1 / Real(c.slope)));
    const Real T = H / (W * Real(c.slope)) * mirror;
    const int k = c.flipSubp >= 0.5 ? 2 - channel : channel;
    const Real u = (x + Real(0.5)) / W;
    const Real v = 1 - (y + Real(0.5)) / H;
    Real a = 0;
    if (c.subpixelCells.empty()) {
        a = (u + k / (3 * W) * mirror + v * T) * P - Real(c.center);
    } else {
        const int yb = c.screenH - 1 - y;
        const int cells[] = {0, (x + yb) % 2, x % 2, (yb + 2 * (x % 2)) % 4, yb % 2};
        const auto index = static_cast<std::size_t>(cells[c.CellPatternMode]);
        const SubpixelCell& cell = c.subpixelCells[index % c.subpixelCells.size()];
        const auto i = static_cast<std::size_t>(k);
        a = ((u + mirror * Real(cell.x[i]) / W) + (v + Real(cell.y[i]) / H) * T) * P -
            Real(c.center);
    }
    const Real z = a - std::floor(a);
    return inverted ? 1 - z : z;
}

int referenceView(const Calibration& calibration, bool inverted, int views, int x, int y,
                  int channel) {
    const long double z = referencePhase(calibration, inverted, x, y, channel);
    return std::min(static_cast<int>(std::floor(z * views)), views - 1);
}

cv::Point referenceQuiltPixel(const Calibration& c, bool inverted, const QuiltLayout& layout, int x,
                              int y, int channel) {
    const int view = referenceView(c, inverted, layout.viewCount, x, y, channel);
    const int column = view % layout.columns;
    const int rowFromBottom = view / layout.columns;
    const long double u = (x + 0.5L) / c.screenW;
    const long double vDown = (y + 0.5L) / c.screenH;
    const long double uSeen = c.flipImageX >= 0.5 ? 1 - u : u;
    const long double vSeen = c.flipImageY >= 0.5 ? 1 - vDown : vDown;
    const cv::Size tile = layout.tileSize;
    return {column * tile.width + static_cast<int>(std::floor(uSeen * tile.width)),
            (layout.rows - 1 - rowFromBottom) * tile.height +
                static_cast<int>(std::floor(vSeen * tile.height))};
}

cv::Mat referenceFast(const cv::Mat& photo, const cv::Mat& depth, double shiftPixels,
                      double focus) {
    cv::Mat view(photo.size(), CV_64FC3);
    for (int y = 0; y < photo.rows; ++y) {
        for (int x = 0; x < photo.cols; ++x) {
            const double place = std::clamp(x + shiftPixels * (depth.at<float>(y, x) - focus), 0.0,
                                            photo.cols - 1.0);
            const int left = static_cast<int>(place);
            const int right = std::min(left + 1, photo.cols - 1);
            const double weight = place - left;
            const cv::Vec3d a = photo.at<cv::Vec3b>(y, left);
            const cv::Vec3d b = photo.at<cv::Vec3b>(y, right);
            view.at<cv::Vec3d>(y, x) = a * (1 - weight) + b * weight;
        }
    }
    return view;
}

cv::Mat referenceLensView(const cv::Mat& native, const Calibration& calibration, bool inverted,
                          double phase, double spot) {
    cv::Mat seen(native.size(), CV_8UC3, cv::Scalar::all(0));
    for (int channel = 0; channel < 3; ++channel) {
        std::vector<cv::Point> lit;
        for (int y = 0; y < native.rows; ++y) {
            for (int x = 0; x < native.cols; ++x) {
                const long double away =
                    referencePhase(calibration, inverted, x, y, channel) - phase;
                if (std::abs(away - std::round(away)) <= spot / 2.0L) lit.emplace_back(x, y);
            }
        }
        for (int y = 0; y < native.rows; ++y) {
            for (int x = 0; x < native.cols; ++x) {
                const auto rank = [x, y](const cv::Point& p) {
                    const int dx = p.x - x;
                    const int dy = p.y - y;
                    return std::make_tuple(dx * dx + dy * dy, std::abs(dy), dy, dx);
                };
                const auto nearest = std::min_element(
                    lit.begin(), lit.end(),
                    [&rank](const cv::Point& a, const cv::Point& b) { return rank(a) < rank(b); });
                if (nearest == lit.end()) continue;
                seen.at<cv::Vec3b>(y, x)[2 - channel] = native.at<cv::Vec3b>(*nearest)[2 - channel];
            }
        }
    }
    return seen;
}

} // namespace altiro3D::test
