#include "viewer/model/document.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/splats.hpp"
#include "cli/folders.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/hand_slide.hpp"
#include "support/photo_files.hpp"
#include "support/random_pictures.hpp"
#include "support/stereo_scene.hpp"
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

class ViewerDocument : public ::testing::Test {
  protected:
    Document read(const std::string& name, Reading reading = Reading::Automatic) const {
        return readDocument({folder_ / name, {}, reading}, display_);
    }
    Document documentOf(const std::string& name, const cv::Mat& picture,
                        Reading reading = Reading::Automatic) const {
        return viewer::documentOf({folder_ / name, {}, reading}, picture, display_);
    }

    TemporaryDirectory folder_;
    Display display_ = sampleDisplay({48, 64});
};

TEST_F(ViewerDocument, NameAndSizeTellWhatAPictureIs) {
    const auto kindOf = [&](const std::string& name, cv::Size size) {
        return documentOf(name, detailedPhoto(size)).kind;
    };
    EXPECT_EQ(kindOf("holiday.jpg", {90, 120}), Kind::Scene);
    EXPECT_EQ(kindOf("a_qs8x6a0.75.png", {80, 60}), Kind::Quilt);
    EXPECT_EQ(kindOf("anything.png", {48, 64}), Kind::Native);
    EXPECT_EQ(kindOf("camera.jpg", {48, 64}), Kind::Scene);
    EXPECT_EQ(kindOf("my_native.jpg", {48, 64}), Kind::Native);
    // a given reading comes first
    EXPECT_EQ(documentOf("anything.png", detailedPhoto({48, 64}), Reading::Photo).kind,
              Kind::Scene);
    EXPECT_EQ(documentOf("x.png", detailedPhoto({40, 60}), Reading::RgbdTop).picture.size(),
              cv::Size(40, 30));
    const Document rgbd = // a video
        documentOf("a_rgbd.mp4", detailedPhoto({90, 60}));
    EXPECT_EQ(rgbd.kind, Kind::Scene);
    EXPECT_EQ(rgbd.picture.size(), cv::Size(45, 60));
    EXPECT_FALSE(rgbd.rawDepth.empty());
    EXPECT_EQ(rgbd.facts(), "Video, 45 x 60 px, with depth");
}

