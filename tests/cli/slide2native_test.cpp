// slide2native: real views from a camera that moves sideways.

#include "altiro3D/altiro3D.hpp"
#include "sandbox.hpp"
#include "support/hand_slide.hpp"
#include "support/video.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

const cv::Size kSize(320, 240);
constexpr int kPictures = 24;

std::vector<cv::Mat> picturesOf(const std::vector<HandCamera>& cameras) {
    static const Boards boards;
    std::vector<cv::Mat> pictures;
    for (const HandCamera& camera : cameras)
        pictures.push_back(boards.photograph(kSize, camera));
    return pictures;
}

// The column of the fourth part of a picture's rows that is most like that of another one.
double shiftBetween(const cv::Mat& from, const cv::Mat& to) {
    cv::Mat a;
    cv::Mat b;
    cv::cvtColor(from, a, cv::COLOR_BGR2GRAY);
    cv::cvtColor(to, b, cv::COLOR_BGR2GRAY);
    const int margin = a.cols / 4;
    const cv::Mat part = a(cv::Rect(margin, a.rows * 3 / 5, a.cols / 2, a.rows / 5));
    cv::Mat like;
    cv::matchTemplate(b.rowRange(a.rows * 3 / 5, a.rows * 3 / 5 + a.rows / 5), part, like,
                      cv::TM_CCOEFF_NORMED);
    cv::Point best;
    cv::minMaxLoc(like, nullptr, nullptr, nullptr, &best);
    return best.x - margin;
}

} // namespace

class Slide2Native : public StudioTest {
  protected:
    Slide2Native() : StudioTest("slide2native") {}

    // A clip of a slide, H.264 as cameras write it.
    void writeClip(const std::string& name, const std::vector<cv::Mat>& pictures) const {
        VideoWriterOptions options;
        options.size = pictures.front().size();
        options.compatible = true;
        options.timeBase = {1, 30};
        VideoWriter writer(studio_ / name, options);
        std::int64_t time = 0;
        for (const cv::Mat& picture : pictures)
            writer.write({picture, time++, 1});
        writer.finish();
    }
    void writePhotos(const std::string& folder, const std::vector<cv::Mat>& pictures) const {
        fs::create_directory(studio_ / folder);
        for (std::size_t i = 0; i < pictures.size(); ++i)
            writeImage(studio_ / folder / ("IMG_" + std::to_string(i) + ".png"), pictures[i]);
    }
    // A calibration and a layout whose views are large enough to look at.
    Outcome slide(const Arguments& more) const {
        return run(Arguments("-c small.json -q 3x4 -r 200x150 -y") + more);
    }
    static std::vector<cv::Mat> shaky(int pictures = kPictures) {
        return picturesOf(handSlide(shakyHand(pictures, 0.4)));
    }
};

TEST_F(Slide2Native, MakesANativeOfAClipWithAllOutputs) {
    writeClip("clip.mp4", shaky());
    const Outcome made = slide("--save-quilt q.png --save-views row --save-stereo e_LRF.png "
                               "--lg v.mp4 --seconds 0.4 --save-photo p.png --save-depth d.png "
                               "--save-splats s.spz clip.mp4 n.png");
    EXPECT_TRUE(says(made, "pictures: 24 of 24 used"));
    for (const char* line :
         {"path: parallax ", "from left to right", "residual: ", "speed: ", "focus: depth "})
        EXPECT_TRUE(says(made, line));
    const cv::Size photo = readBack(studio_ / "p.png").size();
    EXPECT_GE(readSplats(studio_ / "s.spz").splats.size(), std::size_t(photo.area()));
    const cv::Mat quilt = readBack(studio_ / "q_qs4x3a0.75.png");
    ASSERT_EQ(quilt.size(), cv::Size(600, 600));
    const auto tile = [&](int view) { // 3 rows, from the bottom
        return quilt(cv::Rect(view % 4 * 150, (2 - view / 4) * 200, 150, 200));
    };
    for (int view = 1; view < 12; ++view) // what is near moves to the left
        EXPECT_LT(shiftBetween(tile(view - 1), tile(view)), 0) << view;
    EXPECT_TRUE(isDone(studio_.run("quilt2native", "-c small.json q_qs4x3a0.75.png of-quilt.png")));
    EXPECT_EQ(slurp(studio_ / "n.png"), slurp(studio_ / "of-quilt.png"));
    EXPECT_EQ(filesIn(studio_ / "row"), 12U);
    EXPECT_EQ(readBack(studio_ / "e_LRF.png").size(), cv::Size(300, 200));
    EXPECT_EQ(allFrames(studio_ / "v.mp4").size(), 24U);
    const cv::Mat depth = readBack(studio_ / "d.png");
    EXPECT_EQ(depth.type(), CV_16UC1);
    EXPECT_EQ(depth.size(), readBack(studio_ / "p.png").size());
    EXPECT_TRUE(isDone(studio_.run("photo2native", "-c small.json -d p.png d.png of-depth.png")));
}

