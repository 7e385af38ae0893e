#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/stereo_views.hpp"

#include "image/heif_file.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/photo_files.hpp"
#include "support/picture_files.hpp"
#include "support/random_pictures.hpp"
#include "support/stereo_scene.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <tuple>
#include <utility>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

std::string jpegOf(const cv::Mat& picture) {
    return encoded(".jpg", picture, {cv::IMWRITE_JPEG_QUALITY, 95});
}

class ReadStereoPair : public FileTest {
  protected:
    const std::string jpeg = jpegOf(randomPhoto({64, 48}, 1));
    const std::string other = jpegOf(randomPhoto({64, 48}, 2));
};

TEST_F(ReadStereoPair, AnMpoHoldsTheLeftPictureFirst) {
    for (const char* name : {"a.mpo", "a.jpg"}) { // the name does not matter
        spill(directory / name, mpoFile(jpeg, other));
        Notes notes;
        const auto pair = readStereoPair(directory / name, &notes);
        ASSERT_TRUE(pair);
        EXPECT_TRUE(samePicture(pair->left, decoded(jpeg)));
        EXPECT_TRUE(samePicture(pair->right, decoded(other)));
        EXPECT_EQ(pair->origin, "MPO");
        EXPECT_TRUE(notes.empty()) << notes.front().text;
    }
}

TEST_F(ReadStereoPair, BothPicturesAreTurnedUpright) {
    cv::Mat turned;
    cv::rotate(decoded(other), turned, cv::ROTATE_180);
    // the right picture may repeat the orientation or leave it out
    for (const std::string& second : {other, withSegments(other, exifSegment(3))}) {
        spill(directory / "a.mpo", mpoFile(withSegments(jpeg, exifSegment(3)), second));
        const auto pair = readStereoPair(directory / "a.mpo");
        ASSERT_TRUE(pair);
        EXPECT_TRUE(samePicture(pair->left, readPhoto(directory / "a.mpo")));
        EXPECT_TRUE(samePicture(pair->right, turned));
    }
}

