#include "image/image_read.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "support/files.hpp"
#include "support/picture_files.hpp"
#include "support/pixels.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>
#include <vector>

using namespace altiro3D;
using namespace altiro3D::test;

namespace {

// A floor that comes nearer to the bottom, a wall, two balls and a pole. [CV_8UC1, 10..245]
cv::Mat trueDepth() {
    cv::Mat depth(240, 320, CV_8UC1);
    for (int y = 0; y < depth.rows; ++y)
        depth.row(y).setTo(y < 80 ? 10 + y / 4 : 30 + (y - 80));
    const auto ball = [&](cv::Point centre, int radius, int nearest) {
        for (int y = -radius; y <= radius; ++y) {
            for (int x = -radius; x <= radius; ++x) {
                const double inside = radius * radius - x * x - y * y;
                if (inside < 0) continue;
                depth.at<std::uint8_t>(centre.y + y, centre.x + x) =
                    static_cast<std::uint8_t>(nearest + (std::sqrt(inside) - radius) / 2);
            }
        }
    };
    ball({90, 130}, 50, 170);
    ball({230, 170}, 60, 245);
    depth(cv::Rect(150, 20, 12, 200)).setTo(215);
    return depth;
}

struct Map {
    const char* name;
    std::function<cv::Vec3b(std::uint8_t)> colourOf; // BGR
};

Map openCvMap(const char* name, cv::ColormapTypes type) {
    return {name, [type](std::uint8_t value) {
                cv::Mat colour;
                cv::applyColorMap(cv::Mat(1, 1, CV_8UC1, cv::Scalar(value)), colour, type);
                return colour.at<cv::Vec3b>(0);
            }};
}

// Matplotlib's Spectral_r: ColorBrewer's eleven colours, RGB, here from blue to red.
cv::Vec3b spectral(std::uint8_t value) {
    constexpr std::uint32_t kColours[] = {0x5e4fa2, 0x3288bd, 0x66c2a5, 0xabdda4,
                                          0xe6f598, 0xffffbf, 0xfee08b, 0xfdae61,
                                          0xf46d43, 0xd53e4f, 0x9e0142};
    const double place = value / 25.5;
    const int first = std::min(static_cast<int>(place), 9);
    cv::Vec3b colour;
    for (int i = 0; i < 3; ++i) {
        const double from = (kColours[first] >> (8 * i)) & 255U;
        const double to = (kColours[first + 1] >> (8 * i)) & 255U;
        colour[i] = cv::saturate_cast<std::uint8_t>(from + (to - from) * (place - first));
    }
    return colour;
}

// Full saturation and brightness; Record3D's metres are three times the hue.
cv::Vec3b hue(std::uint8_t value) {
    cv::Mat bgr;
    cv::cvtColor(cv::Mat(1, 1, CV_32FC3, cv::Scalar(value / 255.0 * 360, 1, 1)), bgr,
                 cv::COLOR_HSV2BGR);
    cv::Vec3b colour;
    for (int i = 0; i < 3; ++i)
        colour[i] = cv::saturate_cast<std::uint8_t>(255 * bgr.at<cv::Vec3f>(0)[i]);
    return colour;
}

std::vector<Map> allMaps() {
    return {openCvMap("turbo", cv::COLORMAP_TURBO),
            openCvMap("jet", cv::COLORMAP_JET),
            {"Spectral", spectral},
            openCvMap("inferno", cv::COLORMAP_INFERNO),
            openCvMap("magma", cv::COLORMAP_MAGMA),
            openCvMap("viridis", cv::COLORMAP_VIRIDIS),
            openCvMap("plasma", cv::COLORMAP_PLASMA),
            {"hue", hue}};
}

cv::Mat drawn(const cv::Mat& values, const Map& map) {
    std::vector<cv::Vec3b> colours;
    for (int value = 0; value < 256; ++value)
        colours.push_back(map.colourOf(static_cast<std::uint8_t>(value)));
    return pictureOf<cv::Vec3b>(
        values.size(), [&](int x, int y) { return colours[values.at<std::uint8_t>(y, x)]; });
}

double correlation(const cv::Mat& levels, const cv::Mat& truth) {
    cv::Mat numbers[2];
    levels.convertTo(numbers[0], CV_32F);
    truth.convertTo(numbers[1], CV_32F);
    return rankCorrelation(numbers[0], numbers[1]);
}

} // namespace

TEST(ColourMaps, AreUndoneInBothDirections) {
    ALTIRO3D_TAKES(3);
    const cv::Mat truth = trueDepth();
    for (const Map& map : allMaps()) {
        for (const bool isTurned : {false, true}) {
            SCOPED_TRACE(std::string(map.name) + (isTurned ? " turned" : ""));
            const cv::Mat values = isTurned ? cv::Mat(255 - truth) : truth;
            Notes notes;
            const cv::Mat levels = undoColourMap(drawn(values, map), "d.png", &notes);
            ASSERT_EQ(levels.type(), CV_8UC1);
            EXPECT_LE(cv::norm(levels, values, cv::NORM_INF), 2); // some maps repeat colours
            EXPECT_GT(correlation(levels, values), 0.9999);
            EXPECT_EQ(only(notes).code, NoteCode::Converted);
            EXPECT_TRUE(holds(only(notes).text, std::string("colour map ") + map.name + ","));
        }
    }
}

