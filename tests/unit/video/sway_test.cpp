#include "altiro3D/sway.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/products.hpp"
#include "altiro3D/video_io.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/pixels.hpp"
#include "support/video.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

// A near disc before a far ramp.
cv::Mat discDepth(cv::Size size) {
    return pictureOf<float>(size, [&](int x, int y) {
        const double r = std::hypot(x - size.width / 2.0, y - size.height / 2.0);
        return r < size.height / 4.0 ? 0.9F : 0.4F * float(y) / float(size.height);
    });
}

// A quilt whose views are pictures of their own.
cv::Mat numberedQuilt(const QuiltLayout& layout) {
    cv::Mat quilt(layout.size(), CV_8UC3, cv::Scalar::all(0));
    for (int i = 0; i < layout.viewCount; ++i)
        movingPicture(layout.tileSize, 7 * i).copyTo(quilt(layout.tile(i)));
    return quilt;
}

QuiltLayout smallLayout() {
    QuiltLayout layout;
    layout.columns = 3;
    layout.rows = 2;
    layout.tileSize = {64, 48};
    layout.viewCount = 5; // one tile is not used
    return layout;
}

PhotoFit asItIs(cv::Size size) {
    return swayFit(size, double(size.width) / size.height, size);
}

} // namespace

TEST(Sway, AWholePhotoIsFittedInItsOwnShape) {
    PlacementOptions flat;
    flat.views.strengthPercent = 0; // without margins
    const PhotoFit own = swayFitOf({641, 480}, flat);
    EXPECT_EQ(own.size, swaySize({641, 480}, 641.0 / 480));
    EXPECT_EQ(own.source.height, 480);
    EXPECT_EQ(own.target.size(), own.size);
    flat.fit = FitMode::Contain;
    const PhotoFit other = swayFitOf({640, 480}, flat, {}, {100, 200});
    EXPECT_EQ(other.size, cv::Size(100, 200));
    EXPECT_EQ(other.target.size(), cv::Size(100, 75));
    EXPECT_EQ(swayFitOf({30000, 3}, flat).source.width, 30000) << "squeezed to 100 : 1";
    EXPECT_THROW(swayFitOf({0, 3}, flat), Error);
}

TEST(SwayPath, IsASineThatBeginsInTheMiddle) {
    for (const int frames : {4, 8, 12, 120, 1000}) {
        for (int k = 0; k < frames; ++k) {
            const double position = swayPosition(k, frames);
            ASSERT_NEAR(position, std::sin(2 * CV_PI * k / frames), 1e-12) << k << " of " << frames;
            if (k % (frames / 4) == 0) { // the middle and both ends, exactly
                EXPECT_EQ(position, std::round(position));
            }
            EXPECT_EQ(position, swayPosition(k + frames, frames)); // no seam
            // the way back has the places of the way there
            EXPECT_EQ(position, swayPosition((frames / 2 - k + frames) % frames, frames));
        }
    }
}

TEST(SwayPath, ATurnIsAMultipleOfFourFrames) {
    SwayOptions options;
    EXPECT_EQ(framesPerTurn(options), 120);
    options.frameRate = {30000, 1001};
    EXPECT_EQ(framesPerTurn(options), 120);
    options.frameRate = {25, 1};
    options.secondsPerTurn = 3;
    EXPECT_EQ(framesPerTurn(options), 76); // of 75
    options.secondsPerTurn = 0.1;
    options.frameRate = {1, 1};
    EXPECT_EQ(framesPerTurn(options), 4);
}

