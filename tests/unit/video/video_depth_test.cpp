#include "altiro3D/depth_network.hpp"
#include "altiro3D/video_depth.hpp"
#include "altiro3D/video_io.hpp"
#include "base/state_bytes.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

using namespace altiro3D;
using namespace altiro3D::test;
namespace fs = std::filesystem;

namespace {

// An estimator that uses only brightness, with different noise in each call.
class NoisyBrightness {
  public:
    explicit NoisyBrightness(double noise = 0, cv::Size size = {64, 48})
        : noise_(noise), size_(size) {}
    void operator()(const cv::Mat& picture, cv::Mat& raw) {
        cv::Mat grey;
        cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
        cv::resize(grey, grey, size_, 0, 0, cv::INTER_AREA);
        grey.convertTo(raw, CV_32F);
        if (noise_ == 0) return;
        cv::Mat noise(raw.size(), CV_32F);
        rng_.fill(noise, cv::RNG::NORMAL, 0, noise_);
        raw += noise;
    }

  private:
    double noise_;
    cv::Size size_;
    cv::RNG rng_{7};
};

VideoDepthOptions everyOf(int every) {
    VideoDepthOptions options;
    options.every = every;
    return options;
}

// A camera that moves over a picture and cuts to another one in the middle.
std::vector<cv::Mat> cameraMove(int count, int step = 3) {
    std::vector<cv::Mat> result;
    for (int i = 0; i < count; ++i) {
        const cv::Mat world = scenery(cv::Size(700, 300), i < count / 2 ? 3 : 4);
        result.push_back(world(cv::Rect(step * i, i, 320, 180)).clone());
    }
    return result;
}

std::vector<cv::Mat> depthsOf(VideoDepth& video, const std::vector<cv::Mat>& clip,
                              std::vector<VideoDepthStep>* steps = nullptr) {
    std::vector<cv::Mat> result;
    for (const cv::Mat& picture : clip) {
        cv::Mat depth;
        const VideoDepthStep step = video.next(picture, depth);
        if (steps != nullptr) steps->push_back(step);
        result.push_back(depth);
    }
    return result;
}

} // namespace

TEST(VideoDepth, OptionsNameFieldValueAndRange) {
    const auto errorWith = [](auto change) {
        VideoDepthOptions options;
        change(options);
        return errorOf([&] { validate(options); });
    };
    EXPECT_EQ(errorWith([](VideoDepthOptions&) {}), "(no error)");
    EXPECT_EQ(errorWith([](VideoDepthOptions& o) { o.every = -1; }),
              "every: is -1, expected a whole number 0..1000");
    EXPECT_EQ(errorWith([](VideoDepthOptions& o) { o.every = 1001; }),
              "every: is 1001, expected a whole number 0..1000");
    EXPECT_EQ(errorWith([](VideoDepthOptions& o) { o.longestGap = 0; }),
              "longestGap: is 0, expected a whole number 1..1000");
    EXPECT_EQ(errorWith([](VideoDepthOptions& o) { o.maxChangedShare = std::nan(""); }),
              "maxChangedShare: is nan, expected 0..1");
    EXPECT_EQ(errorWith([](VideoDepthOptions& o) { o.steadiness = 1; }),
              "steadiness: is 1, expected 0..0.99");
    EXPECT_EQ(errorOf([] { VideoDepth(nullptr, DepthKind::Metric); }),
              "estimator: is empty, expected a function");
}

TEST(VideoDepth, AScenesFirstDepthIsThatOfItsPictureAlone) {
    const std::vector<cv::Mat> clip = cameraMove(12);
    for (const int every : {0, 1, 5}) {
        VideoDepth video(NoisyBrightness(), DepthKind::FarWhite, everyOf(every));
        std::vector<VideoDepthStep> steps;
        const std::vector<cv::Mat> depths = depthsOf(video, clip, &steps);
        for (std::size_t i = 0; i < clip.size(); ++i) {
            EXPECT_EQ(steps[i].cut, i == 0 || i == 6) << i;
            if (!steps[i].cut) continue;
            EXPECT_TRUE(steps[i].inferred);
            cv::Mat raw;
            NoisyBrightness()(clip[i], raw);
            DepthNormalization normalization;
            normalization.kind = DepthKind::FarWhite;
            cv::Mat expected;
            normalizeDepth(raw, expected, normalization);
            EXPECT_TRUE(samePicture(depths[i], expected)) << i;
        }
    }
}

