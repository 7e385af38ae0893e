#include "altiro3D/qt/image.hpp"

#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"

#include <QColor>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

cv::Mat noise(int cols, int rows, int type = CV_8UC3) {
    return randomPicture({cols, rows}, type, 3);
}

TEST(QtImage, SharesThePicturesMemoryAndShowsItsColours) {
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 3), cv::Size(37, 11)}) {
        const cv::Mat picture = noise(size.width, size.height);
        const QImage image = qt::toImage(picture);
        ASSERT_EQ(image.size(), QSize(size.width, size.height));
        EXPECT_EQ(image.constBits(), picture.data);
        for (int y = 0; y < size.height; ++y) {
            for (int x = 0; x < size.width; ++x) {
                const cv::Vec3b& px = picture.at<cv::Vec3b>(y, x);
                EXPECT_EQ(image.pixelColor(x, y), QColor(px[2], px[1], px[0]));
            }
        }
    }
}

TEST(QtImage, WhatIsDrawnIntoTheImageLeavesThePictureAlone) {
    const cv::Mat picture = noise(5, 4);
    const cv::Mat before = picture.clone();
    QImage image = qt::toImage(picture);
    image.fill(Qt::red);
    EXPECT_TRUE(samePicture(picture, before));
    EXPECT_NE(image.constBits(), picture.data);
}

TEST(QtImage, TheMemoryOutlivesThePicture) {
    cv::Mat picture = noise(50, 40);
    const cv::Mat expected = picture.clone();
    const QImage image = qt::toImage(picture);
    picture.release();
    EXPECT_TRUE(samePicture(qt::toPicture(image), expected));
}

TEST(QtImage, SubMatricesAndGreyPicturesAreFine) {
    const cv::Mat picture = noise(50, 40);
    const cv::Mat part = picture(cv::Rect(7, 5, 13, 9));
    const QImage image = qt::toImage(part);
    EXPECT_EQ(image.constBits(), part.data);
    EXPECT_TRUE(samePicture(qt::toPicture(image), part));
    const cv::Mat grey = noise(5, 4, CV_8UC1);
    EXPECT_EQ(qt::toImage(grey).pixelColor(3, 2).green(), grey.at<uchar>(2, 3));
}

TEST(QtImage, AnyImageBecomesAPictureOnBlack) {
    QImage image(2, 1, QImage::Format_ARGB32);
    image.setPixelColor(0, 0, QColor(10, 20, 30));
    image.setPixelColor(1, 0, QColor(200, 200, 200, 0));
    image.setDevicePixelRatio(2);
    const cv::Mat picture = qt::toPicture(image);
    ASSERT_EQ(picture.size(), cv::Size(2, 1));
    EXPECT_EQ(picture.at<cv::Vec3b>(0, 0), cv::Vec3b(30, 20, 10));
    EXPECT_EQ(picture.at<cv::Vec3b>(0, 1), cv::Vec3b(0, 0, 0));
}

TEST(QtImage, EmptyBecomesNullAndOtherTypesAreErrors) {
    EXPECT_TRUE(qt::toImage({}).isNull());
    EXPECT_TRUE(qt::toPicture({}).empty());
    EXPECT_EQ(errorOf([] { qt::toImage(cv::Mat(2, 2, CV_16UC3)); }),
              "picture: is of CV_16UC3, expected 8-bit BGR or grey");
}

} // namespace
} // namespace altiro3D::test