TEST(SwayPath, BadValuesAreNamed) {
    const auto messageOf = [](const auto& change) {
        SwayOptions options;
        change(options);
        return errorOf([&] { validate(options); });
    };
    EXPECT_EQ(messageOf([](SwayOptions&) {}), "(no error)");
    EXPECT_TRUE(
        holds(messageOf([](SwayOptions& o) { o.secondsPerTurn = 0; }), "secondsPerTurn: is 0 s"));
    EXPECT_TRUE(holds(messageOf([](SwayOptions& o) { o.secondsPerTurn = std::nan(""); }),
                      "secondsPerTurn"));
    EXPECT_TRUE(holds(messageOf([](SwayOptions& o) { o.turns = 0; }), "turns: is 0"));
    EXPECT_TRUE(holds(messageOf([](SwayOptions& o) { o.frameRate.numerator = 500; }),
                      "frameRate: is 500/1"));
    EXPECT_TRUE(holds(errorOf([] { swayPosition(0, 6); }), "framesPerTurn"));
    EXPECT_TRUE(holds(errorOf([] { swayPosition(-1, 8); }), "frame: is -1"));
}

TEST(SwaySize, KeepsShapeAndFitsEveryPlayer) {
    const auto size = [](int width, int height) {
        return swaySize({width, height}, double(width) / height);
    };
    EXPECT_EQ(size(4000, 3000), cv::Size(1440, 1080));
    EXPECT_EQ(size(3000, 4000), cv::Size(1080, 1440)); // standing pictures stand
    EXPECT_EQ(size(3840, 2160), cv::Size(1920, 1080));
    EXPECT_EQ(size(8000, 2000), cv::Size(1920, 480));
    EXPECT_EQ(size(640, 480), cv::Size(640, 480)); // never enlarged
    EXPECT_EQ(size(1001, 667), cv::Size(1000, 666));
    EXPECT_EQ(size(3, 3), cv::Size(16, 16));
    EXPECT_EQ(size(20000, 1), cv::Size(1800, 18)); // counts as 100 : 1
    EXPECT_NE(errorOf([] { swaySize({0, 5}, 1); }), "(no error)");
    EXPECT_NE(errorOf([] { swaySize({5, 5}, 0); }), "(no error)");
}

TEST(SwaySize, NoSideOfATileShrinksToMakeItsPixelsSquare) {
    EXPECT_EQ(swaySize({420, 560}, 0.75), cv::Size(420, 560));
    EXPECT_EQ(swaySize({512, 512}, 16.0 / 9), cv::Size(910, 512));
    EXPECT_EQ(swaySize({512, 512}, 0.5), cv::Size(512, 1024));
}

TEST(SwaySize, OddSidesLoseALineAndAreNotResampled) {
    const cv::Size photo(101, 67);
    const PhotoFit fit = swayFit(photo, 101.0 / 67, swaySize(photo, 101.0 / 67));
    EXPECT_EQ(fit.size, cv::Size(100, 66));
    EXPECT_EQ(fit.source.height, 66);
    EXPECT_EQ(fit.source.width, 100);
}

TEST(SwaySize, TilesAreShownInTheirShape) {
    // square tiles that show 16:9, on square px
    EXPECT_EQ(swayFit({512, 512}, 16.0 / 9, {910, 512}).source, cv::Rect(0, 0, 512, 512));
    const PhotoFit bars = swayFit({512, 512}, 2, {400, 400}, FitMode::Contain);
    EXPECT_EQ(bars.source, cv::Rect(0, 0, 512, 512));
    EXPECT_EQ(bars.target, cv::Rect(0, 100, 400, 200));
    const PhotoFit cut = swayFit({512, 512}, 2, {400, 400});
    EXPECT_EQ(cut.source, cv::Rect(128, 0, 256, 512));
    EXPECT_TRUE(holds(errorOf([] { swayFit({5, 5}, 1000, {16, 16}); }), "aspect"));
}