TEST_F(ViewerDocument, NamesOfHalvesCountIfTheHalvesAgree) { // more of them: DepthSourceTest
    const auto opened = [&](const char* name, const cv::Mat& picture) {
        writeImage(folder_ / name, picture);
        return read(name);
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
    const cv::Mat photo = randomPhoto({90, 60}, 4);
    for (const char* name : {"b_LR.png", "b_rgbd.png"}) {
        const Document plain = opened(name, photo);
        EXPECT_EQ(plain.facts(), "Photo, 90 x 60 px") << name;
        ASSERT_EQ(plain.notes.size(), 1U) << name;
        EXPECT_TRUE(holds(plain.notes[0].text, "it is read as an ordinary photo"));
    }
    EXPECT_TRUE(holds(errorOf([&] { static_cast<void>(opened("c_180.png", photo)); }),
                      "c_180.png: is made for headsets (VR)"));
    EXPECT_EQ(read("c_180.png", Reading::Photo).facts(), "Photo, 90 x 60 px");
}

TEST_F(ViewerDocument, ThePngFileOfANativeSaysSoWhateverItsName) {
    const cv::Mat native = detailedPhoto({48, 64});
    const auto documentAt = [&](const char* name, const Display& shownOn) {
        const fs::path file = folder_ / name;
        writeImage(file, native, ImageMark::Native);
        return readDocument({file, {}, Reading::Automatic}, shownOn);
    };
    EXPECT_EQ(documentAt("a_qs8x6a0.75_native.png", display_).kind, Kind::Native);
    EXPECT_EQ(documentAt("a_rgbd_native.png", display_).kind, Kind::Native);
    const Document other = documentAt("a.png", sampleDisplay({96, 128}));
    EXPECT_EQ(other.kind, Kind::Scene);
    ASSERT_EQ(other.notes.size(), 1U);
    EXPECT_TRUE(holds(other.notes[0].text, "but not of this display's 96 x 128 px"));
}

TEST_F(ViewerDocument, DepthThatComesWithAPhotoIsUsed) {
    const cv::Mat photo = detailedPhoto({90, 60});
    cv::Mat depth(60, 90, CV_32FC1);
    for (int x = 0; x < depth.cols; ++x)
        depth.col(x) = x / 89.0;
    writePhotoWithDepth(folder_ / "a.jpg", photo, depth);
    const Document inside = read("a.jpg");
    EXPECT_EQ(inside.facts(),
              "Photo, 90 x 60 px; depth in the photo's file (Dynamic Depth, 90 x 60 px)");
    EXPECT_GT(inside.rawDepth.at<float>(30, 85), inside.rawDepth.at<float>(30, 5));
    cv::Mat small(6, 9, CV_8UC1, cv::Scalar(7));
    writeImage(folder_ / "a_depth.png", small); // flat: of no use
    const Document flat = read("a.jpg");
    EXPECT_EQ(flat.facts(), inside.facts());
    ASSERT_FALSE(flat.notes.empty());
    EXPECT_TRUE(holds(flat.notes.back().text, "a_depth.png: is not used as depth: it is flat"));
    small.colRange(0, 4) = 90;
    writeImage(folder_ / "a_depth.png", small);
    const Document beside = read("a.jpg");
    EXPECT_EQ(beside.facts(), "Photo, 90 x 60 px; depth image beside the photo (" +
                                  (folder_ / "a_depth.png").string() + ")");
    EXPECT_EQ(beside.rawDepth.size(), cv::Size(9, 6));
}

TEST_F(ViewerDocument, StereoPairsGetTheirDepthByMatching) {
    const Eyes eyes = wallAndThing(6, 26);
    writeImage(folder_ / "l.jpg", eyes.left);
    writeImage(folder_ / "r.jpg", eyes.right);
    spill(folder_ / "a.mpo", mpoFile(slurp(folder_ / "l.jpg"), slurp(folder_ / "r.jpg")));
    const Document mpo = read("a.mpo");
    EXPECT_EQ(mpo.facts().find("Photo, 400 x 300 px; stereo pair (MPO), depth by "
                               "matching; shift "),
              0u)
        << mpo.facts();
    EXPECT_TRUE(mpo.notes.empty()) << mpo.notes.front().text;
    EXPECT_EQ(mpo.rawDepth.size(), eyes.left.size());

    cv::Mat both;
    cv::vconcat(eyes.left, eyes.right, both);
    writeImage(folder_ / "x.png", both); // states nothing
    const Document stacked = documentOf("x.png", both, Reading::EyesTopBottom);
    EXPECT_TRUE(samePicture(stacked.picture, eyes.left));
    EXPECT_GT(stacked.rawDepth.at<float>(150, 200), stacked.rawDepth.at<float>(150, 350));

    // pictures that do not match are a photo with a remark
    const Document other = documentOf("x.png", randomPhoto({400, 150}, 3), Reading::EyesLeftRight);
    EXPECT_TRUE(other.rawDepth.empty());
    ASSERT_EQ(other.notes.size(), 1u);
    EXPECT_TRUE(holds(other.notes[0].text, "do not match"));
}

TEST_F(ViewerDocument, TheDesktopEntryListsTheTypesThatAreOpened) {
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
    for (const bool isVideo : {false, true}) {
        for (const std::string& ending : isVideo ? tools::videoEndings() : imageExtensions()) {
            expectListed("a" + ending);
            EXPECT_EQ(isVideoName("a" + ending), isVideo) << ending;
        }
    }
    EXPECT_GT(known, 20); // the database is there
}

TEST_F(ViewerDocument, CamerasAreRecognizedAsCharacterDevices) {
    const fs::path link = folder_ / "usb-camera-index0";
    fs::create_symlink("/dev/null", link); // a character device, as cameras are
    EXPECT_TRUE(isVideoName(link));
    EXPECT_TRUE(isVideoName("/dev/null"));
    spill(folder_ / "video0", "no device");
    EXPECT_FALSE(isVideoName(folder_ / "video0"));
    EXPECT_FALSE(isVideoName("/dev/video-that-is-not-there"));
}

TEST_F(ViewerDocument, PipesAreRefusedInsteadOfWaitedFor) {
    const fs::path pipe = folder_ / "a.png"; // nobody writes into it
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    fs::create_symlink(pipe, folder_ / "b.mp4");
    writeImage(folder_ / "photo.png", detailedPhoto({48, 64}));
    for (const Source& source :
         {Source{pipe, {}, Reading::Automatic}, Source{folder_ / "b.mp4", {}, Reading::Automatic},
          Source{folder_ / "photo.png", pipe, Reading::Photo}}) {
        EXPECT_TRUE(thumbnailOf({pipe, {}, Reading::Automatic}, 8).isNull());
        try {
            readDocument(source, display_);
            ADD_FAILURE() << source.file;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Unsupported);
            EXPECT_TRUE(holds(error.what(), "is a pipe"));
        }
    }
}

