#include "altiro3D/image_io.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/error.hpp"
#include "base/checks.hpp"
#include "image/exif.hpp"
#include "image/heif_file.hpp"
#include "image/image_header.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/heif_files.hpp"
#include "support/photo_files.hpp"
#include "support/picture_files.hpp"
#include "support/pixels.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <zlib.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

// A picture without fine detail, so that lossy formats keep it recognisable.
cv::Mat smoothPicture(cv::Size size) {
    cv::Mat picture;
    cv::resize(randomPicture({4, 3}, CV_8UC3, 21), picture, size, 0, 0, cv::INTER_CUBIC);
    return picture;
}

const std::string kPngSignature("\x89PNG\r\n\x1a\n", 8);

std::string pngHeader(std::uint32_t columns, std::uint32_t rows) {
    return kPngSignature +
           pngChunk("IHDR", bigEndian(columns) + bigEndian(rows) + std::string("\x08\2\0\0\0", 5));
}

// The smallest EXIF block: one directory with the orientation.
std::string exifBlock(unsigned orientation, bool little) {
    const auto number = little ? littleEndian : bigEndian;
    return std::string(little ? "II*\0" : "MM\0*", 4) + number(8, 4) + number(1, 2) +
           number(0x112, 2) + number(3, 2) + number(1, 4) + number(orientation, 2) +
           std::string(2, '\0') + number(0, 4);
}

const std::string kExifPrefix("Exif\0\0", 6);

std::string jpegWithExif(const cv::Mat& picture, unsigned orientation, bool little) {
    const std::string body = kExifPrefix + exifBlock(orientation, little);
    return withSegments(encoded(".jpg", picture), jpegSegment(0xe1, body));
}

// A number of a WebP chunk.
std::string threeBytes(int value) {
    return littleEndian(static_cast<unsigned>(value), 3);
}

std::string webPWithExif(const cv::Mat& picture, unsigned orientation) {
    const std::string simple = encoded(".webp", picture); // lossless by default
    const std::string exif = exifBlock(orientation, true);
    const std::string body = "WEBPVP8X" + littleEndian(10) + std::string("\x08\0\0\0", 4) +
                             threeBytes(picture.cols - 1) + threeBytes(picture.rows - 1) +
                             simple.substr(12) + "EXIF" + littleEndian(exif.size()) + exif;
    return "RIFF" + littleEndian(body.size()) + body;
}

// ImageMagick's text chunk, packed or not. @param block of EXIF, with its prefix
std::string rawProfileChunk(const std::string& block, bool packed) {
    std::string text = "\nexif\n      " + std::to_string(block.size()) + "\n";
    for (const char c : block) {
        constexpr char kDigits[] = "0123456789abcdef";
        text += kDigits[static_cast<unsigned char>(c) >> 4];
        text += kDigits[static_cast<unsigned char>(c) & 15];
    }
    const std::string keyword("Raw profile type exif\0", 22);
    if (!packed) return pngChunk("tEXt", keyword + text);
    return pngChunk("zTXt", keyword + std::string(1, '\0') + deflated(text));
}

std::string pngWithRawProfile(const cv::Mat& picture, unsigned orientation, bool packed) {
    const std::string block = kExifPrefix + exifBlock(orientation, false);
    const std::string date = pngChunk("tEXt", std::string("date:create\0002026", 16)); // other text
    return withPngChunks(encoded(".png", picture), date + rawProfileChunk(block, packed) + date);
}

// An uncompressed TIFF of 8-bit RGB in one strip.
std::string tiff(cv::Size size, const std::string& data) {
    const auto columns = static_cast<std::uint64_t>(size.width);
    const auto rows = static_cast<std::uint64_t>(size.height);
    const std::array<std::uint64_t, 3> entries[] = {
        {256, 4, columns}, {257, 4, rows}, {258, 3, 8},    {259, 3, 1},           {262, 3, 2},
        {273, 4, 8},       {277, 3, 3},    {278, 4, rows}, {279, 4, data.size()}, {284, 3, 1}};
    const std::string padding(data.size() % 2, '\0');
    std::string file = std::string("II*\0", 4) + littleEndian(8 + data.size() + padding.size()) +
                       data + padding + littleEndian(std::size(entries), 2);
    for (const auto& [tag, type, value] : entries)
        file +=
            littleEndian(tag, 2) + littleEndian(type, 2) + littleEndian(1) + littleEndian(value);
    return file + littleEndian(0);
}

// The upright picture by the EXIF standard's words on row 0 and column 0.
cv::Mat turned(const cv::Mat& stored, int orientation) {
    cv::Mat result = orientation >= 5 ? cv::Mat(stored.t()) : stored.clone();
    const bool fromRight =
        orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7;
    const bool fromBelow =
        orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8;
    if (fromRight) cv::flip(result, result, 1);
    if (fromBelow) cv::flip(result, result, 0);
    return result;
}

class ImageIo : public FileTest {
  protected:
    fs::path file(const std::string& name, const std::string& contents) const {
        spill(directory / name, contents);
        return directory / name;
    }
    std::string problemOf(const std::string& name, const std::string& contents) const {
        const fs::path path = file(name, contents);
        return test::problemOf(path, [&] { readImage(path); });
    }
};

// ------------------------------------------------------------------------------------ reading

TEST_F(ImageIo, APhotoFileIsReadOnceOrComesFromMemory) {
    const cv::Mat picture = randomPhoto({9, 7});
    const fs::path path = directory / "a.png";
    writeImage(path, picture, ImageMark::Native);
    const PhotoFile file(path);
    EXPECT_TRUE(isMarkedNative(file)); // looks at its start
    EXPECT_TRUE(samePicture(readPhoto(file), picture));
    const PhotoFile memory(file.bytes(), "b.png");
    fs::remove(path);
    for (const PhotoFile& kept : {file, memory}) {
        EXPECT_TRUE(isMarkedNative(kept));
        EXPECT_TRUE(samePicture(readPhoto(kept), picture));
        EXPECT_EQ(kept.start(4), "\x89PNG");
    }
    EXPECT_EQ(errorOf([&] { return readPhoto(PhotoFile("cut", "c.png")); }).find("c.png: "), 0U);
    EXPECT_FALSE(isMarkedNative(path)); // removed
}

TEST_F(ImageIo, AnEncodedPictureIsTheFileThatWouldBeWritten) {
    for (const ImageMark mark : {ImageMark::None, ImageMark::Native}) {
        const cv::Mat picture = randomPhoto({31, 17});
        writeImage(directory / "a.png", picture, mark);
        const std::vector<unsigned char> bytes = encodePicture(picture, mark);
        EXPECT_EQ(std::string(bytes.begin(), bytes.end()), slurp(directory / "a.png"));
    }
    EXPECT_ANY_THROW(static_cast<void>(encodePicture(cv::Mat())));
    const cv::Mat picture = randomPhoto({31, 17});
    for (const char* name : {"b.png", "b.tif", "b.jpg", "b.ppm"}) {
        writeImage(directory / name, picture);
        const std::vector<unsigned char> bytes = encodePicture(picture, name);
        EXPECT_EQ(std::string(bytes.begin(), bytes.end()), slurp(directory / name)) << name;
    }
    EXPECT_EQ(errorOf([&] { encodePicture(picture, "b.gif"); }).find("b.gif: "), 0U);
}

