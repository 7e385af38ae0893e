#include "altiro3D/altiro3D.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/onnx.hpp"
#include "support/slow.hpp"
#include "support/video.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr const char* kTool = "altiro3Dtradeoff";

// A board with a disparity of 6 px in front of a wall of 2 px, and the picture of the right camera.
// Disparity values are 10 times the px.
class Tradeoff : public ::testing::Test {
  protected:
    Tradeoff() { writeScene("", 7); }

    void writeScene(const std::string& folder, int boardWidth) const {
        const cv::Size size(60, 40);
        const cv::Mat photo = madePhoto(size.width, size.height);
        cv::Mat disparity(size, CV_8UC1, cv::Scalar::all(20));
        disparity(cv::Rect(25, 10, boardWidth, 20)) = 60;
        cv::Mat truth(size, CV_8UC3);
        for (int y = 0; y < size.height; ++y) {
            for (const int px : {2, 6}) { // the board covers the wall
                for (int x = 0; x < size.width; ++x) {
                    const bool here = disparity.at<uchar>(y, x) == 10 * px;
                    if (here && x >= px) truth.at<cv::Vec3b>(y, x - px) = photo.at<cv::Vec3b>(y, x);
                }
            }
            for (const int x : {58, 59}) // enters at the border of the frame
                truth.at<cv::Vec3b>(y, x) = photo.at<cv::Vec3b>(y, 59);
        }
        // hidden by the board: the wall continues
        for (int y = 10; y < 30; ++y) {
            for (int x = 19 + boardWidth; x < 23 + boardWidth; ++x)
                truth.at<cv::Vec3b>(y, x) = photo.at<cv::Vec3b>(y, 25 + boardWidth);
        }
        if (!folder.empty()) fs::create_directory(sandbox_ / folder);
        const std::string prefix = folder.empty() ? "" : folder + "/";
        writeImage(sandbox_ / (prefix + "L.png"), photo);
        writeImage(sandbox_ / (prefix + "D.png"), disparity);
        writeImage(sandbox_ / (prefix + "R.png"), truth);
    }
    Outcome run(const Arguments& arguments) const { return sandbox_.run(kTool, arguments); }
    Arguments scene() const {
        return {"--photo",           "L.png", "--disparity", "D.png",
                "--disparity-scale", "10",    "--truth",     "R.png"};
    }
    Json json() const { return sandbox_.json("t.json"); }

    Sandbox sandbox_;
};

} // namespace

TEST_F(Tradeoff, PrintsEverySettingOfAScene) {
    const Outcome outcome = run(scene() + Arguments{"--exact-depth"});
    EXPECT_TRUE(says(outcome, "L.png, 60 x 40 px, disparity up to 6.00 px"));
    const std::vector<std::string> lines = test::lines(outcome.out);
    const std::vector<NamedViewOptions> settings = tradeSettings();
    // scene and heading; after the settings the heading of estimated depth and its one source
    ASSERT_EQ(lines.size(), settings.size() + 4) << outcome.out;
    EXPECT_EQ(lines.back().rfind("tiny, 32 px ", 0), 0U) << lines.back();
    for (std::size_t i = 0; i < settings.size(); ++i) {
        EXPECT_EQ(lines[i + 2].rfind(settings[i].name + " ", 0), 0U) << lines[i + 2];
        EXPECT_TRUE(holds(lines[i + 2], " dB ")) << lines[i + 2];
    }
}

