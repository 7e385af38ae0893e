// The large test data through the tools: every photo, quilt, light field and RGB-D pair.

#include "altiro3D/altiro3D.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/slow.hpp"
#include "support/texts.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

std::vector<std::string> inputsIn(const fs::path& directory) {
    std::vector<std::string> files;
    for (const auto& entry : fs::directory_iterator(directory)) {
        const std::string name = entry.path().filename().string();
        if (entry.is_regular_file() && name != "LICENSE" && name != "README.md")
            files.push_back(entry.path().string());
    }
    std::sort(files.begin(), files.end());
    return files;
}

// Every line on standard error is one of ours.
void expectOwnLines(const Outcome& outcome) {
    for (const std::string& line : outcome.errLines()) {
        EXPECT_TRUE(line.rfind(outcome.tool + ": error: ", 0) == 0 ||
                    line.rfind(outcome.tool + ": warning: ", 0) == 0)
            << line;
    }
}

// Runs all files of a folder at once; a file fails exactly if the library cannot read it.
// Returns how many failed.
std::size_t walkPhotos(const std::string& folder) {
    SmallStudio studio;
    const std::vector<std::string> files = inputsIn(dataPath(folder));
    const Outcome outcome =
        studio.convert("photo2native", Arguments("--report r.json") + files + Arguments{"out"});
    expectOwnLines(outcome);
    EXPECT_LE(outcome.status, 1) << outcome.text();
    if (outcome.status > 1) return 0;
    const Json pictures = studio.json("r.json").at("pictures");
    EXPECT_EQ(pictures.size(), files.size());
    std::size_t failed = 0;
    for (const Json& picture : pictures) {
        const std::string photo = picture.at("photo");
        if (picture.contains("error")) {
            const std::string problem = errorOf([&] { readPhoto(photo); });
            ++failed;
            EXPECT_EQ(picture.at("error"), problem);
            const std::string line = "photo2native: error: " + problem;
            const std::vector<std::string> lines = outcome.errLines();
            EXPECT_EQ(std::count(lines.begin(), lines.end(), line), 1) << line << outcome.err;
            EXPECT_TRUE(holds(line, photo));
        } else {
            const std::string native = picture.at("native");
            EXPECT_EQ(readBack(studio / native).size(), cv::Size(96, 128)) << photo;
        }
    }
    EXPECT_EQ(outcome.status, failed == 0 ? 0 : 1);
    return failed;
}

} // namespace

TEST(Data, PhotosBecomeNatives) {
    ALTIRO3D_TAKES(9);
    for (const char* folder : {"photos/skimage", "photos/derived", "photos/exif_orientation"}) {
        ALTIRO3D_REQUIRE_DATA(folder);
        EXPECT_EQ(walkPhotos(folder), 0U) << folder;
    }
}

TEST(Data, OtherFormatsBecomeNativesOrAreRefused) {
    ALTIRO3D_REQUIRE_DATA("photos/kodak");
    EXPECT_EQ(walkPhotos("photos/kodak"), 0U);
    ALTIRO3D_REQUIRE_DATA("photos/pillow");
    walkPhotos("photos/pillow"); // also GIF and PCX, which are not supported
}

TEST(Data, BrokenPhotosAreRefusedInOneLine) {
    ALTIRO3D_REQUIRE_DATA("photos/pillow_broken");
    EXPECT_GE(walkPhotos("photos/pillow_broken"), 5U);
    SmallStudio studio;
    for (const char* name : {"truncated_image.png", "decompression_bomb.gif", "zero_width.gif"}) {
        const std::string photo = dataPath("photos/pillow_broken").string() + "/" + name;
        EXPECT_TRUE(fails(studio.convert("photo2native", {photo, "a.png"}), 1, photo));
        EXPECT_TRUE(fails(studio.convert("quilt2native", {photo, "a.png"}), 1, photo));
    }
}

