// Depth inside photos, in files made as phones write them.

#include "altiro3D/image_io.hpp"

#include "altiro3D/depth_source.hpp"
#include "image/depth_parts.hpp"
#include "image/heif_file.hpp"
#include "image/xmp.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/photo_files.hpp"
#include "support/picture_files.hpp"
#include "support/pixels.hpp"
#include "support/random_pictures.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D {
namespace {

using namespace test;

constexpr int kColumns = 40;
constexpr int kRows = 30;

int levelOf(int x, int columns = kColumns) {
    return x * 255 / (columns - 1);
}

// A ramp of 0..255 from left to right.
cv::Mat ramp(int columns = kColumns, int rows = kRows) {
    return pictureOf<std::uint8_t>({columns, rows},
                                   [&](int x, int) { return levelOf(x, columns); });
}

std::string jpegOf(const cv::Mat& picture) {
    return encoded(".jpg", picture, {cv::IMWRITE_JPEG_QUALITY, 100});
}

class EmbeddedDepthFiles : public FileTest {
  protected:
    std::filesystem::path file(const std::string& contents) const {
        spill(directory / "a.jpg", contents);
        return directory / "a.jpg";
    }
    std::optional<EmbeddedDepth> read(const std::string& contents) {
        notes.clear();
        return readEmbeddedDepth(file(contents), &notes);
    }
    // The depth is the ramp; a JPEG changes it by a level or two.
    void expectRamp(const std::optional<EmbeddedDepth>& found, EmbeddedDepthForm form,
                    bool nearIsRight) {
        ASSERT_TRUE(found);
        EXPECT_EQ(found->form, form);
        EXPECT_TRUE(notes.empty());
        ASSERT_EQ(found->depth.size(), cv::Size(kColumns, kRows));
        ASSERT_EQ(found->depth.type(), CV_32FC1);
        for (int x = 0; x < kColumns; ++x) {
            const double share = levelOf(x) / 255.0;
            EXPECT_NEAR(found->depth.at<float>(7, x), nearIsRight ? share : 1 - share, 2.5 / 255);
        }
    }
    Notes notes;
    std::string photo = jpegOf(scenery({4 * kColumns, 4 * kRows}, 3));
    std::string depthJpeg = jpegOf(ramp());
    std::string depthPng = encoded(".png", ramp());
};

TEST_F(EmbeddedDepthFiles, DynamicDepthIsNearDark) {
    const std::string other = jpegOf(cv::Mat(3, 4, CV_8UC1, cv::Scalar(9)));
    expectRamp(
        read(dynamicDepthPhoto(
            photo, {{"GainMap", other, ""}, {"Depth", depthJpeg, ""}, {"Confidence", other, ""}})),
        EmbeddedDepthForm::DynamicDepth, false);
    EXPECT_EQ(read(dynamicDepthPhoto(photo, {{"Depth", depthJpeg, ""}}))->text(),
              "Dynamic Depth, 40 x 30 px");
    const std::string whole = slurp(directory / "a.jpg");
    const std::size_t tail = whole.size() - depthJpeg.size(); // items are found from the end
    expectRamp(read(whole.substr(0, tail) + "foreign" + whole.substr(tail)),
               EmbeddedDepthForm::DynamicDepth, false);
    // the first generation: elements, another namespace, no meaning but the URI
    expectRamp(
        read(dynamicDepthPhoto(
            photo, {{"", other, "android/original_image"}, {"", depthJpeg, "android/depthmap"}},
            "RangeInverse", 1, 2, true)),
        EmbeddedDepthForm::DynamicDepth, false);
}

TEST_F(EmbeddedDepthFiles, GDepthOfAPngIsExact) {
    const auto found = read(gDepthPhoto(photo, depthPng));
    expectRamp(found, EmbeddedDepthForm::GDepth, false);
    for (int x = 0; x < kColumns; ++x)
        EXPECT_FLOAT_EQ(found->depth.at<float>(0, x), static_cast<float>(1 - levelOf(x) / 255.0));
    cv::Mat colours;
    cv::merge(std::vector<cv::Mat>{ramp(), ramp(), ramp(), cv::Mat(kRows, kColumns, CV_8UC1, 255)},
              colours);
    expectRamp(read(gDepthPhoto(photo, encoded(".png", colours))), EmbeddedDepthForm::GDepth,
               false);
}

TEST_F(EmbeddedDepthFiles, ExtendedXmpOfAnotherVersionIsLeftAlone) {
    const std::string now = "0123456789ABCDEF0123456789ABCDEF";
    const std::string stale = "FEDCBA9876543210FEDCBA9876543210";
    const std::string facts =
        xmpOf("xmlns:GDepth='http://ns.google.com/photos/1.0/depthmap/' GDepth:Format="
              "'RangeInverse' xmlns:xmpNote='http://ns.adobe.com/xmp/note/' "
              "xmpNote:HasExtendedXMP='" +
              now + "'");
    const std::string data = xmpOf("xmlns:GDepth='http://ns.google.com/photos/1.0/depthmap/' "
                                   "GDepth:Data='" +
                                   toBase64(depthPng) + "'");
    expectRamp(
        read(withSegments(photo, xmpSegment(facts) + moreXmpSegments("<old/>", 60000, stale) +
                                     moreXmpSegments(data, 5000, now))),
        EmbeddedDepthForm::GDepth, false);
    EXPECT_FALSE(read(withSegments(photo, xmpSegment(facts) + moreXmpSegments(data, 5000, stale))));
}

// Z = near + v (far - near); relative inverse depth is (1/Z - 1/far) / (1/near - 1/far).
TEST_F(EmbeddedDepthFiles, RangeLinearBecomesInverseDepth) {
    const double nearest = 0.5;
    const double farthest = 10;
    const auto found = read(gDepthPhoto(photo, depthPng, "RangeLinear", nearest, farthest));
    ASSERT_TRUE(found);
    for (int x = 0; x < kColumns; ++x) {
        const double z = nearest + levelOf(x) / 255.0 * (farthest - nearest);
        EXPECT_NEAR(found->depth.at<float>(3, x),
                    (1 / z - 1 / farthest) / (1 / nearest - 1 / farthest), 1e-6);
    }
    for (const auto& [badNear, badFar] : std::vector<std::pair<double, double>>{
             {0, 10}, {-1, 10}, {5, 5}, {10, 1}, {0, 0}, {1e-300, 1e300}}) {
        expectRamp(read(gDepthPhoto(photo, depthPng, "RangeLinear", badNear, badFar)),
                   EmbeddedDepthForm::GDepth, false);
    }
}

TEST_F(EmbeddedDepthFiles, AppleJpegsAreChosenByTheirOwnXmp) {
    const std::string matte = appleAuxiliary(jpegOf(cv::Mat(kRows, kColumns, CV_8UC1, 5)), "depth",
                                             "portraitEffectsMatte");
    const std::string gain = jpegOf(ramp(8, 6));
    const std::string depth = appleAuxiliary(depthJpeg, "disparity");
    expectRamp(read(appleJpeg(photo, {depth})), EmbeddedDepthForm::AppleJpeg, true);
    expectRamp(read(appleJpeg(photo, {gain, matte, depth})), EmbeddedDepthForm::AppleJpeg, true);
    EXPECT_FALSE(read(appleJpeg(photo, {gain, matte})));
    // Many entries that name one long picture are not searched one by one.
    std::string list = bigEndian(0x030000, 4) + std::string(12, '\0');
    for (int i = 0; i < 99; ++i)
        list += bigEndian(0, 4) + bigEndian(40'000'000, 4) + bigEndian(8000, 4) + bigEndian(0, 4);
    std::string index = std::string("MPF\0MM\0*\0\0\0\10\0\144", 14);
    for (int i = 0; i < 100; ++i)
        index += bigEndian(0xb002, 2) + bigEndian(7, 2) + bigEndian(list.size(), 4) +
                 bigEndian(8 + 2 + 1200 + 4, 4);
    std::string hostile =
        withSegments(photo, jpegSegment(0xe2, index + std::string(4, '\0') + list));
    const std::size_t listed = 2 + 4 + 4 + 8000; // where the entries point
    hostile.resize(std::max(hostile.size(), listed + 40'000'000), '\0');
    hostile.replace(listed, 2, "\xff\xd8");
    EXPECT_FALSE(read(hostile)) << "and soon";
    EXPECT_TRUE(notes.empty());
}

TEST_F(EmbeddedDepthFiles, TheOrientationOfThePhotoCountsForBoth) {
    const auto found = read(
        appleJpeg(withSegments(photo, exifSegment(6)), {appleAuxiliary(depthJpeg, "disparity")}));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->depth.size(), cv::Size(kRows, kColumns));
    EXPECT_LT(found->depth.at<float>(2, 5), 0.1F); // left becomes top
    EXPECT_GT(found->depth.at<float>(kColumns - 2, 5), 0.9F);
    EXPECT_EQ(readPhoto(directory / "a.jpg").size(), cv::Size(4 * kRows, 4 * kColumns));
}

