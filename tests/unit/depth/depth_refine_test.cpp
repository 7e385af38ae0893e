#include "altiro3D/depth_map.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/photo_fit.hpp"
#include "depth/refine/depth_steps.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/middlebury.hpp"
#include "support/pixels.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"
#include "support/reference.hpp"
#include "support/slow.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

namespace altiro3D::test {
namespace {

struct World {
    cv::Mat photo;
    cv::Mat depth;
};

// Things of one colour and weak texture each, at several depths; every border of depth is one of
// the photo, and the photo has borders of its own.
World world(cv::Size size = {240, 200}) {
    World made{cv::Mat(size, CV_8UC3, cv::Scalar(90, 130, 60)),
               cv::Mat(size, CV_32FC1, cv::Scalar(0.2))};
    const auto put = [&](const cv::Point& centre, const cv::Size& half, double angle, double depth,
                         const cv::Scalar& color) {
        cv::ellipse(made.photo, centre, half, angle, 0, 360, color, cv::FILLED);
        if (depth >= 0)
            cv::ellipse(made.depth, centre, half, angle, 0, 360, cv::Scalar(depth), cv::FILLED);
    };
    put({40, 150}, {18, 12}, 0, -1, {60, 60, 160}); // painted on the background
    put({70, 60}, {42, 30}, 20, 0.5, {200, 180, 170});
    put({60, 55}, {14, 10}, 0, -1, {120, 90, 200}); // painted on a thing
    put({170, 80}, {30, 50}, -15, 0.65, {30, 60, 190});
    put({110, 150}, {50, 26}, 5, 0.9, {20, 30, 40});
    put({200, 160}, {22, 22}, 0, 0.4, {220, 220, 90});
    made.photo += randomPicture(size, CV_8UC3, 7, 0, 9);
    return made;
}

cv::Mat moved(const cv::Mat& depth, int pixels) {
    const int side = 2 * std::abs(pixels) + 1;
    const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
    cv::Mat result;
    if (pixels > 0) cv::dilate(depth, result, disc);
    if (pixels < 0) cv::erode(depth, result, disc);
    return result;
}

cv::Mat blurred(const cv::Mat& depth, double sigma) {
    cv::Mat result;
    cv::GaussianBlur(depth, result, {}, sigma);
    return result;
}

cv::Mat refined(const cv::Mat& photo, const cv::Mat& depth,
                const DepthRefineOptions& options = {}) {
    cv::Mat result;
    refineDepth(photo, depth, result, options);
    return result;
}

// Part of the px whose depth is wrong by more than 0.03.
double wrongPart(const cv::Mat& depth, const cv::Mat& truth) {
    return cv::countNonZero(cv::abs(depth - truth) > 0.03) / static_cast<double>(truth.total());
}

TEST(DepthRefine, DepthThatFitsThePhotoStaysAsItIs) {
    const World made = world();
    const DepthFlaws flaws = measureDepthFlaws(made.photo, made.depth);
    EXPECT_EQ(flaws.softnessPixels, 0);
    EXPECT_EQ(flaws.growthPixels, 0);
    EXPECT_EQ(flaws.shiftPixels, cv::Point());
    EXPECT_TRUE(samePicture(refined(made.photo, made.depth), made.depth));
}

// Slopes look like wide steps, and there are many in rooms.
TEST(DepthRefine, ExactDepthOfRoomsStaysAsItIs) {
    ALTIRO3D_REQUIRE_DATA("rgbd/slambook2/ch12_dense_rgbd");
    for (const std::string number : {"1", "2", "3", "4", "5"}) {
        const auto room = dataPath("rgbd/slambook2/ch12_dense_rgbd");
        Scene scene;
        depthFromFile(room / "depth" / (number + ".png"), DepthKind::Metric)
            ->readScene(readPhoto(room / "color" / (number + ".png")), 0.5, scene);
        const PhotoFit fit = fitPhoto(scene.photo.size(), 0.75, {420, 560});
        Scene fitted;
        fitScene(scene, fit, 0.5, fitted, DepthRefineOptions{DepthFlaws()});
        EXPECT_TRUE(samePicture(refined(fitted.photo, fitted.depth), fitted.depth)) << number;
    }
}

TEST(DepthRefine, ThingsThatAreTooLargeOrTooSmallGetTheirSize) {
    const World made = world();
    for (const int pixels : {-3, -2, 2, 3}) {
        const cv::Mat wrong = moved(made.depth, pixels);
        EXPECT_NEAR(measureDepthFlaws(made.photo, wrong).growthPixels, pixels, 0.5);
        const double before = wrongPart(wrong, made.depth);
        const double after = wrongPart(refined(made.photo, wrong), made.depth);
        EXPECT_GT(before, 0.03) << pixels;
        EXPECT_LT(after, before / 10) << pixels;
    }
}

// Even exact depth may look half a px too large or too small.
TEST(DepthRefine, LessThanAPixelOfGrowthIsNone) {
    const World made = world();
    cv::Mat wrong = made.depth.clone();
    const cv::Range right(110, wrong.cols);
    moved(made.depth, -1).colRange(right).copyTo(wrong.colRange(right));
    const DepthFlaws flaws = measureDepthFlaws(made.photo, wrong);
    EXPECT_EQ(flaws.growthPixels, 0);
    EXPECT_EQ(flaws.shiftPixels, cv::Point());
}

TEST(DepthRefine, AShiftIsUndone) {
    const World made = world();
    for (const cv::Point shift : {cv::Point(2, 0), cv::Point(-1, 2), cv::Point(0, -3)}) {
        const cv::Mat by = (cv::Mat_<double>(2, 3) << 1, 0, shift.x, 0, 1, shift.y);
        cv::Mat wrong;
        cv::warpAffine(made.depth, wrong, by, wrong.size(), cv::INTER_NEAREST,
                       cv::BORDER_REPLICATE);
        EXPECT_EQ(measureDepthFlaws(made.photo, wrong).shiftPixels, shift);
        const cv::Rect inside(4, 4, made.depth.cols - 8, made.depth.rows - 8);
        EXPECT_TRUE(
            samePicture(refined(made.photo, wrong)(inside).clone(), made.depth(inside).clone()));
    }
}

TEST(DepthRefine, SoftEdgesBecomeHardAtTheBorderOfThePhoto) {
    const World made = world();
    for (const double sigma : {0.6, 0.8, 1.0, 2.0, 4.0}) {
        const cv::Mat wrong = blurred(made.depth, sigma);
        const DepthFlaws flaws = measureDepthFlaws(made.photo, wrong);
        EXPECT_NEAR(flaws.softnessPixels, 2.5 * sigma - 1, 0.3 * sigma + 0.2) << sigma;
        EXPECT_EQ(flaws.growthPixels, 0) << sigma;
        const double before = wrongPart(wrong, made.depth);
        const double after = wrongPart(refined(made.photo, wrong), made.depth);
        EXPECT_GT(before, 0.01) << sigma;
        EXPECT_LT(after, before / (sigma < 4 ? 5 : 3)) << sigma;
        if (sigma >= 0.8) {
            EXPECT_TRUE(flaws.isBlurred) << sigma;
        }
    }
}

// A network's depth has hard steps beside soft ones. Deblurred, a hard step would get a rim that
// stands before the near thing, and a ditch behind it.
TEST(DepthRefine, HardStepsAmongSoftOnesGetNoRims) {
    World made = world();
    cv::Mat wrong = blurred(made.depth, 4);
    const cv::Rect corner(0, 0, 40, 30); // away from the other things
    wrong(corner).setTo(0.2);
    wrong(corner).colRange(20, 40).setTo(0.4);
    made.photo(corner).setTo(cv::Scalar(90, 130, 60));
    made.photo(corner).colRange(20, 40).setTo(cv::Scalar(30, 60, 190));
    DepthRefineOptions options;
    options.flaws = DepthFlaws();
    options.flaws->softnessPixels = 9;
    const cv::Mat result = refined(made.photo, wrong, options);
    const cv::Rect step(14, 4, 12, 14);
    EXPECT_LT(cv::norm(result(step), wrong(step), cv::NORM_INF), 1e-6); // of means, rounded
    const cv::Rect around(4, 4, 32, 14);
    EXPECT_EQ(wrongPart(result(around), wrong(around)), 0);
    EXPECT_LT(wrongPart(result, made.depth), 0.7 * wrongPart(wrong, made.depth)); // soft steps
}

TEST(DepthRefine, EnlargedDepthBecomesHard) {
    const World made = world();
    for (const int interpolation : {cv::INTER_CUBIC, cv::INTER_LINEAR}) {
        cv::Mat wrong;
        cv::resize(made.depth, wrong, {60, 50}, 0, 0, cv::INTER_AREA);
        cv::resize(wrong, wrong, made.depth.size(), 0, 0, interpolation);
        EXPECT_FALSE(measureDepthFlaws(made.photo, wrong).isBlurred);
        EXPECT_LT(wrongPart(refined(made.photo, wrong), made.depth),
                  wrongPart(wrong, made.depth) / (interpolation == cv::INTER_CUBIC ? 4 : 2.5));
    }
    for (const int width : {120, 160, 200}) { // hardly soft steps
        cv::Mat wrong;
        cv::resize(made.depth, wrong, {width, width * 5 / 6}, 0, 0, cv::INTER_AREA);
        cv::resize(wrong, wrong, made.depth.size(), 0, 0, cv::INTER_CUBIC);
        EXPECT_FALSE(measureDepthFlaws(made.photo, wrong).isBlurred) << width;
    }
}

// Floors, cloth and walls have many wide, low slopes in both directions, and often more of them
// than steps.
TEST(DepthRefine, SlopesAreNotTakenForSoftSteps) {
    World made = world();
    forPixels(made.depth.size(), [&](int x, int y) {
        auto& depth = made.depth.at<float>(y, x);
        const int fold = std::abs((x + y) % 60 - 30); // 0..30
        if (depth < 0.3F) depth = 0.05F + 0.15F * static_cast<float>(fold) / 30;
    });
    EXPECT_TRUE(samePicture(refined(made.photo, made.depth), made.depth));
    for (const int interpolation : {cv::INTER_CUBIC, cv::INTER_LINEAR}) {
        cv::Mat wrong;
        cv::resize(made.depth, wrong, {80, 67}, 0, 0, cv::INTER_AREA);
        cv::resize(wrong, wrong, made.depth.size(), 0, 0, interpolation);
        const DepthFlaws flaws = measureDepthFlaws(made.photo, wrong);
        EXPECT_FALSE(flaws.isUneven);
        EXPECT_FALSE(flaws.isBlurred);
        EXPECT_NEAR(flaws.softnessPixels, 2.75, 1); // of steps that are 3 to 4.5 px wide
        EXPECT_EQ(flaws.growthPixels, 0);
        EXPECT_LT(wrongPart(refined(made.photo, wrong), made.depth),
                  wrongPart(wrong, made.depth) / 2);
    }
}

// Folds of patterned cloth: each window has a slope of some height, and edges of the photo.
TEST(DepthRefine, FoldsStayInWideWindows) {
    const cv::Size size(240, 200);
    cv::Mat depth(size, CV_32FC1);
    for (int x = 0; x < size.width; ++x)
        depth.col(x).setTo(cv::Scalar(0.5 + 0.025 * std::sin(2 * CV_PI * x / 40)));
    DepthRefineOptions known;
    known.flaws = DepthFlaws();
    known.flaws->softnessPixels = 9;
    EXPECT_TRUE(samePicture(refined(randomPhoto(size), depth, known), depth));
}

TEST(DepthRefine, NothingMovesWhereThePhotoHasNoEdge) {
    const World made = world();
    const cv::Mat plain(made.photo.size(), CV_8UC3, cv::Scalar(80, 90, 100));
    for (const cv::Mat& depth :
         {made.depth, blurred(made.depth, 2), moved(made.depth, 2), moved(made.depth, -2)})
        EXPECT_TRUE(samePicture(refined(plain, depth), depth));
    // also where other parts of the photo have edges
    cv::Mat half = made.photo.clone();
    half.rowRange(100, 200).setTo(cv::Scalar(80, 90, 100));
    const cv::Mat soft = blurred(made.depth, 2);
    DepthRefineOptions known;
    known.flaws = measureDepthFlaws(half, soft);
    EXPECT_GT(known.flaws->softnessPixels, 3);
    const cv::Range lower(110, 200);
    EXPECT_LT(
        cv::norm(refined(half, soft, known).rowRange(lower), soft.rowRange(lower), cv::NORM_INF),
        0.03);
}

TEST(DepthRefine, SlopesStaySlopes) {
    World made = world();
    for (int x = 0; x < made.depth.cols; ++x)
        made.depth.col(x).setTo(cv::Scalar(x / 240.0));
    EXPECT_TRUE(samePicture(refined(made.photo, made.depth), made.depth));
    DepthRefineOptions soft;
    soft.flaws.emplace();
    soft.flaws->softnessPixels = 4;
    const cv::Mat result = refined(made.photo, made.depth, soft);
    const cv::Range inside(12, 228); // repeated px at the border bend it
    EXPECT_LT(cv::norm(result.colRange(inside), made.depth.colRange(inside), cv::NORM_INF), 1e-5);
}

// The part of px in which two maps differ by more than a tolerance.
double differingPart(const cv::Mat& a, const cv::Mat& b, double tolerance) {
    cv::Mat difference;
    cv::absdiff(a, b, difference);
    return cv::countNonZero(difference > tolerance) / static_cast<double>(a.total());
}

TEST(DepthRefine, SharpeningIsThatOfTheFormulas) {
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 5), cv::Size(61, 47)}) {
        const World made = world(size);
        const cv::Mat depths[] = {blurred(made.depth, 1.5), blurred(made.depth, 4), made.depth};
        for (const cv::Mat& depth : depths) {
            for (const cv::Mat& photo : {made.photo, randomPhoto(size)}) {
                for (const double softness : {0.5, 2.75, 9.0}) {
                    DepthFlaws enlarged;
                    enlarged.softnessPixels = softness;
                    DepthFlaws blur = enlarged;
                    blur.isBlurred = true;
                    for (const DepthFlaws& flaws : {blur, enlarged}) {
                        cv::Mat result = depth.clone();
                        sharpenSteps(photo, flaws, result);
                        // float against double: a px at a threshold may fall on either side
                        EXPECT_LE(
                            differingPart(result, referenceSharpenSteps(photo, flaws, depth), 1e-4),
                            0.002)
                            << size << " " << softness << " " << flaws.isBlurred;
                    }
                }
            }
        }
    }
}