TEST(Data, QuiltsBecomeNatives) {
    struct Case {
        const char* file;
        int columns;
        int rows;
    };
    for (const auto& [file, columns, rows] :
         {Case{"quilts/kirurobo/example01.png", 4, 8}, Case{"quilts/kirurobo/example02.png", 4, 8},
          Case{"quilts/kirurobo/startup.png", 4, 8}, Case{"quilts/modprods/unity_quilt.png", 4, 8},
          Case{"quilts/greenbuddha/GreenBuddha_qs7x5a0.5625.jpg", 7, 5}}) {
        ALTIRO3D_REQUIRE_DATA(file);
        SmallStudio studio;
        const Outcome outcome =
            studio.run("quilt2native", {"-c", "small.json", "--fit", "stretch", "-q",
                                        std::to_string(rows) + "x" + std::to_string(columns),
                                        dataPath(file).string(), "a.png"});
        EXPECT_EQ(outcome.status, 0) << outcome.text();
        expectOwnLines(outcome);
        const cv::Mat quilt = readPhoto(dataPath(file));
        EXPECT_TRUE(
            samePicture(readBack(studio / "a.png"), libraryNative(studio, quilt, columns, rows)))
            << file;
    }
}

TEST(Data, AViewSequenceBecomesTheQuiltMadeOfIt) {
    ALTIRO3D_REQUIRE_DATA("lightfields/greenbuddha_33");
    ALTIRO3D_REQUIRE_DATA("quilts/greenbuddha");
    SmallStudio studio;
    const Outcome outcome =
        studio.run("views2native", {"-c", "small.json", "-q", "3x11", "-r", "662x372", "--fit",
                                    "stretch", "--save-quilt", "q.png",
                                    dataPath("lightfields/greenbuddha_33").string(), "a.png"});
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    expectOwnLines(outcome);
    const cv::Mat quilt = readBack(studio / "q_qs11x3a0.75.png");
    const cv::Mat known = readPhoto(dataPath("quilts/greenbuddha/GreenBuddha_qs7x5a0.5625.jpg"));
    for (int i = 0; i < 33; ++i) {
        const cv::Rect ours(i % 11 * 372, (2 - i / 11) * 662, 372, 662);
        const cv::Rect theirs(i % 7 * 372, (4 - i / 7) * 662, 372, 662);
        EXPECT_LT(compare(quilt(ours), known(theirs)).mean, 4) << i; // JPEG twice over: about 2
    }
}

TEST(Data, PairsOfPhotoAndDepthBecomeNatives) {
    struct Case {
        Arguments arguments;
        std::vector<const char*> inputs;
        int pictures;
    };
    const std::string rgbd = "rgbd/";
    const Case cases[] = {
        {"-d", {"moon_3dphoto/image/moon.jpg", "moon_3dphoto/depth/moon.png"}, 1},
        {"-d --depth-kind metric", {"slambook2/ch5_rgbd/color", "slambook2/ch5_rgbd/depth"}, 5},
        {"-d --depth-kind metric:5000",
         {"slambook2/ch12_dense_rgbd/color", "slambook2/ch12_dense_rgbd/depth"},
         5},
        {"--rgbd right --depth-kind far-white",
         {"side_by_side/dphn03.jpg", "side_by_side/misc_dp03.jpg"},
         2},
        {"--rgbd right",
         {"side_by_side/Bricks076C_1K_rgba_near_bright.png",
          "side_by_side/qoocam_qc010_near_bright.jpg"},
         2},
        {"--rgbd bottom", {"top_bottom/360_02.jpg"}, 1}};
    for (const Case& one : cases) {
        SmallStudio studio;
        fs::create_directory(studio / "out");
        Arguments call = one.arguments + studio.display() + Arguments("--save-depth depth");
        for (const char* input : one.inputs) {
            ALTIRO3D_REQUIRE_DATA(rgbd + input);
            call.push_back(dataPath(rgbd + input).string());
        }
        const Outcome outcome = studio.run("photo2native", call + Arguments{"out"});
        EXPECT_EQ(outcome.status, 0) << outcome.text();
        expectOwnLines(outcome);
        EXPECT_EQ(listImages(studio / "out").size(), static_cast<std::size_t>(one.pictures));
        for (const fs::path& file : listImages(studio / "depth")) {
            const cv::Mat depth = readBack(file);
            double low = 0;
            double high = 0;
            cv::minMaxLoc(depth, &low, &high);
            EXPECT_EQ(low, 0) << file;
            EXPECT_EQ(high, 65535) << file;
        }
    }
}

