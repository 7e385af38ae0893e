#include "altiro3D/camera_slide.hpp"

#include "support/files.hpp"
#include "support/hand_slide.hpp"
#include "support/pixels.hpp"
#include "support/random_pictures.hpp"
#include "support/slow.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace altiro3D::test {

namespace {

const cv::Size kSize(320, 240);

// Pictures of a slide by a shaky hand, rendered once.
struct Clip {
    Clip() {
        for (const HandCamera& camera : cameras)
            pictures.push_back(boards.photograph(kSize, camera));
    }
    Boards boards;
    std::vector<HandCamera> cameras = handSlide(shakyHand(24, 0.6));
    std::vector<cv::Mat> pictures;
};
const Clip& clip() {
    static const Clip made;
    return made;
}

SlidePictureSource sourceOf(const std::vector<cv::Mat>& pictures) {
    return [pictures](const std::function<bool(const cv::Mat&)>& take) {
        for (const cv::Mat& picture : pictures)
            if (!take(picture)) return;
    };
}

std::vector<cv::Mat> viewsOf(CameraSlide& slide, int count) {
    std::vector<cv::Mat> views(static_cast<std::size_t>(count));
    slide.makeViews(count, [&](int view, const cv::Mat& picture) {
        EXPECT_TRUE(views[static_cast<std::size_t>(view)].empty());
        views[static_cast<std::size_t>(view)] = picture.clone();
    });
    return views;
}

std::string refusal(const std::vector<cv::Mat>& pictures) {
    return errorOf([&] { const CameraSlide slide(sourceOf(pictures)); });
}

// How corners move from one view to another, px.
std::vector<cv::Point2d> movesOf(const cv::Mat& from, const cv::Mat& to) {
    cv::Mat a;
    cv::Mat b;
    cv::cvtColor(from, a, cv::COLOR_BGR2GRAY);
    cv::cvtColor(to, b, cv::COLOR_BGR2GRAY);
    std::vector<cv::Point2f> points;
    cv::goodFeaturesToTrack(a, points, 400, 0.01, 6);
    std::vector<cv::Point2f> there;
    std::vector<cv::Point2f> back;
    std::vector<uchar> isFound;
    std::vector<uchar> isBack;
    std::vector<float> errors;
    cv::calcOpticalFlowPyrLK(a, b, points, there, isFound, errors, {15, 15});
    cv::calcOpticalFlowPyrLK(b, a, there, back, isBack, errors, {15, 15});
    std::vector<cv::Point2d> moves;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const cv::Point2f off = back[i] - points[i];
        if (isFound[i] != 0 && isBack[i] != 0 && std::hypot(off.x, off.y) < 0.2F)
            moves.emplace_back(there[i] - points[i]);
    }
    EXPECT_GT(moves.size(), 100U);
    return moves;
}

double percentileOf(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// @param get what of a move
template <class Get>
double percentileOf(const std::vector<cv::Point2d>& moves, double share, Get get) {
    std::vector<double> values;
    for (const cv::Point2d& move : moves)
        values.push_back(get(move));
    return percentileOf(values, share);
}
double across(const cv::Point2d& move) {
    return move.x;
}

// Largest error of the positions found, as share of the path.
double positionError(const SlideReport& report, const std::vector<HandCamera>& cameras) {
    const auto placeOf = [&](const std::pair<int, double>& picture) {
        return cameras[static_cast<std::size_t>(picture.first)].place[0];
    };
    const auto& all = report.positions;
    const double scale =
        (all.back().second - all.front().second) / (placeOf(all.back()) - placeOf(all.front()));
    double worst = 0;
    for (const auto& picture : all)
        worst = std::max(worst, std::abs(picture.second - all.front().second -
                                         scale * (placeOf(picture) - placeOf(all.front()))));
    return worst;
}

} // namespace

TEST(CameraSlide, FindsThePathOfAShakyHand) {
    ALTIRO3D_TAKES(1.5);
    const CameraSlide slide(sourceOf(clip().pictures));
    const SlideReport& report = slide.report();
    EXPECT_EQ(report.pictures, 24);
    EXPECT_EQ(report.used, 24);
    EXPECT_FALSE(report.fromRight);
    EXPECT_FALSE(report.turned);
    EXPECT_LT(report.verticalPixels, 0.3);
    EXPECT_LT(positionError(report, clip().cameras), 0.005);
    EXPECT_NEAR(report.turnDegrees, 1.4, 0.5); // about two axes
    EXPECT_NEAR(report.awayPercent, 2, 1);
    EXPECT_EQ(report.lines().size(), 5U);
    EXPECT_TRUE(slide.notes().empty()) << textOf(slide.notes());
}

