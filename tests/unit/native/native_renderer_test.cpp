#include "altiro3D/native_maker.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt2native.hpp"
#include "native/shift_kernels.hpp"
#include "support/compare.hpp"
#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/pixels.hpp"
#include "support/processors.hpp"
#include "support/random_pictures.hpp"
#include "support/scene.hpp"
#include "support/slow.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

// A display of each kind that the mapping distinguishes.
std::vector<Calibration> displays() {
    std::vector<Calibration> all;
    all.push_back(stripePanel(150, 97));
    Calibration flipped = stripePanel(131, 88);
    flipped.flipImageX = 1;
    flipped.flipImageY = 1;
    flipped.flipSubp = 1;
    all.push_back(flipped);
    Calibration notInverted = stripePanel(64, 200);
    notInverted.invView = 0;
    notInverted.slope = 5.2;
    all.push_back(notInverted);
    Calibration cells = stripePanel(140, 90);
    cells.CellPatternMode = 3;
    for (int i = 0; i < 4; ++i) {
        SubpixelCell cell;
        for (std::size_t k = 0; k < 3; ++k) {
            cell.x[k] = (static_cast<double>(k) - 1) / 3 + 0.02 * i;
            cell.y[k] = 0.1 * i;
        }
        cells.subpixelCells.push_back(cell);
    }
    all.push_back(cells);
    Calibration borders = stripePanel(96, 64); // cell borders are hit exactly
    borders.pitch = 81;
    borders.DPI = 324;
    borders.slope = -4;
    borders.center = 0;
    all.push_back(borders);
    return all;
}

cv::Mat stepsAndSlopes(cv::Size size) {
    cv::Mat depth = pictureOf<float>(size, [&](int x, int y) {
        return 0.2F + 0.4F * static_cast<float>(x + 2 * y) / static_cast<float>(3 * size.width);
    });
    cv::circle(depth, {size.width / 3, size.height / 2}, size.height / 4, cv::Scalar(0.95), -1);
    cv::rectangle(depth, cv::Rect(size.width / 2, 3, size.width / 5, size.height / 2),
                  cv::Scalar(0.02), -1);
    return depth;
}

ViewOptions optionsOf(ViewMethod method, double strength, double focus, int refinement = 0) {
    ViewOptions options;
    options.method = method;
    options.strengthPercent = strength;
    options.focus = focus;
    options.refinement = refinement;
    return options;
}

// Fast, Fast refined, Layered; no strength, usual, large.
std::vector<ViewOptions> allOptions() {
    return {optionsOf(ViewMethod::Fast, 10, 0.5),     optionsOf(ViewMethod::Fast, 60, 0.2, 3),
            optionsOf(ViewMethod::Layered, 10, 0.5),  optionsOf(ViewMethod::Layered, 35, 0.3),
            optionsOf(ViewMethod::Layered, 300, 0.0), optionsOf(ViewMethod::Fast, 0, 0.5),
            optionsOf(ViewMethod::Layered, 0, 0.5)};
}

cv::Mat rendered(const NativeRenderer& renderer, const altiro3D::Scene& scene) {
    cv::Mat native;
    renderer.render(scene, native);
    return native;
}

cv::Mat overTheQuilt(const Calibration& calibration, const QuiltLayout& layout,
                     const ViewOptions& options, const altiro3D::Scene& scene) {
    cv::Mat quilt;
    cv::Mat native;
    Depth2Quilt(layout, options).render(scene, quilt);
    Quilt2Native(NativeLut(calibration, layout)).render(quilt, native);
    return native;
}

