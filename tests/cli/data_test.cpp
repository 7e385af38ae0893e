// The large test data through the tools: photos, a light field and RGB-D pairs.

#include "altiro3D/image_io.hpp"
#include "sandbox.hpp"
#include "support/compare.hpp"
#include "support/slow.hpp"

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

} // namespace altiro3D::test
