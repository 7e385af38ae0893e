#include "altiro3D/quilt2native.hpp"

#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/pixels.hpp"

#include <array>
#include <clocale>
#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <regex>

namespace altiro3D::test {
namespace {

float fract(float a) {
    return a - std::floor(a);
}

// The shader in C++: the numbers come from its text, and each operation is one of 32-bit floats.
class Twin {
  public:
    Twin(const std::string& text, const LensGeometry& geometry) : geometry_(geometry) {
        const std::vector<float> starts = numbers(text, "vec3 starts\\[\\d\\]");
        for (std::size_t i = 0; i < starts.size(); i += 3)
            starts_.push_back({starts[i], starts[i + 1], starts[i + 2]});
        across_ = numbers(text, "vec2 across");
        down_ = numbers(text, "vec2 down");
        panel_ = numbers(text, "vec2 panel");
        grid_ = numbers(text, "vec2 grid");
        views_ = numbers(text, "float views").at(0);
    }

    float views() const { return views_; }

    float phase(int column, int row, int colour) const {
        const auto cell = static_cast<std::size_t>(geometry_.cellIndex(column, row));
        const auto k = static_cast<std::size_t>(colour);
        const auto x = static_cast<float>(column);
        const auto y = static_cast<float>(row);
        const float sum =
            fract(x * across_[0]) + x * across_[1] + (fract(y * down_[0]) + y * down_[1]);
        return fract(sum + starts_.at(cell)[k]);
    }

    // Centre of the px of a quilt that a view shows at a pixel; with linear sampling a place
    // between px.
    cv::Point2f placeOf(float view, int column, int row, cv::Size quilt, bool isLinear) const {
        float u = (static_cast<float>(column) + 0.5F) / panel_[0];
        float v = (static_cast<float>(row) + 0.5F) / panel_[1];
        if (geometry_.mirrorX) u = 1 - u;
        if (geometry_.mirrorY) v = 1 - v;
        const float up = std::floor((view + 0.5F) / grid_[0]);
        return {
            along(view - up * grid_[0], u, static_cast<float>(quilt.width) / grid_[0], isLinear),
            along(grid_[1] - 1 - up, v, static_cast<float>(quilt.height) / grid_[1], isLinear)};
    }

  private:
    static std::vector<float> numbers(const std::string& text, const std::string& name) {
        std::smatch match;
        EXPECT_TRUE(std::regex_search(text, match, std::regex("const " + name + " = ([^;]*);")))
            << name;
        const std::string words = match[1];
        const std::regex number("[-+]?\\d+(\\.\\d+(e[-+]\\d+)?|e[-+]\\d+)");
        std::vector<float> values;
        for (std::sregex_iterator it(words.begin(), words.end(), number), end; it != end; ++it)
            values.push_back(std::stof(it->str()));
        return values;
    }

    static float along(float tile, float place, float size, bool isLinear) {
        const float first = std::ceil(tile * size - 0.01F) + 0.5F;
        const float last = std::floor((tile + 1) * size + 0.01F) - 0.5F;
        const float corner = tile * size;
        const float nearest =
            std::floor(corner) + std::floor(fract(corner) + place * size + 0.0001F) + 0.5F;
        return std::min(std::max(isLinear ? corner + place * size : nearest, first), last);
    }