TEST_F(EmbeddedDepthFiles, HeicAndAvifHoldDisparity) {
    if (!hasHeif()) GTEST_SKIP() << "needs libheif, which this build does not have";
    HeifItem depth = av1Ramp(2);
    depth.properties.push_back(auxC("urn:mpeg:mpegB:cicp:systems:auxiliary:depth"));
    const std::vector<std::pair<std::string, EmbeddedDepthForm>> files = {
        {appleHeic(), EmbeddedDepthForm::AppleHeic},
        {appleHeic(true), EmbeddedDepthForm::AppleHeic},
        {heifFile("avif", {av1Colours(1), depth}, {{"auxl", 2, {1}}}), EmbeddedDepthForm::Avif}};
    for (const auto& [bytes, form] : files) {
        const auto found = read(bytes);
        ASSERT_TRUE(found);
        EXPECT_EQ(found->form, form);
        ASSERT_EQ(found->depth.size(), cv::Size(128, 64));
        for (int x = 0; x < 128; ++x) // the encoder loses some
            EXPECT_NEAR(found->depth.at<float>(20, x), x / 127.0, 0.06) << x;
    }
    EXPECT_FALSE(read(heifFile("heic", {hevcColours(1)})));
}

TEST_F(EmbeddedDepthFiles, DepthOfAnotherShapeOrWithoutRangeIsNotUsed) {
    EXPECT_FALSE(read(gDepthPhoto(photo, encoded(".png", ramp(kColumns, kRows + 2)))));
    EXPECT_EQ(only(notes).code, NoteCode::LeftOut);
    EXPECT_EQ(only(notes).text,
              "the depth (Google lens blur, 40 x 32 px) in the file is not used: its shape is "
              "not that of the photo, 160 x 120 px");
    cv::Mat flat(kRows, kColumns, CV_8UC1, cv::Scalar(77));
    flat.at<std::uint8_t>(3, 3) = 255; // one px is no range
    EXPECT_FALSE(read(gDepthPhoto(photo, encoded(".png", flat))));
    EXPECT_TRUE(holds(only(notes).text, "it is flat"));
    EXPECT_TRUE(read(gDepthPhoto(photo, encoded(".png", ramp(800, 608))))) << "within 2 %";
}

