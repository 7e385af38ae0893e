#include "altiro3D/native_lut.hpp"

#include "altiro3D/display.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/reference.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace altiro3D::test {
namespace {

// View of a sub-pixel read back from the table.
int viewInLut(const NativeLut& lut, int x, int y, int channel) {
    const auto at = lut.channel(channel).at<cv::Vec<std::uint16_t, 2>>(y, x);
    const QuiltLayout& quilt = lut.quilt();
    return (quilt.rows - 1 - at[1] / quilt.tileSize.height) * quilt.columns +
           at[0] / quilt.tileSize.width;
}

// Every sub-pixel against the long-double reference. Where the phase lies within 1e-9 of the border
// between two views, double and long double may fall on different sides.
void expectEqualsReference(const Calibration& c, const QuiltLayout& layout,
                           InvertViews invert = InvertViews::Auto) {
    const NativeLut lut(c, layout, invert);
    const bool inverted = lensGeometry(c, invert).inverted;
    EXPECT_EQ(lut.inverted(), inverted);
    int different = 0;
    for (int channel = 0; channel < 3; ++channel) {
        for (int y = 0; y < c.screenH; ++y) {
            for (int x = 0; x < c.screenW; ++x) {
                const auto at = lut.channel(channel).at<cv::Vec<std::uint16_t, 2>>(y, x);
                const cv::Point expected = referenceQuiltPixel(c, inverted, layout, x, y, channel);
                if (cv::Point(at[0], at[1]) == expected) continue;
                const long double place =
                    referencePhase(c, inverted, x, y, channel) * layout.viewCount;
                if (std::abs(place - std::round(place)) < 1e-9L * layout.viewCount) continue;
                if (++different <= 3) {
                    ADD_FAILURE() << "(x " << x << ", y " << y << ", channel " << channel << ") is "
                                  << at[0] << "," << at[1] << ", expected " << expected;
                }
            }
        }
    }
    EXPECT_EQ(different, 0);
}

TEST(NativeLut, EqualsTheReferenceOnStripePanels) {
    expectEqualsReference(stripePanel(), QuiltLayout());
    Calibration c = stripePanel(16, 16);
    c.slope = 5.2; // early units lean the other way
    expectEqualsReference(c, {5, 9, {819, 455}, 45});
    c = stripePanel(1, 1);
    c.screenW = 17;
    c.screenH = 131;
    c.center = -0.4;
    expectEqualsReference(c, {1, 1, {1, 1}, 1});
}

TEST(NativeLut, EqualsTheReferenceWithEveryCellPattern) {
    for (int mode = 0; mode <= 4; ++mode) {
        for (std::size_t cells : {1U, 2U}) {
            Calibration c = stripePanel(53, 38);
            c.CellPatternMode = mode;
            c.subpixelCells = deltaCells();
            c.subpixelCells.resize(cells);
            expectEqualsReference(c, {7, 7, {857, 857}, 49});
            c.screenH = 39; // row parity is counted from the bottom
            expectEqualsReference(c, {7, 7, {13, 11}, 47});
        }
    }
}

TEST(NativeLut, EqualsTheReferenceWithFlipsAndBgrStripes) {
    for (int flags = 1; flags < 8; ++flags) {
        for (bool cells : {false, true}) {
            Calibration c = stripePanel(64, 48);
            c.flipImageX = flags & 1;
            c.flipImageY = (flags >> 1) & 1;
            c.flipSubp = (flags >> 2) & 1;
            c.CellPatternMode = 2;
            if (cells) c.subpixelCells = deltaCells();
            expectEqualsReference(c, {8, 6, {42, 56}, 48});
        }
    }
}

TEST(NativeLut, InversionCanBeOverridden) {
    expectEqualsReference(stripePanel(), QuiltLayout(), InvertViews::Off);
    expectEqualsReference(stripePanel(), QuiltLayout(), InvertViews::On);
    Calibration c = stripePanel();
    const NativeLut on(c, QuiltLayout(), InvertViews::On);
    const NativeLut off(c, QuiltLayout(), InvertViews::Off);
    EXPECT_EQ(viewInLut(on, 5, 5, 1), 47 - viewInLut(off, 5, 5, 1));
}

TEST(NativeLut, SizesBeyondTheLimitsAreRefusedBeforeMemoryIsTaken) {
    Calibration c = stripePanel();
    EXPECT_TRUE(holds(errorOf([&] {
                          NativeLut(c, QuiltLayout{100, 100, cv::Size(700, 10), 48});
                      }),
                      "at most 65535"));
    c.screenW = 16385;
    EXPECT_TRUE(holds(errorOf([&] { NativeLut(c, QuiltLayout()); }), "screenW is 16385"));
    EXPECT_TRUE(
        holds(errorOf([&] { NativeLut(stripePanel(), QuiltLayout()).channel(3); }), "channel"));
}

// 100 sub-pixels of a real Portrait whose views were checked through its lens.
TEST(NativeLut, AllGoldenSamplesOfARealPortraitAreExact) {
    ALTIRO3D_REQUIRE_DATA("calibrations/portrait_stepit-holo_reference_samples.json");
    const auto golden = nlohmann::json::parse(
        slurp(dataPath("calibrations/portrait_stepit-holo_reference_samples.json")));
    const NativeLut lut(
        readCalibration(dataPath("calibrations") / golden.at("calibration").get<std::string>()),
        QuiltLayout());
    int exact = 0;
    for (const auto& sample : golden.at("samples"))
        exact += viewInLut(lut, sample[1], sample[0], sample[2]) == sample[3].get<int>() ? 1 : 0;
    EXPECT_EQ(golden.at("samples").size(), 100U);
    EXPECT_EQ(exact, 100);
}

// Published test vectors: pixel and the views of its red, green and blue.
TEST(NativeLut, TestVectorsOfOtherUnitsAreExact) {
    ALTIRO3D_REQUIRE_DATA("calibrations");
    const struct {
        const char* file;
        int x, y, red, green, blue;
    } kVectors[] = {{"portrait_altiro3D-manual_LKG-PORT-19930", 0, 0, 10, 8, 5},
                    {"portrait_altiro3D-manual_LKG-PORT-19930", 1535, 0, 23, 20, 18},
                    {"portrait_altiro3D-manual_LKG-PORT-19930", 0, 2047, 18, 16, 13},
                    {"portrait_altiro3D-manual_LKG-PORT-19930", 1535, 2047, 31, 28, 26},
                    {"portrait_altiro3D-manual_LKG-PORT-19930", 1000, 1203, 26, 23, 21},
                    {"gen1-8.9in_LKG-2K-04409", 0, 0, 32, 29, 27},
                    {"gen1-8.9in_LKG-2K-04409", 2559, 1599, 2, 0, 43},
                    {"gen1-8.9in_LKG-2K-04409", 1000, 1203, 39, 37, 35},
                    {"gen1-8.9in_serial-00112_positive-slope", 0, 0, 13, 11, 9},
                    {"gen1-8.9in_serial-00112_positive-slope", 1280, 800, 8, 6, 4},
                    {"gen2-16in_LKG-APW92011", 3839, 0, 2, 44, 42},
                    {"gen2-16in_LKG-APW92011", 1920, 1080, 19, 16, 13},
                    {"gen3-16in-landscape_LKG-J00133", 0, 0, 48, 44, 46},
                    {"gen3-16in-landscape_LKG-J00133", 1, 0, 40, 36, 38},
                    {"gen3-16in-landscape_LKG-J00133", 0, 1, 47, 43, 44},
                    {"gen3-16in-landscape_LKG-J00133", 3839, 2159, 2, 46, 0},
                    {"gen3-16in-landscape_LKG-J00332_trimmed", 0, 1, 13, 9, 10},
                    {"gen3-16in-landscape_LKG-J00332_trimmed", 123, 457, 31, 26, 29},
                    {"gen3-16in-landscape_LKG-J00332_trimmed", 1000, 1203, 21, 16, 18},
                    {"gen3-go_bare-numbers_owner", 0, 0, 59, 56, 52},
                    {"gen3-go_bare-numbers_owner", 1439, 2559, 25, 22, 18},
                    {"gen3-go_bare-numbers_owner", 720, 1280, 36, 32, 29}};
    std::string loaded;
    std::optional<NativeLut> lut;
    for (const auto& v : kVectors) {
        if (loaded != v.file) {
            const Calibration c =
                readCalibration(dataPath("calibrations/" + std::string(v.file) + ".json"));
            const DisplayModel* model = findDisplayModel(c); // 49 views on a 16"
            lut = NativeLut(c, model->earlierQuilt.value_or(model->quilt));
            loaded = v.file;
        }
        EXPECT_EQ(viewInLut(*lut, v.x, v.y, 0), v.red) << v.file << " " << v.x << "," << v.y;
        EXPECT_EQ(viewInLut(*lut, v.x, v.y, 1), v.green) << v.file << " " << v.x << "," << v.y;
        EXPECT_EQ(viewInLut(*lut, v.x, v.y, 2), v.blue) << v.file << " " << v.x << "," << v.y;
    }
}

// Treating a cell panel as stripes gives an error of up to 6 views. The published frequencies of
// the errors 0..6 are from a sample of the panel.
TEST(NativeLut, CellsDifferFromStripesAsPublished) {
    ALTIRO3D_REQUIRE_DATA("calibrations/gen3-16in-landscape_LKG-J00332_trimmed.json");
    Calibration c =
        readCalibration(dataPath("calibrations/gen3-16in-landscape_LKG-J00332_trimmed.json"));
    const QuiltLayout layout{8, 6, {10, 10}, 48};
    const NativeLut cells(c, layout, InvertViews::On);
    c.subpixelCells.clear();
    const NativeLut stripes(c, layout, InvertViews::On);
    std::vector<double> counts(25);
    for (int channel = 0; channel < 3; ++channel) {
        for (int y = 0; y < c.screenH; ++y) {
            for (int x = 0; x < c.screenW; ++x) {
                const int d =
                    std::abs(viewInLut(cells, x, y, channel) - viewInLut(stripes, x, y, channel));
                counts[static_cast<std::size_t>(std::min(d, 48 - d))] += 1;
            }
        }
    }
    const double all = 3.0 * c.screenH * c.screenW;
    const double kPublished[] = {0.200, 0.135, 0.227, 0.109, 0.042, 0.240, 0.048};
    for (std::size_t i = 0; i < 7; ++i)
        EXPECT_NEAR(counts[i] / all, kPublished[i], 0.005) << i;
}

} // namespace
} // namespace altiro3D::test
