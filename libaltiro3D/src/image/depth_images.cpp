#include "altiro3D/image_io.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "image/image_read.hpp"
#include "image/picture_halves.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string_view>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// The second difference that a share of the px does not exceed, in standard deviations.
double bendOf(const cv::Mat& grey, double share) {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(grey, mean, deviation);
    std::vector<float> bends;
    for (int y = 1; y + 1 < grey.rows; ++y) {
        for (int x = 1; x + 1 < grey.cols; ++x) {
            const float twice = 2 * grey.at<float>(y, x);
            bends.push_back(
                std::max(std::abs(grey.at<float>(y, x - 1) + grey.at<float>(y, x + 1) - twice),
                         std::abs(grey.at<float>(y - 1, x) + grey.at<float>(y + 1, x) - twice)));
        }
    }
    const auto rank = static_cast<std::size_t>(share * static_cast<double>(bends.size() - 1));
    return static_cast<double>(valueOfRank(bends, rank)) / deviation[0];
}

// How many of 64 steps between the smallest and the largest value hold 0.5 % of the px or more.
int wideLevels(const cv::Mat& grey) {
    constexpr int kSteps = 64;
    double least = 0;
    double largest = 0;
    cv::minMaxLoc(grey, &least, &largest);
    if (!(largest > least)) return 1;
    std::array<std::size_t, kSteps> counts{};
    for (int y = 0; y < grey.rows; ++y) {
        const float* const row = grey.ptr<float>(y);
        for (int x = 0; x < grey.cols; ++x) {
            const double place = (static_cast<double>(row[x]) - least) / (largest - least);
            ++counts[static_cast<std::size_t>(std::clamp(place * kSteps, 0.0, kSteps - 1.0))];
        }
    }
    return static_cast<int>(std::count_if(counts.begin(), counts.end(), [&](std::size_t count) {
        return count * 200 >= grey.total();
    }));
}

constexpr int kLevels = 256;
constexpr int kBlack = 32;     // px without a brighter channel are black
constexpr int kTolerance = 32; // distance in RGB; compression causes less, edges excepted

struct ColourMap {
    const char* name = nullptr;
    const char* whiteEnd = nullptr; // the colour of level 255
    // Colours of the levels.
    std::array<std::int32_t, kLevels> blue = {};
    std::array<std::int32_t, kLevels> green = {};
    std::array<std::int32_t, kLevels> red = {};
    bool hasBlack = false;
};

// @param colourOf the colour of a place 0..1 of the map, BGR, 0..255
template <class ColourOf>
ColourMap makeMap(const char* name, const char* whiteEnd, ColourOf colourOf) {
    ColourMap map;
    map.name = name;
    map.whiteEnd = whiteEnd;
    for (std::size_t i = 0; i < kLevels; ++i) {
        const cv::Vec3d colour = colourOf(static_cast<double>(i) / (kLevels - 1));
        map.blue[i] = cvRound(std::clamp(colour[0], 0.0, 255.0));
        map.green[i] = cvRound(std::clamp(colour[1], 0.0, 255.0));
        map.red[i] = cvRound(std::clamp(colour[2], 0.0, 255.0));
        if (std::max({map.blue[i], map.green[i], map.red[i]}) < kBlack) map.hasBlack = true;
    }
    return map;
}

ColourMap makeMap(const char* name, const char* whiteEnd, cv::ColormapTypes type) {
    cv::Mat levels(1, kLevels, CV_8UC1);
    for (int i = 0; i < kLevels; ++i)
        levels.at<std::uint8_t>(i) = static_cast<std::uint8_t>(i);
    cv::Mat colours;
    cv::applyColorMap(levels, colours, type);
    return makeMap(name, whiteEnd, [&](double place) -> cv::Vec3d {
        return colours.at<cv::Vec3b>(cvRound(place * (kLevels - 1)));
    });
}

// Straight lines between evenly spaced colours, BGR.
cv::Vec3d between(const std::vector<cv::Vec3d>& colours, double place) {
    const double position = place * static_cast<double>(colours.size() - 1);
    const auto first = std::min(static_cast<std::size_t>(position), colours.size() - 2);
    const double share = position - static_cast<double>(first);
    return colours[first] * (1 - share) + colours[first + 1] * share;
}