TEST_F(EmbeddedDepthFiles, PhotosWithoutDepthHaveNone) {
    EXPECT_FALSE(read(photo));
    const std::string left = dynamicDepthPhoto(photo, {{"Depth", depthJpeg, ""}});
    EXPECT_FALSE(read(left.substr(0, left.size() - depthJpeg.size()))) << "XMP stays behind";
    EXPECT_TRUE(notes.empty());
    EXPECT_FALSE(read(encoded(".png", ramp())));
    EXPECT_FALSE(read(""));
    EXPECT_FALSE(read("text"));
    EXPECT_EQ(errorOf([&] { return readEmbeddedDepth(directory / "none.jpg"); }),
              (directory / "none.jpg").string() + ": does not exist, expected a file");
}

TEST_F(EmbeddedDepthFiles, BrokenFilesGiveDepthOrNone) {
    const std::vector<std::string> files = {
        dynamicDepthPhoto(photo, {{"Depth", depthJpeg, ""}}), gDepthPhoto(photo, depthPng),
        appleJpeg(photo, {appleAuxiliary(depthJpeg, "disparity")})};
    for (const std::string& whole : files)
        for (std::size_t size = 0; size < whole.size(); size += 97)
            EXPECT_EQ(errorOf([&] { read(whole.substr(0, size)); }), "(no error)") << size;
}

