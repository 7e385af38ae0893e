#include "viewer/model/document.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "cli/folders.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/hand_slide.hpp"
#include "support/photo_files.hpp"
#include "support/random_pictures.hpp"
#include "support/stereo_scene.hpp"
#include "support/texts.hpp"
#include "viewer/model/knobs.hpp"
#include "viewer/window/photo_strip.hpp"
#include "viewer_scenes.hpp"

#include <QDir>
#include <QFile>
#include <QMimeDatabase>
#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

TEST(ViewerDocument, NameAndSizeTellWhatAPictureIs) {
    const Display display = sampleDisplay({48, 64});
    const auto kindOf = [&](const std::string& name, cv::Size size) {
        return documentOf({name, {}, Reading::Automatic}, detailedPhoto(size), display).kind;
    };
    EXPECT_EQ(kindOf("holiday.jpg", {90, 120}), Kind::Scene);
    EXPECT_EQ(kindOf("a_qs8x6a0.75.png", {80, 60}), Kind::Quilt);
    EXPECT_EQ(kindOf("anything.png", {48, 64}), Kind::Native);
    EXPECT_EQ(kindOf("camera.jpg", {48, 64}), Kind::Scene);
    EXPECT_EQ(kindOf("my_native.jpg", {48, 64}), Kind::Native);
    const Document rgbd = // a video
        documentOf({"a_rgbd.mp4", {}, Reading::Automatic}, detailedPhoto({90, 60}), display);
    EXPECT_EQ(rgbd.kind, Kind::Scene);
    EXPECT_EQ(rgbd.picture.size(), cv::Size(45, 60));
    EXPECT_FALSE(rgbd.rawDepth.empty());
    EXPECT_EQ(rgbd.facts(), "Video, 45 x 60 px, with depth");
}

TEST(ViewerDocument, NamesOfHalvesCountIfTheHalvesAgree) {
    const Display display = sampleDisplay({48, 64});
    const TemporaryDirectory directory;
    const auto opened = [&](const char* name, const cv::Mat& picture) {
        writeImage(directory / name, picture);
        return readDocument({directory / name, {}, Reading::Automatic}, display);
    };
    const Eyes eyes = wallAndThing(6, 26);
    cv::Mat both;
    cv::hconcat(eyes.left, eyes.right, both);
    const Document pair = opened("a_LR.png", both);
    EXPECT_TRUE(samePicture(pair.picture, eyes.left));
    EXPECT_EQ(pair.origin, DepthOrigin::Matched);
    EXPECT_FALSE(pair.hidden.photo.empty());
    EXPECT_GT(pair.rawDepth.at<float>(150, 200), pair.rawDepth.at<float>(150, 350));
    cv::Mat ramp(eyes.left.size(), CV_32FC1);
    for (int x = 0; x < ramp.cols; ++x)
        ramp.col(x).setTo(x / 399.0);
    joinRgbd(eyes.left, ramp, DepthSide::Left, both);
    const Document rgbd = opened("a_rgbd.png", both);
    EXPECT_TRUE(samePicture(rgbd.picture, eyes.left));
    EXPECT_EQ(rgbd.facts(), "Photo, 400 x 300 px; depth half of the picture (left, by "
                            "its name, rgbd)");
    for (const char* name : {"b_LR.png", "b_rgbd.png"}) {
        const Document plain = opened(name, randomPhoto({90, 60}, 4));
        EXPECT_EQ(plain.facts(), "Photo, 90 x 60 px") << name;
        ASSERT_EQ(plain.notes.size(), 1U) << name;
        EXPECT_TRUE(holds(plain.notes[0].text, "it is read as an ordinary photo"));
    }
    EXPECT_TRUE(holds(errorOf([&] {
                          static_cast<void>(opened("c_180.png", randomPhoto({90, 60}, 4)));
                      }),
                      "c_180.png: is made for headsets (VR)"));
    EXPECT_EQ(readDocument({directory / "c_180.png", {}, Reading::Photo}, display).facts(),
              "Photo, 90 x 60 px");
}