TEST_F(ImageIo, LosslessFormatsReadBackWhatWasWritten) {
    for (const char* name : {"a.png", "a.tif", "a.tiff", "a.pnm", "A.PNG"}) {
        for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3}) {
            for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 1), cv::Size(13, 29)}) {
                const cv::Mat whole = randomPicture({40, 40}, type, 3, 0, 65536);
                const cv::Mat picture = whole(cv::Rect(cv::Point(5, 3), size));
                writeImage(directory / name, picture);
                cv::Mat expected = picture;
                if (picture.channels() == 1) cv::cvtColor(picture, expected, cv::COLOR_GRAY2BGR);
                EXPECT_TRUE(samePicture(readImage(directory / name), expected)) << name << size;
            }
        }
    }
    for (const char* name : {"a.webp", "a.bmp", "a.dib", "a.ppm"}) {
        const cv::Mat picture = randomPicture({13, 29}, CV_8UC3, 3);
        writeImage(directory / name, picture);
        EXPECT_TRUE(samePicture(readImage(directory / name), picture)) << name;
    }
    ALTIRO3D_REQUIRE_WRITER(".jp2");
    const cv::Mat large = smoothPicture({131, 67}); // JPEG 2000 needs some size and cuts off noise
    writeImage(directory / "a.jp2", large);
    EXPECT_TRUE(samePicture(readImage(directory / "a.jp2"), large));
}

TEST_F(ImageIo, SixteenBitsBecomeEightByDividingBy257) {
    const cv::Mat ramp = pictureOf<ushort>({256, 256}, [](int x, int y) { return 256 * y + x; });
    const cv::Mat expected = pictureOf<cv::Vec3b>({256, 256}, [](int x, int y) {
        return cv::Vec3b::all(static_cast<uchar>(std::lround((256 * y + x) / 257.0)));
    });
    writeImage(directory / "ramp.png", ramp);
    EXPECT_TRUE(samePicture(readPhoto(directory / "ramp.png"), expected));
    writeImage(directory / "a.bmp", cv::Mat(8, 8, CV_16UC3, cv::Scalar(128, 129, 65535)));
    EXPECT_TRUE(
        samePicture(readImage(directory / "a.bmp"), cv::Mat(8, 8, CV_8UC3, cv::Scalar(0, 1, 255))));
}

TEST_F(ImageIo, FloatPicturesKeepTheirValuesAndAreClampedAsPhotos) {
    const cv::Mat picture =
        (cv::Mat_<cv::Vec3f>(1, 4) << cv::Vec3f::all(-1), cv::Vec3f::all(0.5F), cv::Vec3f::all(3),
         cv::Vec3f::all(std::numeric_limits<float>::quiet_NaN()));
    const fs::path path = file("f.pfm", encoded(".pfm", picture));
    EXPECT_TRUE(samePicture(readImage(path), picture));
    Notes notes;
    const cv::Mat photo = readPhoto(path, &notes);
    const cv::Mat clamped = (cv::Mat_<cv::Vec3b>(1, 4) << cv::Vec3b::all(0), cv::Vec3b::all(128),
                             cv::Vec3b::all(255), cv::Vec3b::all(0));
    EXPECT_TRUE(samePicture(photo, clamped));
    EXPECT_EQ(notes.size(), 2U); // how floats are understood, and that some are beyond white
}

TEST_F(ImageIo, TransparencyIsShownOverBlack) {
    const cv::Mat picture =
        (cv::Mat_<cv::Vec4b>(1, 4) << cv::Vec4b(10, 20, 30, 255), cv::Vec4b(10, 20, 30, 0),
         cv::Vec4b(200, 100, 50, 128), cv::Vec4b(255, 255, 255, 1));
    const cv::Mat expected = (cv::Mat_<cv::Vec3b>(1, 4) << cv::Vec3b(10, 20, 30), cv::Vec3b(),
                              cv::Vec3b(100, 50, 25), // 100.4, 50.2, 25.1
                              cv::Vec3b(1, 1, 1));
    EXPECT_TRUE(samePicture(readImage(file("a.png", encoded(".png", picture))), expected));
    EXPECT_TRUE(samePicture(readImage(file("a.webp", encoded(".webp", picture))), expected));

    const cv::Mat deep(1, 1, CV_16UC4, cv::Scalar(51400, 25700, 65535, 32896));
    const cv::Mat deepExpected(1, 1, CV_16UC3, cv::Scalar(25801, 12900, 32896));
    EXPECT_TRUE(samePicture(readImage(file("d.png", encoded(".png", deep))), deepExpected));
}

TEST_F(ImageIo, ThePngColourThatStandsForTransparentBecomesBlack) {
    for (const int type : {CV_8UC1, CV_16UC1, CV_8UC3, CV_16UC3}) {
        cv::Mat picture(1, 3, type, cv::Scalar(10, 20, 30));
        picture.col(1).setTo(cv::Scalar(40, 50, 60));
        picture.col(2).setTo(cv::Scalar(40, 50, 61)); // differs in red alone
        const bool isGrey = picture.channels() == 1;
        const std::string key =
            isGrey ? bigEndian(40, 2) : bigEndian(60, 2) + bigEndian(50, 2) + bigEndian(40, 2);
        const fs::path path =
            file("key.png", withPngChunks(encoded(".png", picture), pngChunk("tRNS", key)));
        cv::Mat expected;
        if (isGrey) {
            cv::cvtColor(picture, expected, cv::COLOR_GRAY2BGR);
            expected.colRange(1, 3).setTo(cv::Scalar::all(0));
        } else {
            expected = picture.clone();
            expected.col(1).setTo(cv::Scalar::all(0));
        }
        EXPECT_TRUE(samePicture(readImage(path), expected)) << cv::typeToString(type);
    }
    // One bit: the key 1 is white, which OpenCV spreads to 255.
    const cv::Mat bits = (cv::Mat_<uchar>(1, 2) << 0, 255);
    const std::string png = encoded(".png", bits, {cv::IMWRITE_PNG_BILEVEL, 1});
    const fs::path path = file("bits.png", withPngChunks(png, pngChunk("tRNS", bigEndian(1, 2))));
    EXPECT_EQ(cv::norm(readImage(path), cv::NORM_INF), 0);
}

TEST_F(ImageIo, TheUnusedFourthByteOfABitmapHidesNothing) {
    std::string bmp = encoded(".bmp", cv::Mat(2, 2, CV_8UC4, cv::Scalar(10, 20, 30, 0)));
    const cv::Mat expected(2, 2, CV_8UC3, cv::Scalar(10, 20, 30));
    // A plain 40-byte header: 32 bits, no masks, no compression.
    bmp = "BM" + littleEndian(54 + 16) + littleEndian(0) + littleEndian(54) + littleEndian(40) +
          littleEndian(2) + littleEndian(2) + littleEndian(1, 2) + littleEndian(32, 2) +
          std::string(24, '\0');
    for (int i = 0; i < 4; ++i)
        bmp += std::string("\x0a\x14\x1e\0", 4);
    EXPECT_TRUE(samePicture(readImage(file("a.bmp", bmp)), expected));
}

TEST_F(ImageIo, TheFocalLengthIsThatOfTheExif) {
    for (const bool little : {false, true}) {
        const auto number = little ? littleEndian : bigEndian;
        const auto entry = [&](unsigned tag, unsigned type, unsigned value, unsigned size) {
            return number(tag, 2) + number(type, 2) + number(1, 4) + number(value, size) +
                   std::string(4 - size, '\0');
        };
        const std::string block = std::string(little ? "II*\0" : "MM\0*", 4) + number(8, 4) +
                                  number(1, 2) + entry(0x8769, 4, 26, 4) + number(0, 4) +
                                  number(1, 2) + entry(0xA405, 3, 28, 2) + number(0, 4);
        EXPECT_EQ(focalLengthOf(PhotoFile(block, "a.tif")), 28);
        const std::string body = kExifPrefix + block;
        for (const std::string& exif : {bigEndian(0, 4) + block, bigEndian(6, 4) + body}) {
            const std::string heic =
                heifFile("heic", {hevcColours(1), {2, "Exif", exif, {}, ""}}, {{"cdsc", 2, {1}}});
            EXPECT_EQ(focalLengthOf(PhotoFile(heic, "a.heic")), hasHeif() ? 28 : 0);
        }
        const std::string jpeg = withSegments(
            encoded(".jpg", cv::Mat(8, 8, CV_8UC3, cv::Scalar(1))), jpegSegment(0xe1, body));
        EXPECT_EQ(focalLengthOf(PhotoFile(jpeg, "a.jpg")), 28);
    }
    const std::string none = encoded(".jpg", cv::Mat(8, 8, CV_8UC3, cv::Scalar(1)));
    EXPECT_EQ(focalLengthOf(PhotoFile(none, "a.jpg")), 0);
}