// Jet as Matplotlib draws it; that of MATLAB and OpenCV differs.
cv::Vec3d matplotlibJet(double place) {
    const auto ramp = [](double from, double to, double x) {
        return std::clamp((x - from) / (to - from), 0.0, 1.0);
    };
    const double blue = 0.5 + 0.5 * ramp(0, 0.11, place) - ramp(0.34, 0.65, place);
    const double green = ramp(0.125, 0.375, place) - ramp(0.64, 0.91, place);
    const double red = ramp(0.35, 0.66, place) - 0.5 * ramp(0.89, 1, place);
    return cv::Vec3d(blue, green, red) * 255;
}

// Maps of one name differ only slightly.
const std::vector<ColourMap>& colourMaps() {
    static const std::vector<ColourMap> maps = [] {
        // ColorBrewer's Spectral of 11 colours, from blue to red
        const std::vector<cv::Vec3d> spectral = {{162, 79, 94},   {189, 136, 50},  {165, 194, 102},
                                                 {164, 221, 171}, {152, 245, 230}, {191, 255, 255},
                                                 {139, 224, 254}, {97, 174, 253},  {67, 109, 244},
                                                 {79, 62, 213},   {66, 1, 158}};
        // red, yellow, green, cyan, blue, magenta, red
        const std::vector<cv::Vec3d> hue = {{0, 0, 255}, {0, 255, 255}, {0, 255, 0}, {255, 255, 0},
                                            {255, 0, 0}, {255, 0, 255}, {0, 0, 255}};
        return std::vector<ColourMap>{
            makeMap("turbo", "red", cv::COLORMAP_TURBO),
            makeMap("jet", "red", cv::COLORMAP_JET),
            makeMap("jet", "red", matplotlibJet),
            makeMap("Spectral", "red", [&](double place) { return between(spectral, place); }),
            makeMap("inferno", "yellow", cv::COLORMAP_INFERNO),
            makeMap("magma", "yellow", cv::COLORMAP_MAGMA),
            makeMap("viridis", "yellow", cv::COLORMAP_VIRIDIS),
            makeMap("plasma", "yellow", cv::COLORMAP_PLASMA),
            makeMap("hue", "hue 1", [&](double place) { return between(hue, place); })};
    }();
    return maps;
}

bool isBlack(const cv::Vec3b& px) {
    return std::max({px[0], px[1], px[2]}) < kBlack;
}

// The nearest colour of a map.
struct Nearest {
    int level = 0;
    int squaredDistance = 0;
};
Nearest nearestOf(const ColourMap& map, const cv::Vec3b& px) {
    std::int32_t least = INT32_MAX; // least distance and its level, in one number
    for (std::int32_t i = 0; i < kLevels; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const std::int32_t blue = map.blue[at] - px[0];
        const std::int32_t green = map.green[at] - px[1];
        const std::int32_t red = map.red[at] - px[2];
        least = std::min(least, (blue * blue + green * green + red * red) * kLevels + i);
    }
    return {least % kLevels, least / kLevels};
}

// How well a map explains a picture.
struct Fit {
    const ColourMap* map = nullptr;
    bool isOnCurve = false; // nearly all px are, and some are coloured
    bool isSpread = false;  // the px spread over a part of the map
    double distance = 0;    // mean, RGB
    cv::Mat levels;         // levels of the px, CV_32F
};

