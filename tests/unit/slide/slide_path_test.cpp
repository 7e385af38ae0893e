#include "slide/slide_path.hpp"

#include "support/slow.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace altiro3D::test {

namespace {

// A slide without pictures: points, cameras, and where the cameras see the points.
struct MadeSlide {
    SlideLens lens{1.0, 0};
    std::vector<SlideCamera> cameras;
    std::vector<SlideTrack> tracks;
};

cv::Matx33d turned(double tilt, double pan, double roll) {
    const cv::Matx33d x(1, 0, 0, 0, std::cos(tilt), -std::sin(tilt), 0, std::sin(tilt),
                        std::cos(tilt));
    const cv::Matx33d y(std::cos(pan), 0, std::sin(pan), 0, 1, 0, -std::sin(pan), 0, std::cos(pan));
    const cv::Matx33d z(std::cos(roll), -std::sin(roll), 0, std::sin(roll), std::cos(roll), 0, 0, 0,
                        1);
    return z * y * x;
}

// @param sign 1: to the right @param noise of the places, widths
// @param kept inverse depth of what stays in its column but for what the hand does, 0: none
MadeSlide madeSlide(int pictures, double sign = 1, double noise = 0.1 / 640, double kept = 0) {
    MadeSlide slide;
    std::mt19937 random(1);
    const auto uniform = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random()) / 4294967295.0;
    };
    for (int i = 0; i < pictures; ++i) {
        const double t = static_cast<double>(i) / (pictures - 1);
        SlideCamera camera;
        // speed varies by 3
        camera.place = {sign * (t - 0.5 / (3 * CV_PI) * (std::cos(3 * CV_PI * t) - 1) - 0.5) * 0.5,
                        uniform(-0.01, 0.01), uniform(-0.01, 0.01)};
        const double pan = kept * camera.place[0];
        camera.turn =
            turned(uniform(-0.017, 0.017), pan + uniform(-0.017, 0.017), uniform(-0.009, 0.009));
        camera.zoom = uniform(-0.01, 0.01);
        camera.shear = uniform(-0.002, 0.002);
        slide.cameras.push_back(camera);
    }
    for (int k = 0; k < 600; ++k) {
        const double q = uniform(0.3, 1.2);
        const SlidePoint point{uniform(-0.9, 0.9), uniform(-0.5, 0.5), q};
        SlideTrack track;
        for (int i = 0; i < pictures; ++i) {
            const cv::Point2d at =
                seenAt(point, slide.cameras[static_cast<std::size_t>(i)], slide.lens);
            const bool isInside = std::abs(at.x) < 0.5 && std::abs(at.y) < 0.4;
            if (!isInside) {
                if (!track.at.empty()) break;
                continue;
            }
            if (track.at.empty()) track.first = i;
            track.at.push_back({at.x + uniform(-noise, noise), at.y + uniform(-noise, noise)});
        }
        if (track.at.size() >= 3) slide.tracks.push_back(track);
    }
    return slide;
}

SlidePath findPath(const std::vector<SlideTrack>& tracks, int pictures, const SlideGuess& guess) {
    return findPaths(tracks, pictures, guess).best;
}

// Largest error of the positions as share of the path, after a line was fitted.
double positionError(const std::vector<SlideCamera>& found, const std::vector<SlideCamera>& made) {
    const double first = made.front().place[0];
    const double whole = made.back().place[0] - first;
    const double begin = found.front().place[0];
    const double all = found.back().place[0] - begin;
    double worst = 0;
    for (std::size_t i = 0; i < made.size(); ++i)
        worst = std::max(worst, std::abs((made[i].place[0] - first) / whole -
                                         (found[i].place[0] - begin) / all));
    return worst;
}

} // namespace