    LensGeometry geometry_;
    std::vector<std::array<float, 3>> starts_;
    std::vector<float> across_, down_, panel_, grid_;
    float views_ = 0;
};

Calibration cellPanel(int pattern) {
    Calibration c = stripePanel(192, 108);
    c.subpixelCells = deltaCells();
    c.CellPatternMode = pattern;
    return c;
}

// Known displays, and made-up ones with what those do not have.
std::vector<Calibration> displays() {
    std::vector<Calibration> all{stripePanel(kMaxPanelSide, 16), cellPanel(1), cellPanel(3)};
    for (double Calibration::*flag :
         {&Calibration::flipImageX, &Calibration::flipImageY, &Calibration::flipSubp}) {
        all.push_back(stripePanel(192, 256));
        all.back().*flag = 1;
    }
    all.push_back(readCalibration(sourcePath("calibration/portrait-sample.json")));
    for (const auto& file : realCalibrations())
        all.push_back(readCalibration(file));
    return all;
}

// (2.2), (2.3): the px of a side of a view under a px of the panel.
int pxUnder(int index, int panel, int tile, bool isMirrored) {
    return (2 * (isMirrored ? panel - 1 - index : index) + 1) * tile / (2 * panel);
}

TEST(QuiltShader, TakesTheViewsAndPxOfTheTable) {
    for (const Calibration& c : displays()) {
        const QuiltLayout layout = defaultQuilt(c);
        const LensGeometry g = lensGeometry(c);
        const Twin twin(quiltShader(c, layout), g);
        std::size_t all = 0;
        std::size_t otherViews = 0;
        std::size_t otherPx = 0;
        for (int y = 0; y < c.screenH; y += 17) {
            for (int x = 0; x < c.screenW; ++x) {
                for (int k = 0; k < 3; ++k, ++all) {
                    const float view =
                        std::min(std::floor(twin.phase(x, y, k) * twin.views()), twin.views() - 1);
                    const int expected =
                        LensGeometry::viewOfPhase(g.phase(x, y, k), layout.viewCount);
                    otherViews += static_cast<int>(view) == expected ? 0U : 1U;
                }
                const cv::Point2f at = twin.placeOf(0, x, y, layout.size(), false);
                const cv::Size tile = layout.tileSize;
                const int column = pxUnder(x, c.screenW, tile.width, g.mirrorX);
                const int row =
                    (layout.rows - 1) * tile.height + pxUnder(y, c.screenH, tile.height, g.mirrorY);
                const double off =
                    std::max(std::abs(at.x - 0.5 - column), std::abs(at.y - 0.5 - row));
                otherPx += off == 0 ? 0U : 1U;
                ASSERT_LE(off, 1) << c.serial << " at " << x << ", " << y;
            }
        }
        // borders between views and between px, where rounding decides
        EXPECT_LE(otherViews, all / 10000) << c.serial;
        EXPECT_LE(otherPx, all / 1000) << c.serial;
    }
}

// What a card shows of a place between px.
double sampled(const cv::Mat& quilt, cv::Point2f at, int channel) {
    const int x = static_cast<int>(at.x - 0.5F);
    const int y = static_cast<int>(at.y - 0.5F);
    const double wx = at.x - 0.5 - x;
    const double wy = at.y - 0.5 - y;
    const auto value = [&](int column, int row) -> double {
        return quilt.at<cv::Vec3b>(std::min(row, quilt.rows - 1),
                                   std::min(column, quilt.cols - 1))[channel];
    };
    return (1 - wy) * ((1 - wx) * value(x, y) + wx * value(x + 1, y)) +
           wy * ((1 - wx) * value(x, y + 1) + wx * value(x + 1, y + 1));
}

TEST(QuiltShader, LinearSamplingIsThatOfQuilt2Native) {
    const QuiltSampling linear{ViewFilter::Linear, TileSampling::Linear};
    for (const int pattern : {0, 2, 4}) {
        const Calibration c = pattern == 0 ? stripePanel(96, 128) : cellPanel(pattern);
        const QuiltLayout layout{3, 2, {30, 40}, 5};
        const Twin twin(quiltShader(c, layout, linear), lensGeometry(c));
        cv::Mat quilt(layout.size(), CV_8UC3);
        cv::RNG(3).fill(quilt, cv::RNG::UNIFORM, 0, 256);
        cv::Mat native;
        Quilt2Native(c, layout, linear).render(quilt, native);
        double largest = 0;
        forPixels(native.size(), [&](int x, int y) {
            for (int k = 0; k < 3; ++k) {
                const float view = std::min(
                    std::max(twin.phase(x, y, k) * twin.views() - 0.5F, 0.0F), twin.views() - 1);
                const auto of = [&](float one) {
                    return sampled(quilt, twin.placeOf(one, x, y, quilt.size(), true), 2 - k);
                };
                const float first = std::floor(view);
                const double value = (1 - fract(view)) * of(first) +
                                     fract(view) * of(std::min(first + 1, twin.views() - 1));
                largest = std::max(largest, std::abs(value - native.at<cv::Vec3b>(y, x)[2 - k]));
            }
        });
        EXPECT_LT(largest, 0.6) << "pattern " << pattern; // it is rounded
    }
}

TEST(QuiltShader, QuiltsOfFractionalViewsShowNoNeighbours) {
    const Calibration c = stripePanel(96, 128);
    const QuiltLayout layout{5, 9, {819, 455}, 45};
    const cv::Size quilt(4096, 4096);
    const Twin twin(quiltShader(c, layout), lensGeometry(c));
    for (int view = 0; view < 45; ++view) {
        for (const cv::Point pixel : {cv::Point(0, 0), cv::Point(95, 127)}) {
            const cv::Point2f at =
                twin.placeOf(static_cast<float>(view), pixel.x, pixel.y, quilt, false);
            const int up = view / 5;
            const double left = view % 5 * 819.2;
            const double top = (8 - up) * (4096 / 9.0);
            EXPECT_GE(at.x - 0.5, left) << view;
            EXPECT_LE(at.x + 0.5, left + 819.2) << view;
            EXPECT_GE(at.y - 0.5, top) << view;
            EXPECT_LE(at.y + 0.5, top + 4096 / 9.0) << view;
        }
    }
}

TEST(QuiltShader, HoldsNumbersOnlyAndNoLocale) {
    Calibration c = cellPanel(2);
    c.serial = "x\n//!HOOK OUTPUT\n";
    c.configVersion = c.serial;
    const std::string text = quiltShader(c, QuiltLayout());
    EXPECT_FALSE(holds(text, "OUTPUT"));
    for (const char* locale : {"de_DE.UTF-8", "fr_FR.UTF-8", "C.UTF-8"})
        if (std::setlocale(LC_ALL, locale) != nullptr) break;
    EXPECT_EQ(quiltShader(c, QuiltLayout()), text);
    std::setlocale(LC_ALL, "C");
}

TEST(QuiltShader, RefusesWhatIsNoDisplay) {
    Calibration c = stripePanel(96, 128);
    c.slope = NAN;
    EXPECT_EQ(codeOf([&] { (void)quiltShader(c, QuiltLayout()); }), ErrorCode::BadFormat);
    EXPECT_EQ(codeOf([&] {
                  (void)quiltShader(stripePanel(96, 128), {0, 6, {4, 4}, 1});
              }),
              ErrorCode::InvalidArgument);
}

} // namespace
} // namespace altiro3D::test
