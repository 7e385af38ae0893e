// photo2native --plan, --chunk, --join

#include "altiro3D/altiro3D.hpp"
#include "common/photo_chunk_plan.hpp"
#include "sandbox.hpp"
#include "support/photo_files.hpp"

#include <chrono>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kTool = "photo2native";

// A folder of photos: two of the same stem, a broken one, one with its depth image, one in HEIC,
// one whose name is not UTF-8, one that looks like a depth image, and files that are not photos.
class PhotoStudio : public SmallStudio {
  public:
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
        spill(*this / "in/notes.txt", "not a picture");
    }
    Arguments options() const {
        return display() +
               Arguments{"-j", "2", "--save-quilt", "q", "--save-views", "v", "--report", "r.json"};
    }
    Outcome oneRun(const Arguments& more = {}) const {
        return run(kTool, options() + more + Arguments{"in", "out"});
    }
    Outcome plan(const Arguments& more = {}) const {
        return run(kTool, Arguments{"--plan", "plan", "--chunk-photos", "2"} + options() + more +
                              Arguments{"in", "out"});
    }
    static Arguments call(int number) { return {"--chunk", std::to_string(number), "plan"}; }
    Outcome chunk(int number) const { return run(kTool, call(number)); }
    Outcome join() const { return run(kTool, {"--join", "plan"}); }
    int count() const { return tools::readPhotoChunks(*this / "plan").chunks(); }
    bool isMade(int number) const {
        return tools::isPhotoChunkMade(tools::readPhotoChunks(*this / "plan"), *this / "plan",
                                       number);
    }
    void makeAll() const {
        for (int number = 1; number <= count(); ++number)
            EXPECT_EQ(chunk(number).status, 0);
    }
    // All outputs by name.
    std::map<std::string, std::string> outputs() const {
        std::map<std::string, std::string> all;
        for (const char* folder : {"out", "q", "v"}) {
            if (!fs::exists(*this / folder)) continue;
            for (const auto& entry : fs::recursive_directory_iterator(*this / folder)) {
                if (entry.is_regular_file())
                    all[fs::relative(entry.path(), work()).string()] = slurp(entry.path());
            }
        }
        return all;
    }
    // The report without what was measured and without the folder of the network.
    Json report() const {
        std::string text = slurp(*this / "r.json");
        const std::string folder = models().string();
        for (std::size_t at = 0; (at = text.find(folder, at)) != std::string::npos;)
            text.erase(at, folder.size());
        Json report = Json::parse(text);
        report.erase("setupMilliseconds");
        report.erase("peakMegabytes");
        for (Json& picture : report["pictures"])
            picture.erase("milliseconds");
        return report;
    }
};

// The last line without its time: "5 photos made, 1 failed, ..."
std::string summary(const Outcome& outcome) {
    const std::string text = outcome.out.substr(0, outcome.out.rfind(", in "));
    return text.substr(text.rfind('\n') + 1);
}

// Compares the result of chunks with that of one run in another studio.
void expectSame(const PhotoStudio& many, const Outcome& joined) {
    const PhotoStudio one;
    const Outcome whole = one.oneRun();
    EXPECT_EQ(whole.status, 1) << whole.text(); // of the broken photo
    EXPECT_EQ(joined.status, whole.status) << joined.text();
    EXPECT_EQ(joined.err, whole.err);
    EXPECT_EQ(summary(joined), summary(whole));
    EXPECT_TRUE(many.outputs() == one.outputs());
    EXPECT_EQ(many.report(), one.report());
}

