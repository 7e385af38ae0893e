#include "altiro3D/quilt2native.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/image_io.hpp"
#include "support/files.hpp"
#include "support/picture_files.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

// A scene with large and small things, and its depth.
struct Seen {
    cv::Mat photo;
    cv::Mat depth;
};

Seen seenScene(cv::Size size, int seed) {
    Seen seen;
    cv::addWeighted(scenery(size, seed), 0.6, randomPhoto(size, seed + 1, 4), 0.4, 0, seen.photo);
    cv::resize(randomDepth({5, 4}, seed + 2), seen.depth, size, 0, 0, cv::INTER_LINEAR);
    return seen;
}

cv::Mat quiltOf(const QuiltLayout& layout, int seed, double strengthPercent) {
    const Seen seen = seenScene(layout.tileSize, seed);
    ViewOptions options;
    options.method = ViewMethod::Fast;
    options.strengthPercent = strengthPercent;
    cv::Mat quilt;
    Depth2Quilt(layout, options).render({seen.photo, seen.depth}, quilt);
    return quilt;
}

QuiltLayout layoutOf(int columns, int rows, cv::Size tile) {
    return {columns, rows, tile, columns * rows};
}

cv::Mat scaled(const cv::Mat& picture, cv::Size size) {
    cv::Mat result;
    cv::resize(picture, result, size, 0, 0, cv::INTER_AREA);
    return result;
}

std::string text(const FoundQuilt& found) {
    if (found.verdict == QuiltVerdict::NoQuilt) return "no quilt";
    return std::to_string(found.layout.columns) + " x " + std::to_string(found.layout.rows) +
           (found.verdict == QuiltVerdict::Unsure ? ", unsure" : "");
}

std::string textOf(const cv::Mat& picture) {
    return text(findQuiltLayout(picture));
}

// Lines at every `period` px.
cv::Mat grid(cv::Size size, int period) {
    cv::Mat picture(size, CV_8UC3, cv::Scalar::all(240));
    for (int x = 0; x < size.width; x += period)
        cv::line(picture, {x, 0}, {x, size.height}, cv::Scalar::all(80), 2);
    for (int y = 0; y < size.height; y += period)
        cv::line(picture, {0, y}, {size.width, y}, cv::Scalar::all(80), 2);
    return picture;
}

TEST(FindQuiltLayout, FindsColumnsAndRowsWhateverTheDepth) {
    ALTIRO3D_TAKES(1.1);
    const std::pair<QuiltGrid, cv::Size> layouts[] = {
        {{4, 8}, {160, 90}},  {{5, 9}, {150, 84}},  {{8, 6}, {105, 140}},
        {{7, 5}, {90, 160}},  {{8, 5}, {96, 120}},  {{6, 8}, {128, 96}},
        {{11, 6}, {84, 112}}, {{3, 3}, {200, 150}}, {{2, 2}, {300, 200}}};
    int seed = 1;
    for (const auto& [grid, tile] : layouts) {
        for (const double strength : {0.0, 10.0, 30.0}) {
            seed += 10;
            const QuiltLayout layout = layoutOf(grid.columns, grid.rows, tile);
            const FoundQuilt found = findQuiltLayout(quiltOf(layout, seed, strength));
            EXPECT_EQ(found.layout, layout) << text(found) << " " << strength;
            EXPECT_EQ(found.verdict, QuiltVerdict::Quilt) << found.confidence << " " << strength;
        }
    }
}

TEST(FindQuiltLayout, QuiltsMayBeScaledCompressedAndCropped) {
    const cv::Mat quilt = quiltOf(layoutOf(5, 9, {300, 168}), 3, 10); // 1500 x 1512
    for (const cv::Size size : {cv::Size(1024, 1024), cv::Size(1361, 1193), cv::Size(801, 977)}) {
        const FoundQuilt found = findQuiltLayout(compressed(scaled(quilt, size), 60));
        EXPECT_EQ(text(found), "5 x 9") << size;
        EXPECT_EQ(found.layout.tileSize, cv::Size(size.width / 5, size.height / 9));
    }
    EXPECT_EQ(textOf(quilt(cv::Rect(3, 1, 1492, 1509))), "5 x 9");
    EXPECT_EQ(textOf(quilt(cv::Rect(0, 0, 1497, 1505))), "5 x 9");
}