TEST_F(EmbeddedDepthFiles, TheSharpOriginalIsRead) {
    const cv::Mat sharp = scenery({2 * kColumns, 2 * kRows}, 8);
    EXPECT_TRUE(samePicture(readUnblurredPhoto(file(gDepthPhoto(photo, depthPng, "RangeInverse", 1,
                                                                2, encoded(".png", sharp)))),
                            sharp));
    const cv::Mat pixel = readUnblurredPhoto(file(
        dynamicDepthPhoto(photo, {{"Original", jpegOf(sharp), ""}, {"Depth", depthJpeg, ""}})));
    EXPECT_EQ(pixel.size(), sharp.size());
    EXPECT_TRUE(readUnblurredPhoto(file(photo)).empty());
    EXPECT_TRUE(readUnblurredPhoto(file(gDepthPhoto(photo, depthPng)), &notes).empty());
    EXPECT_TRUE(notes.empty());
    EXPECT_TRUE(readUnblurredPhoto(
                    file(dynamicDepthPhoto(photo, {{"Original", jpegOf(ramp(9, 50)), ""}})), &notes)
                    .empty());
    EXPECT_EQ(only(notes).text,
              "the sharp original in the file is not used: its shape is not that of the photo");
}

TEST_F(EmbeddedDepthFiles, WrittenDepthBeyondItsRangeIsClamped) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const cv::Mat picture = scenery({80, 60}, 4);
    cv::Mat limits(picture.size(), CV_32FC1, cv::Scalar(0));
    limits.colRange(0, 40).setTo(1);
    for (const float size : {1.5F, 1e9F, 1e20F, kInfinity}) {
        cv::Mat beyond(picture.size(), CV_32FC1, cv::Scalar(-size));
        beyond.colRange(0, 40).setTo(size);
        writePhotoWithDepth(directory / "limits.jpg", picture, limits);
        writePhotoWithDepth(directory / "beyond.jpg", picture, beyond);
        EXPECT_EQ(slurp(directory / "beyond.jpg"), slurp(directory / "limits.jpg")) << size;
    }
}

TEST_F(EmbeddedDepthFiles, AWrittenPhotoIsReadBack) {
    const cv::Mat picture = scenery({81, 60}, 4);
    cv::Mat depth;
    ramp(81, 60).convertTo(depth, CV_32F, 1 / 255.0);
    depth.at<float>(0, 0) = std::numeric_limits<float>::quiet_NaN();
    writePhotoWithDepth(directory / "w.jpg", picture, depth);
    const auto found = readEmbeddedDepth(directory / "w.jpg", &notes);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->form, EmbeddedDepthForm::DynamicDepth);
    ASSERT_EQ(found->depth.size(), picture.size());
    EXPECT_LT(cv::norm(found->depth.rowRange(16, 60), depth.rowRange(16, 60), cv::NORM_INF), 0.04);
    writeImage(directory / "plain.jpg", picture);
    EXPECT_TRUE(
        samePicture(readPhoto(directory / "w.jpg", &notes), readPhoto(directory / "plain.jpg")));
    EXPECT_TRUE(notes.empty());
    EXPECT_EQ(errorOf([&] { writePhotoWithDepth(directory / "w.png", picture, depth); }),
              (directory / "w.png").string() +
                  ": a photo with depth is a JPEG, expected the extension .jpg");
    EXPECT_EQ(errorOf([&] { writePhotoWithDepth(directory / "v.jpg", picture, depth.t()); }),
              "depth: has 60 x 81 px, expected the shape of the photo's 81 x 60 px");
    EXPECT_FALSE(std::filesystem::exists(directory / "v.jpg"));
}

