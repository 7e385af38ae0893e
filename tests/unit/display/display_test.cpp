#include "altiro3D/display.hpp"

#include "support/files.hpp"

#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

Calibration panel(int width, int height, double dpi = 300) {
    Calibration c;
    c.pitch = 50;
    c.slope = -7;
    c.DPI = dpi;
    c.screenW = width;
    c.screenH = height;
    return c;
}

std::string modelOf(const std::string& serial) {
    Calibration c = panel(100, 100);
    c.serial = serial;
    const DisplayModel* model = findDisplayModel(c);
    return model != nullptr ? model->name : "";
}

TEST(Display, SerialNumberTellsTheModel) {
    EXPECT_EQ(modelOf("LKG-PORT-19930"), "Looking Glass Portrait");
    EXPECT_EQ(modelOf("LKG-P00655"), "Looking Glass Portrait");
    EXPECT_EQ(modelOf("lkg-2k-04409"), "Looking Glass 8.9\"");
    EXPECT_EQ(modelOf("LKG-APW92011"), "Looking Glass 16\" (2nd generation)");
    EXPECT_EQ(modelOf("LKG-J00133"), "Looking Glass 16\" landscape");
    EXPECT_EQ(modelOf("LKG-E05304"), "Looking Glass Go");
    EXPECT_EQ(modelOf("LKG-G00001"), "Looking Glass Go landscape");
    EXPECT_EQ(modelOf("00112"), "");
}

// Default quilts as the display's maker publishes them: columns, rows, view width and height.
TEST(Display, PanelTellsTheDefaultQuiltWithoutASerialNumber) {
    const struct {
        Calibration calibration;
        int columns, rows, width, height;
    } kTable[] = {{panel(1536, 2048), 8, 6, 420, 560},
                  {panel(2560, 1600), 5, 9, 819, 455},
                  {panel(3840, 2160), 5, 9, 819, 455},
                  {panel(1440, 2560), 11, 6, 372, 682},
                  {panel(2160, 3840), 11, 6, 545, 1000},
                  {panel(4320, 7680), 11, 6, 744, 1364},
                  {panel(7680, 4320), 5, 9, 1638, 910},
                  {panel(7680, 4320, 136), 8, 9, 1024, 910},
                  {panel(2560, 1440), 5, 9, 819, 455},
                  {panel(4320, 7680, 136), 11, 6, 744, 1364},
                  // 27" has no panel size: by its diagonal
                  {panel(3840, 2160, 163), 8, 6, 960, 720},
                  {panel(5120, 2880, 218), 8, 6, 960, 720},
                  {panel(2160, 3840, 163), 12, 4, 640, 1080}};
    for (const auto& row : kTable) {
        const QuiltLayout quilt = defaultQuilt(row.calibration);
        EXPECT_EQ(quilt.columns, row.columns);
        EXPECT_EQ(quilt.rows, row.rows);
        EXPECT_EQ(quilt.tileSize, cv::Size(row.width, row.height));
        EXPECT_EQ(quilt.viewCount, row.columns * row.rows);
    }
    Calibration third = panel(3840, 2160);
    third.viewCone = 50;
    EXPECT_EQ(defaultQuilt(third).tileSize, cv::Size(960, 720));
    third.viewCone = 0;
    third.subpixelCells.resize(1);
    EXPECT_EQ(defaultQuilt(third).columns, 8);
    EXPECT_EQ(findDisplayModel(panel(3840, 2160, 163))->name, "Looking Glass 27\" landscape");
    EXPECT_EQ(findDisplayModel(panel(4320, 7680, 136))->name, "Looking Glass 65\" portrait");
    EXPECT_TRUE(calibrationWarnings(panel(5120, 2880, 218)).empty());
}

// 7 x 7 views of 857 px, of documents before the maker's software had 8 x 6.
TEST(Display, TheEarlierQuiltOfThe16InchIsMeantByItsGridOrItsSize) {
    Calibration c = panel(3840, 2160, 283);
    c.serial = "LKG-J00001";
    const Display display = displayOf(c);
    const QuiltLayout earlier{7, 7, {857, 857}, 49};
    EXPECT_EQ(display.quilt.size(), cv::Size(7680, 4320));
    EXPECT_EQ(usualQuilt(display, {}), display.quilt);
    QuiltRequest request;
    request.grid = QuiltGrid{7, 7};
    EXPECT_EQ(usualQuilt(display, request), earlier);
    EXPECT_EQ(resolveQuilt(request, usualQuilt(display, request), 16.0 / 9).layout, earlier);
    request.grid = QuiltGrid{6, 7};
    EXPECT_EQ(usualQuilt(display, request), display.quilt);
    request.quiltSize = cv::Size(5999, 5999);
    EXPECT_EQ(usualQuilt(display, request), display.quilt); // the grid was asked for
    request.grid.reset();
    EXPECT_EQ(usualQuilt(display, request), earlier);
    c.serial = "LKG-L00001";
    EXPECT_EQ(usualQuilt(displayOf(c), request), defaultQuilt(c));
}

