// The command lines of the original altiro3D give what our tools give.

#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"
#include "support/video.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kImage = "altiro3Dimage";
const Arguments kShort{"--seconds", "0.2", "--turns", "1"};

// The original's studio: a map instead of a calibration.
class OriginalStudio : public SmallStudio {
  public:
    OriginalStudio() {
        EXPECT_TRUE(isDone(run("altiro3Dnative", goodCall("altiro3Dnative", "small.map"))));
        // of the quilt's size, and not: both can be cut into 2 x 3 views
        fs::copy(*this / "quilt.png", *this / "collage.png");
        fs::copy(*this / "photo.png", *this / "photo_qs3x2a0.75.png");
    }
    Arguments map() const { return {"-m", "small.map", "-q", "2x3", "-r", "40x30"}; }

    // Both calls succeed and give the same picture.
    void expectSame(const std::string& original, const std::string& ours, const Arguments& call) {
        for (const char* output : {"a.png", "b.png"})
            fs::remove(*this / output);
        const Outcome first = run(original, call + Arguments{"a.png"});
        const Outcome second = run(ours, call + Arguments{"b.png"});
        EXPECT_EQ(first.status, 0) << first.text();
        EXPECT_EQ(second.status, 0) << second.text();
        EXPECT_TRUE(slurp(*this / "a.png") == slurp(*this / "b.png")) << first.text();
    }

    // With --lg as without; b.mp4 is there, or comes of the second call.
    void expectSameWithVideo(const Arguments& options, const std::string& picture,
                             const std::string& ours, const Arguments& call) {
        for (const char* output : {"a.png", "a.mp4", "b.png"})
            fs::remove(*this / output);
        const Outcome first =
            run(kImage, kShort + options + Arguments{"--lg=a.mp4", picture, "a.png"});
        const Outcome second = run(ours, call + Arguments{picture, "b.png"});
        EXPECT_EQ(first.status, 0) << first.text();
        EXPECT_EQ(second.status, 0) << second.text();
        EXPECT_TRUE(slurp(*this / "a.png") == slurp(*this / "b.png")) << first.text();
        EXPECT_TRUE(slurp(*this / "a.mp4") == slurp(*this / "b.mp4")) << first.text();
    }
};

} // namespace

TEST(OriginalCommands, OptionsOfPhotosMakeAPhoto) {
    OriginalStudio studio;
    for (const Arguments& options :
         {Arguments{"-k"}, Arguments{"-g"}, Arguments{"--strength", "5"}, Arguments{"-y", "-k"}}) {
        studio.expectSame(kImage, "photo2native", studio.map() + options + Arguments{"quilt.png"});
    }
    studio.expectSame(kImage, "photo2native",
                      studio.map() + Arguments{"-d", "quilt.png", "depth.png"});
}

TEST(OriginalCommands, NetworksMakeAPhoto) {
    OriginalStudio studio;
    const Outcome outcome = studio.run(kImage, Arguments{"-n", "none.onnx"} + studio.map() +
                                                   Arguments{"quilt.png", "a.png"});
    EXPECT_EQ(outcome.status, 1) << outcome.text();
    EXPECT_EQ(outcome.err.rfind("photo2native: error: none.onnx: ", 0), 0U) << outcome.text();
}

TEST(OriginalCommands, WithoutArgumentsNoToolIsGuessed) {
    Sandbox studio;
    const Outcome outcome = studio.run(kImage, {});
    EXPECT_EQ(outcome.status, 2) << outcome.text();
    EXPECT_EQ(outcome.err.rfind("altiro3Dimage: error: expected a picture", 0), 0U)
        << outcome.text();
}

TEST(OriginalCommands, SwayingVideosOfPhotosAreThoseOfPhoto2native) {
    OriginalStudio studio;
    studio.expectSameWithVideo(studio.map(), "photo.png", "photo2native",
                               studio.map() + kShort + Arguments{"-y", "--lg", "b.mp4"});
    // an option of photos decides
    studio.expectSameWithVideo(studio.map() + Arguments{"-k"}, "collage.png", "photo2native",
                               studio.map() + kShort + Arguments{"-yk", "--lg", "b.mp4"});
    fs::create_directory(studio / "in");
    fs::copy(studio / "photo.png", studio / "in/one.png");
    EXPECT_EQ(
        studio.run(kImage, studio.map() + kShort + Arguments{"--lg", "videos", "in", "out"}).status,
        0);
    EXPECT_TRUE(fs::exists(studio / "videos/one.mp4"));
}