// A floor that rises to the back, and boxes on it. [CV_32FC1, 0..1]
cv::Mat boxesOnAFloor(cv::Size size) {
    cv::Mat depth(size, CV_32FC1);
    for (int y = 0; y < size.height; ++y)
        depth.row(y).setTo(0.8 * y / size.height);
    depth(cv::Rect(size.width / 8, size.height / 4, size.width / 4, size.height / 3)).setTo(0.9);
    depth(cv::Rect(size.width / 2, size.height / 2, size.width / 3, size.height / 4)).setTo(0.6);
    return depth;
}

cv::Mat threeChannels(const cv::Mat& grey, int depth, double scale) {
    cv::Mat picture;
    grey.convertTo(picture, depth, scale);
    cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
    return picture;
}

TEST(LooksLikeDepthImage, IsSaidOfWhatIsGreyAndSmoothOnly) {
    for (const cv::Size size : {cv::Size(640, 480), cv::Size(301, 997), cv::Size(40, 30)}) {
        const cv::Mat depth = boxesOnAFloor(size);
        for (const auto& [type, scale] : // 5000: mm
             {std::pair(CV_8U, 255), {CV_16U, 65535}, {CV_16U, 5000}, {CV_32F, 1}})
            EXPECT_TRUE(looksLikeDepthImage(threeChannels(depth, type, scale))) << size << scale;
        EXPECT_TRUE(looksLikeDepthImage(threeChannels(1 - depth, CV_8U, 255))) << size;
        cv::Mat holes = threeChannels(depth, CV_32F, 9);
        holes(cv::Rect(0, 0, 5, 5)).setTo(std::numeric_limits<double>::quiet_NaN());
        holes(cv::Rect(9, 9, 2, 2)).setTo(std::numeric_limits<double>::infinity());
        EXPECT_TRUE(looksLikeDepthImage(holes)) << size;

        cv::Mat map = threeChannels(depth, CV_8U, 255); // a colour map of depth
        cv::applyColorMap(map, map, cv::COLORMAP_JET);
        EXPECT_FALSE(looksLikeDepthImage(map)) << size;
        cv::Mat photo = randomPhoto(size); // without its colours
        cv::cvtColor(photo, photo, cv::COLOR_BGR2GRAY);
        EXPECT_FALSE(looksLikeDepthImage(threeChannels(photo, CV_8U, 1))) << size;
        cv::Mat drawing(size, CV_8UC3, cv::Scalar::all(255)); // two greys
        cv::circle(drawing, {size.width / 2, size.height / 2}, size.width / 4, cv::Scalar::all(90),
                   cv::FILLED, cv::LINE_AA);
        EXPECT_FALSE(looksLikeDepthImage(drawing)) << size;
        for (const double value : {0.0, 77.0})
            EXPECT_FALSE(looksLikeDepthImage(cv::Mat(size, CV_8UC3, cv::Scalar::all(value))));
    }
    for (const cv::Size tiny : {cv::Size(1, 1), cv::Size(2, 500), cv::Size(5000, 16)})
        EXPECT_FALSE(looksLikeDepthImage(cv::Mat(tiny, CV_32FC3, cv::Scalar::all(1)))) << tiny;
    EXPECT_THROW(static_cast<void>(looksLikeDepthImage(cv::Mat())), Error);
    EXPECT_THROW(static_cast<void>(looksLikeDepthImage(cv::Mat(20, 20, CV_8UC1))), Error);
}

