#include "altiro3D/altiro3D.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/photo_files.hpp"
#include "support/random_pictures.hpp"
#include "support/stereo_scene.hpp"

#include <csignal>
#include <fcntl.h>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <set>
#include <sstream>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace altiro3D::test {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr const char* kTool = "photo2native";

std::vector<std::string> names(const fs::path& directory) {
    std::vector<std::string> result;
    for (const fs::path& file : listImages(directory))
        result.push_back(file.filename().string());
    return result;
}

} // namespace

class Photo2Native : public StudioTest {
  protected:
    Photo2Native() : StudioTest(kTool) {}
};

TEST_F(Photo2Native, GivesTheNativeOfTheLibrary) {
    writeImage(studio_ / "photo.png", madePhoto(150, 110)); // not of the panel's shape
    const std::pair<Arguments, std::function<void(LibraryPath&)>> cases[] = {
        {{}, [](LibraryPath&) {}},
        {"-k", [](LibraryPath& p) { p.keep = true, p.quilt = false; }},
        {"--strength 37.5 --focus 0.25",
         [](LibraryPath& p) { p.views.strengthPercent = 37.5, p.views.focus = 0.25; }},
        {"--fit contain", [](LibraryPath& p) { p.fit = FitMode::Contain; }},
        {"--fit stretch -j 1", [](LibraryPath& p) { p.fit = FitMode::Stretch; }},
        {"--view-filter linear --sampling linear",
         [](LibraryPath& p) {
             p.sampling = {ViewFilter::Linear, TileSampling::Linear};
         }},
        {"--view-filter linear -k",
         [](LibraryPath& p) { p.sampling.views = ViewFilter::Linear, p.keep = true; }},
        {"--depth-kind far-white", [](LibraryPath& p) { p.kind = DepthKind::FarWhite; }},
        {"--depth-kind metric:5000", [](LibraryPath& p) { p.kind = DepthKind::Metric; }},
        {"--continuous -k --method fast --refine 2",
         [](LibraryPath& p) {
             p.views.method = ViewMethod::Fast, p.views.refinement = 2;
             p.keep = true, p.quilt = false, p.positions = ViewPositions::Continuous;
         }},
        {"--center 0.2,1 --zoom 1.5", [](LibraryPath& p) {
             p.framing = {{0.2, 1}, 1.5};
         }}};
    for (const auto& [arguments, set] : cases) {
        LibraryPath path;
        set(path);
        const Outcome outcome = convert(fixedWay(arguments) +
                                        Arguments("--quick -y -d photo.png depth.png native.png"));
        ASSERT_EQ(outcome.status, 0) << outcome.text();
        EXPECT_TRUE(samePicture(readBack(studio_ / "native.png"), libraryNative(studio_, path)))
            << outcome.call;
    }
}

TEST_F(Photo2Native, ShowsWhatTheLensesCanShowUnlessSomethingElseIsAskedFor) { // all: Jobs
    const auto settingsOf = [&](const Arguments& options) {
        EXPECT_TRUE(isDone(convert(fixedWay(options) +
                                   Arguments("-y --report r.json -d photo.png depth.png a.png"))));
        const Json now = studio_.json("r.json").at("settings");
        return now.at("detail").get<std::string>() + (now.at("lensFilter") ? " filtered" : "") +
               (now.at("continuous") ? " continuous" : "");
    };
    EXPECT_EQ(settingsOf("-k"), "panel");
    EXPECT_EQ(settingsOf("--quick"), "view");
    EXPECT_EQ(settingsOf("--continuous"), "view continuous");
    EXPECT_EQ(settingsOf({}), "lens filtered continuous");
    Display display;
    display.calibration = readCalibration(studio_ / "small.json");
    NativeOptions options;
    options.showAs(Detail::Lens);
    altiro3D::Scene scene;
    scene.photo = readPhoto(studio_ / "photo.png");
    normalizeDepth(readDepthImage(studio_ / "depth.png"), scene.depth);
    cv::Mat native;
    NativeMaker(display, smallLayout(), options).makeNative(scene, native);
    EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"), native));
}

TEST_F(Photo2Native, AutoSaysAndReportsWhatTheLibraryChooses) {
    const cv::Mat photo = madePhoto(150, 110);
    writeImage(studio_ / "photo.png", photo);
    const cv::Mat depth16 = madeDepth(75, 55);
    writeImage(studio_ / "depth.png", depth16);
    const Outcome outcome = convert("--quick --fit auto --focus auto --strength auto --report "
                                    "r.json -d photo.png depth.png native.png");
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.text(), "auto: center "));
    const Json report = studio_.json("r.json");
    EXPECT_TRUE(report.at("settings").at("focus").is_null());
    EXPECT_EQ(report.at("settings").at("fit"), "auto");
    cv::Mat depth;
    depth16.convertTo(depth, CV_32F);
    normalizeDepth(cv::Mat(depth), depth);
    LibraryPath path;
    const PlacementOptions chosen =
        chooseFromScene({photo, depth}, 0.75, smallLayout(), {}, {true, true, true}).options;
    path.views = chosen.views;
    path.framing = chosen.framing;
    const Json& picture = report.at("pictures").at(0);
    EXPECT_NEAR(picture.at("focus").get<double>(), path.views.focus, 1e-6);
    EXPECT_NEAR(picture.at("strengthPercent").get<double>(), path.views.strengthPercent, 1e-6);
    EXPECT_NEAR(picture.at("center").at(0).get<double>(), path.framing.centre.x, kReportPrecision);
    EXPECT_GT(path.views.strengthPercent, 0);
    EXPECT_LE(path.views.strengthPercent, kMaxAutoStrength);
    EXPECT_TRUE(samePicture(readBack(studio_ / "native.png"), libraryNative(studio_, path)));
}

TEST_F(Photo2Native, WithoutOptionsFramingFocusAndALimitOfTheStrengthFollowFromThePhoto) {
    cv::Mat photo(200, 280, CV_8UC3, cv::Scalar::all(99)); // a scan with 3 px around it
    for (int y = 3; y < 197; ++y) // stripes, of which the bright ones are near to the network
        for (int x = 3; x < 277; ++x)
            photo.at<cv::Vec3b>(y, x) = cv::Vec3b::all(x / 20 % 2 == 0 ? 240 : 10);
    writeImage(studio_ / "photo.png", photo);
    const auto make = [&](const Arguments& options, const Arguments& files) {
        const Outcome outcome = convert(Arguments("-y --report r.json") + options + files);
        EXPECT_TRUE(isDone(outcome));
        return outcome.out;
    };
    const auto picture = [&] { return studio_.json("r.json").at("pictures").at(0); };
    const Arguments estimated("photo.png a.png");
    const std::string said = make("--save-depth depth.png", estimated);
    EXPECT_TRUE(holds(said, "--fit cover --focus 0.5 chooses nothing\n"));
    for (const char* part : {"; border of the scan cut: 4 px top", " px bottom", ", strength "})
        EXPECT_TRUE(holds(said, part));
    const Json chosen = picture();
    EXPECT_LT(chosen.at("strengthPercent"), 8); // H of (7.4) is some 3 stripes of the part shown
    EXPECT_GT(chosen.at("strengthPercent"), 2);
    const std::string native = slurp(studio_ / "a.png");
    const std::string same = make("--fit auto --focus auto", estimated);
    EXPECT_EQ(slurp(studio_ / "a.png"), native);
    EXPECT_FALSE(holds(same, "chooses nothing"));
    // each option is obeyed
    make("--strength 10", estimated);
    EXPECT_EQ(picture().at("strengthPercent"), 10);
    make("--focus 0.25", estimated);
    EXPECT_EQ(picture().at("focus"), 0.25);
    for (const Arguments& framed : {Arguments("--fit cover"), Arguments("--center 0.5,0.5")}) {
        make(framed, estimated);
        EXPECT_EQ(picture().at("center"), Json({0.5, 0.5}));
        EXPECT_EQ(picture().at("crop").at(3), 200);
    }
    // given depth bears the strength that is usual
    make({}, "-d photo.png depth.png a.png");
    EXPECT_EQ(picture().at("strengthPercent"), 10);
    EXPECT_LT(picture().at("crop").at(3), 195);
}

TEST_F(Photo2Native, OnlyTheBorderOfAScanThatWouldBeSeenIsSaidToBeCut) {
    const auto saidOf = [&](int cols, int rows, const cv::Rect& inside) {
        cv::Mat photo(rows, cols, CV_8UC3, cv::Scalar::all(250));
        cv::Mat part = photo(inside); // neither rows nor columns of it have one colour
        for (int y = 0; y < part.rows; ++y)
            for (int x = 0; x < part.cols; ++x)
                part.at<cv::Vec3b>(y, x) = cv::Vec3b::all((x / 9 + y / 9) % 2 == 0 ? 20 : 130);
        writeImage(studio_ / "photo.png", photo);
        writeImage(studio_ / "depth.png", madeDepth(cols / 4, rows / 4));
        const Outcome outcome = convert("-y -d photo.png depth.png a.png");
        EXPECT_TRUE(isDone(outcome));
        const std::size_t at = outcome.out.find("; border of the scan cut: ");
        return at == std::string::npos ? ""
                                       : outcome.out.substr(at, outcome.out.find('\n', at) - at);
    };
    // the panel is 3 : 4: of a wide photo it shows the middle
    EXPECT_EQ(saidOf(400, 200, {5, 0, 390, 200}), "");
    EXPECT_EQ(saidOf(400, 200, {5, 3, 390, 194}),
              "; border of the scan cut: 4 px top, 4 px bottom");
    EXPECT_EQ(saidOf(300, 400, {5, 0, 295, 400}), "; border of the scan cut: 6 px left");
}

