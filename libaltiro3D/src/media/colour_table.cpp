#include "media/video_picture.hpp"

#include "base/srgb_light.hpp"
#include "image/colour.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <utility>

namespace altiro3D {

namespace {

constexpr int kNodes = 65;
constexpr float kMost = 65535;
constexpr int kLights = 8192; // less than a quarter of a level apart
constexpr int kLinear = 8;
constexpr int kSrgb = 13;
constexpr int kPq = 16;
constexpr int kHlg = 18;
constexpr double kWhite = 203; // cd/m², BT.2408
constexpr double kPqPeak = 10000;
constexpr double kHlgPeak = 1000; // cd/m²: peak of a display for HLG; brighter light is clamped
constexpr double kHlgGamma = 1.2;
constexpr double kVideoGamma = 2.4;

// Displayed light of an encoded value, in units of white.
double lightOf(double value, int transfer) {
    if (transfer == kPq) return linearLight(value, kPq) * kPqPeak / kWhite;
    if (transfer == kHlg) return std::pow(linearLight(value, kHlg), kHlgGamma) * kHlgPeak / kWhite;
    if (transfer == kLinear) return value;
    if (transfer == kSrgb) return lightOfSrgb(value);
    return std::pow(value, kVideoGamma);
}

double valueOf(double light, int transfer) {
    const bool isSrgb =
        transfer == kLinear || transfer == kSrgb || transfer == kPq || transfer == kHlg;
    return isSrgb ? srgbOf(light) : std::pow(light, 1 / kVideoGamma);
}

// The place of a value between two nodes.
struct Place {
    explicit Place(std::uint16_t value) {
        const float at = static_cast<float>(value) * ((kNodes - 1) / kMost);
        node = std::min(static_cast<int>(at), kNodes - 2);
        share = at - static_cast<float>(node);
    }
    int node;
    float share;
};

} // namespace

double videoToneMapped(double light) {
    constexpr double kKnee = 0.97;
    if (light <= kKnee) return light;
    constexpr double kLargest = (kHlgPeak / kWhite - kKnee) / (1 - kKnee);
    const double beyond = std::min((light - kKnee) / (1 - kKnee), kLargest);
    const double share = beyond * (1 + beyond / (kLargest * kLargest)) / (1 + beyond);
    return kKnee + (1 - kKnee) * share;
}

ColourTable::ColourTable(int primaries, int transfer) {
    const bool isHdr = transfer == kPq || transfer == kHlg;
    const cv::Matx33d toSrgb = toSrgbLight(primaries);
    std::array<double, kNodes> lights{};
    for (int i = 0; i < kNodes; ++i)
        lights[static_cast<std::size_t>(i)] =
            lightOf(static_cast<double>(i) / (kNodes - 1), transfer);
    nodes_.reserve(std::size_t{kNodes} * kNodes * kNodes);
    for (const double blue : lights) {
        for (const double green : lights) {
            for (const double red : lights) {
                cv::Vec3d light(red, green, blue);
                const double most = std::max({red, green, blue});
                if (isHdr && most > 0) light *= videoToneMapped(most) / most;
                light = toSrgb * light;
                nodes_.push_back({static_cast<float>(light[2]), static_cast<float>(light[1]),
                                  static_cast<float>(light[0])});
            }
        }
    }
    encoded_.resize(kLights);
    for (int i = 0; i < kLights; ++i) {
        const double root = static_cast<double>(i) / (kLights - 1);
        encoded_[static_cast<std::size_t>(i)] =
            static_cast<float>(255 * valueOf(root * root, transfer));
    }
}

// Tetrahedral interpolation: from the darkest node of the cell to the brightest, along the largest
// share first.
void ColourTable::row(const std::uint16_t* from, int channels, int columns,
                      std::uint8_t* to) const {
    constexpr int kSteps[3] = {kNodes * kNodes, kNodes, 1};
    for (int x = 0; x < columns; ++x, from += channels, to += 3) {
        float colour[3];
        if (nodes_.empty()) {
            for (int c = 0; c < 3; ++c)
                colour[c] = static_cast<float>(from[c]) * (255 / kMost);
        } else {
            const Place places[3] = {Place(from[0]), Place(from[1]), Place(from[2])};
            int order[3] = {0, 1, 2};
            const auto sort = [&](int a, int b) {
                if (places[order[a]].share < places[order[b]].share) std::swap(order[a], order[b]);
            };
            sort(0, 1);
            sort(1, 2);
            sort(0, 1);
            const std::array<float, 3>* node = nodes_.data();
            for (int c = 0; c < 3; ++c)
                node += places[c].node * kSteps[c];
            const float shares[5] = {1, places[order[0]].share, places[order[1]].share,
                                     places[order[2]].share, 0};
            float light[3] = {0, 0, 0};
            for (int k = 0; k < 4; ++k) {
                for (std::size_t c = 0; c < 3; ++c)
                    light[c] += (shares[k] - shares[k + 1]) * (*node)[c];
                if (k < 3) node += kSteps[order[k]];
            }
            for (int c = 0; c < 3; ++c) {
                const float root = std::sqrt(std::clamp(light[c], 0.0F, 1.0F));
                colour[c] = encoded_[static_cast<std::size_t>(root * (kLights - 1) + 0.5F)];
            }
        }
        constexpr int kOpaque = 0xff00; // 8 bits that the scaler has made 16
        const float alpha =
            channels == 4 && from[3] < kOpaque ? static_cast<float>(from[3]) / kOpaque : 1;
        for (int c = 0; c < 3; ++c)
            to[c] = static_cast<std::uint8_t>(colour[c] * alpha + 0.5F);
    }
}

} // namespace altiro3D
