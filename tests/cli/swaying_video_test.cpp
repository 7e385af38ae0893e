// quilt2video, and photo2native --lg: videos that swing through the views.

#include "altiro3D/altiro3D.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/video.hpp"

#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

// 4:2:0 and the encoder leave this much of small, colourful pictures, dB.
constexpr double kMinPsnr = 26;

const Arguments kShort = {"--seconds", "0.4", "--turns", "2"}; // 2 x 12 frames

std::vector<cv::Mat> framesOf(const fs::path& file) {
    VideoReader reader(file);
    std::vector<cv::Mat> pictures;
    for (const VideoFrame& frame : allFrames(reader))
        pictures.push_back(frame.picture);
    return pictures;
}

// A studio whose pictures survive an encoder.
class VideoStudio : public SmallStudio {
  public:
    VideoStudio() {
        writeImage(*this / "photo.png", movingPicture({90, 120}, 3));
        cv::Mat quilt(80, 90, CV_8UC3);
        for (int i = 0; i < 6; ++i)
            movingPicture({30, 40}, 9 * i)
                .copyTo(quilt(cv::Rect(i % 3 * 30, (1 - i / 3) * 40, 30, 40)));
        writeImage(*this / "quilt.png", quilt);
    }

    Outcome photo(const Arguments& more) const {
        return run("photo2native",
                   display() + kShort + more + Arguments("-d photo.png depth.png native.png"));
    }
    Outcome quilt(const Arguments& more) const { return run("quilt2video", kShort + more); }

    // The views of photo.png by calls of the library alone.
    SwayView views(cv::Size size, const ViewOptions& options = {}) const {
        const cv::Mat photo = readPhoto(*this / "photo.png");
        cv::Mat depth;
        normalizeDepth(readDepthImage(*this / "depth.png"), depth);
        const PhotoFit fit = swayFit(photo.size(), double(photo.cols) / photo.rows, size);
        cv::Mat fittedPhoto;
        cv::Mat fittedDepth;
        applyFit(photo, fit, fittedPhoto);
        applyFitToDepth(depth, photo.size(), fit, fittedPhoto, options.focus, fittedDepth);
        refineDepth(fittedPhoto, fittedDepth, fittedDepth); // no bars: the photo has its own shape
        return photoViews({fittedPhoto, fittedDepth}, options);
    }
};

// 24 frames of 12 positions that are those of `view`.
void expectViews(const fs::path& file, const SwayView& view) {
    const std::vector<cv::Mat> frames = framesOf(file);
    ASSERT_EQ(frames.size(), 24U);
    cv::Mat expected;
    for (int i = 0; i < 24; ++i) {
        view(swayPosition(i, 12), expected);
        const cv::Mat& frame = frames[static_cast<std::size_t>(i)];
        ASSERT_EQ(frame.size(), expected.size());
        const double psnr = cv::PSNR(frame, expected);
        EXPECT_GT(psnr, kMinPsnr) << file << " " << i;
        if (std::abs(swayPosition(i, 12)) < 0.4) continue;
        view(-swayPosition(i, 12), expected);
        EXPECT_GT(psnr, cv::PSNR(frame, expected) + 1) << "the other way round, " << i;
    }
}

} // namespace

TEST(SwayingVideo, OfAPhotoSwingsThroughItsViews) {
    const VideoStudio studio;
    EXPECT_TRUE(isDone(studio.run("photo2native", studio.goodCall("photo2native", "native.png"))));
    const std::string native = slurp(studio / "native.png");
    EXPECT_TRUE(says(studio.photo("-y --lg a.mp4"), "a.mp4: video, 90 x 120 px, 24 frames, 0.8 s"));
    EXPECT_TRUE(slurp(studio / "native.png") == native);
    expectViews(studio / "a.mp4", studio.views({90, 120}));
}

TEST(SwayingVideo, PlaysEverywhere) {
    ALTIRO3D_REQUIRE_FFMPEG();
    const VideoStudio studio;
    EXPECT_TRUE(isDone(studio.photo("--lg a.mp4 --fps 25 --seconds 2")));
    EXPECT_EQ(lines(ffprobe(studio / "a.mp4",
                            "stream=codec_name,profile,width,height,pix_fmt,r_frame_rate,"
                            "avg_frame_rate,start_time,duration,nb_read_frames",
                            "-count_frames")),
              lines("h264|High|90|120|yuv420p|25/1|25/1|0.000000|4.160000|104"));
    EXPECT_TRUE(isDone(studio.photo("-y --lg b.mp4 --fps 29.97")));
    EXPECT_EQ(
        lines(ffprobe(studio / "b.mp4", "stream=r_frame_rate,nb_read_frames", "-count_frames")),
        lines("30000/1001|24"));
}