TEST_F(Photo2Native, OnlyThePathOverTheQuiltNeedsATable) {
    const Arguments photo("-v -y --report r.json -d photo.png depth.png a.png");
    const auto isReported = [&](const char* path) { // and only a quilt has views
        const Json report = studio_.json("r.json");
        return report.at("settings").at("path") == path &&
               report.at("pictures").at(0).at("milliseconds").contains("views") == (*path == 'q');
    };
    for (const Arguments& options :
         {Arguments{}, Arguments{"-k"}, Arguments{"--continuous"}, Arguments("--method fast"),
          Arguments("--view-filter nearest --sampling nearest")}) {
        const Outcome outcome = convert(options + photo);
        EXPECT_TRUE(says(outcome, "path: direct, "));
        EXPECT_TRUE(isReported("direct"));
    }
    EXPECT_TRUE(says(convert(Arguments("--save-quilt q.png --save-views v") + photo), "direct, "));
    EXPECT_TRUE(says(convert(Arguments{"-g"} + photo), "path: over the quilt, as method real"));
    EXPECT_FALSE(fs::exists(studio_.home() / ".cache")) << "nothing is kept unasked";
    for (const char* options : {"--sampling linear", "--view-filter linear"}) {
        EXPECT_TRUE(isDone(convert(Arguments(options) + photo)));
        EXPECT_TRUE(isReported("quilt")) << options;
    }
}

TEST_F(Photo2Native, ContinuousPositionsNeedTheDirectPath) { // options that exclude them: Jobs
    // more views than the direct path supports in a row
    const Outcome many = run("-c small.json -q 257x256 -r 2x2 -y -d photo.png depth.png many.png");
    EXPECT_TRUE(isDone(many));
    EXPECT_TRUE(
        fails(run("--continuous -c small.json -q 257x256 -r 2x2 -d photo.png depth.png a.png"), 2,
              "more than 65536 views"));
    EXPECT_FALSE(fs::exists(studio_ / "a.png"));
}

TEST_F(Photo2Native, DepthIsEstimatedByTheFirstNetworkOrTheNamedOne) {
    LibraryPath path;
    path.isEstimated = true;
    const cv::Mat native = libraryNative(studio_, path);
    const std::string file = (studio_.models() / "tiny.onnx").string();
    for (const Arguments& network :
         {Arguments{}, Arguments("-n tiny"), Arguments("-n tiny.onnx"), Arguments{"-n", file}}) {
        EXPECT_TRUE(says(convert(Arguments("--quick -y --report r.json") + fixedWay(network) +
                                 Arguments("photo.png a.png")),
                         "depth: network tiny ("));
        EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"), native));
        const Json settings = studio_.json("r.json").at("settings");
        EXPECT_EQ(settings.at("network").at("name"), "tiny");
        EXPECT_EQ(settings.at("network").at("file"), file);
    }
}

TEST_F(Photo2Native, WithoutANetworkOnlyPhotosWithoutDepthFail) {
    fs::remove(studio_.models() / "tiny.onnx");
    const std::string problem = "depth: no network is installed that could estimate it, expected ";
    const auto run = [&](const Arguments& more) {
        return convert(Arguments{"-y"} + more + Arguments{"a.png"});
    };
    EXPECT_TRUE(fails(run("photo.png"), 1, problem));
    EXPECT_TRUE(fails(run("-n tiny photo.png"), 1, "tiny.onnx is missing"));
    EXPECT_FALSE(fs::exists(studio_ / "a.png"));
    EXPECT_TRUE(isDone(run("-d photo.png depth.png")));
    fs::copy(studio_ / "depth.png", studio_ / "photo-depth.png");
    EXPECT_TRUE(isDone(run("photo.png")));
}

TEST_F(Photo2Native, ANetworkOfTheCatalogueThatIsNotThereIsNotUsed) {
    fs::create_directory(studio_ / "net");
    fs::copy(sourcePath("models/catalog.json"), studio_ / "net/catalog.json");
    studio_.set("ALTIRO3D_MODELS", (studio_ / "net").string());
    if (fs::exists(sourcePath("models/model-small.onnx")) ||
        fs::exists(sourcePath("models/model-f6b98070.onnx")))
        GTEST_SKIP() << "networks lie in the source tree";
    const auto with = [&](const Arguments& network) {
        return convert(network + Arguments("photo.png a.png"));
    };
    const auto expectFailures = [&](int status,
                                    const std::vector<std::pair<const char*, const char*>>& cases) {
        for (const auto& [network, part] : cases)
            EXPECT_TRUE(fails(with(network), status, part));
    };
    fs::create_directory(studio_ / "midas-large"); // a folder of that name is not a network
    expectFailures(1, {{"-l", "model-f6b98070.onnx"},
                       {"-n midas-small", "its file model-small.onnx is missing"},
                       {"-n midas-large", "its file model-f6b98070.onnx is missing"},
                       {"-n no.onnx", "no.onnx"},
                       {"-n midas", "midas-small, midas-large"}});
    // the one of the source tree, and none that is not the first
    spill(studio_ / "net/fastdepth_224_op10.onnx", "no network");
    EXPECT_TRUE(says(with(Arguments{"--quick"} + fixedWay()), "depth: network altiro3d ("));
    // -l must agree with the catalogue
    for (const char* file : {"net/model-small.onnx", "net/model-f6b98070.onnx", "other.onnx"})
        spill(studio_ / file, "no network either");
    fs::remove(studio_ / "a.png");
    expectFailures(2, {{"-l -n midas-small", "the catalogue knows it as midas-small"},
                       {"-l -n net/model-small.onnx", "midas-small"}});
    // correct usage; the error that the files are not networks follows when they are loaded
    expectFailures(1, {{"-l", "net/model-f6b98070.onnx"},
                       {"", "net/model-small.onnx"},
                       {"-l -n midas-large", "model-f6b98070.onnx"},
                       {"-n net/model-f6b98070.onnx", "model-f6b98070.onnx"},
                       {"-l -n other.onnx", "other.onnx"},
                       {"-n other.onnx", "--net-profile"}});
    EXPECT_FALSE(fs::exists(studio_ / "a.png"));
}

TEST_F(Photo2Native, WhatItSavesLeadsToTheSameNativeAgain) {
    const Arguments photo = studio_.display() + Arguments("-d photo.png depth.png a.png");
    for (const Arguments& keep :
         {Arguments{"--quick"}, Arguments("-k --view-filter nearest"), Arguments("-k -g")}) {
        ASSERT_TRUE(isDone(run(keep + Arguments{"-y"} + photo)));
        const std::string expected = slurp(studio_ / "a.png");
        EXPECT_TRUE(says(
            run(keep +
                Arguments(
                    "-y --save-quilt q.png --save-views v --save-depth d.png --save-rgbd r.png") +
                photo),
            "q_qs3x2a0.75.png"));
        EXPECT_EQ(slurp(studio_ / "a.png"), expected); // whatever else is saved
        EXPECT_TRUE(isDone(studio_.run(
            "quilt2native", "-y --sampling nearest -c small.json q_qs3x2a0.75.png fromQuilt.png")));
        // sampled at the panel's resolution, the Native shows more than any quilt
        const bool ofQuilt = keep.size() != 3;
        EXPECT_EQ(slurp(studio_ / "fromQuilt.png") == expected, ofQuilt);
        EXPECT_EQ(names(studio_ / "v").size(), 6U);
        EXPECT_TRUE(
            isDone(studio_.convert("views2native", "-y --sampling nearest v fromViews.png")));
        EXPECT_EQ(slurp(studio_ / "fromViews.png"), slurp(studio_ / "fromQuilt.png"));
        EXPECT_EQ(readBack(studio_ / "d.png").type(), CV_16UC1);
        EXPECT_EQ(readBack(studio_ / "d.png").size(), cv::Size(90, 120));
        EXPECT_EQ(readBack(studio_ / "r.png").size(), cv::Size(180, 120));
        EXPECT_TRUE(samePicture(readBack(studio_ / "r.png")(cv::Rect(0, 0, 90, 120)),
                                readBack(studio_ / "photo.png")));
    }
}

TEST_F(Photo2Native, ReadsStandardInputAndWritesStandardOutput) {
    const Arguments fixed = fixedWay("--embedded-depth off");
    ASSERT_TRUE(isDone(convert(fixed + Arguments("photo.png file.png"))));
    studio_.readInputFrom(studio_ / "photo.png");
    studio_.sendOutputTo(studio_ / "out.png");
    Outcome outcome = convert(fixed + Arguments("- -"));
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.err, "standard output: Native, 96 x 128 px")); // not in the picture
    EXPECT_EQ(slurp(studio_ / "out.png"), slurp(studio_ / "file.png"));
    outcome = convert("photo.png depth.png -"); // says on standard error what it does
    EXPECT_EQ(outcome.status, 2);
    EXPECT_TRUE(holds(outcome.err, "error: - stands for one picture"));
    studio_.readInputFrom("/dev/null");
    EXPECT_TRUE(fails(convert("- b.png"), 1, "standard input: "));
    studio_.sendOutputTo("/dev/full");
    EXPECT_EQ(convert("photo.png -").status, 1);
}