TEST(NativeRenderer, GivesTheNativeOfTheQuiltBitForBit) {
    ALTIRO3D_TAKES(1.3);
    for (const Calibration& calibration : displays()) {
        for (const cv::Size tile : {cv::Size(61, 37), cv::Size(40, 52)}) {
            for (const int views : {1, 2, 45, 300}) {
                const QuiltLayout layout{20, (views + 19) / 20, tile, views};
                const cv::Size size(tile.width + 16, tile.height);
                const altiro3D::Scene withMargins{
                    randomPhoto(size), stepsAndSlopes(size), {}, {5, 5 + tile.width}};
                for (const altiro3D::Scene& scene :
                     {altiro3D::Scene{randomPhoto(tile), stepsAndSlopes(tile)}, withMargins}) {
                    for (const ViewOptions& options : allOptions()) {
                        const NativeRenderer renderer(calibration, views, options);
                        const cv::Mat native = rendered(renderer, scene);
                        EXPECT_TRUE(
                            samePicture(native, overTheQuilt(calibration, layout, options, scene)))
                            << calibration.screenW << " " << tile << " " << views << " "
                            << options.strengthPercent << " " << scene.shown.start;
                        cv::Mat redFirst;
                        renderer.render(scene, redFirst, ChannelOrder::Rgb);
                        cv::cvtColor(redFirst, redFirst, cv::COLOR_RGB2BGR);
                        EXPECT_TRUE(samePicture(redFirst, native));
                    }
                }
            }
        }
    }
}

// Places of Fast are computed in whole numbers up to S/2 = 64 px, and read from registers where the
// columns of the photo are near enough to each other.
TEST(NativeRenderer, FastGivesTheNativeOfTheQuiltForAnyWidthAndParallax) {
    const Calibration calibration = stripePanel(150, 20);
    for (const int width : {1, 2, 33, 150, 640, 5000}) {
        const cv::Size tile(width, 7);
        const cv::Mat photo = randomPhoto(tile);
        const cv::Mat depth = stepsAndSlopes(tile);
        for (const double halfParallax : {0.004, 0.3, 15.0, 30.5, 63.99, 64.0, 200.0}) {
            for (const double focus : {0.0, 0.5, 0.71, 1.0}) {
                const QuiltLayout layout{4, 4, tile, 15};
                const ViewOptions options =
                    optionsOf(ViewMethod::Fast, std::min(200 * halfParallax / width, 1e4), focus);
                EXPECT_TRUE(
                    samePicture(rendered({calibration, layout.viewCount, options}, {photo, depth}),
                                overTheQuilt(calibration, layout, options, {photo, depth})))
                    << width << " " << halfParallax << " " << focus;
            }
        }
    }
}

// Position from the double phase, view made as a whole: what each sub-pixel must show.
void expectContinuous(const Calibration& calibration, int views, const ViewOptions& options,
                      const cv::Mat& photo, const cv::Mat& depth) {
    const cv::Mat native =
        rendered({calibration, views, options, ViewPositions::Continuous}, {photo, depth});
    const LensGeometry geometry = lensGeometry(calibration);
    cv::RNG rng(4);
    int unlike = 0;
    constexpr int kSamples = 150;
    for (int i = 0; i < kSamples; ++i) {
        const int x = rng.uniform(0, native.cols);
        const int y = rng.uniform(0, native.rows);
        const int colour = rng.uniform(0, 3);
        const double z = geometry.phase(x, y, colour);
        const double position =
            views > 1 ? std::clamp((2 * z * views - views) / (views - 1), -1.0, 1.0) : 0;
        cv::Mat view;
        Depth2Quilt({1, 1, {9, 9}, 1}, options).renderView({photo, depth}, position, view);
        const int seenX = geometry.mirrorX ? native.cols - 1 - x : x;
        const int seenY = geometry.mirrorY ? native.rows - 1 - y : y;
        const cv::Vec3b expected =
            view.at<cv::Vec3b>((2 * seenY + 1) * photo.rows / (2 * native.rows),
                               (2 * seenX + 1) * photo.cols / (2 * native.cols));
        // positions differ in their last bits: places by a step of 1/32 or 1/256 px at most
        if (std::abs(native.at<cv::Vec3b>(y, x)[2 - colour] - expected[2 - colour]) > 8) ++unlike;
    }
    EXPECT_EQ(unlike, 0) << "of " << kSamples;
}

