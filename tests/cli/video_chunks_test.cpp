// video2native --plan, --chunk, --join

#include "altiro3D/altiro3D.hpp"
#include "sandbox.hpp"
#include "support/video.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTool = "video2native";

// clip.mp4: scenes of 7, 26 and 5 s, of which the first one is another at its end, with sound,
// subtitles and chapters.
class ChunkStudio : public SmallStudio {
  public:
    ChunkStudio() {
        spill(*this / "words.srt", "1\n00:00:08,200 --> 00:00:31,000\nHello\n");
        spill(*this / "chapters.txt", ";FFMETADATA1\ntitle=A clip\n[CHAPTER]\nTIMEBASE=1/1000\n"
                                      "START=0\nEND=20000\ntitle=One\n");
        ffmpeg("-f lavfi -i testsrc2=size=60x80:rate=4:duration=7 "
               "-f lavfi -i mandelbrot=size=60x80:rate=4 "
               "-f lavfi -i testsrc=size=60x80:rate=4:duration=5 -f lavfi -i sine=440:duration=38 "
               "-i " +
               arg(*this / "words.srt") + " -i " + arg(*this / "chapters.txt") +
               " -filter_complex '[1]trim=duration=26,setpts=PTS-STARTPTS,setsar=1[b];"
               "[0]setsar=1[a];[2]setsar=1[c];[a][b][c]concat=n=3:v=1[v]' -map '[v]' -map 3 -map 4"
               " -map_metadata 5 -map_chapters 5 -c:v libx264 -crf 10 -g 12 -bf 2 -c:a aac"
               " -c:s mov_text " +
               arg(*this / "clip.mp4"));
    }
    // The options of a run.
    Arguments options() const { return display() + Arguments("-j 1"); }
    Outcome plan(const Arguments& more = {}) const {
        return run(kTool, Arguments("--plan plan --chunk-seconds 12") + options() + more +
                              Arguments("clip.mp4 out.mp4"));
    }
    Outcome chunk(int number) const { return run(kTool, call(number)); }
    static Arguments call(int number) { return {"--chunk", std::to_string(number), "plan"}; }
    Outcome join() const { return run(kTool, "--join plan"); }
    int count() const { return static_cast<int>(readVideoChunks(*this / "plan").chunks.size()); }
    std::string oneRun(const Arguments& more = {}) const {
        const Outcome outcome = run(kTool, options() + more + Arguments("-y clip.mp4 whole.mp4"));
        EXPECT_EQ(outcome.status, 0) << outcome.text();
        return slurp(*this / "whole.mp4");
    }
    void makeAll() const {
        for (int number = 1; number <= count(); ++number)
            ASSERT_TRUE(isDone(chunk(number)));
    }
    // Names in the folder of the chunks.
    std::size_t folders() const {
        return static_cast<std::size_t>(std::distance(
            fs::directory_iterator(*this / "plan" / "chunks"), fs::directory_iterator()));
    }
};

class VideoChunksTool : public ::testing::Test {
  protected:
    void SetUp() override { ALTIRO3D_REQUIRE_FFMPEG(); }
};

TEST_F(VideoChunksTool, TheJoinedFileHasTheBytesOfOneRun) {
    const ChunkStudio studio;
    EXPECT_TRUE(says(studio.plan(), "152 frames, 0:38.0"));
    ASSERT_GE(studio.count(), 3);
    studio.makeAll();
    EXPECT_TRUE(says(studio.join(), "out.mp4: 152 frames, 0:38.0"));
    EXPECT_TRUE(slurp(studio / "out.mp4") == studio.oneRun());
    EXPECT_EQ(lines(ffprobe(studio / "out.mp4", "stream=codec_type")),
              (std::vector<std::string>{"video", "audio", "subtitle", "data"})); // chapters
    // again
    for (const Outcome& again : {studio.join(), studio.chunk(1)}) {
        EXPECT_TRUE(says(again, "is made already"));
    }
    EXPECT_TRUE(holds(slurp(studio / "plan" / "logs" / "1.log"), "made "));
    // another file of that name is not replaced
    spill(studio / "out.mp4", "mine");
    EXPECT_TRUE(fails(studio.join(), 1, "out.mp4: exists"));
    EXPECT_EQ(slurp(studio / "out.mp4"), "mine");
    EXPECT_TRUE(isDone(studio.run(kTool, "-y --join plan")));
    EXPECT_TRUE(slurp(studio / "out.mp4") == slurp(studio / "whole.mp4"));
}

