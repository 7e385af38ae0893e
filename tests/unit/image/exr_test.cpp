// EXR files by the names of their channels.

#include "image/exr_file.hpp"

#include "altiro3D/depth_source.hpp"
#include "altiro3D/image_io.hpp"
#include "image/image_header.hpp"
#include "image/opencv_codecs.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/picture_files.hpp"

#include <gtest/gtest.h>
#include <map>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

constexpr int kColumns = 40;
constexpr int kRows = 30;

// 9 m at the left to 1 m at the right
cv::Mat distances() {
    cv::Mat z(kRows, kColumns, CV_32FC1);
    for (int x = 0; x < kColumns; ++x)
        z.col(x).setTo(9 - 8.0 * x / (kColumns - 1));
    return z;
}

const cv::Mat kGrey(kRows, kColumns, CV_32FC1, cv::Scalar(0.3));

std::string attribute(const std::string& name, const std::string& type, const std::string& value) {
    return name + '\0' + type + '\0' + littleEndian(static_cast<unsigned>(value.size()), 4) + value;
}

std::string boxOf(const cv::Rect& r) {
    std::string text;
    for (const int side : {r.x, r.y, r.x + r.width - 1, r.y + r.height - 1})
        text += littleEndian(static_cast<unsigned>(side), 4);
    return text;
}

// Without compression: lines of all channels, by their names. @param window display window
std::string exrFile(const std::map<std::string, cv::Mat>& channels, cv::Point at = {},
                    cv::Rect window = {}) {
    const cv::Mat& first = channels.begin()->second;
    const cv::Rect data(at, first.size());
    std::string list;
    for (const auto& [name, values] : channels) {
        const unsigned type = values.depth() == CV_16F ? 1 : values.depth() == CV_32S ? 0 : 2;
        list += name + '\0' + littleEndian(type, 4) + littleEndian(0, 4) + littleEndian(1, 4) +
                littleEndian(1, 4);
    }
    std::string file =
        "\x76\x2f\x31\x01" + littleEndian(2, 4) + attribute("channels", "chlist", list + '\0') +
        attribute("compression", "compression", std::string(1, '\0')) +
        attribute("dataWindow", "box2i", boxOf(data)) +
        attribute("displayWindow", "box2i", boxOf(window.empty() ? data : window)) +
        attribute("lineOrder", "lineOrder", std::string(1, '\0')) +
        attribute("pixelAspectRatio", "float", std::string("\0\0\x80\x3f", 4)) +
        attribute("screenWindowCenter", "v2f", std::string(8, '\0')) +
        attribute("screenWindowWidth", "float", std::string("\0\0\x80\x3f", 4)) + '\0';
    std::string lines;
    const std::size_t start = file.size() + 8 * static_cast<std::size_t>(data.height);
    for (int y = 0; y < data.height; ++y) {
        std::string line;
        for (const auto& [name, values] : channels)
            line.append(values.ptr<char>(y),
                        values.elemSize() * static_cast<std::size_t>(data.width));
        file += littleEndian(static_cast<unsigned>(start + lines.size()), 4) + std::string(4, '\0');
        lines += littleEndian(static_cast<unsigned>(y + at.y), 4) +
                 littleEndian(static_cast<unsigned>(line.size()), 4) + line;
    }
    return file + lines;
}

std::map<std::string, cv::Mat> photoWith(const std::string& layer,
                                         std::map<std::string, cv::Mat> more) {
    for (const char* const channel : {"R", "G", "B"})
        more[layer + channel] = kGrey;
    more[layer + "A"] = cv::Mat(kGrey.size(), CV_32FC1, cv::Scalar(1));
    return more;
}

class Exr : public FileTest {
  protected:
    void SetUp() override {
        if (openCvCodecs().exrChannels == nullptr)
            GTEST_SKIP() << "needs OpenEXR, which this build does not have";
    }
    std::filesystem::path file(const std::string& contents) const {
        spill(directory / "a.exr", contents);
        return directory / "a.exr";
    }
    Notes notes;
};

