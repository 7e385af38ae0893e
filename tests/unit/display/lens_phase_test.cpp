#include "display/lens_phase.hpp"

#include "support/displays.hpp"
#include "support/processors.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

// 8 px per lens, upright to within the double's precision: with 48 views every sub-pixel lies on
// the border between two views, with 1 view some lie on the border between two lenses.
Calibration onTheBorders(double center) {
    Calibration c = stripePanel(64, 48);
    c.pitch = 8;
    c.DPI = 64;
    c.slope = 1e12;
    c.center = center;
    return c;
}

template <class T>
std::size_t wrongViews(const LensPhases& phases, int views, int rowStep = 1) {
    const LensGeometry& g = phases.geometry();
    std::vector<T> row(static_cast<std::size_t>(g.panelWidth) + 1, T{77});
    std::size_t wrong = 0;
    for (int y = 0; y < g.panelHeight; y += rowStep) {
        for (int channel = 0; channel < 3; ++channel) {
            phases.viewsOfRow(y, channel, views, row.data());
            for (int x = 0; x < g.panelWidth; ++x) {
                const int expected = LensGeometry::viewOfPhase(g.phase(x, y, channel), views);
                wrong += row[static_cast<std::size_t>(x)] != static_cast<T>(expected) ? 1U : 0U;
            }
            wrong += row.back() != T{77} ? 1U : 0U; // nothing is written behind the row
        }
    }
    return wrong;
}

// Views and phases of every sub-pixel of every rowStep-th row against LensGeometry.
void expectEqualsGeometry(const Calibration& c, int rowStep = 1) {
    for (InvertViews invert : {InvertViews::Auto, InvertViews::On, InvertViews::Off}) {
        const LensPhases phases(lensGeometry(c, invert));
        for (int views : {1, 2, 45, 48, 256}) {
            EXPECT_EQ(wrongViews<std::uint8_t>(phases, views, rowStep), 0U) << views;
        }
        for (int views : {49, 257, 65536}) {
            EXPECT_EQ(wrongViews<std::uint16_t>(phases, views, rowStep), 0U) << views;
        }
        for (int views : {48, 1 << 20}) {
            EXPECT_EQ(wrongViews<std::uint32_t>(phases, views, rowStep), 0U) << views;
        }
        const LensGeometry& g = phases.geometry();
        double largest = 0;
        for (int y = 0; y < g.panelHeight; y += rowStep) {
            for (int channel = 0; channel < 3; ++channel) {
                for (int x = 0; x < g.panelWidth; ++x) {
                    const std::uint32_t phase =
                        phases.columnPhases(y, channel)[x] + phases.rowPhase(y, channel);
                    const double off = phase * 0x1p-32 - g.phase(x, y, channel);
                    largest = std::max(largest, std::abs(off - std::round(off)));
                }
            }
        }
        EXPECT_LE(largest, phases.phaseError() * 0x1p-32);
    }
}

TEST(LensPhases, EqualTheGeometryOnStripePanels) {
    expectEqualsGeometry(stripePanel());
    expectEqualsGeometry(stripePanel(16, 16));
    Calibration c = stripePanel(17, 131);
    c.slope = 5.2;
    c.center = -0.4;
    expectEqualsGeometry(c);
}

TEST(LensPhases, EqualTheGeometryWithFlipsAndEveryCellPattern) {
    for (int flags = 0; flags < 8; ++flags) {
        for (int mode = -1; mode <= 4; ++mode) {
            for (std::size_t cells : {1U, 2U}) {
                Calibration c = stripePanel(37, 22 + flags);
                c.flipImageX = flags & 1;
                c.flipImageY = (flags >> 1) & 1;
                c.flipSubp = (flags >> 2) & 1;
                if (mode >= 0) {
                    c.CellPatternMode = mode;
                    c.subpixelCells = deltaCells();
                    c.subpixelCells.resize(cells);
                }
                expectEqualsGeometry(c, 3);
            }
        }
    }
}

TEST(LensPhases, SubPixelsOnTheBordersBetweenViewsFallWhereTheDoubleFormulaPutsThem) {
    for (double center : {0.0, 0.0625, 0.125, 0.5, -1.0, 1 / 3.0})
        expectEqualsGeometry(onTheBorders(center));
    Calibration c = onTheBorders(0.0625); // x = 0 lies on the border between two lenses
    const LensGeometry g = lensGeometry(c, InvertViews::On);
    std::uint8_t row[64];
    LensPhases(g).viewsOfRow(0, 0, 48, row);
    EXPECT_EQ(row[0], LensGeometry::viewOfPhase(g.phase(0, 0, 0), 48));
}

TEST(LensPhases, KeepTheirErrorBoundAtTheLimitsOfCalibrations) {
    Calibration c = stripePanel(64, 64);
    c.pitch = 3.0 * c.DPI;
    c.slope = 3.0 * 64 / 1e6;
    c.center = 999999.75;
    expectEqualsGeometry(c);
    EXPECT_LE(LensPhases(lensGeometry(c)).phaseError(), 40U);
    c.slope = -1e-3;
    c.center = -1e6;
    expectEqualsGeometry(c);
    c = stripePanel(64, 64);
    c.pitch = 0.001 * c.DPI / 64;
    expectEqualsGeometry(c);
    EXPECT_EQ(LensPhases(lensGeometry(stripePanel(1536, 2048))).phaseError(), 3U);
}

TEST(LensPhases, AreTheSameOnEveryInstructionSet) {
    Calibration c = stripePanel(203, 19);
    c.subpixelCells = deltaCells();
    c.CellPatternMode = 3;
    const LensPhases phases(lensGeometry(c));
    const LensPhases borders(lensGeometry(onTheBorders(0.0625)));
    forEachInstructionSet([&](const char* name) {
        SCOPED_TRACE(name);
        EXPECT_EQ(wrongViews<std::uint8_t>(phases, 48), 0U);
        EXPECT_EQ(wrongViews<std::uint16_t>(phases, 1000), 0U);
        EXPECT_EQ(wrongViews<std::uint32_t>(phases, 1000000), 0U);
        EXPECT_EQ(wrongViews<std::uint8_t>(borders, 48), 0U);
    });
}

} // namespace
} // namespace altiro3D::test
