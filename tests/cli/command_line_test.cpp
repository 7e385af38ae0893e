// The common behaviour of all tools: options, numbers, messages, threads, file names.

#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"
#include "support/slow.hpp"

#include <algorithm>
#include <cstdlib>
#include <opencv2/core/mat.hpp>
#include <regex>
#include <sstream>

namespace altiro3D::test {

namespace fs = std::filesystem;

class EveryTool : public ToolTest {};

INSTANTIATE_TEST_SUITE_P(Tools, EveryTool, ::testing::ValuesIn(allTools()),
                         [](const auto& tool) { return tool.param; });

TEST_P(EveryTool, HelpTellsHowToCallItAndFitsATerminal) {
    for (const char* argument : {"--help", "-h", "--help-all"}) {
        const Outcome outcome = studio_.run(tool(), {argument});
        EXPECT_TRUE(isDone(outcome));
        EXPECT_EQ(outcome.out.rfind("Usage: " + tool() + " ", 0), 0U) << outcome.out;
        // options of all tools; tests/docs compares the rest with manual and completions
        std::vector<std::string> wanted{"  -q, --layout RxC", "  -v, --verbose", "  -h, --help",
                                        "  --version", "  -y "};
        if (argument == std::string("--help-all")) {
            for (const char* option : {"  -j N", "  --serial NAME"})
                wanted.emplace_back(option);
        }
        for (const std::string& option : wanted)
            EXPECT_TRUE(holds(outcome.out, option));
        std::istringstream lines(outcome.out);
        for (std::string line; std::getline(lines, line);)
            EXPECT_LE(line.size(), 100U) << line;
    }
}

// The lines of a help that begin an option or a section, without its Words and what follows them.
std::vector<std::string> optionLines(const std::string& help) {
    std::vector<std::string> found;
    std::istringstream lines(help.substr(0, help.find("\nWords:\n")));
    for (std::string line; std::getline(lines, line);) {
        if (line.rfind("  -", 0) == 0 || (line.rfind("  ", 0) != 0 && line.back() == ':'))
            found.push_back(line);
    }
    return found;
}

TEST_P(EveryTool, HelpIsShortAndHelpAllHasTheRestInTheSameGroups) {
    const std::string help = studio_.run(tool(), "--help").out;
    const std::string helpAll = studio_.run(tool(), "--help-all").out;
    const std::vector<std::string> basic = optionLines(help);
    std::vector<std::string> rest = optionLines(helpAll);
    constexpr std::size_t kMaxLines = 32; // options and titles that fit on a screen
    EXPECT_LE(basic.size(), kMaxLines) << help;
    auto at = rest.begin();
    for (const std::string& line : basic) { // the same lines, in the same order
        at = std::find(at, rest.end(), line);
        ASSERT_NE(at, rest.end()) << line << helpAll;
    }
    const std::string hint = " more options: " + tool() + " --help-all\n";
    if (basic.size() == rest.size()) {
        EXPECT_EQ(help, helpAll);
        EXPECT_FALSE(holds(help, "--help-all"));
    } else {
        EXPECT_TRUE(holds(help, hint));
        EXPECT_FALSE(holds(helpAll, hint));
    }
}

// The commands that the help shows, without the tool's name.
std::vector<Arguments> examplesOf(const std::string& tool, const std::string& help) {
    std::vector<Arguments> examples;
    std::istringstream lines(help.substr(std::min(help.find("\nExamples:\n"), help.size())));
    for (std::string line; std::getline(lines, line);) {
        if (line.rfind("  " + tool + " ", 0) != 0) continue;
        std::istringstream words(line.substr(tool.size() + 3));
        Arguments& example = examples.emplace_back();
        for (std::string word; words >> word;)
            example.push_back(word);
    }
    return examples;
}

TEST_P(EveryTool, TheExamplesOfTheHelpWork) {
    studio_.startPrograms();
    const std::vector<Arguments> examples = examplesOf(tool(), studio_.run(tool(), "--help").out);
    EXPECT_GE(examples.size(), 3U);
    const cv::Mat quilt = madePhoto(240, 240); // 8 columns and 6 rows of 30 x 40 px
    fs::copy(studio_ / "small.json", studio_ / "visual.json");
    fs::copy(studio_ / "photo.png", studio_ / "holiday.jpg");
    fs::copy(studio_ / "depth.png", studio_ / "painted.png");
    writeImage(studio_ / "quilt.png", quilt);
    if (tool() != "photo2native") // which writes it
        writeImage(studio_ / "holiday_qs8x6a0.75.png", quilt);
    if (tool() == "video2native") fs::copy(studio_ / "clip.mp4", studio_ / "clip-depth.mp4");
    if (tool() == "slide2native") fs::copy(studio_ / "slide.mkv", studio_ / "clip.mp4");
    if (tool() == "native2view") fs::copy(studio_ / "panel.png", studio_ / "native.png");
    for (const char* more : {"views/view6.png", "views/view7.png"}) // a folder has 8 at least
        fs::copy(studio_ / "views/view5.png", studio_ / more);
    for (const Arguments& example : examples) {
        const Outcome outcome = studio_.run(tool(), example);
        EXPECT_EQ(outcome.status, 0) << outcome.text();
    }
}

TEST_P(EveryTool, TheHelpExplainsItsWordsOnce) {
    const std::string help = studio_.run(tool(), "--help").out;
    const std::size_t place = help.find("\nWords:\n");
    ASSERT_NE(place, std::string::npos) << help;
    for (const char* word : {"Native", "quilt", "cover", "contain", "stretch", "calibration"}) {
        const bool used = std::regex_search(help.substr(0, place),
                                            std::regex(std::string("\\b") + word + "s?\\b"));
        const std::size_t line = help.find(std::string("\n  ") + word + " ", place);
        EXPECT_TRUE(!used || line != std::string::npos) << word << help;
    }
    EXPECT_EQ(help.find("black bars"), help.rfind("black bars")) << help;
}

TEST_P(EveryTool, AClosedPipeEndsTheHelpQuietly) { // as --help | head -1
    // the reader is gone before the tool begins
    const std::string script = "mkfifo go; { read -r _ <go; \"$0\" \"$1\"; echo $? >status; } | "
                               "{ exec <&-; echo closed >go; }; rm go";
    for (const char* option : {"--help", "--help-man", "--version"}) {
        const Outcome outcome =
            studio_.run("/bin/bash", {"-c", script, toolPath(tool()).string(), option});
        EXPECT_TRUE(isDone(outcome));
        EXPECT_EQ(slurp(studio_ / "status"), "0\n") << option;
    }
}

TEST_P(EveryTool, ManualAndCompletionsAreForProgramsOnly) { // tests/docs looks into them
    const std::string help = studio_.run(tool(), "--help-all").out;
    for (const char* option : {"--help-man", "--help-completion"})
        EXPECT_FALSE(holds(help, option));
    EXPECT_TRUE(fails(studio_.run(tool(), "--help-completion fish"), 2,
                      "--help-completion is \"fish\", expected bash or zsh"));
    const Outcome version = studio_.run(tool(), "--version");
    EXPECT_TRUE(isDone(version));
    EXPECT_EQ(version.out.rfind(tool() + " (altiro3D) ", 0), 0U) << version.out;
}

TEST_P(EveryTool, WrongCallsAreWrongUsage) {
    const Arguments call = studio_.goodCall(tool(), output("a"));
    const auto with = [&](const Arguments& more) { return studio_.run(tool(), call + more); };
    EXPECT_TRUE(fails(studio_.run(tool(), {}), 2, tool() + " --help"));
    for (const char* option : {"--wrong=3", "-Z", "-y=1", "--quil", "--\xff\xfe"})
        EXPECT_TRUE(fails(good(output("a"), {option}), 2, tool() + " --help"));
    for (const char* option : {"-q", "-j", "--serial", "-m", "-c"}) {
        if (!takes(option)) continue;
        EXPECT_TRUE(fails(with({option}), 2, option));
        EXPECT_TRUE(fails(with({option, ""}), 2, option));
    }
    EXPECT_TRUE(fails(with({""}), 2, "empty"));
    const int status = tool() == "slide2native" ? 1 : 2; // which takes any number of photos
    EXPECT_TRUE(fails(with("b.png c.png"), status, ""));
    for (const char* threads : {"0", "1.5", "7x"})
        EXPECT_TRUE(fails(good(output("a"), {"-j", threads}), 2, "-j is "));
    for (const char* pair : {"0x3", "99999999999x1"}) { // the last value counts
        EXPECT_TRUE(fails(with({"-q", pair}), 2, "-q"));
        if (takes("-r")) {
            EXPECT_TRUE(fails(with({"-r", pair}), 2, "-r"));
        }
    }
    if (takes("--invert")) {
        EXPECT_TRUE(fails(with("--invert maybe"), 2, "--invert"));
    }
    EXPECT_FALSE(fs::exists(studio_ / output("a")));
    EXPECT_FALSE(fs::exists(studio_ / "c.png"));
}

TEST(CommandLine, NothingButPlainNumbersCounts) { // one reader for all tools
    SmallStudio studio;
    const Arguments call = studio.goodCall("quilt2native", "a.png");
    for (const char* threads : {"-1", "nan", "inf", "1e999", "1,5", " 2", "0x2", "2000"}) {
        EXPECT_TRUE(
            fails(studio.run("quilt2native", call + Arguments{"-j", threads}), 2, "-j is "));
    }
    for (const char* pair : {"3x0", "-1x3", "2x3x4", "2x", "1025x1", " 2x3"})
        EXPECT_TRUE(fails(studio.run("quilt2native", call + Arguments{"-q", pair}), 2, "-q"));
    for (const char* pair : {"-1x3", "2x3x4"})
        EXPECT_TRUE(fails(studio.run("quilt2native", call + Arguments{"-r", pair}), 2, "-r"));
    EXPECT_TRUE(fails(studio.run("altiro3Dnative", "-r 70000x1 small.json"), 1, "65535"));
    EXPECT_FALSE(fs::exists(studio / "a.png"));
}

TEST(CommandLine, NumbersHaveAPointInEveryLocale) {
    SmallStudio studio;
    // few machines have this locale, so the test generates it, which takes seconds
    const std::string compile =
        "localedef -i de_DE -f UTF-8 '" + (studio / "de_DE.UTF-8").string() + "'";
    if (std::system((compile + " 2>" + (studio / "log").string()).c_str()) != 0) {
        GTEST_SKIP() << "needs Debian's package locales: " << slurp(studio / "log");
    }
    studio.makeClip();
    studio.makeSlide();
    studio.makeScan();
    const auto good = [&](const std::string& tool, const char* stem, const Arguments& more = {}) {
        return studio.run(tool, more + studio.goodCall(tool, outputName(tool, tool + stem)));
    };
    for (const std::string& tool : allTools())
        EXPECT_TRUE(isDone(good(tool, "a")));
    studio.set("ASAN_OPTIONS", "detect_leaks=0"); // glibc keeps memory for LOCPATH
    studio.set("LOCPATH", (studio / "de_DE.UTF-8").parent_path().string());
    studio.set("LC_ALL", "de_DE.UTF-8");
    for (const std::string& tool : allTools()) {
        EXPECT_TRUE(isDone(good(tool, "b")));
        EXPECT_EQ(slurp(studio / outputName(tool, tool + "a")),
                  slurp(studio / outputName(tool, tool + "b")));
        EXPECT_TRUE(fails(good(tool, "c", "-j 1,5"), 2, "-j"));
        const Outcome verbose = good(tool, "d", "-v");
        EXPECT_EQ(verbose.out.find(','), verbose.out.find(", ")) << verbose.out;
    }
}

TEST_P(EveryTool, AnyNumberOfThreadsGivesTheSameBytesInSilence) {
    ASSERT_TRUE(isDone(good(output("all"))));
    const std::string expected = slurp(studio_ / output("all"));
    ASSERT_FALSE(expected.empty());
    for (const char* threads : {"1", "2", "64"}) {
        const std::string name = output(threads);
        EXPECT_TRUE(isDone(good(name, {"-j", threads})));
        EXPECT_EQ(slurp(studio_ / name), expected) << threads;
    }
}

TEST_P(EveryTool, VerboseTellsTheTimeOfEachStage) {
    const Outcome outcome = good(output("a"), "-v");
    EXPECT_TRUE(isDone(outcome));
    const std::string stage = tool() == "video2native"  ? "encode "
                              : tool() == "quilt2video" ? "video "
                              : tool() == "native2view" ? "views "
                                                        : "write ";
    EXPECT_TRUE(holds(outcome.out, stage));
    EXPECT_TRUE(holds(outcome.out, " ms"));
    const Outcome plain = good(output("b"));
    EXPECT_FALSE(holds(plain.out, " ms"));
    EXPECT_TRUE(holds(plain.out, tool() == "native2view"
                                     ? "1 view, 30 x 40 px"
                                     : "3 columns x 2 rows, each view 30 x 40 px"));
    EXPECT_TRUE(holds(good(output("c"), "--verbose").out, stage));
}

TEST_P(EveryTool, AFullStandardOutputIsAnError) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
    studio_.sendOutputTo("/dev/full");
    for (const Arguments& arguments :
         {Arguments{"--help"}, Arguments{"--version"}, studio_.goodCall(tool(), output("a"))}) {
        EXPECT_TRUE(fails(studio_.run(tool(), arguments), 1, "standard output"));
    }
}