TEST(LooksLikeDepthImage, IsRightForRealDepthAndGreyPhotos) {
    ALTIRO3D_REQUIRE_DATA("middlebury");
    ALTIRO3D_REQUIRE_DATA("photos");
    for (const char* scene : {"Art", "Books", "Cones", "Teddy", "Venus"}) {
        for (const char* name : {"disp1.png", "disp2.png", "disp5.png", "disp6.png", "disp2.pgm"}) {
            const auto file = dataPath("middlebury") / scene / name;
            if (!std::filesystem::exists(file)) continue;
            EXPECT_TRUE(looksLikeDepthImage(altiro3D::readImage(file))) << file;
        }
    }
    int photos = 0;
    for (const char* folder : {"photos/kodak", "photos/skimage"}) {
        for (const auto& file : listImages(dataPath(folder))) {
            cv::Mat photo = readPhoto(file);
            cv::cvtColor(photo, photo, cv::COLOR_BGR2GRAY);
            EXPECT_FALSE(looksLikeDepthImage(threeChannels(photo, CV_8U, 1))) << file;
            ++photos;
        }
    }
    EXPECT_GT(photos, 10);
}

TEST(DepthNames, TellThePhotoThatADepthImageIsFor) {
    for (const char* separator : {"-", "_", ".", " "}) {
        for (const char* word : {"depth", "Depth", "DEPTH", "depthmap", "depth_map", "disparity"}) {
            const std::string name = std::string("d/a") + separator + word + ".png";
            EXPECT_EQ(photoOfDepthName(name), "d/a") << name;
        }
    }
    EXPECT_EQ(photoOfDepthName("a.b-depth.tif"), "a.b");
    EXPECT_EQ(photoOfDepthName("herewith_depth.png"), "herewith");
    EXPECT_EQ(photoOfDepthName("with_depth.png"), "with");
    EXPECT_EQ(photoOfDepthName("/d.e/My photo 1-depth-depth.pfm"), "/d.e/My photo 1-depth");
    for (const char* name :
         {"a.png", "depth.png", "-depth.png", "_depth_map.png", "adepth.png", "a-depths.png",
          "a-depth1.png", "a-depth/b.png", "", "depth", "a_with_depth.jpg", "a-With-Depth.jpg"})
        EXPECT_EQ(photoOfDepthName(name), "") << name;
}

TEST_F(EmbeddedDepthFiles, TheDepthBesideAPhotoIsFoundByEveryName) {
    const auto photoFile = directory / "a.jpg";
    for (const char* other :
         {"b-depth.png", "a-depth.txt", "aa-depth.png", "a-depth-depth.png", "a2_depth.png"})
        spill(directory / other, "not of this photo");
    std::filesystem::create_directory(directory / "a_depth.tif");
    std::error_code noLinks; // on Windows
    std::filesystem::create_symlink("nowhere", directory / "a_depth.exr", noLinks);
    EXPECT_EQ(findDepthBeside(photoFile), "");
    for (const char* name :
         {"a-depth.png", "a_depth.jpg", "a.depth.TIFF", "a DEPTH.pfm", "a-disparity.png",
          "a_disparity.webp", "a.depthmap.heic", "a-depth_map.exr"}) {
        spill(directory / name, "x");
        EXPECT_EQ(findDepthBeside(photoFile), directory / name);
        EXPECT_EQ(findDepthBeside(directory / "a.HEIC"), directory / name); // of any format
        std::filesystem::remove(directory / name);
    }
    for (const char* name : {"a_depth.png", "a_Depth.bmp", "a-disparity.png"})
        spill(directory / name, "x");
    EXPECT_EQ(findDepthBeside(photoFile), directory / "a-disparity.png"); // natural order
    EXPECT_EQ(findDepthBeside(directory / "none" / "a.jpg"), "");
    EXPECT_EQ(findDepthBeside(""), "");
}

