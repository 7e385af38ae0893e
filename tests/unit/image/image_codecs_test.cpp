#include "image/image_codecs.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

namespace altiro3D {
namespace {

using Bytes = std::vector<unsigned char>;

std::string_view viewOf(const Bytes& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Bytes encoded(const std::string& extension, const cv::Mat& image,
              const std::vector<int>& settings = {}) {
    Bytes bytes;
    EXPECT_TRUE(cv::imencode(extension, image, bytes, settings));
    return bytes;
}

bool areSame(const cv::Mat& a, const cv::Mat& b) {
    return a.size() == b.size() && a.type() == b.type() &&
           (a.empty() || cv::norm(a, b, cv::NORM_INF) == 0);
}

// What cv::imdecode() makes of the bytes; empty if it throws.
cv::Mat byOpenCv(const Bytes& bytes, int flags) {
    try {
        return cv::imdecode(bytes, flags | cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {
        return {};
    }
}

cv::Mat byUs(const Bytes& bytes, ImageChannels channels) {
    try {
        return decodeImage(viewOf(bytes), imageFormat(viewOf(bytes)), channels);
    } catch (const cv::Exception&) {
        return {};
    }
}

std::vector<Bytes> files() {
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
    std::vector<Bytes> files;
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
    for (const Bytes& file : files()) {
        const cv::Mat stored = byUs(file, ImageChannels::AsStored);
        EXPECT_FALSE(stored.empty());
        EXPECT_TRUE(areSame(stored, byOpenCv(file, cv::IMREAD_UNCHANGED))) << stored.type();
        EXPECT_TRUE(areSame(byUs(file, ImageChannels::Colour), byOpenCv(file, cv::IMREAD_COLOR)));
    }
}

TEST(ImageCodecs, NothingSurroundsALargePicture) {
    cv::Mat colour(2047, 2047, CV_8UC3); // its memory begins at a page of 2 MiB
    cv::randu(colour, 0, 256);
    cv::Mat wide;
    cv::copyMakeBorder(colour, wide, 9, 9, 9, 9, cv::BORDER_REFLECT_101);
    // The place of the page depends on where the allocator puts the block, hence several.
    std::vector<cv::Mat> kept;
    for (int i = 0; i < 6; ++i) {
        kept.push_back(byUs(encoded(".png", colour, {cv::IMWRITE_PNG_COMPRESSION, 0}),
                            ImageChannels::AsStored));
        cv::Mat ours;
        cv::copyMakeBorder(kept.back(), ours, 9, 9, 9, 9, cv::BORDER_REFLECT_101);
        EXPECT_TRUE(areSame(ours, wide));
    }
}

TEST(ImageCodecs, DamagedFilesGiveWhatOpenCvMakesOfThem) {
    std::mt19937 random(11);
    for (const Bytes& file : files()) {
        for (int i = 0; i < 60; ++i) {
            Bytes damaged = file;
            if (i % 3 == 0) {
                damaged.resize(
                    std::uniform_int_distribution<std::size_t>(2, file.size() - 1)(random));
                // as our reader ends a JPEG that is cut off
                damaged.push_back(0xff);
                damaged.push_back(0xd9);
            } else {
                // After the sizes: larger ones take long.
                std::uniform_int_distribution<std::size_t> place(file.size() / 3, file.size() - 1);
                for (int k = 0; k < i % 3; ++k)
                    damaged[place(random)] = static_cast<unsigned char>(random() % 256);
            }
            if (imageFormat(viewOf(damaged)) == ImageFormat::Unknown) continue;
            EXPECT_TRUE(areSame(byUs(damaged, ImageChannels::AsStored),
                                byOpenCv(damaged, cv::IMREAD_UNCHANGED)))
                << "file of " << file.size() << " bytes, damage " << i;
        }
    }
}

TEST(ImageCodecs, JpegIsWrittenAsOpenCvWritesIt) {
    cv::Mat colour(61, 83, CV_8UC3);
    cv::randu(colour, 0, 256);
    cv::Mat grey;
    cv::extractChannel(colour, grey, 1);
    const cv::Mat part = colour(cv::Rect(3, 5, 40, 31)); // rows with a gap
    for (const cv::Mat& image : {colour, grey, part}) {
        EXPECT_EQ(encodeJpeg(image), encoded(".jpg", image, {cv::IMWRITE_JPEG_QUALITY, 95}));
    }
    EXPECT_EQ(encodeJpeg(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(9))),
              encoded(".jpg", cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(9)),
                      {cv::IMWRITE_JPEG_QUALITY, 95}));
}

TEST(ImageCodecs, OtherFormatsAreWrittenByOpenCv) {
    cv::Mat colour(13, 17, CV_8UC3);
    cv::randu(colour, 0, 256);
    const Bytes bytes = encodeImage(colour, ".bmp");
    EXPECT_TRUE(areSame(cv::imdecode(bytes, cv::IMREAD_UNCHANGED), colour));
}

} // namespace
} // namespace altiro3D