TEST(Data, ANetworkGivesTheNativeOfTheLibrary) {
    ALTIRO3D_REQUIRE_DATA("models/fastdepth/fastdepth_224_op10.onnx");
    const fs::path network = dataPath("models/fastdepth/fastdepth_224_op10.onnx");
    const fs::path photo = dataPath("models/fastdepth/rgb.png");
    SmallStudio studio;
    const QuiltLayout layout = smallLayout();
    const auto catalog = readModelCatalog(sourcePath("models/catalog.json"));
    const NetworkProfile* profile = findProfile(catalog, network);
    ASSERT_NE(profile, nullptr);
    cv::Mat quilt;
    cv::Mat native;
    Network2Quilt(DepthNetwork(network, *profile), layout, {}, 0.75)
        .render(readPhoto(photo), quilt);
    Quilt2Native(readCalibration(studio / "small.json"), layout, {}).render(quilt, native);

    studio.set("ALTIRO3D_MODELS",
               sourcePath("models").string() + ":" + network.parent_path().string());
    for (const std::string& name :
         {network.string(), std::string("fastdepth"), std::string("fastdepth_224_op10.onnx")}) {
        for (const char* threads : {"1", "2"}) {
            EXPECT_TRUE(
                says(studio.convert("photo2native", fixedWay({"--quick", "-y", "-j", threads, "-n",
                                                              name, "--report", "r.json"}) +
                                                        Arguments{photo.string(), "a.png"}),
                     "network fastdepth"));
            // the network's sums depend on the number of threads in the last digits
            EXPECT_TRUE(samePicture(readBack(studio / "a.png"), native, 2));
            const Json settings = studio.json("r.json").at("settings");
            EXPECT_EQ(settings.at("network").at("name"), "fastdepth");
            EXPECT_EQ(settings.at("network").at("file"), network.string());
        }
    }
    EXPECT_TRUE(
        fails(studio.convert("photo2native", {"-l", "-n", "fastdepth", photo.string(), "b.png"}), 2,
              "fastdepth"));
}

TEST(Data, NetworksThatCannotBeUsedAreRefusedInOneLine) {
    ALTIRO3D_REQUIRE_DATA("models/midas_small_graph_only/midas_small.onnx");
    SmallStudio studio;
    spill(studio / "p.json", R"({"name": "p", "inputWidth": 256, "inputHeight": 256})");
    for (const std::string& network :
         {dataPath("models/midas_small_graph_only/midas_small.onnx").string(),
          (studio / "photo.png").string(), std::string("p.json"), std::string("views")}) {
        EXPECT_TRUE(fails(studio.convert("photo2native", {"-n", network, "--net-profile", "p.json",
                                                          "photo.png", "a.png"}),
                          1, network));
    }
}

TEST(Data, EveryCalibrationIsExplained) {
    ALTIRO3D_REQUIRE_DATA("calibrations");
    SmallStudio studio;
    for (const std::string& file : inputsIn(dataPath("calibrations"))) {
        const bool partial = file.find("partial") != std::string::npos;
        const bool other = file.find("reference_samples") != std::string::npos ||
                           file.find("templates") != std::string::npos;
        const Outcome outcome = studio.run("altiro3Dnative", {"--json", file});
        expectOwnLines(outcome);
        EXPECT_TRUE(partial || other ? outcome.status <= 1 : outcome.status == 0) << outcome.text();
        EXPECT_EQ(Json::accept(outcome.out), outcome.status == 0) << outcome.text();
    }
}

} // namespace altiro3D::test