TEST_F(ImageIo, TheAuthorIsThatOfTheExif) {
    const std::string exif = std::string("II*\0", 4) + littleEndian(8, 4) + littleEndian(1, 2) +
                             littleEndian(0x13B, 2) + littleEndian(2, 2) + littleEndian(4, 4) +
                             std::string("Ada\0", 4) + littleEndian(0, 4);
    EXPECT_EQ(creditOf(PhotoFile(exif, "a.tif")), "Ada");
    const std::string heic = heifFile(
        "heic", {hevcColours(1), {2, "Exif", bigEndian(0, 4) + exif, {}, ""}}, {{"cdsc", 2, {1}}});
    EXPECT_EQ(creditOf(PhotoFile(heic, "a.heic")), hasHeif() ? "Ada" : "");
}

TEST_F(ImageIo, OrientationIsAppliedExactlyOnce) {
    const cv::Mat picture = smoothPicture({150, 137});
    const cv::Mat fromJpeg = decoded(encoded(".jpg", picture));
    for (unsigned orientation = 1; orientation <= 8; ++orientation) {
        const cv::Mat expected = turned(picture, static_cast<int>(orientation));
        const cv::Mat expectedJpeg = turned(fromJpeg, static_cast<int>(orientation));
        for (const bool little : {false, true}) {
            const fs::path jpeg = file("o.jpg", jpegWithExif(picture, orientation, little));
            EXPECT_TRUE(samePicture(readImage(jpeg), expectedJpeg)) << orientation;
            EXPECT_TRUE(samePicture(readPhoto(jpeg), expectedJpeg)) << orientation;
            EXPECT_EQ(readDepthImage(jpeg).size(), expectedJpeg.size()) << orientation;
            const fs::path png =
                file("o.png", withPngChunks(encoded(".png", picture),
                                            pngChunk("eXIf", exifBlock(orientation, little))));
            EXPECT_TRUE(samePicture(readImage(png), expected)) << orientation;
            const fs::path text = file("t.png", pngWithRawProfile(picture, orientation, little));
            EXPECT_TRUE(samePicture(readImage(text), expected)) << orientation;
        }
        const fs::path webp = file("o.webp", webPWithExif(picture, orientation));
        EXPECT_TRUE(samePicture(readImage(webp), expected)) << orientation;
    }
    // the chunk takes precedence over text
    const std::string chunk = pngChunk("eXIf", exifBlock(6, true));
    const std::string text = rawProfileChunk(kExifPrefix + exifBlock(3, false), false);
    for (const std::string& both : {chunk + text, text + chunk}) {
        const fs::path png = file("p.png", withPngChunks(encoded(".png", picture), both));
        EXPECT_TRUE(samePicture(readImage(png), turned(picture, 6)));
    }
}

// It is a SHORT, and some programs write other whole numbers.
TEST_F(ImageIo, OrientationsOfAnyWholeNumberAreRead) {
    const cv::Mat picture = smoothPicture({9, 7});
    for (const bool little : {false, true}) {
        const auto number = little ? littleEndian : bigEndian;
        for (const auto& [type, bytes] : std::vector<std::pair<unsigned, unsigned>>{
                 {1, 1}, {3, 2}, {4, 4}, {6, 1}, {8, 2}, {9, 4}, {2, 1}, {5, 4}, {7, 1}, {99, 2}}) {
            std::string block = exifBlock(0, little);
            block.replace(12, 2, number(type, 2)).replace(18, bytes, number(6, bytes));
            const fs::path path =
                file("o.png", withPngChunks(encoded(".png", picture), pngChunk("eXIf", block)));
            const bool isWhole = type != 2 && type != 5 && type != 7 && type != 99;
            EXPECT_TRUE(samePicture(readImage(path), turned(picture, isWhole ? 6 : 1))) << type;
        }
        std::string several = exifBlock(6, little); // count
        several.replace(14, 4, number(2, 4));
        EXPECT_EQ(exifOrientation(several), 1);
        EXPECT_EQ(exifOrientation("XX" + exifBlock(6, little).substr(2)), 1);
    }
}

TEST_F(ImageIo, DamagedExifIsIgnored) {
    const cv::Mat picture = smoothPicture({9, 7});
    std::vector<std::string> blocks{exifBlock(0, true), exifBlock(9, true), exifBlock(65535, true)};
    const std::string whole = exifBlock(6, false);
    for (std::size_t size = 0; size < whole.size() - 6; ++size)
        blocks.push_back(whole.substr(0, size));
    for (const std::string& block : blocks) {
        const fs::path path =
            file("o.png", withPngChunks(encoded(".png", picture), pngChunk("eXIf", block)));
        EXPECT_TRUE(samePicture(readImage(path), picture)) << block.size();
    }
}

TEST_F(ImageIo, DepthImagesKeepTheirNumbers) {
    const cv::Mat deep = randomPicture({17, 11}, CV_16UC1, 5, 0, 65536);
    cv::Mat expected;
    deep.convertTo(expected, CV_32F);
    for (const char* extension : {".png", ".pgm", ".tif"}) {
        const fs::path path = file(std::string("d") + extension, encoded(extension, deep));
        EXPECT_TRUE(samePicture(readDepthImage(path), expected)) << extension;
    }
    const float infinity = std::numeric_limits<float>::infinity();
    const cv::Mat numbers = (cv::Mat_<float>(2, 2) << -1.5f, 1e-30f, infinity, 77777);
    for (const char* extension : {".pfm", ".tif", ".exr"}) {
        if (!cv::haveImageWriter(extension)) continue;
        const fs::path path = file(std::string("f") + extension, encoded(extension, numbers));
        EXPECT_TRUE(samePicture(readDepthImage(path), numbers)) << extension;
    }
}

TEST_F(ImageIo, DepthSamplesKeepTheirTypeAndAreTheNumbersOfTheDepthImage) {
    for (const int type : {CV_8UC1, CV_16UC1, CV_8UC3, CV_16UC3}) {
        cv::Mat picture = randomPicture({17, 11}, type, 5, 0, 65536);
        const int colourful = picture.channels() == 3 ? CV_32FC1 : type;
        const fs::path path = file("d.png", encoded(".png", picture));
        EXPECT_EQ(readDepthSamples(path).type(), colourful);
        cv::Mat samples;
        readDepthSamples(path).convertTo(samples, CV_32F);
        EXPECT_TRUE(samePicture(samples, readDepthImage(path))) << cv::typeToString(type);
        // three channels that agree are one
        cv::Mat grey;
        cv::extractChannel(picture, grey, 0);
        if (picture.channels() == 3) cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
        EXPECT_TRUE(samePicture(readDepthSamples(file("g.png", encoded(".png", picture))), grey))
            << cv::typeToString(type);
    }
    const cv::Mat numbers = (cv::Mat_<float>(1, 2) << -1.5f, 77777);
    EXPECT_TRUE(samePicture(readDepthSamples(file("f.pfm", encoded(".pfm", numbers))), numbers));
}