TEST(NativeRenderer, ContinuousPositionsAreThoseOfThePhase) {
    const cv::Mat depth = stepsAndSlopes({61, 37});
    cv::Mat photo = randomPhoto(depth.size());
    cv::GaussianBlur(photo, photo, {5, 5}, 1.5);
    for (const Calibration& calibration : displays()) {
        for (const int views : {1, 2, 48})
            for (const ViewOptions& options :
                 {optionsOf(ViewMethod::Fast, 20, 0.5), optionsOf(ViewMethod::Fast, 20, 0.4, 2),
                  optionsOf(ViewMethod::Layered, 20, 0.5)})
                expectContinuous(calibration, views, options, photo, depth);
    }
}

// A ramp moves as a whole: linear sampling gives the value at any place.
TEST(NativeRenderer, ContinuousPositionsReadLayeredBetweenPx) {
    constexpr int kRise = 3; // grey levels per px
    constexpr int kMargin = 10;
    constexpr int kShown = 60;
    constexpr double kDepth = 0.7;
    cv::Mat photo(37, kShown + 2 * kMargin, CV_8UC3);
    for (int x = 0; x < photo.cols; ++x)
        photo.col(x).setTo(cv::Scalar::all(kRise * x));
    for (const double focus : {0.3, 0.7}) { // moving, and still
        const ViewOptions options = optionsOf(ViewMethod::Layered, 20, focus);
        const altiro3D::Scene scene{photo,
                                    cv::Mat(photo.size(), CV_32FC1, cv::Scalar(kDepth)),
                                    {},
                                    {kMargin, kMargin + kShown}};
        for (const Calibration& calibration : displays()) {
            const cv::Mat native =
                rendered({calibration, 48, options, ViewPositions::Continuous}, scene);
            const LensGeometry geometry = lensGeometry(calibration);
            double worst = 0;
            for (int y = 0; y < native.rows; ++y) {
                for (int x = 0; x < native.cols; ++x) {
                    const int seen = geometry.mirrorX ? native.cols - 1 - x : x;
                    const double place = kMargin + (seen + 0.5) * kShown / native.cols - 0.5;
                    for (int colour = 0; colour < 3; ++colour) {
                        const double z = geometry.phase(x, y, colour);
                        if (std::min(z, 1 - z) < 1.0 / 32768) continue; // rounded to either side
                        const double position = std::clamp((2 * z * 48 - 48) / 47, -1.0, 1.0);
                        const double moved = position * 0.1 * kShown * (kDepth - focus);
                        worst = std::max(worst, std::abs(native.at<cv::Vec3b>(y, x)[2 - colour] -
                                                         kRise * (place + moved)));
                    }
                }
            }
            // rounding of the value, of the place to 1/256 px and of the movement to 1/32 px
            EXPECT_LT(worst, 0.5 + kRise * (0.5 / 256 + 1.0 / 32)) << calibration.screenW;
        }
    }
}

TEST(NativeRenderer, APhotoOfThePanelsSizeIsSampledPixelByPixel) {
    const Calibration calibration = stripePanel(160, 120);
    const cv::Mat photo = randomPhoto({160, 120});
    const cv::Mat flat(photo.size(), CV_32FC1, cv::Scalar(0.5));
    for (const ViewMethod method : {ViewMethod::Fast, ViewMethod::Layered}) {
        const NativeRenderer renderer(calibration, 48, optionsOf(method, 10, 0.5));
        EXPECT_TRUE(samePicture(rendered(renderer, {photo, flat}), photo));
    }
}

// What each sub-pixel shows of a world whose views are known from everywhere.
cv::Mat trueNative(const Scene& scene, const Calibration& calibration, int views, double reach) {
    constexpr int kPlaces = 9;
    const LensGeometry geometry = lensGeometry(calibration);
    cv::Mat native(calibration.screenH, calibration.screenW, CV_8UC3);
    std::vector<cv::Mat> seen;
    for (int i = 0; i < kPlaces; ++i)
        seen.push_back(
            render(scene, native.size(), reach * (2.0 * i / (kPlaces - 1) - 1), 4).photo);
    forPixels(native.size(), [&](int x, int y) {
        for (int colour = 0; colour < 3; ++colour) {
            const double z = geometry.phase(x, y, colour);
            const double position = std::clamp((2 * z * views - views) / (views - 1), -1.0, 1.0);
            const auto place = std::lround((position + 1) / 2 * (kPlaces - 1));
            native.at<cv::Vec3b>(y, x)[2 - colour] =
                seen[static_cast<std::size_t>(place)].at<cv::Vec3b>(y, x)[2 - colour];
        }
    });
    return native;
}