TEST_F(VideoChunksTool, ChunksTakeTheThreadsAndTheCalibrationOfThePlan) {
    const ChunkStudio studio;
    fs::rename(studio / "small.json", studio / "visual.json"); // found without -c
    const Arguments call("-q 2x3 -r 40x30 -j 2 clip.mp4");
    ASSERT_TRUE(isDone(studio.run(kTool, Arguments("--plan plan") + call + Arguments{"out.mp4"})));
    ASSERT_TRUE(isDone(studio.run(kTool, call + Arguments{"whole.mp4"})));
    fs::remove(studio / "visual.json");
    fs::create_directory(studio / "elsewhere"); // names are those of the plan's folder
    for (int number = 1; number <= studio.count(); ++number) {
        ASSERT_TRUE(isDone(
            studio.run("/bin/sh", {"-c", "cd elsewhere && " + arg(toolPath(kTool)) + " --chunk " +
                                             std::to_string(number) + " ../plan"})));
    }
    ASSERT_TRUE(isDone(studio.join()));
    EXPECT_TRUE(slurp(studio / "out.mp4") == slurp(studio / "whole.mp4"));
}

TEST_F(VideoChunksTool, AKilledChunkIsMadeAgain) {
    const ChunkStudio studio;
    ASSERT_TRUE(isDone(studio.plan("--profile best")));
    const Outcome killed =
        studio.run(kTool, ChunkStudio::call(1), SIGKILL, [&] { return studio.folders() > 0; });
    ASSERT_EQ(killed.status, 128 + SIGKILL);
    EXPECT_FALSE(isVideoChunkMade(studio / "plan", 1));
    // the first chunk is joined as not made
    const Outcome early = studio.join();
    EXPECT_EQ(early.status, 1);
    EXPECT_TRUE(holds(early.err, "has no chunk"));
    EXPECT_EQ(early.errLines().size(), 1u) << early.err;
    EXPECT_EQ(studio.folders(), 1u); // what it left
    studio.makeAll();
    EXPECT_EQ(studio.folders(), static_cast<std::size_t>(studio.count()));
    ASSERT_TRUE(isDone(studio.join()));
    EXPECT_TRUE(slurp(studio / "out.mp4") == studio.oneRun("--profile best"));
}

TEST_F(VideoChunksTool, APlanSaysWhyItDoesNotPay) {
    const ChunkStudio studio;
    const auto plan = [&](const Arguments& more) {
        return studio.run(kTool, Arguments("-y --plan plan") + studio.options() + more +
                                     Arguments("clip.mp4 out.mp4"));
    };
    EXPECT_TRUE(says(plan("--chunk-seconds 1 --preview 5"),
                     "does not pay: there is one chunk, because a chunk consists of whole"));
    EXPECT_TRUE(says(plan({}), "because the video is not longer than a chunk"));
    EXPECT_TRUE(says(plan("--chunk-seconds 6"), "it hardly pays: chunks of "));
    const Outcome gains = plan("--chunk-seconds 12 --from 0 --to 33");
    EXPECT_TRUE(isDone(gains));
    EXPECT_FALSE(holds(gains.out, "pay"));
    // one scene
    ffmpeg("-f lavfi -i mandelbrot=size=60x80:rate=4 -t 30 -c:v libx264 " +
           arg(studio / "scene.mp4"));
    fs::rename(studio / "scene.mp4", studio / "clip.mp4");
    EXPECT_TRUE(says(plan("--chunk-seconds 6"), "it does not pay: even with a machine for each"));
}

