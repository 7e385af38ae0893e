// The choice of methods, their options and camera, and the automatic choice of --budget.

#include "altiro3D/altiro3D.hpp"
#include "altiro3D/depth2quilt.hpp"
#include "cli/budget.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/onnx.hpp"

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using tools::BudgetChoice;
using tools::chooseWithinBudget;
using tools::SettingCost;

namespace {

constexpr const char* kTool = "photo2native";

// Options and the Native of photo.png and depth.png of a SmallStudio.
class Methods : public ::testing::Test {
  protected:
    Outcome make(const Arguments& options, const std::string& output = "a.png") const {
        return studio_.convert(kTool, fixedWay(options) +
                                          Arguments{"-y", "-d", "photo.png", "depth.png", output});
    }
    cv::Mat native(const Arguments& options) const {
        const Outcome outcome = make(options);
        EXPECT_TRUE(isDone(outcome));
        return readBack(studio_ / "a.png");
    }
    Json report(const Arguments& options) const {
        EXPECT_EQ(make(options + Arguments("--report r.json")).status, 0);
        return studio_.json("r.json");
    }
    cv::Mat libraryNative(const ViewOptions& views) const {
        LibraryPath path;
        path.views = views;
        return test::libraryNative(studio_, path);
    }
    std::vector<fs::path> cachedBudgets() const {
        std::vector<fs::path> files;
        std::error_code error;
        for (const auto& entry :
             fs::directory_iterator(studio_.home() / ".cache/altiro3D", error)) {
            if (entry.path().filename().string().rfind("budget-", 0) == 0)
                files.push_back(entry.path());
        }
        return files;
    }
    // Costs that no machine has, in the only file that keeps some: what is chosen by them was read.
    // @return that file's contents
    Json keepCosts(const std::vector<double>& costs, const std::vector<Json>& depths = {}) const {
        EXPECT_EQ(cachedBudgets().size(), 1U);
        Json kept = Json::parse(slurp(cachedBudgets().front()));
        for (std::size_t i = 0; i < costs.size(); ++i)
            kept.at("costs").at(i).at("milliseconds") = costs[i];
        for (std::size_t i = 0; i < depths.size(); ++i)
            kept.at("depths").at(i).at("milliseconds") = depths[i];
        spill(cachedBudgets().front(), kept.dump());
        return kept;
    }
    void writeCamera(const std::string& change = R"("zFar": 10)") const {
        spill(studio_ / "camera.json", R"({"fx": 80, "fy": 80, "cx": 44.5, "cy": 59.5,
              "zNear": 1, "baseline": 0.2, )" +
                                           change + "}");
    }

    SmallStudio studio_;
};

ViewOptions optionsOf(ViewMethod method) {
    ViewOptions options;
    options.method = method;
    return options;
}

} // namespace

TEST_F(Methods, TheCameraGivesTheStrength) {
    writeCamera(); // S = 2 80 0.2 (1/1 - 1/10) = 28.8 px of the photo's 90
    ViewOptions options = optionsOf(ViewMethod::Real);
    options.strengthPercent = 32;
    for (const Arguments& keep : {Arguments{}, Arguments{"-k"}}) { // whatever the view's size
        const Json json = report(keep + Arguments("-g --camera camera.json"));
        EXPECT_NEAR(json.at("pictures").at(0).at("strengthPercent").get<double>(), 32,
                    kReportPrecision);
        EXPECT_TRUE(json.at("settings").at("strengthPercent").is_null());
    }
    EXPECT_TRUE(samePicture(native("-g --camera camera.json"), libraryNative(options)));
    EXPECT_TRUE(samePicture(native("-g --strength 32"), libraryNative(options)));
    writeCamera(R"("zFar": null)"); // infinitely far: 2 80 0.2 = 32 px
    const Json json = report("-g --camera camera.json");
    EXPECT_NEAR(json.at("pictures").at(0).at("strengthPercent").get<double>(), 3200 / 90.0,
                kReportPrecision);
}

TEST_F(Methods, TheCameraIsCroppedWithThePhoto) {
    writeImage(studio_ / "photo.png", madePhoto(150, 120)); // 90 of the 150 columns are used
    writeImage(studio_ / "depth.png", madeDepth(75, 60));
    writeCamera();
    const Json picture = report("-g --camera camera.json").at("pictures").at(0);
    EXPECT_EQ(picture.at("crop").at(2), 90);
    EXPECT_NEAR(picture.at("strengthPercent").get<double>(), 32, kReportPrecision);
}