TEST_P(EveryTool, AnyByteMayStandInFileNames) {
    for (const std::string name : {"with blank", "new\nline\tand tab", "\xc3\xa4\xe6\xbc\xa2",
                                   "bytes \xff\xfe\x80", "100%s%n'\"*=b"}) {
        const std::string file = output(name);
        EXPECT_TRUE(isDone(good(file)));
        EXPECT_FALSE(slurp(studio_ / file).empty()) << file;
        EXPECT_TRUE(fails(good(file), 1, "exists")); // one line, whatever is in the name
        EXPECT_TRUE(isDone(good(file, "-y")));
    }
}

TEST_P(EveryTool, AnyByteMayStandInInputNames) {
    for (const std::string name : {"new\nline", "bytes \xff\xfe\x80"}) {
        Arguments call = studio_.goodCall(tool(), output(name + " out"));
        // the last input is before the output, or at the end for altiro3Dnative
        std::string& input = tool() == "altiro3Dnative" ? call.back() : call[call.size() - 2];
        const std::string renamed = name + fs::path(input).extension().string();
        fs::copy(studio_ / input, studio_ / renamed, fs::copy_options::recursive);
        input = renamed;
        EXPECT_TRUE(isDone(studio_.run(tool(), call)));
        fs::remove_all(studio_ / renamed);
        EXPECT_TRUE(fails(studio_.run(tool(), call + Arguments{"-y"}), 1, ""));
    }
}