TEST_F(Photo2Native, MakesOnlyOtherOutputsIfNoNameFollowsThePhoto) {
    const Arguments depth("-d photo.png depth.png");
    ASSERT_TRUE(isDone(convert("--save-quilt with.png -d photo.png depth.png a.png")));
    fs::remove(studio_ / "a.png");
    const Outcome outcome = convert(Arguments("--save-quilt q.png --save-depth d.png --lg s.mp4 "
                                              "--seconds 0.2 --turns 1 --report r.json") +
                                    depth);
    ASSERT_TRUE(isDone(outcome));
    EXPECT_FALSE(holds(outcome.out, ": Native"));
    EXPECT_EQ(slurp(studio_ / "q_qs3x2a0.75.png"), slurp(studio_ / "with_qs3x2a0.75.png"));
    EXPECT_TRUE(fs::exists(studio_ / "d.png") && fs::exists(studio_ / "s.mp4"));
    EXPECT_FALSE(studio_.json("r.json")["pictures"][0].contains("native"));

    fs::create_directory(studio_ / "photos");
    fs::copy(studio_ / "photo.png", studio_ / "photos/p.png");
    EXPECT_TRUE(says(convert("--save-depth depths photos"), "p.png: depth"));
    EXPECT_EQ(names(studio_ / "depths"), std::vector<std::string>{"p_depth.png"});
    EXPECT_TRUE(
        says(convert("--skip-existing --save-depth depths photos"), "0 photos made, 1 skip"));

    // the display does not matter for a video
    EXPECT_TRUE(
        isDone(studio_.run(kTool, Arguments("--lg t.mp4 --seconds 0.2 --turns 1") + depth)));
    EXPECT_TRUE(fails(convert("--plan plan --save-depth d photos"), 2, "a folder for the Natives"));
}

TEST_F(Photo2Native, AReportTellsHowThePicturesEnded) {
    fs::create_directory(studio_ / "photos");
    fs::copy(studio_ / "photo.png", studio_ / "photos/a.png");
    spill(studio_ / "photos/b.png", "noise");
    const Outcome outcome = convert("--progress json --report r.json photos natives");
    EXPECT_EQ(outcome.status, 1);
    const Json report = studio_.json("r.json");
    EXPECT_EQ(report["state"], "failed");
    EXPECT_EQ(report["pictures"][1]["code"], "BadFormat");
    std::istringstream lines(outcome.out);
    std::vector<Json> progress;
    for (std::string line; std::getline(lines, line);)
        progress.push_back(Json::parse(line));
    ASSERT_EQ(progress.size(), 3);
    EXPECT_EQ(progress[1]["state"], "running");
    EXPECT_EQ(progress[1]["photos"], 1);
    EXPECT_EQ(progress[1]["photosInAll"], 2);
    EXPECT_EQ(progress[1]["share"], 0.5);
    EXPECT_EQ(progress[1]["input"], "photos/b.png");
    EXPECT_EQ(progress[2], Json({{"state", "failed"}, {"photos", 1}}));
}

// The first signal ends the run between two steps of a photo.
TEST_F(Photo2Native, ASignalEndsARunWithASummaryAndAReport) {
    fs::create_directory(studio_ / "photos");
    for (int i = 0; i < 200; ++i)
        fs::copy(studio_ / "photo.png", studio_ / ("photos/" + std::to_string(i) + ".png"));
    for (const auto& [signal, status] : {std::pair(SIGINT, 130), std::pair(SIGTERM, 143)}) {
        fs::remove_all(studio_ / "natives");
        const Outcome outcome =
            studio_.run(kTool, "-c small.json -y --report r.json photos natives", signal,
                        [&] { return fs::exists(studio_ / "natives/1_native.png"); });
        EXPECT_EQ(outcome.status, status) << outcome.text();
        EXPECT_TRUE(outcome.odd.empty());
        EXPECT_TRUE(holds(outcome.out, " not begun, in "));
        const Json report = studio_.json("r.json");
        EXPECT_EQ(report["state"], "stopped");
        EXPECT_EQ(report["pictures"].size(), names(studio_ / "natives").size());
    }
}

TEST_F(Photo2Native, PipesAreReadOnce) {
    studio_.makeMap();
    ASSERT_TRUE(isDone(run("-m a.map -c small.json -d photo.png depth.png a.png")));
    std::vector<std::thread> feeders;
    for (const char* name : {"a.map", "small.json", "photo.png", "depth.png"}) {
        fs::rename(studio_ / name, studio_ / ("given-" + std::string(name)));
        ASSERT_EQ(mkfifo((studio_ / name).c_str(), 0600), 0);
        feeders.emplace_back([this, name] {
            std::ofstream(studio_ / name, std::ios::binary)
                << slurp(studio_ / ("given-" + std::string(name)));
        });
    }
    const Outcome outcome = run("-m a.map -c small.json -d photo.png depth.png b.png");
    if (outcome.status != 0) { // lets the feeders end
        for (const char* name : {"a.map", "small.json", "photo.png", "depth.png"})
            ::close(::open((studio_ / name).c_str(), O_RDWR));
    }
    for (std::thread& feeder : feeders)
        feeder.join();
    ASSERT_TRUE(isDone(outcome));
    EXPECT_EQ(slurp(studio_ / "b.png"), slurp(studio_ / "a.png"));
}

TEST_F(Photo2Native, ASignalEndsWaitingForAPipe) {
    ASSERT_EQ(mkfifo((studio_ / "pipe.png").c_str(), 0600), 0);
    int writer = -1; // opens only while the tool waits
    const Outcome outcome = studio_.run(kTool, "-c small.json pipe.png a.png", SIGINT, [&] {
        writer = ::open((studio_ / "pipe.png").c_str(), O_WRONLY | O_NONBLOCK);
        if (writer >= 0) usleep(200000); // it reads now
        return writer >= 0;
    });
    ::close(writer);
    EXPECT_EQ(outcome.status, 130) << outcome.text();
}

TEST_F(Photo2Native, SavedDepthHasAtMost4096PxOrWhatIsAskedFor) {
    writeImage(studio_ / "wide.png", madePhoto(5000, 100));
    cv::Mat halves(2, 100, CV_8UC1, cv::Scalar(0)); // near at the right
    halves.colRange(50, 100) = 255;
    writeImage(studio_ / "halves.png", halves);
    const auto saved = [&](const Arguments& options) {
        EXPECT_TRUE(isDone(
            convert(options + Arguments("-y --fit contain --save-depth d.png "
                                        "--save-photo-with-depth p.jpg -d wide.png halves.png "
                                        "a.png"))));
        const cv::Mat depth = readBack(studio_ / "d.png");
        EXPECT_EQ(depth.at<ushort>(depth.rows / 2, depth.cols / 4), 0);
        EXPECT_EQ(depth.at<ushort>(depth.rows / 2, depth.cols * 3 / 4), 65535);
        EXPECT_EQ(readPhoto(studio_ / "p.jpg").size(), cv::Size(5000, 100));
        const cv::Mat embedded = readEmbeddedDepth(studio_ / "p.jpg").value().depth;
        EXPECT_EQ(embedded.size(), depth.size());
        EXPECT_LT(embedded.at<float>(depth.rows / 2, depth.cols / 4), 0.1F);
        EXPECT_GT(embedded.at<float>(depth.rows / 2, depth.cols * 3 / 4), 0.9F);
        return depth.size();
    };
    EXPECT_EQ(saved({}), cv::Size(4096, 82));
    EXPECT_EQ(saved("--save-depth-size 500"), cv::Size(500, 10));
    EXPECT_EQ(saved("--save-depth-size 65500"), cv::Size(5000, 100));
}

TEST_F(Photo2Native, FormatsThatKeepLessThanDepthHasAreWarnedOf) { // all: Words
    EXPECT_TRUE(warns(convert("--save-depth d.jpg -d photo.png depth.png a.png"),
                      "d.jpg: this format changes depth"));
    EXPECT_TRUE(fs::exists(studio_ / "d.jpg"));
}

TEST_F(Photo2Native, VerboseTellsWhatTheRunNeeded) {
    const Outcome outcome =
        convert("-v --report r.json --save-quilt q.png -d photo.png depth.png a.png");
    ASSERT_TRUE(isDone(outcome));
    for (const char* part : {"ready: start ", "display ", "read ", ", save ", "peak memory "})
        EXPECT_TRUE(holds(outcome.out, part));
    const Json report = studio_.json("r.json");
    for (const char* stage : {"start", "plan", "display"})
        EXPECT_GT(report.at("setupMilliseconds").at(stage).get<double>(), 0) << stage;
    EXPECT_GT(report.at("peakMegabytes").get<double>(), 1); // the program alone is larger
    EXPECT_GT(report.at("pictures").at(0).at("milliseconds").at("save").get<double>(), 0);
}

TEST_F(Photo2Native, OfABrokenPhotoAndABrokenDepthThePhotoIsNamed) {
    for (const char* file : {"photo.png", "depth.png"})
        spill(studio_ / file, "broken");
    for (const char* named : {"photo.png", "depth.png"}) {
        for (const char* threads : {"1", "2"})
            EXPECT_TRUE(
                fails(convert({"-j", threads, "-d", "photo.png", "depth.png", "a.png"}), 1, named));
        writeImage(studio_ / "photo.png", madePhoto(90, 120));
    }
    EXPECT_FALSE(fs::exists(studio_ / "a.png"));
}