TEST(SwayView, OfAPhotoIsTheViewOfTheQuilt) {
    for (const cv::Size size : {cv::Size(61, 47), cv::Size(1, 2)}) {
        const cv::Mat photo = movingPicture(size, 3);
        const cv::Mat depth = discDepth(size);
        for (const ViewMethod method : {ViewMethod::Layered, ViewMethod::Fast, ViewMethod::Real}) {
            ViewOptions options;
            options.method = method;
            options.strengthPercent = 20;
            const SwayView view = photoViews({photo, depth}, options);
            cv::Mat picture;
            cv::Mat expected;
            for (const double position : {-1.0, -0.37, 0.0, 0.001, 0.5, 1.0}) {
                view(position, picture);
                Depth2Quilt(QuiltLayout(), options).renderView({photo, depth}, position, expected);
                EXPECT_TRUE(samePicture(picture, expected)) << position;
            }
            view(5, picture); // beyond the end is the end
            Depth2Quilt(QuiltLayout(), options).renderView({photo, depth}, 1, expected);
            EXPECT_TRUE(samePicture(picture, expected));
        }
    }
}

TEST(SwayView, OfAQuiltIsTheNearestTile) {
    const QuiltLayout layout = smallLayout();
    const cv::Mat quilt = numberedQuilt(layout);
    const SwayView view = quiltViews(quilt, layout, asItIs(layout.tileSize));
    cv::Mat picture;
    // five views stand at -1 -0.5 0 0.5 1
    const std::pair<double, int> cases[] = {{-1, 0},   {-0.76, 0}, {-0.74, 1}, {0, 2}, {0.24, 2},
                                            {0.26, 3}, {1, 4},     {9, 4},     {-9, 0}};
    for (const auto& [position, number] : cases) {
        view(position, picture);
        EXPECT_TRUE(samePicture(picture, quilt(layout.tile(number)))) << position;
    }
    EXPECT_TRUE(samePicture(quilt, numberedQuilt(layout))); // nothing was drawn into it
}

TEST(SwayView, OfAQuiltMayBlendTwoTiles) {
    const QuiltLayout layout = smallLayout();
    const cv::Mat quilt = numberedQuilt(layout);
    const SwayView view = quiltViews(quilt, layout, asItIs(layout.tileSize), ViewFilter::Linear);
    cv::Mat picture;
    for (int i = 0; i < layout.viewCount; ++i) { // at a view it is that view
        view(viewPosition(i, layout.viewCount), picture);
        EXPECT_TRUE(samePicture(picture, quilt(layout.tile(i))));
    }
    view(-0.875, picture); // a quarter of the way from view 0 to view 1
    cv::Mat expected(layout.tileSize, CV_8UC3);
    forPixels(expected.size(), [&](int x, int y) {
        for (int c = 0; c < 3; ++c) {
            const int a = quilt(layout.tile(0)).at<cv::Vec3b>(y, x)[c];
            const int b = quilt(layout.tile(1)).at<cv::Vec3b>(y, x)[c];
            expected.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<uchar>(0.75 * a + 0.25 * b);
        }
    });
    EXPECT_TRUE(samePicture(picture, expected, 1)); // halves are rounded either way
    EXPECT_TRUE(samePicture(quilt, numberedQuilt(layout)));
}

TEST(SwayView, WrongPicturesAreRefused) {
    const QuiltLayout layout = smallLayout();
    const PhotoFit fit = asItIs(layout.tileSize);
    EXPECT_TRUE(
        holds(errorOf([&] { quiltViews(cv::Mat(96, 191, CV_8UC3), layout, fit); }), "192 x 96"));
    EXPECT_TRUE(
        holds(errorOf([&] { quiltViews(cv::Mat(96, 192, CV_8UC1), layout, fit); }), "CV_8UC3"));
    const altiro3D::Scene wrong{cv::Mat(9, 9, CV_8UC3), cv::Mat(9, 8, CV_32FC1)};
    EXPECT_NE(errorOf([&] { return photoViews(wrong); }), "(no error)");
}