Fit fitOf(const ColourMap& map, const std::vector<cv::Vec3b>& pixels) {
    constexpr double kShareOnCurve = 0.85;
    constexpr double kShareOfColours = 0.1;
    constexpr double kShareSeen = 0.25;
    constexpr int kColourful = 48; // largest minus least channel
    constexpr int kSpread = 24;    // levels between the 5th and the 95th percentile
    Fit fit;
    fit.map = &map;
    std::vector<float> levels;
    std::size_t onCurve = 0;
    std::size_t colourful = 0;
    for (const cv::Vec3b& px : pixels) {
        if (!map.hasBlack && isBlack(px)) continue;
        const Nearest nearest = nearestOf(map, px);
        levels.push_back(static_cast<float>(nearest.level));
        const double distance = std::sqrt(nearest.squaredDistance);
        fit.distance += std::min<double>(distance, 2 * kTolerance);
        const auto [least, most] = std::minmax({px[0], px[1], px[2]});
        if (distance > kTolerance) continue;
        ++onCurve;
        if (most - least > kColourful) ++colourful;
    }
    const auto all = static_cast<double>(pixels.size());
    const auto seen = static_cast<double>(levels.size());
    if (seen < all * kShareSeen || levels.empty()) return fit;
    fit.distance /= seen;
    fit.levels = cv::Mat(levels, true);
    std::sort(levels.begin(), levels.end());
    const float spread =
        levels[levels.size() - 1 - levels.size() / 20] - levels[levels.size() / 20];
    fit.isSpread = spread >= kSpread;
    fit.isOnCurve = static_cast<double>(onCurve) >= kShareOnCurve * seen &&
                    static_cast<double>(colourful) >= kShareOfColours * seen;
    return fit;
}

// Whether two maps give the px the same order.
bool doAgree(const Fit& one, const Fit& other) {
    constexpr double kAgreement = 0.9;
    if (one.levels.size() != other.levels.size()) return true; // only one map has black
    cv::Mat correlation;
    cv::matchTemplate(one.levels, other.levels, correlation, cv::TM_CCOEFF_NORMED);
    return correlation.at<float>(0) >= kAgreement;
}

// Evenly spaced px.
std::vector<cv::Vec3b> sampled(const cv::Mat& picture) {
    constexpr int kMaxSide = 64;
    const int stepX = picture.cols / kMaxSide + 1;
    const int stepY = picture.rows / kMaxSide + 1;
    std::vector<cv::Vec3b> pixels;
    for (int y = stepY / 2; y < picture.rows; y += stepY)
        for (int x = stepX / 2; x < picture.cols; x += stepX)
            pixels.push_back(picture.at<cv::Vec3b>(y, x));
    return pixels;
}

const ColourMap* findColourMap(const cv::Mat& picture, const std::string& subject) {
    constexpr double kClose = 4; // difference of mean distances, RGB
    const std::vector<cv::Vec3b> pixels = sampled(picture);
    std::vector<Fit> fits;
    for (const ColourMap& map : colourMaps()) {
        Fit fit = fitOf(map, pixels);
        if (fit.isOnCurve) fits.push_back(std::move(fit));
    }
    if (std::none_of(fits.begin(), fits.end(), [](const Fit& fit) { return fit.isSpread; }))
        return nullptr;
    const auto best = std::min_element(fits.begin(), fits.end(), [](const Fit& a, const Fit& b) {
        return a.distance < b.distance;
    });
    for (const Fit& fit : fits) {
        if (fit.distance < best->distance + kClose && !doAgree(fit, *best)) {
            throw Error(ErrorCode::BadFormat, subject,
                        std::string("the depth is drawn in colours that both ") + best->map->name +
                            " and " + fit.map->name +
                            " contain, expected grey depth or more of the colours of one map");
        }
    }
    return best->map;
}

} // namespace

cv::Mat smallGrey(const cv::Mat& picture) {
    constexpr double kMaxSide = 256;
    cv::Mat grey;
    cv::extractChannel(picture, grey, 1);
    grey.convertTo(grey, CV_32F);
    grey = mapped<float, float>(grey, [](float v) { return std::isfinite(v) ? v : 0.0F; });
    const double scale = kMaxSide / std::max(grey.cols, grey.rows);
    if (scale >= 1) return grey;
    const cv::Size size(std::max(1, static_cast<int>(std::lround(grey.cols * scale))),
                        std::max(1, static_cast<int>(std::lround(grey.rows * scale))));
    cv::Mat small;
    cv::resize(grey, small, size, 0, 0, cv::INTER_AREA);
    return small;
}

