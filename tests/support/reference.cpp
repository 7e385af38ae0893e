#include "support/reference.hpp"
#include "support/pixels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
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

int referenceCubeViView(double interval, double slope, double x0, int x, int y, int colour) {
    double t = std::fmod(3 * ((x + 1) + (y + 1) * slope) + colour + x0, interval);
    if (t < 0) t += interval;
    return static_cast<int>(std::floor(40 * t / interval));
}

int referenceBarrierView(double pitch, double slope, double offset, const std::vector<int>& order,
                         int views, int i, int j) {
    double t = std::fmod(i + 0.5 - slope * j - offset, pitch);
    if (t < 0) t += pitch;
    const int slot = static_cast<int>(std::floor(views * t / pitch));
    return order.empty() ? views - 1 - slot : order[static_cast<std::size_t>(slot)];
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
    forPixels(photo.size(), [&](int x, int y) {
        const double place =
            std::clamp(x + shiftPixels * (depth.at<float>(y, x) - focus), 0.0, photo.cols - 1.0);
        const int left = static_cast<int>(place);
        const int right = std::min(left + 1, photo.cols - 1);
        const double weight = place - left;
        const cv::Vec3d a = photo.at<cv::Vec3b>(y, left);
        const cv::Vec3d b = photo.at<cv::Vec3b>(y, right);
        view.at<cv::Vec3d>(y, x) = a * (1 - weight) + b * weight;
    });
    return view;
}