TEST_F(ImageIo, ColouredDepthImagesGiveTheirGreyValue) {
    cv::Mat picture(1, 2, CV_8UC3);
    picture.at<cv::Vec3b>(0, 0) = cv::Vec3b(77, 77, 77);
    picture.at<cv::Vec3b>(0, 1) = cv::Vec3b(10, 100, 200);
    Notes notes;
    const cv::Mat depth = readDepthImage(file("c.png", encoded(".png", picture)), &notes);
    EXPECT_TRUE(holds(only(notes).text, "has colours, and depth has none"));
    EXPECT_EQ(depth.at<float>(0, 0), 77);
    EXPECT_FLOAT_EQ(depth.at<float>(0, 1), 0.114f * 10 + 0.587f * 100 + 0.299f * 200);
}

TEST_F(ImageIo, OnlyColoursThatShowAreNotedInDepthImages) {
    const auto notesOf = [&](const cv::Mat& picture, const char* extension) {
        Notes notes;
        readDepthSamples(file(std::string("d") + extension, encoded(extension, picture)), &notes);
        return notes.size();
    };
    cv::Mat grey(40, 40, CV_8UC3, cv::Scalar::all(100));
    EXPECT_EQ(notesOf(grey, ".png"), 0U);
    EXPECT_EQ(notesOf(grey, ".jpg"), 0U);
    cv::Mat faint = grey + cv::Scalar(15, 0, 0); // as of a careless converter
    EXPECT_EQ(notesOf(faint, ".png"), 0U);
    EXPECT_EQ(notesOf(grey + cv::Scalar(16, 0, 0), ".png"), 1U);
    cv::Mat mark = grey.clone();
    mark(cv::Rect(0, 0, 8, 4)).setTo(cv::Scalar(0, 0, 255)); // 2 %
    EXPECT_EQ(notesOf(mark, ".png"), 0U);
    mark(cv::Rect(0, 0, 8, 5)).setTo(cv::Scalar(0, 0, 255));
    EXPECT_EQ(notesOf(mark, ".png"), 1U);
    cv::Mat wide;
    grey.convertTo(wide, CV_16U, 257);
    EXPECT_EQ(notesOf(wide, ".png"), 0U);
    EXPECT_EQ(notesOf(wide + cv::Scalar(5000, 0, 0), ".png"), 1U);
    cv::Mat floats;
    cv::Mat(grey + cv::Scalar(6, 0, 0))
        .convertTo(floats, CV_32F, 1000); // below a sixteenth of the most
    EXPECT_FALSE(hasColours(floats));
    cv::Mat(grey - cv::Scalar(0, 8, 0)).convertTo(floats, CV_32F, 1e-6);
    EXPECT_TRUE(hasColours(floats));
    EXPECT_FALSE(hasColours(cv::Mat(3, 3, CV_32FC3, cv::Scalar::all(0))));
    EXPECT_FALSE(hasColours(cv::Mat(3, 3, CV_32FC3, cv::Scalar::all(NAN))));
    EXPECT_FALSE(hasColours(cv::Mat(3, 3, CV_64FC3, cv::Scalar(1, HUGE_VAL, 2))));
    EXPECT_THROW(hasColours(cv::Mat(3, 3, CV_8UC1)), Error);
    EXPECT_THROW(hasColours(cv::Mat()), Error);
    cv::Mat tall(3000, 4, CV_8UC3, cv::Scalar(10, 20, 200)); // not each row is looked at
    EXPECT_EQ(notesOf(tall, ".png"), 1U);
}

TEST_F(ImageIo, PnmSamplesAreSpreadForPhotosAndKeptForDepth) {
    const fs::path path = file("m.pgm", "P5\n# made by hand\n2 1\n1023\n" + bigEndian(0x03ff0200));
    EXPECT_EQ(readImage(path).at<cv::Vec3w>(0, 0)[0], 65535);
    EXPECT_EQ(readPhoto(path).at<cv::Vec3b>(0, 1)[0], 128); // 512 / 1023 * 255 = 127.6
    EXPECT_EQ(readDepthImage(path).at<float>(0, 0), 1023);
    for (const unsigned largest : {1U, 15U, 31U, 100U, 200U, 255U, 256U, 1023U, 65535U}) {
        const std::string size = " 3 1 " + std::to_string(largest) + "\n";
        const unsigned half = largest / 2;
        const auto expected = static_cast<int>(std::lround(255.0 * half / largest));
        for (const bool isText : {false, true}) {
            for (const unsigned channels : {1U, 3U}) {
                std::string samples;
                for (const unsigned sample : {0U, half, largest}) {
                    for (unsigned c = 0; c < channels; ++c)
                        samples += isText ? std::to_string(sample) + " "
                                          : bigEndian(sample, largest > 255 ? 2 : 1);
                }
                const int kind = (isText ? 2 : 5) + (channels == 3 ? 1 : 0);
                const fs::path all = file("a.pnm", "P" + std::to_string(kind) + size + samples);
                const cv::Mat photo = readPhoto(all);
                EXPECT_EQ(photo.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 0)) << kind << size;
                // 1: OpenCV rounds the numbers of texts down
                EXPECT_NEAR(photo.at<cv::Vec3b>(0, 1)[0], expected, 1) << kind << size;
                EXPECT_EQ(photo.at<cv::Vec3b>(0, 2), cv::Vec3b(255, 255, 255)) << kind << size;
                if (!isText) {
                    EXPECT_EQ(readDepthImage(all).at<float>(0, 1), half) << kind << size;
                }
            }
        }
    }
    EXPECT_EQ(readPhoto(file("t.ppm", "P3 1 1 255 10 20 30")).at<cv::Vec3b>(0, 0),
              cv::Vec3b(30, 20, 10));
}

// 16 bits as 12: samples are stored as differences from half of the range.
TEST_F(ImageIo, SamplesOfJpeg2000AreSpreadForPhotosAndKeptForDepth) {
    ALTIRO3D_REQUIRE_WRITER(".jp2");
    std::string bytes =
        encoded(".jp2", cv::Mat(64, 48, CV_16UC1, cv::Scalar(1435 + (1 << 15) - (1 << 11))),
                {cv::IMWRITE_JPEG2000_COMPRESSION_X1000, 1000});
    bytes.erase(0, bytes.find("\xff\x4f\xff\x51"));
    ASSERT_EQ(bytes[42], 15);
    bytes[42] = 11;
    EXPECT_EQ(readPhoto(file("a.j2k", bytes)).at<cv::Vec3b>(9, 9), cv::Vec3b(89, 89, 89));
    EXPECT_EQ(readDepthImage(directory / "a.j2k").at<float>(9, 9), 1435);
    bytes[42] = 3;
    EXPECT_EQ(problemOf("b.j2k", bytes),
              "4-bit JPEG 2000 pictures are not read, expected an ordinary JPEG 2000 file; convert "
              "it first");
}

// ----------------------------------------------------------------------------- what is refused