TEST_F(EmbeddedDepthFiles, TheDepthBesideAPhotoMayHaveTheSameNameInOtherLetters) {
    const auto jpeg = directory / u8"Caf\u00e9 1.JPG";
    const auto decomposed = directory / u8"cafe\u0301 1-DEPTH.PNG"; // as files of a Mac
    spill(jpeg, "x");
    spill(directory / u8"Caf\u00e8 1-depth.png", "another letter");
    EXPECT_EQ(findDepthBeside(jpeg), "");
    spill(decomposed, "x");
    EXPECT_EQ(findDepthBeside(jpeg), decomposed);
    spill(directory / u8"cafe\u0301 1.jpg", "x"); // whose depth it is
    EXPECT_EQ(findDepthBeside(jpeg), "");
    EXPECT_EQ(findDepthBeside(directory / u8"cafe\u0301 1.jpg"), decomposed);
    const auto exact = directory / u8"Caf\u00e9 1_depth.png";
    spill(exact, "x");
    EXPECT_EQ(findDepthBeside(jpeg), exact);
    std::filesystem::remove(directory / u8"cafe\u0301 1.jpg");
    EXPECT_EQ(findDepthBeside(jpeg), exact);
}

TEST(ReasonAgainstDepth, IsAnotherShapeOrNoRange) {
    const cv::Size photo(400, 300);
    const auto reason = [&](const cv::Mat& samples) { return reasonAgainstDepth(samples, photo); };
    const cv::Mat ramp = pictureOf<float>({40, 30}, [](int x, int y) { return 1000 + 40 * y + x; });
    EXPECT_EQ(reason(ramp), "");
    EXPECT_EQ(reason(-ramp), "");
    EXPECT_EQ(reason(ramp.colRange(0, 39)),
              "its shape, 39 x 30 px, is not that of the photo, 400 x "
              "300 px");
    cv::Mat flat(30, 40, CV_32FC1, cv::Scalar(7));
    EXPECT_EQ(reason(flat), "it is flat");
    flat.at<float>(3, 3) = 255; // single px are no range
    flat.at<float>(4, 3) = std::numeric_limits<float>::infinity();
    EXPECT_EQ(reason(flat), "it is flat");
    EXPECT_EQ(reason(cv::Mat::zeros(30, 40, CV_32FC1)), "it is flat");
    EXPECT_EQ(reason(cv::Mat(30, 40, CV_32FC1, cv::Scalar(std::nan("")))), "it is flat");
    EXPECT_EQ(errorOf([&] { return reason({}); }),
              "samples: is empty, expected one channel of 8 or 16 bits or of floats");
}

TEST_F(EmbeddedDepthFiles, DepthBesideThatDoesNotFitIsLeftOut) {
    const auto source = storedDepthOr(estimatedDepth());
    const auto path = file(gDepthPhoto(photo, depthPng));
    for (const cv::Mat& unfit : {cv::Mat(15, 20, CV_8UC1, cv::Scalar(90)), ramp(20, 20)}) {
        spill(directory / "a_depth.png", encoded(".png", unfit));
        notes.clear();
        EXPECT_EQ(source->readPhoto(path, &notes).text,
                  "depth in the photo's file (Google lens blur, 40 x 30 px)");
        EXPECT_TRUE(startsWith(only(notes).text, (directory / "a_depth.png").string() +
                                                     ": is not used as depth: it"));
    }
}

TEST_F(EmbeddedDepthFiles, ASourceTakesTheDepthThatComesWithThePhoto) {
    const auto source = storedDepthOr(estimatedDepth());
    altiro3D::Scene scene;
    const auto path = file(gDepthPhoto(photo, depthPng));
    const PhotoDepth found = source->readPhoto(path);
    source->readScene(found, 0.5, scene);
    EXPECT_EQ(found.text, "depth in the photo's file (Google lens blur, 40 x 30 px)");
    EXPECT_EQ(scene.depth.size(), cv::Size(kColumns, kRows));
    EXPECT_GT(scene.depth.at<float>(5, 0), scene.depth.at<float>(5, kColumns - 1));

    spill(directory / "b.jpg", photo);
    const PhotoDepth plain = source->readPhoto(directory / "b.jpg");
    source->readScene(plain, 0.5, scene);
    EXPECT_EQ(plain.text, estimatedDepth()->description());
    altiro3D::Scene expected;
    estimatedDepth()->readScene(readPhoto(directory / "b.jpg"), 0.5, expected);
    EXPECT_TRUE(samePicture(scene.depth, expected.depth));

    PhotoDepthOptions off;
    off.useDepth = false;
    const auto without = storedDepthOr(estimatedDepth(), off);
    EXPECT_EQ(without->readPhoto(path).text, estimatedDepth()->description());
}