cv::Mat referenceLensView(const cv::Mat& native, const Calibration& calibration, bool inverted,
                          double phase, double spot) {
    cv::Mat seen(native.size(), CV_8UC3, cv::Scalar::all(0));
    for (int channel = 0; channel < 3; ++channel) {
        std::vector<cv::Point> lit;
        forPixels(native.size(), [&](int x, int y) {
            const long double away = referencePhase(calibration, inverted, x, y, channel) - phase;
            if (std::abs(away - std::round(away)) <= spot / 2.0L) lit.emplace_back(x, y);
        });
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

namespace {

// For each sample, along one axis: the px first..last of the guide whose centres lie in its cell,
// or else the px nearest to its centre.
std::vector<std::vector<int>> pixelsInCells(int first, int last, double start, double step,
                                            int pixels) {
    std::vector<std::vector<int>> cells;
    for (int sample = first; sample <= last; ++sample) {
        std::vector<int> cell;
        for (int x = 0; x < pixels; ++x)
            if (std::floor(start + (x + 0.5) * step) == sample) cell.push_back(x);
        if (cell.empty()) {
            const auto nearest = static_cast<int>(std::floor((sample + 0.5 - start) / step));
            cell.push_back(std::clamp(nearest, 0, pixels - 1));
        }
        cells.push_back(cell);
    }
    return cells;
}

// The cubic B-spline.
double spline(double d) {
    d = std::abs(d);
    if (d >= 2) return 0.0;
    return d >= 1 ? std::pow(2 - d, 3) / 6 : (4 - 6 * d * d + 3 * d * d * d) / 6;
}

} // namespace

cv::Mat referenceFit(const cv::Mat& depth, const cv::Rect2d& part, const cv::Mat& guide) {
    const double stepX = part.width / guide.cols;
    const double stepY = part.height / guide.rows;
    const cv::Point first(static_cast<int>(std::floor(part.x)),
                          static_cast<int>(std::floor(part.y)));
    const cv::Point last(static_cast<int>(std::ceil(part.x + part.width)) - 1,
                         static_cast<int>(std::ceil(part.y + part.height)) - 1);
    const auto columns = pixelsInCells(first.x, last.x, part.x, stepX, guide.cols);
    const auto rows = pixelsInCells(first.y, last.y, part.y, stepY, guide.rows);
    cv::Mat colors(depth.size(), CV_64FC3, cv::Scalar::all(0));
    for (int j = first.y; j <= last.y; ++j) {
        for (int i = first.x; i <= last.x; ++i) {
            cv::Vec3d sum(0, 0, 0);
            int count = 0;
            for (const int y : rows[static_cast<std::size_t>(j - first.y)]) {
                for (const int x : columns[static_cast<std::size_t>(i - first.x)]) {
                    sum += cv::Vec3d(guide.at<cv::Vec3b>(y, x));
                    ++count;
                }
            }
            for (int c = 0; c < 3; ++c)
                colors.at<cv::Vec3d>(j, i)[c] = std::floor(sum[c] / count + 0.5);
        }
    }
    cv::Mat result(guide.size(), CV_32FC1);
    forPixels(guide.size(), [&](int x, int y) {
        const double atX = part.x + (x + 0.5) * stepX - 0.5;
        const double atY = part.y + (y + 0.5) * stepY - 0.5;
        double sum = 0;
        double weights = 0;
        for (int j = static_cast<int>(std::floor(atY)) - 1; j <= std::floor(atY) + 2; ++j) {
            for (int i = static_cast<int>(std::floor(atX)) - 1; i <= std::floor(atX) + 2; ++i) {
                const cv::Point from(std::clamp(i, first.x, last.x),
                                     std::clamp(j, first.y, last.y));
                const cv::Vec3d distance =
                    colors.at<cv::Vec3d>(from) - cv::Vec3d(guide.at<cv::Vec3b>(y, x));
                const double step = std::floor(distance.dot(distance) / 8);
                const double likeness =
                    step < 1024 ? std::exp(-(step + 0.5) * 8 / (2 * 16.0 * 16.0)) : 0;
                const double weight = spline(atX - i) * spline(atY - j) * (likeness + 1e-4);
                sum += weight * static_cast<double>(depth.at<float>(from));
                weights += weight;
            }
        }
        result.at<float>(y, x) = static_cast<float>(sum / weights);
    });
    return result;
}

double referenceLight(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

double srgbCode(double light) {
    return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

cv::Matx33d referenceXyz(const Chromaticities& c) {
    cv::Matx33d primaries;
    for (int i = 0; i < 3; ++i) {
        const double x = c[static_cast<std::size_t>(2 * i)];
        const double y = c[static_cast<std::size_t>(2 * i + 1)];
        primaries(0, i) = x / y;
        primaries(1, i) = 1;
        primaries(2, i) = (1 - x - y) / y;
    }
    const cv::Vec3d white(0.3127 / 0.3290, 1, (1 - 0.3127 - 0.3290) / 0.3290);
    const cv::Vec3d share = primaries.inv() * white;
    for (int i = 0; i < 3; ++i)
        for (int row = 0; row < 3; ++row)
            primaries(row, i) *= share[i];
    return primaries;
}

double referencePq(double nits) {
    const double y = std::pow(nits / 10000, 0.1593017578125);
    return std::pow((0.8359375 + 18.8515625 * y) / (1 + 18.6875 * y), 78.84375);
}

namespace {

cv::Vec3d encodedFromLinear(const cv::Vec3d& rgb, const Chromaticities& chromaticities) {
    const cv::Vec3d linear = referenceXyz(kSrgb).inv() * (referenceXyz(chromaticities) * rgb);
    const auto encoded = [](double v) { return srgbCode(std::clamp(v, 0.0, 1.0)); };
    return {encoded(linear[2]), encoded(linear[1]), encoded(linear[0])};
}

double lightFromPq(double value) {
    const double root = std::pow(value, 1 / 78.84375);
    return 10000 * std::pow(std::max(root - 0.8359375, 0.0) / (18.8515625 - 18.6875 * root),
                            1 / 0.1593017578125);
}

} // namespace

cv::Vec3d referenceSrgb(const cv::Vec3d& bgr, const Chromaticities& chromaticities,
                        double exponent) {
    const auto decoded = [&](double v) {
        return exponent > 0 ? std::pow(v, exponent) : referenceLight(v);
    };
    return encodedFromLinear({decoded(bgr[2]), decoded(bgr[1]), decoded(bgr[0])}, chromaticities);
}

cv::Vec3d referenceToneMapped(const cv::Vec3d& bgr, const Chromaticities& chromaticities,
                              bool isHlg) {
    cv::Vec3d nits; // RGB
    for (int i = 0; i < 3; ++i) {
        const double v = bgr[2 - i];
        if (!isHlg)
            nits[i] = lightFromPq(v);
        else if (v <= 0.5)
            nits[i] = v * v / 3;
        else
            nits[i] = (std::exp((v - 0.55991073) / 0.17883277) + 0.28466892) / 12;
    }
    if (isHlg) {
        const double luminance = (referenceXyz(chromaticities) * nits)[1];
        nits *= 1000 * std::pow(luminance, 0.2);
    }
    // BT.2390, section 5.4: peak of the source 1000 cd/m^2, of the target 203, both blacks 0
    const double brightest = std::max({nits[0], nits[1], nits[2]});
    const double e1 = std::min(referencePq(brightest) / referencePq(1000), 1.0);
    const double maxLum = referencePq(203) / referencePq(1000);
    const double ks = 1.5 * maxLum - 0.5;
    double e2 = e1;
    if (e1 >= ks) {
        const double t = (e1 - ks) / (1 - ks);
        e2 = (2 * std::pow(t, 3) - 3 * t * t + 1) * ks +
             (std::pow(t, 3) - 2 * t * t + t) * (1 - ks) +
             (-2 * std::pow(t, 3) + 3 * t * t) * maxLum;
    }
    const double mapped = lightFromPq(e2 * referencePq(1000));
    if (brightest > 0) nits *= mapped / brightest;
    return encodedFromLinear(nits / 203, chromaticities);
}

namespace {

double clampedAt(const cv::Mat& values, int x, int y) {
    return values.at<double>(std::clamp(y, 0, values.rows - 1), std::clamp(x, 0, values.cols - 1));
}

// (4.7)
cv::Mat deblurred(const cv::Mat& given, double sigma) {
    const int radius = std::max(1, static_cast<int>(std::ceil(2.5 * sigma)));
    cv::Mat result = given.clone();
    for (int pass = 0; pass < 3; ++pass) {
        const cv::Mat before = result.clone();
        forPixels(given.size(), [&](int x, int y) {
            double sum = 0;
            double weights = 0;
            for (int j = -radius; j <= radius; ++j) {
                for (int i = -radius; i <= radius; ++i) {
                    const double weight = std::exp(-(i * i + j * j) / (2 * sigma * sigma));
                    sum += weight * clampedAt(before, x + i, y + j);
                    weights += weight;
                }
            }
            const double value = before.at<double>(y, x) + given.at<double>(y, x) - sum / weights;
            result.at<double>(y, x) = std::clamp(value, 0.0, 1.0);
        });
    }
    return result;
}

cv::Mat squaredSlopes(const cv::Mat& depth) {
    cv::Mat result(depth.size(), CV_64F);
    forPixels(depth.size(), [&](int x, int y) {
        const double across = clampedAt(depth, x + 1, y) - clampedAt(depth, x - 1, y);
        const double down = clampedAt(depth, x, y + 1) - clampedAt(depth, x, y - 1);
        result.at<double>(y, x) = (across * across + down * down) / 4;
    });
    return result;
}

// (4.7a)
cv::Mat withHardSteps(const cv::Mat& given, const cv::Mat& deblurred, double sigma) {
    const int r = static_cast<int>(std::lround(2 * sigma));
    const cv::Mat squares = squaredSlopes(given);
    cv::Mat result = deblurred.clone();
    for (int y = 0; y < given.rows; ++y) {
        for (int x = 0; x < given.cols; ++x) {
            double least = given.at<double>(y, x);
            double most = least;
            double steepest = 0;
            for (int j = -r; j <= r; ++j) {
                for (int i = -r; i <= r; ++i) {
                    least = std::min(least, clampedAt(given, x + i, y + j));
                    most = std::max(most, clampedAt(given, x + i, y + j));
                    steepest = std::max(steepest, clampedAt(squares, x + i, y + j));
                }
            }
            const double width = std::sqrt(2 * CV_PI * steepest) * sigma; // of a step of height 1
            if (width <= 1.8 * (most - least)) continue;
            const double hardness = width / (most - least);
            const double keep = std::clamp((hardness - 1.8) / 0.6, 0.0, 1.0);
            result.at<double>(y, x) =
                keep * given.at<double>(y, x) + (1 - keep) * deblurred.at<double>(y, x);
        }
    }
    return result;
}

// Means over the px of one side of a step.
struct SideSums {
    double weight = 0;
    double depth = 0;
    double color = 0;
};

// r and m of 4a.3, and the part of px that are decided.
struct StepRule {
    double width;
    int r;
    double part;
    double minHeight;
};

StepRule stepRule(double width, double part) {
    const int r = std::max(2, static_cast<int>(std::lround(0.9 * width)));
    return {width, r, part, std::min(std::max(0.006 * width, 0.03), 0.08)};
}

// (4.8) to (4.11)
double sharpenedPixel(const cv::Mat& photo, const cv::Mat& given, const cv::Mat& depth,
                      const cv::Mat& squaredSlope, const StepRule& rule, cv::Point at) {
    const int r = rule.r;
    const double own = depth.at<double>(at);
    double least = own;
    double most = own;
    double steepest = 0;
    for (int y = at.y - r; y <= at.y + r; ++y) {
        for (int x = at.x - r; x <= at.x + r; ++x) {
            least = std::min(least, clampedAt(depth, x, y));
            most = std::max(most, clampedAt(depth, x, y));
            steepest = std::max(steepest, clampedAt(squaredSlope, x, y));
        }
    }
    const double height = most - least;
    if (height < rule.minHeight || height > 1.5 * (rule.width + 1) * std::sqrt(steepest))
        return own;
    const int stride = (r + 5) / 6; // at most 6 px on each side
    SideSums sides[2];              // far, near
    for (int j = -(r / stride); j <= r / stride; ++j) {
        for (int i = -(r / stride); i <= r / stride; ++i) {
            const cv::Point q = at + stride * cv::Point(i, j);
            if (!cv::Rect({}, depth.size()).contains(q)) continue;
            const double d = depth.at<double>(q);
            const double a = (2 * d - most - least) / height;
            const double distance = stride * stride * (i * i + j * j);
            const double weight = a * a * std::exp(-distance / (2.0 * r * r));
            const cv::Vec3i difference =
                cv::Vec3i(photo.at<cv::Vec3b>(at)) - cv::Vec3i(photo.at<cv::Vec3b>(q));
            const int step = difference.dot(difference) / 16; // in steps of 16, 0 beyond 8192
            const double similar =
                step < 512 ? std::exp(-(step + 0.5) * 16 / (2 * 14.0 * 14.0)) : 0;
            SideSums& side = sides[a > 0 ? 1 : 0];
            side.weight += weight;
            side.depth += weight * d;
            side.color += weight * similar;
        }
    }
    for (SideSums& side : sides) {
        if (!(side.weight > 0)) return own;
        side.depth /= side.weight;
        side.color /= side.weight;
    }
    const auto& [far, near] = sides;
    const double place = (own - far.depth) / (near.depth - far.depth);
    if (std::abs(place - 0.5) > rule.part) return own;
    if (far.color > 0.8 && near.color > 0.8) return given.at<double>(at);
    const double vote = 6 * (2 * place - 1) + std::log((near.color + 0.02) / (far.color + 0.02));
    return far.depth + (near.depth - far.depth) * (std::clamp(vote, -1.0, 1.0) + 1) / 2;
}

} // namespace

cv::Mat referenceSharpenSteps(const cv::Mat& photo, const DepthFlaws& flaws, const cv::Mat& depth) {
    const double softness = flaws.softnessPixels;
    cv::Mat given;
    depth.convertTo(given, CV_64F);
    cv::Mat source = given;
    StepRule rule = stepRule(softness, 1);
    if (flaws.isBlurred) {
        const double sigma = (softness + 1) / 2.5;
        source = withHardSteps(given, deblurred(given, sigma), sigma);
        rule = stepRule(softness / 2, 1);
    }
    const auto pass = [&](const cv::Mat& flat, const cv::Mat& from, const StepRule& how) {
        const cv::Mat squares = squaredSlopes(from);
        cv::Mat to = pictureOf<double>(from.size(), [&](int x, int y) {
            return sharpenedPixel(photo, flat, from, squares, how, {x, y});
        });
        return to;
    };
    const cv::Mat once = pass(given, source, rule);
    const cv::Mat twice = pass(once, once, stepRule(2, 0.3));
    cv::Mat result(depth.size(), CV_32FC1);
    forPixels(depth.size(), [&](int x, int y) {
        std::vector<double> around;
        for (int v = y - 1; v <= y + 1; ++v)
            for (int u = x - 1; u <= x + 1; ++u)
                around.push_back(twice.at<double>(std::clamp(v, 0, depth.rows - 1),
                                                  std::clamp(u, 0, depth.cols - 1)));
        std::sort(around.begin(), around.end());
        const double own = twice.at<double>(y, x);
        const bool moved = std::abs(own - given.at<double>(y, x)) > 0.005;
        result.at<float>(y, x) = static_cast<float>(moved ? around[4] : own);
    });
    return result;
}

cv::Mat referenceSubjectWeights(const cv::Mat& photo, const cv::Mat& depth) {
    const auto nearAt = [&](int y, int x) {
        const float d = depth.at<float>(static_cast<int>((y + 0.5) * depth.rows / photo.rows),
                                        static_cast<int>((x + 0.5) * depth.cols / photo.cols));
        return std::isnan(d) ? 0.0 : static_cast<double>(d);
    };
    const auto brightness = [&](int y, int x) {
        const auto c =
            photo.at<cv::Vec3b>(std::min(y, photo.rows - 1), std::min(x, photo.cols - 1));
        return (29 * c[0] + 150 * c[1] + 77 * c[2] + 128) / 256;
    };
    cv::Mat weights(photo.size(), CV_32SC1);
    forPixels(photo.size(), [&](int x, int y) {
        double steps = 0;
        int places = 0;
        for (int v = std::max(0, y - 3); v <= std::min(photo.rows - 1, y + 3); ++v) {
            for (int u = std::max(0, x - 3); u <= std::min(photo.cols - 1, x + 3); ++u) {
                steps += std::abs(brightness(v, u + 1) - brightness(v, u)) +
                         std::abs(brightness(v + 1, u) - brightness(v, u));
                ++places;
            }
        }
        std::vector<double> row;
        for (int u = 0; u < photo.cols; ++u)
            row.push_back(nearAt(y, u));
        std::sort(row.begin(), row.end());
        const double usual = row[(row.size() - 1) / 4];
        const double d = nearAt(y, x);
        const double right = 2 * (x + 0.5) / photo.cols - 1;
        const double down = 2 * (y + 0.5) / photo.rows - 1;
        const double weight = (0.2 + 0.8 * std::min(1.0, steps / places / 32)) *
                              (0.02 + 0.18 * d + 0.8 * std::max(0.0, d - usual)) *
                              (1 - 0.45 * (right * right + down * down));
        weights.at<int>(y, x) = 1 + static_cast<int>(65534 * weight);
    });
    return weights;
}

cv::Rect referenceBestWindow(const cv::Mat& weights, cv::Size window) {
    cv::Rect best;
    double most = -1;
    int leastAway = 0;
    for (int y = 0; y + window.height <= weights.rows; ++y) {
        for (int x = 0; x + window.width <= weights.cols; ++x) {
            const int borderX = window.width / 4;
            const int borderY = window.height / 4;
            double sum = 0;
            for (int v = 0; v < window.height; ++v) {
                for (int u = 0; u < window.width; ++u) {
                    const bool inMiddle = u >= borderX && u < window.width - borderX &&
                                          v >= borderY && v < window.height - borderY;
                    sum += (inMiddle ? 2.0 : 1.0) * weights.at<int>(y + v, x + u);
                }
            }
            const int away = std::abs(2 * x + window.width - weights.cols) +
                             std::abs(2 * y + window.height - weights.rows);
            if (sum < most || (sum == most && away >= leastAway)) continue;
            most = sum;
            leastAway = away;
            best = {cv::Point(x, y), window};
        }
    }
    return best;
}

cv::Mat referenceDownscale(const cv::Mat& photo, int longestSide) {
    const int longer = std::max(photo.cols, photo.rows);
    if (longer <= longestSide) return photo.clone();
    const auto scaled = [&](int side) {
        return std::max(1L, std::lround(static_cast<double>(side) * longestSide / longer));
    };
    cv::Mat small(static_cast<int>(scaled(photo.rows)), static_cast<int>(scaled(photo.cols)),
                  CV_8UC3);
    // the px that a px of the small photo touches
    const auto touched = [](std::int64_t i, std::int64_t from, std::int64_t to) {
        return cv::Range(static_cast<int>(i * from / to),
                         static_cast<int>(((i + 1) * from + to - 1) / to));
    };
    forPixels(small.size(), [&](int x, int y) {
        const cv::Mat block =
            photo(touched(y, photo.rows, small.rows), touched(x, photo.cols, small.cols));
        std::array<std::int64_t, 3> total{};
        for (int j = 0; j < block.rows; ++j)
            for (int i = 0; i < block.cols; ++i)
                for (int c = 0; c < 3; ++c)
                    total[static_cast<std::size_t>(c)] += block.at<cv::Vec3b>(j, i)[c];
        const auto count = static_cast<std::int64_t>(block.total());
        for (int c = 0; c < 3; ++c)
            small.at<cv::Vec3b>(y, x)[c] =
                static_cast<uchar>((total[static_cast<std::size_t>(c)] + count / 2) / count);
    });
    return small;
}

} // namespace altiro3D::test