// Rotation about the middle, by hand: a point straight ahead at a distance of 2 seen by a camera
// that is panned to the right and 0.1 to the right lies to the left.
TEST(SlidePath, PointsAreSeenAsByAPinholeCamera) {
    SlideCamera camera;
    camera.place = {0.1, 0, 0};
    const cv::Point2d moved = seenAt(SlidePoint{0, 0, 0.5}, camera, {1, 0});
    EXPECT_NEAR(moved.x, -0.05, 1e-12);
    EXPECT_NEAR(moved.y, 0, 1e-12);
    camera.place = {0, 0, 1}; // half way there
    EXPECT_NEAR(seenAt(SlidePoint{0.1, 0.2, 0.5}, camera, {1, 0}).y, 0.4, 1e-12);
    camera = {};
    camera.zoom = std::log(2);
    camera.shear = 0.1;
    const cv::Point2d seen = seenAt(SlidePoint{0.1, 0.2, 0.5}, camera, {1, 0});
    EXPECT_NEAR(seen.x, 0.2 + 0.04, 1e-12);
    EXPECT_NEAR(seen.y, 0.4, 1e-12);
    const cv::Point2d bent = seenAt(SlidePoint{0.3, 0.4, 1}, {}, {1, 0.1});
    EXPECT_NEAR(bent.x, 0.3 * 1.025, 1e-12);
}

TEST(SlidePath, FindsPlacesTurnsZoomAndLens) {
    ALTIRO3D_TAKES(0.6);
    const MadeSlide slide = madeSlide(40);
    const SlidePath path = findPath(slide.tracks, 40, {});
    EXPECT_LT(positionError(path.cameras, slide.cameras), 0.001); // 5 % of a step of 48 views
    EXPECT_LT(path.cameras.front().place[0], path.cameras.back().place[0]);
    EXPECT_NEAR(path.lens.focal, 1, 0.02);
    EXPECT_EQ(path.misfitShare, 0);
    double zoom = 0; // of the first picture against the mean
    for (const SlideCamera& camera : slide.cameras)
        zoom += camera.zoom / 40;
    EXPECT_NEAR(path.cameras.front().zoom, slide.cameras.front().zoom - zoom, 0.003);
    for (std::size_t i = 0; i < path.cameras.size(); ++i) {
        EXPECT_LT(path.residual[i][1] * 640, 0.1) << i; // uniform noise of 0.1 px: 0.058 rms
        const cv::Matx33d off = path.cameras[i].turn * path.cameras[0].turn.t() *
                                (slide.cameras[i].turn * slide.cameras[0].turn.t()).t();
        EXPECT_NEAR(off(0, 1), 0, 0.001) << i; // roll
        EXPECT_NEAR(off(1, 2), 0, 0.002) << i; // tilt
    }
    // what remains beside the path is what the hand did
    for (std::size_t i = 0; i < path.cameras.size(); ++i)
        EXPECT_LT(std::abs(path.cameras[i].place[1]), 0.03);
}

TEST(SlidePath, ACameraThatMovesToTheLeftHasFallingPositions) {
    const MadeSlide slide = madeSlide(20, -1);
    const SlidePath path = findPath(slide.tracks, 20, {});
    EXPECT_GT(path.cameras.front().place[0], path.cameras.back().place[0]);
    EXPECT_LT(positionError(path.cameras, slide.cameras), 0.002);
}

// Through a wide lens, turns tell which of both it is.
TEST(SlidePath, OfAHandThatFollowsAThingTheReversedPathIsClearlyWorse) {
    ALTIRO3D_TAKES(1.9);
    for (const double kept : {0.45, 0.7, 1.0}) {
        const FoundPaths paths = findPaths(madeSlide(25, 1, 0.1 / 640, kept).tracks, 25, {});
        EXPECT_LT(paths.best.cameras.front().place[0], paths.best.cameras.back().place[0]) << kept;
        EXPECT_TRUE(!paths.reversed || paths.worse > 5) << kept;
    }
    EXPECT_FALSE(findPaths(madeSlide(25).tracks, 25, {}).reversed);
}

TEST(SlidePath, AnUprightPathIsKnownByWhatMovesApart) {
    const MadeSlide slide = madeSlide(20, 1, 0.3 / 640, 0.7); // its shifts are those of the hand
    EXPECT_FALSE(movesUpright(slide.tracks, 20, 1.0 / 640));
    const std::vector<SlideTrack> turned = turnedByAQuarter(slide.tracks, 1);
    EXPECT_TRUE(movesUpright(turned, 20, 1.0 / 640));
    const SlideTrack back = turnedByAQuarter(turnedByAQuarter(turned, 0.75), 1 / 0.75).front();
    EXPECT_NEAR(back.at[1].x, -turned[0].at[1].x, 1e-12);
    EXPECT_NEAR(back.at[1].y, -turned[0].at[1].y, 1e-12);
}