TEST_F(Methods, TheStrengthOfTheCameraDecidesHowFarThePhotoIsEnlarged) {
    writeImage(studio_ / "photo.png", madePhoto(900, 1200));
    writeCamera(); // 28.8 px of 900 are 3.2 %
    const auto picture = [&](const Arguments& options) {
        const Arguments automatic("-g --fit auto --focus 0.5");
        return report(automatic + options).at("pictures").at(0);
    };
    const Json expected = picture("--strength 3.2");
    const Json made = picture("--camera camera.json");
    EXPECT_EQ(made.at("crop"), expected.at("crop"));
    EXPECT_NE(made.at("crop"), picture("--strength 10").at("crop"));
    const double shown = made.at("crop").at(2);
    EXPECT_NEAR(made.at("strengthPercent").get<double>(), 3.2 * 900 / shown, kReportPrecision);
}

TEST_F(Methods, ABadCameraIsOneErrorLine) { // all: the library's tests
    spill(studio_ / "camera.json", "no json");
    EXPECT_TRUE(fails(make("-g --camera camera.json"), 1, "camera.json"));
    EXPECT_FALSE(fs::exists(studio_ / "a.png"));
}

TEST(ChooseWithinBudget, TakesTheFirstThatFitsAndElseTheLast) {
    // a better one need not be the slower one
    const std::vector<SettingCost> costs{{"best", 200}, {"good", 90}, {"odd", 150}, {"quick", 50}};
    const std::pair<double, BudgetChoice> cases[] = {{200, {0, true}}, {199.9, {1, true}},
                                                     {90, {1, true}},  {89.9, {3, true}},
                                                     {50, {3, true}},  {49.9, {3, false}}};
    for (const auto& [budget, expected] : cases) {
        const BudgetChoice choice = chooseWithinBudget(costs, budget);
        EXPECT_EQ(choice.index, expected.index) << budget;
        EXPECT_EQ(choice.fits, expected.fits) << budget;
    }
}

TEST_F(Methods, ABudgetChoosesTheBestThatFitsAndSaysSo) {
    const Outcome outcome = make("--budget 60000 --report r.json");
    EXPECT_TRUE(says(outcome, "budget: layered, Native in "));
    EXPECT_TRUE(holds(outcome.out, " ms of 60000 ms\n"));
    EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"), libraryNative({})));
    const Json report = studio_.json("r.json");
    EXPECT_EQ(report.at("settings").at("method"), "layered");
    const Json& budget = report.at("budget");
    EXPECT_EQ(budget.at("milliseconds"), 60000);
    EXPECT_EQ(budget.at("chosen"), "layered");
    EXPECT_TRUE(budget.at("fits").get<bool>());
    EXPECT_FALSE(budget.at("fromCache").get<bool>());
    std::vector<std::string> settings;
    for (const Json& cost : budget.at("measured")) {
        settings.push_back(cost.at("setting"));
        EXPECT_GT(cost.at("milliseconds").get<double>(), 0);
    }
    EXPECT_EQ(settings, (std::vector<std::string>{"layered", "layered, hard borders",
                                                  "layered, hard borders, fill continue",
                                                  "fast, refinement 2", "fast"}));
    EXPECT_TRUE(this->report({}).at("budget").is_null());
}

TEST_F(Methods, ABudgetAndAutoChooseTogether) {
    const Arguments automatic("--fit auto --focus auto --strength auto");
    const auto picture = [&](const Arguments& options) {
        return report(automatic + options).at("pictures").at(0);
    };
    const Json alone = picture("--quick");
    const cv::Mat expected = readBack(studio_ / "a.png");
    const Json within = picture("--budget 60000"); // layered, as without a budget
    EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"), expected));
    // a method that the budget chooses makes the picture that the method makes by itself
    keepCosts({6000, 3000, 2000, 1500, 1});
    const Json quick = picture("--budget 2");
    const cv::Mat made = readBack(studio_ / "a.png");
    picture("--method fast");
    EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"), made));
    EXPECT_FALSE(samePicture(made, expected));
    for (const char* key : {"focus", "center", "strengthPercent"}) {
        EXPECT_EQ(within.at(key), alone.at(key)) << key;
        EXPECT_EQ(quick.at(key), alone.at(key)) << key;
    }
    EXPECT_NE(alone.at("strengthPercent"), 10);
}