// The rows in the order from the top.
cv::Mat fromTop(const cv::Mat& quilt, const QuiltLayout& layout) {
    const int height = layout.tileSize.height;
    cv::Mat turned(quilt.size(), quilt.type());
    for (int row = 0; row < layout.rows; ++row)
        quilt.rowRange(height * row, height * (row + 1))
            .copyTo(
                turned.rowRange(height * (layout.rows - 1 - row), height * (layout.rows - row)));
    return turned;
}

std::string remarksOf(const cv::Mat& quilt, const QuiltLayout& layout) {
    return test::textOf(checkQuiltLayout(quilt, layout));
}

TEST(FindQuiltLayout, IsNotSureOfRowsFromTheTop) {
    ALTIRO3D_TAKES(7);
    int seed = 8;
    for (const QuiltLayout& layout : {layoutOf(5, 4, {150, 120}), layoutOf(8, 6, {105, 140}),
                                      layoutOf(4, 8, {160, 90}), layoutOf(7, 2, {90, 120})}) {
        for (const double strength : {5.0, 10.0, 40.0}) {
            const cv::Mat quilt = quiltOf(layout, ++seed, strength);
            const std::string columns = std::to_string(layout.columns);
            const std::string expected = columns + " x " + std::to_string(layout.rows);
            const FoundQuilt right = findQuiltLayout(compressed(scaled(quilt, {901, 887}), 60));
            EXPECT_EQ(text(right), expected) << strength;
            EXPECT_FALSE(right.isFromTop) << strength;
            const cv::Mat turned = fromTop(quilt, layout);
            EXPECT_EQ(remarksOf(quilt, layout), "");
            EXPECT_TRUE(holds(remarksOf(turned, layout), "from the top to the bottom"));
            for (const cv::Mat& wrong : {turned, compressed(scaled(turned, {901, 887}), 60)}) {
                const FoundQuilt found = findQuiltLayout(wrong);
                EXPECT_EQ(text(found), expected + ", unsure") << strength;
                EXPECT_TRUE(strength > 20 || found.isFromTop) << strength;
            }
        }
    }
    // without a movement of the camera all orders give the same
    const QuiltLayout still = layoutOf(6, 4, {150, 120});
    EXPECT_EQ(textOf(fromTop(quiltOf(still, 5, 0), still)), "6 x 4");
}

TEST(FindQuiltLayout, QuiltsMayHaveOneRow) {
    for (const int columns : {5, 8, 12}) {
        const QuiltLayout layout = layoutOf(columns, 1, {150, 200});
        const cv::Mat quilt = quiltOf(layout, 30 + columns, 10);
        const std::string expected = std::to_string(columns) + " x 1";
        EXPECT_EQ(textOf(quilt), expected);
        EXPECT_EQ(textOf(compressed(scaled(quilt, {columns * 131 + 3, 180}), 60)), expected);
    }
    EXPECT_NE(findQuiltLayout(quiltOf(layoutOf(2, 1, {300, 300}), 4, 10)).verdict,
              QuiltVerdict::Quilt); // a stereo pair
}

TEST(FindQuiltLayout, QuiltsMayHaveLinesBetweenTheirViews) {
    for (const int grey : {0, 128, 255}) {
        const QuiltLayout layout = layoutOf(5, 9, {150, 84});
        cv::Mat quilt = quiltOf(layout, 70 + grey, 10);
        for (int view = 0; view < layout.viewCount; ++view)
            cv::rectangle(quilt, layout.tile(view), cv::Scalar::all(grey), 2);
        EXPECT_EQ(textOf(quilt), "5 x 9") << grey;
        EXPECT_EQ(textOf(compressed(scaled(quilt, {701, 743}), 60)), "5 x 9") << grey;
    }
}

