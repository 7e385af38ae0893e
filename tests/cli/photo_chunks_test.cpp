// photo2native --plan, --chunk, --join

#include "altiro3D/altiro3D.hpp"
#include "sandbox.hpp"
#include "support/photo_files.hpp"
#include "support/slow.hpp"

#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTool = "photo2native";

// A folder of photos: two of the same stem, a broken one, one with its depth image, one in HEIC,
// one whose name is not UTF-8, one that looks like a depth image, and files that are not photos.
// Two of them make a chunk: a.jpg a.png, b.png c.png, d.heic e.png, z.png.
class PhotoStudio : public SmallStudio {
  public:
    static constexpr int kChunks = 4;

    PhotoStudio() {
        fs::create_directory(*this / "in");
        writeImage(*this / "in/a.jpg", madePhoto(40, 50));
        writeImage(*this / "in/a.png", madePhoto(50, 40));
        spill(*this / "in/b.png", "broken");
        writeImage(*this / "in/c.png", madePhoto(60, 80));
        writeImage(*this / "in/c-depth.png", madeDepth(60, 80));
        spill(*this / "in/d.heic", heifFile("heic", {hevcColours(1)}));
        writeImage(*this / "in/e\xe9.png", madePhoto(30, 70));
        fs::copy(*this / "depth.png", *this / "in/z.png");
        spill(*this / "in/clip.mp4", "a video");
    }
    Arguments options() const {
        return display() + Arguments("-j 2 --save-quilt q --save-views v --report r.json");
    }
    Outcome plan(const Arguments& more = {}) const {
        return run(kTool, Arguments("--plan plan --chunk-photos 2") + options() + more +
                              Arguments("in out"));
    }
    Outcome chunk(int number) const {
        return run(kTool, {"--chunk", std::to_string(number), "plan"});
    }
    Outcome join() const { return run(kTool, "--join plan"); }
    void makeAll() const {
        for (int number = 1; number <= kChunks; ++number)
            EXPECT_EQ(chunk(number).status, 0);
    }
    // "1 of 4 chunks made"
    ::testing::AssertionResult hasMade(int count) const {
        const std::string said = run("altiro3Dcluster", "--status plan").out;
        if (said.find(std::to_string(count) + " of 4 chunks made") != std::string::npos)
            return ::testing::AssertionSuccess();
        return ::testing::AssertionFailure() << said;
    }
    // All outputs by name.
    std::map<std::string, std::string> outputs() const {
        return contentsBelow(*this, {"out", "q", "v"});
    }
};

// The bytes of one run with the same options.
std::map<std::string, std::string> outputsOfOneRun() {
    const PhotoStudio one;
    const Outcome whole = one.run(kTool, one.options() + Arguments("in out"));
    EXPECT_EQ(whole.status, 1) << whole.text(); // of the broken photo
    EXPECT_EQ(one.outputs().size(), 5U * (2 + 6));
    return one.outputs();
}

TEST(PhotoChunks, OutputsAreThoseOfOneRunAndTheJoinNamesWhatFailed) {
    const PhotoStudio studio;
    EXPECT_TRUE(says(studio.plan(), "plan: 4 chunks, 7 photos"));
    EXPECT_TRUE(studio.outputs().empty());
    for (const int number : {4, 3, 1})
        EXPECT_TRUE(isDone(studio.chunk(number)));
    EXPECT_TRUE(studio.hasMade(3));
    EXPECT_TRUE(fails(studio.join(), 1, "has no chunk 2 yet, expected chunks 1..4"));
    EXPECT_FALSE(fs::exists(studio / "r.json"));
    const Outcome second = studio.chunk(2); // with the broken photo
    EXPECT_EQ(second.status, 0) << second.text();
    EXPECT_EQ(second.errLines().size(), 1u) << second.err;
    EXPECT_TRUE(holds(slurp(studio / "plan/logs/2.log"), "failed: in/b.png: "));
    EXPECT_TRUE(holds(slurp(studio / "plan/logs/4.log"), "in/z.png: looks like"));
    EXPECT_TRUE(studio.hasMade(4));
    const Outcome joined = studio.join();
    EXPECT_TRUE(fails(joined, 1, "in/b.png"));
    EXPECT_TRUE(
        holds(joined.out, "0 photos made, 5 skipped as the outputs exist, 1 failed, 1 left out"));
    EXPECT_TRUE(studio.outputs() == outputsOfOneRun());
    const auto report = studio.json("r.json");
    EXPECT_EQ(report.at("pictures").size(), 7U);
    const auto part = studio.json("plan/logs/2.json");
    EXPECT_EQ(part.at("pictures").at(1).at("depthImage"), "in/c-depth.png");
    // again
    const auto time = fs::last_write_time(studio / "out/c_native.png");
    const Outcome again = studio.chunk(2);
    EXPECT_TRUE(says(again, "chunk 2 is made already"));
    EXPECT_TRUE(isDone(studio.plan()));
    EXPECT_TRUE(studio.hasMade(4));
    writeImage(studio / "in/b.png", madePhoto(40, 50)); // the join tries what failed again
    EXPECT_TRUE(isDone(studio.join()));
    EXPECT_TRUE(fs::exists(studio / "out/b_native.png"));
    EXPECT_EQ(fs::last_write_time(studio / "out/c_native.png"), time);
}

