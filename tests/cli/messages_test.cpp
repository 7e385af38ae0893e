// The messages of the tools: whole lines, once, in order, and only what helps.

#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"
#include "support/video.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <regex>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

using Lines = std::vector<std::string>;

// The text that a terminal shows at the end, after the escape sequences of a status line.
Lines screenOf(const std::string& text) {
    Lines rows(1);
    std::size_t column = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        std::string& row = rows.back();
        if (text.compare(i, 3, "\033[K") == 0) {
            row.resize(std::min(row.size(), column));
            i += 2;
        } else if (text.compare(i, 4, "\033[?7") == 0) { // line wrap, which no test needs
            i += 4;
        } else if (text[i] == '\r') {
            column = 0;
        } else if (text[i] == '\n') {
            rows.emplace_back();
            column = 0;
        } else {
            row.resize(std::max(row.size(), column + 1), ' ');
            row[column++] = text[i];
        }
    }
    return rows;
}

// A studio with a directory of so many photos, every third of them broken.
class BatchStudio : public SmallStudio {
  public:
    explicit BatchStudio(int photos) {
        fs::create_directory(*this / "in");
        for (int i = 0; i < photos; ++i) {
            const fs::path file = *this / ("in/" + std::to_string(100 + i) + ".png");
            if (i % 3 == 1) {
                spill(file, "broken");
            } else {
                writeImage(file, madePhoto(40, 50));
            }
        }
    }
    Arguments call() const { return fixedWay() + display() + Arguments("in out"); }
};

// The command line of a tool for a shell.
std::string shellText(const std::string& tool, const Arguments& arguments) {
    std::string text = "'" + toolPath(tool).string() + "'";
    for (const std::string& argument : arguments)
        text += " '" + argument + "'";
    return text;
}

Outcome onTerminal(const Sandbox& sandbox, const std::string& tool, const Arguments& arguments) {
    return sandbox.run("/usr/bin/script", {"-qefc", shellText(tool, arguments), "/dev/null"});
}

bool hasTerminals() {
    return fs::exists("/usr/bin/script");
}

} // namespace

TEST(Messages, OnATerminalTheStatusLineGivesWayToThem) {
    if (!hasTerminals()) GTEST_SKIP() << "needs script(1)";
    const BatchStudio studio(4);
    const Outcome outcome = onTerminal(studio, "photo2native", studio.call());
    EXPECT_EQ(outcome.status, 1) << outcome.text();
    EXPECT_TRUE(holds(outcome.out, "[2/4] "));
    const Lines screen = screenOf(outcome.out);
    ASSERT_EQ(screen.size(), 9U) << outcome.text();
    EXPECT_EQ(screen[0].rfind("display: ", 0), 0U) << outcome.text();
    EXPECT_EQ(screen[3], "100.png: out/100_native.png: Native, 96 x 128 px");
    EXPECT_EQ(screen[4].rfind("photo2native: error: in/101.png: ", 0), 0U) << screen[4];
    EXPECT_EQ(screen[5], "102.png: out/102_native.png: Native, 96 x 128 px");
    EXPECT_EQ(screen[6], "103.png: out/103_native.png: Native, 96 x 128 px");
    EXPECT_EQ(screen[7].rfind("3 photos made, 1 failed, in ", 0), 0U) << screen[7];
    EXPECT_EQ(screen[8], "");
}

TEST(Messages, OnATerminalAVideosStatusLineGivesWayToThem) {
    if (!hasTerminals()) GTEST_SKIP() << "needs script(1)";
    const SmallStudio studio;
    studio.makeClip();
    const Outcome outcome =
        onTerminal(studio, "video2native", studio.goodCall("video2native", "out.mkv"));
    EXPECT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.out, ", frame 1, "));
    EXPECT_TRUE(holds(outcome.out, "finishing the file"));
    const Lines screen = screenOf(outcome.out);
    EXPECT_EQ(screen[screen.size() - 2].rfind("out.mkv: Native video", 0), 0U) << outcome.text();
    for (const std::string& row : screen) {
        EXPECT_FALSE(holds(row, "finishing the file"));
        EXPECT_FALSE(holds(row, ", frame "));
    }
}

