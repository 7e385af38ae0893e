#include "altiro3D/depth_source.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

TEST(DepthSource, CuesAreTakenAsTheyAre) {
    const cv::Mat photo = scenery({64, 48}, 3);
    cv::Mat expected;
    estimateDepthFromCues(photo, expected);
    const auto source = depthFromCues();
    altiro3D::Scene scene;
    source->readScene(photo, 0.5, scene);
    EXPECT_TRUE(samePicture(scene.photo, photo));
    EXPECT_TRUE(samePicture(scene.depth, expected));
    EXPECT_EQ(source->description(), "built-in estimator");
}

TEST(DepthSource, AFileIsNormalizedByItsKind) {
    const TemporaryDirectory directory;
    cv::Mat samples(2, 4, CV_16UC1);
    for (int i = 0; i < 8; ++i)
        samples.at<std::uint16_t>(i / 4, i % 4) = static_cast<std::uint16_t>(1000 * i);
    writeImage(directory / "depth.png", samples);
    const cv::Mat photo = randomPhoto({40, 20});
    for (const DepthKind kind : {DepthKind::NearWhite, DepthKind::FarWhite}) {
        const auto source = depthFromFile(directory / "depth.png", kind);
        EXPECT_EQ(source->kind(), kind);
        altiro3D::Scene scene;
        source->readScene(photo, 0.5, scene);
        ASSERT_EQ(scene.depth.size(), samples.size());
        for (int i = 0; i < 8; ++i) {
            const float near = static_cast<float>(i) / 7;
            EXPECT_NEAR(scene.depth.at<float>(i / 4, i % 4),
                        kind == DepthKind::NearWhite ? near : 1 - near, 1e-6);
        }
    }
    EXPECT_THROW(
        {
            altiro3D::Scene scene;
            depthFromFile(directory / "none.png")->readScene(photo, 0.5, scene);
        },
        Error);
}

TEST(DepthSource, FlatDepthLiesWhereItIsWanted) {
    const TemporaryDirectory directory;
    writeImage(directory / "flat.png", cv::Mat(3, 3, CV_8UC1, cv::Scalar(77)));
    altiro3D::Scene scene;
    depthFromFile(directory / "flat.png")->readScene(randomPhoto({9, 9}), 0.25, scene);
    EXPECT_TRUE(samePicture(scene.depth, cv::Mat(3, 3, CV_32FC1, cv::Scalar(0.25))));
}

TEST(DepthSource, AnRgbdImageIsSplit) {
    const cv::Mat photo = randomPhoto({30, 20});
    const cv::Mat depth = randomDepth({30, 20});
    for (const DepthSide side :
         {DepthSide::Left, DepthSide::Right, DepthSide::Top, DepthSide::Bottom}) {
        cv::Mat image;
        joinRgbd(photo, depth, side, image);
        altiro3D::Scene scene;
        depthFromRgbd(side)->readScene(image, 0.5, scene);
        EXPECT_TRUE(samePicture(scene.photo, photo));
        // 8 bits, and the percentiles cut 0.5 % at both ends of the range
        EXPECT_TRUE(samePicture(scene.depth, depth, 0.02));
    }
}

TEST(DepthSource, ReadsFilesAsReadTakesThem) {
    const TemporaryDirectory directory;
    const cv::Mat photo = randomPhoto({30, 20});
    const cv::Mat depth = randomDepth({30, 20});
    writeImage(directory / "photo.png", photo);
    writeImage(directory / "depth.png", depthTo16Bit(depth));
    cv::Mat image;
    joinRgbd(photo, depth, DepthSide::Right, image);
    cv::Mat wide; // 16 bits a channel, which a photo has not
    image.convertTo(wide, CV_16U, 257);
    writeImage(directory / "rgbd.png", wide);

    const auto given = depthFromFile(directory / "depth.png");
    altiro3D::Scene scene;
    scene.photo = given->readImage(directory / "photo.png");
    std::filesystem::remove(directory / "depth.png"); // read already
    given->readScene(scene.photo, 0.5, scene);
    EXPECT_TRUE(samePicture(scene.photo, photo));
    EXPECT_TRUE(samePicture(scene.depth, depth, 0.02));
    EXPECT_THROW(given->readScene(photo, 0.5, scene), Error) << "once";
    EXPECT_THROW(given->readImage(directory / "photo.png"), Error);

    const auto rgbd = depthFromRgbd(DepthSide::Right);
    scene.photo = rgbd->readImage(directory / "rgbd.png");
    EXPECT_EQ(scene.photo.type(), CV_16UC3);
    rgbd->readScene(scene.photo, 0.5, scene);
    EXPECT_TRUE(samePicture(scene.photo, photo));

    EXPECT_TRUE(samePicture(depthFromCues()->readImage(directory / "rgbd.png"), image));
}

TEST(DepthSource, NotesNameTheirFile) {
    const TemporaryDirectory directory;
    writeImage(directory / "photo.png", randomPhoto({30, 20}));
    writeImage(directory / "coloured.png", randomPhoto({30, 20}));
    Notes notes;
    depthFromFile(directory / "coloured.png")->readImage(directory / "photo.png", &notes);
    ASSERT_EQ(notes.size(), 1U);
    EXPECT_EQ(notes[0].text.rfind((directory / "coloured.png").string() + ": ", 0), 0U)
        << notes[0].text;
}

} // namespace
} // namespace altiro3D::test