TEST_F(ViewerDocument, ScenesOfSplatsBecomeTheQuiltOfTheirViews) {
    Scene photo;
    photo.photo = detailedPhoto({40, 30});
    photo.depth = cv::Mat(30, 40, CV_32FC1, cv::Scalar(0.5));
    photo.depth.colRange(10, 20) = 1;
    const SplatScene splats = splatsOf(photo);
    writeSplats(folder_ / "a.ply", splats);
    const Document document = read("a.ply");
    EXPECT_EQ(document.kind, Kind::Quilt);
    const SplatCamera camera =
        chooseSplatCamera(splats, display_.quilt.tileSize, display_.aspect()).camera;
    const SplatRenderer renderer(splats, camera);
    cv::Mat quilt;
    renderQuilt(renderer, placeSplats(renderer.render(), camera, display_.quilt), display_.quilt,
                quilt);
    EXPECT_TRUE(samePicture(document.picture, quilt, 2)); // a .ply has opacities as logits
    EXPECT_TRUE(holds(textOf(document.notes), "that of the file"));
    EXPECT_EQ(codeOf([&] { (void)read("missing.splat"); }), ErrorCode::NotFound);
    // the photo that they were made of is not opened beside them
    const std::vector<Source> sources =
        pairUp({folder_ / "a.jpg", folder_ / "a.ply", folder_ / "b.jpg"});
    ASSERT_EQ(sources.size(), 2U);
    EXPECT_EQ(sources[0].file, folder_ / "a.ply");
    // other views of the same splats
    SplatSight sight;
    sight.layout = display_.quilt;
    sight.framing = {{0.75, 0.5}, 2}; // a quarter of a turn to the right
    SplatCameraOptions turned;
    turned.yaw = 90;
    SplatCamera side =
        chooseSplatCamera(splats, display_.quilt.tileSize, display_.aspect(), turned).camera;
    side.intrinsics.fx *= 2;
    side.intrinsics.fy *= 2;
    sight.isOneView = true;
    const Document seen = withSight(document, display_, sight);
    EXPECT_TRUE(samePicture(seen.picture, SplatRenderer(splats, side).render().picture, 2));
    EXPECT_EQ(seen.layout.viewCount, 1);
    sight.isOneView = false;
    sight.isDraft = true;
    EXPECT_EQ(withSight(document, display_, sight).layout.tileSize, display_.quilt.tileSize / 2);
}