TEST(OriginalCommands, SwayingVideosOfQuiltsAreThoseOfQuilt2video) {
    OriginalStudio studio;
    const auto expect = [&](const Arguments& options, const std::string& quilt,
                            const Arguments& ofNative, const Arguments& ofVideo) {
        const Arguments video = Arguments{"-y"} + kShort + ofVideo + Arguments{quilt, "b.mp4"};
        EXPECT_TRUE(isDone(studio.run("quilt2video", video)));
        studio.expectSameWithVideo(options, quilt, "quilt2native", ofNative);
    };
    expect(studio.map(), "collage.png", studio.map(), {"-q", "2x3"});
    const Arguments mapAlone{"-m", "small.map"}; // the layout is the map's
    expect(mapAlone, "collage.png", mapAlone, {"-q", "2x3"});
    const Arguments calibration{"-c", "small.json"};
    expect(calibration, "photo_qs3x2a0.75.png", calibration, calibration);
    const Arguments serial = calibration + Arguments{"--serial", "TEST-1"};
    expect(serial, "photo_qs3x2a0.75.png", serial, serial);
    // options of one of the two, and of both
    const Arguments linear = studio.display() + Arguments{"--view-filter=linear", "--fit", "cover"};
    const Arguments native{"--sampling", "linear", "--invert=on"};
    const Arguments video{"--size", "64x32", "--fps=20", "--aspect", "1.5"};
    expect(native + linear + video, "collage.png", linear + native,
           video + Arguments{"-c", "small.json", "-q", "2x3", "--view-filter", "linear"});
    // a display's serial number is of no use for the video alone
    studio.set("LKG_CALIBRATION", (studio / "small.json").string());
    const Arguments found{"--serial", "TEST-1", "-q2x3", "-r40x30"};
    expect(found, "collage.png", found, {"-q", "2x3"});
}

TEST(OriginalCommands, OfAQuiltBothAreMadeOrNone) {
    OriginalStudio studio;
    spill(studio / "precious.mp4", "precious");
    fs::create_hard_link(studio / "small.map", studio / "map.mp4");
    struct Case {
        Arguments arguments; // after those of the display
        int status;
        std::string error;
    };
    const Case cases[] = {
        {{"--lg", "s.mp4", "--fps", "0", "collage.png", "a.png"}, 2, "quilt2video: error: --fps"},
        {{"--lg", "s.gif", "collage.png", "a.png"}, 2, "quilt2video: error: s.gif: no video"},
        {{"--lg", "precious.mp4", "collage.png", "a.png"},
         1,
         "quilt2video: error: precious.mp4: exists"},
        {{"--lg", "no/s.mp4", "collage.png", "a.png"}, 1, "quilt2video: error: no/s.mp4: "},
        {{"--lg", "s.mp4", "collage.png", "no/a.png"}, 1, "quilt2native: error: no/a.png: "},
        {{"--lg", "s.mp4", "collage.png", "photo.png"}, 1, "quilt2native: error: photo.png: "},
        {{"--lg", "s.mp4", "collage.png", "a"}, 2, "quilt2native: error: a: no picture"},
        {{"--lg", "s.mp4", "collage.png", "s.MP4"}, 2, "altiro3Dimage: error: s.MP4: is a video"},
        {{"-y", "--lg", "map.mp4", "collage.png", "a.png"}, 2, "altiro3Dimage: error: map.mp4: "},
        {{"--lg", "a.png", "collage.png", "a.png"}, 2, "altiro3Dimage: error: a.png: is another"},
        {{"--lg", "s.mp4", "--nonsense", "collage.png", "a.png"}, 2, "photo2native: error: "},
        {{"--fps", "20", "collage.png", "a.png"}, 2, "photo2native: error: --seconds, --turns"},
        {{"--lg", "", "collage.png", "a.png"}, 2, "photo2native: error: --lg is empty"},
        {{"collage.png", "a.png", "--lg"}, 2, "photo2native: error: Missing value after '--lg'"},
        {{"--lg", "s.mp4", "collage.png"}, 2, "photo2native: error: expected PHOTO and OUT"}};
    for (const auto& [arguments, status, error] : cases) {
        const Outcome outcome = studio.run(kImage, studio.map() + arguments);
        EXPECT_EQ(outcome.status, status) << outcome.text();
        EXPECT_EQ(outcome.err.rfind(error, 0), 0U) << outcome.text();
        EXPECT_EQ(outcome.errLines().size(), 1U) << outcome.text();
        for (const char* output : {"a.png", "s.mp4", "s.MP4", "s.gif"})
            EXPECT_FALSE(fs::exists(studio / output)) << output << "\n" << outcome.text();
    }
    EXPECT_EQ(slurp(studio / "precious.mp4"), "precious");
    // what was there before stays, as a new one
    spill(studio / "a.png", "old");
    EXPECT_EQ(
        studio.run(kImage, studio.map() + Arguments{"-y", "--lg", "s.gif", "collage.png", "a.png"})
            .status,
        2);
    EXPECT_EQ(readBack(studio / "a.png").size(), cv::Size(96, 128));
}

