#include "altiro3D/quilt.hpp"

#include "support/files.hpp"

#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

constexpr double kPortraitAspect = 0.75;

std::string gridText(const std::string& text) {
    const QuiltGrid grid = parseQuiltGrid(text);
    return std::to_string(grid.columns) + " columns " + std::to_string(grid.rows) + " rows";
}

ResolvedQuilt resolve(const char* q, const char* r, double aspect = kPortraitAspect) {
    QuiltRequest request;
    if (q != nullptr) request.grid = parseQuiltGrid(q);
    if (r != nullptr) request.tileSize = parseTileSize(r);
    return resolveQuilt(request, QuiltLayout(), aspect);
}

TEST(QuiltLayout, ViewZeroIsTheBottomLeftTileThenRightThenUp) {
    const QuiltLayout layout{3, 2, {10, 20}, 6};
    EXPECT_EQ(layout.size(), cv::Size(30, 40));
    EXPECT_EQ(layout.tile(0), cv::Rect(0, 20, 10, 20));
    EXPECT_EQ(layout.tile(2), cv::Rect(20, 20, 10, 20));
    EXPECT_EQ(layout.tile(3), cv::Rect(0, 0, 10, 20));
    EXPECT_EQ(layout.text(), "3 columns x 2 rows, each view 10 x 20 px");
}

TEST(QuiltLayout, PositionsRunFromLeftToRightAndOneViewIsTheCentre) {
    EXPECT_EQ(viewPosition(0, 48), -1);
    EXPECT_EQ(viewPosition(47, 48), 1);
    EXPECT_EQ(viewPosition(1, 3), 0);
    EXPECT_EQ(viewPosition(0, 1), 0);
    EXPECT_EQ(viewPosition(0, 2), -1);
}

TEST(QuiltLayout, LimitsAreNamed) {
    const auto error = [](const QuiltLayout& layout) { return errorOf([&] { validate(layout); }); };
    EXPECT_EQ(error({1, 1, {65535, 65535}, 1}), "(no error)");
    EXPECT_TRUE(holds(error({1, 1, {65536, 10}, 1}), "at most 65535 a side"));
    EXPECT_TRUE(holds(error({1024, 1, {65535, 1}, 1}), "at most 65535"));
    EXPECT_TRUE(holds(error({0, 6, {420, 560}, 1}), "0 columns"));
    EXPECT_TRUE(holds(error({8, 6, {0, 560}, 1}), "views of 0 x 560"));
    EXPECT_TRUE(holds(error({8, 6, {420, 560}, 49}), "49 views, expected 1..48"));
}

TEST(QuiltOption, IsRowsTimesColumnsAndHeightTimesWidth) {
    EXPECT_EQ(gridText("6x8"), "8 columns 6 rows");
    EXPECT_EQ(gridText("9X5"), "5 columns 9 rows");
    EXPECT_EQ(parseTileSize("560x420"), cv::Size(420, 560));
    for (const char* bad : {"", "6", "6x", "x8", "6x8x2", "0x8", "6x-8", "6 x 8", "6x8 ", "sixx8",
                            "999999x1", "2000x2"}) {
        EXPECT_TRUE(holds(errorOf([&] { parseQuiltGrid(bad); }),
                          "quilt grid: \"" + std::string(bad) + "\""))
            << bad;
    }
    EXPECT_TRUE(holds(errorOf([] { parseTileSize("560"); }), "HEIGHTxWIDTH"));
}

TEST(QuiltName, IsTheLastSuffixOfTheName) {
    const auto text = [](const char* file) -> std::string {
        const auto name = parseQuiltName(file);
        if (!name) return "none";
        return std::to_string(name->grid.columns) + "," + std::to_string(name->grid.rows) + "," +
               (name->aspect ? std::to_string(*name->aspect) : "none");
    };
    EXPECT_EQ(text("a_qs8x6a0.75.png"), "8,6,0.750000");
    EXPECT_EQ(text("a_qs11x6a0.5625.mp4"), "11,6,0.562500");
    EXPECT_EQ(text("a_qs8x13.jpg"), "8,13,none");
    EXPECT_EQ(text("a_qs5x9a1.78_qs8x6a0.75.png"), "8,6,0.750000");
    EXPECT_EQ(text("A_QS5X9A1.77778.JPG"), "5,9,1.777780");
    EXPECT_EQ(text("dir_qs2x2/photo.png"), "none");
    EXPECT_EQ(text("qs8x6.png"), "none");
    EXPECT_EQ(text("a_qs8x6b.png"), "none");
    EXPECT_EQ(text("a_qs8x6a0.75b.png"), "none");
    EXPECT_EQ(text("a_qs8x6a.75.png"), "none");
    EXPECT_EQ(text("a_qs8x6ab.png"), "none");
    EXPECT_EQ(text("a_qs8x60000.png"), "none");
    EXPECT_EQ(text("a_QS8X6A0.75-2.png"), "8,6,0.750000");
    EXPECT_EQ(text("a_qs8x6_qs5.png"), "8,6,none");
    EXPECT_EQ(text("a_qs8x6a0.75"), "8,6,0.750000");
    EXPECT_TRUE(holds(errorOf([] { parseQuiltName("_qs0x6a1.png"); }), "1..1024 columns"));
    EXPECT_TRUE(holds(errorOf([] { parseQuiltName("a_qs8x6a99.png"); }), "0.1..10"));
}