namespace {

std::string textOf(const Json& value) {
    return value.is_string() ? value.get<std::string>() : value.dump();
}

// The call that a report describes, without the names of photo, depth and output.
Arguments callOf(const Json& settings) {
    const Json& quilt = settings.at("quilt");
    Arguments call{"-c", textOf(settings.at("display").at("files").at(0)),
                   "-q", textOf(quilt.at("rows")) + "x" + textOf(quilt.at("columns")),
                   "-r", textOf(quilt.at("viewHeight")) + "x" + textOf(quilt.at("viewWidth"))};
    const std::pair<const char*, const char*> options[] = {{"--method", "method"},
                                                           {"--strength", "strengthPercent"},
                                                           {"--focus", "focus"},
                                                           {"--fit", "fit"},
                                                           {"--depth-kind", "depthKind"},
                                                           {"--invert", "invert"},
                                                           {"--view-filter", "viewFilter"},
                                                           {"--sampling", "sampling"}};
    for (const auto& [option, key] : options) {
        if (!settings.at(key).is_null()) call = call + Arguments{option, textOf(settings.at(key))};
    }
    for (const auto& [knob, value] : settings.at("knobs").items()) {
        if (!value.is_null()) call = call + Arguments{"--" + knob, textOf(value)};
    }
    if (settings.at("detail") == "panel") call.emplace_back("-k");
    if (settings.at("continuous").get<bool>()) call.emplace_back("--continuous");
    return call;
}

} // namespace

TEST_F(Photo2Native, TheReportIsEnoughToMakeThePictureAgain) {
    fs::rename(studio_ / "small.json", studio_ / "visual.json"); // found, not given
    spill(studio_ / "camera.json", R"({"fx": 80, "fy": 80, "cx": 44.5, "cy": 59.5, "zNear": 1,
                                      "zFar": 10, "baseline": 0.2})");
    struct Case {
        const char* method;
        Arguments arguments;
    };
    const Arguments strength("--strength 17.3");
    const Case cases[] = {{"layered", strength},
                          {"layered", strength + Arguments("--fill continue")},
                          {"fast", strength + Arguments("--method fast")},
                          {"fast", strength + Arguments("--method fast --refine 3")},
                          {"real", strength + Arguments{"-g"}},
                          {"real", strength + Arguments("--method real --inpaint-from behind")},
                          {"real", {"-g", "--camera", "camera.json"}}};
    std::set<std::string> natives;
    for (const auto& [method, arguments] : cases) {
        const Outcome first =
            run(arguments +
                Arguments(
                    "-y -q 2x3 -r 40x30 --focus 0.31 -k --fit contain --invert off --report r.json "
                    "-d --depth-kind far-white --view-filter linear photo.png depth.png a.png"));
        ASSERT_TRUE(isDone(first));
        const Json report = studio_.json("r.json");
        const Json& settings = report.at("settings");
        const Json& picture = report.at("pictures").at(0);
        ASSERT_TRUE(settings.at("depthImages").get<bool>());
        ASSERT_TRUE(isDone(
            run(callOf(settings) + Arguments{"-y", "-d", textOf(picture.at("photo")),
                                             textOf(picture.at("depthImage")), "again.png"})));
        const std::string native = slurp(studio_ / textOf(picture.at("native")));
        EXPECT_EQ(slurp(studio_ / "again.png"), native) << first.call;
        EXPECT_TRUE(natives.insert(native).second) << "a knob does nothing: " << first.call;

        EXPECT_EQ(report.at("tool"), kTool);
        EXPECT_EQ(settings.at("method"), method);
        // a camera takes the place of the strength: 2 80 0.2 (1/1 - 1/10) = 28.8 px of 90
        const bool camera = arguments.back() == "camera.json";
        EXPECT_EQ(settings.at("strengthPercent").is_null(), camera);
        EXPECT_NEAR(picture.at("strengthPercent").get<double>(), camera ? 32 : 17.3,
                    kReportPrecision);
        EXPECT_TRUE(settings.at("network").is_null());
        EXPECT_TRUE(settings.at("rgbdSide").is_null());
        EXPECT_EQ(settings.at("display").at("serial"), "TEST-1");
        EXPECT_TRUE(report.at("warnings").empty());
        EXPECT_EQ(picture.at("photoWidth"), 90);
        for (const char* stage : {"read", "depth", "fit", "views", "native", "write"})
            EXPECT_GT(picture.at("milliseconds").at(stage).get<double>(), 0) << stage;
    }
}

TEST_F(Photo2Native, NamesInTheWrongOrderLoseNoPhoto) {
    ASSERT_TRUE(isDone(convert("photo.png out.png")));
    const std::string photo = slurp(studio_ / "photo.png");
    const std::string wrong = "out.png: is a Native already, expected a photo";
    EXPECT_TRUE(fails(convert("-y out.png photo.png"), 1, wrong));
    EXPECT_EQ(slurp(studio_ / "photo.png"), photo);
    const std::string depth = slurp(studio_ / "depth.png");
    for (const Arguments& names : {Arguments("out.png depth.png photo.png"),
                                   {"depth.png", "out.png", "photo.png"},
                                   {"out.png", "photo.png", "depth.png"},
                                   {"photo.png", "out.png", "depth.png"}}) {
        EXPECT_TRUE(fails(convert(Arguments("-d -y") + names), 1, "out.png: is a Native already"));
    }
    EXPECT_EQ(slurp(studio_ / "photo.png"), photo);
    EXPECT_EQ(slurp(studio_ / "depth.png"), depth);
    EXPECT_TRUE(fails(studio_.run("quilt2native", "-c small.json out.png b.png"), 1,
                      "out.png: is a Native already, expected a quilt"));
    // photo and depth
    EXPECT_TRUE(warns(convert("-d depth.png photo.png c.png"),
                      "photo.png: has colours, and depth has none"));
}

TEST_F(Photo2Native, ErrorsSuggestWhatWasMeant) { // wrong usage: Jobs
    studio_.makeMap();
    EXPECT_TRUE(fails(run("-c a.map photo.png o.png"), 1,
                      "a.map: is a look-up table, expected a display's visual.json"));
    EXPECT_FALSE(holds(run("--quite-another photo.png o.png").err, "did you mean"));
    EXPECT_FALSE(fs::exists(studio_ / "o.png"));
    EXPECT_TRUE(warns(convert("--strength 0.1 photo.png o.png"), "--strength is in %"));
}

TEST_F(Photo2Native, ACalibrationIsFoundInItsVolume) {
    fs::create_directories(studio_ / "LKG/LKG_calibration");
    fs::rename(studio_ / "small.json", studio_ / "LKG/LKG_calibration/visual.json");
    const Arguments rest("-q 2x3 -r 40x30 photo.png");
    EXPECT_TRUE(isDone(run(Arguments("-c LKG") + rest + Arguments{"a.png"})));
    EXPECT_TRUE(isDone(run(Arguments("-c LKG/LKG_calibration") + rest + Arguments{"b.png"})));
    EXPECT_EQ(slurp(studio_ / "a.png"), slurp(studio_ / "b.png"));
    EXPECT_TRUE(fails(run(Arguments("-c .") + rest + Arguments{"c.png"}), 1, "is a directory"));
    // and it is an input, which nothing replaces
    const std::string inside = "LKG/LKG_calibration/visual.json";
    EXPECT_TRUE(
        fails(run(Arguments{"-c", "LKG", "--report", inside, "-y"} + rest + Arguments{"c.png"}), 2,
              "is also an input"));
    EXPECT_TRUE(
        fails(studio_.run("altiro3Dnative", {"-y", "-m", inside, "LKG"}), 2, "is also an input"));
}

TEST_F(Photo2Native, AQuiltsNameIsAskedAbout) {
    fs::copy(studio_ / "photo.png", studio_ / "photo_qs3x2a0.75.png");
    fs::copy(studio_ / "photo.png", studio_ / "photo_qs0x2.png"); // no quilt's name
    EXPECT_TRUE(warns(
        convert("photo_qs3x2a0.75.png a.png"),
        "its name says that it is a quilt, but it is read as one picture of a scene; for a quilt "
        "use quilt2native"));
    EXPECT_TRUE(isDone(convert("photo_qs0x2.png b.png")));
}

TEST_F(Photo2Native, NativesAmongThePhotosOfADirectoryAreLeftOut) {
    fs::create_directory(studio_ / "photos");
    writeImage(studio_ / "photos/a.png", madePhoto(40, 50));
    const Arguments again = studio_.display() + Arguments("-y photos photos");
    ASSERT_TRUE(isDone(run(again)));
    const Outcome outcome = run(again);
    EXPECT_TRUE(
        warns(outcome, "photos/a_native.png: is a Native, which is finished; it is left out"));
    EXPECT_TRUE(holds(outcome.out, "1 photo made, 1 left out (1 Native), in "));
    EXPECT_EQ(names(studio_ / "photos"), (std::vector<std::string>{"a.png", "a_native.png"}));
    fs::remove(studio_ / "photos/a.png");
    EXPECT_TRUE(fails(run(again), 1, "photos: holds no pictures"));
}

