// TIFF pictures of all kinds, written by libtiff sample by sample; the expected pictures are closed
// forms.

#include "altiro3D/image_io.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/pixels.hpp"

#include <cmath>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <opencv2/core.hpp>
#include <tiffio.h>
#include <vector>

namespace altiro3D {
namespace {

using namespace test;

using Bytes = std::vector<std::uint8_t>;
// The number of a sample.
using Samples = std::function<double(int x, int y, unsigned sample)>;

struct Kind {
    unsigned bits = 8;
    unsigned samples = 3;
    unsigned photometric = PHOTOMETRIC_RGB;
    unsigned format = SAMPLEFORMAT_UINT;
    bool isPlanar = false;
    bool isTiled = false;
    std::string mode = "w"; // of libtiff: byte order, BigTIFF
    unsigned bitOrder = FILLORDER_MSB2LSB;
    unsigned orientation = ORIENTATION_TOPLEFT;
    unsigned compression = COMPRESSION_NONE;
    std::vector<std::uint16_t> extras;
    cv::Size size{37, 21};
};

Kind greyKind(unsigned bits = 8) {
    Kind kind;
    kind.bits = bits;
    kind.samples = 1;
    kind.photometric = PHOTOMETRIC_MINISBLACK;
    return kind;
}

struct Close {
    void operator()(TIFF* file) const { TIFFClose(file); }
};
using File = std::unique_ptr<TIFF, Close>;

File create(const std::filesystem::path& path, const std::string& mode = "w") {
    File file(TIFFOpen(path.string().c_str(), mode.c_str()));
    EXPECT_TRUE(file);
    return file;
}

template <typename T>
void append(Bytes& bytes, T number) {
    bytes.resize(bytes.size() + sizeof(T));
    std::memcpy(bytes.data() + bytes.size() - sizeof(T), &number, sizeof(T));
}

// The bits of a half float. OpenCV has no type for it on every processor.
std::uint16_t halfOf(double number) {
    cv::Mat half;
    cv::Mat1f(1, 1, static_cast<float>(number)).convertTo(half, CV_16F);
    std::uint16_t bits = 0;
    std::memcpy(&bits, half.data, sizeof bits);
    return bits;
}

// Samples of a row, as libtiff takes them.
Bytes packed(const std::vector<double>& row, const Kind& kind) {
    Bytes bytes;
    unsigned bit = 0;
    for (const double number : row) {
        if (kind.format == SAMPLEFORMAT_IEEEFP) {
            if (kind.bits == 16) append(bytes, halfOf(number));
            if (kind.bits == 32) append(bytes, static_cast<float>(number));
            if (kind.bits == 64) append(bytes, number);
            if (kind.bits == 24) bytes.resize(bytes.size() + 3);
        } else if (kind.bits == 32) {
            append(bytes, static_cast<std::uint32_t>(static_cast<std::int64_t>(number)));
        } else if (kind.bits == 16) {
            append(bytes, static_cast<std::uint16_t>(static_cast<int>(number)));
        } else { // the most significant bit first
            for (unsigned i = 0; i < kind.bits; ++i, ++bit) {
                if (bit % 8 == 0) bytes.push_back(0);
                if ((static_cast<std::int64_t>(number) >> (kind.bits - 1 - i) & 1) != 0)
                    bytes.back() |= static_cast<std::uint8_t>(128U >> bit % 8);
            }
        }
    }
    return bytes;
}

void setFields(TIFF* file, const Kind& kind) {
    TIFFSetField(file, TIFFTAG_IMAGEWIDTH, kind.size.width);
    TIFFSetField(file, TIFFTAG_IMAGELENGTH, kind.size.height);
    TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, kind.bits);
    TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, kind.samples);
    TIFFSetField(file, TIFFTAG_PHOTOMETRIC, kind.photometric);
    TIFFSetField(file, TIFFTAG_SAMPLEFORMAT, kind.format);
    TIFFSetField(file, TIFFTAG_PLANARCONFIG,
                 kind.isPlanar ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
    TIFFSetField(file, TIFFTAG_COMPRESSION, kind.compression);
    TIFFSetField(file, TIFFTAG_FILLORDER, kind.bitOrder);
    TIFFSetField(file, TIFFTAG_ORIENTATION, kind.orientation);
    if (!kind.extras.empty())
        TIFFSetField(file, TIFFTAG_EXTRASAMPLES, kind.extras.size(), kind.extras.data());
}

void writePage(TIFF* file, const Kind& kind, const Samples& samples) {
    constexpr int kTile = 16;
    setFields(file, kind);
    if (kind.isTiled) {
        TIFFSetField(file, TIFFTAG_TILEWIDTH, kTile);
        TIFFSetField(file, TIFFTAG_TILELENGTH, kTile);
    } else {
        TIFFSetField(file, TIFFTAG_ROWSPERSTRIP, 16);
    }
    const auto rowOf = [&](int left, int width, int y, unsigned plane) {
        std::vector<double> row;
        for (int x = left; x < left + width; ++x) {
            for (unsigned s = 0; s < kind.samples; ++s) {
                if (kind.isPlanar && s != plane) continue;
                const bool isInside = x < kind.size.width && y < kind.size.height;
                row.push_back(isInside ? samples(x, y, s) : 0);
            }
        }
        return packed(row, kind);
    };
    for (unsigned plane = 0; plane < (kind.isPlanar ? kind.samples : 1); ++plane) {
        const auto sample = static_cast<std::uint16_t>(plane);
        const int step = kind.isTiled ? kTile : 1;
        for (int y = 0; y < kind.size.height; y += step) {
            for (int x = 0; x < kind.size.width; x += kind.isTiled ? kTile : kind.size.width) {
                Bytes block;
                for (int i = 0; i < step; ++i) {
                    const Bytes row =
                        rowOf(x, kind.isTiled ? kTile : kind.size.width, y + i, plane);
                    block.insert(block.end(), row.begin(), row.end());
                }
                const auto left = static_cast<std::uint32_t>(x);
                const auto top = static_cast<std::uint32_t>(y);
                ASSERT_GE(kind.isTiled ? TIFFWriteTile(file, block.data(), left, top, 0, sample)
                                       : TIFFWriteScanline(file, block.data(), top, sample),
                          0);
            }
        }
    }
}

void write(const std::filesystem::path& path, const Kind& kind, const Samples& samples) {
    writePage(create(path, kind.mode).get(), kind, samples);
}

double largestOf(const Kind& kind) {
    if (kind.format == SAMPLEFORMAT_IEEEFP) return 1;
    return std::pow(2.0, kind.bits) - 1;
}

// 0 to 1, another in each px and sample.
double share(int x, int y, unsigned sample) {
    return (x * 7 + y * 13 + static_cast<int>(sample) * 41) % 101 / 100.0;
}

// `share` as a number of the file.
Samples levels(const Kind& kind) {
    return [kind](int x, int y, unsigned s) {
        const double level = share(x, y, s) * largestOf(kind);
        return kind.format == SAMPLEFORMAT_IEEEFP ? level : std::round(level);
    };
}

// What readPhoto() shows of numbers of red, green and blue; or grey of one.
cv::Mat photoOf(const Kind& kind, const Samples& samples) {
    cv::Mat photo(kind.size, CV_8UC3);
    forPixels(photo.size(), [&](int x, int y) {
        for (unsigned c = 0; c < 3; ++c) {
            const double level = samples(x, y, kind.samples < 3 ? 0 : 2 - c);
            photo.at<cv::Vec3b>(y, x)[static_cast<int>(c)] =
                static_cast<std::uint8_t>(std::lround(level / largestOf(kind) * 255));
        }
    });
    return photo;
}

std::string textOf(const Kind& kind) {
    return std::to_string(kind.bits) + " bits, format " + std::to_string(kind.format) + ", " +
           kind.mode + (kind.isPlanar ? ", planar" : "") + (kind.isTiled ? ", tiled" : "");
}

class Tiff : public FileTest {
  protected:
    // The refusal of a file, without its name.
    std::string problemOf(const Kind& kind) const {
        write(file, kind, [](int, int, unsigned) { return 0; });
        return test::problemOf(file, [&] { readImage(file); });
    }
    cv::Vec3b photoPx() const { return readPhoto(file).at<cv::Vec3b>(0, 0); }