TEST(VideoDepth, InfersOnEveryNthPictureOfAScene) {
    const std::vector<cv::Mat> clip = cameraMove(20);
    for (const int every : {1, 2, 3, 7}) {
        VideoDepth video(NoisyBrightness(), DepthKind::NearWhite, everyOf(every));
        std::vector<VideoDepthStep> steps;
        depthsOf(video, clip, &steps);
        for (int i = 0; i < 20; ++i)
            EXPECT_EQ(steps[static_cast<std::size_t>(i)].inferred, i % 10 % every == 0) << i;
    }
}

TEST(VideoDepth, CarriesTheDepthWithThePicture) {
    std::vector<cv::Mat> clip = cameraMove(16, 4);
    clip.resize(8); // one scene
    VideoDepth video(NoisyBrightness(0, {320, 180}), DepthKind::NearWhite, everyOf(8));
    const std::vector<cv::Mat> depths = depthsOf(video, clip);
    const cv::Rect inside(60, 30, 180, 120); // seen by all
    for (int i = 1; i < 8; ++i) {
        const cv::Mat carried = depths[static_cast<std::size_t>(i)](inside);
        const cv::Mat shifted = depths[0](inside + cv::Point(4 * i, i));
        const cv::Mat still = depths[0](inside);
        const double error = cv::norm(carried, shifted, cv::NORM_L1);
        EXPECT_LT(error, 0.25 * cv::norm(still, shifted, cv::NORM_L1)) << i;
    }
}

TEST(VideoDepth, RepeatsCostNothingAndChangeNothing) {
    std::vector<cv::Mat> clip = cameraMove(6);
    clip.insert(clip.begin() + 2, 5, clip[1].clone());
    VideoDepth video(NoisyBrightness(3), DepthKind::NearWhite, everyOf(1));
    std::vector<VideoDepthStep> steps;
    const std::vector<cv::Mat> depths = depthsOf(video, clip, &steps);
    for (std::size_t i = 0; i < clip.size(); ++i) {
        const bool repeat = i >= 2 && i < 7;
        EXPECT_EQ(steps[i].repeated, repeat) << i;
        EXPECT_EQ(steps[i].inferred, !repeat) << i;
        if (!repeat) continue;
        EXPECT_TRUE(samePicture(depths[i], depths[1]));
        EXPECT_NE(depths[i].data, depths[1].data) << "memory of its own";
    }
}

TEST(VideoDepth, BlankPicturesKeepTheDepthAndAreNotInferred) {
    // A still scene, a fade that stays black for longer than the longest gap, a flash, the scene.
    const cv::Mat scene = scenery(cv::Size(320, 180), 3);
    std::vector<cv::Mat> clip{scene, scene + cv::Scalar::all(1)};
    for (int i = 0; i < 30; ++i)
        clip.emplace_back(scene.size(), CV_8UC3, cv::Scalar::all(40 - i));
    clip.emplace_back(scene.size(), CV_8UC3, cv::Scalar::all(255));
    clip.push_back(scene);
    const auto isBlank = [&](std::size_t i) { return i >= 2 && i + 1 < clip.size(); };
    for (const int every : {0, 5}) {
        int blanks = 0;
        const auto estimator = [&](const cv::Mat& picture, cv::Mat& raw) {
            const cv::Vec3b first = picture.at<cv::Vec3b>(0, 0);
            if (cv::norm(picture, cv::Mat(picture.size(), CV_8UC3, first), cv::NORM_INF) == 0)
                ++blanks;
            NoisyBrightness()(picture, raw);
        };
        VideoDepth video(estimator, DepthKind::NearWhite, everyOf(every));
        VideoDepth resumed(estimator, DepthKind::NearWhite, everyOf(every));
        cv::Mat before;
        for (std::size_t i = 0; i < clip.size(); ++i) {
            resumed.setState(video.state());
            cv::Mat depth;
            cv::Mat again;
            const VideoDepthStep step = video.next(clip[i], depth);
            resumed.next(clip[i], again);
            EXPECT_TRUE(samePicture(again, depth)) << i;
            EXPECT_EQ(resumed.state().bytes, video.state().bytes) << i;
            EXPECT_EQ(step.inferred, i == 0) << i;
            EXPECT_EQ(step.cut, i == 0) << i;
            if (isBlank(i)) {
                EXPECT_TRUE(samePicture(depth, before)) << i;
            }
            before = depth;
        }
        EXPECT_EQ(blanks, 0);
    }
}

