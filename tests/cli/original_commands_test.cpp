// The command lines of the original altiro3D give the same results as our tools.

#include "sandbox.hpp"
#include "support/video.hpp"

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kImage = "altiro3Dimage";

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
};

} // namespace

TEST(OriginalCommands, ThePictureDecidesWhichToolMakesIt) {
    OriginalStudio studio;
    studio.expectSame(kImage, "photo2native", studio.map() + Arguments("-k collage.png"));
    studio.expectSame(kImage, "quilt2native", studio.map() + Arguments("collage.png"));
    const std::pair<Arguments, const char*> kinds[] = {
        {studio.map() + Arguments("collage.png"), "quilt"}, // of the quilt's size
        {"-m small.map collage.png", "quilt"},
        {studio.display() + Arguments("collage.png"), "quilt"},
        {"--map=small.map --layout=2x3 -v --lg=a.mp4 collage.png", "quilt"},
        {studio.display() + Arguments("--sampling linear --view-filter=linear collage.png"),
         "quilt"},
        {"-c small.json photo_qs3x2a0.75.png", "quilt"}, // by its name
        {studio.map() + Arguments("photo.png"), "photo"},
        {studio.display() + Arguments("photo.png"), "photo"},
        {studio.map() + Arguments("--lg videos views"), "photo"},
        // options of photos
        {studio.map() + Arguments("-g collage.png"), "photo"},
        {studio.map() + Arguments("--strength 5 collage.png"), "photo"},
        {studio.map() + Arguments("-y -k --lg=a.mp4 collage.png"), "photo"},
        {studio.map() + Arguments("-d collage.png depth.png"), "photo"}};
    for (const auto& [call, kind] : kinds) {
        const Outcome told =
            studio.run("quilt2native", Arguments("--tell-kind") + call + Arguments("a.png"));
        // as altiro3Dimage takes it
        EXPECT_EQ(told.status == 0 ? told.out : "photo\n", kind + std::string("\n")) << told.text();
    }
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