TEST(Messages, InASharedPipeLinesAreWholeAndInOrder) {
    const BatchStudio studio(60); // more than a buffer holds
    const Outcome outcome =
        studio.run("/bin/sh", {"-c", shellText("photo2native", studio.call()) + " 2>&1 | cat"});
    const Lines lines = test::lines(outcome.out);
    ASSERT_EQ(lines.size(), 3 + 60 + 1U) << outcome.text();
    for (int i = 0; i < 60; ++i) {
        const std::string name = std::to_string(100 + i);
        const std::string& line = lines[static_cast<std::size_t>(3 + i)];
        if (i % 3 == 1) {
            EXPECT_EQ(line.rfind("photo2native: error: in/" + name + ".png: ", 0), 0U) << line;
        } else {
            EXPECT_EQ(line, name + ".png: out/" + name + "_native.png: Native, 96 x 128 px");
        }
    }
    EXPECT_EQ(lines.back().rfind("40 photos made, 20 failed, in ", 0), 0U) << lines.back();
}

TEST(Messages, ABatchHasOneLineForEachPhoto) {
    SmallStudio studio;
    fs::create_directory(studio / "in");
    writeImage(studio / "in/a.png", madePhoto(90, 120));
    writeImage(studio / "in/wide.png", madePhoto(120, 40));
    const Outcome outcome = studio.convert("photo2native", "--save-quilt q --save-depth d in out");
    EXPECT_TRUE(isDone(outcome));
    const std::string chosen = "; center 0.[0-9]+,0.[0-9]+(, zoom 1.[0-9]+)?, focus 0.[0-9]+"
                               "(, strength [0-9.]+ %)?\n";
    const std::regex expected("display: [^\n]*\nquilt: [^\n]*\ndepth: [^\n]*\n"
                              "auto: framing and focus by the photo; --fit cover --focus 0.5 "
                              "chooses nothing\n"
                              "a.png: out/a_native.png: Native, 96 x 128 px, quilt, depth" +
                              chosen +
                              "wide.png: out/wide_native.png: Native, 96 x 128 px, quilt, depth; "
                              "75 % of the width is cut off" +
                              chosen + "2 photos made, in [0-9.]+ s\n");
    EXPECT_TRUE(std::regex_match(outcome.out, expected)) << outcome.text();
    const Outcome verbose = studio.convert("photo2native", "-v -y in out");
    EXPECT_TRUE(holds(verbose.out, "\na.png: parallax: "));
    EXPECT_TRUE(holds(verbose.out, "\nwide.png: read "));
}

TEST(Messages, TheParallaxIsSaidNearItsLimitAndWarnedOfAboveIt) {
    SmallStudio studio;
    // S/2 = 60 % of 120 px, 6 views, half of the range before the focus: 72 * 0.5 * 2 / 5 px
    const auto make = [&](const char* strength) {
        return studio.run("photo2native", fixedWay({"-c", "small.json", "-q", "2x3", "-r",
                                                    "160x120", "-y", "--strength", strength, "-d",
                                                    "photo.png", "depth.png", "a.png"}));
    };
    const Outcome far = make("30"); // 3.6 px
    EXPECT_TRUE(isDone(far));
    EXPECT_FALSE(holds(far.out, "parallax"));
    const Outcome near = make("40"); // 4.8 px
    EXPECT_TRUE(says(near, "\nparallax: strength 40.0 %, focus 0.50: at most 4.80 view px"));
    const Outcome above = make("60"); // 7.2 px
    EXPECT_TRUE(warns(above, "parallax between adjacent views is up to 7.2 view px"));
    EXPECT_FALSE(holds(above.out, "parallax"));
    fs::create_directory(studio / "in");
    for (const char* name : {"in/a.png", "in/b.png"})
        fs::copy(studio / "photo.png", studio / name);
    const Outcome batch =
        studio.run("photo2native", "-c small.json -q 2x3 -r 160x120 --strength 90 in out");
    const Lines lines = batch.errLines();
    ASSERT_EQ(lines.size(), 2U) << batch.text();
    EXPECT_EQ(lines[0].rfind("photo2native: warning: a.png: parallax between ", 0), 0U) << lines[0];
    EXPECT_EQ(lines[1].rfind("photo2native: warning: b.png: parallax between ", 0), 0U) << lines[1];
}