TEST(VideoDepth, TakesMostOfTheFlickerOfAStillPictureAway) {
    std::vector<cv::Mat> clip;
    for (int i = 0; i < 40; ++i) {
        cv::Mat noisy = scenery(cv::Size(320, 180), 3) + cv::Scalar::all(i % 2);
        clip.push_back(noisy);
    }
    const auto flicker = [&](double steadiness) {
        VideoDepthOptions options = everyOf(1);
        options.steadiness = steadiness;
        VideoDepth video(NoisyBrightness(5), DepthKind::NearWhite, options);
        const std::vector<cv::Mat> depths = depthsOf(video, clip);
        double sum = 0;
        for (std::size_t i = 1; i < depths.size(); ++i)
            sum += cv::norm(depths[i], depths[i - 1], cv::NORM_L1);
        return sum;
    };
    EXPECT_LT(flicker(VideoDepthOptions().steadiness), 0.2 * flicker(0));
}

TEST(VideoDepth, LeavesNoGhostBehindWhatMoves) {
    // A bright box before noise; its depth is its brightness, so the truth is known.
    const cv::Mat background = randomPhoto(cv::Size(320, 180), 3, 2) * 0.4;
    std::vector<cv::Mat> clip;
    for (int i = 0; i < 24; ++i) {
        cv::Mat picture = background.clone();
        picture(cv::Rect(8 * i, 60, 60, 60)).setTo(cv::Scalar(230, 240, 250));
        clip.push_back(picture);
    }
    VideoDepth video(NoisyBrightness(0, {160, 90}), DepthKind::NearWhite, everyOf(1));
    const std::vector<cv::Mat> depths = depthsOf(video, clip);
    for (int i = 8; i < 24; ++i) {
        cv::Mat raw;
        NoisyBrightness(0, {160, 90})(clip[static_cast<std::size_t>(i)], raw);
        cv::Mat expected;
        normalizeDepth(raw, expected);
        cv::Mat difference;
        cv::absdiff(depths[static_cast<std::size_t>(i)], expected, difference);
        // where the box is and where it was in the last eight pictures
        const cv::Rect way(std::max(0, 4 * i - 32), 28, std::min(34 + 32, 160 - 4 * i + 32), 34);
        EXPECT_LT(cv::mean(difference(way & cv::Rect(0, 0, 160, 90)))[0], 0.03) << i;
    }
}

TEST(VideoDepth, AutoInfersMoreOftenWhereThePictureChanges) {
    VideoDepthOptions options;
    options.longestGap = 8;
    const auto inferences = [&options](const std::vector<cv::Mat>& clip) {
        VideoDepth video(NoisyBrightness(), DepthKind::NearWhite, options);
        std::vector<VideoDepthStep> steps;
        depthsOf(video, clip, &steps);
        return std::count_if(steps.begin(), steps.end(),
                             [](const VideoDepthStep& step) { return step.inferred; });
    };
    std::vector<cv::Mat> still;
    for (int i = 0; i < 24; ++i)
        still.push_back(scenery(cv::Size(320, 180), 3) + cv::Scalar::all(i % 3));
    EXPECT_EQ(inferences(still), 3) << "the first and after each longest gap";
    std::vector<cv::Mat> quick;
    for (int i = 0; i < 24; ++i) {
        const cv::Mat world = scenery(cv::Size(1200, 300), 3);
        quick.push_back(world(cv::Rect(30 * i, 0, 320, 180)).clone());
    }
    EXPECT_GE(inferences(quick), 2 * 3);
}