TEST(OriginalCommands, APictureOfTheQuiltsSizeIsAQuilt) {
    OriginalStudio studio;
    studio.expectSame(kImage, "quilt2native", studio.map() + Arguments{"collage.png"});
    studio.expectSame(kImage, "quilt2native", {"-m", "small.map", "collage.png"});
    studio.expectSame(kImage, "quilt2native", studio.display() + Arguments{"collage.png"});
    studio.expectSame(kImage, "quilt2native",
                      {"--map=small.map", "--quilt=2x3", "-v", "collage.png"});
}

TEST(OriginalCommands, ANameCanSayQuilt) {
    OriginalStudio studio;
    studio.expectSame(kImage, "quilt2native", {"-c", "small.json", "photo_qs3x2a0.75.png"});
}

TEST(OriginalCommands, AnyOtherPictureIsAPhoto) {
    OriginalStudio studio;
    studio.expectSame(kImage, "photo2native", studio.map() + Arguments{"photo.png"});
    studio.expectSame(kImage, "photo2native", studio.display() + Arguments{"photo.png"});
}

TEST(OriginalCommands, TakeOddNames) {
    OriginalStudio studio;
    const std::string odd = "-k it's \"a\" $(touch bad) * \n photo.png";
    fs::copy(studio / "photo.png", studio / odd);
    fs::copy(studio / "collage.png", studio / ("q" + odd));
    studio.expectSame(kImage, "photo2native", studio.map() + Arguments{"--", odd});
    studio.expectSame(kImage, "quilt2native", studio.map() + Arguments{"q" + odd});
    fs::rename(studio / "small.map", studio / "-k.map");
    studio.expectSame(kImage, "quilt2native", {"-m", "-k.map", "collage.png"});
    fs::rename(studio / "views", studio / "my -h views");
    studio.expectSame("images2native", "views2native", studio.display() + Arguments{"my -h views"});
    fs::rename(studio / ("q" + odd), studio / ("-q" + odd));
    EXPECT_EQ(studio
                  .run(kImage, kShort + Arguments{"-m", "-k.map", "--lg", "-s \n.mp4", "--",
                                                  "-q" + odd, "-n \n.png"})
                  .status,
              0);
    EXPECT_TRUE(fs::exists(studio / "-s \n.mp4"));
    EXPECT_TRUE(fs::exists(studio / "-n \n.png"));
    EXPECT_FALSE(fs::exists(studio / "bad"));
}

TEST(OriginalCommands, ViewsBecomeANative) {
    OriginalStudio studio;
    studio.expectSame("images2native", "views2native", studio.map() + Arguments{"views"});
}

TEST(OriginalCommands, VideosBecomeNativeVideos) {
    ALTIRO3D_REQUIRE_FFMPEG();
    OriginalStudio studio;
    ffmpeg("-f lavfi -i testsrc2=size=60x80:rate=10:duration=0.5 '" +
           (studio / "flat.mp4").string() + "'");
    const Outcome outcome =
        studio.run("altiro3Dvideo", studio.map() + Arguments{"-k", "flat.mp4", "native.mp4"});
    EXPECT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_EQ(ffprobe(studio / "native.mp4", "stream=width,height", "-select_streams v:0"),
              "96|128\n");
}

TEST(OriginalCommands, FailuresAreThoseOfTheTools) {
    OriginalStudio studio;
    for (const char* command : {kImage, "altiro3Dvideo", "images2native"}) {
        EXPECT_EQ(studio.run(command, {}).status, 2) << command;
        EXPECT_EQ(studio.run(command, {"--nonsense", "a", "b.png"}).status, 2) << command;
        const Outcome missing = studio.run(
            command,
            studio.map() +
                Arguments{"none", std::string(command) == "altiro3Dvideo" ? "b.mp4" : "b.png"});
        EXPECT_EQ(missing.status, 1) << missing.text();
        EXPECT_EQ(missing.errLines().size(), 1U) << missing.text();
        EXPECT_NE(missing.err.find(": error: none: "), std::string::npos) << missing.text();
        const Outcome help = studio.run(command, {"--help"});
        EXPECT_TRUE(isDone(help));
        EXPECT_EQ(help.out.rfind("Usage: " + std::string(command) + " ", 0), 0U) << help.text();
    }
}

TEST(OriginalCommands, AnswerInTheirOwnNames) {
    Sandbox studio;
    for (const char* command : {kImage, "altiro3Dvideo", "images2native"}) {
        const std::string version = studio.run("photo2native", {"--version"}).out;
        const Outcome outcome = studio.run(command, {"--version"});
        EXPECT_TRUE(isDone(outcome));
        EXPECT_EQ(outcome.out, command + version.substr(version.find(' ')));
        // made when the commands are built
        EXPECT_TRUE(fails(studio.run(command, {"--help-man"}), 2, "Unknown option 'help-man'"));
        EXPECT_TRUE(fails(studio.run(command, {"--help-completion", "bash"}), 2,
                          "Unknown option 'help-completion'"));
    }
}

} // namespace altiro3D::test