TEST(CameraSlide, PointsMoveInTheirRowsByEqualSteps) {
    ALTIRO3D_TAKES(1);
    SlideOptions options;
    options.focus = 0.4; // the far wall, which has most corners, lies behind it
    CameraSlide slide(sourceOf(clip().pictures), options);
    const std::vector<cv::Mat> views = viewsOf(slide, 9);
    EXPECT_EQ(views[0].size(), slide.viewSize());
    // of the nearest and the farthest points, per step
    std::vector<double> near;
    std::vector<double> far;
    for (int i = 0; i < 9; ++i) {
        if (i == 4) continue;
        const std::vector<cv::Point2d> moves =
            movesOf(views[4], views[static_cast<std::size_t>(i)]);
        EXPECT_LT(percentileOf(moves, 0.5, [](const auto& m) { return std::abs(m.y); }), 0.3) << i;
        EXPECT_LT(percentileOf(moves, 0.9, [](const auto& m) { return std::abs(m.y); }), 0.6) << i;
        near.push_back(percentileOf(moves, i > 4 ? 0.05 : 0.95, across) / (i - 4));
        far.push_back(percentileOf(moves, i > 4 ? 0.95 : 0.05, across) / (i - 4));
    }
    for (std::size_t i = 0; i < near.size(); ++i) {
        EXPECT_LT(near[i], -0.5) << i; // the camera moves to the right
        EXPECT_GT(far[i], 0.2) << i;
        EXPECT_NEAR(far[i], percentileOf(far, 0.5), 0.1 * percentileOf(far, 0.5)) << i;
    }
}

TEST(CameraSlide, FromRightToLeftGivesTheSameOrder) {
    ALTIRO3D_TAKES(1.5);
    std::vector<cv::Mat> pictures = clip().pictures;
    CameraSlide there(sourceOf(pictures));
    std::reverse(pictures.begin(), pictures.end());
    CameraSlide back(sourceOf(pictures));
    EXPECT_TRUE(back.report().fromRight);
    const std::vector<cv::Mat> a = viewsOf(there, 3);
    const std::vector<cv::Mat> b = viewsOf(back, 3);
    for (const auto& views : {a, b}) { // what is near moves to the left, the far wall stays
        const std::vector<cv::Point2d> moves = movesOf(views[0], views[2]);
        EXPECT_LT(percentileOf(moves, 0.02, across), -15);
        EXPECT_LT(percentileOf(moves, 0.98, across), 5);
    }
    EXPECT_NEAR(there.report().parallaxPercent, back.report().parallaxPercent, 2);
}

// Corners that are followed by their brightness move along its gradients when the light changes.
TEST(CameraSlide, LightThatChangesDoesNotMoveCorners) {
    ALTIRO3D_TAKES(4);
    HandSlide hand;
    hand.pictures = 12;
    hand.exposure = 0.3;
    std::vector<cv::Mat> pictures;
    for (const HandCamera& camera : handSlide(hand))
        pictures.push_back(clip().boards.photograph({640, 480}, camera));
    const CameraSlide slide(sourceOf(pictures));
    EXPECT_LT(slide.report().verticalPixels, 0.1);
    EXPECT_LT(slide.report().turnDegrees, 0.2);
}

// Few pictures, as of an owner who takes wide steps, in little light.
TEST(CameraSlide, CornersAreFollowedThroughNoise) {
    ALTIRO3D_TAKES(2);
    const std::vector<HandCamera> cameras = handSlide(shakyHand(6, 0.6));
    cv::RNG random(3);
    std::vector<cv::Mat> pictures;
    for (const HandCamera& camera : cameras) {
        cv::Mat noise(480, 640, CV_16SC1);
        random.fill(noise, cv::RNG::NORMAL, 0, 50);
        cv::merge(std::vector<cv::Mat>(3, noise), noise);
        pictures.push_back(clip().boards.photograph(noise.size(), camera));
        cv::add(pictures.back(), noise, pictures.back(), {}, CV_8U);
    }
    const CameraSlide slide(sourceOf(pictures));
    EXPECT_EQ(slide.report().used, 6);
    EXPECT_LT(slide.report().verticalPixels, 0.6);
    EXPECT_LT(slide.report().misfitPercent, 5);
    EXPECT_LT(positionError(slide.report(), cameras), 0.012);
}