TEST_F(Photo2Native, OneBadPhotoDoesNotStopTheRest) {
    fs::create_directory(studio_ / "photos");
    for (const char* name : {"photos/a.png", "photos/c.png", "photos/d.png"})
        writeImage(studio_ / name, madePhoto(40, 50));
    spill(studio_ / "photos/b.png", "broken");
    spill(studio_ / "photos/notes.txt", "not a picture");
    fs::create_directory(studio_ / "photos/deeper");
    const Outcome outcome = convert("--report r.json --save-quilt q --save-views v photos out");
    EXPECT_TRUE(fails(outcome, 1, "photos/b.png"));
    EXPECT_TRUE(
        holds(outcome.out, "\n3 photos made, 1 failed, 2 left out (1 .txt file, 1 folder), in "));
    EXPECT_TRUE(holds(outcome.out, "\nc.png: out/c_native.png: "));
    EXPECT_EQ(names(studio_ / "out"),
              (std::vector<std::string>{"a_native.png", "c_native.png", "d_native.png"}));
    EXPECT_EQ(names(studio_ / "q").size(), 3U);
    EXPECT_EQ(names(studio_ / "v/c_views").size(), 6U);
    const Json pictures = studio_.json("r.json").at("pictures");
    ASSERT_EQ(pictures.size(), 4U);
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_EQ(pictures[i].contains("error"), i == 1) << i;

    // alone it is the same Native
    ASSERT_TRUE(isDone(convert("photos/c.png c.png")));
    EXPECT_EQ(slurp(studio_ / "c.png"), slurp(studio_ / "out/c_native.png"));
}

TEST_F(Photo2Native, PhotosOfOneNameInSubfoldersHaveTheirOwnDepth) {
    const cv::Mat depth = readBack(studio_ / "depth.png");
    cv::Mat turned;
    cv::flip(depth, turned, 0);
    for (const char* folder : {"in/100", "in/101", "depths/100", "depths/101"})
        fs::create_directories(studio_ / folder);
    for (const char* name : {"in/100/a.png", "in/101/a.png"})
        fs::copy(studio_ / "photo.png", studio_ / name);
    writeImage(studio_ / "depths/100/a.png", depth);
    writeImage(studio_ / "depths/101/a.png", turned);
    const Arguments usual = studio_.display() + Arguments{"-d"};
    EXPECT_EQ(run(usual + Arguments("--recursive in depths out")).status, 0);
    for (const char* folder : {"100", "101"}) {
        const std::string name = std::string(folder) + "/a";
        EXPECT_EQ(run(usual + Arguments{"in/" + name + ".png", "depths/" + name + ".png",
                                        "alone.png", "-y"})
                      .status,
                  0);
        EXPECT_EQ(slurp(studio_ / ("out/" + name + "_native.png")), slurp(studio_ / "alone.png"));
    }
    EXPECT_NE(slurp(studio_ / "out/100/a_native.png"), slurp(studio_ / "out/101/a_native.png"));
    fs::remove(studio_ / "depths/101/a.png");
    EXPECT_TRUE(
        fails(run(usual + Arguments("--recursive in depths out -y")), 1, "depths/101/a.png"));
}

TEST_F(Photo2Native, OnlyGivenDepthIsSaidToBeExchanged) {
    const Eyes eyes = ceiling();
    writeImage(studio_ / "l.jpg", eyes.left);
    writeImage(studio_ / "r.jpg", eyes.right);
    spill(studio_ / "p.mpo", mpoFile(slurp(studio_ / "l.jpg"), slurp(studio_ / "r.jpg")));
    cv::Mat depth(eyesSize(), CV_32FC1);
    for (int y = 0; y < depth.rows; ++y)
        depth.row(y) = 1 - static_cast<float>(y) / static_cast<float>(depth.rows);
    writePhotoWithDepth(studio_ / "e.jpg", eyes.left, depth);
    fs::create_directory(studio_ / "in");
    fs::copy(studio_ / "l.jpg", studio_ / "in/l.jpg");
    depth.convertTo(depth, CV_8U, 255);
    writeImage(studio_ / "in/l-depth.png", depth);
    const auto run = [&](const Arguments& call) {
        const Arguments strength("-y --strength 1 --report r.json");
        return convert(strength + call);
    };
    const auto depthSource = [&] {
        const Json report = studio_.json("r.json");
        return report.at("pictures").at(0).at("depthSource").get<std::string>();
    };
    const std::string exchanged =
        ": near and far look exchanged; if near things look far, photo2native ";
    const std::string automatic = "-d with --depth-kind far-white turns it round, and "
                                  "--embedded-depth off leaves it out";
    EXPECT_TRUE(isDone(run("p.mpo a.png")));
    EXPECT_EQ(depthSource().find("stereo pair (MPO)"), 0U) << depthSource();
    EXPECT_TRUE(isDone(run("--stereo files l.jpg r.jpg a.png")));
    EXPECT_TRUE(warns(run("e.jpg a.png"), "e.jpg" + exchanged + automatic));
    EXPECT_TRUE(warns(run("-d l.jpg in/l-depth.png a.png"),
                      "in/l-depth.png" + exchanged + "--depth-kind far-white turns it round"));
    EXPECT_TRUE(warns(run("in out"), "in/l-depth.png" + exchanged + automatic));
    EXPECT_EQ(depthSource(), "depth image beside the photo (in/l-depth.png)");
}

TEST_F(Photo2Native, DepthImagesBesideThePhotosOfAFolderAreCheckedAndCanBeRefused) {
    fs::create_directory(studio_ / "in");
    writeImage(studio_ / "in/a.png", scenery({60, 80}, 3));
    const auto sourceOf = [&](const Arguments& more) {
        EXPECT_TRUE(isDone(convert(more + Arguments("-y --report r.json in out"))));
        const Json picture = studio_.json("r.json").at("pictures").at(0);
        auto source = picture.at("depthSource").get<std::string>();
        EXPECT_EQ(picture.contains("depthImage"), source.find("beside") != std::string::npos);
        return source;
    };
    writeImage(studio_ / "in/a-depth.png", cv::Mat(40, 30, CV_8UC1, cv::Scalar(9)));
    const Outcome flat = convert("in out");
    EXPECT_TRUE(warns(flat, "in/a-depth.png: is not used as depth: it is flat"));
    EXPECT_FALSE(holds(flat.out, "depth of a-depth.png"));
    fs::copy(studio_ / "depth.png", studio_ / "in/a-depth.png",
             fs::copy_options::overwrite_existing);
    EXPECT_EQ(sourceOf({}), "depth image beside the photo (in/a-depth.png)");
    for (const Arguments& other : {Arguments("-n tiny"), Arguments("--embedded-depth off")})
        EXPECT_EQ(sourceOf(other).rfind("network tiny (", 0), 0U);
    // in a folder of depth images they may be named as beside a photo
    fs::create_directory(studio_ / "depths");
    fs::rename(studio_ / "in/a-depth.png", studio_ / "depths/a_depth.png");
    EXPECT_TRUE(says(convert("-d in depths apart"), "depth of a_depth.png"));
}

TEST_F(Photo2Native, PicturesOfTwoFoldersMayHaveTheSameNamesInOtherLetters) {
    const cv::Mat depth = readBack(studio_ / "depth.png");
    for (const char* folder : {"in/trip", "depths/TRIP"})
        fs::create_directories(studio_ / folder);
    for (const char* name : {u8"in/Caf\u00e9.jpg", "in/IMG_1.JPG", "in/Once.jpg", "in/Twice.jpg",
                             "in/a.jpg", "in/A.JPG", "in/trip/B.jpg"})
        writeImage(studio_ / name, scenery({60, 80}, 3));
    for (const char* name :
         {u8"depths/Cafe\u0301.png", "depths/img_1.png", "depths/Once.png", "depths/once.png",
          "depths/TWICE.png", "depths/twice.png", "depths/A.png", "depths/TRIP/b-Depth.PNG"})
        writeImage(studio_ / name, depth);
    const Outcome outcome = convert("--recursive -d in depths out");
    EXPECT_EQ(outcome.status, 1);
    for (const char* line :
         {u8": Native, 96 x 128 px; depth of Cafe\u0301.png", "; depth of img_1.png",
          "; depth of Once.png", "; depth of TWICE.png", "; depth of b-Depth.PNG",
          "\nA.JPG: out/A_native.png: Native, 96 x 128 px; depth of A.png"})
        EXPECT_TRUE(holds(outcome.out, line)) << line;
    for (const char* line :
         {"depths/once.png: is not used, as Once.png is used",
          "depths/twice.png: is not used, as TWICE.png is used", "depths/a.jpg: does not exist"})
        EXPECT_TRUE(holds(outcome.err, line)) << line;

    fs::remove(studio_ / "depths/A.png");
    writeImage(studio_ / "depths/a-DEPTH.png", depth);
    EXPECT_TRUE(holds(convert("-d in depths two").out, "depth of a-DEPTH.png"));
    fs::rename(studio_ / "depths/a-DEPTH.png", studio_ / "depths/a-DEPTH.jpg");
    fs::copy(studio_ / "in/a.jpg", studio_ / "in/Img_1.jpg");
    const Outcome either = convert("-d in depths three");
    EXPECT_TRUE(holds(either.err, "depths/img_1.png: is not used, as IMG_1.JPG and Img_1.jpg"));
    fs::rename(studio_ / "depths/img_1.png", studio_ / "in/img_1-depth.png");
    for (const auto& [from, to] : {std::pair("depths/a-DEPTH.jpg", "in/A-depth.png"),
                                   {u8"depths/Cafe\u0301.png", u8"in/Cafe\u0301-DEPTH.PNG"}})
        fs::copy(studio_ / from, studio_ / to);
    // depth images beside the photos
    const Outcome beside = convert("in four");
    EXPECT_TRUE(holds(beside.out, "in/img_1-depth.png: is a depth image by its name, but IMG_1.JPG "
                                  "and Img_1.jpg could take it"));
    for (const char* line :
         {u8"; depth of Cafe\u0301-DEPTH.PNG",
          "\nA.JPG: four/A_native.png: Native, 96 x 128 px; depth of A-depth.png"})
        EXPECT_TRUE(holds(beside.out, line));
    EXPECT_FALSE(holds(beside.out, "\na.jpg: four/a_native.png: Native, 96 x 128 px; depth of A-"));
    EXPECT_TRUE(says(convert({u8"in/Caf\u00e9.jpg", "alone.png"}),
                     u8"depth image beside the photo (in/Cafe\u0301-DEPTH.PNG)"));
}