TEST(PhotoChunks, ChunksTakeTheFolderAndTheCalibrationOfThePlan) {
    const PhotoStudio studio;
    fs::rename(studio / "small.json", studio / "visual.json"); // found without -c
    const Arguments call("-q 2x3 -r 40x30");
    EXPECT_EQ(studio.run(kTool, call + Arguments("in out")).status, 1);
    const auto whole = studio.outputs();
    fs::remove_all(studio / "out");
    ASSERT_TRUE(isDone(studio.run(kTool, Arguments("--plan plan") + call + Arguments("in out"))));
    fs::remove(studio / "visual.json");
    fs::create_directory(studio / "elsewhere");
    studio.run("/bin/sh",
               {"-c", "cd elsewhere && " + toolPath(kTool).string() + " --chunk 1 ../plan"});
    EXPECT_TRUE(studio.outputs() == whole);
}

TEST(PhotoChunks, AKilledChunkContinues) {
    ALTIRO3D_TAKES(3);
    const PhotoStudio studio;
    for (int i = 0; i < 20; ++i)
        writeImage(studio / ("in/m" + std::to_string(i) + ".png"), madePhoto(300, 400));
    ASSERT_TRUE(isDone(studio.plan("--chunk-photos 100")));
    const Outcome killed = studio.run(kTool, "--chunk 1 plan", SIGKILL,
                                      [&] { return fs::exists(studio / "out/m1_native.png"); });
    ASSERT_EQ(killed.status, 128 + SIGKILL);
    EXPECT_TRUE(fails(studio.join(), 1, "has no chunk 1 yet"));
    const auto time = fs::last_write_time(studio / "out/c_native.png");
    EXPECT_EQ(studio.chunk(1).status, 0);
    EXPECT_EQ(fs::last_write_time(studio / "out/c_native.png"), time);
    EXPECT_EQ(studio.join().status, 1);
    const auto made = studio.outputs();
    EXPECT_EQ(studio.run(kTool, studio.options() + Arguments("-y in out")).status, 1);
    EXPECT_TRUE(studio.outputs() == made);
}

TEST(PhotoChunks, TheSameChunkTwiceAtOnceIsRight) {
    const PhotoStudio studio;
    ASSERT_TRUE(isDone(studio.plan()));
    for (int number = 1; number <= PhotoStudio::kChunks; ++number) {
        Outcome both[2];
        std::thread other([&] { both[1] = studio.chunk(number); });
        both[0] = studio.chunk(number);
        other.join();
        for (const Outcome& one : both)
            EXPECT_EQ(one.status, 0) << one.text();
    }
    EXPECT_EQ(studio.join().status, 1);
    EXPECT_TRUE(studio.outputs() == outputsOfOneRun());
}

TEST(PhotoChunks, AnotherRunIsRefused) {
    const PhotoStudio studio;
    const std::string calibration = slurp(studio / "small.json");
    ASSERT_TRUE(isDone(studio.plan()));
    for (const Arguments& other : {Arguments("--strength 3"), {"--chunk-photos", "3"}, {"-j", "1"}})
        EXPECT_TRUE(
            fails(studio.plan(other), 1, "holds a plan of another run, expected a new folder"));
    writeCalibration(studio / "small.json", {96, 128}, 51);
    EXPECT_TRUE(fails(studio.chunk(1), 1, "was made with other settings ("));
    spill(studio / "small.json", calibration + " "); // the same display
    writeImage(studio / "in/new.png", madePhoto(40, 50));
    EXPECT_TRUE(fails(studio.plan(), 1, "holds a plan of another run"));
    studio.makeAll();
    EXPECT_EQ(studio.join().status, 1);
    EXPECT_FALSE(fs::exists(studio / "out/new_native.png")); // is not in the list
}