// Pictures shifted so that the middle depth stays: near things move to the left, far ones to the
// right, as if near and far were exchanged and the camera went the other way. What hides what
// tells.
TEST(CameraSlide, PicturesThatFollowAThingHaveTheRightOrder) {
    ALTIRO3D_TAKES(3);
    HandSlide steady;
    steady.pictures = 14;
    steady.length = 0.8;
    std::vector<cv::Mat> pictures;
    for (const HandCamera& camera : handSlide(steady)) {
        const cv::Mat picture = clip().boards.photograph({640, 480}, camera);
        const cv::Matx23d shift(1, 0, camera.place[0] * 640 / 3.5, 0, 1, 0);
        cv::Mat shifted;
        cv::warpAffine(picture, shifted, shift, picture.size(), cv::INTER_CUBIC);
        pictures.push_back(shifted(cv::Rect(80, 60, 480, 360)).clone());
    }
    EXPECT_FALSE(CameraSlide(sourceOf(pictures)).report().fromRight);
    std::reverse(pictures.begin(), pictures.end());
    EXPECT_TRUE(CameraSlide(sourceOf(pictures)).report().fromRight);
}

// A floor that rises to the back, kept in place in its middle: nothing hides anything, so its upper
// side may be near or far.
TEST(CameraSlide, IfNearAndFarMayBeExchangedTheFirstPictureIsTheLeftmostAndThatIsSaid) {
    ALTIRO3D_TAKES(2.1);
    cv::Mat floor = randomPhoto(kSize, 5, 1.5);
    cv::normalize(floor, floor, 0, 255, cv::NORM_MINMAX);
    std::vector<cv::Mat> pictures;
    for (int i = -8; i <= 8; ++i) {
        cv::Mat_<cv::Vec2f> places(kSize);
        places.forEach([&](cv::Vec2f& place, const int* at) {
            const float nearness =
                static_cast<float>(at[0]) / static_cast<float>(kSize.height) - 0.5F;
            place = {static_cast<float>(at[1]) + 2 * static_cast<float>(i) * nearness,
                     static_cast<float>(at[0])};
        });
        cv::Mat picture;
        cv::remap(floor, picture, places, {}, cv::INTER_CUBIC, cv::BORDER_REFLECT);
        pictures.push_back(picture);
    }
    for (int order = 0; order < 2; ++order) {
        const CameraSlide slide(sourceOf(pictures));
        EXPECT_FALSE(slide.report().fromRight) << order;
        const auto isIt = [](const Note& note) {
            return note.text.find("near and far may be exchanged") == 0;
        };
        EXPECT_EQ(std::count_if(slide.notes().begin(), slide.notes().end(), isIt), 1) << order;
        for (const Note& note : slide.notes())
            EXPECT_EQ(std::count_if(slide.notes().begin(), slide.notes().end(),
                                    [&](const Note& other) { return other.code == note.code; }),
                      1)
                << note.text;
        std::reverse(pictures.begin(), pictures.end());
    }
}

TEST(CameraSlide, AnUprightSlideIsTurnedAndSaysSo) {
    ALTIRO3D_TAKES(0.7);
    std::vector<cv::Mat> pictures;
    for (const cv::Mat& picture : clip().pictures) {
        pictures.emplace_back();
        cv::rotate(picture, pictures.back(), cv::ROTATE_90_COUNTERCLOCKWISE);
    }
    const CameraSlide slide(sourceOf(pictures));
    EXPECT_TRUE(slide.report().turned);
    EXPECT_FALSE(slide.report().fromRight);
    EXPECT_LT(positionError(slide.report(), clip().cameras), 0.005);
    EXPECT_TRUE(holds(textOf(slide.notes()), "moves upright"));
}

TEST(CameraSlide, OfBackAndForthTheLongestStretchIsUsed) {
    ALTIRO3D_TAKES(1.5);
    std::vector<cv::Mat> pictures = clip().pictures;
    for (int i = 22; i >= 8; --i)
        pictures.push_back(clip().pictures[static_cast<std::size_t>(i)]);
    const CameraSlide slide(sourceOf(pictures));
    EXPECT_FALSE(slide.report().fromRight);
    EXPECT_EQ(slide.report().positions.front().first, 0);
    EXPECT_NEAR(slide.report().positions.back().first, 23, 1);
    EXPECT_NEAR(slide.report().stretchPercent, 60, 10);
}