TEST_F(Exr, DepthIsReadByTheNameOfItsChannel) {
    const cv::Mat z = distances();
    for (const char* const name :
         {"Z", "V", "Y", "Depth.V", "ViewLayer.Depth.Z", "depth", "anything"})
        EXPECT_TRUE(samePicture(readDepthSamples(file(exrFile({{name, z}})), &notes), z)) << name;
    cv::Mat half;
    z.convertTo(half, CV_16F);
    EXPECT_LT(cv::norm(readDepthSamples(file(exrFile({{"Z", half}}))), z, cv::NORM_INF), 0.004);
    cv::Mat millimetres;
    z.convertTo(millimetres, CV_32S, 1000);
    EXPECT_LT(
        cv::norm(readDepthSamples(file(exrFile({{"Z", millimetres}}))), z * 1000, cv::NORM_INF),
        0.51);
    const cv::Mat other = z + 1;
    EXPECT_TRUE(samePicture(readDepthSamples(file(exrFile(photoWith("", {{"Z", z}}))), &notes), z));
    EXPECT_TRUE(notes.empty());
    const auto layers = photoWith("ViewLayer.Combined.", {{"ViewLayer.Depth.Z", z},
                                                          {"Other.Depth.V", other},
                                                          {"ViewLayer.Normal.X", other},
                                                          {"ViewLayer.Normal.Y", other},
                                                          {"ViewLayer.Normal.Z", other}});
    EXPECT_TRUE(samePicture(readDepthSamples(file(exrFile(layers)), &notes), other));
    EXPECT_EQ(only(notes).text, "several of its channels may be depth: Other.Depth.V is read, and "
                                "not ViewLayer.Depth.Z");
    EXPECT_TRUE(holds(errorOf([&] {
                          readDepthSamples(file(exrFile({{"u", z}, {"w", z}})));
                      }),
                      "its channels are u, w; of these, none is named as depth"));
}

TEST_F(Exr, APhotoBringsItsDistances) {
    const cv::Mat z = distances();
    for (const char* const layer : {"", "ViewLayer.Combined."}) {
        const std::string depth = *layer == '\0' ? "Z" : "ViewLayer.Depth.V";
        const auto picture = file(exrFile(photoWith(layer, {{depth, z}})));
        // 0.3 of light is level 149 of sRGB
        EXPECT_LE(cv::norm(readPhoto(picture, &notes),
                           cv::Mat(z.size(), CV_8UC3, cv::Scalar::all(149)), cv::NORM_INF),
                  1);
        const auto found = readEmbeddedDepth(picture, &notes);
        ASSERT_TRUE(found);
        EXPECT_EQ(found->text(), "EXR, 40 x 30 px");
        EXPECT_LT(cv::norm(found->depth, 1 / z, cv::NORM_INF), 1e-6); // the nearest is 1 m
        EXPECT_TRUE(notes.empty());
    }
    cv::Mat holes = z.clone();
    holes.col(3).setTo(0);
    holes.col(4).setTo(1e10);
    const auto found = readEmbeddedDepth(file(exrFile(photoWith("", {{"Z", holes}}))));
    ASSERT_TRUE(found);
    EXPECT_TRUE(std::isnan(found->depth.at<float>(0, 3)));
    EXPECT_NEAR(found->depth.at<float>(0, 4), 0, 1e-6);
    EXPECT_FALSE(readEmbeddedDepth(file(exrFile(photoWith("", {})))));
    EXPECT_FALSE(readEmbeddedDepth(file(exrFile({{"Z", z}}))));
    EXPECT_TRUE(holds(errorOf([&] { readPhoto(directory / "a.exr"); }), "its channels are Z"));
}

TEST_F(Exr, ThePictureIsTheDisplayWindow) {
    const cv::Mat z = distances();
    const cv::Rect window(-5, 10, 20, 30); // the data are at 2, 3
    const cv::Mat read = readDepthSamples(file(exrFile({{"Z", z}}, {2, 3}, window)));
    cv::Mat expected = cv::Mat::zeros(window.size(), CV_32FC1);
    z(cv::Rect(0, 7, 13, 23)).copyTo(expected(cv::Rect(7, 0, 13, 23)));
    EXPECT_TRUE(samePicture(read, expected));
    EXPECT_EQ(readImageHeader(exrFile({{"Z", z}}, {2, 3}, window), "").columns, 20U);
}

TEST_F(Exr, DistancesThatCountAsNearAreReported) {
    spill(directory / "z.exr", exrFile({{"Z", distances()}}));
    spill(directory / "p.png", encoded(".png", cv::Mat(kRows, kColumns, CV_8UC3)));
    depthFromFile(directory / "z.exr", DepthKind::Metric)->readPhoto(directory / "p.png", &notes);
    EXPECT_TRUE(notes.empty());
    depthFromFile(directory / "z.exr", DepthKind::NearWhite)
        ->readPhoto(directory / "p.png", &notes);
    EXPECT_TRUE(holds(only(notes).text, "its channel Z holds distances by its name"));
}

TEST_F(Exr, DamagedFilesAreOneError) {
    const std::string whole = exrFile(photoWith("", {{"Z", distances()}}));
    cv::RNG random(5);
    for (int trial = 0; trial < 300; ++trial) {
        std::string bytes = whole;
        for (int i = 0; i < 3; ++i)
            bytes[static_cast<std::size_t>(random.uniform(0, 900))] =
                static_cast<char>(random.uniform(0, 256));
        if (trial % 3 == 0) bytes.resize(static_cast<std::size_t>(random.uniform(8, 9000)));
        const auto damaged = file(bytes);
        errorOf([&] { return readPhoto(damaged); });
        errorOf([&] { return readDepthSamples(damaged); });
        EXPECT_NO_THROW(static_cast<void>(readEmbeddedDepth(damaged)));
    }
}

} // namespace
} // namespace altiro3D::test