// A network's steps: some are soft, others very soft. Where the photo has an edge they become hard.
TEST(DepthRefine, StepsOfDifferingSoftnessAreRecognizedAndBecomeHard) {
    World made = world();
    for (cv::Mat* map : {&made.photo, &made.depth})
        cv::resize(*map, *map, {}, 2, 2, cv::INTER_NEAREST);
    cv::Mat wrong = blurred(made.depth, 1.2);
    const cv::Range right(132, made.depth.cols);
    blurred(made.depth, 5).colRange(right).copyTo(wrong.colRange(right));
    const DepthFlaws flaws = measureDepthFlaws(made.photo, wrong);
    EXPECT_TRUE(flaws.isUneven);
    EXPECT_GT(flaws.softnessPixels, 3);
    EXPECT_LE(flaws.softnessPixels, 0.04 * made.depth.cols + 1e-9);
    cv::Mat partlyHard = made.depth.clone(); // left of x = 50
    blurred(made.depth, 0.8).colRange(50, 100).copyTo(partlyHard.colRange(50, 100));
    const cv::Range soft(100, made.depth.cols);
    blurred(made.depth, 3).colRange(soft).copyTo(partlyHard.colRange(soft));
    EXPECT_TRUE(measureDepthFlaws(made.photo, partlyHard).isUneven);
    for (const double sigma : {1.0, 2.0, 4.0})
        EXPECT_FALSE(measureDepthFlaws(made.photo, blurred(made.depth, sigma)).isUneven) << sigma;
    EXPECT_FALSE(measureDepthFlaws(made.photo, made.depth).isUneven);
    EXPECT_LT(wrongPart(refined(made.photo, wrong), made.depth),
              0.75 * wrongPart(wrong, made.depth));
}