    std::filesystem::path file = directory / "a.tif";
};

const std::vector<std::pair<unsigned, unsigned>> kDepths = {
    {1, SAMPLEFORMAT_UINT},    {2, SAMPLEFORMAT_UINT},    {4, SAMPLEFORMAT_UINT},
    {6, SAMPLEFORMAT_UINT},    {8, SAMPLEFORMAT_UINT},    {10, SAMPLEFORMAT_UINT},
    {12, SAMPLEFORMAT_UINT},   {14, SAMPLEFORMAT_UINT},   {16, SAMPLEFORMAT_UINT},
    {32, SAMPLEFORMAT_UINT},   {16, SAMPLEFORMAT_IEEEFP}, {32, SAMPLEFORMAT_IEEEFP},
    {64, SAMPLEFORMAT_IEEEFP}, {8, SAMPLEFORMAT_VOID}};

TEST_F(Tiff, EachDepthInEachLayoutGivesTheSamePicture) {
    Kind kind;
    for (const auto& [bits, format] : kDepths) {
        for (const char* mode : {"wl", "wb", "wl8", "wb8"}) {
            for (const int layout : {0, 1, 2, 3}) {
                kind.bits = bits;
                kind.format = format;
                kind.mode = mode;
                kind.isPlanar = layout % 2 != 0;
                kind.isTiled = layout / 2 != 0;
                write(file, kind, levels(kind));
                // 1: numbers are rounded in the file, then to 16 bits, then to 8
                EXPECT_TRUE(samePicture(readPhoto(file), photoOf(kind, levels(kind)), 1))
                    << textOf(kind);
            }
        }
    }
}

TEST_F(Tiff, DepthImagesKeepTheNumbersOfEachDepth) {
    Kind kind = greyKind();
    auto depths = kDepths;
    for (const unsigned bits : {8U, 16U, 32U})
        depths.emplace_back(bits, SAMPLEFORMAT_INT);
    for (const auto& [bits, format] : depths) {
        for (const bool isTiled : {false, true}) {
            kind.bits = bits;
            kind.format = format;
            kind.isTiled = isTiled;
            const double zero = format == SAMPLEFORMAT_INT ? std::pow(2.0, bits - 1) : 0;
            const Samples numbers = [&](int x, int y, unsigned s) {
                return levels(kind)(x, y, s) - zero;
            };
            write(file, kind, numbers);
            const cv::Mat expected =
                pictureOf<float>(kind.size, [&](int x, int y) { return numbers(x, y, 0); });
            // half floats have 11 bits
            const double tolerance = format == SAMPLEFORMAT_IEEEFP && bits == 16 ? 0x1p-11 : 0;
            EXPECT_TRUE(samePicture(readDepthImage(file), expected, tolerance)) << textOf(kind);
        }
    }
}

TEST_F(Tiff, WhiteMayBeZero) {
    Kind kind;
    for (const unsigned bits : {1U, 4U, 8U, 12U, 16U, 32U}) {
        kind = greyKind(bits);
        write(file, kind, levels(kind));
        const cv::Mat expected = readPhoto(file);
        kind.photometric = PHOTOMETRIC_MINISWHITE;
        write(file, kind,
              [&](int x, int y, unsigned s) { return largestOf(kind) - levels(kind)(x, y, s); });
        EXPECT_TRUE(samePicture(readPhoto(file), expected)) << bits;
    }
    kind.compression = COMPRESSION_CCITTFAX4;
    kind.bits = 1;
    for (const unsigned order : {unsigned{FILLORDER_MSB2LSB}, unsigned{FILLORDER_LSB2MSB}}) {
        kind.bitOrder = order;
        write(file, kind, [](int x, int y, unsigned s) { return share(x, y, s) < 0.5 ? 1 : 0; });
        EXPECT_EQ(readPhoto(file).at<cv::Vec3b>(0, 3)[0], share(3, 0, 0) < 0.5 ? 0 : 255);
        EXPECT_EQ(readPhoto(file).at<cv::Vec3b>(0, 9)[0], share(9, 0, 0) < 0.5 ? 0 : 255);
    }
}

// Where row 0 and column 0 of the file are in the picture, for each orientation.
TEST_F(Tiff, OrientationIsAppliedOnce) {
    const cv::Point corners[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (unsigned orientation = 1; orientation <= 8; ++orientation) {
        for (const unsigned bits : {8U, 16U}) {
            Kind kind = greyKind(bits);
            kind.mode = bits == 8 ? "wl" : "wb";
            kind.orientation = orientation;
            kind.size = {3, 2};
            write(file, kind, [](int x, int y, unsigned) { return 10 + 3 * y + x; });
            const cv::Mat depth = readDepthImage(file);
            const cv::Size size = orientation < 5 ? cv::Size(3, 2) : cv::Size(2, 3);
            ASSERT_EQ(depth.size(), size);
            EXPECT_EQ(readImage(file).size(), size);
            const cv::Point corner = corners[orientation - 1];
            forPixels(size, [&](int x, int y) {
                const int right = std::abs(x - corner.x * (size.width - 1)); // from the corner
                const int down = std::abs(y - corner.y * (size.height - 1));
                EXPECT_EQ(depth.at<float>(y, x),
                          orientation < 5 ? 10 + 3 * down + right : 10 + 3 * right + down)
                    << orientation << " " << x << " " << y;
            });
        }
    }
}

// What is brighter than its alpha is not multiplied by it yet.
TEST_F(Tiff, AlphaOfAnUnstatedKindIsRecognized) {
    Kind kind;
    kind.samples = 4;
    kind.extras = {EXTRASAMPLE_UNSPECIFIED};
    for (const double factor : {1.0, 0.5}) {
        const double numbers[] = {200 * factor, 100 * factor, 50 * factor, 128};
        write(file, kind, [&](int, int, unsigned s) { return numbers[s]; });
        EXPECT_EQ(photoPx(), cv::Vec3b(25, 50, 100)) << factor;
    }
}

TEST_F(Tiff, TheThumbnailBeforeThePhotoIsNotShown) {
    Kind photo;
    Kind thumbnail;
    thumbnail.size = {9, 5};
    const auto add = [&](TIFF* tiff, const Kind& kind, unsigned subfile) {
        TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, subfile);
        writePage(tiff, kind, levels(kind));
        TIFFWriteDirectory(tiff);
    };
    for (const unsigned type : {unsigned{FILETYPE_REDUCEDIMAGE}, unsigned{FILETYPE_MASK}}) {
        {
            const File tiff = create(file);
            add(tiff.get(), thumbnail, type);
            add(tiff.get(), photo, 0);
        }
        Notes notes;
        EXPECT_TRUE(samePicture(readImage(file, &notes), photoOf(photo, levels(photo)), 1));
        EXPECT_TRUE(notes.empty());
        EXPECT_EQ(readDepthImage(file).size(), photo.size);
    }
    { // the photo in a directory below that of the thumbnail
        const File tiff = create(file);
        const std::uint64_t none[1] = {0};
        TIFFSetField(tiff.get(), TIFFTAG_SUBIFD, 1, none);
        add(tiff.get(), thumbnail, FILETYPE_REDUCEDIMAGE);
        add(tiff.get(), photo, 0);
    }
    EXPECT_TRUE(samePicture(readImage(file), photoOf(photo, levels(photo)), 1));
    { // nothing but a thumbnail
        const File tiff = create(file);
        add(tiff.get(), thumbnail, FILETYPE_REDUCEDIMAGE);
    }
    EXPECT_EQ(readImage(file).size(), thumbnail.size);
}

TEST_F(Tiff, FurtherChannelsAreLeftOutWithANote) {
    const std::vector<std::pair<unsigned, unsigned>> kinds = {
        {PHOTOMETRIC_RGB, 5}, {PHOTOMETRIC_RGB, 7}, {PHOTOMETRIC_MINISBLACK, 2}};
    for (const auto& [photometric, samples] : kinds) {
        for (const bool isPlanar : {false, true}) {
            Kind kind;
            kind.photometric = photometric;
            kind.samples = samples;
            kind.isPlanar = isPlanar;
            kind.extras.resize(samples - (photometric == PHOTOMETRIC_RGB ? 3 : 1));
            write(file, kind, levels(kind));
            Notes notes;
            EXPECT_TRUE(samePicture(readImage(file, &notes), photoOf(kind, levels(kind)), 1));
            EXPECT_EQ(only(notes).text,
                      "the file has channels that are neither colours nor alpha (" +
                          std::to_string(kind.extras.size()) + "): they are left out");
        }
    }
}

TEST_F(Tiff, AlphaOfEachDepthIsComposedOverBlack) {
    for (const auto& [bits, format] : kDepths) {
        for (const unsigned colours : {1U, 3U}) {
            for (const unsigned place : {0U, 1U}) { // after a channel of another meaning
                Kind kind;
                kind.bits = bits;
                kind.format = format;
                kind.photometric = colours == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB;
                kind.samples = colours + place + 1;
                kind.extras.resize(place + 1);
                for (const unsigned type :
                     {unsigned{EXTRASAMPLE_UNASSALPHA}, unsigned{EXTRASAMPLE_ASSOCALPHA}}) {
                    kind.extras[place] = static_cast<std::uint16_t>(type);
                    // alpha is 1 on the left, 0 on the right
                    const Samples samples = [&](int x, int y, unsigned s) {
                        const bool isOpaque = x < 20;
                        if (s == colours + place) return isOpaque ? largestOf(kind) : 0;
                        return isOpaque || type == EXTRASAMPLE_UNASSALPHA ? levels(kind)(x, y, s)
                                                                          : 0;
                    };
                    write(file, kind, samples);
                    Kind shown = kind;
                    shown.samples = colours;
                    cv::Mat expected = photoOf(shown, samples);
                    expected.colRange(20, kind.size.width).setTo(0);
                    EXPECT_TRUE(samePicture(readPhoto(file), expected, 1)) << textOf(kind);
                }
            }
        }
    }
}

TEST_F(Tiff, PalettesOf8And16BitsGiveTheirColours) {
    for (const unsigned bits : {1U, 4U, 8U}) {
        for (const unsigned factor : {1U, 256U, 257U}) {
            Kind kind = greyKind(bits);
            kind.photometric = PHOTOMETRIC_PALETTE;
            const std::size_t count = std::size_t{1} << bits;
            std::vector<std::uint16_t> map[3];
            for (std::size_t i = 0; i < count; ++i) {
                for (std::size_t c = 0; c < 3; ++c)
                    map[c].push_back(static_cast<std::uint16_t>(
                        ((i * (50 * c + 3) + 60 * c) % 254 + 2) * factor));
            }
            {
                const File tiff = create(file);
                setFields(tiff.get(), kind);
                TIFFSetField(tiff.get(), TIFFTAG_COLORMAP, map[0].data(), map[1].data(),
                             map[2].data());
                writePage(tiff.get(), kind, levels(kind));
            }
            cv::Mat expected(kind.size, CV_8UC3);
            forPixels(expected.size(), [&](int x, int y) {
                const auto index = static_cast<std::size_t>(levels(kind)(x, y, 0));
                for (std::size_t c = 0; c < 3; ++c)
                    expected.at<cv::Vec3b>(y, x)[2 - static_cast<int>(c)] =
                        static_cast<std::uint8_t>(map[c][index] / factor);
            });
            EXPECT_TRUE(samePicture(readImage(file), expected)) << bits << " " << factor;
        }
    }
}

TEST_F(Tiff, InksBecomeColours) {
    for (const unsigned bits : {8U, 16U}) {
        for (const bool isPlanar : {false, true}) {
            Kind kind;
            kind.bits = bits;
            kind.samples = 4;
            kind.photometric = PHOTOMETRIC_SEPARATED;
            kind.isPlanar = isPlanar;
            const double inks[] = {200, 100, 50, 51};
            write(file, kind,
                  [&](int, int, unsigned s) { return inks[s] * largestOf(kind) / 255; });
            // (1 - ink) (1 - black), the black being a fifth
            EXPECT_EQ(photoPx(), cv::Vec3b(164, 124, 44)) << textOf(kind);
        }
    }
}

// Colours of CIE Lab at D50: sRGB's red, a grey of 128 and sRGB's blue, from the tables of others.
TEST_F(Tiff, LabOfBothKindsBecomesColours) {
    const cv::Vec3d labs[] = {{54.29, 80.80, 69.89}, {53.585, 0, 0}, {29.57, 68.29, -112.03}};
    const cv::Vec3b colours[] = {{0, 0, 255}, {128, 128, 128}, {255, 0, 0}};
    for (const unsigned bits : {8U, 16U}) {
        for (const unsigned photometric :
             {unsigned{PHOTOMETRIC_CIELAB}, unsigned{PHOTOMETRIC_ICCLAB}}) {
            for (int i = 0; i < 3; ++i) {
                Kind kind;
                kind.bits = bits;
                kind.photometric = photometric;
                const bool isIcc = photometric == PHOTOMETRIC_ICCLAB;
                const double step = bits == 8 ? 1 : 256;
                const double white = bits == 16 && isIcc ? 65280 : largestOf(kind);
                write(file, kind, [&](int, int, unsigned s) {
                    if (s == 0) return std::round(labs[i][0] / 100 * white);
                    const double value = std::round(labs[i][static_cast<int>(s)] * step);
                    return isIcc ? value + 128 * step : value;
                });
                // whole a* and b* are that coarse
                EXPECT_LE(cv::norm(photoPx(), colours[i], cv::NORM_INF), bits == 8 ? 6 : 1)
                    << textOf(kind) << photometric << " " << i << photoPx();
            }
        }
    }
}

// Red of a full range as YCbCr of Rec. 601, one pair of colours for 2 x 2 px.
TEST_F(Tiff, SampledYcbcrBecomesColours) {
    Kind kind;
    kind.photometric = PHOTOMETRIC_YCBCR;
    kind.size = {16, 8};
    {
        const File tiff = create(file);
        setFields(tiff.get(), kind);
        TIFFSetField(tiff.get(), TIFFTAG_YCBCRSUBSAMPLING, 2, 2);
        TIFFSetField(tiff.get(), TIFFTAG_ROWSPERSTRIP, 8);
        Bytes strip;
        for (int i = 0; i < 32; ++i) // luma of four px, blue, red
            for (const int value : {76, 76, 76, 76, 85, 255})
                strip.push_back(static_cast<std::uint8_t>(value));
        ASSERT_GT(
            TIFFWriteEncodedStrip(tiff.get(), 0, strip.data(), static_cast<tmsize_t>(strip.size())),
            0);
    }
    EXPECT_LE(
        cv::norm(readPhoto(file), cv::Mat(kind.size, CV_8UC3, cv::Scalar(0, 0, 254)), cv::NORM_INF),
        1);
}

// Light as X, Y, Z and as Y: a grey and sRGB's red.
TEST_F(Tiff, LogLuvBecomesColours) {
    Kind kind;
    kind.bits = 32;
    kind.format = SAMPLEFORMAT_IEEEFP;
    kind.compression = COMPRESSION_SGILOG;
    const auto make = [&](const Samples& samples) {
        const File tiff = create(file);
        setFields(tiff.get(), kind);
        TIFFSetField(tiff.get(), TIFFTAG_SGILOGDATAFMT, SGILOGDATAFMT_FLOAT);
        writePage(tiff.get(), kind, samples);
    };
    const double white[] = {0.9505, 1, 1.0891};
    const double red[] = {0.4124, 0.2126, 0.0193};
    kind.photometric = PHOTOMETRIC_LOGLUV;
    make([&](int x, int, unsigned s) { return x < 9 ? white[s] * 0.2158 : red[s]; });
    EXPECT_LE(cv::norm(photoPx(), cv::Vec3b::all(128), cv::NORM_INF), 2) << photoPx();
    const auto px = readPhoto(file).at<cv::Vec3b>(0, 20);
    EXPECT_GE(px[2], 250) << px;
    EXPECT_LE(px[1], 20) << px; // its steps are 0.3 % of the light
    kind.photometric = PHOTOMETRIC_LOGL;
    kind.samples = 1;
    make([](int, int, unsigned) { return 0.2158; });
    EXPECT_LE(cv::norm(photoPx(), cv::Vec3b::all(128), cv::NORM_INF), 1) << photoPx();
}

TEST_F(Tiff, JpegInTiffGivesItsColours) {
    if (TIFFIsCODECConfigured(COMPRESSION_JPEG) == 0) GTEST_SKIP() << "needs JPEG in libtiff";
    for (const unsigned photometric : {unsigned{PHOTOMETRIC_RGB}, unsigned{PHOTOMETRIC_YCBCR}}) {
        for (const bool isTiled : {false, true}) {
            Kind kind;
            kind.photometric = photometric;
            kind.compression = COMPRESSION_JPEG;
            kind.isTiled = isTiled;
            {
                const File tiff = create(file);
                setFields(tiff.get(), kind);
                TIFFSetField(tiff.get(), TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
                TIFFSetField(tiff.get(), TIFFTAG_JPEGQUALITY, 98);
                writePage(tiff.get(), kind, [](int, int, unsigned s) {
                    return s == 0 ? 220 : s == 1 ? 120 : 30;
                });
            }
            EXPECT_LE(cv::norm(photoPx(), cv::Vec3b(30, 120, 220), cv::NORM_INF), 3)
                << photometric << textOf(kind);
        }
    }
}

TEST_F(Tiff, KindsThatAreNotReadAreNamed) {
    const struct {
        unsigned bits, samples, photometric, format;
        const char* name;
    } cases[] = {
        {64, 3, PHOTOMETRIC_RGB, SAMPLEFORMAT_COMPLEXIEEEFP, "complex-number TIFF"},
        {24, 3, PHOTOMETRIC_RGB, SAMPLEFORMAT_UINT, "24-bit TIFF"},
        {24, 3, PHOTOMETRIC_RGB, SAMPLEFORMAT_IEEEFP, "24-bit float TIFF"},
        {32, 1, PHOTOMETRIC_MINISWHITE, SAMPLEFORMAT_IEEEFP, "32-bit float min-is-white TIFF"},
        {32, 1, PHOTOMETRIC_CFA, SAMPLEFORMAT_IEEEFP, "TIFF (photometric interpretation 32803)"},
        {8, 3, PHOTOMETRIC_SEPARATED, SAMPLEFORMAT_UINT, "TIFF (inks other than CMYK)"},
        {32, 4, PHOTOMETRIC_SEPARATED, SAMPLEFORMAT_UINT, "32-bit CMYK TIFF"},
        {32, 3, PHOTOMETRIC_CIELAB, SAMPLEFORMAT_UINT, "32-bit Lab TIFF"}};
    Kind kind;
    for (const auto& [bits, samples, photometric, format, name] : cases) {
        kind.bits = bits;
        kind.samples = samples;
        kind.photometric = photometric;
        kind.format = format;
        EXPECT_EQ(problemOf(kind), std::string(name) + " pictures are not read, expected an "
                                                       "ordinary TIFF file; convert it first");
    }
    kind = greyKind(16);
    kind.format = SAMPLEFORMAT_INT;
    EXPECT_EQ(problemOf(kind), "has signed whole numbers, expected numbers without sign or "
                               "floats; convert it first");
}

TEST_F(Tiff, ACutOffFileIsRefused) {
    for (const bool isTiled : {false, true}) {
        Kind kind;
        kind.isTiled = isTiled;
        write(file, kind, levels(kind));
        const std::string whole = slurp(file); // the directory stands at the end
        const std::size_t missing = 1000;
        spill(file, whole.substr(0, 8) + whole.substr(8 + missing)); // and its places are wrong
        EXPECT_TRUE(holds(errorOf([&] { readImage(file); }), "expected a whole TIFF file"));
    }
}

} // namespace
} // namespace altiro3D