TEST(PhotoChunks, OutputsAndReportAreThoseOfOneRun) {
    const PhotoStudio studio;
    const Outcome planned = studio.plan();
    ASSERT_TRUE(isDone(planned));
    ASSERT_GE(studio.count(), 3);
    EXPECT_NE(planned.out.find(std::to_string(studio.count()) + " chunks, "), std::string::npos);
    EXPECT_TRUE(studio.outputs().empty());
    for (int number = studio.count(); number >= 1; --number) {
        EXPECT_FALSE(studio.isMade(number));
        if (number == 2) continue;
        EXPECT_EQ(studio.chunk(number).status, 0);
    }
    EXPECT_TRUE(fails(studio.join(), 1,
                      "has no chunk 2 yet, expected chunks 1.." + std::to_string(studio.count())));
    EXPECT_FALSE(fs::exists(studio / "r.json"));
    const Outcome second = studio.chunk(2); // with the broken photo
    EXPECT_EQ(second.status, 0) << second.text();
    EXPECT_EQ(second.errLines().size(), 1u) << second.err;
    EXPECT_NE(slurp(studio / "plan/logs/2.log").find("failed: in/b.png: "), std::string::npos);
    EXPECT_TRUE(studio.isMade(2));
    const Outcome joined = studio.join();
    expectSame(studio, joined);
    // again
    const auto time = fs::last_write_time(studio / "out/c_native.png");
    const Outcome again = studio.chunk(2);
    EXPECT_TRUE(isDone(again));
    EXPECT_NE(again.out.find("chunk 2 is made already"), std::string::npos) << again.out;
    EXPECT_EQ(fs::last_write_time(studio / "out/c_native.png"), time);
    EXPECT_EQ(studio.join().out, joined.out);
    EXPECT_TRUE(isDone(studio.plan()));
    expectSame(studio, studio.join());
}

TEST(PhotoChunks, ChunksTakeTheFolderAndTheCalibrationOfThePlan) {
    const PhotoStudio studio;
    fs::rename(studio / "small.json", studio / "visual.json"); // found without -c
    const Arguments call{"-q", "2x3", "-r", "40x30", "--report", "r.json"};
    EXPECT_EQ(studio.run(kTool, call + Arguments{"in", "out"}).status, 1);
    const auto whole = studio.outputs();
    const Json report = studio.report();
    fs::remove_all(studio / "out");
    fs::remove(studio / "r.json");
    ASSERT_TRUE(
        isDone(studio.run(kTool, Arguments{"--plan", "plan"} + call + Arguments{"in", "out"})));
    fs::remove(studio / "visual.json");
    fs::create_directory(studio / "elsewhere");
    for (const char* task : {" --chunk 1 ../plan", " --join ../plan"})
        studio.run("/bin/sh", {"-c", "cd elsewhere && " + toolPath(kTool).string() + task});
    EXPECT_TRUE(studio.outputs() == whole);
    EXPECT_EQ(studio.report(), report);
}

TEST(PhotoChunks, WarningsAreThoseOfOneRun) {
    const auto prepare = [](const PhotoStudio& studio) {
        fs::remove(studio / "in/b.png");
        writeImage(studio / "in/c-depth.png", madeDepth(80, 60)); // of another shape
        fs::copy(studio / "in/c-depth.png", studio / "in/a-depth.png");
    };
    const PhotoStudio one;
    prepare(one);
    const Outcome whole = one.oneRun();
    ASSERT_EQ(whole.status, 0) << whole.text();
    ASSERT_FALSE(whole.err.empty());
    const PhotoStudio many;
    prepare(many);
    ASSERT_EQ(many.plan().status, 0);
    many.makeAll();
    const Outcome joined = many.join();
    EXPECT_EQ(joined.err, whole.err);
    EXPECT_EQ(joined.status, 0);
    EXPECT_EQ(many.report(), one.report());
}

TEST(PhotoChunks, AKilledChunkIsMadeAgain) {
    const PhotoStudio studio;
    for (int i = 0; i < 20; ++i)
        writeImage(studio / ("in/m" + std::to_string(i) + ".png"), madePhoto(600, 800));
    ASSERT_TRUE(isDone(studio.plan({"--chunk-photos", "100"})));
    const Outcome killed = studio.run(kTool, PhotoStudio::call(1), SIGKILL,
                                      [&] { return fs::exists(studio / "out/c_native.png"); });
    ASSERT_EQ(killed.status, 128 + SIGKILL);
    EXPECT_FALSE(studio.isMade(1));
    EXPECT_TRUE(fails(studio.join(), 1, "has no chunk 1 yet"));
    EXPECT_EQ(studio.chunk(1).status, 0);
    EXPECT_TRUE(studio.isMade(1));
    EXPECT_EQ(studio.join().status, 1);
    const auto made = studio.outputs();
    EXPECT_EQ(studio.oneRun({"-y"}).status, 1);
    EXPECT_TRUE(studio.outputs() == made);
}

