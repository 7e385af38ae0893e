#include "altiro3D/video_io.hpp"
#include "image/pixel_values.hpp"
#include "support/files.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"
#include "video/motion/motion.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

using namespace altiro3D;
using namespace altiro3D::test;

namespace {

std::vector<cv::Mat> pictures(const std::string& clip, std::size_t most = 1000) {
    VideoReader reader(dataPath("videos/" + clip));
    std::vector<cv::Mat> result;
    while (result.size() < most) {
        auto frame = reader.next();
        if (!frame) break;
        result.push_back(frame->picture);
    }
    return result;
}

std::vector<int> cutsOf(const std::vector<cv::Mat>& clip) {
    PictureTracker tracker;
    std::vector<int> found;
    for (std::size_t i = 0; i < clip.size(); ++i)
        if (tracker.next(clip[i]).cut) found.push_back(static_cast<int>(i));
    return found;
}

// A part of a large noise picture, as a camera that moves over it sees it.
cv::Mat seenFrom(const cv::Mat& world, int x, int y, cv::Size size = {320, 180}) {
    return world(cv::Rect(cv::Point(x, y), size)).clone();
}

cv::Mat greyNoise(cv::Size size, int seed) {
    return brightnessOf(randomPhoto(size, seed, 3));
}

} // namespace

// --- Motion --------------------------------------------------------------------------------------

TEST(FindMotion, FindsAWholeShift) {
    const cv::Mat world = greyNoise(cv::Size(400, 300), 5);
    const cv::Rect start(60, 60, 192, 108);
    for (const cv::Point shift : {cv::Point(0, 0), cv::Point(3, 0), cv::Point(-2, 5),
                                  cv::Point(17, -11), cv::Point(-1, 20)}) {
        const cv::Mat before = world(start).clone();
        const cv::Mat now = world(start + shift).clone(); // x now was at x + shift before
        cv::Mat motion;
        findMotion(before, now, motion);
        ASSERT_EQ(motion.size(), now.size());
        int right = 0;
        int all = 0;
        for (int y = 24; y < now.rows - 24; ++y) {
            for (int x = 24; x < now.cols - 24; ++x, ++all) {
                const cv::Vec2f vector = motion.at<cv::Vec2f>(y, x);
                right += std::hypot(vector[0] - static_cast<float>(shift.x),
                                    vector[1] - static_cast<float>(shift.y)) < 0.3F
                             ? 1
                             : 0;
            }
        }
        EXPECT_GT(right, all * 97 / 100) << shift;
    }
}

TEST(FindMotion, IsExactlyZeroWhereNothingMovesDespiteNoiseAndExposure) {
    const cv::Mat before = greyNoise(cv::Size(192, 108), 5);
    cv::Mat now = before * 0.9;
    now += randomPicture(now.size(), CV_8UC1, 1, 0, 3);
    cv::Mat motion;
    findMotion(before, now, motion);
    EXPECT_EQ(cv::norm(motion, cv::NORM_INF), 0);
    EXPECT_LT(cv::mean(misfit(before, now, motion))[0], 2.5);
}

TEST(PictureHash, DiffersForOneBitAndForOtherOrders) {
    cv::Mat picture = randomPhoto(cv::Size(37, 11));
    const std::uint64_t hash = pictureHash(picture);
    EXPECT_EQ(pictureHash(picture.clone()), hash);
    for (int i = 0; i < 37 * 3; ++i) {
        cv::Mat changed = picture.clone();
        changed.ptr(i % 11)[i] ^= static_cast<uchar>(1U << static_cast<unsigned>(i % 8));
        EXPECT_NE(pictureHash(changed), hash) << i;
    }
    cv::Mat turned;
    cv::flip(picture, turned, 0);
    EXPECT_NE(pictureHash(turned), hash);
}

// --- Cuts ----------------------------------------------------------------------------------------

TEST(SceneCuts, ThePicturesOfAMovingCameraAreOneScene) {
    const cv::Mat world = scenery(cv::Size(900, 500), 4);
    std::vector<cv::Mat> clip;
    for (int i = 0; i < 20; ++i)
        clip.push_back(seenFrom(world, 20 * i, 5 * i));
    EXPECT_EQ(cutsOf(clip), std::vector<int>{0});
}