TEST(ViewerDocument, ThePngFileOfANativeSaysSoWhateverItsName) {
    const Display display = sampleDisplay({48, 64});
    const TemporaryDirectory directory;
    const cv::Mat native = detailedPhoto({48, 64});
    const auto documentAt = [&](const char* name, const Display& shownOn) {
        const fs::path file = directory / name;
        writeImage(file, native, ImageMark::Native);
        return readDocument({file, {}, Reading::Automatic}, shownOn);
    };
    EXPECT_EQ(documentAt("a_qs8x6a0.75_native.png", display).kind, Kind::Native);
    EXPECT_EQ(documentAt("a_rgbd_native.png", display).kind, Kind::Native);
    const Document other = documentAt("a.png", sampleDisplay({96, 128}));
    EXPECT_EQ(other.kind, Kind::Scene);
    ASSERT_EQ(other.notes.size(), 1U);
    EXPECT_TRUE(holds(other.notes[0].text, "but not of this display's 96 x 128 px"));
}

TEST(ViewerDocument, DepthThatComesWithAPhotoIsUsed) {
    const Display display = sampleDisplay({48, 64});
    const TemporaryDirectory directory;
    const cv::Mat photo = detailedPhoto({90, 60});
    cv::Mat depth(60, 90, CV_32FC1);
    for (int x = 0; x < depth.cols; ++x)
        depth.col(x) = x / 89.0;
    writePhotoWithDepth(directory / "a.jpg", photo, depth);
    const Document inside = readDocument({directory / "a.jpg", {}, Reading::Automatic}, display);
    EXPECT_EQ(inside.facts(),
              "Photo, 90 x 60 px; depth in the photo's file (Dynamic Depth, 90 x 60 px)");
    EXPECT_GT(inside.rawDepth.at<float>(30, 85), inside.rawDepth.at<float>(30, 5));
    cv::Mat small(6, 9, CV_8UC1, cv::Scalar(7));
    writeImage(directory / "a_depth.png", small); // flat: of no use
    const Document flat = readDocument({directory / "a.jpg", {}, Reading::Automatic}, display);
    EXPECT_EQ(flat.facts(), inside.facts());
    ASSERT_FALSE(flat.notes.empty());
    EXPECT_TRUE(holds(flat.notes.back().text, "a_depth.png: is not used as depth: it is flat"));
    small.colRange(0, 4) = 90;
    writeImage(directory / "a_depth.png", small);
    const Document beside = readDocument({directory / "a.jpg", {}, Reading::Automatic}, display);
    EXPECT_EQ(beside.facts(), "Photo, 90 x 60 px; depth image beside the photo (" +
                                  (directory / "a_depth.png").string() + ")");
    EXPECT_EQ(beside.rawDepth.size(), cv::Size(9, 6));
}

TEST(ViewerDocument, StereoPairsGetTheirDepthByMatching) {
    const Display display = sampleDisplay({48, 64});
    const TemporaryDirectory directory;
    const Eyes eyes = wallAndThing(6, 26);
    writeImage(directory / "l.jpg", eyes.left);
    writeImage(directory / "r.jpg", eyes.right);
    spill(directory / "a.mpo", mpoFile(slurp(directory / "l.jpg"), slurp(directory / "r.jpg")));
    const Document mpo = readDocument({directory / "a.mpo", {}, Reading::Automatic}, display);
    EXPECT_EQ(mpo.facts().find("Photo, 400 x 300 px; stereo pair (MPO), depth by "
                               "matching; shift "),
              0u)
        << mpo.facts();
    EXPECT_TRUE(mpo.notes.empty()) << mpo.notes.front().text;
    EXPECT_EQ(mpo.rawDepth.size(), eyes.left.size());

    cv::Mat both;
    cv::vconcat(eyes.left, eyes.right, both);
    const fs::path file = directory / "x.png"; // states nothing
    writeImage(file, both);
    const Document stacked = documentOf({file, {}, Reading::EyesTopBottom}, both, display);
    EXPECT_TRUE(samePicture(stacked.picture, eyes.left));
    EXPECT_GT(stacked.rawDepth.at<float>(150, 200), stacked.rawDepth.at<float>(150, 350));

    // pictures that do not match are a photo with a remark
    const Document other =
        documentOf({file, {}, Reading::EyesLeftRight}, randomPhoto({400, 150}, 3), display);
    EXPECT_TRUE(other.rawDepth.empty());
    ASSERT_EQ(other.notes.size(), 1u);
    EXPECT_TRUE(holds(other.notes[0].text, "do not match"));
}