TEST(PhotoChunks, TheSameChunkTwiceAtOnceIsRight) {
    const PhotoStudio studio;
    ASSERT_TRUE(isDone(studio.plan()));
    for (int number = 1; number <= studio.count(); ++number) {
        Outcome both[2];
        std::thread other([&] { both[1] = studio.chunk(number); });
        both[0] = studio.chunk(number);
        other.join();
        for (const Outcome& one : both)
            EXPECT_EQ(one.status, 0) << one.text();
    }
    expectSame(studio, studio.join());
}

TEST(PhotoChunks, AChangedPhotoIsRefused) {
    const PhotoStudio studio;
    ASSERT_TRUE(isDone(studio.plan()));
    const fs::path depth = studio / "in/c-depth.png";
    const auto time = fs::last_write_time(depth);
    fs::last_write_time(depth, time + std::chrono::seconds(2));
    EXPECT_EQ(studio.chunk(1).status, 0); // without it
    const Outcome changed[] = {studio.chunk(2), studio.join()};
    for (const Outcome& outcome : changed) {
        EXPECT_TRUE(fails(outcome, 1, "in/c.png: was "));
        EXPECT_NE(outcome.err.find(", expected the same file (on "), std::string::npos);
    }
    EXPECT_TRUE(fails(studio.plan(), 1, "holds a plan of another run (photo 4 was in/c.png"));
    fs::last_write_time(depth, time);
    fs::rename(studio / "in/c.png", studio / "in/away");
    EXPECT_TRUE(fails(studio.chunk(2), 1, "in/c.png: was "));
    fs::rename(studio / "in/away", studio / "in/c.png");
    writeImage(studio / "in/new.png", madePhoto(40, 50)); // is not in the list
    studio.makeAll();
    EXPECT_EQ(studio.join().status, 1);
    EXPECT_FALSE(fs::exists(studio / "out/new_native.png"));
    EXPECT_TRUE(fails(studio.plan(), 1, "holds a plan of another run (photo "));
}

TEST(PhotoChunks, AnotherOptionOrInputIsRefused) {
    const PhotoStudio studio;
    const std::string calibration = slurp(studio / "small.json");
    ASSERT_TRUE(isDone(studio.plan()));
    EXPECT_TRUE(fails(studio.plan({"--strength", "3"}), 1,
                      "another run (--strength was not set and is 3), expected a new folder"));
    EXPECT_TRUE(fails(studio.plan({"--chunk-photos", "3"}), 1, "--chunk-photos was 2 and is 3"));
    EXPECT_TRUE(fails(studio.plan({"-j", "1"}), 1, "threads was 2 and is 1"));
    writeCalibration(studio / "small.json", {96, 128}, 51);
    EXPECT_TRUE(fails(studio.chunk(1), 1, "was planned with other settings (display was "));
    EXPECT_TRUE(fails(studio.join(), 1, "was planned with other settings (display was "));
    spill(studio / "small.json", calibration + " "); // the same display
    studio.makeAll();
    EXPECT_EQ(studio.join().status, 1);
}

TEST(PhotoChunks, DamageIsNamedAndMadeAgain) {
    const PhotoStudio studio;
    ASSERT_TRUE(isDone(studio.plan()));
    studio.makeAll();
    fs::remove(studio / "v/c_views/view_3.png");
    EXPECT_FALSE(studio.isMade(2));
    EXPECT_TRUE(fails(studio.join(), 1,
                      "v/c_views/view_3.png: is missing, expected the file as chunk 2 wrote it"));
    EXPECT_EQ(studio.chunk(2).status, 0);
    spill(studio / "out/c_native.png", "mine");
    EXPECT_TRUE(fails(studio.join(), 1, "out/c_native.png: has another size"));
    EXPECT_EQ(studio.chunk(2).status, 0);
    expectSame(studio, studio.join());
    const fs::path record = studio / "plan/chunks/000002.json";
    const std::string bytes = slurp(record);
    const std::string damaged[] = {"", "[]", "{}", bytes.substr(0, bytes.size() / 2),
                                   std::string(100000, '[')};
    for (const std::string& text : damaged) {
        spill(record, text);
        EXPECT_FALSE(studio.isMade(2));
        EXPECT_TRUE(fails(studio.join(), 1, "000002.json: is damaged"));
    }
    EXPECT_EQ(studio.chunk(2).status, 0);
    expectSame(studio, studio.join());
    const std::string plan = slurp(studio / "plan/plan.json");
    for (const std::string& text : {std::string("{}"), plan.substr(0, plan.size() / 2)}) {
        spill(studio / "plan/plan.json", text);
        EXPECT_TRUE(fails(studio.chunk(1), 1, "plan.json: is damaged"));
        EXPECT_TRUE(fails(studio.join(), 1, "plan.json: is damaged"));
    }
    spill(studio / "plan/plan.json", R"({"format": "altiro3D video plan", "version": 1})");
    EXPECT_FALSE(tools::isPhotoPlan(studio / "plan"));
    EXPECT_TRUE(fails(studio.chunk(1), 1, "plan.json: is not a plan of photos"));
    spill(studio / "plan/plan.json", plan);
    EXPECT_TRUE(tools::isPhotoPlan(studio / "plan"));
    spill(studio / "plan/arguments", "nonsense");
    EXPECT_TRUE(fails(studio.chunk(1), 1, "arguments: is damaged"));
}