TEST(SceneCuts, AnotherPictureOrSizeIsACut) {
    const cv::Mat a = scenery(cv::Size(320, 180), 1);
    const cv::Mat b = scenery(cv::Size(320, 180), 2);
    const cv::Mat c = scenery(cv::Size(320, 200), 2);
    EXPECT_EQ(cutsOf({a, a, a, b, b, c, c, a}), (std::vector<int>{0, 3, 5, 7}));
}

TEST(SceneCuts, FlashesBlackAndFadesAreNone) {
    const cv::Mat a = scenery(cv::Size(320, 180), 1);
    const cv::Mat b = scenery(cv::Size(320, 180), 2);
    const cv::Mat white(a.size(), CV_8UC3, cv::Scalar::all(255));
    const cv::Mat black(a.size(), CV_8UC3, cv::Scalar::all(0));
    const cv::Mat bright = a * 1.3;
    EXPECT_EQ(cutsOf({a, white, a, black, black, a, bright, a}), std::vector<int>{0});
    // out of one scene over black into another: where the other begins to show
    std::vector<cv::Mat> clip;
    for (int i = 10; i >= 0; --i)
        clip.push_back(a * (i / 10.0));
    for (int i = 1; i <= 10; ++i)
        clip.push_back(b * (i / 10.0));
    const std::vector<int> cuts = cutsOf(clip);
    ASSERT_EQ(cuts.size(), 2U);
    EXPECT_GE(cuts[1], 11);
    EXPECT_LE(cuts[1], 13);
}

TEST(SceneCuts, TakesTheSmallestAndPlainestPictures) {
    const cv::Mat dot(1, 1, CV_8UC3, cv::Scalar(10, 20, 30));
    const cv::Mat other(1, 1, CV_8UC3, cv::Scalar(200, 20, 30));
    EXPECT_EQ(cutsOf({dot, other, dot}), std::vector<int>{0});
}

TEST(SceneCuts, FindsThoseOfARealFilmAndNoOthers) {
    ALTIRO3D_REQUIRE_DATA("videos/bikes.mp4");
    EXPECT_EQ(cutsOf(pictures("bikes.mp4")), (std::vector<int>{0, 30, 76, 137, 187, 242}));
}

TEST(SceneCuts, FindsNoneWhereThereIsNone) {
    ALTIRO3D_TAKES(4);
    ALTIRO3D_REQUIRE_DATA("videos/bikes.mp4");
    for (const char* clip : {"bigbuckbunny.mp4", "flower.mp4", "carphone_pristine.mp4",
                             "realshort.mp4", "car-detection.mp4"}) {
        const std::vector<cv::Mat> all = pictures(clip, 150);
        EXPECT_EQ(cutsOf(all), std::vector<int>{0}) << clip;
        std::vector<cv::Mat> everySecond;
        for (std::size_t i = 0; i < all.size(); i += 2)
            everySecond.push_back(all[i]);
        EXPECT_EQ(cutsOf(everySecond), std::vector<int>{0}) << clip << " at double speed";
    }
}

TEST(SceneCuts, FindsThoseBetweenClipsThatAreJoined) {
    ALTIRO3D_REQUIRE_DATA("videos/bikes.mp4");
    std::vector<std::vector<cv::Mat>> clips;
    for (const char* clip : {"bikes.mp4", "bigbuckbunny.mp4", "flower.mp4", "carphone_pristine.mp4",
                             "realshort.mp4", "car-detection.mp4"}) {
        std::vector<cv::Mat> some = pictures(clip, 25);
        for (cv::Mat& picture : some)
            cv::resize(picture, picture, cv::Size(480, 270), 0, 0, cv::INTER_AREA);
        clips.push_back(some);
    }
    for (std::size_t a = 0; a < clips.size(); ++a) {
        for (std::size_t b = 0; b < clips.size(); ++b) {
            if (a == b) continue;
            std::vector<cv::Mat> joined(clips[a].begin(), clips[a].begin() + 7);
            joined.insert(joined.end(), clips[b].begin() + 10, clips[b].begin() + 17);
            EXPECT_EQ(cutsOf(joined), (std::vector<int>{0, 7})) << a << ", " << b;
        }
    }
}