TEST_F(Photo2Native, FoldersOfSystemsAreCountedAndNotSearched) {
    const std::vector<std::string> folders = {
        "@eaDir",   ".thumbnails", ".AppleDouble", "$RECYCLE.BIN", "System Volume Information",
        "__MACOSX", ".Trash-1000", "lost+found",   "trip"};
    for (const std::string& folder : folders) {
        fs::create_directories(studio_ / "in" / folder);
        writeImage(studio_ / "in" / folder / "a.png", scenery({60, 80}, 3));
    }
    const Outcome outcome = convert("--recursive in out");
    EXPECT_TRUE(isDone(outcome));
    EXPECT_TRUE(holds(outcome.out, "\n1 photo made, 8 left out (8 system folders), in "));
    EXPECT_TRUE(holds(outcome.out, "\nin/@eaDir: is a folder of the system by its name "));
    EXPECT_EQ(names(studio_ / "out/trip"), std::vector<std::string>{"a_native.png"});
    EXPECT_TRUE(isDone(convert("in/@eaDir named"))); // a folder that is named is wanted
}

TEST_F(Photo2Native, NothingInAFolderIsLostSilently) {
    fs::create_directories(studio_ / "in/trip");
    const cv::Mat photo = scenery({60, 80}, 3);
    for (const char* name :
         {"in/a.png", "in/b.jpg", "in/trip/a.png", "in/q_qs3x2a0.75.png", "in/lone_depth.png"})
        writeImage(studio_ / name, photo);
    for (const char* name : {"in/a-depth.png", "in/a_disparity.png", "in/z.png"})
        fs::copy(studio_ / "depth.png", studio_ / name);
    cv::Mat web; // a quilt whose name does not say it
    Depth2Quilt({4, 5, {140, 100}, 20})
        .render({scenery({140, 100}, 3), randomDepth({140, 100})}, web);
    writeImage(studio_ / "in/web.png", web);
    for (const char* name : {"in/b.MOV", "in/c.mp4", "in/d.xyz", "in/e.xyz", "in/.hidden",
                             "in/r.CR3", "in/s.nef", "in/README"})
        spill(studio_ / name, "not a picture");
    fs::copy(studio_ / "in/b.jpg", studio_ / "in/IMG_0001"); // pictures need no extension
    const Outcome outcome = convert("in out");
    EXPECT_TRUE(isDone(outcome));
    EXPECT_EQ(names(studio_ / "out"),
              (std::vector<std::string>{"a_native.png", "b_native.png", "IMG_0001_native.png"}));
    for (const char* line :
         {"s.nef: is a raw picture of a camera, which is not read; export it",
          "\na.png: out/a_native.png: Native, 96 x 128 px; depth of a-depth.png",
          "\nin/a_disparity.png: is a depth image by its name, but a-depth.png is used\n",
          "\nin/b.MOV: is the clip of the Live Photo b.jpg\n",
          "\nin/c.mp4: is a video; video2native makes Natives of videos\n",
          "\nin/d.xyz: is no picture or video of a format that can be read\n",
          "\nin/lone_depth.png: is a depth image by its name, but its photo is missing\n",
          "\nin/q_qs3x2a0.75.png: is a quilt by its name",
          "\nin/trip: is a folder; --recursive also converts what it holds\n",
          "\nz.png: looks like a depth image, as it is grey and smooth; a photo is converted if",
          "\nweb.png: is a quilt of 4 columns x 5 rows; quilt2native"})
        EXPECT_TRUE(holds(outcome.out, line));
    EXPECT_TRUE(holds(outcome.out,
                      "\n3 photos made, 13 left out (1 Live Photo clip, 1 video, 2 .xyz files, 2 "
                      "quilts, 2 raw pictures, 1 other file, 3 depth images, 1 folder), in "));
    EXPECT_FALSE(holds(outcome.out, "hidden"));
    // the depth is the one that -d gives
    ASSERT_TRUE(isDone(convert("-d in/a.png in/a-depth.png d.png")));
    EXPECT_EQ(slurp(studio_ / "d.png"), slurp(studio_ / "out/a_native.png"));
    // a photo alone is made with it as well
    const Outcome alone = convert("in/a.png alone.png");
    EXPECT_TRUE(says(alone, "depth image beside the photo (in/a-depth.png)"));
    EXPECT_EQ(slurp(studio_ / "alone.png"), slurp(studio_ / "d.png"));

    EXPECT_TRUE(isDone(convert("--recursive --skip-existing in in/trip/out")));
    EXPECT_EQ(names(studio_ / "in/trip/out/trip"), (std::vector<std::string>{"a_native.png"}));
    // what is written there is not read again
    EXPECT_TRUE(holds(convert("--recursive --skip-existing in in/trip/out").out,
                      "\n0 photos made, 4 skipped as the outputs exist, "));
}

TEST_F(Photo2Native, APhotoSavedWithDepthIsAPhotoUnlessItsOriginalIsThere) {
    fs::create_directory(studio_ / "in");
    writeImage(studio_ / "in/a.png", scenery({60, 80}, 3));
    fs::copy(studio_ / "depth.png", studio_ / "in/a-depth.png");
    const auto make = [&](const Arguments& options) {
        const Outcome outcome = convert(options + Arguments("-y in out"));
        EXPECT_TRUE(isDone(outcome));
        return outcome.out;
    };
    make("--save-photo-with-depth in"); // in/a_with_depth.jpg
    const std::string both = make({});
    EXPECT_TRUE(holds(both,
                      "\nin/a_with_depth.jpg: is a photo that was saved with its depth: a.png is "
                      "taken\n"));
    EXPECT_EQ(names(studio_ / "out"), (std::vector<std::string>{"a_native.png"}));
    fs::remove(studio_ / "in/a.png");
    EXPECT_TRUE(holds(make({}), "\na_with_depth.jpg: out/a_with_depth_native.png: Native"));
}

class SkipExisting : public SmallStudio {
  public:
    SkipExisting() {
        fs::create_directory(*this / "in");
        for (const char* name : {"in/a.png", "in/b.png", "in/c.png"})
            writeImage(*this / name, madePhoto(40, 50));
    }
    Outcome make(const Arguments& more) const {
        return run(kTool, more + display() +
                              Arguments("--save-quilt q --save-views v --report r.json in out"));
    }
    // All outputs of photos, by name.
    std::map<std::string, std::string> contents() const {
        return contentsBelow(*this, {"out", "q", "v"});
    }
};