TEST(SwayView, APositionThatIsNoNumberIsRefused) {
    const QuiltLayout layout = smallLayout();
    const cv::Size size(61, 47);
    ViewOptions fast;
    fast.method = ViewMethod::Fast;
    cv::Mat picture;
    for (const SwayView& view : {quiltViews(numberedQuilt(layout), layout, asItIs(layout.tileSize)),
                                 photoViews({movingPicture(size, 3), discDepth(size)}),
                                 photoViews({movingPicture(size, 3), discDepth(size)}, fast)}) {
        EXPECT_EQ(errorOf([&] { view(std::nan(""), picture); }),
                  "position: is nan, expected a number");
        EXPECT_EQ(errorOf([&] { view(HUGE_VAL, picture); }), "(no error)"); // the end
    }
}

class WriteSway : public FileTest {};

TEST_F(WriteSway, FramesComeBackAsTheViewsOfThePath) {
    const fs::path file = directory / "sway.mp4";
    const cv::Size size(160, 120);
    const SwayView view = photoViews({movingPicture(size, 3), discDepth(size)});
    SwayOptions options;
    options.secondsPerTurn = 0.8;
    options.turns = 2;
    options.frameRate = {30000, 1001};
    std::vector<int> told;
    writeSway(file, size, options, view, [&](const VideoProgress& progress) {
        EXPECT_EQ(progress.framesInAll, 48);
        told.push_back(static_cast<int>(progress.frames));
        return true;
    });
    EXPECT_EQ(told.size(), 48U);
    VideoReader reader(file);
    EXPECT_EQ(reader.facts().codec, "h264");
    EXPECT_EQ(reader.facts().pixelFormat, "yuv420p");
    EXPECT_EQ(reader.facts().averageRate.numerator, 30000);
    EXPECT_EQ(reader.facts().averageRate.denominator, 1001);
    EXPECT_NEAR(reader.facts().duration.value_or(0), 48 * 1.001 / 30, 1e-3);
    const std::vector<VideoFrame> frames = allFrames(reader);
    ASSERT_EQ(frames.size(), 48U);
    cv::Mat expected;
    for (int i = 0; i < 48; ++i) {
        view(swayPosition(i, 24), expected);
        const VideoFrame& frame = frames[static_cast<std::size_t>(i)];
        EXPECT_GT(cv::PSNR(frame.picture, expected), 30) << i; // 4:2:0 and x264 cost the rest
        EXPECT_EQ(frame.pts * 30000, frames[1].pts * 30000 * i);
    }
}

TEST_F(WriteSway, CancellingLeavesNothing) {
    const SwayView view = [](double, cv::Mat& picture) {
        picture.create(48, 64, CV_8UC3);
        picture.setTo(cv::Scalar::all(9));
    };
    const auto untilFrame = [](int last) {
        return [last](const VideoProgress& progress) { return progress.frames < last; };
    };
    EXPECT_FALSE(writeSway(directory / "a.mp4", {64, 48}, {}, view, untilFrame(5)));
    EXPECT_TRUE(fs::is_empty(directory.path()));
    EXPECT_TRUE(writeSway(directory / "a.mp4", {64, 48}, {}, view, untilFrame(1000)));
    EXPECT_TRUE(fs::exists(directory / "a.mp4"));
}

TEST_F(WriteSway, AFailureLeavesNothing) {
    const SwayView view = [](double position, cv::Mat& picture) {
        if (position > 0.5) throw std::runtime_error("no more");
        picture.create(48, 64, CV_8UC3);
        picture.setTo(cv::Scalar::all(9));
    };
    EXPECT_THROW(writeSway(directory / "a.mp4", {64, 48}, {}, view), std::runtime_error);
    EXPECT_TRUE(holds(
        errorOf([&] { writeSway(directory / "a.mp4", cv::Size(63, 48), SwayOptions(), view); }),
        "63 x 48"));
    EXPECT_TRUE(holds(
        errorOf([&] { writeSway(directory / "a.gif", cv::Size(64, 48), SwayOptions(), view); }),
        "a.gif"));
    EXPECT_TRUE(fs::is_empty(directory.path()));
}

} // namespace altiro3D::test