TEST(FindQuiltLayout, IsNotSureOfAPhotoWithLines) {
    for (const int period : {60, 100, 150}) {
        cv::Mat photo = seenScene({1200, 900}, 90 + period).photo;
        for (int x = period; x < photo.cols; x += period)
            cv::line(photo, {x, 0}, {x, photo.rows}, cv::Scalar::all(255), 4);
        for (int y = period; y < photo.rows; y += period)
            cv::line(photo, {0, y}, {photo.cols, y}, cv::Scalar::all(255), 4);
        EXPECT_NE(findQuiltLayout(photo).verdict, QuiltVerdict::Quilt) << period;
    }
}

TEST(FindQuiltLayout, PhotosAreNoQuilts) {
    for (int seed = 1; seed < 6; ++seed) {
        EXPECT_EQ(textOf(seenScene({1200, 900}, seed).photo), "no quilt");
        EXPECT_EQ(textOf(seenScene({600, 1000}, seed).photo), "no quilt");
    }
    EXPECT_EQ(textOf(randomPhoto({800, 600}, 1, 0)), "no quilt");
    const cv::Mat flat(700, 900, CV_8UC3, cv::Scalar(90, 120, 200));
    EXPECT_EQ(findQuiltLayout(flat).verdict, QuiltVerdict::Unsure); // it may be one
    EXPECT_EQ(findQuiltLayout(flat).confidence, 0);
}

TEST(FindQuiltLayout, AContactSheetOfDifferentPhotosIsNoQuilt) {
    cv::Mat sheet(4 * 180, 5 * 240, CV_8UC3);
    for (int i = 0; i < 20; ++i)
        seenScene({240, 180}, 50 + 10 * i)
            .photo.copyTo(sheet(cv::Rect(i % 5 * 240, i / 5 * 180, 240, 180)));
    EXPECT_EQ(textOf(sheet), "no quilt");
}

TEST(FindQuiltLayout, IsNeverSureOfARegularPattern) {
    ALTIRO3D_TAKES(3);
    for (const int period : {20, 37, 64, 100, 200}) {
        EXPECT_NE(findQuiltLayout(grid({1000, 1000}, period)).verdict, QuiltVerdict::Quilt)
            << period;
        EXPECT_NE(findQuiltLayout(grid({1600, 1200}, period)).verdict, QuiltVerdict::Quilt)
            << period;
    }
}

TEST(FindQuiltLayout, PicturesOfAnySizeAreSearched) {
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 3), cv::Size(127, 900),
                                cv::Size(5000, 1), cv::Size(128, 128), cv::Size(131, 4999)}) {
        const FoundQuilt found = findQuiltLayout(randomPhoto(size));
        EXPECT_NE(found.verdict, QuiltVerdict::Quilt) << size;
        EXPECT_EQ(found.verdict == QuiltVerdict::Unsure, std::min(size.width, size.height) < 128)
            << size; // too small to tell
    }
    EXPECT_TRUE(holds(errorOf([] { (void)findQuiltLayout(cv::Mat()); }), "picture: is empty"));
}

TEST(FindQuiltLayout, APartOfAMatrixIsSearchedAsItsCopy) {
    const cv::Mat quilt = quiltOf(layoutOf(4, 3, {150, 100}), 4, 10);
    cv::Mat frame(quilt.rows + 20, quilt.cols + 31, CV_8UC3, cv::Scalar::all(0));
    cv::Mat part = frame(cv::Rect(17, 9, quilt.cols, quilt.rows));
    quilt.copyTo(part);
    EXPECT_EQ(findQuiltLayout(part).confidence, findQuiltLayout(quilt).confidence);
}

TEST(FindQuiltLayout, IsTheSameForAnyNumberOfThreads) {
    const cv::Mat quilt = quiltOf(layoutOf(5, 4, {160, 120}), 4, 10);
    const int threads = cv::getNumThreads();
    cv::setNumThreads(1);
    const FoundQuilt serial = findQuiltLayout(quilt);
    cv::setNumThreads(4);
    const FoundQuilt parallel = findQuiltLayout(quilt);
    cv::setNumThreads(threads);
    EXPECT_EQ(serial.layout, parallel.layout);
    EXPECT_EQ(serial.confidence, parallel.confidence);
}