TEST_F(ImageIo, HugePicturesAreRefusedFromTheirHeader) {
    const std::string limits = " px, expected at most 400 megapixels and sides of at most 65500 px";
    EXPECT_EQ(problemOf("bomb.png", pngHeader(60000, 60000)), "has 60000 x 60000" + limits);
    EXPECT_EQ(problemOf("long.png", pngHeader(70000, 1)), "has 70000 x 1" + limits);
    const std::vector<std::pair<std::string, std::string>> bombs = {
        {"b.tif", tiff({60000, 60000}, "")},
        {"b.ppm", "P6 60000 60000 255\n"},
        {"b.pfm", "PF\n60000 60000\n-1\n"},
        {"b.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n"},
        {"b.bmp", "BM" + std::string(12, '\0') + littleEndian(40) + littleEndian(60000) +
                      littleEndian(0u - 60000u) + std::string(28, '\0')},
        {"b.jp2", std::string("\xff\x4f\xff\x51\0\x2f\0\0", 8) + bigEndian(60000) +
                      bigEndian(60000) + std::string(26, '\0') + '\7' + std::string(13, '\0')},
        {"b.jpg", std::string("\xff\xd8\xff\xc0\0\x11\x08", 7) + bigEndian(60000, 2) +
                      bigEndian(60000, 2) + std::string("\3\1\x11\0\2\x11\0\3\x11\0\xff\xd9", 12)},
        {"b.webp", "RIFF" + littleEndian(30) + "WEBPVP8X" + littleEndian(10) +
                       std::string(4, '\0') + littleEndian(59999, 3) + littleEndian(59999, 3)}};
    for (const auto& [name, contents] : bombs)
        EXPECT_TRUE(startsWith(problemOf(name, contents), "has 60000 x 60000 px")) << name;
    EXPECT_EQ(codeOf([&] { readImage(directory / "bomb.png"); }), ErrorCode::TooLarge);
}

TEST_F(ImageIo, TurnedAndMirroredHdrIsRefused) {
    for (const char* size : {"+Y 8 +X 8", "-Y 8 -X 8", "+X 8 -Y 8"}) {
        const std::string problem =
            problemOf("turned.hdr", std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n") + size +
                                        "\n" + std::string(256, '\x20'));
        EXPECT_TRUE(holds(problem, "turned or mirrored HDR")) << size << problem;
    }
}

// What says another size behind the header that decoders go by, or before it where they do not
// look.
TEST_F(ImageIo, NoSecondHeaderHidesTheSizeOfAPicture) {
    const std::string small = pngHeader(1, 1).substr(kPngSignature.size());
    const std::string vp8x = "VP8X" + littleEndian(10) + std::string(4, '\0');
    std::string wide = tiff({60000, 60000}, "");
    const std::string planes = littleEndian(284, 2) + littleEndian(3, 2);
    ASSERT_TRUE(holds(wide, planes));
    wide.replace(wide.find(planes), 2, littleEndian(256, 2)); // has the value 1
    const std::vector<std::pair<std::string, std::string>> bombs = {
        {"b.png", pngHeader(60000, 60000) + small + pngChunk("IEND", "")},
        {"b.webp", "RIFF" + littleEndian(48) + "WEBP" + vp8x + littleEndian(59999, 3) +
                       littleEndian(59999, 3) + vp8x + std::string(6, '\0')},
        {"b.tif", wide}};
    for (const auto& [name, contents] : bombs)
        EXPECT_TRUE(startsWith(problemOf(name, contents), "has 60000 x 60000 px")) << name;

    const cv::Mat picture = randomPicture({5, 3}, CV_8UC3, 4);
    cv::Mat rgb;
    cv::cvtColor(picture, rgb, cv::COLOR_BGR2RGB);
    std::string readable =
        tiff(rgb.size(), {reinterpret_cast<const char*>(rgb.data), 3 * rgb.total()});
    readable.replace(readable.find(planes), 2, littleEndian(256, 2));
    EXPECT_TRUE(samePicture(readImage(file("r.tif", readable)), picture));
}

TEST_F(ImageIo, TheSizeOfAJpeg2000IsThatOfItsCodestreamsBox) {
    ALTIRO3D_REQUIRE_WRITER(".jp2");
    const cv::Mat picture = randomPicture({200, 100}, CV_8UC3, 4);
    const std::string start("\xff\x4f\xff\x51", 4);
    const std::string decoy =
        start + std::string("\0\x2f\0\0", 4) + bigEndian(1) + bigEndian(1) + std::string(40, '\0');
    std::string bytes = encoded(".jp2", picture, {cv::IMWRITE_JPEG2000_COMPRESSION_X1000, 1000});
    const std::size_t box = bytes.find("jp2c") - 4;
    ASSERT_LT(box, bytes.size());
    bytes.insert(box, bigEndian(decoy.size() + 8) + "free" + decoy);
    EXPECT_EQ(readImageHeader(bytes, ".jp2").columns, 200u);
    EXPECT_TRUE(samePicture(readImage(file("a.jp2", bytes)), picture));
    const std::string codestream = bytes.substr(bytes.rfind(start));
    EXPECT_EQ(readImageHeader(codestream, ".j2k").rows, 100u);
    // A box with a long size says the same.
    bytes.replace(box, 4, bigEndian(1));
    bytes.insert(box + 8, bigEndian(0) + bigEndian(decoy.size() + 16));
    EXPECT_EQ(readImageHeader(bytes, ".jp2").columns, 200u);
    bytes.replace(bytes.rfind(start) + 8, 8, bigEndian(60000) + bigEndian(60000));
    EXPECT_TRUE(startsWith(problemOf("b.jp2", bytes), "has 60000 x 60000 px"));
    // Boxes that reach beyond the file, or nowhere, lead to no codestream.
    for (const std::uint32_t size : {0u, 7u, 0xffffffffu}) {
        bytes.replace(box, 4, bigEndian(size));
        EXPECT_EQ(readImageHeader(bytes, ".jp2").columns, 0u) << size;
    }
}

TEST_F(ImageIo, FormatsWithoutAReaderAreRefusedByName) {
    const std::string zeros(200, '\0');
    const std::vector<std::pair<std::string, std::string>> formats = {
        {"GIF89a" + zeros, "GIF"},
        {"\xff\x0a" + zeros, "JPEG XL"},
        {std::string("\0\0\0\x0cJXL \r\n\x87\n", 12) + zeros, "JPEG XL"},
        {"8BPS" + zeros, "PSD"},
        {"%PDF-1.7" + zeros, "PDF"},
        {"<?xml version=\"1.0\"?>\n<svg width=\"3\"></svg>", "SVG"},
        {"\x93NUMPY" + zeros, "NumPy"}};
    for (const auto& [contents, name] : formats) {
        EXPECT_EQ(problemOf("x.bin", contents), name + " pictures are not read, expected " +
                                                    readableFormats() + "; convert it first");
    }
    const std::pair<std::string, std::string> raws[] = {
        {"cr3", std::string("\0\0\0\x18", 4) + "ftypcrx " + zeros},
        {"cr2", std::string("II*\0\x10\0\0\0CR\2", 11) + zeros},
        {"nef", tiff({1, 1}, "abc")},
        {"DNG", tiff({1, 1}, "abc")}};
    for (const auto& [name, contents] : raws) {
        EXPECT_EQ(problemOf("a." + (name == "DNG" ? "dng" : name), contents),
                  "is a raw picture of a camera (" + name + "), which is not read, expected " +
                      readableFormats() + "; export it from a photo program first");
    }
    EXPECT_EQ(problemOf("a.mp4", std::string("\0\0\0\x18", 4) + "ftypisom" + zeros),
              "is a video (MP4), expected a picture");
    EXPECT_EQ(problemOf("a.zip", std::string("PK\3\4", 4) + zeros),
              "is a ZIP archive, expected a picture; unpack it first");
    EXPECT_EQ(problemOf("a.jpg", "<!DOCTYPE html><html></html>"),
              "is a web page, expected a picture; download the picture itself");
    EXPECT_EQ(problemOf("a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd"),
              "XYZE HDR pictures are not read, expected an ordinary HDR file; convert it first");
}