TEST(ViewerDocument, TheDesktopEntryListsTheTypesThatAreOpened) {
    QFile entry(QString::fromStdString(sourcePath("tools/viewer/altiro3Dview.desktop").string()));
    ASSERT_TRUE(entry.open(QIODevice::ReadOnly));
    QStringList listed;
    for (const QByteArray& line : entry.readAll().split('\n')) {
        if (line.startsWith("MimeType=")) listed = QString(line.mid(9)).split(';');
    }
    int known = 0;
    const auto expectListed = [&](const std::string& name) {
        const auto types = QMimeDatabase().mimeTypesForFileName(QString::fromStdString(name));
        if (types.isEmpty()) return; // mpo, pfm
        ++known;
        EXPECT_TRUE(std::any_of(types.begin(), types.end(), [&](const QMimeType& type) {
            return listed.contains(type.name());
        })) << name;
    };
    for (const std::string& ending : imageExtensions()) {
        expectListed("a" + ending);
        EXPECT_FALSE(isVideoName("a" + ending)) << ending;
    }
    for (const std::string& ending : tools::videoEndings()) {
        expectListed("a" + ending);
        EXPECT_TRUE(isVideoName("a" + ending)) << ending;
    }
    EXPECT_GT(known, 20); // the database is there
}

TEST(ViewerDocument, CamerasAreRecognizedAsCharacterDevices) {
    const TemporaryDirectory folder;
    const fs::path link = folder / "usb-camera-index0";
    fs::create_symlink("/dev/null", link); // a character device, as cameras are
    EXPECT_TRUE(isVideoName(link));
    EXPECT_TRUE(isVideoName("/dev/null"));
    spill(folder / "video0", "no device");
    EXPECT_FALSE(isVideoName(folder / "video0"));
    EXPECT_FALSE(isVideoName("/dev/video-that-is-not-there"));
}

TEST(ViewerDocument, PipesAreRefusedInsteadOfWaitedFor) {
    const TemporaryDirectory folder;
    const fs::path pipe = folder / "a.png"; // nobody writes into it
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    fs::create_symlink(pipe, folder / "b.mp4");
    writeImage(folder / "photo.png", detailedPhoto({48, 64}));
    const Display display = sampleDisplay({48, 64});
    for (const Source& source :
         {Source{pipe, {}, Reading::Automatic}, Source{folder / "b.mp4", {}, Reading::Automatic},
          Source{folder / "photo.png", pipe, Reading::Photo}}) {
        EXPECT_TRUE(thumbnailOf({pipe, {}, Reading::Automatic}, 8).isNull());
        try {
            readDocument(source, display);
            ADD_FAILURE() << source.file;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Unsupported);
            EXPECT_NE(std::string(error.what()).find("is a pipe"), std::string::npos);
        }
    }
}

TEST(ViewerDocument, AGivenReadingOverridesNameAndSize) {
    const Display display = sampleDisplay({48, 64});
    const Source photo{"anything.png", {}, Reading::Photo};
    EXPECT_EQ(documentOf(photo, detailedPhoto({48, 64}), display).kind, Kind::Scene);
    const Source top{"x.png", {}, Reading::RgbdTop};
    EXPECT_EQ(documentOf(top, detailedPhoto({40, 60}), display).picture.size(), cv::Size(40, 30));
}

TEST(ViewerDocument, QuiltsHaveTheLayoutOfTheirNames) {
    const Document quilt = documentOf({"a_qs5x2a0.75.png", {}, Reading::Automatic},
                                      detailedPhoto({52, 40}), sampleDisplay());
    EXPECT_EQ(quilt.layout, (QuiltLayout{5, 2, {10, 20}, 10}));
    EXPECT_EQ(quilt.picture.size(), cv::Size(50, 40)); // views of whole px
    EXPECT_TRUE(quilt.notes.empty());
    EXPECT_FALSE(quilt.certainty);
}

TEST(ViewerDocument, QuiltsWithoutANameAreFound) {
    const QuiltLayout layout{4, 5, {140, 100}, 20};
    cv::Mat picture;
    Depth2Quilt(layout).render({scenery({140, 100}, 3), randomDepth({140, 100})}, picture);
    const Document quilt =
        documentOf({"web.png", {}, Reading::Automatic}, picture, sampleDisplay());
    EXPECT_EQ(quilt.kind, Kind::Quilt);
    EXPECT_EQ(quilt.layout, layout);
    EXPECT_TRUE(holds(quilt.facts(), " % sure"));
    EXPECT_EQ(documentOf({"web.png", {}, Reading::Photo}, picture, sampleDisplay()).kind,
              Kind::Scene);
    EXPECT_EQ(
        documentOf({"web.png", {}, Reading::Automatic}, scenery({400, 300}, 3), sampleDisplay())
            .kind,
        Kind::Scene);
    // nothing to see: its size tells
    const auto kindOfGrey = [](cv::Size size) {
        const cv::Mat grey(size, CV_8UC3, cv::Scalar::all(90));
        return documentOf({"grey.png", {}, Reading::Automatic}, grey, sampleDisplay()).kind;
    };
    EXPECT_EQ(kindOfGrey(sampleDisplay().quilt.size()), Kind::Quilt);
    EXPECT_EQ(kindOfGrey({640, 480}), Kind::Scene);
}