TEST(Display, UnknownPanelsGetAQuiltOfTheirShape) {
    for (const cv::Size size : {cv::Size(1920, 1080), cv::Size(1080, 1920), cv::Size(16, 16384),
                                cv::Size(16384, 16), cv::Size(333, 777)}) {
        const QuiltLayout quilt = defaultQuilt(panel(size.width, size.height));
        EXPECT_NO_THROW(validate(quilt));
        EXPECT_EQ(quilt.viewCount, 48);
    }
    const QuiltLayout hd = defaultQuilt(panel(1920, 1080));
    EXPECT_NEAR(static_cast<double>(hd.tileSize.width) / hd.tileSize.height, 16.0 / 9, 0.01);
    EXPECT_EQ(cv::Size(hd.columns, hd.rows), cv::Size(6, 8));
    const QuiltLayout upright = defaultQuilt(panel(1080, 1920));
    EXPECT_EQ(cv::Size(upright.columns, upright.rows), cv::Size(8, 6));
}

TEST(Display, EveryTemplatesQuiltIsItsDefault) {
    ALTIRO3D_REQUIRE_DATA("calibrations");
    for (const Calibration& c :
         readCalibrations(dataPath("calibrations/templates_LKG-Toolkit_nominal.json"))) {
        const DisplayModel* model = findDisplayModel(c);
        ASSERT_NE(model, nullptr) << c.serial;
        EXPECT_EQ(model->panelSize, cv::Size(c.screenW, c.screenH)) << c.serial;
        EXPECT_EQ(calibrationWarnings(c).size(), 0U) << c.serial;
    }
}

TEST(Display, OddCalibrationsGetRemarks) {
    Calibration c = panel(1440, 2560);
    c.serial = "LKG-PORT-1";
    c.fringe = 0.1;
    c.flipImageX = 1;
    const auto found = calibrationWarnings(c);
    ASSERT_EQ(found.size(), 3U);
    EXPECT_TRUE(holds(found[0].text, "1536 x 2048"));
    c = panel(3840, 2160);
    c.serial = "LKG-J00001";
    ASSERT_EQ(calibrationWarnings(c).size(), 1U);
    EXPECT_TRUE(holds(calibrationWarnings(c)[0].text, "sub-pixel cells"));
    c.subpixelCells.resize(2);
    EXPECT_TRUE(calibrationWarnings(c).empty());
}

TEST(Display, MountedVolumesAreFoundWhereSystemsMountThem) {
    const TemporaryDirectory root;
    EXPECT_TRUE(findMountedCalibrations(root.path()).empty());
    const auto mount = [&](const std::string& volume) {
        fs::create_directories(root / volume / "LKG_calibration");
        spill(root / volume / "LKG_calibration" / "visual.json", "{}");
    };
    mount("media/user/LKG-P00655");
    mount("run/media/user/LKG-E04406");
    mount("mnt/lkg-j1");
    mount("Volumes/LKG-F1");
    mount("mnt/disks/deeper/LKG-F2");               // beyond what is looked at
    mount("media/user/OTHER");                      // another disk
    fs::create_directories(root / "mnt/LKG-EMPTY"); // a display's volume without its file
    const auto found = findMountedCalibrations(root.path());
    ASSERT_EQ(found.size(), 4U);
    EXPECT_EQ(found[0].volume, "LKG-F1");
    EXPECT_EQ(found[1].volume, "LKG-P00655");
    EXPECT_EQ(found[2].volume, "lkg-j1");
    EXPECT_EQ(found[3].volume, "LKG-E04406");
    EXPECT_EQ(found[1].file, root / "media/user/LKG-P00655/LKG_calibration/visual.json");
}

TEST(Display, IsReadWithItsPanelAndItsModelsQuilt) {
    const TemporaryDirectory directory;
    const auto file = directory / "visual.json";
    spill(file, R"([{"serial":"LKG-P00001","pitch":52.5,"slope":-7.1,"center":0.4,
        "screenW":1536,"screenH":2048,"DPI":324,"viewCone":40,"invView":1},
        {"serial":"LKG-E00002","pitch":50,"slope":-7,"center":0.1,
        "screenW":1440,"screenH":2560,"DPI":491,"viewCone":54,"invView":1}])");
    const Display first = readDisplay(file);
    EXPECT_EQ(first.calibration.serial, "LKG-P00001");
    EXPECT_EQ(first.panelSize(), cv::Size(1536, 2048));
    EXPECT_DOUBLE_EQ(first.aspect(), 0.75);
    EXPECT_EQ(first.quilt, defaultQuilt(first.calibration));
    EXPECT_EQ(first.source, file.string());
    EXPECT_EQ(readDisplay(file, "lkg-e00002").panelSize(), cv::Size(1440, 2560));
    EXPECT_EQ(errorOf([&] { readDisplay(file, "LKG-P00009"); }),
              file.string() + ": holds no calibration of LKG-P00009, expected the serial number "
                              "of LKG-P00001");
}

TEST(Display, IsMadeOfValidCalibrationsOnly) {
    const std::string error = errorOf([] { displayOf(Calibration(), "mine"); });
    EXPECT_TRUE(startsWith(error, "mine: pitch is "));
}

} // namespace
} // namespace altiro3D::test