TEST_F(Methods, CostsAreMeasuredOnceAndKept) {
    ASSERT_TRUE(isDone(make("--budget 60000")));
    Json kept = keepCosts({6000, 3000, 600, 60, 6});
    const fs::path cache = cachedBudgets().front();
    EXPECT_EQ(kept.at("format"), 5);
    ViewOptions hard;
    hard.layered.softBorders = false;
    ViewOptions fill = hard;
    fill.layered.fill = LayeredFill::Continue;
    ViewOptions refined = optionsOf(ViewMethod::Fast);
    refined.refinement = 2;
    const std::tuple<const char*, const char*, ViewOptions> cases[] = {
        {"6000", "budget: layered, Native in 6000 ms of 6000 ms", {}},
        {"5999", "budget: layered, hard borders, Native in 3000 ms of 5999 ms", hard},
        {"2999", "budget: layered, hard borders, fill continue, Native in 600 ms of 2999 ms", fill},
        {"99.5", "budget: fast, refinement 2, Native in 60 ms of 100 ms", refined},
        {"6", "budget: fast, Native in 6 ms of 6 ms", optionsOf(ViewMethod::Fast)}};
    for (auto [budget, line, options] : cases) {
        options.strengthPercent = 40;
        EXPECT_TRUE(says(make({"--strength", "40", "--budget", budget}), line));
        EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"), libraryNative(options))) << line;
    }
    const Outcome tight = make("--budget 5.5");
    EXPECT_TRUE(warns(tight, "meets the budget of 5.5 ms"));
    EXPECT_TRUE(holds(tight.out, "budget: fast, Native in 6 ms of 5.5 ms"));
    EXPECT_TRUE(
        samePicture(readBack(studio_ / "a.png"), libraryNative(optionsOf(ViewMethod::Fast))));
    kept["format"] = 1;
    const std::string older = kept.dump();
    for (const std::string& useless : {std::string(), std::string("{}"), std::string("[1, 2"),
                                       std::string(R"({"format": 5, "costs": "none"})"), older}) {
        spill(cache, useless);
        EXPECT_TRUE(isDone(make("--budget 60000")));
        EXPECT_EQ(Json::parse(slurp(cache)).at("costs").size(), 5U) << useless;
        EXPECT_NE(slurp(cache), older);
    }
    studio_.set("HOME", std::nullopt); // no cache: measured each time
    EXPECT_TRUE(isDone(make("--budget 60000")));
    const fs::path elsewhere = studio_.home() / "elsewhere";
    for (const std::string& home :
         {elsewhere.string(), std::string("relative"), std::string("/proc/nothing"),
          (studio_ / "small.json").string() + "/below/a/file/\xff"}) {
        studio_.set("XDG_CACHE_HOME", home);
        EXPECT_TRUE(isDone(make("--budget 60000")));
    }
    EXPECT_TRUE(fs::exists(elsewhere / "altiro3D"));
    EXPECT_FALSE(fs::exists(studio_ / "relative")) << "as the XDG standard requires";
}

