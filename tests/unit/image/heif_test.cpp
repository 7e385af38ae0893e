// HEIC and AVIF: pictures, turns, repaired files, broken files.

#include "altiro3D/image_io.hpp"
#include "image/heif_file.hpp"
#include "image/image_header.hpp"
#include "support/files.hpp"
#include "support/heif_files.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D {
namespace {

using namespace test;

#define REQUIRE_HEIF()                                                                             \
    if (!hasHeif()) GTEST_SKIP() << "needs libheif, which this build does not have"

class Heif : public FileTest {
  protected:
    std::filesystem::path file(const std::string& contents) const {
        spill(directory / "a.heic", contents);
        return directory / "a.heic";
    }
};

// The px are those of the picture that was encoded, up to what the encoder loses.
void expectNear(const cv::Vec3b& bgr, int red, int green, int blue) {
    constexpr int kLoss = 14; // chroma at half resolution, quality 80
    EXPECT_NEAR(bgr[2], red, kLoss);
    EXPECT_NEAR(bgr[1], green, kLoss);
    EXPECT_NEAR(bgr[0], blue, kLoss);
}

void expectColours(const cv::Mat& picture) {
    ASSERT_EQ(picture.size(), cv::Size(128, 64));
    ASSERT_EQ(picture.type(), CV_8UC3);
    expectNear(picture.at<cv::Vec3b>(16, 32), 200, 40, 40);
    expectNear(picture.at<cv::Vec3b>(16, 96), 40, 180, 60);
    expectNear(picture.at<cv::Vec3b>(48, 32), 40, 60, 200);
    expectNear(picture.at<cv::Vec3b>(48, 96), 230, 230, 230);
}

TEST_F(Heif, HeicAndAvifAreRead) {
    REQUIRE_HEIF();
    Notes notes;
    expectColours(readPhoto(file(heifFile("heic", {hevcColours(1)})), &notes));
    expectColours(readPhoto(file(heifFile("avif", {av1Colours(1)})), &notes));
    EXPECT_TRUE(notes.empty());
}

TEST_F(Heif, PicturesOfAnAnimationAreFurtherPictures) {
    REQUIRE_HEIF();
    std::string box = heifFullBox("stsz", 0, bigEndian(7, 4) + bigEndian(12, 4)); // 12 of 7 bytes
    for (const char* const outer : {"stbl", "minf", "mdia", "trak", "moov"})
        box = heifBox(outer, box);
    for (const auto& [brand, item] : {std::pair{"avif", av1Colours(1)}, {"heic", hevcColours(1)}}) {
        const std::filesystem::path picture = file(heifFile(brand, {item}) + box);
        if (holds(errorOf([&] { readPhoto(picture); }), "image sequence"))
            GTEST_SKIP() << "this libheif reads animations and wants boxes that are not made here";
        Notes notes;
        expectColours(readPhoto(picture, &notes));
        EXPECT_EQ(only(notes).code, NoteCode::LeftOut);
        EXPECT_EQ(only(notes).text, "the file holds 12 pictures: the main one is read");
    }
}

TEST_F(Heif, DepthAndMattesAreNoFurtherPictures) {
    REQUIRE_HEIF();
    Notes notes;
    expectColours(readPhoto(file(appleHeic()), &notes));
    EXPECT_TRUE(notes.empty());
    readPhoto(file(heifFile("heic", {hevcColours(1), hevcColours(2)})), &notes);
    EXPECT_EQ(only(notes).code, NoteCode::LeftOut);
    EXPECT_EQ(only(notes).text, "the file holds 2 pictures: the main one is read");
}

TEST_F(Heif, TheContentsDecideTheFormat) {
    REQUIRE_HEIF();
    spill(directory / "a.jpg", heifFile("mif1", {hevcColours(1)}));
    expectColours(readPhoto(directory / "a.jpg"));
    EXPECT_EQ(imageFormat(heifFile("MiHB", {hevcColours(1)})), ImageFormat::Heic);
    EXPECT_EQ(imageFormat(std::string("\0\0\0\x18", 4) + "ftypmif1"), ImageFormat::Heic)
        << "ends before the list of brands";
    EXPECT_EQ(
        imageFormat(std::string("\0\0\0\x18", 4) + std::string("ftypmif1\0\0\0\0mif1avif", 20)),
        ImageFormat::Avif);
    EXPECT_EQ(
        imageFormat(std::string("\0\0\0\x18", 4) + std::string("ftypisom\0\0\0\0isommp42", 20)),
        ImageFormat::Unknown);
}

// EXIF repeats the turn that the format has already stated.
TEST_F(Heif, ThePictureIsTurnedOnce) {
    REQUIRE_HEIF();
    HeifItem photo = hevcColours(1);
    photo.properties.push_back(irot(3)); // a quarter clockwise
    const std::string exif =
        bigEndian(0, 4) + std::string("II*\0\10\0\0\0\1\0\x12\1\3\0\1\0\0\0\6\0\0\0\0\0\0\0", 26);
    const std::string bytes =
        heifFile("heic", {photo, {2, "Exif", exif, {}, ""}}, {{"cdsc", 2, {1}}});
    const cv::Mat turned = readPhoto(file(bytes));
    ASSERT_EQ(turned.size(), cv::Size(64, 128));
    expectNear(turned.at<cv::Vec3b>(32, 16), 40, 60, 200);
    expectNear(turned.at<cv::Vec3b>(32, 48), 200, 40, 40);
    EXPECT_EQ(readImageHeader(bytes, ".heic").columns, 64U);
}

TEST_F(Heif, FilesOfIos18AreRepaired) {
    REQUIRE_HEIF();
    const std::string bytes = appleHeic(true);
    const std::string repaired = repairedHeif(bytes);
    ASSERT_EQ(repaired.size(), bytes.size());
    EXPECT_EQ(repaired.find("tmap"), bytes.find("tmap"));
    EXPECT_EQ(repairedHeif(repaired), "");
    expectColours(readPhoto(file(bytes)));
    expectColours(readPhoto(file(repaired)));
    EXPECT_TRUE(HeifFile(bytes).decodeDepth(1e6).has_value());
    EXPECT_EQ(repairedHeif(appleHeic()), "") << "nothing to repair";
}

TEST_F(Heif, BrokenFilesOfIos18AreLeftAlone) {
    const std::string bytes = appleHeic(true);
    for (std::size_t size = 0; size < bytes.size(); size += 3)
        static_cast<void>(repairedHeif(bytes.substr(0, size)));
    const std::size_t iref = bytes.find("iref");
    for (std::size_t at = iref - 4; at < iref + 60; ++at) {
        for (const char value : {'\0', '\1', '\x7f', '\xff'}) {
            std::string broken = bytes;
            broken[at] = value;
            const std::string repaired = repairedHeif(broken);
            EXPECT_TRUE(repaired.empty() || repaired.size() == bytes.size()) << at;
        }
    }
}

TEST_F(Heif, TheSizeIsLimitedBeforeDecoding) {
    REQUIRE_HEIF();
    HeifItem photo = hevcColours(1);
    photo.properties.back() = ispe(30000, 30000);
    EXPECT_EQ(errorOf([&] { readPhoto(file(heifFile("heic", {photo}))); }),
              (directory / "a.heic").string() +
                  ": has 30000 x 30000 px, expected at most 400 megapixels and sides of at most "
                  "65500 px");
}

std::string bytesOf(const std::string& bits) {
    std::string bytes;
    for (std::size_t i = 0; i < bits.size(); i += 8)
        bytes.push_back(static_cast<char>(std::stoi(bits.substr(i, 8), nullptr, 2)));
    return bytes;
}

// The settings of a coded picture of so many px: a NAL unit as H.265 7.3.2.2 describes it.
std::string hevcSettings(unsigned columns, unsigned rows) {
    std::string bits = "0100001000000001"
                       "0000"
                       "000"
                       "1" +
                       std::string(96, '0');
    for (const unsigned value : {0U, 1U, columns, rows}) { // exponential-Golomb codes
        std::string digits;
        for (unsigned rest = value + 1; rest > 0; rest /= 2)
            digits.insert(digits.begin(), static_cast<char>('0' + rest % 2));
        bits += std::string(digits.size() - 1, '0') + digits;
    }
    bits += std::string(8 - bits.size() % 8, '1');
    std::string unit;
    for (const char byte : bytesOf(bits)) { // what would look like a start gets a 3 before it
        if (unit.size() >= 2 && unit.substr(unit.size() - 2) == std::string(2, '\0') &&
            static_cast<unsigned char>(byte) < 4)
            unit.push_back(3);
        unit.push_back(byte);
    }
    return heifBox("hvcC", '\1' + std::string(21, '\0') + '\1' + '\x21' + bigEndian(1, 2) +
                               bigEndian(unit.size(), 2) + unit);
}

TEST_F(Heif, TheCodedPictureIsLimitedAsWell) {
    EXPECT_EQ(heifProblem(appleHeic(), 128 * 64), "");
    EXPECT_EQ(heifProblem(appleHeic(), 128 * 64 - 1), "its coded picture has 128 x 64 px");
    const std::string huge = "its coded picture has 60000 x 50000 px";
    HeifItem photo = hevcColours(1);
    photo.properties.push_back(hevcSettings(60000, 50000));
    const std::string bytes = heifFile("heic", {photo});
    EXPECT_EQ(heifProblem(bytes, 4e8), huge);
    for (std::size_t size = 0; size < bytes.size(); size += 3)
        static_cast<void>(heifProblem(bytes.substr(0, size), 4e8));
    EXPECT_EQ(heifProblem("", 4e8), "");
    // Unusual sizes and places hide nothing.
    const auto longBox = [](const std::string& type, const std::string& body) {
        return bigEndian(1, 4) + type + bigEndian(16 + body.size(), 8) + body;
    };
    const std::string settings = hevcSettings(60000, 50000);
    const std::string body = settings.substr(8);
    const std::string zeros(4, '\0'); // version and flags
    const std::string ipco = heifBox("ipco", settings);
    for (const std::string& hidden :
         {longBox("meta", zeros + longBox("iprp", longBox("ipco", longBox("hvcC", body)))),
          heifBox("meta", zeros) + heifBox("meta", zeros + heifBox("iprp", ipco)),
          bigEndian(0, 4) + "meta" + zeros + heifBox("iprp", bigEndian(0, 4) + ipco.substr(4)),
          heifBox("meta", zeros + heifBox("iprp", heifBox("ipco", [&] {
                                              std::string many;
                                              for (int i = 0; i < 20000; ++i)
                                                  many += heifBox("free", "");
                                              return many + settings;
                                          }())))}) {
        EXPECT_EQ(heifProblem(hidden, 4e8), huge);
    }
    if (!hasHeif()) return;
    EXPECT_EQ(errorOf([&] { readPhoto(file(bytes)); }),
              (directory / "a.heic").string() +
                  ": cannot be decoded (its coded picture has 60000 x 50000 px), expected a whole "
                  "HEIC file");
}

// A sequence header of a still picture of so many px, with sizes of 16 bits (AV1 5.5.1).
std::string av1Sequence(unsigned columns, unsigned rows) {
    std::string bits = "000"
                       "1"
                       "1"
                       "00000"
                       "1111"
                       "1111";
    for (const unsigned value : {columns - 1, rows - 1}) {
        for (int bit = 15; bit >= 0; --bit)
            bits += (value >> bit & 1U) != 0 ? '1' : '0';
    }
    bits += std::string(8 - bits.size() % 8, '0');
    const std::string unit = bytesOf(bits);
    return "\x0a" + bigEndian(unit.size(), 1) + unit;
}

TEST_F(Heif, TheCodedPictureOfAnAvifIsLimitedAsWell) {
    const std::string whole = heifFile("avif", {av1Colours(1)});
    EXPECT_EQ(heifProblem(whole, 128 * 64), "");
    EXPECT_EQ(heifProblem(whole, 128 * 64 - 1), "its coded picture has 128 x 64 px");
    HeifItem photo = av1Colours(1);
    photo.data = std::string("\x12\0", 2) + av1Sequence(30000, 20001) + photo.data;
    const std::string bytes = heifFile("avif", {photo});
    EXPECT_EQ(heifProblem(bytes, 4e8), "its coded picture has 30000 x 20001 px");
    photo.data = "\x7a\x05?????" + photo.data; // padding hides nothing
    EXPECT_EQ(heifProblem(heifFile("avif", {photo}), 4e8),
              "its coded picture has 30000 x 20001 px");
    for (std::size_t size = 0; size < bytes.size(); size += 3)
        static_cast<void>(heifProblem(bytes.substr(0, size), 4e8));
    if (!hasHeif()) return;
    EXPECT_TRUE(holds(errorOf([&] { readPhoto(file(bytes)); }), "30000 x 20001 px"));
}

TEST_F(Heif, PartsMakeNoPictureThatIsNotStated) {
    const auto gridOf = [](unsigned columns, unsigned rows, bool isLong) {
        const unsigned size = isLong ? 4 : 2;
        return std::string(1, '\0') + bigEndian(isLong ? 1 : 0, 1) + bigEndian(0, 1) +
               bigEndian(0, 1) + bigEndian(columns, size) + bigEndian(rows, size);
    };
    const auto fileOf = [&](const std::string& type, const std::string& data) {
        HeifItem canvas;
        canvas.id = 2;
        canvas.type = type;
        canvas.data = data;
        canvas.properties = {ispe(128, 64)};
        return heifFile("heic", {hevcColours(1), canvas}, {{"dimg", 2, {1}}});
    };
    EXPECT_EQ(heifProblem(fileOf("grid", gridOf(128, 64, false)), 4e8), "");
    EXPECT_EQ(heifProblem(fileOf("grid", gridOf(128, 64, true)), 4e8), "");
    const std::string problem = "its parts make a picture of 32000 x 32000 px, which it does not "
                                "state";
    EXPECT_EQ(heifProblem(fileOf("grid", gridOf(32000, 32000, false)), 4e9), problem);
    EXPECT_EQ(heifProblem(fileOf("grid", gridOf(32000, 32000, true)), 4e9), problem);
    EXPECT_EQ(heifProblem(fileOf("iovl", std::string(10, '\0') + bigEndian(32000, 2) +
                                             bigEndian(32000, 2) + bigEndian(0, 4)),
                          4e9),
              problem);
    EXPECT_NE(heifProblem(fileOf("grid", gridOf(128, 65, false)), 4e8), "");
}

TEST_F(Heif, CutOffFilesAreOneErrorOrAPicture) {
    REQUIRE_HEIF();
    for (const std::string& whole : {appleHeic(), heifFile("avif", {av1Colours(1)})}) {
        int failures = 0;
        for (std::size_t size = 12; size < whole.size(); size += 5) {
            const std::string error = errorOf([&] { readPhoto(file(whole.substr(0, size))); });
            if (error == "(no error)") continue;
            ++failures;
            EXPECT_EQ(error.find('\n'), std::string::npos) << error;
            EXPECT_TRUE(holds(error, "expected"));
        }
        EXPECT_GT(failures, 20);
    }
}

TEST_F(Heif, WithoutLibheifTheErrorSaysSo) {
    if (hasHeif()) GTEST_SKIP() << "needs a build without libheif (ALTIRO3D_WITH_HEIF=OFF)";
    EXPECT_EQ(errorOf([&] { readPhoto(file(appleHeic())); }),
              (directory / "a.heic").string() +
                  ": HEIC pictures are not read, as libaltiro3D was built without libheif, "
                  "expected PNG, JPEG, TIFF, WebP, BMP, PNM, PFM, EXR, HDR or JPEG 2000; convert "
                  "it first");
}

} // namespace
} // namespace altiro3D
