#include "media/video_picture.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/video_io.hpp"
#include "support/files.hpp"
#include "support/reference.hpp"
#include "support/video.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <string>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr int kBt2020 = 9;
constexpr int kP3 = 12;
constexpr int kLinear = 8;
constexpr int kSrgbCurve = 13;
constexpr int kPq = 16;
constexpr int kHlg = 18;

// The colour of a table for BGR of 0..1.
cv::Vec3b converted(const ColourTable& table, const cv::Vec3d& bgr) {
    std::uint16_t from[3];
    for (int c = 0; c < 3; ++c)
        from[c] = static_cast<std::uint16_t>(std::lround(std::clamp(bgr[c], 0.0, 1.0) * 65535));
    cv::Vec3b to;
    table.row(from, 3, 1, to.val);
    return to;
}

// The largest difference in levels from a reference of colours between the nodes.
template <class Reference>
double worst(const ColourTable& table, const Reference& reference) {
    double most = 0;
    cv::RNG random(5);
    for (int i = 0; i < 4000; ++i) {
        const cv::Vec3d bgr{random.uniform(0.0, 1.0), random.uniform(0.0, 1.0),
                            random.uniform(0.0, 1.0)}; // in this order for all compilers
        const cv::Vec3d expected = reference(bgr);
        const cv::Vec3b made = converted(table, bgr);
        for (int c = 0; c < 3; ++c)
            most = std::max(most, std::abs(255 * expected[c] - made[c]));
    }
    return most;
}

// An sRGB colour, BGR of 0..255, as HDR of a white of 203 cd/m² (BT.2100, BT.2408).
cv::Vec3d asHdr(const cv::Vec3d& bgr, int transfer) {
    const cv::Vec3d rgb(referenceLight(bgr[2] / 255), referenceLight(bgr[1] / 255),
                        referenceLight(bgr[0] / 255));
    cv::Vec3d nits = 203 * (referenceXyz(kRec2020).inv() * referenceXyz(kSrgb) * rgb);
    cv::Vec3d coded;
    for (int i = 0; i < 3; ++i) {
        double value = std::max(nits[i], 0.0);
        if (transfer == kPq) {
            value = referencePq(value);
        } else { // the scene's light, of a display of 1000 cd/m² with the gamma 1.2
            value = std::pow(value / 1000, 1 / 1.2);
            value = value <= 1.0 / 12 ? std::sqrt(3 * value)
                                      : 0.17883277 * std::log(12 * value - 0.28466892) + 0.55991073;
        }
        coded[2 - i] = value;
    }
    return coded;
}

TEST(ColourTable, WideGamutBecomesSrgb) {
    EXPECT_LE(worst(ColourTable(kP3, kSrgbCurve),
                    [](const cv::Vec3d& bgr) { return referenceSrgb(bgr, kDisplayP3, 0); }),
              1.5); // rounding and the table
    EXPECT_LE(worst(ColourTable(1, kLinear),
                    [](const cv::Vec3d& bgr) { return referenceSrgb(bgr, kSrgb, 1); }),
              1.5);
    const cv::Matx33d toRec709 = referenceXyz(kSrgb).inv() * referenceXyz(kRec2020);
    const auto video = [&](const cv::Vec3d& bgr) {
        const cv::Vec3d light = toRec709 * cv::Vec3d(std::pow(bgr[2], 2.4), std::pow(bgr[1], 2.4),
                                                     std::pow(bgr[0], 2.4));
        cv::Vec3d result;
        for (int i = 0; i < 3; ++i)
            result[2 - i] = std::pow(std::clamp(light[i], 0.0, 1.0), 1 / 2.4);
        return result;
    };
    EXPECT_LE(worst(ColourTable(kBt2020, 14), video), 4); // the power is steep at black
}

TEST(ColourTable, HdrIsAsBrightAsOtherVideo) {
    for (const int transfer : {kPq, kHlg}) {
        const ColourTable table(kBt2020, transfer);
        const cv::Vec3d colours[] = {
            {0, 0, 220}, {0, 200, 0}, {200, 40, 10}, {90, 90, 90}, {0, 0, 0}};
        for (const cv::Vec3d& colour : colours) {
            const cv::Vec3b made = converted(table, asHdr(colour, transfer));
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(made[c], colour[c], 4) << colour << " " << transfer;
        }
        const cv::Vec3b white = converted(table, asHdr({255, 255, 255}, transfer));
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(white[c], 253.3, 1.5) << transfer;
        // brighter light is brighter still, and ends at white
        int last = 0;
        for (int i = 0; i <= 1000; ++i) {
            const cv::Vec3b grey = converted(table, cv::Vec3d::all(i / 1000.0));
            EXPECT_GE(grey[1], last);
            last = grey[1];
        }
        EXPECT_EQ(last, 255);
    }
}