TEST(ViewerDocument, ADirectoryOfViewsIsAQuilt) {
    const TemporaryDirectory folder;
    const Display display = sampleDisplay({48, 64});
    for (int i = 0; i < 48; ++i) {
        writeImage(folder / ("v" + std::to_string(i) + ".png"),
                   cv::Mat(40, 30, CV_8UC3, cv::Scalar::all(5 * i)));
    }
    const Document views = readDocument({folder.path(), {}, Reading::Automatic}, display);
    EXPECT_EQ(views.kind, Kind::Quilt);
    EXPECT_EQ(views.picture.at<cv::Vec3b>(views.layout.tile(47).tl())[0], 235);
}

TEST(ViewerDocument, PhotosOfAMovingCameraBecomeRealViews) {
    const TemporaryDirectory folder;
    const Boards boards;
    int number = 0;
    for (const HandCamera& camera : handSlide(shakyHand(16, 0.4)))
        writeImage(folder / ("IMG_" + std::to_string(number++) + ".png"),
                   boards.photograph({320, 240}, camera));
    const Display display = sampleDisplay({48, 64});
    const Document views = readDocument({folder.path(), {}, Reading::Slide}, display);
    EXPECT_EQ(views.kind, Kind::Quilt);
    EXPECT_FALSE(views.video);
    EXPECT_EQ(views.layout, display.quilt);
    EXPECT_TRUE(contains(textOf(views.notes), "pictures: 16 of 16 used"));
    EXPECT_TRUE(
        contains(errorOf([&] {
                     (void)readDocument({folder / "IMG_3.png", {}, Reading::Slide}, display);
                 }),
                 "IMG_3.png: holds 1 picture, expected a video or several photos"));
}

// The files of a folder by name, "photo+depth" for pairs.
std::vector<std::string> namesIn(const fs::path& folder) {
    std::vector<std::string> names;
    for (const Source& source : filesOfFolder(folder).files) {
        EXPECT_EQ(source.reading, Reading::Automatic);
        names.push_back(source.file.filename().string());
        if (!source.depth.empty()) names.back() += "+" + source.depth.filename().string();
    }
    return names;
}

TEST(ViewerDocument, AFolderIsItsFilesUnlessTheyAreViewsOfOneScene) {
    const TemporaryDirectory folder;
    const auto inFolder = [&](const std::string& name) { return folder / name; };
    EXPECT_TRUE(holds(errorOf([&] { filesOfFolder(folder.path()); }), "holds no pictures and no"));
    cv::Mat quilt;
    const QuiltLayout layout{4, 3, {60, 80}, 12};
    Depth2Quilt(layout).render({detailedPhoto({60, 80}), randomDepth({60, 80})}, quilt);
    for (int i = 0; i < layout.viewCount; ++i)
        writeImage(inFolder("v" + std::to_string(i) + ".png"), quilt(layout.tile(i)));
    EXPECT_EQ(filesOfFolder(folder.path()).files.front().file, folder.path());
    EXPECT_EQ(filesOfFolder(folder.path()).files.size(), 1U);
    for (const char* name : {"v12.png", "v5.png"}) { // after the last one; in place of another
        writeImage(inFolder(name), boxDepth(layout.tileSize));
        EXPECT_GT(filesOfFolder(folder.path()).files.size(), 1U) << name;
        fs::remove(inFolder("v12.png"));
    }
    writeImage(inFolder("v5.png"), quilt(layout.tile(5)));
    spill(inFolder("notes.txt"), "x"); // such a file does not matter
    EXPECT_EQ(filesOfFolder(folder.path()).files.front().file, folder.path());

    const cv::Mat native(2048, 1536, CV_8UC3, cv::Scalar(1, 2, 3));
    writeImage(inFolder("n.png"), native, ImageMark::Native); // a Native is no view
    EXPECT_EQ(filesOfFolder(folder.path()).files.size(), 13U);

    const TemporaryDirectory photos;
    for (int i = 0; i < 5; ++i) {
        cv::Mat photo = scenery({90, 60}, 7 * i + 1);
        writeImage(photos / ("p" + std::to_string(i) + ".jpg"), photo);
    }
    writeImage(photos / "p2-depth.png", boxDepth({90, 60}));
    writeImage(photos / "x_depth.png", boxDepth({90, 60}));
    fs::create_directory(photos / "deeper");
    for (const char* name : {"a.mp4", "p1.mov", "q_qs8x6a0.75.png", ".hidden.jpg", "b.txt"})
        spill(photos / name, "x");
    EXPECT_EQ(namesIn(photos.path()),
              (std::vector<std::string>{"a.mp4", "p0.jpg", "p1.jpg", "p2.jpg+p2-depth.png",
                                        "p3.jpg", "p4.jpg", "q_qs8x6a0.75.png"}));
    const Notes notes = filesOfFolder(photos.path()).notes;
    ASSERT_EQ(notes.size(), 1U);
    EXPECT_EQ(notes[0].text, photos.path().string() + ": not opened: 1 .txt file, 1 Live Photo "
                                                      "clip, 1 depth image, 1 folder");
    EXPECT_EQ(errorOf([&] { filesOfFolder(photos / "none"); }),
              (photos / "none").string() + ": does not exist, expected a directory with pictures");
}