TEST_F(ViewerDocument, QuiltsHaveTheLayoutOfTheirNames) {
    const Document quilt = documentOf("a_qs5x2a0.75.png", detailedPhoto({52, 40}));
    EXPECT_EQ(quilt.layout, (QuiltLayout{5, 2, {10, 20}, 10}));
    EXPECT_EQ(quilt.picture.size(), cv::Size(50, 40)); // views of whole px
    EXPECT_TRUE(quilt.notes.empty());
    EXPECT_FALSE(quilt.certainty);
}

TEST_F(ViewerDocument, QuiltsWithoutANameAreFound) {
    const QuiltLayout layout{4, 5, {140, 100}, 20};
    cv::Mat picture;
    Depth2Quilt(layout).render({scenery({140, 100}, 3), randomDepth({140, 100})}, picture);
    const Document quilt = documentOf("web.png", picture);
    EXPECT_EQ(quilt.kind, Kind::Quilt);
    EXPECT_EQ(quilt.layout, layout);
    EXPECT_TRUE(holds(quilt.facts(), " % sure"));
    EXPECT_EQ(documentOf("web.png", picture, Reading::Photo).kind, Kind::Scene);
    EXPECT_EQ(documentOf("web.png", scenery({400, 300}, 3)).kind, Kind::Scene);
    // nothing to see: its size tells
    display_ = sampleDisplay();
    const cv::Mat grey(display_.quilt.size(), CV_8UC3, cv::Scalar::all(90));
    EXPECT_EQ(documentOf("grey.png", grey).kind, Kind::Quilt);
    EXPECT_EQ(documentOf("grey.png", grey(cv::Rect(0, 0, 640, 480))).kind, Kind::Scene);
}

TEST_F(ViewerDocument, ADirectoryOfViewsIsAQuilt) {
    for (int i = 0; i < 48; ++i) {
        writeImage(folder_ / ("v" + std::to_string(i) + ".png"),
                   cv::Mat(40, 30, CV_8UC3, cv::Scalar::all(5 * i)));
    }
    const Document views = readDocument({folder_.path(), {}, Reading::Automatic}, display_);
    EXPECT_EQ(views.kind, Kind::Quilt);
    EXPECT_EQ(views.picture.at<cv::Vec3b>(views.layout.tile(47).tl())[0], 235);
}