TEST(VideoDepth, ContinuesFromAStateBitForBit) {
    ALTIRO3D_TAKES(1.5);
    const std::vector<cv::Mat> clip = cameraMove(16);
    for (const int every : {0, 1, 3}) {
        VideoDepth whole(NoisyBrightness(), DepthKind::NearWhite, everyOf(every));
        const std::vector<cv::Mat> expected = depthsOf(whole, clip);
        for (const std::size_t stop : {0U, 1U, 2U, 6U, 9U, 15U, 16U}) {
            VideoDepth first(NoisyBrightness(), DepthKind::NearWhite, everyOf(every));
            depthsOf(first, {clip.begin(), clip.begin() + static_cast<std::ptrdiff_t>(stop)});
            VideoDepth second(NoisyBrightness(), DepthKind::NearWhite, everyOf(every));
            second.setState(first.state());
            EXPECT_EQ(second.state().bytes, first.state().bytes);
            for (std::size_t i = stop; i < clip.size(); ++i) {
                cv::Mat depth;
                second.next(clip[i], depth);
                EXPECT_TRUE(samePicture(depth, expected[i])) << stop << ", " << i;
            }
        }
    }
}

TEST(VideoDepth, RefusesForeignAndDamagedStates) {
    const std::vector<cv::Mat> clip = cameraMove(4);
    VideoDepth video(NoisyBrightness(), DepthKind::NearWhite);
    depthsOf(video, clip);
    const std::string good = video.state().bytes;
    const std::string sentence =
        "state: is damaged or foreign, expected a result of VideoDepth::state()";
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{1}, std::size_t{16}, good.size() / 2, good.size() - 1})
        EXPECT_EQ(errorOf([&] { video.setState({good.substr(0, size)}); }), sentence);
    EXPECT_EQ(errorOf([&] { video.setState({std::string(5000, 'x')}); }), sentence);
    EXPECT_EQ(errorOf([&] { video.setState({good + 'x'}); }), sentence);
    for (std::size_t i = 0; i < good.size(); i += 997) {
        std::string bad = good;
        bad[i] = static_cast<char>(bad[i] ^ 4);
        EXPECT_EQ(errorOf([&] { video.setState({bad}); }), sentence) << i;
    }
    // Right sums, but a picture of another shape than its small copy: it is compared px by px.
    constexpr std::size_t kWord = sizeof(std::uint64_t);
    const auto forged = [&](std::uint64_t rows, std::uint64_t cols) {
        std::string bytes = good.substr(0, kWord);
        append(bytes, rows);
        append(bytes, cols);
        bytes += good.substr(3 * kWord, good.size() - 4 * kWord);
        append(bytes, checksum(bytes));
        return bytes;
    };
    ASSERT_EQ(forged(180, 320), good);
    for (const auto& [rows, cols] :
         {std::pair{320, 180}, {180, 181}, {1, 320}, {0, 320}, {180, 0}, {0, 0}}) {
        EXPECT_EQ(errorOf([&, r = rows, c = cols] {
                      video.setState(
                          {forged(static_cast<std::uint64_t>(r), static_cast<std::uint64_t>(c))});
                  }),
                  sentence)
            << rows << " x " << cols;
    }
    EXPECT_EQ(video.state().bytes, good) << "a state that is refused changes nothing";
}

TEST(VideoDepth, IsTheSameForAnyNumberOfThreads) {
    const std::vector<cv::Mat> clip = cameraMove(14);
    const RestoredThreads restored;
    std::vector<std::vector<cv::Mat>> results;
    for (const int threads : {1, 2, 5}) {
        cv::setNumThreads(threads);
        VideoDepth video(NoisyBrightness(4), DepthKind::NearWhite, everyOf(3));
        results.push_back(depthsOf(video, clip));
    }
    for (const auto& result : results)
        for (std::size_t i = 0; i < clip.size(); ++i)
            EXPECT_TRUE(samePicture(result[i], results[0][i])) << i;
}