TEST(FolderSearch, AFolderThatCannotBeReadDoesNotEndTheSearch) {
    const TemporaryDirectory root;
    fs::permissions(root.path(), fs::perms::all);
    fs::create_directories(root / "closed/deeper");
    fs::create_directory(root / "open");
    for (const char* name : {"a.png", "open/b.png", "closed/c.png"})
        writeImage(root / name, scenery({30, 20}, 1));
    fs::permissions(root / "closed", fs::perms::none);
    const auto closed = [&] {
        std::error_code error;
        static_cast<void>(fs::directory_iterator(root / "closed", error));
        return static_cast<bool>(error);
    };
    tools::FolderSearch search;
    search.recursive = true;
    constexpr uid_t kNobody = 65534;
    const bool isRoot = geteuid() == 0; // whom nothing is closed to
    const bool isOther = isRoot && seteuid(kNobody) == 0;
    const bool isClosed = closed();
    tools::FolderContents found;
    std::string problem;
    if (isClosed) problem = errorOf([&] { found = tools::searchFolder(root.path(), search); });
    ASSERT_TRUE(!isOther || seteuid(0) == 0);
    fs::permissions(root / "closed", fs::perms::owner_all);
    if (!isClosed) GTEST_SKIP() << "this user may read every folder";
    EXPECT_EQ(problem, "(no error)");
    EXPECT_EQ(found.files.size(), 2U);
    ASSERT_EQ(found.leftOut.size(), 1U);
    EXPECT_EQ(found.leftOut[0].file, root / "closed");
    EXPECT_EQ(found.leftOut[0].why.find("cannot be searched: "), 0U) << found.leftOut[0].why;
    EXPECT_EQ(tools::kindsText(found.leftOut), "1 folder");
}

TEST(ViewerDocument, SixteenBitsAndGivenDepthAreRead) {
    const TemporaryDirectory folder;
    writeImage(folder / "p.png", cv::Mat(20, 10, CV_16UC3, cv::Scalar::all(257 * 100)));
    writeImage(folder / "p-depth.png", cv::Mat(20, 10, CV_16UC1, cv::Scalar(1000)));
    const Document document = readDocument(
        {folder / "p.png", folder / "p-depth.png", Reading::Automatic}, sampleDisplay());
    EXPECT_TRUE(samePicture(document.picture, cv::Mat(20, 10, CV_8UC3, cv::Scalar::all(100))));
    EXPECT_EQ(document.rawDepth.type(), CV_16UC1);
}

TEST(ViewerDocument, ADepthImageOfAVideoIsSaidToBeUnused) {
    const TemporaryDirectory folder;
    writeGreys(folder / "v.mkv", {64, 48}, 2);
    writeImage(folder / "d.png", cv::Mat(48, 64, CV_8UC1, cv::Scalar(9)));
    const Document document =
        readDocument({folder / "v.mkv", folder / "d.png", Reading::Automatic}, sampleDisplay());
    ASSERT_EQ(document.notes.size(), 1U);
    EXPECT_TRUE(holds(document.notes[0].text, "d.png: is not used"));
}

