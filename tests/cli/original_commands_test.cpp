// The command lines of the original altiro3D give the same results as our tools.

#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"
#include "support/texts.hpp"
#include "support/video.hpp"

#include <opencv2/core/mat.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kImage = "altiro3Dimage";
const Arguments kShort("--seconds 0.2 --turns 1");

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

    // The same for a.mp4 of --lg and b.mp4 of the second call.
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
         {Arguments{"-k"}, Arguments{"-g"}, Arguments("--strength 5"), Arguments("-y -k")}) {
        studio.expectSame(kImage, "photo2native", studio.map() + options + Arguments{"quilt.png"});
    }
    studio.expectSame(kImage, "photo2native", studio.map() + Arguments("-d quilt.png depth.png"));
}

TEST(OriginalCommands, NetworksMakeAPhoto) {
    OriginalStudio studio;
    const Outcome outcome =
        studio.run(kImage, Arguments("-n none.onnx") + studio.map() + Arguments("quilt.png a.png"));
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
                               studio.map() + kShort + Arguments("-y --lg b.mp4"));
    // an option of photos decides
    studio.expectSameWithVideo(studio.map() + Arguments{"-k"}, "collage.png", "photo2native",
                               studio.map() + kShort + Arguments("-yk --lg b.mp4"));
    fs::create_directory(studio / "in");
    fs::copy(studio / "photo.png", studio / "in/one.png");
    EXPECT_EQ(studio.run(kImage, studio.map() + kShort + Arguments("--lg videos in out")).status,
              0);
    EXPECT_TRUE(fs::exists(studio / "videos/one.mp4"));
}

TEST(OriginalCommands, SwayingVideosOfQuiltsAreThoseOfQuilt2native) {
    OriginalStudio studio;
    for (const Arguments& options :
         {studio.map(), Arguments("-m small.map"),
          studio.display() +
              Arguments("--sampling linear --view-filter=linear --size 64x32 --fit cover")}) {
        studio.expectSameWithVideo(options, "collage.png", "quilt2native",
                                   options + kShort + Arguments("-y --lg b.mp4"));
    }
}

TEST(OriginalCommands, APictureOfTheQuiltsSizeIsAQuilt) {
    OriginalStudio studio;
    studio.expectSame(kImage, "quilt2native", studio.map() + Arguments{"collage.png"});
    studio.expectSame(kImage, "quilt2native", "-m small.map collage.png");
    studio.expectSame(kImage, "quilt2native", studio.display() + Arguments{"collage.png"});
    studio.expectSame(kImage, "quilt2native", "--map=small.map --layout=2x3 -v collage.png");
}

TEST(OriginalCommands, ANameCanSayQuilt) {
    OriginalStudio studio;
    studio.expectSame(kImage, "quilt2native", "-c small.json photo_qs3x2a0.75.png");
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
    studio.expectSame(kImage, "quilt2native", "-m -k.map collage.png");
    fs::rename(studio / "views", studio / "my -h views");
    studio.expectSame("images2native", "views2native", studio.display() + Arguments{"my -h views"});
    fs::rename(studio / ("q" + odd), studio / ("-q" + odd));
    EXPECT_TRUE(isDone(studio.run(kImage, {"-m", "-k.map", "--", "-q" + odd, "-n \n.png"})));
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
        studio.run("altiro3Dvideo", studio.map() + Arguments("-k flat.mp4 native.mp4"));
    EXPECT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_EQ(ffprobe(studio / "native.mp4", "stream=width,height", "-select_streams v:0"),
              "96|128\n");
}

TEST(OriginalCommands, FailuresAreThoseOfTheTools) {
    OriginalStudio studio;
    for (const char* command : {kImage, "altiro3Dvideo", "images2native"}) {
        EXPECT_EQ(studio.run(command, {}).status, 2) << command;
        EXPECT_EQ(studio.run(command, "--nonsense a b.png").status, 2) << command;
        const Outcome missing = studio.run(
            command,
            studio.map() +
                Arguments{"none", std::string(command) == "altiro3Dvideo" ? "b.mp4" : "b.png"});
        EXPECT_EQ(missing.status, 1) << missing.text();
        EXPECT_EQ(missing.errLines().size(), 1U) << missing.text();
        EXPECT_TRUE(holds(missing.err, ": error: none: "));
        const Outcome help = studio.run(command, "--help");
        EXPECT_TRUE(isDone(help));
        EXPECT_EQ(help.out.rfind("Usage: " + std::string(command) + " ", 0), 0U) << help.text();
    }
}

TEST(OriginalCommands, AnswerInTheirOwnNames) {
    Sandbox studio;
    for (const char* command : {kImage, "altiro3Dvideo", "images2native"}) {
        const std::string version = studio.run("photo2native", "--version").out;
        const Outcome outcome = studio.run(command, "--version");
        EXPECT_TRUE(isDone(outcome));
        EXPECT_EQ(outcome.out, command + version.substr(version.find(' ')));
        // made when the commands are built
        EXPECT_TRUE(fails(studio.run(command, "--help-man"), 2, "Unknown option 'help-man'"));
        EXPECT_TRUE(fails(studio.run(command, "--help-completion bash"), 2,
                          "Unknown option 'help-completion'"));
    }
}

} // namespace altiro3D::test