// The display, the quilt and the network are told by the plan, not by each chunk.
TEST_F(VideoChunksTool, AChunkSaysOneLine) {
    const ChunkStudio studio;
    const Outcome plan = studio.plan();
    EXPECT_TRUE(says(plan, "display: "));
    const Outcome chunk = studio.chunk(1);
    ASSERT_TRUE(says(chunk, "chunk 1: made "));
    EXPECT_EQ(std::count(chunk.out.begin(), chunk.out.end(), '\n'), 1) << chunk.out;
}

TEST_F(VideoChunksTool, AnInterruptedChunkLeavesNothing) {
    const ChunkStudio studio;
    ASSERT_TRUE(isDone(studio.plan("--profile best")));
    const Outcome stopped =
        studio.run(kTool, ChunkStudio::call(1), SIGTERM, [&] { return studio.folders() > 0; });
    EXPECT_EQ(stopped.status, 143) << stopped.text();
    EXPECT_EQ(studio.folders(), 0u);
}

TEST_F(VideoChunksTool, TheSameChunkTwiceAtOnceIsRight) {
    const ChunkStudio studio;
    ASSERT_TRUE(isDone(studio.plan()));
    for (int number = 1; number <= studio.count(); ++number) {
        Outcome both[2];
        std::thread other([&] { both[1] = studio.chunk(number); });
        both[0] = studio.chunk(number);
        other.join();
        for (const Outcome& one : both) { // while one ends, the other has temporary files
            EXPECT_EQ(one.status, 0) << one.text();
            EXPECT_EQ(one.err, "");
        }
    }
    EXPECT_EQ(studio.folders(), static_cast<std::size_t>(studio.count()));
    ASSERT_TRUE(isDone(studio.join()));
    EXPECT_TRUE(slurp(studio / "out.mp4") == studio.oneRun());
}

TEST_F(VideoChunksTool, AFullDiskIsReportedAndLeavesNothing) {
    ChunkStudio studio;
    ASSERT_TRUE(isDone(studio.plan()));
    studio.limitFiles(20000);
    const Outcome full = studio.chunk(1);
    EXPECT_EQ(full.status, 1) << full.text();
    EXPECT_EQ(full.errLines().size(), 1u) << full.err;
    EXPECT_TRUE(holds(full.err, " (on ")); // names its machine
    EXPECT_EQ(studio.folders(), 0u);
    studio.limitFiles(0);
    EXPECT_TRUE(isDone(studio.chunk(1)));
}

TEST_F(VideoChunksTool, WrongCallsAreRefused) {
    const ChunkStudio studio;
    const auto call = [&](const Arguments& arguments) { return studio.run(kTool, arguments); };
    EXPECT_TRUE(fails(call("--chunk 1 nowhere"), 1, "nowhere: holds no plan"));
    EXPECT_TRUE(fails(call("--join nowhere"), 1, "nowhere: holds no plan"));
    EXPECT_TRUE(fails(call("--chunk 1"), 2, "expected --chunk K PLAN"));
    EXPECT_TRUE(fails(call("--chunk 0 plan"), 2, "--chunk"));
    EXPECT_TRUE(fails(call("--join plan out.mp4"), 2, "expected --join PLAN"));
    EXPECT_TRUE(fails(call("--chunk 1 --crf 3 plan"), 2, "expected no --crf"));
    EXPECT_TRUE(fails(call("--chunk-seconds 9 clip.mp4 out.mp4"), 2, "--plan"));
    EXPECT_TRUE(fails(call("--plan plan --resume clip.mp4 out.mp4"), 2, "--resume"));
    fs::create_directory(studio / "videos");
    EXPECT_TRUE(fails(call("--plan plan videos natives"), 2, "one video"));
    EXPECT_TRUE(fails(call("--plan plan none.mp4 out.mp4"), 1, "none.mp4"));
    EXPECT_TRUE(
        fails(call(Arguments("--plan views") + studio.options() + Arguments("clip.mp4 out.mp4")), 1,
              "views: holds other files"));
    ASSERT_TRUE(isDone(studio.plan()));
    EXPECT_TRUE(fails(studio.chunk(99), 1, "chunk: is 99, expected 1.."));
    spill(studio / "plan" / "arguments", "nonsense");
    EXPECT_TRUE(fails(studio.chunk(1), 1, "arguments: is damaged"));
}

} // namespace
} // namespace altiro3D::test