TEST_P(EveryTool, LeadingDashesComeAfterTwoDashes) {
    Arguments call = studio_.goodCall(tool(), output("-out"));
    std::string& input = tool() == "altiro3Dnative" ? call.back() : call[call.size() - 2];
    fs::rename(studio_ / input, studio_ / ("-" + input));
    input = "-" + input;
    // all names without an option go behind "--"
    const std::size_t names = tool() == "altiro3Dnative" ? 1 : tool() == "photo2native" ? 3 : 2;
    call.insert(call.end() - static_cast<std::ptrdiff_t>(names), "--");
    EXPECT_TRUE(isDone(studio_.run(tool(), call)));
    EXPECT_TRUE(fs::exists(studio_ / output("-out")));
}

TEST_P(EveryTool, WorksInAHostileEnvironment) {
    studio_.startPrograms();
    for (const char* name : {"HOME", "LANG", "PATH", "ALTIRO3D_MODELS"})
        studio_.set(name, std::nullopt);
    EXPECT_TRUE(isDone(good(output("a"))));
    studio_.set("LC_ALL", "xx_YY.nonsense");
    studio_.set("XDG_CACHE_HOME", "/proc/nothing");
    studio_.set("XDG_DATA_HOME", "/proc/nothing");
    studio_.set("TMPDIR", "/proc/nothing");
    studio_.set("DISPLAY", ":77");
    studio_.set("QT_QPA_PLATFORM", "nonsense");
    EXPECT_TRUE(isDone(good(output("b"))));
    EXPECT_EQ(slurp(studio_ / output("a")), slurp(studio_ / output("b")));
}

} // namespace altiro3D::test