TEST_F(Tradeoff, WritesWhatIsAskedForAndReplacesItOnlyWithY) {
    const Arguments outputs("--report t.json --csv t.csv --plot t.svg --save-views views");
    ASSERT_TRUE(isDone(run(scene() + outputs)));
    const std::size_t settings = tradeSettings().size();

    const Json report = json();
    EXPECT_EQ(report.at("tool"), kTool);
    EXPECT_EQ(report.at("against"), "true view");
    ASSERT_EQ(report.at("rows").size(), settings);
    for (const Json& row : report.at("rows")) {
        EXPECT_EQ(row.at("scene"), "L.png");
        EXPECT_GT(row.at("millisecondsPerView").get<double>(), 0);
        EXPECT_GT(row.at("psnrWhole").get<double>(), 15) << row;
        EXPECT_LE(row.at("ssimInside").get<double>(), 1);
    }
    // whole px and exact depth: only what was hidden had to be made up, and here it is known
    const auto psnrOf = [&](const std::string& setting) {
        for (const Json& row : report.at("rows"))
            if (row.at("setting") == setting) return row.at("psnrInside");
        return Json();
    };
    const Json exact = psnrOf("layered, fill continue");
    EXPECT_TRUE(exact.is_null() || exact.get<double>() > 25) << exact; // null: no difference at all

    const std::vector<std::string> lines = test::lines(slurp(sandbox_ / "t.csv"));
    ASSERT_EQ(lines.size(), settings + 1);
    EXPECT_EQ(lines[0].rfind("scene,setting,ms_per_view,", 0), 0U) << lines[0];
    EXPECT_EQ(lines[1].rfind("\"L.png\",\"fast\",", 0), 0U) << lines[1];

    const std::string plot = slurp(sandbox_ / "t.svg");
    EXPECT_EQ(plot.rfind("<svg", 0), 0U) << plot.substr(0, 80);
    EXPECT_TRUE(holds(plot, "</svg>"));
    EXPECT_TRUE(holds(plot, "L.png"));

    const StereoScene stereo =
        makeStereoScene("s", readPhoto(sandbox_ / "L.png"), readDepthImage(sandbox_ / "D.png"), 10,
                        readPhoto(sandbox_ / "R.png"));
    for (const NamedViewOptions& method : defaultSettings()) {
        cv::Mat view;
        Depth2Quilt({1, 1, stereo.photo.size(), 1}, stereo.options(method.options))
            .renderView({stereo.photo, stereo.depth}, 1, view);
        EXPECT_TRUE(samePicture(readBack(sandbox_ / ("views/" + method.name + ".png")), view))
            << method.name;
    }
    EXPECT_EQ(listImages(sandbox_ / "views").size(), 3U);

    for (const Arguments& output : {Arguments("--report t.json"), Arguments("--csv t.csv"),
                                    Arguments("--plot t.svg"), Arguments("--save-views views")}) {
        EXPECT_TRUE(fails(run(scene() + output), 1, "exists"));
    }
    EXPECT_EQ(slurp(sandbox_ / "t.svg"), plot);
    EXPECT_EQ(json(), report);
    spill(sandbox_ / "t.json", "old");
    EXPECT_TRUE(isDone(run(scene() + Arguments("-y --report t.json"))));
    EXPECT_EQ(json().at("rows").size(), settings);
    EXPECT_TRUE(fails(run(scene() + Arguments("-y --report L.png")), 2, "is also an input"));
    EXPECT_TRUE(fails(run(scene() + Arguments("--csv x --report x")), 2, "written twice"));
    EXPECT_TRUE(fails(run(scene() + Arguments("--report none/x")), 1, "there is no directory"));
}

TEST_F(Tradeoff, SourcesOfDepthAreComparedWithTheTruth) {
    ASSERT_TRUE(isDone(run(scene() + Arguments("--exact-depth --report t.json"))));
    const Json rows = json().at("estimatedDepth");
    ASSERT_EQ(rows.size(), 1U);
    const Json& row = rows.front();
    EXPECT_EQ(row.at("source"), "tiny, 32 px");
    EXPECT_EQ(row.at("scene"), "L.png");
    EXPECT_GT(row.at("milliseconds").get<double>(), 0);

    // step by step
    const StereoScene stereo =
        makeStereoScene("L.png", readPhoto(sandbox_ / "L.png"), readDepthImage(sandbox_ / "D.png"),
                        10, readPhoto(sandbox_ / "R.png"));
    cv::Mat depth;
    const InstalledNetwork tiny = standardNetwork(false, {sandbox_.models()}).value();
    altiro3D::Scene estimated;
    depthFromNetworkFile(tiny.file, tiny.profile)->readScene(stereo.photo, 0.5, estimated);
    depth = estimated.depth;
    cv::resize(depth, depth, stereo.depth.size(), 0, 0, cv::INTER_LINEAR);
    EXPECT_NEAR(row.at("rankCorrelation").get<double>(), rankCorrelation(depth, stereo.depth),
                kReportPrecision);
    alignDepth(depth, stereo.depth, depth);
    ViewOptions layered;
    layered.method = ViewMethod::Layered;
    cv::Mat view;
    Depth2Quilt({1, 1, stereo.photo.size(), 1}, stereo.options(layered))
        .renderView({stereo.photo, depth}, 1, view);
    const ViewAccuracy accuracy = compareViews(view, stereo.truth, stereo.band());
    EXPECT_NEAR(row.at("psnrInside").get<double>(), accuracy.psnrInside, kReportPrecision);
    EXPECT_NEAR(row.at("ssimWhole").get<double>(), accuracy.ssimWhole, kReportPrecision);
}