TEST(VideoDepth, AnEstimatorThatThrowsLeavesEverythingAsItWas) {
    const std::vector<cv::Mat> clip = cameraMove(6);
    bool fails = false;
    NoisyBrightness brightness;
    VideoDepth video(
        [&](const cv::Mat& picture, cv::Mat& raw) {
            if (fails) throw std::runtime_error("no more");
            brightness(picture, raw);
        },
        DepthKind::NearWhite, everyOf(1));
    cv::Mat depth;
    video.next(clip[0], depth);
    const std::string state = video.state().bytes;
    fails = true;
    EXPECT_THROW(video.next(clip[1], depth), std::runtime_error);
    EXPECT_EQ(video.state().bytes, state);
    fails = false;
    EXPECT_TRUE(video.next(clip[1], depth).inferred);
}

TEST(VideoDepth, AcceptsAnyPicturesAndNumbers) {
    // raw numbers of any kind
    const float infinity = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    int call = 0;
    VideoDepth video(
        [&](const cv::Mat&, cv::Mat& raw) {
            raw = cv::Mat(4 + call % 3, 5, CV_32FC1, cv::Scalar(call));
            raw.at<float>(0, 0) = call % 2 == 0 ? nan : infinity;
            raw.at<float>(1, 1) = -std::numeric_limits<float>::max();
            if (call == 3) raw.setTo(nan);
            ++call;
        },
        DepthKind::Metric, everyOf(1));
    int seed = 0;
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 1), cv::Size(1, 3), cv::Size(3, 500),
                                cv::Size(6000, 2), cv::Size(640, 360)}) {
        for (int i = 0; i < 4; ++i) {
            cv::Mat depth;
            const cv::Mat picture =
                i == 2 ? cv::Mat(size, CV_8UC3, cv::Scalar::all(77)) : randomPhoto(size, ++seed);
            EXPECT_EQ(video.next(picture, depth).repeated, false);
            ASSERT_EQ(depth.type(), CV_32FC1);
            EXPECT_TRUE(cv::checkRange(depth, true, nullptr, 0, 1.0001)) << depth;
        }
    }
    EXPECT_EQ(errorOf([&] {
                  cv::Mat depth;
                  video.next(cv::Mat(), depth);
              }),
              "picture: is empty, expected CV_8UC3");
}

TEST(VideoDepth, StaysBetween0And1HoweverSeldomAndFlatInferencesAre) {
    ALTIRO3D_TAKES(3);
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr float kLargest = std::numeric_limits<float>::max();
    const cv::Mat world = scenery(cv::Size(24, 16), 5);
    for (const int every : {1, 1000}) {
        for (const double steadiness : {0.9, 0.99}) {
            if (every == 1000 && steadiness < 0.99) continue; // takes long
            for (const cv::Size size : {cv::Size(1, 1), cv::Size(7, 5)}) {
                for (const float number : {3.25F, -kLargest, kNan, kInfinity}) {
                    int call = 0;
                    const auto estimate = [&](const cv::Mat&, cv::Mat& raw) {
                        raw = cv::Mat(size, CV_32FC1, cv::Scalar::all(number));
                        ++call;
                    };
                    VideoDepthOptions options = everyOf(every);
                    options.steadiness = steadiness;
                    VideoDepth video(estimate, DepthKind::NearWhite, options);
                    for (int i = 0; i < 2 * every + 30; ++i) {
                        cv::Mat picture = world.clone();
                        picture.at<cv::Vec3b>(0, 0)[0] = static_cast<std::uint8_t>(i % 2 * 3);
                        cv::Mat depth;
                        ASSERT_FALSE(video.next(picture, depth).repeated);
                        // what has no range lies in the middle, as in a photo
                        ASSERT_TRUE(cv::checkRange(depth, true, nullptr, 0.499, 0.501))
                            << every << " " << steadiness << " " << size << " " << number << " at "
                            << i << "\n"
                            << depth;
                    }
                    ASSERT_GE(call, 3);
                }
            }
        }
    }
}
