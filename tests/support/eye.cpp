#include "support/eye.hpp"
#include "support/reference.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

namespace altiro3D::test {

namespace {

// BT.709, blue first.
const cv::Vec3f kLuminance(0.0722F, 0.7152F, 0.2126F);

cv::Mat blurred(const cv::Mat& picture, double sigma) {
    cv::Mat result;
    cv::GaussianBlur(picture, result, {}, sigma, sigma, cv::BORDER_REFLECT);
    return result;
}

cv::Vec2f labColour(const cv::Vec3f& bgr) {
    const cv::Matx33f toXyz(0.4124564F, 0.3575761F, 0.1804375F, 0.2126729F, 0.7151522F, 0.0721750F,
                            0.0193339F, 0.1191920F, 0.9503041F);
    const cv::Vec3f white(0.95047F, 1, 1.08883F);
    const cv::Vec3f xyz = toXyz * cv::Vec3f(bgr[2], bgr[1], bgr[0]);
    cv::Vec3f f;
    for (int i = 0; i < 3; ++i) {
        const float t = xyz[i] / white[i];
        f[i] = t > 216.0F / 24389 ? std::cbrt(t) : (24389.0F / 27 * t + 16) / 116;
    }
    return {500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

// A third of the width, by the width that is nearest to the sub-pixels of each colour.
cv::Vec3f gainsOf(const cv::Mat& places) {
    cv::Vec3d widths(0, 0, 0); // BGR
    for (int y = 0; y < places.rows; ++y) {
        std::vector<std::pair<double, int>> order;
        for (int i = 0; i < 3 * places.cols; ++i)
            order.emplace_back(places.ptr<double>(y)[i], 2 - i % 3);
        std::sort(order.begin(), order.end());
        for (std::size_t i = 1; i + 1 < order.size(); ++i)
            widths[order[i].second] += order[i + 1].first - order[i - 1].first;
    }
    cv::Vec3f gains;
    for (int i = 0; i < 3; ++i)
        gains[i] = static_cast<float>(cv::sum(widths)[0] / (3 * widths[i]));
    return gains;
}

} // namespace

cv::Mat lightOf(const cv::Mat& picture) {
    cv::Mat table(1, 256, CV_32FC1);
    for (int i = 0; i < 256; ++i)
        table.at<float>(i) = static_cast<float>(referenceLight(i / 255.0));
    cv::Mat light;
    cv::LUT(picture, table, light);
    return light;
}

LensTwin::LensTwin(const LensGeometry& lens)
    : places_(lens.panelHeight, lens.panelWidth, CV_64FC3) {
    const double perPixel =
        (lens.inverted ? -1 : 1) * lens.periodsPerWidth / static_cast<double>(lens.panelWidth);
    cv::parallel_for_(cv::Range(0, lens.panelHeight), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            const double start = lens.phase(0, y, 0);
            for (int x = 0; x < lens.panelWidth; ++x) {
                for (int channel = 0; channel < 3; ++channel) {
                    const double phase = lens.phase(x, y, channel);
                    places_.at<cv::Vec3d>(y, x)[channel] =
                        phase + std::round(start + x * perPixel - phase);
                }
            }
        }
    });
    if (!lens.cells.empty()) gains_ = gainsOf(places_.rowRange(0, 4)); // cells repeat
}

cv::Mat LensTwin::seen(const cv::Mat& light, double phase) const {
    cv::Mat seen(light.size(), CV_32FC3, cv::Scalar::all(0));
    cv::parallel_for_(cv::Range(0, light.rows), [&](const cv::Range& rows) {
        struct Lens {
            double distance = std::numeric_limits<double>::max();
            int x = 0;
            int channel = 0;
        };
        std::vector<Lens> lenses;
        for (int y = rows.start; y < rows.end; ++y) {
            const auto* places = places_.ptr<cv::Vec3d>(y);
            const auto lensOf = [&](int x, int channel) {
                return std::lround(places[x][channel] - phase);
            };
            const long first = std::min(lensOf(0, 0), lensOf(light.cols - 1, 0)) - 2;
            const long last = std::max(lensOf(0, 0), lensOf(light.cols - 1, 0)) + 2;
            lenses.assign(static_cast<std::size_t>(last - first + 1), {});
            const auto at = [&](int x, int channel) -> Lens& {
                return lenses[static_cast<std::size_t>(lensOf(x, channel) - first)];
            };
            for (int x = 0; x < light.cols; ++x) {
                for (int channel = 0; channel < 3; ++channel) {
                    const double away = places[x][channel] - phase;
                    const double distance = std::abs(away - std::round(away));
                    if (distance < at(x, channel).distance) at(x, channel) = {distance, x, channel};
                }
            }
            for (int x = 0; x < light.cols; ++x) { // a third of a px, the light of three sub-pixels
                for (int channel = 0; channel < 3; ++channel) {
                    const Lens& lit = at(x, channel);
                    const int index = 2 - lit.channel;
                    seen.at<cv::Vec3f>(y, x)[index] +=
                        gains_[index] * light.at<cv::Vec3f>(y, lit.x)[index];
                }
            }
        }
    });
    return seen;
}

EyePicture blurredByEye(const cv::Mat& light) {
    EyePicture picture;
    cv::Mat luminance;
    cv::transform(light, luminance, kLuminance.t());
    for (std::size_t i = 0; i < EyePicture::kSigmas.size(); ++i) {
        cv::Mat& coded = picture.luminance[i] = blurred(luminance, EyePicture::kSigmas[i]);
        coded.forEach<float>(
            [](float& value, const int*) { value = static_cast<float>(srgbCode(value)); });
    }
    const cv::Mat colours = blurred(light, EyePicture::kColourSigma);
    picture.colour.create(light.size(), CV_32FC2);
    picture.colour.forEach<cv::Vec2f>([&colours](cv::Vec2f& colour, const int* at) {
        colour = labColour(colours.at<cv::Vec3f>(at[0], at[1]));
    });
    return picture;
}

EyeDifference eyeDifference(const EyePicture& picture, const EyePicture& truth) {
    constexpr int kBorder = 24; // px
    const cv::Rect inner(kBorder, kBorder, truth.colour.cols - 2 * kBorder,
                         truth.colour.rows - 2 * kBorder);
    EyeDifference difference;
    for (std::size_t i = 0; i < truth.luminance.size(); ++i) {
        const double squares =
            cv::norm(picture.luminance[i](inner), truth.luminance[i](inner), cv::NORM_L2SQR);
        difference.luminancePsnr[i] = -10 * std::log10(squares / inner.area());
    }
    const cv::Mat apart = picture.colour(inner) - truth.colour(inner);
    cv::Mat parts[2];
    cv::split(apart, parts);
    cv::Mat distance;
    cv::magnitude(parts[0], parts[1], distance);
    difference.chroma = cv::mean(distance)[0];
    return difference;
}

} // namespace altiro3D::test