TEST(DepthRefine, ThinThingsKeepTheirDepth) {
    World made = world();
    const cv::Rect bar(10, 0, 3, 100); // beside the other things
    made.photo(bar).setTo(cv::Scalar(250, 250, 250));
    made.depth(bar).setTo(1);
    const cv::Mat wrong = blurred(made.depth, 2);
    const cv::Rect inside(11, 10, 1, 80);
    const double before = cv::mean(wrong(inside))[0];
    const double after = cv::mean(refined(made.photo, wrong)(inside))[0];
    EXPECT_LT(before, 0.7);
    EXPECT_GT(after, before + 0.3 * (1 - before));
}

TEST(DepthRefine, NearThingsGrowOverTheMixedPixelsOfSoftPhotos) {
    const World made = world();
    struct Case {
        double sigma; // of the photo's blur, px
        int mixed;    // px
    };
    for (const Case& soft : {Case{0, 0}, Case{0.5, 0}, Case{0.9, 0}, Case{1.6, 1}, Case{2, 1},
                             Case{3, 2}, Case{5, 2}}) {
        const cv::Mat photo = soft.sigma > 0 ? blurred(made.photo, soft.sigma) : made.photo;
        for (const cv::Mat& depth :
             {made.depth, blurred(made.depth, 2), moved(made.depth, -2), moved(made.depth, 2)})
            EXPECT_EQ(measureDepthFlaws(photo, depth).mixedPixels, soft.mixed) << soft.sigma;
        const cv::Mat expected = soft.mixed > 0 ? moved(made.depth, soft.mixed) : made.depth;
        EXPECT_TRUE(samePicture(refined(photo, made.depth), expected)) << soft.sigma;
    }
}