TEST(CheckQuiltLayout, SaysMissingViewsRowsFromTheTopAndAnotherLayout) {
    const QuiltLayout layout = layoutOf(8, 6, {60, 80});
    for (const double strength : {0.0, 10.0}) {
        const cv::Mat quilt = quiltOf(layout, 40, strength);
        EXPECT_EQ(remarksOf(quilt, layout), "");
        EXPECT_EQ(remarksOf(compressed(quilt, 80), layout), "");
        cv::Mat tail = quilt.clone();
        for (const int view : {45, 46, 47})
            tail(layout.tile(view)).setTo(cv::Scalar::all(0));
        EXPECT_TRUE(
            holds(remarksOf(tail, layout), "of its views 0 to 47 there is nothing in 45, 46, 47:"));
    }
    const cv::Mat quilt = quiltOf(layout, 41, 15);
    EXPECT_TRUE(holds(remarksOf(fromTop(quilt, layout), layout), "from the top to the bottom"));
    EXPECT_TRUE(holds(remarksOf(quilt, layoutOf(5, 9, {96, 53})), "in 6 rows of 8 (-q 6x8)"));
    EXPECT_EQ(remarksOf(cv::Mat(quilt.size(), CV_8UC3, cv::Scalar::all(0)), layout), "");
    EXPECT_EQ(remarksOf(quilt, {1, 1, quilt.size(), 1}), "");
}

TEST(CheckQuiltLayout, TellsTheOrderOfRows) {
    int seed = 60;
    for (const QuiltLayout& layout : {layoutOf(5, 9, {120, 68}), layoutOf(11, 6, {90, 120})}) {
        for (const double strength : {10.0, 20.0}) {
            const cv::Mat quilt = quiltOf(layout, ++seed, strength);
            EXPECT_EQ(remarksOf(quilt, layout), "") << layout.columns << ' ' << strength;
            EXPECT_TRUE(
                holds(remarksOf(fromTop(quilt, layout), layout), "from the top to the bottom"))
                << layout.columns << ' ' << strength;
        }
    }
}

TEST(CheckQuiltLayout, RefusesWhatIsNoLayout) {
    const cv::Mat picture(300, 400, CV_8UC3, cv::Scalar::all(9));
    for (const QuiltLayout& layout :
         {QuiltLayout{0, 2, {100, 100}, 2}, QuiltLayout{2, 0, {100, 100}, 2},
          QuiltLayout{-2, -2, {100, 100}, 4}, QuiltLayout{2, 2, {200, 150}, 5}})
        EXPECT_EQ(codeOf([&] { (void)checkQuiltLayout(picture, layout); }),
                  ErrorCode::InvalidArgument);
}

TEST(CheckQuiltLayout, TellsPhotosFromQuilts) {
    for (int seed = 70; seed < 76; ++seed) {
        const cv::Mat photo = seenScene({900, 1200}, seed).photo;
        EXPECT_TRUE(holds(remarksOf(photo, layoutOf(8, 6, {112, 200})), "do not look like views"))
            << seed;
    }
}

