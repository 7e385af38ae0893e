#include "native/view_table.hpp"

#include "altiro3D/quilt2native.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/memory_limit.hpp"
#include "support/pixels.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"

#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>
#include <zlib.h>

namespace altiro3D::test {
namespace {

using Pair = cv::Vec<std::uint16_t, 2>;

// Applies the full table, one sub-pixel after the other.
cv::Mat slowNative(const NativeLut& lut, const cv::Mat& quilt) {
    cv::Mat native(lut.panelSize(), CV_8UC3);
    forPixels(native.size(), [&](int x, int y) {
        for (int k = 0; k < 3; ++k) {
            const Pair at = lut.channel(k).at<Pair>(y, x);
            native.at<cv::Vec3b>(y, x)[2 - k] = quilt.at<cv::Vec3b>(at[1], at[0])[2 - k];
        }
    });
    return native;
}

// All paths to a Native give the result of the full table.
void expectEqualsLut(const Calibration& c, const QuiltLayout& layout) {
    const NativeLut lut(c, layout);
    const cv::Mat quilt = randomPicture(layout.size(), CV_8UC3);
    const cv::Mat expected = slowNative(lut, quilt);
    cv::Mat native;
    Quilt2Native(lut).render(quilt, native);
    EXPECT_TRUE(samePicture(native, expected));
    Quilt2Native(c, layout, {}).render(quilt, native);
    EXPECT_TRUE(samePicture(native, expected));
    const auto built = viewTable(lensGeometry(c), layout);
    ASSERT_EQ(built.has_value(), layout.columns * layout.rows <= 65536);
    if (built) {
        native.setTo(7);
        built->render(quilt, native, ChannelOrder::Bgr);
        EXPECT_TRUE(samePicture(native, expected));
    }
    const auto derived = viewTable(lut);
    const bool possible = built && layout.tileSize.width > 1 && layout.tileSize.height > 1;
    ASSERT_EQ(derived.has_value(), possible);
    if (derived) {
        EXPECT_TRUE(samePicture(derived->views, built->views));
        EXPECT_EQ(derived->columns, built->columns);
        EXPECT_EQ(derived->rows, built->rows);
    }
}

const QuiltLayout kLayouts[] = {
    {8, 6, {42, 56}, 48},     {5, 9, {37, 23}, 45},  {1, 1, {1, 1}, 1},
    {1, 7, {2, 3}, 7},        {7, 1, {3, 2}, 5},     {16, 16, {2, 2}, 256},
    {17, 16, {3, 2}, 3},      {30, 31, {2, 5}, 900}, {3, 2, {301, 203}, 6},
    {4, 4, {1, 9}, 16},       {4, 4, {9, 1}, 16},    {1, 300, {2, 2}, 300},
    {1, 1, {65535, 3}, 1},    {1, 1, {2, 65535}, 1}, {1024, 1, {63, 2}, 1024},
    {300, 300, {2, 2}, 90000}};

TEST(ViewTable, SaysWhatTheFullTableSays) {
    for (const QuiltLayout& layout : kLayouts) {
        SCOPED_TRACE(layout.text());
        expectEqualsLut(stripePanel(16, 17), layout);
    }
    expectEqualsLut(stripePanel(), kLayouts[0]);
    expectEqualsLut(stripePanel(), kLayouts[8]);
}

TEST(ViewTable, SaysWhatTheFullTableSaysOfMirroredPanelsAndCells) {
    for (int flags = 0; flags < 8; ++flags) {
        for (int mode = -1; mode <= 4; ++mode) {
            Calibration c = stripePanel(53, 37 + flags);
            c.flipImageX = flags & 1;
            c.flipImageY = (flags >> 1) & 1;
            c.flipSubp = (flags >> 2) & 1;
            if (mode >= 0) {
                c.CellPatternMode = mode;
                c.subpixelCells.resize(2);
                c.subpixelCells[0].x = {-0.31, 0.28, 0};
                c.subpixelCells[1].y = {0.25, 0.25, -0.25};
            }
            expectEqualsLut(c, {7, 7, {11, 13}, 49});
        }
    }
}

TEST(ViewTable, IsTheSameOnEveryInstructionSetAndForAnyNumberOfThreads) {
    const RestoredThreads restored;
    const NativeLut lut(stripePanel(), kLayouts[0]);
    const cv::Mat expected = viewTable(lut)->views;
    forEachInstructionSet([&](const char* name) {
        SCOPED_TRACE(name);
        for (int threads : {1, 3}) {
            cv::setNumThreads(threads);
            const NativeLut built(stripePanel(), kLayouts[0]);
            for (int k = 0; k < 3; ++k)
                EXPECT_TRUE(samePicture(built.channel(k), lut.channel(k)));
            EXPECT_TRUE(samePicture(viewTable(lut)->views, expected));
            expectEqualsLut(stripePanel(19, 16), kLayouts[7]);
        }
    });
}

// A table whose contents have been replaced, as another program may have written it.
NativeLut foreignLut(const QuiltLayout& layout,
                     const std::function<Pair(int y, int x, const Pair&)>& changed) {
    const TemporaryDirectory directory;
    const NativeLut lut(stripePanel(), layout);
    lut.save(directory / "a.map");
    std::string bytes = slurp(directory / "a.map");
    std::size_t at = 128;
    for (int k = 0; k < 3; ++k) {
        for (int y = 0; y < lut.panelSize().height; ++y) {
            for (int x = 0; x < lut.panelSize().width; ++x, at += 4) {
                const Pair pair = changed(y, x, lut.channel(k).at<Pair>(y, x));
                std::memcpy(&bytes[at], pair.val, 4);
            }
        }
    }
    const auto crc = [&](std::size_t begin, std::size_t end) {
        return static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(&bytes[begin]),
                                                static_cast<uInt>(end - begin)));
    };
    const std::uint32_t data = crc(128, bytes.size());
    std::memcpy(&bytes[120], &data, 4);
    const std::uint32_t header = crc(0, 124);
    std::memcpy(&bytes[124], &header, 4);
    spill(directory / "b.map", bytes);
    return NativeLut::load(directory / "b.map");
}