TEST(DepthRefine, ExtremesAreDefined) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    for (const cv::Size size :
         {cv::Size(1, 1), cv::Size(2, 1), cv::Size(1, 40), cv::Size(17, 3), cv::Size(97, 61)}) {
        const World made = world(size);
        for (const float value : {nan, infinity, -infinity, 1e30F, 0.0F, 0.5F}) {
            cv::Mat depth = made.depth.clone();
            depth.at<float>(size.height / 2, size.width / 2) = value;
            for (const cv::Mat& input : {depth, cv::Mat(size, CV_32FC1, cv::Scalar(value))}) {
                const cv::Mat result = refined(made.photo, input);
                EXPECT_TRUE(cv::checkRange(result, true, nullptr, 0, 1.001)) << value;
            }
        }
        for (const double softness : {1.0, 64.0}) {
            DepthRefineOptions extreme;
            for (const bool isUneven : {false, true}) {
                for (const bool isBlurred : {false, true}) {
                    extreme.flaws.emplace(DepthFlaws{softness, 7, {-7, 7}, isUneven, isBlurred, 7});
                    const cv::Mat result = refined(made.photo, made.depth, extreme);
                    EXPECT_TRUE(cv::checkRange(result, true, nullptr, 0, 1.001)) << softness;
                }
            }
        }
    }
}