TEST(CheckQuiltLayout, TellsRealQuiltsFromThoseWithRowsFromTheTopAndFromPhotos) {
    ALTIRO3D_TAKES(4);
    ALTIRO3D_REQUIRE_DATA("quilts");
    const std::pair<const char*, QuiltLayout> quilts[] = {
        {"kirurobo/example01.png", layoutOf(4, 8, {512, 256})},
        {"kirurobo/example02.png", layoutOf(4, 8, {512, 256})},
        {"lkg_sdk/example-quilt.jpg", layoutOf(5, 9, {819, 455})},
        {"modprods/unity_quilt.png", layoutOf(4, 8, {512, 256})}};
    for (const auto& [file, layout] : quilts) {
        const cv::Mat quilt = readPhoto(dataPath(std::string("quilts/") + file));
        EXPECT_EQ(textOf(quilt),
                  std::to_string(layout.columns) + " x " + std::to_string(layout.rows))
            << file;
        EXPECT_EQ(remarksOf(quilt, layout), "") << file;
        EXPECT_TRUE(holds(remarksOf(fromTop(quilt, layout), layout), "to the bottom")) << file;
        EXPECT_TRUE(holds(remarksOf(quilt, layoutOf(6, 7, {100, 100})), " (-q ")) << file;
    }
    const cv::Mat ofTwoViewsLess =
        readPhoto(dataPath("quilts/greenbuddha/GreenBuddha_qs7x5a0.5625.jpg"));
    EXPECT_EQ(textOf(ofTwoViewsLess), "7 x 5");
    EXPECT_EQ(textOf(readPhoto(dataPath("quilts/kirurobo/startup.png"))), "4 x 8");
    const QuiltLayout seven = layoutOf(7, 5, {372, 662});
    const std::string missing = remarksOf(ofTwoViewsLess, seven);
    EXPECT_EQ(missing.find("of its views 0 to 34 there is nothing in 33, 34: "), 0U) << missing;
    EXPECT_EQ(std::count(missing.begin(), missing.end(), '\n'), 1) << missing;
    EXPECT_TRUE(holds(remarksOf(fromTop(ofTwoViewsLess, seven), seven), "to the bottom"));
    for (const auto& file : listImages(dataPath("photos/kodak")))
        EXPECT_TRUE(holds(remarksOf(readPhoto(file), layoutOf(8, 6, {96, 85})), "may be a photo"))
            << file;
}

TEST(LikenessOfViews, TellsViewsFromUnrelatedPhotos) {
    const QuiltLayout layout = layoutOf(6, 2, {160, 120});
    for (int seed = 1; seed < 6; ++seed) {
        const cv::Mat quilt = quiltOf(layout, 100 * seed, 20);
        std::vector<cv::Mat> views;
        std::vector<cv::Mat> photos;
        for (int i = 0; i < 12; ++i) {
            views.push_back(quilt(layout.tile(i)));
            photos.push_back(seenScene({160, 120}, 100 * seed + 7 * i).photo);
        }
        EXPECT_GT(likenessOfViews(views), 0.8) << seed;
        EXPECT_LT(likenessOfViews(photos), 0.7 * kMinLikenessOfViews) << seed;
    }
    const cv::Mat flat(50, 60, CV_8UC3, cv::Scalar::all(90));
    EXPECT_EQ(likenessOfViews({flat, flat, flat}), 1);
    EXPECT_EQ(likenessOfViews({randomPhoto({50, 60})}), 1);
    EXPECT_EQ(likenessOfViews({}), 1);
    EXPECT_TRUE(holds(errorOf([] { (void)likenessOfViews({cv::Mat()}); }), "picture: is empty"));
}

// Groups of three or of two columns are alike as well.
TEST(FindQuiltLayout, ARowOfTwelveViewsIsNotTakenForFewer) {
    ALTIRO3D_REQUIRE_DATA("photos/kodak");
    for (const char* name : {"kodim04", "kodim15", "kodim22"}) {
        const QuiltLayout layout = layoutOf(12, 1, {420, 560});
        altiro3D::Scene scene;
        altiro3D::Scene fitted;
        const auto source = estimatedDepth();
        source->readScene(readPhoto(dataPath(std::string("photos/kodak/") + name + ".png")), 0.5,
                          scene);
        fitScene(scene, fitPhoto(scene.photo.size(), 0.75, layout.tileSize), 0.5, fitted);
        ViewOptions options;
        options.method = ViewMethod::Fast;
        options.strengthPercent = 5;
        cv::Mat quilt;
        Depth2Quilt(layout, options).render({fitted.photo, fitted.depth}, quilt);
        EXPECT_EQ(textOf(quilt), "12 x 1") << name;
    }
}

TEST(FindQuiltLayout, RealPhotosAreNoQuilts) {
    ALTIRO3D_REQUIRE_DATA("photos/kodak");
    for (const char* folder : {"photos/kodak", "photos/skimage"})
        for (const auto& file : listImages(dataPath(folder)))
            EXPECT_EQ(textOf(readPhoto(file)), "no quilt") << file;
}

} // namespace
} // namespace altiro3D::test