TEST_F(ViewerDocument, PhotosOfAMovingCameraBecomeRealViews) {
    const Boards boards;
    int number = 9990;
    for (const HandCamera& camera : handSlide(shakyHand(16, 0.4))) {
        const std::string digits = std::to_string(10000 + number++ % 10000).substr(1);
        writeImage(folder_ / ("IMG_" + digits + ".png"), boards.photograph({320, 240}, camera));
    }
    const Document views = readDocument({folder_.path(), {}, Reading::Slide}, display_);
    EXPECT_EQ(views.kind, Kind::Quilt);
    EXPECT_FALSE(views.video);
    EXPECT_EQ(views.layout, display_.quilt);
    EXPECT_TRUE(holds(textOf(views.notes), "the first picture is IMG_9990.png"));
    EXPECT_TRUE(holds(textOf(views.notes), "pictures: 16 of 16 used"));
    EXPECT_TRUE(holds(errorOf([&] { (void)read("IMG_9993.png", Reading::Slide); }),
                      "IMG_9993.png: holds 1 picture, expected a video or several photos"));
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

TEST_F(ViewerDocument, AFolderIsItsFilesUnlessTheyAreViewsOfOneScene) {
    const auto inFolder = [&](const std::string& name) { return folder_ / name; };
    EXPECT_TRUE(holds(errorOf([&] { filesOfFolder(folder_.path()); }), "holds no pictures and no"));
    cv::Mat quilt;
    const QuiltLayout layout{4, 3, {60, 80}, 12};
    Depth2Quilt(layout).render({detailedPhoto({60, 80}), randomDepth({60, 80})}, quilt);
    for (int i = 0; i < layout.viewCount; ++i)
        writeImage(inFolder("v" + std::to_string(i) + ".png"), quilt(layout.tile(i)));
    EXPECT_EQ(filesOfFolder(folder_.path()).files.front().file, folder_.path());
    EXPECT_EQ(filesOfFolder(folder_.path()).files.size(), 1U);
    for (const char* name : {"v12.png", "v5.png"}) { // after the last one; in place of another
        writeImage(inFolder(name), boxDepth(layout.tileSize));
        EXPECT_GT(filesOfFolder(folder_.path()).files.size(), 1U) << name;
        fs::remove(inFolder("v12.png"));
    }
    writeImage(inFolder("v5.png"), quilt(layout.tile(5)));
    spill(inFolder("notes.txt"), "x"); // such a file does not matter
    EXPECT_EQ(filesOfFolder(folder_.path()).files.front().file, folder_.path());

    const cv::Mat native(2048, 1536, CV_8UC3, cv::Scalar(1, 2, 3));
    writeImage(inFolder("n.png"), native, ImageMark::Native); // a Native is no view
    EXPECT_EQ(filesOfFolder(folder_.path()).files.size(), 13U);

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

TEST_F(ViewerDocument, SixteenBitsAndGivenDepthAreRead) {
    writeImage(folder_ / "p.png", cv::Mat(20, 10, CV_16UC3, cv::Scalar::all(257 * 100)));
    writeImage(folder_ / "p-depth.png", cv::Mat(20, 10, CV_16UC1, cv::Scalar(1000)));
    const Document document = readDocument(
        {folder_ / "p.png", folder_ / "p-depth.png", Reading::Automatic}, sampleDisplay());
    EXPECT_TRUE(samePicture(document.picture, cv::Mat(20, 10, CV_8UC3, cv::Scalar::all(100))));
    EXPECT_EQ(document.rawDepth.type(), CV_16UC1);
}

TEST_F(ViewerDocument, ADepthImageOfAVideoIsSaidToBeUnused) {
    writeGreys(folder_ / "v.mkv", {64, 48}, 2);
    writeImage(folder_ / "d.png", cv::Mat(48, 64, CV_8UC1, cv::Scalar(9)));
    const Document document =
        readDocument({folder_ / "v.mkv", folder_ / "d.png", Reading::Automatic}, sampleDisplay());
    ASSERT_EQ(document.notes.size(), 1U);
    EXPECT_TRUE(holds(document.notes[0].text, "d.png: is not used"));
}

TEST(ViewerSources, PhotosAndTheirDepthImagesBecomeOne) {
    const auto paired = [](const std::vector<fs::path>& files) {
        std::string all;
        for (const Source& source : pairUp(files))
            all += source.file.string() + "+" + source.depth.string() + ";";
        return all;
    };
    EXPECT_EQ(paired({"d/b-depth.png", "d/a.jpg", "d/b.jpg", "e/a-depth.png", "d/a_Depth.tif",
                      "depth.png"}),
              "d/a.jpg+d/a_Depth.tif;d/b.jpg+d/b-depth.png;" // those of photos elsewhere:
              "e/a-depth.png+;depth.png+;");
    EXPECT_EQ(pairUp({"clip.mp4", "clip-depth.mp4"}).size(), 2U); // a photo's, or none
    EXPECT_EQ(pairUp({"clip.jpg", "clip-depth.mp4"}).size(), 2U); // a depth video is no image
    EXPECT_EQ(paired({"a_depth.png", "a.jpg", "a-depth.png"}), "a.jpg+a_depth.png;a-depth.png+;");
    EXPECT_EQ(paired({"a.heic", "a.jpg", "a disparity.png"}),
              "a.heic+a disparity.png;a.jpg+a disparity.png;");
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
        commandLine.parse({arguments.begin(), arguments.end()});
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
