#include "altiro3D/products.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"

#include <atomic>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

// A near box before a far wall.
Scene boxAndWall(cv::Size size) {
    Scene scene{randomPhoto(size, 1), cv::Mat(size, CV_32FC1, cv::Scalar(0.2))};
    scene.depth(cv::Rect(size.width / 4, size.height / 4, size.width / 2, size.height / 2)) = 0.9F;
    return scene;
}

TEST(Products, AFrameKeepsTheFlawsOfItsScene) {
    const cv::Size size(60, 40);
    Scene blurred = boxAndWall(size);
    for (int x = 11; x <= 19; ++x) // a soft step in each row
        blurred.depth(cv::Rect(x, 10, 1, 20)) = static_cast<float>(0.2 + 0.7 * (x - 11) / 8);
    std::optional<DepthFlaws> kept;
    const Placement first = placeFrame(blurred, 1.5, size, {}, kept);
    ASSERT_TRUE(kept);
    EXPECT_EQ(DepthFlaws::fields(*kept), DepthFlaws::fields(first.flaws));
    EXPECT_TRUE(samePicture(first.scene.depth, placeScene(blurred, 1.5, size, {}).scene.depth));
    // another frame of the scene has those of the first one, whatever its own are
    kept->softnessPixels = 5;
    PlacementOptions known;
    known.refine.flaws = kept;
    const Scene sharp = boxAndWall(size);
    EXPECT_TRUE(samePicture(placeFrame(sharp, 1.5, size, {}, kept).scene.depth,
                            placeScene(sharp, 1.5, size, known).scene.depth));
    EXPECT_EQ(kept->softnessPixels, 5);
    // flaws that are stated win
    PlacementOptions exact;
    exact.refine.flaws = DepthFlaws();
    EXPECT_TRUE(samePicture(placeFrame(blurred, 1.5, size, exact, kept).scene.depth,
                            placeScene(blurred, 1.5, size, exact).scene.depth));
}

TEST(Products, SavedDepthHasTheShapeOfThePhoto) {
    Scene scene = boxAndWall({60, 40});
    cv::Mat expected = scene.depth;
    EXPECT_TRUE(samePicture(savedDepth(scene), expected)); // of the photo's size: as it is
    EXPECT_EQ(savedDepth(scene, 30).size(), cv::Size(30, 20));
    EXPECT_EQ(savedDepth(scene, 1).size(), cv::Size(1, 1));
    EXPECT_EQ(codeOf([&] { (void)savedDepth(scene, 0); }), ErrorCode::InvalidArgument);
    EXPECT_EQ(codeOf([&] {
                  (void)savedDepth({scene.photo, 9 * scene.depth});
              }),
              ErrorCode::InvalidArgument);
    scene.photo = randomPhoto({120, 80}, 2);
    fitDepth(scene.depth, {0, 0, 60, 40}, scene.photo, expected);
    EXPECT_TRUE(samePicture(savedDepth(scene), expected));
    EXPECT_EQ(scene.photo.size(), cv::Size(120, 80)); // not taken
}

TEST(Products, EyesShowTheWholePhotoWhateverThePanelShows) {
    const Scene scene = boxAndWall({61, 40});
    PlacementOptions options;
    options.framing = {{0.2, 0.8}, 3};
    options.views.strengthPercent = 40;
    const StereoPair eyes = photoEyes(scene, options, 2, EyesFrom::KeepLeft);
    EXPECT_TRUE(samePicture(eyes.left, scene.photo));
    PlacementOptions whole;
    whole.fit = FitMode::Stretch;
    whole.views.strengthPercent = 2;
    const Placement placed = placeScene(scene, 61.0 / 40, {61, 40}, whole);
    EXPECT_TRUE(
        samePicture(eyes.right, renderEyes(placed.scene, whole.views, EyesFrom::KeepLeft).right));
    EXPECT_THROW((void)photoEyes(boxAndWall({404, 4}), options, 2), Error);
}

TEST(Products, ASwayingVideoShowsThePartThatIsAskedFor) {
    const Scene scene = boxAndWall({200, 100});
    PlacementOptions options;
    options.views.strengthPercent = 0; // the views are the photo
    cv::Mat picture;
    const PhotoFit all = swayFitOf({200, 100}, options);
    EXPECT_EQ(all.size, cv::Size(200, 100));
    swayViewsOf(scene, options, all)(1, picture);
    EXPECT_TRUE(samePicture(picture, scene.photo));
    const cv::Rect part(40, 20, 80, 60);
    const PhotoFit some = swayFitOf({200, 100}, options, part);
    swayViewsOf(scene, options, some)(-1, picture);
    EXPECT_TRUE(samePicture(picture, scene.photo(part)));
    EXPECT_EQ(swayFitOf({200, 100}, options, part, {64, 32}).size, cv::Size(64, 32));
}

class WrittenViews : public FileTest {
  protected:
    std::function<fs::path(int)> files() const {
        return [this](int view) { return directory / (std::to_string(view) + ".png"); };
    }
    std::size_t left() const {
        return static_cast<std::size_t>(
            std::distance(fs::directory_iterator(directory.path()), fs::directory_iterator()));
    }
    const QuiltLayout layout_{3, 2, {8, 6}, 6};
    const cv::Mat quilt_ = randomPhoto({24, 12}, 3);
};

TEST_F(WrittenViews, AreTheTilesOfTheQuilt) {
    double last = -1;
    EXPECT_TRUE(writeViews(files(), quilt_, layout_, [&](double done) {
        EXPECT_GE(done, last); // several may be written at the same time
        EXPECT_LT(done, 1);
        last = done;
        return true;
    }));
    for (int view = 0; view < 6; ++view)
        EXPECT_TRUE(samePicture(readPhoto(files()(view)), quilt_(layout_.tile(view)))) << view;
    EXPECT_EQ(left(), 6U);
}

TEST_F(WrittenViews, AreAllThereOrNone) {
    int calls = 0;
    EXPECT_FALSE(writeViews(files(), quilt_, layout_, [&](double) { return ++calls < 4; }));
    EXPECT_EQ(left(), 0U);
    const auto broken = [&](int view) {
        return view < 4 ? files()(view) : directory / "no" / "such.png";
    };
    EXPECT_THROW(writeViews(broken, quilt_, layout_), Error);
    EXPECT_EQ(left(), 0U);
}

TEST_F(WrittenViews, NeedAQuiltOfTheLayout) {
    EXPECT_EQ(codeOf([&] { writeViews(files(), quilt_.rowRange(1, quilt_.rows), layout_); }),
              ErrorCode::Mismatch);
    QuiltLayout tooMany = layout_;
    tooMany.viewCount = tooMany.columns * tooMany.rows + 1;
    EXPECT_EQ(codeOf([&] { writeViews(files(), quilt_, tooMany); }), ErrorCode::InvalidArgument);
    EXPECT_EQ(left(), 0U);
}

} // namespace
} // namespace altiro3D::test