// The sum of all steps is then next to nothing, and tells nothing of the direction.
TEST(CameraSlide, AClipThatComesBackIsNotTakenForAnUprightOne) {
    ALTIRO3D_TAKES(2);
    std::vector<cv::Mat> pictures = clip().pictures;
    pictures.insert(pictures.end(), clip().pictures.rbegin() + 1, clip().pictures.rend());
    for (std::size_t i = 0; i < pictures.size(); ++i) // 1 px down in every second picture
        pictures[i] = pictures[i](cv::Rect(0, 20 - static_cast<int>(i) / 2 % 20, 320, 200)).clone();
    const CameraSlide slide(sourceOf(pictures));
    EXPECT_FALSE(slide.report().turned);
    EXPECT_GT(slide.report().used, 18);
}

TEST(CameraSlide, PicturesThatAreNotInOrderAreTold) {
    ALTIRO3D_TAKES(1.5);
    std::vector<cv::Mat> pictures;
    for (int i = 0; i < 24; ++i) // 0, 7, 14, 21, 4, ...
        pictures.push_back(clip().pictures[static_cast<std::size_t>(i * 7 % 24)]);
    const CameraSlide slide(sourceOf(pictures));
    EXPECT_TRUE(holds(textOf(slide.notes()), "not in the order"));
    EXPECT_LT(slide.report().stretchPercent, 40);
    const CameraSlide inOrder(sourceOf(clip().pictures));
    EXPECT_FALSE(holds(textOf(inOrder.notes()), "not in the order"));
}

TEST(CameraSlide, TwoPicturesHaveViewsAndDepth) {
    ALTIRO3D_TAKES(0.8);
    CameraSlide slide(sourceOf({clip().pictures[6], clip().pictures[15]}));
    cv::Mat photo;
    cv::Mat depth;
    slide.makeDepth(photo, depth);
    EXPECT_EQ(depth.size(), slide.viewSize());
    EXPECT_TRUE(cv::checkRange(depth));
    EXPECT_EQ(viewsOf(slide, 3).size(), 3U);
}

TEST(CameraSlide, ALongPathIsCutToTheParallaxAllowed) {
    ALTIRO3D_TAKES(0.7);
    SlideOptions options;
    options.mostParallax = 0.1;
    const CameraSlide slide(sourceOf(clip().pictures), options);
    EXPECT_TRUE(holds(textOf(slide.notes()), "too long for the display: its middle"));
    EXPECT_LT(slide.report().parallaxPercent, 20);
    EXPECT_LT(slide.report().used, 24);
}

// The boards are at 2 to 6 m.
TEST(CameraSlide, DepthOfTheMiddleViewIsInverseDistance) {
    ALTIRO3D_TAKES(0.8);
    CameraSlide slide(sourceOf(clip().pictures));
    cv::Mat photo;
    cv::Mat depth;
    slide.makeDepth(photo, depth);
    EXPECT_EQ(photo.size(), slide.viewSize());
    ASSERT_EQ(depth.size(), slide.viewSize());
    std::vector<double> values;
    forPixels(depth.size(),
              [&](int x, int y) { values.push_back(static_cast<double>(depth.at<float>(y, x))); });
    const double wall = percentileOf(values, 0.1);
    const double front = percentileOf(values, 0.995);
    EXPECT_NEAR(front / wall, 6 / 2.2, 0.3);
    // half of the picture shows the wall
    EXPECT_NEAR(percentileOf(values, 0.3), wall, 0.02 * wall);
}

TEST(CameraSlide, RefusesWhatIsNoSlide) {
    EXPECT_EQ(refusal({clip().pictures[0]}),
              "slide: holds 1 picture, expected a video or several photos of a camera that moves "
              "sideways");
    EXPECT_TRUE(holds(refusal({}), "holds 0 pictures"));
    EXPECT_TRUE(holds(refusal(std::vector<cv::Mat>(10, clip().pictures[0])),
                      "the camera stands: what it sees moves by 0.00 % of the width"));
    const cv::Mat plain(kSize, CV_8UC3, cv::Scalar::all(90));
    EXPECT_TRUE(holds(refusal(std::vector<cv::Mat>(10, plain)), "only 0 corners can be followed"));
    std::vector<cv::Mat> pictures = clip().pictures;
    for (std::size_t i = 4; i < 16; i += 4)
        pictures[i] = cv::Mat(kSize, CV_8UC3, cv::Scalar::all(0));
    EXPECT_EQ(refusal(pictures), "slide: 3 of 24 pictures do not show the scene of the others "
                                 "(picture 5, picture 9, picture 13), expected 2 at most");
}