TEST(NativeRenderer, ThePanelsResolutionAndContinuousPositionsComeNearerToTheTruth) {
    ALTIRO3D_TAKES(5);
    const Calibration calibration = stripePanel(90, 120);
    const Scene scene = sampleScene();
    constexpr int kViews = 6; // few for a small panel: as far apart as 48 are on a large one
    ViewOptions options;
    options.focus = relativeInverseDepth(scene, scene.focusDistance);
    const double reach = options.strengthPercent / 200 /
                         (scene.focalWidths * (1 / scene.nearDistance - 1 / scene.farDistance));
    const cv::Mat truth = trueNative(scene, calibration, kViews, reach);
    const Rendering world = render(scene, {360, 480}, 0, 1);
    const auto accuracy = [&](cv::Size size, ViewPositions positions) {
        cv::Mat photo;
        cv::Mat depth;
        cv::Mat native;
        const PhotoFit fit = fitPhoto(world.photo.size(), 0.75, size);
        applyFit(world.photo, fit, photo);
        applyFitToDepth(world.depth, world.photo.size(), fit, photo, options.focus, depth);
        NativeRenderer(calibration, kViews, options, positions).render({photo, depth}, native);
        return psnr(native, truth);
    };
    const double tile = accuracy({25, 33}, ViewPositions::Discrete);
    const double panel = accuracy({90, 120}, ViewPositions::Discrete);
    const double continuous = accuracy({90, 120}, ViewPositions::Continuous);
    EXPECT_GT(panel, tile + 4);
    EXPECT_GT(continuous, panel + 0.1);
}

// The sides of the outermost views of a wide photo are cut to the panel's shape.
TEST(NativeRenderer, MarginsOfThePhotoBringTheSidesOfViewsNearerToTheTruth) {
    ALTIRO3D_TAKES(4);
    const Scene narrow = sampleScene();
    Scene wide = narrow; // the same camera with a picture twice as wide
    wide.focalWidths /= 2;
    ViewOptions options;
    options.focus = relativeInverseDepth(narrow, narrow.focusDistance);
    const double reach = options.strengthPercent / 200 /
                         (narrow.focalWidths * (1 / narrow.nearDistance - 1 / narrow.farDistance));
    const cv::Size size(120, 160);
    const int strip = 6; // the largest shift
    const Rendering world = render(wide, {2 * size.width, size.height}, 0, 4);
    const PhotoFit plain = fitPhoto(world.photo.size(), 0.75, size);
    const cv::Mat truths[] = {render(narrow, size, -reach, 4).photo,
                              render(narrow, size, reach, 4).photo};
    const auto accuracyAtSides = [&](const PhotoFit& fit, ViewMethod method) {
        options.method = method;
        altiro3D::Scene fitted;
        fitScene({world.photo, world.depth}, fit, options.focus, fitted);
        double sum = 0;
        for (const int side : {-1, 1}) {
            cv::Mat view;
            Depth2Quilt({1, 1, size, 1}, options).renderView(fitted, side, view);
            const cv::Mat& truth = truths[side < 0 ? 0 : 1];
            for (const int from : {0, size.width - strip}) {
                const cv::Range columns(from, from + strip);
                sum += psnr(view.colRange(columns), truth.colRange(columns));
            }
        }
        return sum / 4;
    };
    // Fast reads the depth of the wrong px there, as everywhere at depth steps.
    for (const ViewMethod method : {ViewMethod::Real, ViewMethod::Layered}) {
        const double without = accuracyAtSides(plain, method);
        const double with =
            accuracyAtSides(withMargins(plain, world.photo.size(), options), method);
        EXPECT_GT(with, without + 1) << static_cast<int>(method);
    }
}

