// Colours: profiles, codes and gammas against closed forms; pictures that must keep their bytes.

#include "image/colour.hpp"

#include "altiro3D/depth_source.hpp"
#include "altiro3D/image_io.hpp"
#include "image/heif_file.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/photo_files.hpp"
#include "support/picture_files.hpp"
#include "support/pixels.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <lcms2.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tiffio.h>
#include <turbojpeg.h>

namespace altiro3D {
namespace {

using namespace test;

using Primaries = Chromaticities;

constexpr Primaries kSwapped = {0.30, 0.60, 0.64, 0.33, 0.15, 0.06}; // red and green
constexpr Primaries kAdobe = {0.64, 0.33, 0.21, 0.71, 0.15, 0.06};

std::string saved(cmsHPROFILE profile) {
    cmsUInt32Number size = 0;
    cmsSaveProfileToMem(profile, nullptr, &size);
    std::string bytes(size, '\0');
    cmsSaveProfileToMem(profile, bytes.data(), &size);
    cmsCloseProfile(profile);
    return bytes;
}

// exponent 0: the curve of sRGB
std::string iccProfile(const Primaries& p, double exponent) {
    const cmsCIExyY white{0.3127, 0.3290, 1};
    const cmsCIExyYTRIPLE primaries{{p[0], p[1], 1}, {p[2], p[3], 1}, {p[4], p[5], 1}};
    const double srgb[5] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    cmsToneCurve* const curve = exponent > 0 ? cmsBuildGamma(nullptr, exponent)
                                             : cmsBuildParametricToneCurve(nullptr, 4, srgb);
    cmsToneCurve* const curves[3] = {curve, curve, curve};
    std::string bytes = saved(cmsCreateRGBProfile(&white, &primaries, curves));
    cmsFreeToneCurve(curve);
    return bytes;
}

std::string iccChunk(const std::string& profile) {
    return pngChunk("iCCP", std::string("p\0\0", 3) + deflated(profile));
}

std::string gammaChunk(double exponent) {
    return pngChunk("gAMA", bigEndian(static_cast<unsigned>(std::lround(exponent * 1e5)), 4));
}

std::string primariesChunk(const Primaries& p) {
    std::string data = bigEndian(31270, 4) + bigEndian(32900, 4);
    for (const double value : p)
        data += bigEndian(static_cast<unsigned>(std::lround(value * 1e5)), 4);
    return pngChunk("cHRM", data);
}

std::string codeChunk(unsigned primaries, unsigned transfer) {
    return pngChunk("cICP",
                    bigEndian(primaries, 1) + bigEndian(transfer, 1) + std::string("\0\1", 2));
}

// All colours of a grid, and greys.
cv::Mat colourGrid() {
    cv::Mat picture(27, 29, CV_8UC3);
    for (int i = 0; i < 27 * 29; ++i) {
        const int k = i % 729;
        const auto level = [](int step) { return static_cast<std::uint8_t>(step * 255 / 8); };
        picture.at<cv::Vec3b>(i / 29, i % 29) = {level(k % 9), level(k / 9 % 9), level(k / 81)};
    }
    return picture;
}

// The largest difference in levels from the reference of each px.
template <class Reference>
double worst(const cv::Mat& picture, const cv::Mat& source, const Reference& reference) {
    double most = 0;
    forPixels(source.size(), [&](int x, int y) {
        const cv::Vec3d expected = reference(cv::Vec3d(source.at<cv::Vec3b>(y, x)) / 255.0);
        for (int c = 0; c < 3; ++c)
            most = std::max(most, std::abs(expected[c] * 255 - picture.at<cv::Vec3b>(y, x)[c]));
    });
    return most;
}

class ColourFiles : public FileTest {
  protected:
    cv::Mat read(const std::string& contents) {
        notes.clear();
        spill(directory / "a.png", contents);
        return readPhoto(directory / "a.png", &notes);
    }
    Notes notes;
    cv::Mat grid = colourGrid();
    std::string png = encoded(".png", grid);
};

TEST_F(ColourFiles, ProfilesAreConverted) {
    const std::vector<std::tuple<const char*, Primaries, double>> profiles = {
        {"Display P3", kDisplayP3, 0}, {"Adobe RGB", kAdobe, 2.19921875}, {"linear", kSrgb, 1}};
    for (const auto& [name, primaries, exponent] : profiles) {
        const cv::Mat picture = read(withPngChunks(png, iccChunk(iccProfile(primaries, exponent))));
        EXPECT_TRUE(notes.empty());
        // rounding, and lcms's tables of 8 bits
        EXPECT_LE(worst(picture, grid,
                        [&p = primaries, e = exponent](const cv::Vec3d& bgr) {
                            return referenceSrgb(bgr, p, e);
                        }),
                  1.6)
            << name;
    }
}

TEST_F(ColourFiles, SixteenBitsAreConverted) {
    cv::Mat deep;
    grid.convertTo(deep, CV_16U, 257);
    const std::string file =
        withPngChunks(encoded(".png", deep), iccChunk(iccProfile(kDisplayP3, 0)));
    spill(directory / "a.png", file);
    const cv::Mat picture = readImage(directory / "a.png");
    ASSERT_EQ(picture.type(), CV_16UC3);
    double most = 0;
    forPixels(grid.size(), [&](int x, int y) {
        const cv::Vec3d expected =
            referenceSrgb(cv::Vec3d(grid.at<cv::Vec3b>(y, x)) / 255.0, kDisplayP3, 0);
        for (int c = 0; c < 3; ++c)
            most = std::max(most, std::abs(expected[c] - picture.at<cv::Vec3w>(y, x)[c] / 65535.0));
    });
    EXPECT_LE(most * 255, 2); // lcms interpolates in a table of 33 steps
}

TEST_F(ColourFiles, AllFormatsWithProfilesAreConverted) {
    const std::string profile = iccProfile(kSwapped, 0);
    const cv::Mat plain(8, 8, CV_8UC3, cv::Scalar(30, 60, 200)); // BGR
    const std::string jpeg = encoded(".jpg", plain);
    const std::string parted =
        jpegSegment(0xe2, std::string("ICC_PROFILE\0\2\2", 14) + profile.substr(100)) +
        jpegSegment(0xe2, std::string("ICC_PROFILE\0\1\2", 14) + profile.substr(0, 100));
    std::vector<std::string> files = {withPngChunks(encoded(".png", plain), iccChunk(profile)),
                                      withSegments(jpeg, parted)};
    const std::string webp = encoded(".webp", plain); // a lossy or lossless chunk from byte 12
    const std::string extended = "WEBPVP8X" + littleEndian(10, 4) + std::string("\x20\0\0\0", 4) +
                                 littleEndian(7, 3) + littleEndian(7, 3) + "ICCP" +
                                 littleEndian(profile.size(), 4) + profile +
                                 std::string(profile.size() % 2, '\0') + webp.substr(12);
    files.push_back("RIFF" + littleEndian(extended.size(), 4) + extended);
    if (hasHeif()) {
        HeifItem item = hevcColours(1);
        item.properties.push_back(iccBox(profile));
        files.push_back(heifFile("heic", {item}));
    }
    for (std::size_t i = 0; i < files.size(); ++i) {
        const cv::Mat picture = read(files[i]);
        const auto& colour = picture.at<cv::Vec3b>(4, 4); // red and green have changed places
        if (i < 3) {
            EXPECT_NEAR(colour[2], 60, 4) << i;
            EXPECT_NEAR(colour[1], 200, 4) << i;
            EXPECT_NEAR(colour[0], 30, 4) << i;
        } else {
            EXPECT_NEAR(colour[1], 200, 14);
            EXPECT_NEAR(colour[2], 40, 14);
        }
    }
}

// The lightness of the test profile, which shows greys: each ink darkens by its own share.
double lightnessOf(double cyan, double magenta, double black) {
    return 100 * (1 - black) * (1 - 0.5 * cyan) * (1 - 0.3 * magenta);
}

std::string cmykProfile() {
    const auto sample = [](const cmsUInt16Number in[], cmsUInt16Number out[], void* /*cargo*/) {
        const cmsCIELab lab{lightnessOf(in[0] / 65535.0, in[1] / 65535.0, in[3] / 65535.0), 0, 0};
        cmsFloat2LabEncoded(out, &lab);
        return 1;
    };
    const cmsHPROFILE profile = cmsCreateProfilePlaceholder(nullptr);
    cmsSetProfileVersion(profile, 2.1);
    cmsSetDeviceClass(profile, cmsSigOutputClass);
    cmsSetColorSpace(profile, cmsSigCmykData);
    cmsSetPCS(profile, cmsSigLabData);
    cmsPipeline* const pipeline = cmsPipelineAlloc(nullptr, 4, 3);
    cmsStage* const grid = cmsStageAllocCLut16bit(nullptr, 9, 4, 3, nullptr);
    cmsStageSampleCLut16bit(grid, sample, nullptr, 0);
    cmsPipelineInsertStage(pipeline, cmsAT_BEGIN, grid);
    cmsWriteTag(profile, cmsSigAToB0Tag, pipeline);
    cmsPipelineFree(pipeline);
    return saved(profile);
}

// @param inks 0..255, as they are stored
std::string cmykJpeg(const cv::Scalar& inks, int side = 16) {
    const cv::Mat picture(side, side, CV_8UC4, inks);
    const tjhandle coder = tjInitCompress();
    unsigned char* bytes = nullptr;
    unsigned long size = 0;
    tjCompress2(coder, picture.data, side, 0, side, TJPF_CMYK, &bytes, &size, TJSAMP_444, 100, 0);
    std::string file(reinterpret_cast<const char*>(bytes), size);
    tjFree(bytes);
    tjDestroy(coder);
    return file;
}

// The sRGB level of a grey.
double greyLevel(double lightness) {
    const double f = (lightness + 16) / 116;
    const double light = lightness > 8 ? f * f * f : lightness / 903.3;
    return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

TEST_F(ColourFiles, InksAreConvertedByTheirProfile) {
    const std::string profile = cmykProfile();
    const std::string segment = jpegSegment(0xe2, std::string("ICC_PROFILE\0\1\1", 14) + profile);
    ASSERT_LT(profile.size(), 60000U);
    const std::array<double, 4> colours[] = {{0, 0, 0, 0},     {1, 0, 0, 0},   {0, 1, 0, 0},
                                             {0, 0, 1, 0},     {0, 0, 0, 0.5}, {0.25, 0.5, 1, 0.25},
                                             {0.5, 0.25, 0, 0}};
    for (const auto& [cyan, magenta, yellow, black] : colours) {
        // Adobe's programs store 0 for all of an ink
        const std::string file = cmykJpeg(
            {255 - 255 * cyan, 255 - 255 * magenta, 255 - 255 * yellow, 255 - 255 * black});
        const cv::Vec3b grey = read(withSegments(file, segment)).at<cv::Vec3b>(8, 8);
        EXPECT_TRUE(notes.empty());
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(grey[c], greyLevel(lightnessOf(cyan, magenta, black)), 3)
                << cyan << " " << magenta << " " << yellow << " " << black;
        }
        // without a profile each ink takes its colour away, and a note says so
        const cv::Vec3b usual = read(file).at<cv::Vec3b>(8, 8);
        EXPECT_TRUE(holds(only(notes).text, "CMYK without a colour profile"));
        EXPECT_NEAR(usual[0], 255 * (1 - yellow) * (1 - black), 3);
        EXPECT_NEAR(usual[1], 255 * (1 - magenta) * (1 - black), 3);
        EXPECT_NEAR(usual[2], 255 * (1 - cyan) * (1 - black), 3);
    }
    // an RGB profile is not for inks
    const std::string foreign =
        jpegSegment(0xe2, std::string("ICC_PROFILE\0\1\1", 14) + iccProfile(kSwapped, 0));
    EXPECT_NEAR(read(withSegments(cmykJpeg({55, 255, 255, 255}), foreign)).at<cv::Vec3b>(8, 8)[2],
                55, 3);
    ASSERT_EQ(notes.size(), 1U);
    // a file that ends too early is shown as far as it goes, and not by its profile
    const std::string whole = withSegments(cmykJpeg({155, 55, 255, 255}, 256), segment);
    EXPECT_EQ(read(whole.substr(0, whole.size() - 300)).size(), cv::Size(256, 256));
    ASSERT_EQ(notes.size(), 2U);
    EXPECT_TRUE(holds(notes[0].text, "CMYK"));
    EXPECT_EQ(notes[1].code, NoteCode::CutOff);
    // without Adobe's mark 255 is all of an ink
    std::string unmarked = cmykJpeg({255, 0, 0, 0});
    const std::size_t mark = unmarked.find("Adobe");
    ASSERT_NE(mark, std::string::npos);
    unmarked.erase(mark - 4, 16);
    (void)read(unmarked); // is stored as YCCK, which only the mark tells
    EXPECT_EQ(notes.size(), 2U);
}

TEST_F(ColourFiles, WhatIsSrgbKeepsItsBytes) {
    std::vector<std::string> chunks = {
        "",
        iccChunk(saved(cmsCreate_sRGBProfile())),
        iccChunk(iccProfile({0.6401, 0.33, 0.30, 0.6001, 0.1499, 0.06}, 0)),
        codeChunk(1, 13),
        codeChunk(2, 2),
        codeChunk(1, 1),
        gammaChunk(0.45455),
        gammaChunk(0.45455) + primariesChunk(kSrgb),
        pngChunk("sRGB", std::string(1, '\0')) + gammaChunk(1) + primariesChunk(kSwapped)};
    for (const std::string& chunk : chunks)
        EXPECT_TRUE(samePicture(read(withPngChunks(png, chunk)), grid)) << chunk.substr(4, 4);
    EXPECT_TRUE(notes.empty());
}

TEST_F(ColourFiles, GammaAndChromaticitiesOfPngCount) {
    const auto error = [&](const std::string& chunks, const Primaries& primaries, double exponent) {
        return worst(read(withPngChunks(png, chunks)), grid,
                     [&](const cv::Vec3d& bgr) { return referenceSrgb(bgr, primaries, exponent); });
    };
    EXPECT_LE(error(gammaChunk(1), kSrgb, 1), 1.6);
    EXPECT_LE(error(gammaChunk(1 / 1.8) + primariesChunk(kDisplayP3), kDisplayP3, 1.8), 1.6);
    EXPECT_LE(error(gammaChunk(0.45455) + primariesChunk(kSwapped), kSwapped, 0), 1.6);
    EXPECT_LE(error(primariesChunk(kSwapped), kSwapped, 0), 1.6);
}

TEST_F(ColourFiles, CodeGoesBeforeProfileBeforeSrgbBeforeGamma) {
    const std::string profile = iccChunk(iccProfile(kSwapped, 0));
    const cv::Mat p3 = read(withPngChunks(png, codeChunk(12, 13)));
    EXPECT_LE(
        worst(p3, grid, [](const cv::Vec3d& bgr) { return referenceSrgb(bgr, kDisplayP3, 0); }),
        1.6);
    EXPECT_TRUE(samePicture(read(withPngChunks(png, codeChunk(12, 13) + profile)), p3));
    const cv::Mat swapped = read(withPngChunks(png, profile));
    EXPECT_TRUE(samePicture(
        read(withPngChunks(png, profile + pngChunk("sRGB", std::string(1, '\0')) + gammaChunk(1))),
        swapped));
    cv::Mat expected;
    cv::mixChannels(std::vector<cv::Mat>{grid},
                    std::vector<cv::Mat>{expected = cv::Mat(grid.size(), CV_8UC3)},
                    std::vector<int>{0, 0, 1, 2, 2, 1});
    EXPECT_LE(cv::norm(swapped, expected, cv::NORM_INF), 1);
}

TEST_F(ColourFiles, DepthIsNeverConverted) {
    const std::string file = withPngChunks(png, iccChunk(iccProfile(kSrgb, 1)));
    spill(directory / "d.png", file);
    spill(directory / "e.png", png);
    EXPECT_TRUE(
        samePicture(readDepthImage(directory / "d.png"), readDepthImage(directory / "e.png")));
}

TEST_F(ColourFiles, HdrIsToneMapped) {
    const std::vector<std::tuple<unsigned, unsigned, Primaries>> codes = {
        {9, 16, kRec2020}, {12, 16, kDisplayP3}, {9, 18, kRec2020}};
    for (const auto& [primaries, transfer, chromaticities] : codes) {
        const cv::Mat picture = read(withPngChunks(png, codeChunk(primaries, transfer)));
        EXPECT_EQ(only(notes).code, NoteCode::Converted);
        EXPECT_EQ(only(notes).text, std::string("the picture is HDR (") +
                                        (transfer == 16 ? "PQ" : "HLG") +
                                        "): its bright parts are compressed");
        EXPECT_LE(worst(picture, grid,
                        [&c = chromaticities, isHlg = transfer == 18](const cv::Vec3d& bgr) {
                            return referenceToneMapped(bgr, c, isHlg);
                        }),
                  1.0); // rounding and tables
    }
}

// Light of 0 to 1, the levels of the grid.
cv::Mat lightOf(const cv::Mat& grid) {
    cv::Mat light;
    grid.convertTo(light, CV_32F, 1 / 255.0);
    return light;
}

TEST_F(ColourFiles, LightOfExrAndHdrBecomesSrgb) {
    ALTIRO3D_REQUIRE_WRITER(".exr");
    const cv::Mat light = lightOf(grid);
    const auto srgb = [](const cv::Vec3d& bgr) { return referenceSrgb(bgr, kSrgb, 1); };
    const std::string exr = encoded(".exr", light);
    EXPECT_LE(worst(read(exr), grid, srgb), 0.51); // rounding
    EXPECT_TRUE(notes.empty());
    const std::string hdr = encoded(".hdr", light);
    // mantissas of 8 bits for the three colours together; in the dark a step is up to 13 levels
    EXPECT_LE(worst(read(hdr), grid, srgb), 14);
    EXPECT_NEAR(
        read(encoded(".hdr", cv::Mat(9, 9, CV_32FC3, cv::Scalar::all(0.1023)))) // 90 of sRGB
            .at<cv::Vec3b>(4, 4)[1],
        90, 1);
    EXPECT_TRUE(notes.empty());

    cv::Mat grey( // depth stays as it is
        light.size(), CV_32FC1);
    cv::extractChannel(light, grey, 1);
    spill(directory / "d.exr", encoded(".exr", grey));
    EXPECT_TRUE(samePicture(readDepthImage(directory / "d.exr"), grey));
    EXPECT_LE(worst(readPhoto(directory / "d.exr"), grid,
                    [&](const cv::Vec3d& bgr) { return srgb(cv::Vec3d::all(bgr[1])); }),
              0.51);
}

TEST_F(ColourFiles, PrimariesOfExrAndHdrCount) {
    const auto reference = [](const cv::Vec3d& bgr) { return referenceSrgb(bgr, kRec2020, 1); };
    std::string attribute("v/1\1\2\0\0\0chromaticities\0chromaticities\0\x20\0\0\0", 42);
    for (const float value : {0.708F, 0.292F, 0.170F, 0.797F, 0.131F, 0.046F, 0.3127F, 0.3290F})
        attribute.append(reinterpret_cast<const char*>(&value), sizeof(value));
    cv::Mat picture = lightOf(grid);
    convertToSrgb(picture, readColourFacts(attribute, ImageFormat::Exr), &notes);
    picture.convertTo(picture, CV_8U, 255);
    EXPECT_LE(worst(picture, grid, reference), 1);
    picture = lightOf(grid); // a file that ends too early states nothing
    convertToSrgb(picture, readColourFacts(attribute.substr(0, 73), ImageFormat::Exr), &notes);
    picture.convertTo(picture, CV_8U, 255);
    EXPECT_LE(worst(picture, grid, [](const cv::Vec3d& v) { return referenceSrgb(v, kSrgb, 1); }),
              1);

    const cv::Mat plain(8, 8, CV_32FC3, cv::Scalar(0.25, 0.5, 0.75));
    const std::string hdr = encoded(".hdr", plain);
    const std::string line = "\nPRIMARIES= 0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.3290";
    const cv::Vec3b colour =
        read(std::string(hdr).insert(hdr.find("\n\n"), line)).at<cv::Vec3b>(4, 4);
    const cv::Vec3d expected = reference({0.25, 0.5, 0.75}) * 255;
    EXPECT_LE(cv::norm(cv::Vec3d(colour), expected, cv::NORM_INF), 2) << colour << expected;
    EXPECT_TRUE(notes.empty());

    // ACES: one primary lies beyond all colours, and white has another colour; grey stays grey
    ColourFacts aces;
    aces.gamma = 1;
    aces.chromaticities = {0.32168, 0.33767, 0.7347, 0.2653, 0, 1, 0.0001, -0.077};
    cv::Mat grey(4, 4, CV_32FC3, cv::Scalar::all(0.5));
    convertToSrgb(grey, aces, &notes);
    EXPECT_LE(cv::norm(grey, cv::Mat(4, 4, CV_32FC3, cv::Scalar::all(0.7354)), cv::NORM_INF),
              0.001);
    EXPECT_TRUE(notes.empty());
    aces.chromaticities->at(1) = 0;
    grey.setTo(0.5);
    convertToSrgb(grey, aces, &notes);
    EXPECT_EQ(only(notes).text,
              "the primaries that the file states are damaged: those of sRGB are used");
    EXPECT_LE(cv::norm(grey, cv::Mat(4, 4, CV_32FC3, cv::Scalar::all(0.7354)), cv::NORM_INF),
              0.001);
}

TEST_F(ColourFiles, LightBeyondWhiteIsNoted) {
    ALTIRO3D_REQUIRE_WRITER(".exr");
    cv::Mat light(10, 10, CV_32FC3, cv::Scalar::all(0.5));
    light.row(0).setTo(4);
    light.at<cv::Vec3f>(1, 0) = cv::Vec3f::all(std::nanf(""));
    light.at<cv::Vec3f>(1, 1) = cv::Vec3f::all(HUGE_VALF);
    light.at<cv::Vec3f>(1, 2) = cv::Vec3f::all(-1);
    const cv::Mat photo = read(encoded(".exr", light));
    EXPECT_EQ(only(notes).code, NoteCode::AsItIs);
    EXPECT_EQ(only(notes).text, "11 % of the picture is brighter than white and shown as white");
    EXPECT_EQ(photo.at<cv::Vec3b>(0, 0), cv::Vec3b::all(255));
    EXPECT_EQ(photo.at<cv::Vec3b>(1, 0), cv::Vec3b::all(0));
    EXPECT_EQ(photo.at<cv::Vec3b>(1, 1), cv::Vec3b::all(255));
    EXPECT_EQ(photo.at<cv::Vec3b>(1, 2), cv::Vec3b::all(0));
    EXPECT_EQ(photo.at<cv::Vec3b>(5, 5), cv::Vec3b::all(188));                        // 0.7354
    EXPECT_NEAR(readImage(directory / "a.png").at<cv::Vec3f>(0, 0)[0], 1.825, 0.001); // 4
}

TEST_F(ColourFiles, FloatsAreConvertedByTheirProfileOrNoted) {
    const cv::Mat light = lightOf(grid);
    const auto file = directory / "a.tif";
    for (const bool hasProfile : {false, true}) {
        cv::imwrite(file.string(), light, {cv::IMWRITE_TIFF_COMPRESSION, COMPRESSION_NONE});
        if (hasProfile) {
            const std::string profile = iccProfile(kDisplayP3, 1);
            TIFF* const tiff = TIFFOpen(file.string().c_str(), "r+");
            TIFFSetField(tiff, TIFFTAG_ICCPROFILE, profile.size(), profile.data());
            ASSERT_EQ(TIFFRewriteDirectory(tiff), 1);
            TIFFClose(tiff);
        }
        notes.clear();
        const cv::Mat photo = readPhoto(file, &notes);
        if (hasProfile) {
            EXPECT_LE(worst(photo, grid,
                            [](const cv::Vec3d& v) { return referenceSrgb(v, kDisplayP3, 1); }),
                      1);
            EXPECT_TRUE(notes.empty());
        } else {
            EXPECT_TRUE(samePicture(photo, grid));
            EXPECT_EQ(only(notes).code, NoteCode::Doubtful);
            EXPECT_EQ(only(notes).text,
                      "the file holds floats without a colour profile: they are read as sRGB from "
                      "0, black, to 1, white, and not as linear light");
        }
    }
}

TEST(Colour, AvifStatesColoursAsNumbers) {
    if (!hasHeif()) GTEST_SKIP() << "needs libheif, which this build does not have";
    const auto factsOf = [](const std::vector<std::string>& boxes) {
        HeifItem item = av1Colours(1);
        item.properties.insert(item.properties.end(), boxes.begin(), boxes.end());
        return readColourFacts(heifFile("avif", {item}), ImageFormat::Avif);
    };
    const ColourFacts p3 = factsOf({nclx(12, 13)});
    ASSERT_TRUE(p3.code);
    EXPECT_EQ(p3.code->primaries, 12);
    EXPECT_EQ(p3.code->transfer, 13);
    EXPECT_EQ(factsOf({nclx(9, 16)}).code->transfer, 16);
    EXPECT_FALSE(factsOf({nclx(9, 16), iccBox(iccProfile(kSrgb, 0))}).code) << "ICC goes first";
}

TEST_F(ColourFiles, DamagedAndForeignProfilesAreSaid) {
    const std::string profile = iccProfile(kDisplayP3, 0);
    EXPECT_TRUE(samePicture(read(withPngChunks(png, iccChunk("not a profile"))), grid));
    EXPECT_EQ(only(notes).code, NoteCode::AsItIs);
    EXPECT_EQ(only(notes).text, "the colour profile is damaged: the colours are read as sRGB");
    EXPECT_TRUE(samePicture(
        read(withPngChunks(png, iccChunk(saved(cmsCreateLab4Profile(nullptr))))), grid));
    ASSERT_EQ(notes.size(), 1U);
    for (std::size_t size = 0; size < profile.size(); size += 11)
        EXPECT_EQ(read(withPngChunks(png, iccChunk(profile.substr(0, size)))).size(), grid.size());
    for (const Primaries& odd :
         {Primaries{}, Primaries{0, 0, 0, 0, 0, 0}, Primaries{0.3, 0.3, 0.3, 0.3, 0.3, 0.3}})
        EXPECT_EQ(read(withPngChunks(png, primariesChunk(odd) + gammaChunk(1))).size(),
                  grid.size());
    EXPECT_TRUE(samePicture(read(withPngChunks(png, gammaChunk(0.00001))), grid));
}

TEST_F(ColourFiles, ThreadsDoNotChangeTheResult) {
    const cv::Mat photo = scenery({301, 211}, 5);
    for (const std::string& chunk : {iccChunk(iccProfile(kDisplayP3, 0)), codeChunk(9, 18)}) {
        const std::string file = withPngChunks(encoded(".png", photo), chunk);
        expectSameForAnyThreads([&] { return read(file); }, {5});
    }
}

// The numbers of depth are not colours.
TEST(Colour, OfAnRgbdImageOnlyThePhotoIsConverted) {
    const TemporaryDirectory directory;
    const std::string chunk = iccChunk(iccProfile(kSwapped, 1.4));
    const cv::Mat photo = randomPhoto({40, 30}, 3);
    cv::Mat depth(photo.size(), CV_8UC3);
    for (int x = 0; x < depth.cols; ++x)
        depth.col(x).setTo(cv::Scalar::all(6 * x));
    spill(directory / "photo.png", withPngChunks(encoded(".png", photo), chunk));
    const cv::Mat converted = readImage(directory / "photo.png");
    EXPECT_FALSE(samePicture(converted, photo));
    for (const bool isFirst : {false, true}) {
        cv::Mat both;
        cv::hconcat(isFirst ? depth : photo, isFirst ? photo : depth, both);
        spill(directory / "both.png", withPngChunks(encoded(".png", both), chunk));
        const DepthSide side = isFirst ? DepthSide::Left : DepthSide::Right;
        const cv::Mat read = readRgbdImage(directory / "both.png", side);
        const cv::Rect left(0, 0, 40, 30);
        const cv::Rect right(40, 0, 40, 30);
        EXPECT_TRUE(samePicture(read(isFirst ? right : left), converted));
        EXPECT_TRUE(samePicture(read(isFirst ? left : right), depth));
        Scene scene;
        const auto source = depthFromRgbd(side);
        source->readScene(source->readPhoto(directory / "both.png"), 0.5, scene);
        EXPECT_TRUE(samePicture(scene.photo, converted));
        EXPECT_NEAR(scene.depth.at<float>(15, 20), 20 / 39.0, 0.01);
    }
    // a grey picture becomes one with colours where its profile changes it
    cv::Mat grey;
    cv::cvtColor(depth, grey, cv::COLOR_BGR2GRAY);
    cv::hconcat(grey, grey, grey);
    spill(directory / "grey.png", withPngChunks(encoded(".png", grey), gammaChunk(1)));
    const cv::Mat read = readRgbdImage(directory / "grey.png", DepthSide::Right);
    EXPECT_EQ(read.type(), CV_8UC3);
    EXPECT_TRUE(samePicture(read.colRange(40, 80), depth));
    EXPECT_GT(read.at<cv::Vec3b>(15, 20)[0], depth.at<cv::Vec3b>(15, 20)[0] + 40);
}

} // namespace
} // namespace altiro3D