bool looksLikeDepthImage(const cv::Mat& picture) try {
    constexpr int kMinSide = 16;      // px
    constexpr double kMaxBend = 0.03; // measured: docs/depth.md
    constexpr double kSmoothShare = 0.7;
    constexpr int kMinLevels = 8;
    checkType(picture, {CV_8UC3, CV_16UC3, CV_32FC3}, "picture",
              "three channels of 8 or 16 bits or of floats");
    if (std::min(picture.cols, picture.rows) < kMinSide || hasColours(picture)) return false;
    const cv::Mat grey = smallGrey(picture);
    if (std::min(grey.cols, grey.rows) < kMinSide) return false;
    return wideLevels(grey) >= kMinLevels && bendOf(grey, kSmoothShare) <= kMaxBend;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

std::string reasonAgainstDepth(const cv::Mat& samples, cv::Size photo) try {
    checkType(samples, {CV_8UC1, CV_16UC1, CV_32FC1, CV_64FC1}, "samples",
              "one channel of 8 or 16 bits or of floats");
    if (!haveOneShape(samples.size(), photo))
        return "its shape, " + sizeText(samples.size()) + ", is not that of the photo, " +
               sizeText(photo);
    cv::Mat numbers;
    samples.convertTo(numbers, CV_32F);
    std::vector<float> values;
    for (const float value : cv::Mat_<float>(numbers)) {
        if (std::isfinite(value)) values.push_back(value);
    }
    if (values.empty()) return "it is flat";
    const double low = static_cast<double>(percentileOf(values, 0.005));
    const double high = static_cast<double>(percentileOf(values, 0.995));
    const bool isFlat = (high - low) * 255 < std::max(std::abs(low), std::abs(high)) || high == low;
    return isFlat ? "it is flat" : "";
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

bool hasColours(const cv::Mat& picture) try {
    checkType(picture, {CV_8UC3, CV_16UC3, CV_32FC3, CV_64FC3}, "picture",
              "three channels of 8 or 16 bits or of floats");
    constexpr int kMaxRows = 512; // large pictures are sampled
    const int step = picture.rows / kMaxRows + 1;
    cv::Mat rows;
    for (int y = 0; y < picture.rows; y += step)
        rows.push_back(picture.row(y));
    rows.convertTo(rows, CV_32F);
    double white = picture.depth() == CV_8U ? 255 : 65535;
    if (picture.depth() >= CV_32F)
        white = cv::norm(rows, cv::NORM_INF); // floats have no fixed range
    std::int64_t coloured = 0;
    for (int y = 0; y < rows.rows; ++y) {
        const auto* pixel = rows.ptr<cv::Vec3f>(y);
        for (int x = 0; x < rows.cols; ++x) {
            const auto [least, most] = std::minmax({pixel[x][0], pixel[x][1], pixel[x][2]});
            if (most - least > white / 16) ++coloured;
        }
    }
    return coloured * 50 > static_cast<std::int64_t>(rows.total());
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

cv::Mat undoColourMap(const cv::Mat& picture, const std::string& subject, Notes* notes) {
    if (picture.type() != CV_8UC3 && picture.type() != CV_16UC3) return {};
    if (!hasColours(picture)) return {};
    const cv::Mat pixels = picture.depth() == CV_8U ? picture : toEightBits(picture);
    const ColourMap* const map = findColourMap(pixels, subject);
    if (map == nullptr) return {};
    addNote(notes, NoteCode::Converted,
            std::string("the depth is drawn in the colour map ") + map->name +
                ", which is undone: " + map->whiteEnd +
                " counts as white, near unless you say otherwise");
    cv::Mat levels(pixels.size(), CV_8UC1);
    overRows(pixels.rows, [&](int y) {
        const cv::Vec3b* const px = pixels.ptr<cv::Vec3b>(y);
        std::uint8_t* const level = levels.ptr(y);
        for (int x = 0; x < pixels.cols; ++x) {
            if (x > 0 && px[x] == px[x - 1]) {
                level[x] = level[x - 1];
            } else if (!map->hasBlack && isBlack(px[x])) {
                level[x] = 0;
            } else {
                level[x] = static_cast<std::uint8_t>(nearestOf(*map, px[x]).level);
            }
        }
    });
    return levels;
}

} // namespace altiro3D