TEST(ColourTable, WithoutOneColoursStayAndAlphaIsOverBlack) {
    const std::uint16_t from[] = {0,     257,   65535, 65535, 100 * 257, 200 * 257,
                                  65535, 32768, 65535, 65535, 65535,     0};
    std::uint8_t to[9];
    ColourTable().row(from, 4, 3, to);
    const std::uint8_t expected[] = {0, 1, 255, 50, 100, 128, 0, 0, 0};
    EXPECT_TRUE(std::equal(to, to + 9, expected));
}

struct TaggedVideo {
    const char* codec;
    const char* primariesName;
    const char* transferName;
    int primaries;
    int transfer;

    // FFmpeg 5 takes tags from the options of the codec, FFmpeg 7 from the frames.
    std::string filter() const {
        return std::string("setparams=color_primaries=") + primariesName +
               ":color_trc=" + transferName;
    }
    std::string options() const {
        return std::string(codec) + " -color_primaries " + primariesName + " -color_trc " +
               transferName;
    }
};

class TaggedVideos : public FfmpegTest, public testing::WithParamInterface<TaggedVideo> {};

// Files of a colour whose encoded values are known, in RGB and with subsampled chroma.
TEST_P(TaggedVideos, AreConvertedAndTheirCopyIsNotTagged) {
    const TaggedVideo& video = GetParam();
    ffmpeg("-f lavfi -i color=0xC83C28:size=64x48:rate=5:duration=0.4 -vf "
           "scale=out_color_matrix=bt2020," +
           video.filter() + " " + video.options() + " " + arg(directory / "tagged.mkv"));
    VideoReader reader(directory / "tagged.mkv");
    const auto frame = reader.next();
    ASSERT_TRUE(frame);
    const cv::Vec3b expected =
        converted(ColourTable(video.primaries, video.transfer), cv::Vec3d(0x28, 0x3C, 0xC8) / 255);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(frame->picture.at<cv::Vec3b>(20, 30)[c], expected[c], 5) << c;
    EXPECT_EQ(reader.notes().size(), video.transfer >= kPq ? 1U : 0U);

    // depth is not converted
    VideoReaderOptions options;
    options.isDepth = true;
    const cv::Mat depth = VideoReader(directory / "tagged.mkv", options).next()->picture;
    const cv::Vec3b stored(0x28, 0x3C, 0xC8);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(depth.at<cv::Vec3b>(20, 30)[c], stored[c], 3) << c;

    VideoWriterOptions encoding;
    encoding.size = frame->picture.size();
    VideoReader source(directory / "tagged.mkv");
    VideoWriter writer(directory / "copy.mkv", encoding, &source);
    writer.write({frame->picture, 0, 200});
    writer.finish();
    const std::string tags = ffprobe(directory / "copy.mkv",
                                     "stream=color_primaries,color_transfer", "-select_streams v");
    EXPECT_FALSE(holds(tags, "2020"));
    EXPECT_FALSE(holds(tags, "smpte"));
    EXPECT_FALSE(holds(tags, "arib"));
}

INSTANTIATE_TEST_SUITE_P(
    Tagged, TaggedVideos,
    testing::Values(
        TaggedVideo{"-c:v libx264 -crf 4 -pix_fmt yuv420p -colorspace bt2020nc", "bt2020", "bt709",
                    kBt2020, 1},
        TaggedVideo{"-c:v libx265 -crf 4 -x265-params log-level=none -pix_fmt yuv420p10le "
                    "-colorspace bt2020nc",
                    "bt2020", "arib-std-b67", kBt2020, kHlg},
        TaggedVideo{"-c:v libx265 -crf 4 -x265-params log-level=none -pix_fmt yuv420p10le "
                    "-colorspace bt2020nc",
                    "bt2020", "smpte2084", kBt2020, kPq},
        TaggedVideo{"-c:v ffv1 -pix_fmt bgr0", "smpte432", "iec61966-2-1", kP3, kSrgbCurve}));

struct TransparentVideo {
    const char* name;
    const char* codec;
};

class TransparentVideos : public FfmpegTest,
                          public testing::WithParamInterface<TransparentVideo> {};