TEST(NativeRenderer, ThreadsReuseAndSubMatricesDoNotMatter) {
    const Calibration calibration = stripePanel(150, 97);
    const cv::Rect part(7, 5, 61, 37);
    const cv::Mat largePhoto = randomPhoto({90, 60});
    const cv::Mat largeDepth = stepsAndSlopes({90, 60});
    const RestoredThreads restored;
    for (const ViewOptions& options : allOptions()) {
        const NativeRenderer renderer(calibration, 48, options);
        cv::setNumThreads(1);
        cv::Mat one;
        renderer.render({largePhoto(part).clone(), largeDepth(part).clone()}, one);
        for (const int threads : {2, 3, 7}) {
            cv::setNumThreads(threads);
            cv::Mat many(one.size(), CV_8UC3, cv::Scalar::all(7));
            const uchar* memory = many.data;
            renderer.render({largePhoto(part), largeDepth(part)}, many);
            EXPECT_EQ(many.data, memory);
            EXPECT_TRUE(samePicture(many, one));
        }
    }
}

// The tile is so small that vectors of AVX-512 find all they need in registers, or so large and
// strong that they do not.
TEST(NativeRenderer, AllInstructionSetsGiveTheSameBytes) {
    const Calibration calibration = stripePanel(331, 65);
    for (const cv::Size tile : {cv::Size(90, 31), cv::Size(331, 65)}) {
        const cv::Mat photo = randomPhoto(tile);
        const cv::Mat depth = stepsAndSlopes(tile);
        for (const ViewOptions& options : allOptions()) {
            for (const ViewPositions positions :
                 {ViewPositions::Discrete, ViewPositions::Continuous}) {
                const NativeRenderer renderer(calibration, 48, options, positions);
                const cv::Mat expected = rendered(renderer, {photo, depth});
                forEachInstructionSet([&](const char* name) {
                    EXPECT_TRUE(samePicture(rendered(renderer, {photo, depth}), expected)) << name;
                });
            }
        }
    }
}

TEST(NativeRenderer, WholeShiftsOfPhasesAreNearTheShiftsOfFloats) {
    std::vector<std::uint32_t> columns = paddedRow<std::uint32_t>(500);
    cv::RNG rng(3);
    for (std::uint32_t& phase : columns)
        phase = rng.next();
    columns[0] = 0;
    columns[1] = ~std::uint32_t{0};
    std::vector<std::uint16_t> halves = paddedRow<std::uint16_t>(columns.size());
    std::transform(columns.begin(), columns.end(), halves.begin(),
                   [](std::uint32_t phase) { return static_cast<std::uint16_t>(phase >> 16); });
    std::vector<float> exact = paddedRow<float>(500);
    std::vector<std::int16_t> whole = paddedRow<std::int16_t>(500);
    forEachInstructionSet([&](const char* name) {
        for (const std::uint32_t row : {0U, 0x12345678U, 0xfffffffU}) {
            for (const int views : {1, 2, 48, 4000}) {
                for (const auto& [halfParallax, steps] :
                     {std::pair(0.0F, 128.0), std::pair(16.8F, 128.0), std::pair(63.9F, 128.0),
                      std::pair(40.0F, 16384 / 40.0)}) {
                    shiftsOfPhases(columns.data(), row, 500, views, halfParallax, exact.data());
                    wholeShiftsOfPhases(halves.data(), row, 500, views, halfParallax, steps,
                                        whole.data());
                    for (std::size_t i = 0; i < 500; ++i) {
                        const std::uint32_t phase = columns[i] + row;
                        const std::uint32_t toEnd = std::min(phase, 0U - phase);
                        if (toEnd < 3 << 16) continue; // may count as the other end of the lens
                        // a half for the rounding of the shift, as much for that of S/2, and phases
                        ASSERT_NEAR(whole[i], steps * double{exact[i]},
                                    1 + steps * double{halfParallax} * 0x1p-13)
                            << name << " " << row << " " << views << " " << halfParallax;
                    }
                }
            }
        }
    });
}