// A network whose numbers overflow where the picture is bright.
TEST_F(Tradeoff, ASourceOfDepthThatFailsIsLeftOutOfAllScenes) {
    const fs::path models = sandbox_.models();
    spill(models / "hot.onnx", onnx::mixModel({2e38F, 2e38F, 2e38F}, {0, 0}));
    spill(models / "catalog.json",
          R"({"networks": [{"name": "hot", "file": "hot.onnx", "inputWidth": 32,
                            "inputHeight": 32},
                           {"name": "tiny", "file": "tiny.onnx", "inputWidth": 32,
                            "inputHeight": 32}]})");
    writeScene("dark", 9);
    writeScene("bright", 9);
    for (const char* picture : {"L.png", "R.png"}) {
        const fs::path dark = sandbox_ / ("dark/" + std::string(picture));
        writeImage(dark, readPhoto(dark) / 8);
    }
    writeImage(sandbox_ / "bright/L.png", cv::Mat(40, 60, CV_8UC3, cv::Scalar::all(250)));
    const std::string head = "scene,left,right,disp_left,disp_scale\n";
    const std::string rows = "dark,L.png,R.png,D.png,10\nbright,L.png,R.png,D.png,10\n";
    spill(sandbox_ / "scenes.csv", head + rows);
    const Arguments call("--scenes scenes.csv --exact-depth --report t.json");
    const Outcome outcome = run(call);
    EXPECT_TRUE(warns(outcome, "depth by hot, 32 px is left out"));
    EXPECT_TRUE(holds(outcome.out, "\nhot, 32 px ")) << "it was measured on the dark scene";
    const Json report = json();
    EXPECT_EQ(report.at("rows").size(), 3 * tradeSettings().size());
    std::vector<std::string> measured;
    for (const Json& row : report.at("estimatedDepth"))
        measured.push_back(row.at("scene").get<std::string>() + ": " +
                           row.at("source").get<std::string>());
    EXPECT_EQ(measured, (std::vector<std::string>{"dark: tiny, 32 px", "bright: tiny, 32 px",
                                                  "mean: tiny, 32 px"}));
}

TEST_F(Tradeoff, ADamagedCatalogueIsReportedBeforeAnyMeasurement) {
    const fs::path models = sandbox_ / "net";
    fs::create_directory(models);
    sandbox_.set("ALTIRO3D_MODELS", models.string());
    spill(models / "catalog.json", "{\"networks\": [");
    const Outcome outcome = run(scene() + Arguments{"--exact-depth"});
    EXPECT_TRUE(fails(outcome, 1, "catalog.json"));
    EXPECT_FALSE(holds(outcome.out, "per view"));
}

TEST_F(Tradeoff, ScenesOfATableGetMeans) {
    writeScene("one", 9);
    writeScene("two", 20);
    spill(sandbox_ / "scenes.csv", "disp_scale,scene,left,right,disp_left,note\r\n"
                                   "10,one,L.png,R.png,D.png,nothing\r\n"
                                   "\n"
                                   "10,two,L.png,R.png,D.png\n");
    EXPECT_TRUE(
        says(run("--scenes scenes.csv --report t.json --plot t.svg -j 1"), "mean of 2 scenes"));
    const Json rows = json().at("rows");
    const std::size_t settings = tradeSettings().size();
    ASSERT_EQ(rows.size(), 3 * settings);
    for (std::size_t i = 0; i < settings; ++i) {
        const Json& one = rows[i];
        const Json& two = rows[settings + i];
        const Json& mean = rows[2 * settings + i];
        EXPECT_EQ(one.at("scene"), "one");
        EXPECT_EQ(two.at("scene"), "two");
        EXPECT_EQ(mean.at("scene"), "mean");
        EXPECT_EQ(mean.at("setting"), one.at("setting"));
        for (const char* key : {"millisecondsPerView", "psnrWhole", "ssimWhole", "ssimInside"}) {
            EXPECT_NEAR(mean.at(key).get<double>(),
                        (one.at(key).get<double>() + two.at(key).get<double>()) / 2,
                        kReportPrecision)
                << key;
        }
    }
    EXPECT_TRUE(holds(slurp(sandbox_ / "t.svg"), "mean"));
}