TEST_F(ImageIo, WhatIsNoPictureIsSaidToBeNone) {
    EXPECT_EQ(problemOf("a.png", "hello\n"),
              "is not a picture that can be read (it holds text), expected " + readableFormats());
    EXPECT_TRUE(startsWith(problemOf("a.jpg", std::string("\1\2\3\4", 4)),
                           "is not a picture that can be read"));
    EXPECT_EQ(problemOf("a.png", ""), "is empty, expected a picture");
    EXPECT_EQ(errorOf([&] { readImage(directory / "none.png"); }),
              (directory / "none.png").string() + ": does not exist, expected a file");
    EXPECT_EQ(errorOf([&] { readImage(directory.path()); }),
              directory.path().string() + ": is a directory, expected a file");
}

TEST_F(ImageIo, ACutOffJpegOpensWithANoteAndOthersAreRefused) {
    const std::string whole = encoded(".jpg", smoothPicture({160, 120}));
    Notes notes;
    readImage(file("whole.jpg", whole), &notes);
    readImage(file("long.jpg", whole + "trailer"), &notes);
    EXPECT_TRUE(notes.empty());
    const cv::Mat picture =
        readImage(file("cut.jpg", whole.substr(0, whole.size() * 3 / 4)), &notes);
    EXPECT_EQ(picture.size(), cv::Size(160, 120));
    EXPECT_EQ(only(notes).code, NoteCode::CutOff);
    EXPECT_EQ(only(notes).text, "the file is cut off: its lower part is missing");
    EXPECT_EQ(cv::norm(picture.rowRange(0, 40), readImage(directory / "whole.jpg").rowRange(0, 40),
                       cv::NORM_INF),
              0);
    notes.clear();
    const std::string progressive =
        encoded(".jpg", smoothPicture({160, 120}), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
    readImage(file("cut.jpg", progressive.substr(0, progressive.size() * 3 / 4)), &notes);
    EXPECT_EQ(only(notes).code, NoteCode::CutOff);
    EXPECT_EQ(only(notes).text, "the file is cut off: its fine detail is missing");
    for (std::size_t size = progressive.size() / 2; size < progressive.size(); size += 7)
        EXPECT_EQ(readImage(file("cut.jpg", progressive.substr(0, size))).cols, 160) << size;
    EXPECT_EQ(problemOf("cut.jpg", whole.substr(0, 100)),
              "its header is damaged or cut off, expected a whole JPEG file");
    const std::string png = encoded(".png", randomPicture({40, 30}, CV_8UC3, 3));
    EXPECT_EQ(problemOf("cut.png", png.substr(0, png.size() / 2)),
              "is cut off, expected a whole PNG file");
    EXPECT_EQ(problemOf("cut.png", png.substr(0, 20)),
              "its header is damaged or cut off, expected a whole PNG file");
}

TEST_F(ImageIo, OfSeveralPagesTheFirstIsReadWithANote) {
    const cv::Mat first = randomPicture({5, 4}, CV_8UC3, 1);
    cv::imwritemulti((directory / "p.tif").string(),
                     std::vector<cv::Mat>{first, randomPicture({9, 9}, CV_8UC3, 2)});
    Notes notes;
    EXPECT_TRUE(samePicture(readImage(directory / "p.tif", &notes), first));
    EXPECT_EQ(only(notes).code, NoteCode::LeftOut);
    EXPECT_EQ(only(notes).text, "the file holds 2 pages: the first one is read");
}

// A frame of an animation: the chunks of a WebP file at a place.
std::string webPFrame(const std::string& chunks, cv::Rect area) {
    const std::string body = threeBytes(area.x / 2) + threeBytes(area.y / 2) +
                             threeBytes(area.width - 1) + threeBytes(area.height - 1) +
                             threeBytes(100) + std::string(1, '\0') + chunks;
    return "ANMF" + littleEndian(body.size()) + body;
}

std::string animatedWebP(cv::Size size, const std::string& frames) {
    const std::string body = "WEBPVP8X" + littleEndian(10) + std::string("\x12\0\0\0", 4) +
                             threeBytes(size.width - 1) + threeBytes(size.height - 1) + "ANIM" +
                             littleEndian(6) + std::string("\xff\xff\xff\xff\0\0", 6) + frames;
    return "RIFF" + littleEndian(body.size()) + body;
}

TEST_F(ImageIo, OfAnAnimatedWebPTheFirstPictureIsReadWithANote) {
    const cv::Mat first = randomPicture({8, 6}, CV_8UC3, 1);
    const cv::Mat second = randomPicture({16, 12}, CV_8UC3, 2);
    const cv::Size size(16, 12);
    const std::string last = webPFrame(encoded(".webp", second).substr(12), {{0, 0}, size});
    const std::string chunks = encoded(".webp", first).substr(12);
    Notes notes;
    const auto read = [&](const std::string& frame) {
        notes.clear();
        return readImage(file("a.webp", animatedWebP(size, frame + last)), &notes);
    };
    cv::Mat expected = cv::Mat::zeros(size, CV_8UC3);
    first.copyTo(expected(cv::Rect(4, 2, 8, 6)));
    EXPECT_TRUE(samePicture(read(webPFrame(chunks, {4, 2, 8, 6})), expected));
    EXPECT_EQ(only(notes).code, NoteCode::LeftOut);
    EXPECT_EQ(only(notes).text, "the file holds 2 frames: the first one is read");
    EXPECT_TRUE(samePicture(read(last), second));

    cv::Mat halfClear(12, 16, CV_8UC4, cv::Scalar(40, 90, 200, 255)); // lossy, with alpha
    halfClear.colRange(8, 16).setTo(cv::Scalar(40, 90, 200, 0));
    const std::string still = encoded(".webp", halfClear, {cv::IMWRITE_WEBP_QUALITY, 90});
    const std::size_t alpha = still.find("ALPH");
    ASSERT_NE(alpha, std::string::npos);
    const cv::Mat picture = read(webPFrame(still.substr(alpha), {{0, 0}, size}));
    EXPECT_LE(cv::norm(picture.at<cv::Vec3b>(6, 2), cv::Vec3b(40, 90, 200), cv::NORM_INF), 6);
    EXPECT_EQ(picture.at<cv::Vec3b>(6, 12), cv::Vec3b(0, 0, 0));

    for (const cv::Rect& wrong : {cv::Rect(10, 2, 8, 6), cv::Rect(4, 2, 8, 4)}) {
        EXPECT_EQ(problemOf("a.webp", animatedWebP(size, webPFrame(chunks, wrong))),
                  "is damaged or of an unusual kind, expected a whole WebP file");
    }
}

TEST_F(ImageIo, AnyDamageGivesAPictureOrAnError) {
    const cv::Mat picture = smoothPicture({19, 13});
    cv::RNG random(3);
    for (const char* extension :
         {".png", ".jpg", ".tif", ".webp", ".bmp", ".ppm", ".pfm", ".hdr", ".exr"}) {
        if (!cv::haveImageWriter(extension)) continue;
        cv::Mat suited = picture;
        const std::string name = extension;
        if (name == ".exr" || name == ".pfm" || name == ".hdr") picture.convertTo(suited, CV_32F);
        const std::string whole = encoded(extension, suited);
        for (int trial = 0; trial < 40; ++trial) {
            std::string bytes = whole;
            if (trial % 2 == 0) {
                bytes.resize(
                    static_cast<std::size_t>(random.uniform(0, static_cast<int>(whole.size()))));
            } else {
                for (int i = 0; i < 1 + trial / 8; ++i) {
                    const int limit = std::min(static_cast<int>(whole.size()), 300);
                    bytes[static_cast<std::size_t>(random.uniform(0, limit))] =
                        static_cast<char>(random.uniform(0, 256));
                }
            }
            const fs::path path = file("broken" + name, bytes);
            try {
                EXPECT_EQ(readPhoto(path).type(), CV_8UC3);
            } catch (const Error& error) {
                EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
            }
        }
    }
}

TEST_F(ImageIo, TheHeaderReaderTakesAnyBytes) {
    ALTIRO3D_REQUIRE_WRITER(".exr");
    const cv::Mat picture = smoothPicture({19, 13});
    const std::vector<std::string> seeds = {
        pngWithRawProfile(picture, 6, true),
        jpegWithExif(picture, 6, true),
        webPWithExif(picture, 6),
        tiff({1, 1}, "abc"),
        encoded(".bmp", picture),
        encoded(".hdr", cv::Mat(2, 2, CV_32FC3, cv::Scalar(1))),
        encoded(".ppm", picture),
        encoded(".exr", cv::Mat(2, 2, CV_32FC3, cv::Scalar(1)))};
    cv::RNG random(3);
    for (int trial = 0; trial < 20000; ++trial) {
        std::string bytes = seeds[static_cast<std::size_t>(trial) % seeds.size()];
        for (int i = 0; i < 4; ++i) {
            const int limit = std::min(static_cast<int>(bytes.size()), i % 2 == 0 ? 64 : 100000);
            bytes[static_cast<std::size_t>(random.uniform(0, limit))] =
                static_cast<char>(random.uniform(0, 256));
        }
        if (trial % 3 == 0) bytes.resize(static_cast<std::size_t>(random.uniform(0, 200)));
        const ImageHeader header = readImageHeader(bytes, ".jpg");
        ASSERT_GE(header.orientation, 1);
        ASSERT_LE(header.orientation, 8);
    }
}

TEST_F(ImageIo, AnExrFileWithAPartThatIsLongerThanTheFileHasNoHeader) {
    ALTIRO3D_REQUIRE_WRITER(".exr");
    // OpenEXR would take the 1.5 GB that the part claims
    std::string bytes = encoded(".exr", cv::Mat(2, 2, CV_32FC3, cv::Scalar(1)));
    ASSERT_EQ(readImageHeader(bytes, ".exr").columns, 2u);
    const std::size_t size = bytes.find('\0', bytes.find("lineOrder") + 10) + 1;
    bytes[size + 3] = 0x60;
    EXPECT_EQ(readImageHeader(bytes, ".exr").columns, 0u);
    EXPECT_EQ(readImageHeader(bytes.substr(0, 100), ".exr").columns, 0u);
}

TEST(OrOutOfMemory, NamesWhatIsToBlameAndLetsOtherErrorsPass) {
    const auto codeWith = [](const std::function<void()>& work) {
        return codeOf([&] { orOutOfMemory("a.png", "does not fit", work); });
    };
    EXPECT_EQ(codeWith([] { throw std::bad_alloc(); }), ErrorCode::OutOfMemory);
    EXPECT_EQ(codeWith([] { CV_Error(cv::Error::StsNoMem, "as cv::Mat says it"); }),
              ErrorCode::OutOfMemory);
    EXPECT_THROW(orOutOfMemory("a", "b", [] { CV_Error(cv::Error::StsError, "other"); }),
                 cv::Exception);
    EXPECT_EQ(orOutOfMemory("a", "b", [] { return 7; }), 7);
}

// ------------------------------------------------------------------------------------ writing

// The deflated bytes of a PNG file; every chunk's checksum is looked at.
std::string imageData(const std::string& png) {
    std::string data;
    for (std::size_t at = 8; at + 12 <= png.size();) {
        const std::size_t size = bigEndianAt(png, at);
        const auto* const named = reinterpret_cast<const Bytef*>(png.data() + at + 4);
        EXPECT_EQ(bigEndianAt(png, at + 8 + size), crc32_z(0, named, size + 4)) << at;
        if (png.compare(at + 4, 4, "IDAT") == 0) data += png.substr(at + 8, size);
        at += 12 + size;
    }
    return data;
}

// The names of a PNG file's chunks, each once.
std::string chunkNames(const std::string& png) {
    std::string names;
    for (std::size_t at = 8; at + 12 <= png.size(); at += 12 + bigEndianAt(png, at)) {
        const std::string name = png.substr(at + 4, 4);
        if (names.find(name) == std::string::npos) names += name;
    }
    return names;
}

TEST_F(ImageIo, NativesAreMarkedInPngFiles) {
    const cv::Mat picture = randomPicture({20, 10}, CV_8UC3, 1);
    const fs::path native = directory / "native.png";
    writeImage(native, picture, ImageMark::Native);
    const std::string png = slurp(native);
    EXPECT_EQ(chunkNames(png), "IHDRtEXtIDATIEND");
    EXPECT_TRUE(holds(png, std::string("tEXtaltiro3D\0Native", 19)));
    imageData(png); // checks each sum
    EXPECT_TRUE(samePicture(readImage(native), picture));
    EXPECT_TRUE(isMarkedNative(native));

    writeImage(directory / "plain.png", picture);
    EXPECT_EQ(chunkNames(slurp(directory / "plain.png")), "IHDRIDATIEND");
    writeImage(directory / "native.tif", picture, ImageMark::Native);
    // the words alone are no mark: not after the pixels' end, not with another keyword
    const std::string text = "tEXt" + std::string("altiro3D\0Native", 15);
    file("tail.png", slurp(directory / "plain.png") + text);
    file("other.png", withPngChunks(encoded(".png", picture),
                                    pngChunk("tEXt", std::string("Title\0Native", 12))));
    file("cut.png", png.substr(0, 40));
    for (const char* name :
         {"plain.png", "native.tif", "tail.png", "other.png", "cut.png", "missing.png", "."})
        EXPECT_FALSE(isMarkedNative(directory / name)) << name;
}

TEST_F(ImageIo, PngFilesOfAnyShapeAreSoundAndReadBack) {
    struct Case {
        cv::Size size;
        int type;
    };
    // one band, several (of some 512 kB of pixels each), rows longer than a band
    for (const auto& [size, type] :
         {Case{{1, 1}, CV_8UC1}, Case{{3, 2}, CV_16UC3}, Case{{700, 1000}, CV_8UC3},
          Case{{1000, 900}, CV_16UC1}, Case{{1100, 500}, CV_8UC1}, Case{{200, 2000}, CV_16UC3},
          Case{{60000, 2}, CV_16UC3}, Case{{1, 60000}, CV_8UC3}}) {
        cv::Mat smooth;
        cv::resize(randomPicture({4, 3}, type, 21, 0, 65536), smooth, size, 0, 0, cv::INTER_CUBIC);
        for (const cv::Mat& picture :
             {randomPicture(size, type, 9, 0, 65536), smooth,
              cv::Mat(size, type, cv::Scalar(0, 200, 77)), cv::Mat(smooth.t())}) {
            const fs::path path = directory / "a.png";
            writeImage(path, picture);
            const cv::Mat back = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
            EXPECT_TRUE(samePicture(back, picture)) << size << cv::typeToString(type);
            const std::string data = imageData(slurp(path));
            // a row begins with its filter's number; uncompress() looks at the sum of all bytes
            std::vector<Bytef> rows(picture.total() * picture.elemSize() +
                                    static_cast<std::size_t>(picture.rows));
            uLongf length = static_cast<uLongf>(rows.size());
            EXPECT_EQ(uncompress(rows.data(), &length, reinterpret_cast<const Bytef*>(data.data()),
                                 static_cast<uLong>(data.size())),
                      Z_OK);
            EXPECT_EQ(length, rows.size());
        }
    }
}

TEST_F(ImageIo, PngFilesAreSmallAndTheSameForAnyNumberOfThreads) {
    const cv::Mat flat(1000, 1200, CV_8UC3, cv::Scalar(1, 2, 3));
    writeImage(directory / "flat.png", flat);
    EXPECT_LT(fs::file_size(directory / "flat.png"), flat.total() / 50);
    const cv::Mat smooth = smoothPicture({1200, 1000});
    writeImage(directory / "smooth.png", smooth);
    EXPECT_LT(fs::file_size(directory / "smooth.png"), encoded(".png", smooth).size());
    const RestoredThreads restored;
    for (const int count : {1, 2, 5}) {
        cv::setNumThreads(count);
        writeImage(directory / "again.png", smooth);
        EXPECT_EQ(slurp(directory / "again.png"), slurp(directory / "smooth.png")) << count;
    }
}

TEST_F(ImageIo, JpegIsWrittenAtQuality95) {
    const cv::Mat colour = smoothPicture({83, 61});
    cv::Mat grey;
    cv::extractChannel(colour, grey, 1);
    const cv::Mat part = colour(cv::Rect(3, 5, 40, 31)); // rows with a gap
    for (const cv::Mat& picture : {colour, grey, part, cv::Mat(colour(cv::Rect(0, 0, 1, 1)))}) {
        writeImage(directory / "a.jpg", picture);
        EXPECT_EQ(slurp(directory / "a.jpg"),
                  encoded(".jpg", picture, {cv::IMWRITE_JPEG_QUALITY, 95}));
    }
}

TEST_F(ImageIo, WhatCannotBeWrittenIsRefusedWithAReason) {
    const auto problem = [&](const char* name, const cv::Mat& picture) {
        return test::problemOf(directory / name, [&] { writeImage(directory / name, picture); });
    };
    const cv::Mat picture(4, 4, CV_8UC3, cv::Scalar::all(1));
    const std::string extensions =
        "its extension names no picture format that is written, expected "
        ".png, .jpg, .tif, .webp, .bmp, .ppm, .pgm or .jp2";
    EXPECT_EQ(problem("a.gif", picture), extensions);
    EXPECT_EQ(problem("noextension", picture), extensions);
    EXPECT_EQ(problem("a.pgm", picture),
              "PGM holds no colours, expected .ppm or .png for a colour picture");
    EXPECT_EQ(
        problem("a.webp", cv::Mat(1, 16384, CV_8UC3, cv::Scalar())),
        "16384 x 1 px are too many for WebP, expected sides of at most 16383 px; write a .png");
    EXPECT_TRUE(startsWith(problem("a.jp2", cv::Mat(1, 1, CV_8UC3, cv::Scalar())),
                           "cannot be encoded as JPEG 2000"));
    EXPECT_EQ(problem("a.png", cv::Mat()),
              "picture: is empty, expected 8 or 16 bits and 1 or 3 channels");
    EXPECT_EQ(problem("a.png", cv::Mat(1, 1, CV_32FC3)),
              "picture: is 1 x 1 px of CV_32FC3, expected 8 or 16 bits and 1 or 3 channels");
    EXPECT_EQ(problem("none/a.png", picture),
              "cannot be written: No such file or directory; its directory must exist");
    EXPECT_TRUE(fs::is_empty(directory.path()));
}

TEST_F(ImageIo, WhatCanBeWrittenIsToldByTheExtension) {
    for (const char* name : {"a.png", "a.PNG", "d/a.Jpg", "a.jpeg", "a.tif", "a.TIFF", "a.webp",
                             "a.bmp", "a.ppm", "a.pgm", "a.jp2", "a.b.png"})
        EXPECT_TRUE(canWriteImage(name)) << name;
    for (const char* name : {"a", "", ".png", "a.gif", "a.png.tmp", "a.mp4", "png", "a.exr"})
        EXPECT_FALSE(canWriteImage(name)) << name;
}

TEST_F(ImageIo, NamesAreOrderedNaturally) {
    const std::vector<std::string> ordered{"",
                                           "A1",
                                           "a2",
                                           "a10",
                                           "a10b",
                                           "B",
                                           "view9.png",
                                           "view10.png",
                                           "view10b.png",
                                           "view99999999999999999999998.png",
                                           "view99999999999999999999999.png"};
    for (std::size_t i = 0; i < ordered.size(); ++i)
        for (std::size_t j = 0; j < ordered.size(); ++j)
            EXPECT_EQ(naturalLess(ordered[i], ordered[j]), i < j)
                << ordered[i] << ' ' << ordered[j];
    // Names that differ in case or leading zeros alone still have one order.
    EXPECT_NE(naturalLess("a01", "a1"), naturalLess("a1", "a01"));
    EXPECT_NE(naturalLess("View", "view"), naturalLess("view", "View"));
}

TEST_F(ImageIo, ADirectorysPicturesAreListedInNaturalOrder) {
    for (const char* name : {"view10.png", "view9.PNG", "View1.jpg", ".hidden.png", "notes.txt"})
        file(name, "x");
    fs::create_directory(directory / "folder.png");
    std::error_code noLinks; // on Windows
    fs::create_symlink("nowhere.png", directory / "broken.png", noLinks);
    EXPECT_EQ(listImages(directory.path()),
              (std::vector<fs::path>{directory / "View1.jpg", directory / "view9.PNG",
                                     directory / "view10.png"}));
    const auto problem = [&](const char* name) {
        return test::problemOf(directory / name, [&] { listImages(directory / name); });
    };
    EXPECT_EQ(problem("none"), "does not exist, expected a directory with pictures");
    EXPECT_EQ(problem("notes.txt"), "cannot be listed: Not a directory, expected a directory");
}

// ------------------------------------------------------------------------------------ real data

TEST_F(ImageIo, EveryPhotoOpensOrIsRefusedWithOneLine) {
    ALTIRO3D_REQUIRE_DATA("photos");
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(dataPath("photos"))) {
        if (!entry.is_regular_file()) continue;
        const fs::path& path = entry.path();
        const std::string extension = path.extension().string();
        const bool isBroken = path.parent_path().filename() == "pillow_broken";
        const bool isOther =
            extension == ".gif" || extension == ".pcx" || extension == ".md" || extension.empty();
        try {
            const cv::Mat photo = readPhoto(path);
            EXPECT_EQ(photo.type(), CV_8UC3) << path;
            EXPECT_FALSE(photo.empty()) << path;
            EXPECT_FALSE(isOther) << path;
        } catch (const Error& error) {
            EXPECT_TRUE(isBroken || isOther) << error.what();
            const std::string said = error.what();
            EXPECT_TRUE(startsWith(said, path.string() + ": "));
            EXPECT_EQ(said.find('\n'), std::string::npos) << said;
        }
    }
}