TEST(Xmp, AttributesAndElementsCountTheSame) {
    const std::string text = xmpOf("xmlns:a='http://x/a/' a:one='1'",
                                   "<a:two>2.5</a:two><a:three><a:in>x</a:in></a:three>");
    const Xmp xmp(text);
    EXPECT_EQ(xmp.value("x/a", "one"), "1");
    EXPECT_EQ(xmp.number("x/a", "two"), 2.5);
    EXPECT_EQ(xmp.value("x/a", "in"), "x");
    EXPECT_FALSE(xmp.has("x/a", "three"));
    EXPECT_FALSE(xmp.has("x/b", "one"));
}

TEST(Xmp, QuotesInCommentsAndRawTextMeanNothing) {
    const std::string data = "xmlns:a='u' a:Data=\"" + std::string(3000, 'x') + "\"";
    const std::string raw = "<b xmlns='v'><![CDATA[it's \"<]]></b>";
    for (const std::string& text :
         {"<!-- photographer's copy -->" + xmpOf(data), xmpOf(data, raw + "<!--'-->" + raw)})
        EXPECT_EQ(Xmp(text).value("u", "Data").size(), 3000U) << text.substr(0, 100);
    EXPECT_EQ(Xmp(xmpOf(data, raw)).value("v", "b"), "it's \"<");
    for (const std::string unfinished : {"<!-- '", "<![CDATA[ '", "<!--", "<"})
        EXPECT_FALSE(Xmp(unfinished).has("u", "Data"));
}

TEST(Xmp, PacketMarksAroundItMeanNothing) {
    const std::string data = xmpOf("xmlns:a='u' a:Data='1'");
    const std::string id = " id='W5M0MpCehiHzreSzNTczkc9d'?>";
    const std::string padding = std::string(4000, ' ') + "<?xpacket end='w'?>";
    for (const std::string& before :
         {"<?xpacket begin='\xef\xbb\xbf'" + id, "<?xpacket begin='\xff\xfe'" + id,
          "<?xpacket begin=''" + id + "\n<?xml version='1.0' encoding='UTF-8'?>\n",
          std::string("\xef\xbb\xbf\n <?xml version='1.0'?>"), std::string(1, '\0'),
          "<?xpacket begin=\"it's\"" + id + "<!-- <b>'</b> -->"}) {
        EXPECT_EQ(Xmp(before + data + padding).value("u", "Data"), "1") << before;
        EXPECT_FALSE(Xmp(before).has("u", "Data"));
    }
    EXPECT_FALSE(Xmp("<?xpacket begin=''" + data).has("u", "Data")) << "no end";
}

TEST(Xmp, DocumentTypesAndDepthAreRefused) {
    EXPECT_FALSE(Xmp("<!DOCTYPE a [<!ENTITY b 'c'>]><a xmlns:s='u' s:v='&b;'/>").has("u", "v"));
    std::string deep;
    for (int i = 0; i < 200000; ++i)
        deep += "<a>";
    EXPECT_FALSE(Xmp(deep + "<b xmlns='u'>1</b>").has("u", "b"));
    EXPECT_TRUE(Xmp("<a xmlns:s='u' s:v='1'><broken").has("u", "v")) << "what precedes a fault";
}

TEST(Xmp, Base64SkipsBlanksAndReferences) {
    EXPECT_EQ(decodeBase64("TWFu"), "Man");
    EXPECT_EQ(decodeBase64("TW&#xA;F\nu TQ=="), "ManM");
    EXPECT_EQ(decodeBase64("TW&"), "M");
    EXPECT_EQ(decodeBase64(""), "");
    for (const std::string& text :
         {std::string("a"), std::string("ab"), std::string("\0\xff\1", 3)})
        EXPECT_EQ(decodeBase64(toBase64(text)), text);
}

} // namespace
} // namespace altiro3D