TEST(DepthRefine, ItDoesNotDependOnTheNumberOfThreads) {
    const World made = world();
    const cv::Mat noise = randomPicture(made.depth.size(), CV_32FC1, 5, -0.05, 0.05);
    DepthRefineOptions all;
    all.flaws.emplace(DepthFlaws{5, 1, {1, -1}, false, true});
    DepthRefineOptions uneven;
    uneven.flaws.emplace(DepthFlaws{7, 0, {}, true});
    for (const cv::Mat& depth : {cv::Mat(made.depth + noise), blurred(made.depth, 2)})
        for (const DepthRefineOptions& options : {DepthRefineOptions(), all, uneven})
            expectSameForAnyThreads([&] { return refined(made.photo, depth, options); }, {4});
}

TEST(DepthRefine, WorksInPlaceAndOnPartsOfPictures) {
    const World made = world();
    const cv::Mat soft = blurred(made.depth, 2);
    const cv::Rect part(13, 7, 150, 120);
    const cv::Mat expected = refined(made.photo(part).clone(), soft(part).clone());
    EXPECT_TRUE(samePicture(refined(made.photo(part), soft(part)), expected));
    cv::Mat place = soft(part).clone();
    refineDepth(made.photo(part), place, place);
    EXPECT_TRUE(samePicture(place, expected));
    DepthRefineOptions known;
    known.flaws = DepthFlaws();
    known.flaws->shiftPixels = {3, -2};
    for (const int growth : {-2, 2}) {
        known.flaws->growthPixels = growth;
        EXPECT_TRUE(samePicture(refined(made.photo(part), soft(part), known),
                                refined(made.photo(part).clone(), soft(part).clone(), known)));
    }
    const DepthRefineOptions off{DepthFlaws()};
    EXPECT_TRUE(samePicture(refined(made.photo, soft, off), soft));
}

TEST(DepthRefine, WrongArgumentsAreNamed) {
    const World made = world();
    cv::Mat out;
    const auto error = [&](const DepthFlaws& flaws) {
        DepthRefineOptions options;
        options.flaws = flaws;
        return errorOf([&] { refineDepth(made.photo, made.depth, out, options); });
    };
    EXPECT_EQ(error({65, 0, {}}), "softness: is 65, expected 0..64 px");
    EXPECT_EQ(error({0, -8, {}}), "growth: is -8, expected -7..7 px");
    EXPECT_EQ(error({0, 0, {0, 8}}), "shift: is 8, expected -7..7 px");
    EXPECT_EQ(error({0, 0, {}, false, false, -1}), "mixed px: is -1, expected 0..7 px");
    EXPECT_NE(errorOf([&] { refineDepth(made.photo, made.depth.rowRange(0, 9), out); }),
              "(no error)");
    EXPECT_NE(errorOf([&] { refineDepth(made.depth, made.depth, out); }), "(no error)");
    EXPECT_NE(errorOf([&] { refineDepth(made.photo, cv::Mat(), out); }), "(no error)");
    EXPECT_NE(errorOf([&] { (void)measureDepthFlaws(cv::Mat(), cv::Mat()); }), "(no error)");
}