TEST(NativeRenderer, DepthAtItsLimitsIsDefined) {
    const Calibration calibration = stripePanel(64, 48);
    using Limits = std::numeric_limits<float>;
    for (const cv::Size size :
         {cv::Size(1, 1), cv::Size(1, 9), cv::Size(31, 1), cv::Size(101, 77)}) {
        const cv::Mat photo = randomPhoto(size);
        for (const float value : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(),
                                  Limits::denorm_min(), Limits::max(), -3.0F}) {
            cv::Mat wild(size, CV_32FC1, cv::Scalar(static_cast<double>(value)));
            const cv::Mat tame(size, CV_32FC1, cv::Scalar(value > 1 ? 1 : 0));
            for (const ViewOptions& options : allOptions()) {
                const NativeRenderer renderer(calibration, 48, options);
                EXPECT_TRUE(samePicture(rendered(renderer, {photo, wild}),
                                        rendered(renderer, {photo, tame})))
                    << value << size;
            }
        }
    }
}

TEST(NativeRenderer, WrongInputsAreRefusedByName) {
    const Calibration calibration = stripePanel(64, 48);
    const auto make = [](const Calibration& display, int views, const ViewOptions& options = {}) {
        return errorOf([&] { NativeRenderer(display, views, options); });
    };
    EXPECT_TRUE(
        holds(make(calibration, 48, optionsOf(ViewMethod::Real, 10, 0.5)), "method: is real"));
    EXPECT_TRUE(holds(make(calibration, 0), "view count: is 0"));
    EXPECT_TRUE(holds(make(Calibration(), 48), "pitch"));
    const NativeRenderer renderer(calibration, 48);
    const auto render = [&](const cv::Mat& photo, const cv::Mat& depth, cv::Mat native = {}) {
        const altiro3D::Scene scene{photo, depth};
        return errorOf([&] { renderer.render(scene, native); });
    };
    const cv::Mat photo(48, 64, CV_8UC3);
    const cv::Mat depth(48, 64, CV_32FC1, cv::Scalar(0));
    EXPECT_TRUE(holds(render(photo, depth.colRange(0, 9)), "depth: has 9 x 48 px"));
    EXPECT_TRUE(holds(render(depth, depth), "photo: "));
    EXPECT_TRUE(holds(render(photo, depth, photo), "shares its memory"));
    const cv::Mat large(90, 120, CV_8UC3, cv::Scalar::all(0)); // would be reallocated
    EXPECT_TRUE(holds(render(large, cv::Mat(large.size(), CV_32FC1, cv::Scalar(0)), large),
                      "shares its memory"));
}

TEST(NativeRenderer, PhotoAndNativeMayBePartsOfOneCanvas) {
    const NativeRenderer renderer(stripePanel(64, 48), 48);
    const cv::Mat depth = stepsAndSlopes({61, 37});
    cv::Mat canvas(100, 200, CV_8UC3, cv::Scalar::all(7));
    cv::Mat photo = canvas(cv::Rect(64, 5, 61, 37));
    randomPhoto({61, 37}).copyTo(photo);
    const cv::Mat expected = rendered(renderer, {photo.clone(), depth});
    for (const cv::Point corner : {cv::Point(0, 0), cv::Point(125, 5), cv::Point(64, 42)}) {
        cv::Mat native = canvas(cv::Rect(corner, expected.size()));
        renderer.render({photo, depth}, native);
        EXPECT_TRUE(samePicture(canvas(cv::Rect(corner, expected.size())), expected)) << corner;
    }
    const altiro3D::Scene scene{photo, depth};
    for (const cv::Point corner : {cv::Point(1, 0), cv::Point(124, 5), cv::Point(64, 41)}) {
        cv::Mat native = canvas(cv::Rect(corner, expected.size()));
        EXPECT_NE(errorOf([&] { renderer.render(scene, native); }), "(no error)") << corner;
    }
}

} // namespace
} // namespace altiro3D::test