TEST(QuiltName, NamesOfAnyLengthAreRead) {
    const std::string digits(100000, '1');
    EXPECT_FALSE(parseQuiltName("a_qs8x6a" + digits + ".png"));
    EXPECT_FALSE(parseQuiltName(digits + ".png"));
    EXPECT_TRUE(parseQuiltName(digits + "_qs8x6a0.75.png"));
}

TEST(QuiltName, WhatIsWrittenIsReadAgain) {
    for (const QuiltLayout& layout :
         {QuiltLayout{1, 1, {9, 9}, 1}, QuiltLayout{40, 40, {9, 9}, 1600},
          QuiltLayout{1024, 1, {9, 9}, 1024}, QuiltLayout{1024, 1024, {1, 1}, 5}}) {
        for (const double aspect : {16 / 16384.0, 0.0999, 0.1, 1.0, 16.0 / 9, 10.0, 10.1, 1024.0}) {
            const std::filesystem::path named = quiltFileName("p.png", layout, aspect);
            const auto name = parseQuiltName(named);
            ASSERT_TRUE(name) << named;
            EXPECT_EQ(name->grid.columns, layout.columns);
            EXPECT_EQ(name->grid.rows, layout.rows);
            EXPECT_EQ(name->aspect.has_value(), aspect >= 0.1 && aspect <= 10) << named;
            EXPECT_NEAR(name->aspect.value_or(aspect), aspect, 1e-5);
            EXPECT_EQ(quiltFileName(named, layout, aspect), named);
        }
    }
    EXPECT_TRUE(holds(errorOf([] { parseQuiltName("a_qs1025x6.png"); }), "1..1024 columns"));
    EXPECT_EQ(errorOf([] {
                  quiltFileName("p.png", QuiltLayout{0, 6, cv::Size(9, 9), 1}, 1);
              }),
              "quilt layout: 0 columns x 6 rows, expected 1..1024 of each");
}

TEST(QuiltName, IsWrittenOnceAndNeverAgainstTheName) {
    const QuiltLayout layout;
    EXPECT_EQ(quiltFileName("out/photo.png", layout, 0.75), "out/photo_qs8x6a0.75.png");
    EXPECT_EQ(quiltFileName("photo_qs8x6a0.75.png", layout, 0.75), "photo_qs8x6a0.75.png");
    EXPECT_EQ(quiltFileName("photo_qs8x6.png", layout, 0.75), "photo_qs8x6.png");
    EXPECT_EQ(quiltFileName("p", layout, 16.0 / 9), "p_qs8x6a1.77778");
    EXPECT_TRUE(holds(errorOf([&] { quiltFileName("p_qs6x8a0.75.png", layout, 0.75); }),
                      "expected a name that ends in _qs8x6a0.75"));
}

TEST(ResolveQuilt, TakesTheDisplaysOwnLayoutWhenNothingIsSaid) {
    EXPECT_EQ(resolve(nullptr, nullptr).layout, QuiltLayout());
    EXPECT_TRUE(resolve(nullptr, nullptr).notes.empty());
}

TEST(ResolveQuilt, PublishedExamplesMeanWhatTheirFigureShows) {
    const ResolvedQuilt portrait = resolve("6x8", "560x420");
    EXPECT_EQ(portrait.layout.text(), "8 columns x 6 rows, each view 420 x 560 px");
    EXPECT_TRUE(portrait.notes.empty());
    const ResolvedQuilt wide = resolve("9x5", "455x819", 16.0 / 9);
    EXPECT_EQ(wide.layout.text(), "5 columns x 9 rows, each view 819 x 455 px");
    EXPECT_TRUE(wide.notes.empty());
}

TEST(ResolveQuilt, WarnsWithBothReadingsWhereTheSwappedOneFitsThePanel) {
    const ResolvedQuilt swapped = resolve("8x6", "420x560");
    EXPECT_TRUE(holds(only(swapped.notes).text, "6 columns x 8 rows, each view 560 x 420 px"));
    EXPECT_TRUE(holds(only(swapped.notes).text, "8 columns x 6 rows, each view 420 x 560 px"));
    EXPECT_EQ(resolve("8x6", nullptr).notes.size(), 1U); // 560 x 420 views on an upright panel
    // neither reading fits: that may be meant so
    EXPECT_TRUE(resolve("9x5", "455x819").notes.empty());
}