// Advice names what the user can change.
TEST(Messages, WarningsAdviseNoOptionThatDoesNotApply) {
    SmallStudio studio;
    spill(studio / "camera.json", R"({"fx": 100, "fy": 100, "cx": 45, "cy": 60, "zNear": 1,
                                      "zFar": 100, "baseline": 0.9})");
    const Arguments photo = Arguments("-y -c small.json -q 2x3 -r 160x120");
    const Arguments names("-d photo.png depth.png a.png");
    const Outcome camera =
        studio.run("photo2native", photo + Arguments("-g --camera camera.json") + names);
    EXPECT_TRUE(warns(camera, "lower the baseline in --camera"));
    EXPECT_FALSE(holds(camera.err, "--strength"));

    const Outcome budget = studio.run("photo2native", photo + Arguments("--budget 0.1") + names);
    if (!budget.err.empty()) { // else this machine is quick
        EXPECT_TRUE(warns(budget, "smaller views (-r) take less"));
        EXPECT_FALSE(holds(budget.err, "-k"));
    }
    const Outcome kept = studio.run("photo2native", photo + Arguments("--budget 0.1 -k") + names);
    if (!kept.err.empty()) {
        EXPECT_TRUE(warns(kept, "it takes less without -k"));
    }
}

TEST(Messages, NothingIsWarnedOfTwice) {
    SmallStudio studio;
    studio.makeClip();
    writeCalibration(studio / "one.json", {96, 128}, 52.58, "LKG-PORT-1"); // no Portrait's panel
    spill(studio / "odd.json",
          "[" + slurp(studio / "one.json") + ", " + slurp(studio / "small.json") + "]");
    cv::Mat rgbd;
    cv::hconcat(madePhoto(90, 120), madePhoto(90, 120), rgbd);
    writeImage(studio / "rgbd.png", rgbd);
    fs::create_directory(studio / "in");
    for (const char* name : {"in/a.png", "in/b_qs3x2.png"})
        fs::copy(studio / "photo.png", studio / name);
    studio.makeMap();
    const Arguments odd("-c odd.json -q 3x2 -r 40x30"); // 3x2: the swapped reading
    const Arguments map("-m a.map -c small.json");
    struct Call {
        const char* tool;
        Arguments arguments;
    };
    const Call calls[] = {
        {"photo2native", odd + Arguments("--strength 100 -r 400x300 photo.png 1.jpg --save-depth "
                                         "1d.jpg --lg 1.mp4 --seconds 0.2 --turns 1")},
        {"photo2native", odd + Arguments("--strength 100 in photo.png 2")},
        {"photo2native", odd + Arguments("--rgbd right rgbd.png 3.png")},
        {"photo2native", map + Arguments("-g -k photo.png 4.png")},
        {"photo2native", odd + Arguments("-k --continuous in 5")},
        {"video2native", odd + Arguments("--profile best --compat clip.mp4 6.mp4")},
        {"video2native", odd + Arguments("--profile live --quilt-out clip.mp4 7.mp4")},
        {"video2native", odd + Arguments("--rgbd-out --compat clip.mp4 8.mp4")},
        {"video2native", map + Arguments("--profile best clip.mp4 9.mp4")},
        {"quilt2native",
         {"-c", "odd.json", "-q", "2x3", "quilt.png", "a.jpg", "--lg", "a.mp4", "--turns", "1"}},
        {"views2native", odd + Arguments("views b.jpg --save-quilt b.png")},
        {"native2view", odd + Arguments("--angle 60 panel.png c.jpg")},
        {"altiro3Dnative", {"--info", "odd.json"}}};
    for (const auto& [tool, arguments] : calls) {
        const Outcome outcome = studio.run(tool, arguments);
        EXPECT_EQ(outcome.status, 0) << outcome.text();
        Lines lines = outcome.errLines();
        std::sort(lines.begin(), lines.end());
        EXPECT_EQ(std::adjacent_find(lines.begin(), lines.end()), lines.end()) << outcome.text();
        // nor in other words on standard output
        EXPECT_EQ(outcome.err.find("parallax") != std::string::npos &&
                      outcome.out.find("parallax") != std::string::npos,
                  false)
            << outcome.text();
    }
}

} // namespace altiro3D::test