TEST(PhotoChunks, AFullDiskIsNotTheFaultOfThePhoto) {
    PhotoStudio studio;
    ASSERT_TRUE(
        isDone(studio.run(kTool, Arguments{"--plan", "plan", "--chunk-photos", "1"} +
                                     studio.display() + Arguments{"-j", "2", "in", "out"})));
    studio.limitFiles(4000);
    const Outcome full = studio.chunk(1);
    EXPECT_TRUE(fails(full, 1, "_native.png: "));
    EXPECT_FALSE(studio.isMade(1));
    studio.limitFiles(0);
    EXPECT_TRUE(isDone(studio.chunk(1)));
    EXPECT_TRUE(studio.isMade(1));
}

TEST(PhotoChunks, WrongCallsAreRefused) {
    const PhotoStudio studio;
    const auto call = [&](const Arguments& arguments) { return studio.run(kTool, arguments); };
    EXPECT_TRUE(fails(call({"--chunk", "1", "nowhere"}), 1, "nowhere: holds no plan"));
    EXPECT_TRUE(fails(call({"--join", "nowhere"}), 1, "nowhere: holds no plan"));
    EXPECT_TRUE(fails(call({"--chunk", "1"}), 2, "expected --chunk K PLAN"));
    EXPECT_TRUE(fails(call({"--chunk", "0", "plan"}), 2, "--chunk"));
    EXPECT_TRUE(fails(call({"--join", "plan", "out"}), 2, "expected --join PLAN"));
    EXPECT_TRUE(fails(call({"--chunk", "1", "-k", "plan"}), 2, "expected no -k"));
    EXPECT_TRUE(fails(call({"--chunk-photos", "9", "in", "out"}), 2, "--plan"));
    EXPECT_TRUE(fails(studio.plan({"--chunk-photos", "0"}), 2, "--chunk-photos"));
    EXPECT_TRUE(fails(studio.plan({"--skip-existing"}), 2, "--skip-existing"));
    EXPECT_TRUE(fails(studio.plan({"--budget", "40"}), 2, "--budget"));
    EXPECT_TRUE(fails(studio.plan({"--join", "plan"}), 2, "--join"));
    EXPECT_TRUE(
        fails(call(Arguments{"--plan", "plan", "photo.png", "a.png"}), 2, "several photos"));
    EXPECT_TRUE(
        fails(call(Arguments{"--plan", "views"} + studio.options() + Arguments{"in", "out"}), 1,
              "views: holds other files"));
    EXPECT_FALSE(fs::exists(studio / "plan"));
    fs::create_directory(studio / "out");
    spill(studio / "out/c_native.png", "mine");
    EXPECT_TRUE(fails(studio.plan(), 1, "out/c_native.png: exists"));
    EXPECT_FALSE(fs::exists(studio / "plan"));
    ASSERT_TRUE(isDone(studio.plan({"-y"})));
    EXPECT_TRUE(fails(studio.chunk(99), 1, "chunk: is 99, expected 1.."));
    studio.makeAll();
    EXPECT_TRUE(isDone(studio.plan({"-y"}))); // from the beginning
    EXPECT_FALSE(studio.isMade(1));
}

} // namespace
} // namespace altiro3D::test