TEST_F(ReadStereoPair, OtherFilesAreNoPairs) {
    const std::string files[] = {jpeg,
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
    EXPECT_TRUE(
        holds(errorOf([&] { return readStereoPair(directory / "none.mpo"); }), "does not exist"));
    Notes notes;
    spill(directory / "a.mpo", mpoFile(jpeg, jpeg.substr(0, jpeg.size() / 2)));
    EXPECT_FALSE(readStereoPair(directory / "a.mpo", &notes));
    EXPECT_EQ(only(notes).text, "the right eye's picture is not used: it is damaged or too large");
}

TEST_F(ReadStereoPair, ASpatialHeicNamesItsEyes) {
    if (!hasHeif()) GTEST_SKIP() << "needs libheif";
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
    EXPECT_EQ(only(notes).code, NoteCode::LeftOut);
}

// Of a picture: where the left and the right eye's picture are, and their shape.
struct JpsCase {
    std::string header;
    cv::Rect left;
    cv::Rect right;
    cv::Size shape;
};

TEST_F(ReadStereoPair, TheHeaderOfJpsSaysLayoutOrderAndShape) {
    const cv::Mat picture = decoded(jpeg);
    const cv::Rect left(0, 0, 32, 48);
    const cv::Rect right(32, 0, 32, 48);
    const cv::Rect upper(0, 0, 64, 24);
    const cv::Rect lower(0, 24, 64, 24);
    const std::string foreign = jpegSegment(0xe3, "Meta") + jpegSegment(0xe3, "_JPS");
    const JpsCase cases[] = {
        {jpsSegment(2, 4), left, right, {32, 48}},
        {jpsSegment(2, 0), right, left, {32, 48}},
        {jpsSegment(3, 4), upper, lower, {64, 24}},
        {jpsSegment(3, 0), lower, upper, {64, 24}},
        {jpsSegment(2, 6), left, right, {64, 48}},
        {jpsSegment(3, 5), upper, lower, {64, 48}},
        {jpsSegment(2, 5), left, right, {32, 96}},
        {jpsSegment(2, 7), left, right, {32, 48}}, // half of both: the same shape
        {jpsSegment(2, 4, 8), {0, 0, 28, 48}, {36, 0, 28, 48}, {28, 48}}, // a gap of 8 px
        {jpsSegment(2, 4, 255), left, right, {32, 48}}, // as wide as no gap can be
        {foreign + exifSegment(1) + jpsSegment(2, 4), left, right, {32, 48}},
        {jpsSegment(2, 4) + jpsSegment(3, 0), left, right, {32, 48}}, // the first one holds
    };
    for (const JpsCase& given : cases) {
        for (const char* name : {"a.jps", "a.JPG"}) {
            spill(directory / name, withSegments(jpeg, given.header));
            Notes notes;
            const auto pair = readStereoPair(directory / name, &notes);
            ASSERT_TRUE(pair) << &given - cases;
            EXPECT_TRUE(notes.empty()) << notes.front().text;
            EXPECT_EQ(pair->left.size(), given.shape) << &given - cases;
            EXPECT_EQ(pair->right.size(), given.shape) << &given - cases;
            if (given.shape != given.left.size()) {
                // a mean is kept when a picture is stretched
                EXPECT_LT(cv::norm(cv::mean(pair->left), cv::mean(picture(given.left))), 1);
                EXPECT_EQ(pair->origin, "JPS, squeezed");
                continue;
            }
            EXPECT_TRUE(samePicture(pair->left, picture(given.left))) << &given - cases;
            EXPECT_TRUE(samePicture(pair->right, picture(given.right))) << &given - cases;
            EXPECT_EQ(pair->origin, "JPS");
        }
    }
    spill(directory / "a.jpg", withSegments(jpeg, jpsSegment(3, 0)));
    EXPECT_EQ(readStereoLayout(directory / "a.jpg"), StereoLayout::BottomTop);
    spill(directory / "a.jpg", jpeg);
    EXPECT_FALSE(readStereoLayout(directory / "a.jpg"));
}

TEST_F(ReadStereoPair, JpsThatIsNoPairIsSaid) {
    const auto tryHeader = [&](const char* name, const std::string& header, bool isPair) {
        spill(directory / name, withSegments(jpeg, header));
        Notes notes;
        EXPECT_EQ(readStereoPair(directory / name, &notes).has_value(), isPair) << name;
        return notes.size() == 1 ? notes[0].text : std::to_string(notes.size()) + " notes";
    };
    const std::string begin = std::string("_JPSJPS_\0\4", 10);
    const std::string notUsed = "its JPS header is not used, as it ";
    const std::pair<std::string, std::string> damaged[] = {
        {jpsSegment(9, 4), notUsed + "states the layout 9, which does not exist"},
        {jpsSegment(0, 4), notUsed + "states the layout 0, which does not exist"},
        {jpsSegment(2, 4, 0, 7), notUsed + "states the medium 7, which does not exist"},
        {jpegSegment(0xe3, "_JPSJPS_"), notUsed + "is cut off"},
        {jpegSegment(0xe3, begin), notUsed + "is cut off"},
        {jpegSegment(0xe3, begin + std::string("\0\4\2", 3)), notUsed + "is cut off"},
        {jpegSegment(0xe3, std::string("_JPSJPS_\0\0\0\4\2\1", 14)), notUsed + "is cut off"}};
    for (const auto& [header, text] : damaged) {
        EXPECT_EQ(tryHeader("a.jpg", header, false), text + ": it is read as a photo");
        EXPECT_EQ(tryHeader("a.jps", header, true),
                  text + ": the right eye's picture is taken to be at the left");
    }
    for (const char* name : {"a.jpg", "a.jps"}) {
        EXPECT_EQ(tryHeader(name, jpsSegment(2, 4, 0, 0), false),
                  "its JPS header says that the picture is of one eye: it is read as a photo");
    }
    for (const auto& [layout, word] : {std::pair(1U, "interleaved"), std::pair(4U, "anaglyph")}) {
        const fs::path file = directory / "a.jpg";
        spill(file, withSegments(jpeg, jpsSegment(layout, 4)));
        EXPECT_EQ(errorOf([&] { return readStereoPair(file); }),
                  file.string() + ": is " + word +
                      " by its JPS header, which is not read, expected the eyes beside or above "
                      "each other");
    }
}

TEST_F(ReadStereoPair, APngNamedPnsIsCrossed) {
    const cv::Mat picture = randomPhoto({64, 48}, 1);
    writeImage(directory / "a.png", picture);
    EXPECT_FALSE(readStereoPair(directory / "a.png"));
    for (const char* name : {"b.pns", "C.PNS"}) {
        spill(directory / name, slurp(directory / "a.png"));
        const auto pair = readStereoPair(directory / name);
        ASSERT_TRUE(pair);
        EXPECT_TRUE(samePicture(pair->left, picture.colRange(32, 64)));
        EXPECT_TRUE(samePicture(pair->right, picture.colRange(0, 32)));
        EXPECT_EQ(pair->origin, "PNS");
    }
    EXPECT_EQ(listImages(directory.path()).size(), 3u);
}

// PNG's extension sTER: 0 crossed, 1 parallel; the right picture begins at a multiple of 8 px.
TEST_F(ReadStereoPair, TheChunkOfAPngSaysTheOrder) {
    const auto withMode = [&](const cv::Mat& picture, const std::string& mode) {
        writeImage(directory / "plain.png", picture);
        std::string file = slurp(directory / "plain.png"); // the checksum is not read
        file.insert(33, bigEndian(mode.size(), 4) + "sTER" + mode + std::string(4, '\0'));
        spill(directory / "a.png", file);
    };
    for (const int width : {20, 24}) { // of an eye's picture
        const int second = (width + 7) / 8 * 8;
        const cv::Mat picture = randomPhoto({second + width, 30}, 2);
        for (const char mode : {'\0', '\1'}) {
            withMode(picture, std::string(1, mode));
            const auto pair = readStereoPair(directory / "a.png");
            ASSERT_TRUE(pair);
            EXPECT_EQ(pair->origin, "PNG with sTER");
            const cv::Mat first = picture.colRange(0, width);
            const cv::Mat last = picture.colRange(second, second + width);
            EXPECT_TRUE(samePicture(pair->left, mode == 1 ? first : last)) << width;
            EXPECT_TRUE(samePicture(pair->right, mode == 1 ? last : first)) << width;
        }
    }
    withMode(randomPhoto({64, 30}, 2), "\7");
    Notes notes;
    EXPECT_FALSE(readStereoPair(directory / "a.png", &notes));
    EXPECT_TRUE(holds(only(notes).text, "its chunk sTER is not used"));
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
    const cv::Rect upper(0, 0, 101, 20);
    const cv::Rect lower(0, 20, 101, 20);
    const std::tuple<StereoLayout, cv::Rect, cv::Rect> cases[] = {
        {StereoLayout::LeftRight, first, second},
        {StereoLayout::RightLeft, second, first},
        {StereoLayout::TopBottom, upper, lower},
        {StereoLayout::BottomTop, lower, upper}};
    for (const auto& [layout, left, right] : cases) {
        const StereoPair pair = splitStereoPair(picture, layout);
        EXPECT_TRUE(samePicture(pair.left, picture(left)));
        EXPECT_TRUE(samePicture(pair.right, picture(right)));
    }
    EXPECT_EQ(splitStereoPair(picture, StereoLayout::LeftRight).origin, "left and right half");
    EXPECT_EQ(splitStereoPair(picture, StereoLayout::BottomTop).origin, "lower and upper half");
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
    for (const StereoLayout layout : {StereoLayout::LeftRight, StereoLayout::TopBottom})
        EXPECT_EQ(errorOf([&] { return splitStereoPair(one, layout); }),
                  "picture: is 1 x 1 px of CV_8UC3, expected two halves");
    const cv::Mat two(1, 2, CV_8UC3, cv::Scalar::all(0));
    EXPECT_EQ(splitStereoPair(two, StereoLayout::LeftRight, StereoHalves::Full).left.size(),
              cv::Size(1, 1));
}

// A round disc of half the smaller side, and its width : height in a picture.
cv::Mat discIn(cv::Size size) {
    cv::Mat picture(size, CV_8UC3, cv::Scalar(90, 60, 30));
    cv::circle(picture, {size.width / 2, size.height / 2}, std::min(size.width, size.height) / 4,
               cv::Scalar::all(255), -1);
    return picture;
}

double discAspect(const cv::Mat& picture) {
    cv::Mat disc;
    cv::inRange(picture, cv::Scalar(170, 150, 140), cv::Scalar::all(255), disc);
    const cv::Rect around = cv::boundingRect(disc);
    return static_cast<double>(around.width) / around.height;
}

class WriteEyes : public FileTest {};

TEST_F(WriteEyes, ADiscIsRoundAgainInAnyLayoutAndShape) {
    for (const cv::Size size : {cv::Size(320, 240), {301, 200}, {202, 350}, {480, 270}}) {
        const cv::Mat eye = discIn(size);
        for (const EyesPicture kind :
             {EyesPicture::SideBySide, EyesPicture::SideBySideHalf, EyesPicture::Crossed,
              EyesPicture::TopBottom, EyesPicture::TopBottomHalf}) {
            for (const char* name : {"a.png", "a_LR.jpg", "a_TB.jpeg"}) {
                cv::Mat joined;
                joinEyes(eye, eye, kind, joined);
                writeEyes(directory / name, joined, kind);
                const auto pair = readStereoPair(directory / name);
                ASSERT_TRUE(pair) << name << " " << size;
                EXPECT_NEAR(discAspect(pair->left), 1, 0.04) << name << size << nameOf(kind).option;
            }
        }
    }
}

TEST_F(WriteEyes, TheOrderOfTheEyesIsKept) {
    const cv::Mat left = randomPhoto({64, 48}, 1);
    const cv::Mat right = randomPhoto({64, 48}, 2);
    for (const bool swapped : {false, true}) {
        for (const EyesPicture kind :
             {EyesPicture::SideBySide, EyesPicture::Crossed, EyesPicture::TopBottom}) {
            cv::Mat joined;
            joinEyes(swapped ? right : left, swapped ? left : right, kind, joined);
            writeEyes(directory / "a.png", joined, kind, swapped);
            const auto pair = readStereoPair(directory / "a.png");
            ASSERT_TRUE(pair);
            EXPECT_TRUE(samePicture(pair->left, left));
            EXPECT_TRUE(samePicture(pair->right, right));
        }
    }
}

TEST_F(WriteEyes, WhatMixesTheEyesIsRefusedAsAPhotoAndKeepsThemApartInJpeg) {
    const cv::Mat left(48, 64, CV_8UC3, cv::Scalar(20, 20, 230));
    const cv::Mat right(48, 64, CV_8UC3, cv::Scalar(230, 230, 20));
    for (const EyesPicture kind : {EyesPicture::Rows, EyesPicture::AnaglyphHalf}) {
        cv::Mat joined;
        joinEyes(left, right, kind, joined);
        for (const char* name : {"a.png", "a.jpg"}) {
            writeEyes(directory / name, joined, kind);
            EXPECT_LE(cv::norm(readPhoto(directory / name), joined, cv::NORM_INF), 4) << name;
            EXPECT_TRUE(holds(errorOf([&] { return readStereoPair(directory / name); }),
                              kind == EyesPicture::Rows ? "is interleaved" : "is anaglyph"));
        }
    }
}

TEST_F(WriteEyes, AShapeThatIsGuessedIsToldUnlessMarkOrNameSaysIt) {
    const cv::Mat half = discIn({640, 480}); // 4:3, as a whole
    writeEyes(directory / "marked.png", half, EyesPicture::SideBySideHalf);
    writeImage(directory / "a_LR.png", half);
    const auto split = [&](const char* name, StereoHalves halves, Notes& notes) {
        return splitStereoFile(half, StereoLayout::LeftRight, halves, directory / name, &notes)
            .left.size();
    };
    Notes notes;
    EXPECT_EQ(split("marked.png", StereoHalves::Automatic, notes), cv::Size(640, 480));
    EXPECT_EQ(split("a_LR.png", StereoHalves::Squeezed, notes), cv::Size(640, 480));
    EXPECT_EQ(split("a_LR.png", StereoHalves::Full, notes), cv::Size(320, 480));
    for (const char* name : {"a_HSBS.png", "a_half_SBS.png", "a_SBS_half.png"}) {
        writeImage(directory / name, half);
        EXPECT_EQ(split(name, StereoHalves::Automatic, notes), cv::Size(640, 480)) << name;
    }
    EXPECT_TRUE(notes.empty()) << notes.front().text;
    EXPECT_EQ(split("a_LR.png", StereoHalves::Automatic, notes), cv::Size(320, 480));
    ASSERT_EQ(notes.size(), 1U);
    EXPECT_TRUE(holds(notes.front().text, "--stereo left-right:squeezed"));
}

TEST_F(WriteEyes, AFrameAndAGapAreLeftOut) {
    const Eyes eyes = wallAndThing(6, 20);
    const cv::Size size = eyes.left.size();
    const auto joined = [&](int frame, int gap, int colour, int bars) {
        cv::Mat whole(size.height + 2 * (frame + bars), 2 * size.width + 2 * frame + gap, CV_8UC3,
                      cv::Scalar::all(colour));
        eyes.left.copyTo(whole(cv::Rect({frame, frame + bars}, size)));
        eyes.right.copyTo(whole(cv::Rect({frame + size.width + gap, frame + bars}, size)));
        writeImage(directory / "a_LRF.png", whole);
        Notes notes;
        StereoPair pair = splitStereoFile(whole, StereoLayout::LeftRight, StereoHalves::Automatic,
                                          directory / "a_LRF.png", &notes);
        EXPECT_EQ(notes.size(), frame + gap + bars > 0 ? 1U : 0U);
        return pair;
    };
    for (const auto& [frame, gap, colour, bars] : {std::array{0, 0, 0, 0},
                                                   {40, 0, 0, 0},
                                                   {30, 24, 0, 0},
                                                   {0, 40, 255, 0},
                                                   {0, 0, 0, 50},
                                                   {20, 60, 128, 10}}) {
        const StereoPair pair = joined(frame, gap, colour, bars);
        EXPECT_TRUE(samePicture(pair.left, eyes.left)) << frame << " " << gap;
        EXPECT_TRUE(samePicture(pair.right, eyes.right)) << frame << " " << gap;
    }
}

// XMP of a panorama, its part in px.
std::string gpano(int width, int height, int wholeWidth, int wholeHeight) {
    const auto number = [](const char* name, int value) {
        return std::string(" GPano:") + name + "='" + std::to_string(value) + "'";
    };
    return xmpOf("xmlns:GPano='http://ns.google.com/photos/1.0/panorama/' "
                 "GPano:ProjectionType='equirectangular'" +
                 number("CroppedAreaImageWidthPixels", width) +
                 number("CroppedAreaImageHeightPixels", height) +
                 number("FullPanoWidthPixels", wholeWidth) +
                 number("FullPanoHeightPixels", wholeHeight));
}

class Panoramas : public FileTest {};

TEST_F(Panoramas, ASphereIsRefusedInAnyFormatWithACommandThatFlattensIt) {
    const cv::Mat sphere = randomPhoto({128, 64});
    const std::string xmp = gpano(128, 64, 128, 64);
    const std::string png = encoded(".png", sphere);
    const std::pair<const char*, std::string> files[] = {
        {"s.jpg", withSegments(jpegOf(sphere), xmpSegment(xmp))},
        {"s.png", withPngChunks(
                      png, pngChunk("iTXt", std::string("XML:com.adobe.xmp\0\0\0\0\0", 22) + xmp))},
        {"$s '1'.tif", encoded(".tif", sphere) + xmp}}; // for a shell in quotes
    for (const auto& [name, bytes] : files) {
        const auto file = directory / name;
        spill(file, bytes);
        const std::string error = errorOf([&] { return readPhoto(file); });
        EXPECT_TRUE(holds(error, "shows 360 x 180 degrees of a sphere")) << error;
        EXPECT_TRUE(holds(error, "ffmpeg -i " + shellWord(file.string()) + " "));
        EXPECT_TRUE(holds(error, "-vf v360=e:flat:yaw=0:pitch=0:h_fov=90:v_fov=73.74:w=40:h=30"))
            << error;
    }
}

TEST_F(Panoramas, AHemisphereIsPaddedAndItsRightEyeIsFlattenedAlso) {
    const cv::Mat half = randomPhoto({64, 64});
    const std::string right = xmpOf("xmlns:GImage='http://ns.google.com/photos/1.0/image/' "
                                    "GImage:Data=\"" +
                                    toBase64(jpegOf(half)) + "\"");
    const std::string left =
        withSegments(jpegOf(half), xmpSegment(gpano(64, 64, 128, 64)) + moreXmpSegments(right));
    spill(directory / "v.vr.jpg", left);
    const std::string error = errorOf([&] { return readStereoPair(directory / "v.vr.jpg"); });
    EXPECT_TRUE(holds(error, "shows 180 x 180 degrees of a sphere")) << error;
    EXPECT_TRUE(holds(error, "exiftool")) << error;
    EXPECT_TRUE(holds(error, "[1]pad=128:64:32:0,v360=e:flat")) << error;
}

TEST_F(Panoramas, PhonesPanoramasArePicturesAndCardboardsArePairs) {
    const cv::Mat photo = randomPhoto({240, 80}, 1);
    const std::string strip =
        withSegments(jpegOf(photo), xmpSegment(gpano(240, 80, 720, 360))); // 120 x 40
    spill(directory / "p.jpg", strip);
    Notes notes;
    EXPECT_TRUE(samePicture(readPhoto(directory / "p.jpg", &notes), decoded(jpegOf(photo))));
    EXPECT_FALSE(readStereoPair(directory / "p.jpg", &notes));
    EXPECT_TRUE(notes.empty());
    const std::string other = jpegOf(randomPhoto({240, 80}, 2));
    const std::string right = xmpOf("xmlns:GImage='http://ns.google.com/photos/1.0/image/' "
                                    "GImage:Mime='image/jpeg' GImage:Data=\"" +
                                    toBase64(other) + "\"");
    spill(directory / "c.vr.jpg", withSegments(jpegOf(photo), xmpSegment(gpano(240, 80, 240, 160)) +
                                                                  moreXmpSegments(right, 3000)));
    const auto pair = readStereoPair(directory / "c.vr.jpg", &notes);
    ASSERT_TRUE(pair);
    EXPECT_EQ(pair->origin, "Cardboard Camera");
    EXPECT_TRUE(samePicture(pair->left, decoded(jpegOf(photo))));
    EXPECT_TRUE(samePicture(pair->right, decoded(other)));
    EXPECT_TRUE(notes.empty());
}

TEST(MixedEyes, AnaglyphsAndInterlacedPicturesAreFoundAndPhotosAreNot) {
    Eyes eyes = wallAndThing(4, 14);
    cv::GaussianBlur(eyes.left, eyes.left, {}, 1);
    cv::GaussianBlur(eyes.right, eyes.right, {}, 1);
    // channels of noise have nothing to do with each other; those of photos have
    for (cv::Mat* eye : {&eyes.left, &eyes.right}) {
        cv::cvtColor(*eye, *eye, cv::COLOR_BGR2GRAY);
        cv::cvtColor(*eye, *eye, cv::COLOR_GRAY2BGR);
    }
    EXPECT_EQ(mixedEyes(eyes.left), "");
    EXPECT_EQ(mixedEyes(randomPhoto({400, 300})), "");
    EXPECT_EQ(mixedEyes(cv::Mat(300, 400, CV_8UC3, cv::Scalar::all(9))), "");
    EXPECT_EQ(mixedEyes(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(9))), "");
    const auto mixed = [&](EyesPicture kind) {
        cv::Mat joined;
        joinEyes(eyes.left, eyes.right, kind, joined);
        return joined;
    };
    for (const EyesPicture kind :
         {EyesPicture::Anaglyph, EyesPicture::AnaglyphHalf, EyesPicture::AnaglyphGrey})
        EXPECT_TRUE(holds(mixedEyes(mixed(kind)), "red-cyan anaglyph")) << nameOf(kind).option;
    const cv::Mat rows = mixed(EyesPicture::Rows);
    EXPECT_TRUE(holds(mixedEyes(rows), "every second row"));
    EXPECT_TRUE(holds(mixedEyes(compressed(rows, 90)), "every second row"));
    cv::Mat columns = eyes.left.clone();
    for (int x = 1; x < columns.cols; x += 2)
        eyes.right.col(x).copyTo(columns.col(x));
    EXPECT_TRUE(holds(mixedEyes(columns), "every second column"));
}

} // namespace
} // namespace altiro3D::test