TEST(ColourMaps, AreUndoneAfterJpegCompression) {
    ALTIRO3D_TAKES(3);
    const cv::Mat truth = trueDepth();
    for (const Map& map : allMaps()) {
        for (const int quality : {75, 95}) {
            SCOPED_TRACE(std::string(map.name) + " " + std::to_string(quality));
            const cv::Mat levels =
                undoColourMap(compressed(drawn(truth, map), quality), "d.jpg", nullptr);
            ASSERT_FALSE(levels.empty());
            EXPECT_GT(correlation(levels, truth), 0.99);
        }
    }
}

TEST(ColourMaps, JetOfMatplotlibIsUndone) {
    // its documented corners: place, red, green, blue
    const std::vector<cv::Vec4d> corners = {{0, 0, 0, 0.5},
                                            {0.11, 0, 0, 1},
                                            {0.125, 0, 0, 1},
                                            {0.34, 0, 0.86, 1},
                                            {0.35, 0, 0.9, 0.9677},
                                            {0.375, 0.0806, 1, 0.8871},
                                            {0.64, 0.9355, 1, 0.0323},
                                            {0.65, 0.9677, 0.963, 0},
                                            {0.66, 1, 0.9259, 0},
                                            {0.89, 1, 0.0741, 0},
                                            {0.91, 0.9091, 0, 0},
                                            {1, 0.5, 0, 0}};
    const Map map{"jet", [&](std::uint8_t value) {
                      const double place = value / 255.0;
                      std::size_t i = 1;
                      while (corners[i][0] < place)
                          ++i;
                      const double share =
                          (place - corners[i - 1][0]) / (corners[i][0] - corners[i - 1][0]);
                      const cv::Vec4d rgb =
                          (corners[i - 1] * (1 - share) + corners[i] * share) * 255;
                      return cv::Vec3b(cv::saturate_cast<std::uint8_t>(rgb[3]),
                                       cv::saturate_cast<std::uint8_t>(rgb[2]),
                                       cv::saturate_cast<std::uint8_t>(rgb[1]));
                  }};
    const cv::Mat truth = trueDepth();
    const cv::Mat levels = undoColourMap(drawn(truth, map), "d.png", nullptr);
    ASSERT_FALSE(levels.empty());
    EXPECT_LE(cv::norm(levels, truth, cv::NORM_INF), 4); // blue is the same from 0.11 to 0.125
}

TEST(ColourMaps, BlackPxAreUnknownUnlessTheMapHasBlack) {
    const cv::Mat truth = trueDepth();
    const cv::Rect hole(20, 20, 100, 90);
    for (const Map& map : allMaps()) {
        SCOPED_TRACE(map.name);
        cv::Mat picture = drawn(truth, map);
        picture(hole).setTo(cv::Scalar::all(0));
        const cv::Mat levels = undoColourMap(picture, "d.png", nullptr);
        ASSERT_FALSE(levels.empty());
        cv::Mat expected = truth.clone();
        expected(hole).setTo(0);
        EXPECT_LE(cv::norm(levels, expected, cv::NORM_INF), 2);
    }
}

TEST(ColourMaps, SixteenBitPicturesAreUndone) {
    const cv::Mat truth = trueDepth();
    cv::Mat picture;
    drawn(truth, allMaps()[0]).convertTo(picture, CV_16U, 257);
    const cv::Mat levels = undoColourMap(picture, "d.png", nullptr);
    ASSERT_FALSE(levels.empty());
    EXPECT_LE(cv::norm(levels, truth, cv::NORM_INF), 1);
}

TEST(ColourMaps, ColoursOfTwoMapsThatContradictAreRefused) {
    const cv::Mat parts = trueDepth() / 5 + 40; // blue to cyan, which jet and hue contain
    EXPECT_EQ(errorOf([&] { undoColourMap(drawn(parts, allMaps()[1]), "d.png", nullptr); }),
              "d.png: the depth is drawn in colours that both jet and hue contain, expected grey "
              "depth or more of the colours of one map");
}

TEST(ColourMaps, GreyAndOtherPicturesAreNotTakenForThem) {
    const cv::Mat truth = trueDepth();
    cv::Mat grey;
    cv::cvtColor(truth, grey, cv::COLOR_GRAY2BGR);
    cv::Mat red;
    cv::merge(std::vector<cv::Mat>{cv::Mat(truth / 4), cv::Mat(truth / 4), truth}, red);
    cv::Mat sepia;
    cv::merge(std::vector<cv::Mat>{cv::Mat(truth * 0.6), cv::Mat(truth * 0.8), truth}, sepia);
    const Map hot = openCvMap("hot", cv::COLORMAP_HOT);
    const cv::Mat pictures[] = {grey,
                                compressed(grey, 75),
                                red,
                                sepia,
                                drawn(truth, hot),
                                drawn(truth / 16 + 120, allMaps()[0]), // hardly any depth
                                randomPhoto({64, 48}, 3),
                                cv::Mat(40, 40, CV_8UC3, cv::Scalar(255, 0, 0)),
                                cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(0)),
                                truth};
    int index = 0;
    for (const cv::Mat& picture : pictures) {
        EXPECT_TRUE(undoColourMap(picture, "p", nullptr).empty()) << index;
        ++index;
    }
}