// Photos that were aligned and then shaken: what they have in common with their neighbours is the
// hand alone. Near and far may be exchanged, which leaves the positions as they are.
TEST(SlidePath, AHandThatFollowsAThingAndShakesIsFollowed) {
    ALTIRO3D_TAKES(1.8);
    for (const double kept : {0.45, 0.7, 1.0}) {
        const MadeSlide slide = madeSlide(25, 1, 0.3 / 640, kept);
        const SlidePath path = findPath(slide.tracks, 25, {});
        EXPECT_LT(positionError(path.cameras, slide.cameras), 0.004) << kept;
        EXPECT_EQ(longestStretch(path.cameras).size(), 25U) << kept;
        EXPECT_LT(path.misfitShare, 0.01) << kept;
    }
}

// A ball at a distance of 1 that turns to the right by 25 degrees: the camera goes about it to the
// left, from its right to its left.
TEST(SlidePath, AThingOnATurntableGivesThePathAboutIt) {
    constexpr int kPictures = 20;
    MadeSlide slide;
    std::mt19937 random(2);
    const auto uniform = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random()) / 4294967295.0;
    };
    for (int i = 0; i < kPictures; ++i) {
        const double angle = (12.5 - 25.0 * i / (kPictures - 1)) * CV_PI / 180;
        SlideCamera camera;
        camera.place = {std::sin(angle), 0, 1 - std::cos(angle)};
        camera.turn = turned(0, angle, 0);
        slide.cameras.push_back(camera);
    }
    slide.lens = {0.9, 0};
    for (int k = 0; k < 400; ++k) {
        const double up = uniform(-0.25, 0.25);
        const double side = uniform(-0.9, 0.9); // radians about the axis, on the front
        const double radius = 0.3 * std::sqrt(1 - up * up / 0.09);
        const double z = 1 - radius * std::cos(side);
        const SlidePoint point{radius * std::sin(side) / z, up / z, 1 / z};
        SlideTrack track;
        for (const SlideCamera& camera : slide.cameras) {
            const cv::Point2d at = seenAt(point, camera, slide.lens);
            track.at.push_back({at.x + uniform(-1e-4, 1e-4), at.y + uniform(-1e-4, 1e-4)});
        }
        slide.tracks.push_back(track);
    }
    EXPECT_GT(slide.tracks[0].at.back().x, slide.tracks[0].at.front().x); // it turns to the right
    SlideGuess guess;
    guess.isTurntable = true;
    const SlidePath path = findPath(slide.tracks, kPictures, guess);
    EXPECT_GT(path.cameras.front().place[0], path.cameras.back().place[0]);
    EXPECT_LT(positionError(path.cameras, slide.cameras), 0.01);
    const cv::Matx33d turn = path.cameras.back().turn * path.cameras.front().turn.t();
    EXPECT_NEAR(std::asin(turn(0, 2)) * 180 / CV_PI, -25, 3);
    for (const cv::Vec2d& residual : path.residual)
        EXPECT_LT(residual[1] * 640, 0.1);
}

TEST(SlidePath, OutliersAreFoundAndDoNotMatter) {
    MadeSlide slide = madeSlide(30);
    std::size_t moved = 0;
    for (std::size_t t = 0; t < slide.tracks.size(); t += 5, ++moved) { // things that fall
        double fall = 0;
        for (cv::Point2d& at : slide.tracks[t].at)
            at.y += (fall += 3.0 / 640);
    }
    const SlidePath path = findPath(slide.tracks, 30, {});
    EXPECT_NEAR(path.misfitShare,
                static_cast<double>(moved) / static_cast<double>(slide.tracks.size()), 0.02);
    EXPECT_LT(positionError(path.cameras, slide.cameras), 0.002);
}

TEST(SlidePath, IsTheSameForAnyNumberOfThreads) {
    const MadeSlide slide = madeSlide(12);
    const int threads = cv::getNumThreads();
    cv::setNumThreads(1);
    const SlidePath one = findPath(slide.tracks, 12, {});
    cv::setNumThreads(5);
    const SlidePath five = findPath(slide.tracks, 12, {});
    cv::setNumThreads(threads);
    for (std::size_t i = 0; i < one.cameras.size(); ++i)
        EXPECT_EQ(one.cameras[i].place, five.cameras[i].place) << i;
}

} // namespace altiro3D::test