TEST(SwayingVideo, KnowsAllOptionsOfThePhoto) {
    const VideoStudio studio;
    ViewOptions real;
    real.method = ViewMethod::Real;
    EXPECT_TRUE(isDone(studio.photo("-g --looking g.mp4")));
    expectViews(studio / "g.mp4", studio.views({90, 120}, real));
    ViewOptions strong;
    strong.strengthPercent = 25;
    strong.focus = 0.2;
    EXPECT_TRUE(isDone(studio.photo(
        "-y -k --continuous --strength 25 --focus 0.2 --lg k.mp4 --save-depth d.png")));
    expectViews(studio / "k.mp4", studio.views({90, 120}, strong));
    EXPECT_TRUE(isDone(studio.photo("-y --size 60x64 --lg s.mkv")));
    expectViews(studio / "s.mkv", studio.views({60, 64}));
    // estimated depth, and a photo with odd sides
    writeImage(studio / "odd.png", movingPicture({91, 67}, 4));
    EXPECT_TRUE(isDone(
        studio.convert("photo2native", kShort + Arguments("--lg odd.mp4 odd.png odd_native.png"))));
    EXPECT_EQ(framesOf(studio / "odd.mp4").at(0).size(), cv::Size(90, 66));
    EXPECT_GT(cv::PSNR(framesOf(studio / "odd.mp4").at(0),
                       readBack(studio / "odd.png")(cv::Rect(0, 0, 90, 66))),
              kMinPsnr);
}

TEST(SwayingVideo, IsInTheReport) {
    const VideoStudio studio;
    EXPECT_TRUE(isDone(studio.photo("--lg a.mp4 --report r.json")));
    const Json report = studio.json("r.json");
    EXPECT_EQ(report["settings"]["video"]["secondsPerTurn"], 0.4);
    EXPECT_EQ(report["settings"]["video"]["turns"], 2);
    EXPECT_EQ(report["settings"]["video"]["framesPerSecond"], 30);
    const Json expected = {{"file", "a.mp4"}, {"width", 90}, {"height", 120}, {"frames", 24}};
    EXPECT_EQ(report["pictures"][0]["video"], expected);
    EXPECT_TRUE(report["pictures"][0]["milliseconds"].contains("video"));
    EXPECT_TRUE(isDone(studio.convert("photo2native", "-y --report r.json photo.png native.png")));
    EXPECT_FALSE(studio.json("r.json")["settings"].contains("video"));
}

TEST(SwayingVideo, OfSeveralPhotosGoIntoADirectory) {
    const VideoStudio studio;
    fs::create_directory(studio / "in");
    fs::copy(studio / "photo.png", studio / "in/one.png");
    fs::copy(studio / "photo.png", studio / "in/two.png");
    const Arguments call = studio.display() + kShort + Arguments("--lg videos in out");
    EXPECT_TRUE(isDone(studio.run("photo2native", call)));
    for (const char* name : {"one", "two"}) {
        EXPECT_EQ(framesOf(studio / ("videos/" + std::string(name) + ".mp4")).size(), 24U);
        EXPECT_TRUE(fs::exists(studio / ("out/" + std::string(name) + "_native.png")));
    }
    // a bad photo leaves no video and does not stop the rest
    spill(studio / "in/one.png", "broken");
    fs::remove_all(studio / "videos");
    EXPECT_TRUE(fails(studio.run("photo2native", Arguments{"-y"} + call), 1, "one.png"));
    EXPECT_FALSE(fs::exists(studio / "videos/one.mp4"));
    EXPECT_EQ(framesOf(studio / "videos/two.mp4").size(), 24U);
}

TEST(SwayingVideo, ThatCannotGrowLeavesNothing) {
    VideoStudio studio;
    fs::create_directory(studio / "out");
    studio.limitFiles(2048);
    EXPECT_TRUE(fails(studio.photo("--lg out/a.mp4"), 1, "a.mp4: cannot be written"));
    EXPECT_TRUE(fails(studio.quilt("-q 2x3 quilt.png out/a.mp4"), 1, "a.mp4: cannot be written"));
    EXPECT_TRUE(fs::is_empty(studio / "out"));
    EXPECT_FALSE(fs::exists(studio / "native.png")); // the Native comes last
}

TEST(SwayingVideo, OfAQuiltSwingsThroughItsTiles) {
    const VideoStudio studio;
    const cv::Mat quilt = readBack(studio / "quilt.png");
    const QuiltLayout layout = smallLayout();
    const PhotoFit fit = swayFit({30, 40}, 0.75, {30, 40});
    const Outcome outcome = studio.quilt("-q 2x3 quilt.png a.mp4");
    EXPECT_TRUE(says(outcome, "3 columns x 2 rows, each view 30 x 40 px"));
    EXPECT_TRUE(holds(outcome.out, "a.mp4: video, 30 x 40 px, 24 frames, 0.8 s"));
    expectViews(studio / "a.mp4", quiltViews(quilt, layout, fit));
    EXPECT_TRUE(isDone(studio.quilt("-q 2x3 --view-filter linear quilt.png b.mp4")));
    expectViews(studio / "b.mp4", quiltViews(quilt, layout, fit, ViewFilter::Linear));
}