TEST(ViewerDocument, PhotosAndTheirDepthImagesBecomeOne) {
    const auto sources = pairUp(
        {"d/b-depth.png", "d/a.jpg", "d/b.jpg", "e/a-depth.png", "d/a_Depth.tif", "depth.png"});
    ASSERT_EQ(sources.size(), 4U);
    EXPECT_EQ(sources[0].file, "d/a.jpg");
    EXPECT_EQ(sources[0].depth, "d/a_Depth.tif");
    EXPECT_EQ(sources[1].file, "d/b.jpg");
    EXPECT_EQ(sources[1].depth, "d/b-depth.png");
    EXPECT_EQ(sources[2].file, "e/a-depth.png"); // of a photo elsewhere
    EXPECT_TRUE(sources[2].depth.empty());
    EXPECT_EQ(sources[3].file, "depth.png");
    EXPECT_EQ(pairUp({"clip.mp4", "clip-depth.mp4"}).size(), 2U); // a photo's, or none
    EXPECT_EQ(pairUp({"clip.jpg", "clip-depth.mp4"}).size(), 2U); // a depth video is no image
    const auto second = pairUp({"a_depth.png", "a.jpg", "a-depth.png"});
    ASSERT_EQ(second.size(), 2U);
    EXPECT_EQ(second[0].depth, "a_depth.png");
    EXPECT_EQ(second[1].file, "a-depth.png");
    const auto twins = pairUp({"a.heic", "a.jpg", "a disparity.png"});
    ASSERT_EQ(twins.size(), 2U);
    for (const Source& twin : twins)
        EXPECT_EQ(twin.depth, "a disparity.png");
}

// The volume that the window chooses, in a directory of its own.
class ViewerDisplay : public ::testing::Test {
  protected:
    void SetUp() override {
        QDir::setCurrent(QString::fromStdString(folder_.path().string()));
        qunsetenv("LKG_CALIBRATION");
        write("first.json", 100);
        write("second.json", 104);
    }
    void TearDown() override { QDir::setCurrent(before_); }
    // The sample with a panel of that width.
    void write(const char* name, int width) const {
        std::string text = slurp(sourcePath("calibration/portrait-sample.json"));
        text.replace(text.find("1536"), 4, std::to_string(width));
        spill(folder_ / name, text);
    }
    tools::ChosenDisplay find(bool firstWillDo, std::vector<const char*> arguments = {}) {
        tools::CommandLine commandLine("test", "");
        tools::addDisplayOptions(commandLine);
        arguments.insert(arguments.begin(), "test");
        commandLine.parse(static_cast<int>(arguments.size()),
                          const_cast<char**>(arguments.data())); // NOLINT: as main() has them
        const auto volumes = [this] {
            return std::vector<MountedCalibration>{{folder_ / "first.json", "LKG-1"},
                                                   {folder_ / "second.json", "LKG-2"}};
        };
        return tools::findDisplay(tools::displayOptions(commandLine), messages_,
                                  {volumes, firstWillDo});
    }

    TemporaryDirectory folder_;
    QString before_ = QDir::currentPath();
    tools::Messages messages_{"test", false};
};

TEST_F(ViewerDisplay, TakesTheFirstOfSeveralVolumesIfAnotherCanBeChosenLater) {
    EXPECT_THROW(find(false), Error);
    const tools::ChosenDisplay display = find(true);
    EXPECT_EQ(display.panelSize(), cv::Size(100, 2048));
    EXPECT_EQ(display.source, (folder_ / "first.json").string());
    ASSERT_FALSE(messages_.warnings().empty());
    EXPECT_TRUE(holds(messages_.warnings().front(), "LKG-1"));
    EXPECT_EQ(find(true, {"--serial", "LKG-2"}).panelSize().width, 104);
}

TEST_F(ViewerDisplay, WhatIsChosenOtherwiseComesBeforeVolumes) {
    write("visual.json", 108);
    EXPECT_EQ(find(true).panelSize().width, 108);
    ASSERT_FALSE(messages_.warnings().empty());
    EXPECT_EQ(messages_.warnings()[0].rfind("visual.json: is used, but a display with another ", 0),
              0U)
        << messages_.warnings()[0];
    EXPECT_EQ(find(true, {"-c", "second.json", "--invert", "on"}).invert, InvertViews::On);
}

TEST(ViewerKnobs, ColumnsAndRowsDivideTheDisplaysQuilt) {
    const Display display = sampleDisplay();
    Knobs knobs;
    EXPECT_EQ(layoutOf(knobs, display), display.quilt);
    knobs.columns = 5;
    knobs.rows = 9;
    EXPECT_EQ(layoutOf(knobs, display), (QuiltLayout{5, 9, {672, 373}, 45}));
}

} // namespace
} // namespace altiro3D::test