TEST_F(Tradeoff, BrokenTablesAreOneErrorLineThatNamesTheColumn) {
    writeScene("one", 9);
    const std::string head = "scene,left,right,disp_left,disp_scale\n";
    const std::pair<std::string, const char*> tables[] = {
        {"", "lists no scenes"},
        {head, "lists no scenes"},
        {"scene,left,right,disp_left\none,L.png,R.png,D.png\n", "has no disp_scale"},
        {"scene,left,disp_left,disp_scale\none,L.png,D.png,10\n", "has no right"},
        {head + "one,L.png,R.png,D.png\n", "has no disp_scale"},
        {head + ",L.png,R.png,D.png,10\n", "has no scene"},
        {head + "one,,R.png,D.png,10\n", "has no left"},
        {head + "one,L.png,R.png,D.png,ten\n", "disp_scale is \"ten\""},
        {head + "one,L.png,R.png,D.png,0\n", "disparity scale"},
        {head + "one,L.png,R.png,none.png,10\n", "none.png"},
        {head + "none,L.png,R.png,D.png,10\n", "none/L.png"}};
    for (const auto& [table, part] : tables) {
        spill(sandbox_ / "scenes.csv", table);
        EXPECT_TRUE(fails(run("--scenes scenes.csv --report t.json"), 1, part)) << table;
    }
    EXPECT_TRUE(fails(run("--scenes none.csv"), 1, "none.csv"));
    EXPECT_TRUE(fails(run("--scenes one"), 1, "one"));
    EXPECT_FALSE(fs::exists(sandbox_ / "t.json"));
}

TEST_F(Tradeoff, BrokenScenesAreOneErrorLine) {
    writeImage(sandbox_ / "small.png", madePhoto(59, 40));
    spill(sandbox_ / "broken.png", "broken");
    const auto with = [&](const char* option, const char* file) {
        Arguments call = scene();
        for (std::size_t i = 0; i + 1 < call.size(); i += 2)
            if (call[i] == option) call[i + 1] = file;
        return run(call + Arguments("--report t.json"));
    };
    for (const char* option : {"--photo", "--disparity", "--truth"}) {
        EXPECT_TRUE(fails(with(option, "none.png"), 1, "none.png: does not exist"));
        EXPECT_TRUE(fails(with(option, "broken.png"), 1, "broken.png"));
    }
    EXPECT_TRUE(fails(with("--truth", "small.png"), 1, "59 x 40"));
    for (const char* scale : {"0", "nan", "ten"})
        EXPECT_TRUE(fails(with("--disparity-scale", scale), 2, "--disparity-scale"));
    EXPECT_FALSE(fs::exists(sandbox_ / "t.json"));
}

TEST_F(Tradeoff, APhotoAloneIsComparedWithTheMostAccurateSetting) {
    // without strength all views are the photo, and soon made
    EXPECT_TRUE(says(run("--strength 0 --report t.json --csv t.csv --plot t.svg L.png"),
                     "reference: layered, outermost view, 420 x 560 px"));
    const Json report = json();
    EXPECT_EQ(report.at("against"), "most accurate setting");
    ASSERT_EQ(report.at("rows").size(), tradeSettings().size());
    for (const Json& row : report.at("rows")) {
        EXPECT_TRUE(row.at("psnrWhole").is_null()); // no difference: infinite
        EXPECT_NEAR(row.at("ssimWhole").get<double>(), 1, 1e-12);
    }
    EXPECT_EQ(slurp(sandbox_ / "t.svg").rfind("<svg", 0), 0U);
    EXPECT_TRUE(fails(run("none.png"), 1, "none.png"));
}