TEST(SwayingVideo, OfAQuiltThatIsStoppedLeavesNothing) {
    const VideoStudio studio;
    const Outcome outcome = studio.run(
        "quilt2video", "-q 2x3 --seconds 60 --turns 100 quilt.png sway.mp4", SIGINT, [&] {
            return fs::exists(studio / "sway.mp4.part"); // while it is written
        });
    EXPECT_EQ(outcome.status, 130) << outcome.text();
    EXPECT_TRUE(holds(outcome.err, "stopped; the output was not made"));
    EXPECT_FALSE(fs::exists(studio / "sway.mp4.part"));
    EXPECT_FALSE(fs::exists(studio / "sway.mp4"));
}

TEST(SwayingVideo, OfAQuiltKnowsItsLayoutAndShape) {
    const VideoStudio studio;
    const auto sizeOf = [&](const Arguments& arguments) {
        EXPECT_TRUE(isDone(studio.quilt(Arguments{"-y"} + arguments + Arguments{"a.mp4"})));
        return framesOf(studio / "a.mp4").at(0).size();
    };
    fs::copy(studio / "quilt.png", studio / "q_qs3x2a0.75.png");
    fs::copy(studio / "quilt.png", studio / "wide_qs3x2a1.5.png");
    EXPECT_EQ(sizeOf("q_qs3x2a0.75.png"), cv::Size(30, 40));
    EXPECT_EQ(sizeOf("wide_qs3x2a1.5.png"), cv::Size(60, 40)); // px that are not square
    EXPECT_EQ(sizeOf("--aspect 0.5 wide_qs3x2a1.5.png"), cv::Size(30, 60));
    EXPECT_EQ(sizeOf("-q 2x3 -c small.json quilt.png"), cv::Size(30, 40));
    EXPECT_EQ(sizeOf("--size 64x32 q_qs3x2a0.75.png"), cv::Size(64, 32));
    // black bars with --fit contain
    EXPECT_EQ(sizeOf("--size 128x64 --fit contain q_qs3x2a0.75.png"), cv::Size(128, 64));
    const cv::Mat bars = framesOf(studio / "a.mp4").at(0);
    EXPECT_LT(cv::norm(bars.colRange(0, 32), cv::NORM_INF), 8);
    EXPECT_GT(cv::mean(bars.colRange(48, 80))[0], 20);
    // the display's own layout where nothing else is known
    const cv::Size quilt = defaultQuilt(readCalibration(studio / "small.json")).size();
    writeImage(studio / "usual.png", cv::Mat(quilt, CV_8UC3, cv::Scalar::all(80)));
    EXPECT_TRUE(isDone(studio.quilt("-y -c small.json usual.png a.mp4")));
}

TEST(SwayingVideo, OfAQuiltThatCannotBeMadeIsOneErrorLine) {
    const VideoStudio studio;
    spill(studio / "precious.mp4", "precious");
    fs::create_symlink("quilt.png", studio / "link.mp4");
    const std::pair<Arguments, std::pair<int, std::string>> cases[] = {
        {{}, {2, "quilt2video --help"}},
        {"quilt.png", {2, "expected QUILT and OUT, got 1"}},
        {"quilt.png a.mp4", {2, "quilt.png: its name does not state"}},
        {"-q 2x3 quilt.png a.png", {2, "a.png: no video format"}},
        {"-q 2y3 quilt.png a.mp4", {2, "-q"}},
        {"-q 2x3 --fps 1000 quilt.png a.mp4", {2, "--fps"}},
        {"-q 2x3 --aspect 99 quilt.png a.mp4", {2, "--aspect"}},
        {"-q 2x3 --fit some quilt.png a.mp4", {2, "--fit"}},
        {"-q 2x3 --view-filter some quilt.png a.mp4", {2, "--view-filter"}},
        {"-q 2x3 --serial some quilt.png a.mp4", {2, "-c with it"}},
        {"-q 200x300 quilt.png a.mp4", {1, "do not fit"}},
        {"-q 2x3 none.png a.mp4", {1, "none.png: does not exist"}},
        {"-q 2x3 small.json a.mp4", {1, "small.json"}},
        {"-q 2x3 quilt.png missing/a.mp4", {1, "there is no directory"}},
        {"-q 2x3 quilt.png precious.mp4", {1, "precious.mp4: exists"}},
        {"-y -q 2x3 quilt.png link.mp4", {2, "is also an input"}}};
    for (const auto& [arguments, expected] : cases) {
        EXPECT_TRUE(fails(studio.run("quilt2video", arguments), expected.first, expected.second));
        EXPECT_FALSE(fs::exists(studio / "a.mp4"));
    }
    EXPECT_EQ(slurp(studio / "precious.mp4"), "precious");
    EXPECT_TRUE(isDone(studio.quilt("-y -q 2x3 quilt.png precious.mp4")));
    EXPECT_EQ(framesOf(studio / "precious.mp4").size(), 24U);
}

} // namespace altiro3D::test