TEST_F(Photo2Native, SkipExistingCompletesAnInterruptedRun) {
    const SkipExisting studio;
    EXPECT_TRUE(says(studio.make("--skip-existing"), "\n3 photos made, in "));
    const auto whole = studio.contents();
    ASSERT_EQ(whole.size(), 3 * 8U);

    for (const char* directory : {"out", "q", "v"})
        fs::remove_all(studio / directory);
    const Arguments call = studio.display() + Arguments("--save-quilt q --save-views v in out");
    studio.run(kTool, call, SIGKILL, [&] { return fs::exists(studio / "out/a_native.png"); });
    EXPECT_TRUE(isDone(studio.make("--skip-existing")));
    EXPECT_EQ(studio.contents(), whole);

    fs::remove(studio / "out/c_native.png"); // as if it had been stopped during the last one
    const auto before = fs::last_write_time(studio / "out/a_native.png");
    const Outcome second = studio.make("--skip-existing");
    EXPECT_TRUE(says(second, "\n1 photo made, 2 skipped as the outputs exist, in "));
    EXPECT_FALSE(holds(second.out, "a.png"));
    EXPECT_EQ(studio.contents(), whole);
    EXPECT_EQ(fs::last_write_time(studio / "out/a_native.png"), before);
    const Json pictures = studio.json("r.json").at("pictures");
    ASSERT_EQ(pictures.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(pictures[i].contains("skipped"), i < 2) << i;

    EXPECT_TRUE(says(studio.make("--skip-existing"), "\n0 photos made, 3 skipped"));
}

// If any output of a photo is missing or empty, all of them are made.
TEST_F(Photo2Native, SkipExistingMakesPartlyPresentSetsAnewAndCountsFailures) {
    const SkipExisting studio;
    ASSERT_TRUE(isDone(studio.make({})));
    const auto whole = studio.contents();
    fs::remove(studio / "q/a_qs3x2a0.75.png");
    spill(studio / "v/b_views/view_3.png", "");
    spill(studio / "out/b_native.png", "of another run");
    EXPECT_TRUE(says(studio.make("--skip-existing"), "\n2 photos made, 1 skipped"));
    EXPECT_EQ(studio.contents(), whole);

    fs::remove(studio / "out/a_native.png");
    fs::remove(studio / "out/b_native.png");
    spill(studio / "in/b.png", "broken");
    const Outcome outcome = studio.make("--skip-existing");
    EXPECT_TRUE(fails(outcome, 1, "in/b.png"));
    EXPECT_TRUE(
        holds(outcome.out, "\n1 photo made, 1 skipped as the outputs exist, 1 failed, in "));

    // and of a single photo
    const Arguments one = studio.display() + Arguments("--skip-existing photo.png a.png");
    EXPECT_TRUE(isDone(studio.run(kTool, one)));
    const std::string native = slurp(studio / "a.png");
    EXPECT_TRUE(says(studio.run(kTool, one), "photo.png: skipped, as a.png exists\n"));
    EXPECT_EQ(slurp(studio / "a.png"), native);
}

TEST_F(Photo2Native, WarningsOfTheDisplaySurviveABadFirstPhoto) {
    writeCalibration(studio_ / "odd.json", {96, 128}, 52.58, "LKG-PORT-1"); // no Portrait's panel
    spill(studio_ / "a.png", "broken");
    const Outcome outcome = run("-c odd.json -q 2x3 -r 40x30 a.png photo.png out");
    EXPECT_EQ(outcome.status, 1);
    EXPECT_EQ(outcome.errLines().size(), 2U) << outcome.text();
    EXPECT_TRUE(holds(outcome.err, "warning: serial number LKG-PORT-1"));
}

TEST_F(Photo2Native, DepthOfAnotherShapeIsStretchedWithAWarning) {
    writeImage(studio_ / "photo.png", madePhoto(160, 90));
    const Outcome outcome = run(studio_.goodCall(kTool, "a.png"));
    EXPECT_TRUE(warns(outcome, "depth.png: its shape differs"));
    EXPECT_TRUE(holds(outcome.out, "fit: 58 % of the width is cut off")); // other shapes: Words
}

TEST_F(Photo2Native, TheAspectOfTheQuiltsNameCounts) {
    const Arguments call = studio_.display() + Arguments("-d photo.png depth.png a.png");
    EXPECT_TRUE(isDone(run(Arguments("--save-quilt q_qs3x2a1.5.png --report r.json") + call)));
    EXPECT_TRUE(fs::exists(studio_ / "q_qs3x2a1.5.png"));
    const Json report = studio_.json("r.json");
    EXPECT_EQ(report.at("pictures").at(0).at("quiltAspect"), 1.5);
    EXPECT_EQ(report.at("pictures").at(0).at("aspect"), 0.75);
    const std::string native = slurp(studio_ / "a.png"); // keeps the panel's shape
    EXPECT_TRUE(isDone(run(Arguments{"-y"} + call)));
    EXPECT_EQ(slurp(studio_ / "a.png"), native);
}

TEST_F(Photo2Native, DepthInThePhotoIsUsedAndSaid) {
    const cv::Mat photo = madePhoto(80, 60);
    cv::Mat depth;
    madeDepth(80, 60).convertTo(depth, CV_32F, 1 / 65535.0);
    writePhotoWithDepth(studio_ / "p.jpg", photo, depth);
    const Outcome used = convert("--report r.json p.jpg a.png");
    EXPECT_TRUE(isDone(used));
    const std::string line = "depth in the photo's file (Dynamic Depth, 80 x 60 px)";
    EXPECT_TRUE(holds(used.out, "p.jpg: " + line));
    EXPECT_EQ(studio_.json("r.json").at("pictures").at(0).at("depthSource"), line);

    // the same numbers as a depth image give the same picture
    cv::Mat eightBits;
    readEmbeddedDepth(studio_ / "p.jpg")->depth.convertTo(eightBits, CV_8U, 255);
    writeImage(studio_ / "d.png", eightBits);
    EXPECT_TRUE(isDone(convert("-d p.jpg d.png given.png")));
    EXPECT_EQ(slurp(studio_ / "a.png"), slurp(studio_ / "given.png"));
}

namespace {

// Mean brightness of the thing and of the wall at its right in a depth image of wallAndThing().
std::pair<double, double> nearAndFar(const fs::path& file) {
    const cv::Mat depth = readDepthImage(file);
    const cv::Rect thing = thingInLeft();
    return {cv::mean(depth(cv::Rect(thing.x + 20, thing.y + 20, 80, 70)))[0],
            cv::mean(depth(cv::Rect(thing.x + thing.width + 20, thing.y, 80, 100)))[0]};
}

} // namespace

TEST_F(Photo2Native, APairInOnePictureBecomesDepthByMatching) {
    const Eyes eyes = wallAndThing(-6, 14);
    writeImage(studio_ / "l.png", eyes.left);
    writeImage(studio_ / "r.png", eyes.right);
    cv::Mat both;
    cv::hconcat(eyes.left, eyes.right, both);
    writeImage(studio_ / "both.png", both);
    const Outcome beside =
        convert("--stereo left-right --report r.json --save-depth d.png both.png a.png");
    EXPECT_TRUE(isDone(beside));
    const std::string line = "stereo pair (left and right half), depth by matching; shift -1.5 %";
    EXPECT_TRUE(holds(beside.out, "both.png: " + line));
    const Json report = studio_.json("r.json");
    EXPECT_EQ(report.at("settings").at("stereo"), "left-right");
    EXPECT_EQ(report.at("pictures").at(0).at("depthSource").get<std::string>().find(line), 0u);
    EXPECT_EQ(report.at("pictures").at(0).at("photoWidth"), eyes.left.cols);
    const auto [near, far] = nearAndFar(studio_ / "d.png");
    EXPECT_GT(near, 60000);
    EXPECT_LT(far, 6000);

    // in every other form the same pair gives the same picture
    cv::hconcat(eyes.right, eyes.left, both);
    writeImage(studio_ / "crossed.png", both);
    cv::vconcat(eyes.left, eyes.right, both);
    writeImage(studio_ / "stacked.png", both);
    for (const Arguments& other : {Arguments("--stereo right-left crossed.png"),
                                   Arguments("--stereo top-bottom:full stacked.png"),
                                   Arguments("--stereo files l.png r.png")}) {
        EXPECT_TRUE(isDone(convert(Arguments{"-y"} + other + Arguments{"b.png"})));
        EXPECT_EQ(slurp(studio_ / "b.png"), slurp(studio_ / "a.png")) << other[1];
    }
}

TEST_F(Photo2Native, FilesThatSayHowTheyHoldBothEyesArePairsByThemselves) { // all: ReadStereoPair
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat both;
    cv::hconcat(eyes.left, eyes.right, both);
    writeImage(studio_ / "both.jpg", both);
    cv::hconcat(eyes.right, eyes.left, both);
    writeImage(studio_ / "crossed.jpg", both);
    writeImage(studio_ / "l.jpg", eyes.left);
    writeImage(studio_ / "r.jpg", eyes.right);
    fs::create_directory(studio_ / "photos");
    spill(studio_ / "photos/p.mpo", mpoFile(slurp(studio_ / "l.jpg"), slurp(studio_ / "r.jpg")));
    fs::copy(studio_ / "crossed.jpg", studio_ / "photos/a.jps"); // the usual order
    spill(studio_ / "photos/d.jpg", withSegments(slurp(studio_ / "both.jpg"), jpsSegment(2, 4)));
    EXPECT_TRUE(isDone(convert("photos out")));
    const Outcome mpo = convert("-y --save-depth d.png photos/p.mpo one.png");
    EXPECT_TRUE(says(mpo, "p.mpo: stereo pair (MPO), depth by matching; shift "));
    EXPECT_EQ(slurp(studio_ / "out/p_native.png"), slurp(studio_ / "one.png"));
    const auto [near, far] = nearAndFar(studio_ / "d.png");
    EXPECT_GT(near, far + 50000);
    for (const Arguments& other : {Arguments("--embedded-depth off"), Arguments("-n tiny")}) {
        const Outcome flat = convert(other + Arguments("-y photos/p.mpo b.png"));
        EXPECT_TRUE(warns(flat, "several pictures: the first one is read"));
        EXPECT_FALSE(holds(flat.out, "stereo pair"));
        EXPECT_NE(slurp(studio_ / "b.png"), slurp(studio_ / "one.png"));
    }
    const Outcome one = convert("photos/a.jps a.png");
    EXPECT_TRUE(says(one, "a.jps: stereo pair (JPS), depth by matching; shift "));
    EXPECT_TRUE(warns(convert("-n tiny photos/a.jps e.png"),
                      "a.jps: holds the pictures of both eyes, which are read as one picture"));
    EXPECT_TRUE(warns(convert("-n tiny photos/d.jpg c.png"),
                      "d.jpg: holds the pictures of both eyes, which are read as one picture; "
                      "--stereo left-right reads the left one"));
}

TEST_F(Photo2Native, NamesSayWhatAPictureHoldsAloneAndInFolders) {
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat both;
    cv::hconcat(eyes.left, eyes.right, both);
    writeImage(studio_ / "both.png", both);
    cv::Mat ramp(eyes.left.size(), CV_32FC1);
    for (int x = 0; x < ramp.cols; ++x)
        ramp.col(x).setTo(x / 399.0);
    cv::Mat rgbd;
    joinRgbd(eyes.left, ramp, DepthSide::Right, rgbd);
    writeImage(studio_ / "depth.png", rgbd);
    fs::create_directory(studio_ / "in");
    fs::copy(studio_ / "both.png", studio_ / "in/a_LR.png");
    fs::copy(studio_ / "both.png", studio_ / "in/b_360.png");
    fs::copy(studio_ / "depth.png", studio_ / "in/c_rgbd.png");
    writeImage(studio_ / "in/d_LR.png", randomPhoto({80, 60}, 4));
    const auto make = [&](const Arguments& arguments) {
        return convert(Arguments{"-y"} + arguments);
    };
    EXPECT_TRUE(isDone(make("--stereo left-right both.png a.png")));
    EXPECT_TRUE(isDone(make("--rgbd right depth.png c.png")));
    const Outcome folder = make("in out");
    EXPECT_TRUE(warns(folder, "d_LR.png: its name (LR) may mean that it holds both eyes"));
    EXPECT_TRUE(holds(folder.out, "b_360.png: is made for headsets (VR) by its name"));
    EXPECT_TRUE(holds(folder.out, "3 photos made, 1 left out (1 VR file)"));
    for (const auto& [name, same] :
         {std::pair("a_LR", "a.png"), std::pair("c_rgbd", "c.png"), std::pair("d_LR", "")}) {
        const std::string file = std::string("in/") + name + ".png";
        EXPECT_EQ(make({file, "one.png"}).status, 0);
        const std::string inFolder = slurp(studio_ / ("out/" + std::string(name) + "_native.png"));
        EXPECT_EQ(slurp(studio_ / "one.png"), inFolder) << name;
        if (*same == 0) continue;
        EXPECT_EQ(inFolder, slurp(studio_ / same)) << name;
    }
    EXPECT_TRUE(fails(make("in/b_360.png x.png"), 1, "is made for headsets (VR)"));
    EXPECT_TRUE(fails(make("-n tiny in/b_360.png x.png"), 1, "is made for headsets"));
    EXPECT_EQ(make("--embedded-depth off in/b_360.png x.png").status, 0);
    EXPECT_EQ(make("--stereo left-right in/b_360.png x.png").status, 0);
    EXPECT_TRUE(warns(make("-n tiny in/a_LR.png x.png"),
                      "may hold both eyes, as its name (LR) says, and is read as one picture; "
                      "--stereo left-right takes it apart"));
    EXPECT_TRUE(warns(make("--embedded-depth off in/c_rgbd.png x.png"),
                      "may hold photo and depth, as its name (rgbd) says"));
}

TEST_F(Photo2Native, HalvesOfRgbdMayBeSqueezed) { // what says it: HalvesOf
    cv::Mat both;
    joinRgbd(randomPhoto({80, 90}, 4), randomDepth({80, 90}), DepthSide::Right, both);
    writeImage(studio_ / "a_RGBD.png", both); // of 16:9
    for (const auto& [layout, size] :
         {std::pair("right:squeezed", cv::Size(320, 90)), std::pair("right", cv::Size(160, 90))}) {
        EXPECT_TRUE(isDone(
            convert({"-y", "--rgbd", layout, "--save-rgbd", "s.png", "a_RGBD.png", "o.png"})));
        EXPECT_EQ(readImage(studio_ / "s.png").size(), size) << layout;
    }
}

TEST_F(Photo2Native, TheSharpOriginalIsNamed) {
    writeImage(studio_ / "blurred.jpg", scenery({120, 160}, 3));
    writeImage(studio_ / "sharp.jpg", scenery({120, 160}, 4));
    writeImage(studio_ / "d.png", madeDepth(120, 160));
    spill(studio_ / "p.jpg", gDepthPhoto(slurp(studio_ / "blurred.jpg"), slurp(studio_ / "d.png"),
                                         "RangeInverse", 1, 10, slurp(studio_ / "sharp.jpg")));
    const auto run = [&](const char* photo) {
        return convert({"--unblurred", "-y", "--report", "r.json", photo, "a.png"});
    };
    const auto isReported = [&] {
        return studio_.json("r.json").at("pictures").at(0).at("unblurred").get<bool>();
    };
    EXPECT_TRUE(says(run("p.jpg"), "p.jpg: the sharp original in the file is used\n"));
    EXPECT_TRUE(isReported());
    EXPECT_TRUE(says(run("sharp.jpg"), "sharp.jpg: no sharp original in the file is used\n"));
    EXPECT_FALSE(isReported());
}

TEST_F(Photo2Native, EyesAreTheViewsOfAQuiltOfTwo) {
    writeImage(studio_ / "p.png", scenery({80, 60}, 3));
    writeImage(studio_ / "d.png", depthTo16Bit(randomDepth({80, 60})));
    const Arguments pair("-y -d p.png d.png");
    const Outcome views = run(studio_.display() +
                              Arguments("--save-views v --fit stretch --strength 2.5 --focus 0.4 "
                                        "-q 1x2 -r 60x80 --quick") +
                              pair + Arguments("n.png"));
    ASSERT_EQ(views.status, 0) << views.text();
    const cv::Mat left = readImage(studio_ / "v/view_0.png");
    const cv::Mat right = readImage(studio_ / "v/view_1.png");
    EXPECT_FALSE(samePicture(left, right));
    // no display, no Native
    const auto made = [&](const Arguments& layout, const char* name) {
        Outcome outcome =
            run(Arguments{"--save-stereo", name} + Arguments("--focus 0.4") + layout + pair);
        EXPECT_TRUE(isDone(outcome));
        EXPECT_EQ(outcome.out.find("display"), std::string::npos) << outcome.out;
        return outcome;
    };
    made({}, "e_LRF.png");
    cv::Mat expected;
    joinEyes(left, right, EyesPicture::SideBySide, expected);
    EXPECT_TRUE(samePicture(readImage(studio_ / "e_LRF.png"), expected));
    EXPECT_TRUE(holds(made("--stereo-layout anaglyph --stereo-swap", "r.png").out,
                      "only by its name, as r_anaglyph.png"));
    joinEyes(right, left, EyesPicture::Anaglyph, expected);
    EXPECT_TRUE(samePicture(readImage(studio_ / "r.png"), expected));
    made("--stereo-layout files", "f.png");
    EXPECT_TRUE(samePicture(readImage(studio_ / "f_L.png"), left));
    EXPECT_TRUE(samePicture(readImage(studio_ / "f_R.png"), right));
    made("--stereo-layout files --stereo-keep left", "k.png");
    EXPECT_TRUE(samePicture(readImage(studio_ / "k_L.png"), readImage(studio_ / "p.png")));
}

TEST_F(Photo2Native, PhotographedEyesAreLaidOutAnew) {
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat both;
    joinEyes(eyes.left, eyes.right, EyesPicture::SideBySide, both);
    fs::create_directory(studio_ / "in");
    writeImage(studio_ / "in/a_LRF.png", both);
    writeImage(studio_ / "in/l.png", eyes.left);
    writeImage(studio_ / "in/r.png", eyes.right);
    cv::Mat expected;
    joinEyes(eyes.left, eyes.right, EyesPicture::TopBottom, expected);
    const auto make = [&](const Arguments& arguments) { return run(arguments); };
    const Arguments stacked("-y --save-stereo t_TBF.png --stereo-layout tb");
    for (const char* input : {"in/a_LRF.png", "--stereo left-right:full in/a_LRF.png",
                              "--stereo files in/l.png in/r.png"}) {
        EXPECT_TRUE(isDone(make(stacked + Arguments(input)))) << input;
        EXPECT_TRUE(samePicture(readImage(studio_ / "t_TBF.png"), expected)) << input;
    }
    EXPECT_TRUE(fails(make("--save-stereo s_LRF.png in/a_LRF.png"), 1, "is side by side already"));
    // other views are asked for
    EXPECT_TRUE(isDone(make(stacked + Arguments("--strength 2 in/a_LRF.png"))));
    EXPECT_FALSE(samePicture(readImage(studio_ / "t_TBF.png"), expected));
    // a folder of them
    fs::remove(studio_ / "in/l.png");
    fs::remove(studio_ / "in/r.png");
    EXPECT_TRUE(isDone(make("--save-stereo out --stereo-layout tb in")));
    EXPECT_TRUE(samePicture(readImage(studio_ / "out/a_LRF_TBF.png"), expected));
}

TEST_F(Photo2Native, EyesThatAFormatMixesAreToldAndKeptApart) {
    writeImage(studio_ / "p.png", scenery({80, 60}, 3));
    writeImage(studio_ / "d.png", depthTo16Bit(randomDepth({80, 60})));
    for (const char* layout : {"rows", "anaglyph-half"}) {
        const auto make = [&](const char* name) {
            return run(Arguments{"-y", "--save-stereo", name, "--stereo-layout", layout} +
                       Arguments("-d p.png d.png"));
        };
        EXPECT_TRUE(isDone(make("x_anaglyph.png")));
        EXPECT_TRUE(warns(make("x_anaglyph.jpg"), "x_anaglyph.jpg: this format mixes a little"));
        const cv::Mat exact = readImage(studio_ / "x_anaglyph.png");
        EXPECT_LE(cv::norm(readImage(studio_ / "x_anaglyph.jpg"), exact, cv::NORM_INF), 6);
        EXPECT_TRUE(fails(convert("x_anaglyph.png n.png"), 1, "by its mark of altiro3D"));
    }
}

TEST_F(Photo2Native, ThinPicturesAreReportedInPlainWords) {
    writeImage(studio_ / "one.png", randomPhoto({1, 40}));
    EXPECT_TRUE(fails(convert("--rgbd right one.png n.png"), 1,
                      "too small to split, expected at least 2 px across"));
    writeImage(studio_ / "wide.png", randomPhoto({1300, 8}));
    writeImage(studio_ / "deep.png", randomPhoto({1300, 8}));
    EXPECT_TRUE(fails(run("--save-stereo w_LRF.png -d wide.png deep.png"), 1,
                      "wide.png: has 1300 x 8 px, expected for --save-stereo"));
}

} // namespace altiro3D::test