TEST(PhotoChunks, WhatIsMissingIsMadeAgainAndDamageIsNamed) {
    const PhotoStudio studio;
    ASSERT_TRUE(isDone(studio.plan()));
    studio.makeAll();
    const auto whole = studio.outputs();
    fs::remove(studio / "v/c_views/view_3.png");
    spill(studio / "out/e\xe9_native.png", "");
    EXPECT_TRUE(studio.hasMade(2));
    EXPECT_TRUE(fails(studio.join(), 1, "has no chunks 2-3 yet"));
    spill(studio / "plan/chunks/1", "damaged");
    EXPECT_TRUE(studio.hasMade(1));
    studio.makeAll();
    EXPECT_TRUE(studio.hasMade(4));
    EXPECT_TRUE(studio.outputs() == whole);
    const std::string list = slurp(studio / "plan/photos");
    const std::string zero(1, '\0');
    for (const std::string& text : {std::string(), list.substr(0, list.size() / 2), list + zero,
                                    "a" + zero + "b" + zero + "x" + zero + "1" + zero}) {
        spill(studio / "plan/photos", text);
        EXPECT_TRUE(fails(studio.chunk(1), 1, "photos: is damaged"));
        EXPECT_TRUE(fails(studio.join(), 1, "photos: is damaged"));
    }
    spill(studio / "plan/photos", list);
    spill(studio / "plan/arguments", "nonsense");
    EXPECT_TRUE(fails(studio.join(), 1, "arguments: is damaged"));
}

TEST(PhotoChunks, AFullDiskIsNotTheFaultOfThePhoto) {
    PhotoStudio studio;
    ASSERT_TRUE(isDone(studio.convert(kTool, "--plan plan --chunk-photos 1 -j 2 in out")));
    studio.limitFiles(4000);
    EXPECT_TRUE(fails(studio.chunk(1), 1, "_native.png: "));
    EXPECT_FALSE(fs::exists(studio / "plan/chunks/1"));
    studio.limitFiles(0);
    EXPECT_TRUE(isDone(studio.chunk(1)));
    EXPECT_TRUE(fs::exists(studio / "plan/chunks/1"));
}

TEST(PhotoChunks, ExistingOutputsAreReplacedOnlyWithConsent) {
    const PhotoStudio studio;
    fs::create_directory(studio / "out");
    spill(studio / "out/c_native.png", "mine");
    EXPECT_TRUE(fails(studio.plan(), 1, "out/c_native.png: exists"));
    EXPECT_FALSE(fs::exists(studio / "plan"));
    ASSERT_TRUE(isDone(studio.plan("-y")));
    studio.makeAll();
    spill(studio / "out/c_native.png", "mine");
    ASSERT_TRUE(isDone(studio.plan("-y"))); // from the beginning
    EXPECT_TRUE(studio.hasMade(0));
    studio.makeAll();
    EXPECT_TRUE(studio.outputs() == outputsOfOneRun());
}

TEST(PhotoChunks, AJoinThatReplacesFilesDoesNotTakeOldOnesForMade) {
    const PhotoStudio studio;
    ASSERT_TRUE(isDone(studio.plan()));
    studio.makeAll();
    EXPECT_EQ(studio.join().status, 1);           // b.png is broken
    spill(studio / "in/c.png", "broken as well"); // and its Native is there
    ASSERT_TRUE(isDone(studio.plan("-y")));
    studio.makeAll();
    const Outcome joined = studio.join();
    EXPECT_EQ(joined.status, 1);
    EXPECT_TRUE(holds(joined.text(), "c.png"));
    EXPECT_TRUE(holds(joined.text(), "2 failed"));
}

TEST(PhotoChunks, WrongCallsAreRefused) {
    const PhotoStudio studio;
    const auto call = [&](const Arguments& arguments) { return studio.run(kTool, arguments); };
    EXPECT_TRUE(fails(call("--chunk 1 nowhere"), 1, "nowhere: holds no plan"));
    EXPECT_TRUE(fails(call("--join nowhere"), 1, "nowhere: holds no plan"));
    EXPECT_TRUE(fails(call("--chunk 1"), 2, "expected --chunk K PLAN"));
    EXPECT_TRUE(fails(call("--chunk 0 plan"), 2, "--chunk"));
    EXPECT_TRUE(fails(call("--join plan out"), 2, "expected --join PLAN"));
    EXPECT_TRUE(fails(call("--chunk 1 -k plan"), 2, "expected no -k"));
    EXPECT_TRUE(fails(call("--chunk-photos 9 in out"), 2, "--plan"));
    EXPECT_TRUE(fails(studio.plan("--chunk-photos 0"), 2, "--chunk-photos"));
    EXPECT_TRUE(fails(studio.plan("--budget 40"), 2, "--budget"));
    EXPECT_TRUE(fails(studio.plan("--join plan"), 2, "--join"));
    EXPECT_TRUE(fails(call(Arguments("--plan plan photo.png a.png")), 2, "several photos"));
    EXPECT_TRUE(fails(call(Arguments("--plan views") + studio.options() + Arguments("in out")), 1,
                      "views: holds other files"));
    ASSERT_TRUE(isDone(studio.plan()));
    EXPECT_TRUE(fails(studio.chunk(99), 1, "chunk: is 99, expected 1..4"));
}

} // namespace
} // namespace altiro3D::test
