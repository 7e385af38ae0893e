#include "altiro3D/image_io.hpp"

#include "image/heif_boxes.hpp"
#include "image/heif_file.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/photo_files.hpp"
#include "support/random_pictures.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

namespace altiro3D::test {
namespace {

std::string jpegOf(const cv::Mat& picture) {
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, 95});
    return {bytes.begin(), bytes.end()};
}

cv::Mat decodedJpeg(const std::string& bytes) {
    return cv::imdecode(std::vector<unsigned char>(bytes.begin(), bytes.end()),
                        cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
}

TEST(ReadStereoPair, AnMpoHoldsTheLeftPictureFirst) {
    const TemporaryDirectory directory;
    const std::string left = jpegOf(randomPhoto({64, 48}, 1));
    const std::string right = jpegOf(randomPhoto({64, 48}, 2));
    for (const char* name : {"a.mpo", "a.jpg"}) { // the name does not matter
        spill(directory / name, mpoFile(left, right));
        Notes notes;
        const auto pair = readStereoPair(directory / name, &notes);
        ASSERT_TRUE(pair);
        EXPECT_TRUE(samePicture(pair->left, decodedJpeg(left)));
        EXPECT_TRUE(samePicture(pair->right, decodedJpeg(right)));
        EXPECT_EQ(pair->origin, "MPO");
        EXPECT_TRUE(notes.empty()) << notes.front().text;
    }
}

TEST(ReadStereoPair, BothPicturesAreTurnedUpright) {
    const TemporaryDirectory directory;
    const std::string left = jpegOf(randomPhoto({64, 48}, 1));
    const std::string right = jpegOf(randomPhoto({64, 48}, 2));
    cv::Mat turned;
    cv::rotate(decodedJpeg(right), turned, cv::ROTATE_180);
    // the right picture may repeat the orientation or leave it out
    for (const std::string& second : {right, withSegments(right, exifSegment(3))}) {
        spill(directory / "a.mpo", mpoFile(withSegments(left, exifSegment(3)), second));
        const auto pair = readStereoPair(directory / "a.mpo");
        ASSERT_TRUE(pair);
        EXPECT_TRUE(samePicture(pair->left, readPhoto(directory / "a.mpo")));
        EXPECT_TRUE(samePicture(pair->right, turned));
    }
}

TEST(ReadStereoPair, OtherFilesAreNoPairs) {
    const TemporaryDirectory directory;
    const std::string jpeg = jpegOf(randomPhoto({64, 48}, 1));
    const std::string other = jpegOf(randomPhoto({64, 48}, 2));
    const std::vector<std::string> files = {jpeg,
                                            appleJpeg(jpeg, {other}),           // a portrait
                                            appleJpeg(jpeg, {other}, 0x020001), // a panorama
                                            appleJpeg(jpeg, {other}, 0x020003), // several angles
                                            jpeg.substr(0, 20),
                                            "",
                                            std::string("\xff\xd8\xff\xe2\xff\xffMPF\0", 10),
                                            heifFile("heic", {hevcColours(1), hevcRamp(2)}),
                                            slurp(sourcePath("calibration/portrait-sample.json"))};
    for (const std::string& file : files) {
        spill(directory / "a.mpo", file);
        Notes notes;
        EXPECT_FALSE(readStereoPair(directory / "a.mpo", &notes));
        EXPECT_TRUE(notes.empty());
    }
    EXPECT_FALSE(readStereoPair(directory / "none.mpo"));
}

TEST(ReadStereoPair, ADamagedSecondPictureIsARemark) {
    const TemporaryDirectory directory;
    const std::string jpeg = jpegOf(randomPhoto({64, 48}, 1));
    spill(directory / "a.mpo", mpoFile(jpeg, jpeg.substr(0, jpeg.size() / 2)));
    Notes notes;
    EXPECT_FALSE(readStereoPair(directory / "a.mpo", &notes));
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_EQ(notes[0].text, "the right eye's picture is not used: it is damaged or too large");
}

TEST(ReadStereoPair, ASpatialHeicNamesItsEyes) {
    if (!hasHeif()) GTEST_SKIP() << "needs libheif";
    const TemporaryDirectory directory;
    spill(directory / "plain.heic", heifFile("heic", {hevcColours(1)}));
    spill(directory / "ramp.heic", heifFile("heic", {hevcRamp(1)}));
    const cv::Mat colours = readPhoto(directory / "plain.heic");
    const cv::Mat ramp = readPhoto(directory / "ramp.heic");
    for (const bool isSwapped : {false, true}) {
        spill(directory / "a.heic", isSwapped ? spatialHeic(2, 1) : spatialHeic(1, 2));
        Notes notes;
        const auto pair = readStereoPair(directory / "a.heic", &notes);
        ASSERT_TRUE(pair);
        EXPECT_TRUE(samePicture(pair->left, isSwapped ? ramp : colours));
        EXPECT_TRUE(samePicture(pair->right, isSwapped ? colours : ramp));
        EXPECT_EQ(pair->origin, "spatial HEIC");
        EXPECT_TRUE(notes.empty());
    }
    spill(directory / "a.heic", spatialHeic(1, 9)); // there is no such item
    Notes notes;
    EXPECT_FALSE(readStereoPair(directory / "a.heic", &notes));
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_EQ(notes[0].code, NoteCode::LeftOut);
}

TEST(FindHeifEyes, ReadsTheGroupAndNothingElse) {
    const std::string file = spatialHeic(1, 2);
    const auto eyes = findHeifEyes(file);
    ASSERT_TRUE(eyes);
    EXPECT_EQ(eyes->left, 1u);
    EXPECT_EQ(eyes->right, 2u);
    EXPECT_FALSE(findHeifEyes(spatialHeic(1, 1)));
    EXPECT_FALSE(findHeifEyes(heifFile("heic", {hevcColours(1), hevcRamp(2)})));
    for (std::size_t size = 0; size < file.find("mdat") - 4; ++size) // a cut-off box has no group
        EXPECT_FALSE(findHeifEyes(std::string_view(file).substr(0, size)));
}

TEST(SplitStereoPair, TakesTheHalvesInOrder) {
    const cv::Mat picture = randomPhoto({101, 40}, 3);
    const cv::Rect first(0, 0, 50, 40);
    const cv::Rect second(51, 0, 50, 40);
    const StereoPair pair = splitStereoPair(picture, StereoLayout::LeftRight);
    EXPECT_TRUE(samePicture(pair.left, picture(first)));
    EXPECT_TRUE(samePicture(pair.right, picture(second)));
    EXPECT_EQ(pair.origin, "left and right half");
    const StereoPair crossed = splitStereoPair(picture, StereoLayout::RightLeft);
    EXPECT_TRUE(samePicture(crossed.left, picture(second)));
    EXPECT_TRUE(samePicture(crossed.right, picture(first)));
    const StereoPair stacked = splitStereoPair(picture, StereoLayout::TopBottom);
    EXPECT_TRUE(samePicture(stacked.left, picture(cv::Rect(0, 0, 101, 20))));
    EXPECT_TRUE(samePicture(stacked.right, picture(cv::Rect(0, 20, 101, 20))));
}

TEST(SplitStereoPair, HalvesOf3dTvAreSqueezed) {
    const cv::Mat tv = randomPhoto({192, 108}, 3);
    EXPECT_EQ(splitStereoPair(tv, StereoLayout::LeftRight).left.size(), cv::Size(192, 108));
    EXPECT_EQ(splitStereoPair(tv, StereoLayout::TopBottom).right.size(), cv::Size(192, 108));
    EXPECT_EQ(splitStereoPair(tv, StereoLayout::LeftRight).origin, "left and right half, squeezed");
    EXPECT_EQ(splitStereoPair(tv, StereoLayout::LeftRight, StereoHalves::Full).left.size(),
              cv::Size(96, 108));
    const cv::Mat wide = randomPhoto({400, 150}, 3);
    EXPECT_EQ(splitStereoPair(wide, StereoLayout::LeftRight).left.size(), cv::Size(200, 150));
    EXPECT_EQ(splitStereoPair(wide, StereoLayout::LeftRight, StereoHalves::Squeezed).left.size(),
              cv::Size(400, 150));
}

TEST(SplitStereoPair, TooSmallPicturesAreRefused) {
    const cv::Mat one(1, 1, CV_8UC3, cv::Scalar::all(0));
    EXPECT_EQ(errorOf([&] { static_cast<void>(splitStereoPair(one, StereoLayout::LeftRight)); }),
              "picture: is 1 x 1 px of CV_8UC3, expected two halves");
    EXPECT_EQ(errorOf([&] { static_cast<void>(splitStereoPair(one, StereoLayout::TopBottom)); }),
              "picture: is 1 x 1 px of CV_8UC3, expected two halves");
    const cv::Mat two(1, 2, CV_8UC3, cv::Scalar::all(0));
    EXPECT_EQ(splitStereoPair(two, StereoLayout::LeftRight, StereoHalves::Full).left.size(),
              cv::Size(1, 1));
}

} // namespace
} // namespace altiro3D::test