TEST(DepthRefine, FittedScenesAreRefinedInsideTheirBars) {
    const World made = world();
    const cv::Mat soft = blurred(made.depth, 2);
    for (const FitMode mode : {FitMode::Cover, FitMode::Contain}) {
        const PhotoFit fit = fitPhoto(made.photo.size(), 0.75, {150, 200}, mode);
        Scene scene;
        fitScene({made.photo, soft}, fit, 0.3, scene);
        cv::Mat photo;
        cv::Mat depth;
        applyFit(made.photo, fit, photo);
        applyFitToDepth(soft, made.photo.size(), fit, photo, 0.3, depth);
        const DepthRefineOptions off{DepthFlaws()};
        Scene plain;
        fitScene({made.photo, soft}, fit, 0.3, plain, off);
        EXPECT_TRUE(samePicture(plain.depth, depth));
        refined(photo(fit.target), depth(fit.target)).copyTo(depth(fit.target));
        EXPECT_TRUE(samePicture(scene.depth, depth));
        EXPECT_TRUE(samePicture(scene.photo, photo));
    }
}

// What it is for: views that are nearer to true ones.
TEST(DepthRefine, ViewsOfWrongDepthComeNearerToTrueOnes) {
    ALTIRO3D_REQUIRE_DATA("middlebury/Teddy");
    const StereoScene scene = middleburyScene("Teddy");
    const auto quality = [&](const cv::Mat& depth) {
        cv::Mat view;
        Depth2Quilt({1, 1, scene.photo.size(), 1}, scene.options({}))
            .renderView({scene.photo, depth}, 1, view);
        return compareViews(view, scene.truth, scene.band());
    };
    EXPECT_TRUE(samePicture(refined(scene.photo, scene.depth), scene.depth));
    struct Case {
        cv::Mat depth;
        double gain; // dB, at least; measured: 1.2, 1.5, 1.5, 3.5, 1.7
    };
    for (const Case& wrong : {Case{blurred(scene.depth, 0.8), 0.8},
                              Case{blurred(scene.depth, 2), 1}, Case{blurred(scene.depth, 4), 1},
                              Case{moved(scene.depth, -2), 2}, Case{moved(scene.depth, 2), 1}}) {
        const ViewAccuracy before = quality(wrong.depth);
        const ViewAccuracy after = quality(refined(scene.photo, wrong.depth));
        EXPECT_GT(after.psnrInside, before.psnrInside + wrong.gain);
        EXPECT_GT(after.ssimInside, before.ssimInside);
    }
}

TEST(DepthRefine, ViewsOfSoftPhotosComeNearerToTrueOnes) {
    ALTIRO3D_TAKES(3);
    ALTIRO3D_REQUIRE_DATA("middlebury/Teddy");
    const StereoScene scene = middleburyScene("Teddy");
    for (const double sigma : {1.5, 2.0, 3.0}) {
        const cv::Mat photo = blurred(scene.photo, sigma);
        const cv::Mat truth = blurred(scene.truth, sigma);
        for (const ViewMethod method : {ViewMethod::Layered, ViewMethod::Real}) {
            ViewOptions options;
            options.method = method;
            const auto quality = [&](const cv::Mat& depth) {
                cv::Mat view;
                Depth2Quilt({1, 1, photo.size(), 1}, scene.options(options))
                    .renderView({photo, depth}, 1, view);
                return compareViews(view, truth, scene.band());
            };
            const ViewAccuracy before = quality(scene.depth);
            const ViewAccuracy after = quality(refined(photo, scene.depth));
            // measured: Layered 1.1, 1.3, 2.1 dB; Real 2.1, 1.9, 2.8 dB
            EXPECT_GT(after.psnrInside, before.psnrInside + 0.6) << sigma;
            EXPECT_GT(after.ssimInside, before.ssimInside + 0.003) << sigma;
        }
    }
}

} // namespace
} // namespace altiro3D::test