TEST(CameraSlide, APictureOfSomethingElseIsLeftOutAndNamed) {
    ALTIRO3D_TAKES(2);
    std::vector<cv::Mat> pictures = clip().pictures;
    pictures[0] = cv::Mat(kSize, CV_8UC3, cv::Scalar::all(255));
    pictures[12] = cv::Mat(kSize, CV_8UC3, cv::Scalar::all(0));
    SlideOptions options;
    options.names.assign(13, "a.png");
    options.names[12] = "b.png";
    const CameraSlide slide(sourceOf(pictures), options);
    EXPECT_EQ(slide.report().used, 22);
    EXPECT_LT(positionError(slide.report(), clip().cameras), 0.005);
    EXPECT_TRUE(holds(textOf(slide.notes()), "a.png is left out: it is white"));
    EXPECT_TRUE(holds(textOf(slide.notes()), "b.png is left out: it is black"));
    pictures = clip().pictures;
    cv::GaussianBlur(clip().pictures[7], pictures[7] = cv::Mat(), {}, 15);
    EXPECT_TRUE(holds(textOf(CameraSlide(sourceOf(pictures)).notes()),
                      "picture 8 is left out: it is blurred"));
}

TEST(CameraSlide, RefusesACameraThatTurnsOrZooms) {
    ALTIRO3D_TAKES(1.6);
    std::vector<cv::Mat> turns;
    std::vector<cv::Mat> zooms;
    for (int i = 0; i < 12; ++i) {
        HandCamera camera;
        camera.panDegrees = i - 5.5;
        turns.push_back(clip().boards.photograph(kSize, camera));
        camera.panDegrees = 0;
        camera.zoom = 1 + 0.03 * i;
        zooms.push_back(clip().boards.photograph(kSize, camera));
    }
    EXPECT_TRUE(holds(refusal(turns), "turns instead of moving: the parallax is 0."));
    EXPECT_TRUE(
        holds(refusal(zooms), "the camera zooms or moves forwards: what it sees grows by 3"));
}

TEST(CameraSlide, RefusesASceneThatMoves) {
    ALTIRO3D_TAKES(0.7);
    // leaves in the wind: blocks that move on their own
    std::vector<cv::Mat> pictures;
    for (std::size_t i = 0; i < clip().pictures.size(); ++i) {
        cv::Mat picture = clip().pictures[i].clone();
        for (int block = 0; block < 12; ++block) {
            const cv::Rect part(100 + 50 * (block % 4), 20 + 70 * (block / 4), 50, 70);
            const double phase = 0.5 * static_cast<double>(i) + 1.7 * block;
            const cv::Matx23d sway(1, 0, 6 * std::sin(1.3 * phase), 0, 1, 6 * std::sin(phase));
            cv::Mat moved;
            cv::warpAffine(clip().pictures[i], moved, sway, kSize, cv::INTER_LINEAR,
                           cv::BORDER_REFLECT);
            moved(part).copyTo(picture(part));
        }
        pictures.push_back(picture);
    }
    EXPECT_TRUE(startsWith(refusal(pictures), "slide: the scene moves in a part of the picture: "))
        << refusal(pictures);
}

TEST(CameraSlide, RefusesPicturesThatStabilisationWarps) {
    ALTIRO3D_TAKES(0.7);
    std::vector<cv::Mat> pictures;
    for (std::size_t i = 0; i < clip().pictures.size(); ++i) {
        const double phase = 1.9 * static_cast<double>(i);
        const cv::Mat places = pictureOf<cv::Vec2f>(kSize, [&](int x, int y) {
            return cv::Vec2f{static_cast<float>(x + 5 * std::sin(y / 35.0 + phase)),
                             static_cast<float>(y + 5 * std::sin(x / 40.0 + 1.3 * phase))};
        });
        cv::Mat warped;
        cv::remap(clip().pictures[i], warped, places, {}, cv::INTER_LINEAR, cv::BORDER_REFLECT);
        pictures.push_back(warped);
    }
    EXPECT_TRUE(startsWith(refusal(pictures), "slide: the pictures are warped, as a phone's"))
        << refusal(pictures);
}

TEST(CameraSlide, ChecksItsOptions) {
    SlideOptions options;
    options.focus = 2;
    EXPECT_TRUE(startsWith(errorOf([&] { validate(options); }), "focus: is 2, expected 0..1"));
    options = {};
    options.viewDegrees = 170;
    EXPECT_TRUE(startsWith(errorOf([&] { validate(options); }), "viewDegrees: is 170"));
}

} // namespace altiro3D::test