TEST_F(Tradeoff, TheDepthOfAPhotoMayBeGiven) {
    ALTIRO3D_TAKES(23);
    // a flat depth at the focus leaves every view the photo, whatever the strength
    writeImage(sandbox_ / "flat.png", cv::Mat(40, 60, CV_8UC1, cv::Scalar::all(9)));
    EXPECT_TRUE(isDone(run("--strength 4 --report t.json -d L.png flat.png")));
    const Json flat = json().at("rows");
    ASSERT_EQ(flat.size(), tradeSettings().size());
    for (const Json& row : flat) {
        EXPECT_EQ(row.at("scene"), "L.png");
        EXPECT_TRUE(row.at("psnrWhole").is_null()) << row; // no difference: infinite
    }
    // the board before the wall moves, and not all settings make the same of it
    EXPECT_TRUE(says(run("--strength 4 -y --report t.json -d L.png D.png"),
                     "reference: layered, outermost view, 420 x 560 px"));
    EXPECT_EQ(json().at("against"), "most accurate setting");
    const Json rows = json().at("rows");
    ASSERT_EQ(rows.size(), tradeSettings().size());
    EXPECT_TRUE(rows.back().at("psnrWhole").is_null()) << "the reference itself";
    EXPECT_TRUE(rows.front().at("psnrWhole").is_number()) << rows.front();

    EXPECT_TRUE(fails(run("-d L.png"), 2, "expected PHOTO and DEPTH, got 1 name"));
    EXPECT_TRUE(fails(run("-d L.png none.png"), 1, "none.png"));
}

TEST_F(Tradeoff, WrongCombinationsAreWrongUsage) {
    spill(sandbox_ / "scenes.csv", "");
    const char* const together = "--photo, --disparity and --truth belong together";
    const char* const oneScene = "--save-views shows one scene";
    const std::pair<Arguments, const char*> cases[] = {
        {{}, "expected PHOTO (with -d PHOTO and DEPTH), got 0 names"},
        {"L.png R.png", "expected PHOTO (with -d PHOTO and DEPTH), got 2 names"},
        {"--photo L.png", together},
        {"--photo L.png --truth R.png", together},
        {"--truth R.png L.png", together},
        {"--disparity D.png L.png", together},
        {scene() + Arguments{"L.png"}, "expected no names beside --photo or --scenes, got 1 name"},
        {scene() + Arguments("--scenes scenes.csv"), "--photo and --scenes exclude each other"},
        {"--scenes scenes.csv L.png", "expected no names beside --photo or --scenes, got 1 name"},
        {"--scenes scenes.csv --save-views views", oneScene},
        {"--save-views views L.png", oneScene},
        {"--wrong L.png", "Unknown option 'wrong'"},
        {{"--report", "", "L.png"}, "--report is empty"},
        {"--strength 101 L.png", "--strength is \"101\", expected a number 0..100"},
        {"--scenes", "Missing value after '--scenes'"},
        // options that change nothing
        {scene() + Arguments("--strength 5"),
         "--strength does not apply to scenes with a true view"},
        {scene() + Arguments{"-l"}, "-l does not apply to scenes"},
        {"--method=fast L.png", "Unknown option"},
        {"-g L.png", "Unknown option"},
        {"-k L.png", "Unknown option"},
        {"--refine=2 L.png", "Unknown option"},
        {"--fill=continue L.png", "Unknown option"},
        {"--disparity-scale 2 L.png", "expected --photo with it"}};
    for (const auto& [arguments, sentence] : cases)
        EXPECT_TRUE(fails(run(arguments), 2, sentence));
    EXPECT_FALSE(fs::exists(sandbox_ / "views"));
}

TEST_F(Tradeoff, HelpAndVersionAreAsOfTheOtherTools) {
    for (const char* option : {"--help", "-h"}) {
        const Outcome outcome = run({option});
        EXPECT_TRUE(isDone(outcome));
        EXPECT_EQ(outcome.out.rfind("Usage: altiro3Dtradeoff ", 0), 0U) << outcome.out;
        for (const std::string& line : test::lines(outcome.out))
            EXPECT_LE(line.size(), 100U) << line;
    }
    EXPECT_EQ(run("--version").out.rfind("altiro3Dtradeoff (altiro3D) ", 0), 0U);
    if (!fs::exists("/dev/full")) return;
    sandbox_.sendOutputTo("/dev/full");
    EXPECT_TRUE(fails(run(scene()), 1, "standard output"));
}

} // namespace altiro3D::test