// A network of 32 px that also runs with 16 px, and one that does not.
TEST_F(Methods, ABudgetChoosesTheSourceOfEstimatedDepth) {
    const fs::path models = studio_ / "net";
    fs::create_directory(models);
    studio_.set("ALTIRO3D_MODELS", models.string());
    spill(models / "open.onnx", onnx::mixModel({0.2F, 0.3F, 0.5F}, {0, 0}));
    spill(models / "fixed.onnx", onnx::mixModel({0.5F, 0.3F, 0.2F}, {32, 32}));
    const std::string size = R"("inputWidth": 32, "inputHeight": 32, "multipleOf": 16})";
    spill(models / "catalog.json", R"({"networks": [{"name": "open", "file": "open.onnx", )" +
                                       size + R"(, {"name": "fixed", "file": "fixed.onnx", )" +
                                       size + "]}");
    const auto estimated = [&](const Arguments& options) {
        return studio_.convert(kTool, options + Arguments("-y photo.png a.png"));
    };
    EXPECT_TRUE(says(estimated("--budget 60000 --report r.json"),
                     "budget: open, 32 px; layered, depth and Native in "));
    const Json report = studio_.json("r.json");
    std::vector<std::string> sources;
    for (const Json& cost : report.at("budget").at("measuredDepths"))
        sources.push_back(cost.at("setting"));
    EXPECT_EQ(sources, (std::vector<std::string>{"open, 32 px", "open, 16 px", "fixed, 32 px",
                                                 "fixed, 16 px"}));
    keepCosts({4000, 3500, 400, 40, 4}, {10000, 1000, 900, nullptr});
    const std::tuple<const char*, const char*, Arguments> cases[] = {
        {"14000", "open, 32 px; layered, depth and Native in 14000 ms of", {"-n", "open"}},
        {"13999",
         "open, 16 px; layered, depth and Native in 5000 ms of",
         {"-n", "open", "--network-size", "16"}},
        {"4999", "fixed, 32 px; layered, depth and Native in 4900 ms of", {"-n", "fixed"}},
        {"903",
         "fixed, 32 px; fast, depth and Native in 904 ms of",
         {"-n", "fixed", "--method", "fast"}}};
    for (const auto& [budget, line, same] : cases) {
        EXPECT_TRUE(holds(estimated({"--budget", budget}).out, line));
        const cv::Mat chosen = readBack(studio_ / "a.png");
        EXPECT_TRUE(isDone(estimated(Arguments{"--quick"} + same)));
        EXPECT_TRUE(samePicture(chosen, readBack(studio_ / "a.png"))) << line;
    }
    const Outcome named = estimated("--budget 60000 -n fixed"); // its time counts
    EXPECT_TRUE(holds(named.out, "budget: network fixed"));
    EXPECT_TRUE(holds(named.out, "; layered, depth and Native in "));
}

TEST_F(Methods, CostsAreThoseOfThePathThatIsTaken) {
    studio_.makeMap();
    const Arguments photo("-y --budget 60000 -d photo.png depth.png a.png");
    const Arguments small = studio_.display();
    const Arguments paths[] = {small,
                               small + Arguments{"-k"},
                               small + Arguments("-j 1"),
                               small + Arguments{"--continuous"},
                               {"-m", "a.map"},
                               small + Arguments("--view-filter linear")};
    std::size_t measured = 0;
    for (const Arguments& path : paths) {
        ++measured;
        for (int repetition = 0; repetition < 2; ++repetition) {
            const Outcome outcome = studio_.run(kTool, path + photo);
            EXPECT_TRUE(says(outcome, "budget: layered, Native in "));
            EXPECT_EQ(cachedBudgets().size(), measured) << outcome.call;
        }
    }
    EXPECT_TRUE(isDone(studio_.run(kTool, fixedWay(small) + photo))); // choosing changes nothing
    EXPECT_TRUE(samePicture(readBack(studio_ / "a.png"), libraryNative({})));
}

TEST_F(Methods, ABudgetIsForAllPicturesOfARun) {
    spill(studio_ / "broken.png", "broken");
    const Outcome outcome =
        studio_.convert(kTool, "--budget 60000 --report r.json broken.png photo.png quilt.png out");
    EXPECT_EQ(outcome.status, 1); // the broken one
    const std::size_t first = outcome.out.find("budget: ");
    EXPECT_NE(first, std::string::npos) << outcome.out;
    EXPECT_EQ(outcome.out.find("budget: ", first + 1), std::string::npos) << outcome.out;
    EXPECT_EQ(studio_.json("r.json").at("budget").at("chosen"), "tiny, 32 px; layered");
    EXPECT_EQ(
        studio_.convert(kTool, "-y --budget 9 --report r.json broken.png broken.png out").status,
        2); // two in one file
    fs::create_directory(studio_ / "bad");
    fs::copy(studio_ / "broken.png", studio_ / "bad");
    EXPECT_EQ(studio_.convert(kTool, "-y --budget 9 --report r.json bad out").status, 1);
    EXPECT_EQ(studio_.json("r.json").at("budget"), Json({{"milliseconds", 9}}));
}

} // namespace altiro3D::test
