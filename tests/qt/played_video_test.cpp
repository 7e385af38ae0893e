// A video on the display is what video2native writes: frame by frame, the same bytes.

#include "altiro3D/depth_map.hpp"
#include "support/random_pictures.hpp"
#include "support/video.hpp"
#include "viewer/model/depth_maker.hpp"
#include "viewer/model/studio.hpp"
#include "viewer/show/slide_presenter.hpp"
#include "viewer_scenes.hpp"

#include <climits>
#include <gtest/gtest.h>
#include <set>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

constexpr int kWidth = 160;
constexpr int kHeight = 120;

// A box that moves before a wall, and its depth, whose edges lie outside the box's.
struct Take {
    int seed = 1;
    int grown = 0;           // px
    int least = 0, most = 0; // depth, of 255
    int frames = 0;
    bool isNight = true; // a bright box before a dark wall; else exchanged and not sharp
};

std::vector<cv::Mat> photosOf(const Take& take, std::vector<cv::Mat>& depths) {
    cv::Mat wall = randomPhoto({kWidth, kHeight}, take.seed);
    wall *= 0.3;
    std::vector<cv::Mat> photos;
    for (int i = 0; i < take.frames; ++i) {
        const cv::Rect box(40 + i % 20, 30, 50, 60);
        cv::Mat photo = wall.clone();
        cv::Mat bright = photo(box);
        bright += cv::Scalar(40, 150, 160);
        if (!take.isNight) {
            cv::bitwise_not(photo, photo);
            cv::GaussianBlur(photo, photo, {0, 0}, 1.5);
        }
        photos.push_back(photo);
        cv::Mat depth(photo.size(), CV_8UC1, cv::Scalar(take.least));
        depth(cv::Rect(box.x - take.grown, box.y - take.grown, box.width + 2 * take.grown,
                       box.height + 2 * take.grown)) = take.most;
        depths.push_back(depth);
    }
    return photos;
}

class PlayedVideo : public ::testing::Test {
  protected:
    // With photo and depth side by side, or the photos alone.
    void writeTakes(const fs::path& file, const std::vector<Take>& takes, bool hasDepth) {
        std::vector<cv::Mat> pictures;
        std::set<double> growths;
        for (const Take& take : takes) {
            std::vector<cv::Mat> depths;
            std::vector<cv::Mat> photos = photosOf(take, depths);
            cv::Mat depth;
            depths.front().convertTo(depth, CV_32F, 1 / 255.0);
            growths.insert(measureDepthFlaws(photos.front(), depth).growthPixels);
            for (std::size_t i = 0; i < photos.size(); ++i) {
                cv::Mat picture = photos[i];
                if (hasDepth) {
                    cv::cvtColor(depths[i], depth, cv::COLOR_GRAY2BGR);
                    cv::hconcat(photos[i], depth, picture);
                }
                pictures.push_back(picture);
            }
        }
        EXPECT_EQ(growths.size(), takes.size()) << "each take has flaws of its own";
        writeClip(file, pictures, 25);
    }

    // The colours and the depth of takes as two streams of a file, the depth with its title.
    void writeTrack(const fs::path& file, const std::vector<Take>& takes, const char* pixels) {
        writeTakes(folder_ / "halves.mkv", takes, true);
        const std::string side = std::to_string(kWidth);
        ffmpeg(
            "-i " + arg(folder_ / "halves.mkv") + " -filter_complex '[0:v]split[a][b];[a]crop=" +
            side + ":ih:0:0[c];[b]crop=" + side + ":ih:" + side + ":0,format=" + pixels +
            "[d]' -map '[c]' -map '[d]' -c:v ffv1 -pix_fmt:v:0 bgr0 -metadata:s:v:1 title=depth " +
            arg(file));
    }

    void expectSame(const fs::path& video, const QStringList& options, const Knobs& knobs) {
        const QStringList call{"-y", "-c", writeSample(folder_ / "c.json", display_->panelSize()),
                               "--codec", "ffv1"};
        const fs::path written = folder_ / "native.mkv";
        ASSERT_EQ(QProcess::execute(ALTIRO3D_TOOL_VIDEO2NATIVE,
                                    call + options + QStringList{toName(video), toName(written)}),
                  0);
        const Source source{video, {}, Reading::Automatic};
        const auto depthMaker = std::make_shared<DepthMaker>();
        const Document first = readDocument(source, *display_);
        PlayedDepth depth(depthMaker);
        Studio studio(depthMaker);
        int scene = 0;
        const auto inWindow = [&](const cv::Mat& picture, double seconds) {
            auto document = std::make_shared<Document>(documentOfFrame(first, picture, *display_));
            depth.next(*document, knobs.depth, seconds);
            scene = document->scene;
            Request request{document, knobs, display_};
            request.mode = Mode::Native;
            request.area = {INT_MAX, INT_MAX};
            return studio.render(request).picture.clone();
        };
        SlideMaker maker(display_, {});
        const Slide slide = maker.make(source);
        ASSERT_EQ(slide.problem, "");

        VideoReader reader(video, readingOf(source));
        VideoFrame frame;
        int number = 0;
        for (const VideoFrame& native : allFrames(written)) {
            ASSERT_TRUE(reader.read(frame));
            const double time = static_cast<double>(frame.pts) * reader.facts().timeBase.value();
            EXPECT_EQ(cv::norm(inWindow(frame.picture, time), native.picture, cv::NORM_INF), 0)
                << "in the window, frame " << number;
            if (knobs == ofVideo(Knobs())) { // a slide show has no others
                const cv::Mat shown = slide.nativeOfFrame(frame.picture, time);
                EXPECT_EQ(cv::norm(shown, native.picture, cv::NORM_INF), 0)
                    << "in the show, frame " << number;
            }
            if (HasFailure()) return;
            ++number;
        }
        EXPECT_FALSE(reader.read(frame));
        EXPECT_EQ(scene, 2); // its flaws were measured again
    }

    TemporaryDirectory folder_;
    std::shared_ptr<const Display> display_ =
        std::make_shared<const Display>(sampleDisplay({96, 128}));
};

TEST_F(PlayedVideo, IsTheWrittenOneWithItsOwnDepth) {
    writeTakes(folder_ / "clip_rgbd.mkv", {{1, 3, 40, 200, 5}, {2, 0, 0, 255, 4, false}}, true);
    const QStringList options{"--rgbd", "right"};
    expectSame(folder_ / "clip_rgbd.mkv", options, ofVideo(Knobs()));
    Knobs knobs = ofVideo(Knobs());
    knobs.choices.focus = true;
    expectSame(folder_ / "clip_rgbd.mkv", options + QStringList{"--focus", "auto"}, knobs);
}

TEST_F(PlayedVideo, IsTheWrittenOneWithDepthOfATrack) {
    for (const char* const pixels : {"gray", "gray10le", "gray16le"}) {
        writeTrack(folder_ / "track.mkv", {{1, 3, 40, 200, 5}, {2, 0, 0, 255, 4, false}}, pixels);
        expectSame(folder_ / "track.mkv", {}, ofVideo(Knobs()));
    }
}

TEST_F(PlayedVideo, IsTheWrittenOneWithEstimatedDepth) {
    writeTakes(folder_ / "clip.mkv", {{1, 3, 40, 200, 4}, {2, 0, 0, 255, 4, false}}, false);
    expectSame(folder_ / "clip.mkv", {}, ofVideo(Knobs()));
}

} // namespace
} // namespace altiro3D::test