// Magenta, transparent in the left half.
TEST_P(TransparentVideos, AreBlackWhereTheyAreTransparent) {
    const fs::path file = directory / GetParam().name;
    ffmpeg("-f lavfi -i color=0xE020E0:size=64x48:rate=5:duration=0.4 -vf "
           "\"format=rgba,geq=r='r(X,Y)':g='g(X,Y)':b='b(X,Y)':a='if(lt(X,32),0,255)'\" " +
           std::string(GetParam().codec) + " " + arg(file));
    VideoReader reader(file);
    const auto frame = reader.next();
    ASSERT_TRUE(frame);
    EXPECT_TRUE(reader.notes().empty());
    const cv::Vec3b colour(0xE0, 0x20, 0xE0);
    for (int c = 0; c < 3; ++c) {
        EXPECT_LE(frame->picture.at<cv::Vec3b>(20, 10)[c], 1) << c;
        EXPECT_NEAR(frame->picture.at<cv::Vec3b>(20, 50)[c], colour[c], 5) << c;
    }
}

// Where nothing is transparent, white and black are those of the same video without alpha.
TEST_P(TransparentVideos, KeepWhiteWhereTheyAreOpaque) {
    const fs::path file = directory / GetParam().name;
    ffmpeg("-f lavfi -i color=white:size=64x48:rate=5:duration=0.4 -vf "
           "format=rgba,drawbox=0:0:32:48:black@1:fill " +
           std::string(GetParam().codec) + " " + arg(file));
    VideoReader reader(file);
    const auto frame = reader.next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->picture.at<cv::Vec3b>(20, 50), cv::Vec3b::all(255));
    EXPECT_EQ(frame->picture.at<cv::Vec3b>(20, 10), cv::Vec3b::all(0));
}

INSTANTIATE_TEST_SUITE_P(
    Transparent, TransparentVideos,
    testing::Values(TransparentVideo{"a.mov", "-c:v prores_ks -pix_fmt yuva444p10le"},
                    TransparentVideo{"b.mov", "-c:v qtrle -pix_fmt argb"},
                    TransparentVideo{"c.webm", "-c:v libvpx-vp9 -pix_fmt yuva420p"},
                    TransparentVideo{"d.mkv", "-c:v ffv1 -pix_fmt yuva420p"},
                    TransparentVideo{"e.mov", "-c:v png -pix_fmt rgba"},
                    TransparentVideo{"f.mkv", "-c:v ffv1 -pix_fmt bgra"},
                    TransparentVideo{"g.mkv", "-c:v ffv1 -pix_fmt yuva444p"},
                    TransparentVideo{"h.mov", "-c:v png -pix_fmt rgba64be"}));

// An MP4 file of HEVC that states a profile of Dolby Vision.
std::string withDolbyVision(std::string bytes, int profile, int compatible) {
    std::string box("\0\0\0\x20"
                    "dvcC\1\0",
                    10);
    const int level = 3;
    box += static_cast<char>(profile << 1);
    box += static_cast<char>(level << 3 | 5); // metadata and base layer are present
    box += static_cast<char>(compatible << 4);
    box.resize(32, '\0');
    const std::size_t at = bytes.find("hvcC") - 4;
    for (const char* parent : {"moov", "trak", "mdia", "minf", "stbl", "stsd", "hev1"}) {
        const std::size_t size = bytes.find(parent) - 4; // below 2^16
        const int now = (static_cast<unsigned char>(bytes[size + 2]) << 8) +
                        static_cast<unsigned char>(bytes[size + 3]) + 32;
        bytes[size + 2] = static_cast<char>(now >> 8);
        bytes[size + 3] = static_cast<char>(now);
    }
    return bytes.insert(at, box);
}

class DolbyVision : public FfmpegTest {};

TEST_F(DolbyVision, IsReadByItsBaseLayerOrRefused) {
    ffmpeg("-f lavfi -i color=gray:size=64x48:rate=5:duration=0.4 -c:v libx265 -x265-params "
           "log-level=none -pix_fmt yuv420p10le -color_primaries bt2020 -color_trc arib-std-b67 "
           "-colorspace bt2020nc " +
           arg(directory / "hlg.mp4"));
    const std::string bytes = slurp(directory / "hlg.mp4");
    spill(directory / "8.mp4", withDolbyVision(bytes, 8, 4));
    EXPECT_EQ(VideoReader(directory / "8.mp4").next()->picture.at<cv::Vec3b>(9, 9),
              VideoReader(directory / "hlg.mp4").next()->picture.at<cv::Vec3b>(9, 9));
    spill(directory / "5.mp4", withDolbyVision(bytes, 5, 0));
    const auto read = [&] { VideoReader{directory / "5.mp4"}; };
    EXPECT_EQ(codeOf(read), ErrorCode::Unsupported);
    EXPECT_TRUE(holds(errorOf(read), "Dolby Vision of profile 5"));
}

} // namespace
} // namespace altiro3D::test