void expectRendersAsItSays(const NativeLut& lut) {
    const cv::Mat quilt = randomPicture(lut.quilt().size(), CV_8UC3);
    cv::Mat native;
    Quilt2Native(lut).render(quilt, native);
    EXPECT_TRUE(samePicture(native, slowNative(lut, quilt)));
    cv::Mat redFirst;
    cv::cvtColor(quilt, redFirst, cv::COLOR_BGR2RGB);
    Quilt2Native(lut).render(redFirst, native, ChannelOrder::Rgb);
    cv::cvtColor(native, native, cv::COLOR_RGB2BGR);
    EXPECT_TRUE(samePicture(native, slowNative(lut, quilt)));
}

TEST(ViewTable, SaysHowMuchMemoryItNeeds) {
    ALTIRO3D_REQUIRE_MEMORY_LIMITS();
    LensGeometry g = lensGeometry(stripePanel());
    g.panelWidth = 20000;
    g.panelHeight = 30000;
    const auto problem = [&](const QuiltLayout& layout) {
        const MemoryLimit limit(300);
        return errorOf([&] { viewTable(g, layout); });
    };
    // three views for each of 600 million px, of a byte each, or two where there are more than 256
    QuiltLayout layout;
    EXPECT_EQ(problem(layout), "look-up table: no memory for a panel of 20000 x 30000 px, expected "
                               "1800 MB to be free");
    layout.columns = 20;
    layout.rows = 20;
    layout.viewCount = 400;
    EXPECT_EQ(problem(layout), "look-up table: no memory for a panel of 20000 x 30000 px, expected "
                               "3600 MB to be free");
}

TEST(ViewTable, TablesOfOtherProgramsAreRenderedAsTheySay) {
    const QuiltLayout layout{8, 6, {42, 56}, 47};
    cv::RNG rng(3);
    const NativeLut anywhere = foreignLut(layout, [&](int, int, const Pair&) {
        return Pair(static_cast<std::uint16_t>(rng.uniform(0, 8 * 42)),
                    static_cast<std::uint16_t>(rng.uniform(0, 6 * 56)));
    });
    EXPECT_FALSE(viewTable(anywhere));
    expectRendersAsItSays(anywhere);

    // one sub-pixel beside its place, near every end of the vectors
    for (int x : {0, 1, 15, 16, 63, 95, 96, 99, 100}) {
        const NativeLut one = foreignLut(layout, [&](int y, int atX, const Pair& p) {
            const int beside = p[0] == 0 ? 1 : p[0] - 1;
            return y == 66 && atX == x ? Pair(static_cast<std::uint16_t>(beside), p[1]) : p;
        });
        EXPECT_FALSE(viewTable(one)) << x;
        expectRendersAsItSays(one);
    }

    // other places inside the tiles, the same for all sub-pixels of a column and a row
    const NativeLut shifted = foreignLut(layout, [&](int y, int x, const Pair& p) {
        return Pair(static_cast<std::uint16_t>(p[0] / 42 * 42 + (x * 31 + 5) % 42),
                    static_cast<std::uint16_t>(p[1] / 56 * 56 + (y * 17 + 3) % 56));
    });
    EXPECT_TRUE(viewTable(shifted));
    expectRendersAsItSays(shifted);

    // the tile that no view uses
    const NativeLut unused = foreignLut(layout, [&](int y, int x, const Pair&) {
        return Pair(static_cast<std::uint16_t>(7 * 42 + x % 42),
                    static_cast<std::uint16_t>(y % 56));
    });
    EXPECT_TRUE(viewTable(unused));
    expectRendersAsItSays(unused);
}

} // namespace
} // namespace altiro3D::test