TEST_F(ImageIo, WhatIsBrokenInItsMetadataAloneOpens) {
    ALTIRO3D_REQUIRE_DATA("photos/pillow_broken");
    const fs::path folder = dataPath("photos/pillow_broken");
    EXPECT_EQ(readPhoto(folder / "broken_exif_dpi.jpg").size(), cv::Size(100, 100));
    EXPECT_EQ(readPhoto(folder / "invalid-exif.jpg").size(), cv::Size(200, 200));
    EXPECT_EQ(readPhoto(folder / "junk_jpeg_header.jpg").size(), cv::Size(1024, 768));
    EXPECT_EQ(readPhoto(folder / "truncated_exif_dpi.jpg").size(), cv::Size(480, 640));
    Notes notes;
    EXPECT_EQ(readPhoto(folder / "truncated_jpeg.jpg", &notes).size(), cv::Size(100, 100));
    EXPECT_EQ(notes.size(), 1u);
}

TEST_F(ImageIo, CmykColoursAreRight) {
    ALTIRO3D_REQUIRE_DATA("photos/derived/kodim23_cmyk.jpg");
    // Naive CMYK and JPEG's losses; inverted inks would give less than 10 dB.
    EXPECT_GT(psnr(readPhoto(dataPath("photos/derived/kodim23_cmyk.jpg")),
                   readPhoto(dataPath("photos/kodak/kodim23.png"))),
              30);
}

} // namespace
} // namespace altiro3D::test