TEST(ResolveQuilt, TheLargestViewHasMorePixelsThanAnIntHolds) {
    QuiltRequest request;
    request.grid = QuiltGrid{1, 1};
    request.quiltSize = cv::Size(65535, 65535);
    EXPECT_EQ(resolveQuilt(request, {}, 0.75).layout.tileSize, *request.quiltSize);
}

TEST(ResolveQuilt, ViewSizeComesFromThePictureWithoutItsUnusedPixels) {
    QuiltRequest request;
    request.quiltSize = cv::Size(4096, 4096);
    request.grid = QuiltGrid{5, 9};
    EXPECT_EQ(resolveQuilt(request, QuiltLayout(), 1.6).layout.tileSize, cv::Size(819, 455));
    request.tileSize = cv::Size(819, 455);
    EXPECT_NO_THROW(resolveQuilt(request, QuiltLayout(), 1.6));
    request.tileSize = cv::Size(820, 455);
    EXPECT_TRUE(holds(errorOf([&] { resolveQuilt(request, QuiltLayout(), 1.6); }),
                      "view size: says views of 820 x 455 px"));
    request = {};
    request.quiltSize = cv::Size(3, 3);
    EXPECT_TRUE(holds(errorOf([&] { resolveQuilt(request, QuiltLayout(), 1.6); }), "do not fit"));
}

TEST(ResolveQuilt, WhatIsAssumedOfANamelessPictureIsSaid) {
    const auto warnings = [](cv::Size size, const QuiltRequest& stated = {}) {
        QuiltRequest request = stated;
        request.quiltSize = size;
        return resolveQuilt(request, QuiltLayout(), 0.75).notes;
    };
    EXPECT_TRUE(warnings(QuiltLayout().size()).empty()); // the display's own
    ASSERT_EQ(warnings({4095, 4095}).size(), 1U);        // 5 columns x 9 rows, but who knows
    EXPECT_TRUE(holds(warnings({4095, 4095})[0].text, "it is read as 8 columns x 6 rows"));
    QuiltRequest stated;
    stated.name = parseQuiltName("a_qs8x6a0.75.png");
    EXPECT_TRUE(warnings({4095, 4095}, stated).empty());
    stated = {};
    stated.grid = QuiltGrid{8, 6};
    EXPECT_TRUE(warnings({4096, 4096}, stated).empty());
    stated = {};
    stated.tileSize = cv::Size(512, 682);
    EXPECT_TRUE(warnings({4096, 4096}, stated).empty());
}

TEST(ResolveQuilt, WhatHasNoTilesIsRefusedNotDividedBy) {
    const auto error = [](const QuiltRequest& request, const QuiltLayout& standard) {
        return errorOf([&] { resolveQuilt(request, standard, 0.75); });
    };
    for (const QuiltGrid grid : {QuiltGrid{}, QuiltGrid{8, 0}, QuiltGrid{-1, 6}, QuiltGrid{1025, 1},
                                 QuiltGrid{65536, 65536}}) {
        const std::string expected = "quilt layout: " + std::to_string(grid.columns) +
                                     " columns x " + std::to_string(grid.rows) +
                                     " rows, expected 1..1024 of each";
        QuiltRequest request;
        request.grid = grid;
        EXPECT_EQ(error(request, {}), expected);
        request = {};
        request.name = QuiltName{grid, {}};
        EXPECT_EQ(error(request, {}), expected);
        EXPECT_EQ(error({}, {grid.columns, grid.rows, {9, 9}, 1}), expected);
    }
}

TEST(ResolveQuilt, FileNameWinsAndAConflictIsAnError) {
    QuiltRequest request;
    request.name = parseQuiltName("a_qs4x8a1.6.png");
    request.quiltSize = cv::Size(2048, 2048);
    EXPECT_EQ(resolveQuilt(request, QuiltLayout(), 1.6).layout.text(),
              "4 columns x 8 rows, each view 512 x 256 px");
    request.grid = parseQuiltGrid("8x4"); // rows x columns: the same
    EXPECT_NO_THROW(resolveQuilt(request, QuiltLayout(), 1.6));
    request.grid = parseQuiltGrid("4x8");
    EXPECT_TRUE(
        holds(errorOf([&] { resolveQuilt(request, QuiltLayout(), 1.6); }),
              "quilt grid: says 8 columns x 4 rows, but the file name says 4 columns x 8 rows"));
}

} // namespace
} // namespace altiro3D::test
