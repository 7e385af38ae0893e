#include "image/image_codecs.hpp"

#include "support/compare.hpp"
#include "support/picture_files.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

namespace altiro3D::test {
namespace {

cv::Mat byUs(const std::string& bytes, ImageChannels channels) {
    try {
        return decodeImage(bytes, imageFormat(bytes), channels);
    } catch (const cv::Exception&) {
        return {};
    }
}

std::vector<std::string> files() {
    cv::Mat colour(61, 83, CV_8UC3);
    cv::randu(colour, 0, 256);
    cv::GaussianBlur(colour, colour, {}, 2);
    cv::Mat grey;
    cv::extractChannel(colour, grey, 1);
    cv::Mat deep(61, 83, CV_16UC3);
    cv::randu(deep, 0, 65536);
    cv::Mat deepGrey;
    cv::extractChannel(deep, deepGrey, 0);
    cv::Mat alpha(61, 83, CV_8UC4);
    cv::randu(alpha, 0, 256);
    cv::Mat deepAlpha(61, 83, CV_16UC4);
    cv::randu(deepAlpha, 0, 65536);
    std::vector<std::string> files;
    for (const cv::Mat& image : {colour, grey}) {
        files.push_back(encoded(".jpg", image));
        files.push_back(encoded(".jpg", image, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
        files.push_back(encoded(".jpg", image, {cv::IMWRITE_JPEG_RST_INTERVAL, 2}));
        files.push_back(encoded(".jpg", image, {cv::IMWRITE_JPEG_QUALITY, 20}));
    }
    for (const cv::Mat& image : {colour, grey, deep, deepGrey, alpha, deepAlpha})
        files.push_back(encoded(".png", image));
    cv::Mat bits = grey > 128;
    files.push_back(encoded(".png", bits, {cv::IMWRITE_PNG_BILEVEL, 1}));
    files.push_back(encoded(".bmp", colour));
    return files;
}

TEST(ImageCodecs, FilesAreDecodedToTheBitsOfOpenCv) {
    for (const std::string& file : files()) {
        const cv::Mat stored = byUs(file, ImageChannels::AsStored);
        EXPECT_TRUE(samePicture(stored, decoded(file, cv::IMREAD_UNCHANGED))) << stored.type();
        EXPECT_TRUE(samePicture(byUs(file, ImageChannels::Colour), decoded(file)));
    }
}

TEST(ImageCodecs, DamagedFilesGiveWhatOpenCvMakesOfThem) {
    std::mt19937 random(11);
    for (const std::string& file : files()) {
        for (int i = 0; i < 60; ++i) {
            std::string damaged = file;
            if (i % 3 == 0) {
                damaged.resize(
                    std::uniform_int_distribution<std::size_t>(2, file.size() - 1)(random));
                // as our reader ends a JPEG that is cut off
                damaged += "\xff\xd9";
            } else {
                // After the sizes: larger ones take long.
                std::uniform_int_distribution<std::size_t> place(file.size() / 3, file.size() - 1);
                for (int k = 0; k < i % 3; ++k)
                    damaged[place(random)] = static_cast<char>(random() % 256);
            }
            if (imageFormat(damaged) == ImageFormat::Unknown) continue;
            const cv::Mat ours = byUs(damaged, ImageChannels::AsStored);
            const cv::Mat expected = decoded(damaged, cv::IMREAD_UNCHANGED);
            EXPECT_TRUE((ours.empty() && expected.empty()) || samePicture(ours, expected))
                << "file of " << file.size() << " bytes, damage " << i;
        }
    }
}

} // namespace
} // namespace altiro3D::test