TEST_F(Slide2Native, APhotoSetAndTheNearestPictures) {
    writePhotos("photos", shaky());
    EXPECT_TRUE(says(slide("--method nearest photos n.png"), "pictures: 24 of 24 used"));
    Arguments named;
    for (int i = 0; i < kPictures; ++i)
        named.push_back("photos/IMG_" + std::to_string(i) + ".png");
    EXPECT_TRUE(says(slide(named + Arguments{"n.png"}), "pictures: 24 of 24 used"));
    for (int i = 0; i < kPictures; ++i) // IMG_9990 to IMG_9999, IMG_0001 to IMG_0014
        fs::rename(studio_ / named[static_cast<std::size_t>(i)],
                   studio_ / "photos" /
                       (i < 10 ? "IMG_999" + std::to_string(i) + ".png"
                               : "IMG_00" + std::to_string(i - 9 + 100).substr(1) + ".png"));
    const Outcome around = slide("photos n.png");
    EXPECT_TRUE(warns(around, "the first picture is IMG_9990.png"));
    EXPECT_NE(around.out.find("pictures: 24 of 24 used"), std::string::npos) << around.out;
    writeImage(studio_ / "photos/IMG_7.png", cv::Mat(kSize.width, kSize.height, CV_8UC3));
    EXPECT_TRUE(fails(slide("photos n.png"), 1,
                      "photos/IMG_7.png: has 240 x 320 px, expected like the first photo 320 x "
                      "240 px"));
}

TEST_F(Slide2Native, RefusesWhatIsNoSlide) { // all: CameraSlide
    writeClip("bad.mp4", picturesOf({HandCamera()}));
    EXPECT_TRUE(fails(slide("bad.mp4 n.png"), 1,
                      "bad.mp4: holds 1 picture, expected a video or several photos"));
    EXPECT_FALSE(fs::exists(studio_ / "n.png"));
}

TEST_F(Slide2Native, TellsAnUprightSlide) {
    std::vector<cv::Mat> pictures = shaky();
    for (cv::Mat& picture : pictures)
        cv::rotate(picture, picture, cv::ROTATE_90_CLOCKWISE);
    writeClip("upright.mp4", pictures);
    EXPECT_TRUE(warns(slide("upright.mp4 n.png"), "the camera moves upright: the pictures are "
                                                  "turned by a quarter"));
}

TEST_F(Slide2Native, WrongUsage) {
    EXPECT_TRUE(fails(slide("clip.mp4"), 2, "a video, a folder or photos, and OUT"));
    EXPECT_TRUE(fails(slide("--method best clip.mp4 n.png"), 2, "expected between or nearest"));
    EXPECT_TRUE(fails(slide("--turns 3 clip.mp4 n.png"), 2, "expected --lg with them"));
    EXPECT_TRUE(fails(slide("nothing.mp4 n.png"), 1, "nothing.mp4: does not exist"));
}

} // namespace altiro3D::test
