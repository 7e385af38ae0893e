#include "image/pixel_values.hpp"

#include "support/compare.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

// Among the sizes are blocks of 1 px, of unequal sizes, and of more than 2^23 px.
TEST(Downscale, TheResultIsTheRoundedMeanOfTheTouchedPx) {
    struct Case {
        cv::Size size;
        int longestSide;
    };
    for (const Case& c : {Case{{1, 1}, 1}, Case{{7, 5}, 7}, Case{{7, 5}, 6}, Case{{31, 47}, 2},
                          Case{{640, 3}, 320}, Case{{960, 540}, 320}, Case{{1001, 601}, 320},
                          Case{{3, 2000}, 64}, Case{{3000, 2900}, 1}, Case{{3000, 2900}, 2}}) {
        const cv::Mat photo = randomPicture(c.size, CV_8UC3, 7);
        EXPECT_TRUE(
            samePicture(downscale(photo, c.longestSide), referenceDownscale(photo, c.longestSide)))
            << c.size << " to " << c.longestSide;
        const cv::Mat white(c.size, CV_8UC3, cv::Scalar::all(255));
        EXPECT_EQ(cv::countNonZero(downscale(white, c.longestSide).reshape(1) != 255), 0);
    }
}

TEST(Downscale, ASubMatrixIsReadWithItsStep) {
    const cv::Mat frame = randomPicture({130, 91}, CV_8UC3, 8);
    const cv::Mat part = frame({11, 7, 101, 67});
    EXPECT_TRUE(samePicture(downscale(part, 40), referenceDownscale(part, 40)));
}

} // namespace
} // namespace altiro3D::test
