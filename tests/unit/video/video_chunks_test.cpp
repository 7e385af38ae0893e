#include "altiro3D/video_conversion.hpp"

#include "support/displays.hpp"
#include "support/files.hpp"
#include "support/slow.hpp"
#include "support/video.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <gtest/gtest.h>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr int kSegmentFrames = 12; // of a clip of 2 frames a second

// A scene of its own for each seed, in which things move slowly.
cv::Mat scenePicture(int seed, int number) {
    cv::Mat large(80, 120, CV_8UC3);
    cv::RNG random(static_cast<std::uint64_t>(seed) * 77 + 5);
    large.setTo(cv::Scalar(random.uniform(0, 255), random.uniform(0, 255), random.uniform(0, 255)));
    for (int i = 0; i < 30; ++i) {
        const cv::Point at(random.uniform(0, 120), random.uniform(0, 80));
        const cv::Scalar colour(random.uniform(0, 255), random.uniform(0, 255),
                                random.uniform(0, 255));
        cv::circle(large, at + cv::Point(i % 3 * number / 4, 0), random.uniform(4, 14), colour,
                   cv::FILLED);
    }
    return large({number / 3 % 40, number / 5 % 30, 64, 48}).clone();
}

// What the frames of a clip are.
struct Clip {
    std::vector<int> scenes;   // their lengths in frames
    bool hasStills = false;    // every fifth frame equals the one before
    bool variableRate = false; // frames are 0.25 s and 1 s long
    int rate = 2;
};

void writeClip(const fs::path& file, const Clip& clip) {
    VideoWriterOptions options;
    options.size = {64, 48};
    options.codec = VideoCodec::Ffv1;
    options.frameRate = {clip.rate, 1};
    options.constantRate = !clip.variableRate;
    VideoWriter writer(file, options);
    std::int64_t pts = 0;
    int number = 0;
    for (std::size_t scene = 0; scene < clip.scenes.size(); ++scene) {
        for (int i = 0; i < clip.scenes[scene]; ++i, ++number) {
            const int shown = clip.hasStills && i % 5 == 4 ? i - 1 : i;
            const std::int64_t length =
                clip.variableRate ? (number % 3 == 0 ? 1000 : 250) : 1000 / clip.rate;
            writer.write({scenePicture(static_cast<int>(scene), shown), pts, length});
            pts += length;
        }
    }
    writer.finish();
}

Display smallDisplay() {
    return sixViewDisplay(48, 64, {24, 32});
}

class VideoChunksTest : public FileTest {
  protected:
    VideoConversion conversion(const std::string& output) const {
        VideoConversion all;
        all.input = directory / "clip.mkv";
        all.output = directory / output;
        all.display = smallDisplay();
        all.encoding.codec = VideoCodec::H264;
        all.encoding.preset = EncoderPreset::UltraFast;
        all.encoding.threads = 1;
        if (change) change(all);
        return all;
    }

    // The file of one run.
    std::string oneRun() const {
        VideoConverter(conversion("whole.mp4")).run();
        return slurp(conversion("whole.mp4").output);
    }

    VideoChunkPlan plan(double seconds) const {
        VideoChunkOptions options;
        options.seconds = seconds;
        return planVideoChunks(conversion("out.mp4"), folder(), options);
    }

    VideoConversionResult make(int number) const {
        return makeVideoChunk(conversion("out.mp4"), folder(), number);
    }

    std::string join() const {
        const fs::path output = conversion("out.mp4").output;
        fs::remove(output);
        joinVideoChunks(conversion("out.mp4"), folder());
        return slurp(output);
    }

    // The file of many machines; chunks are made in the plan's order or the other way round.
    std::string manyRuns(double seconds, bool backwards) const {
        fs::remove_all(folder());
        std::vector<int> numbers(plan(seconds).chunks.size());
        std::iota(numbers.begin(), numbers.end(), 1);
        if (backwards) std::reverse(numbers.begin(), numbers.end());
        for (const int number : numbers)
            make(number);
        return join();
    }

    // The first, third, ... lengths are made backwards.
    void expectSameBytes(const std::vector<double>& lengths) const {
        const std::string whole = oneRun();
        ASSERT_FALSE(whole.empty());
        bool isBackwards = false;
        for (const double seconds : lengths) {
            isBackwards = !isBackwards;
            EXPECT_TRUE(manyRuns(seconds, isBackwards) == whole)
                << seconds << " s, backwards " << isBackwards;
        }
    }

    fs::path folder() const { return directory / "plan"; }

    // The first file of a chunk with this ending.
    fs::path fileOf(int number, const std::string& ending) const {
        const std::string digits = std::to_string(number);
        const fs::path chunk = folder() / "chunks" / (std::string(6 - digits.size(), '0') + digits);
        for (const auto& entry : fs::directory_iterator(chunk))
            if (entry.path().extension() == ending) return entry.path();
        return {};
    }

    std::function<void(VideoConversion&)> change;
};

const Clip kFewScenes = {{14, 27, 9, 31, 13}};

TEST_F(VideoChunksTest, TheJoinedFileHasTheBytesOfOneRun) {
    ALTIRO3D_TAKES(5);
    writeClip(directory / "clip.mkv", kFewScenes);
    expectSameBytes({1, 13, 30, 1000});
}

TEST_F(VideoChunksTest, ASceneMayBeLongerThanManyChunks) {
    ALTIRO3D_TAKES(3);
    Clip clip{{7, 90, 10}};
    clip.hasStills = true;
    writeClip(directory / "clip.mkv", clip);
    expectSameBytes({6, 20});
}

TEST_F(VideoChunksTest, FramesMayHaveDifferentLengths) {
    ALTIRO3D_TAKES(3);
    Clip clip = kFewScenes;
    clip.variableRate = true;
    writeClip(directory / "clip.mkv", clip);
    expectSameBytes({1, 13});
}

TEST_F(VideoChunksTest, ChoicesHoldForTheirScene) {
    ALTIRO3D_TAKES(4);
    writeClip(directory / "clip.mkv", kFewScenes);
    change = [](VideoConversion& all) { all.recipe.choices = {true, true, true}; };
    expectSameBytes({1, 13});
}

TEST_F(VideoChunksTest, APartOfAVideoIsDividedAlike) {
    ALTIRO3D_TAKES(3);
    writeClip(directory / "clip.mkv", kFewScenes);
    change = [](VideoConversion& all) {
        all.part.from = 7.3;
        all.part.to = 40;
    };
    expectSameBytes({6});
}

TEST_F(VideoChunksTest, OtherCodecsAndProductsAreDividedAlike) {
    ALTIRO3D_TAKES(6);
    writeClip(directory / "clip.mkv", kFewScenes);
    change = [](VideoConversion& all) {
        all.product = VideoProduct::Rgbd;
        all.encoding.preset = EncoderPreset::VeryFast; // reorders pictures
    };
    expectSameBytes({6});
    change = [](VideoConversion& all) {
        all.product = VideoProduct::Quilt;
        all.encoding.codec = VideoCodec::ProRes;
        all.output.replace_extension(".mov");
    };
    expectSameBytes({6});
    change = [](VideoConversion& all) { all.product = VideoProduct::Stereo; };
    expectSameBytes({6});
}

TEST_F(VideoChunksTest, GivenDepthIsDividedAlike) {
    ALTIRO3D_TAKES(20);
    Clip clip{{60, 190}}; // its flaws are measured in each scene
    clip.hasStills = true;
    writeClip(directory / "clip.mkv", clip);
    writeClip(directory / "depth.mkv", {{90, 160}});
    for (const DepthKind kind : {DepthKind::NearWhite, DepthKind::Metric}) {
        for (const bool choices : {false, true}) {
            change = [&, kind, choices](VideoConversion& all) {
                all.given.emplace().source = directory / "depth.mkv";
                all.given->kind = kind;
                if (choices) all.recipe.choices = {true, true, false};
            };
            expectSameBytes({13});
        }
    }
    change = [](VideoConversion& all) { all.given.emplace().rgbd = DepthSide::Right; };
    expectSameBytes({13});
}

TEST_F(VideoChunksTest, DepthOf16BitsIsMeasuredOnceForAllChunks) {
    writeClip(directory / "clip.mkv", {{120}});
    fs::create_directory(directory / "depth");
    for (int i = 0; i < 3; ++i) {
        cv::Mat depth(24, 32, CV_16UC1);
        for (int x = 0; x < depth.cols; ++x)
            depth.col(x).setTo(1000 * i + 50 * x);
        writeImage(directory / "depth" / (std::to_string(i) + ".png"), depth);
    }
    std::atomic<int> reads{0};
    change = [&](VideoConversion& all) {
        all.given.emplace().source = directory / "depth";
        all.given->read = [&](const fs::path& file, Notes* notes) {
            ++reads;
            return readDepthSamples(file, notes);
        };
    };
    expectSameBytes({6});
    plan(6);
    EXPECT_TRUE(holds(slurp(folder() / "plan.json"), "depth range"));
    reads = 0;
    make(1);
    const std::int64_t whole = readVideoChunks(folder()).chunks[0].frames;
    EXPECT_LE(reads, whole + 1); // the frames, and the shape
}

TEST_F(VideoChunksTest, FramesThatAreQuiltsAreDividedAlike) {
    writeClip(directory / "clip.mkv", kFewScenes);
    change = [](VideoConversion& all) {
        all.fromQuilt = true;
        QuiltLayout& layout = all.layout.emplace(all.display->quilt);
        layout.columns = 2;
        layout.viewCount = 4;
        layout.tileSize = {32, 24};
    };
    expectSameBytes({6});
    EXPECT_EQ(plan(6).repeatedFrames, 0); // they have no depth to carry
}

TEST_F(VideoChunksTest, ChunksAreTheVideoAndBeginSoonAfterCuts) {
    // cuts just before the borders of the 2nd, 5th and 6th segment
    writeClip(directory / "clip.mkv", {{11, 35, 13, 60}});
    const VideoChunkPlan made = plan(12);
    EXPECT_EQ(made.frames, 119);
    EXPECT_NEAR(made.end, 59.5, 1e-9);
    EXPECT_FALSE(made.cancelled);
    std::vector<VideoChunk> chunks = made.chunks;
    const auto work = [](const VideoChunk& chunk) {
        return static_cast<double>(chunk.frames) +
               0.3 * static_cast<double>(chunk.first - chunk.begin);
    };
    EXPECT_TRUE(
        std::is_sorted(chunks.begin(), chunks.end(), [&](const VideoChunk& a, const VideoChunk& b) {
            return work(a) > work(b);
        }));
    std::sort(chunks.begin(), chunks.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    std::int64_t at = 0;
    const std::vector<std::int64_t> starts = {0, 11, 46, 59}; // of the scenes
    for (const VideoChunk& chunk : chunks) {
        EXPECT_EQ(chunk.first, at);
        EXPECT_EQ(chunk.first % kSegmentFrames, 0);
        EXPECT_EQ(chunk.begin, *(std::upper_bound(starts.begin(), starts.end(), chunk.first) - 1));
        EXPECT_NEAR(chunk.start, static_cast<double>(chunk.first) / 2, 1e-9);
        EXPECT_NEAR(chunk.end - chunk.start, static_cast<double>(chunk.frames) / 2, 1e-9);
        at += chunk.frames;
    }
    EXPECT_EQ(at, made.frames);
    const VideoChunkPlan again = readVideoChunks(folder());
    ASSERT_EQ(again.chunks.size(), made.chunks.size());
    EXPECT_EQ(again.repeatedFrames, made.repeatedFrames);
    EXPECT_EQ(again.threads, cv::getNumThreads());
}

TEST_F(VideoChunksTest, OneChunkMakesTheDepthOfALongScene) {
    ALTIRO3D_TAKES(3);
    writeClip(directory / "clip.mkv", {{100}});
    const VideoChunkPlan made = plan(6);
    ASSERT_GT(made.chunks.size(), 6u);
    EXPECT_EQ(made.chunks.front().frames, 0);
    EXPECT_EQ(made.chunks.front().begin, 0);
    const auto inPictures = std::count_if(made.chunks.begin(), made.chunks.end(),
                                          [](const auto& chunk) { return chunk.frames > 0; });
    EXPECT_EQ(static_cast<std::size_t>(inPictures), made.chunks.size() - 1);
    EXPECT_EQ(made.repeatedFrames, made.chunks.front().first);
    make(1);
    EXPECT_TRUE(isVideoChunkMade(folder(), 1));
    EXPECT_TRUE(holds(
        errorOf([&] { join(); }),
        " yet, expected chunks 2.." +
            std::to_string(made.chunks.size()))); // the join needs the chunks with pictures only
    for (std::size_t i = 1; i < made.chunks.size(); ++i) {
        // with the states that it has left, no depth is made twice: each chunk estimates the depth
        // of its own frames only
        const VideoConversionResult result = make(static_cast<int>(i) + 1);
        EXPECT_LE(result.pipeline.stages.at(0).frames, made.chunks[i].frames);
        EXPECT_EQ(result.frames, made.chunks[i].frames);
    }
    EXPECT_TRUE(join() == oneRun());
}

TEST_F(VideoChunksTest, DamagedStatesAreNotUsed) {
    ALTIRO3D_TAKES(4);
    writeClip(directory / "clip.mkv", {{100}});
    const std::size_t count = plan(6).chunks.size();
    make(1);
    for (const auto& entry : fs::directory_iterator(folder() / "states")) {
        std::string bytes = slurp(entry.path());
        bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
        spill(entry.path(), bytes);
    }
    for (std::size_t i = 1; i < count; ++i)
        make(static_cast<int>(i) + 1);
    EXPECT_TRUE(join() == oneRun());
}

TEST_F(VideoChunksTest, AChunkThatIsMadeIsNotMadeAgain) {
    writeClip(directory / "clip.mkv", kFewScenes);
    const VideoChunkPlan made = plan(30);
    EXPECT_FALSE(isVideoChunkMade(folder(), 1));
    EXPECT_EQ(make(1).keptFrames, 0);
    EXPECT_TRUE(isVideoChunkMade(folder(), 1));
    const auto time = fs::last_write_time(fileOf(1, ".mp4"));
    const VideoConversionResult again = make(1);
    EXPECT_EQ(again.keptFrames, made.chunks[0].frames);
    EXPECT_EQ(fs::last_write_time(fileOf(1, ".mp4")), time);
    EXPECT_TRUE(holds(errorOf([&] { make(0); }), "chunk: is 0, expected 1.."));
    EXPECT_TRUE(holds(errorOf([&] { make(99); }), "chunk: is 99, expected 1.."));
}

TEST_F(VideoChunksTest, JoiningNamesChunksThatAreNotMade) {
    ALTIRO3D_TAKES(3);
    writeClip(directory / "clip.mkv", kFewScenes);
    const std::size_t count = plan(12).chunks.size();
    ASSERT_GT(count, 3u);
    for (int number = 1; number <= static_cast<int>(count); ++number)
        if (number != 2 && number != 4) make(number);
    EXPECT_TRUE(holds(errorOf([&] { join(); }),
                      "has no chunks 2, 4 yet, expected chunks 1.." + std::to_string(count)));
    EXPECT_FALSE(fs::exists(directory / "out.mp4"));
    make(2);
    make(4);
    EXPECT_TRUE(join() == oneRun());
    EXPECT_TRUE(join() == oneRun()); // a second join
}

TEST_F(VideoChunksTest, ADamagedChunkIsNamedAndCanBeMadeAgain) {
    ALTIRO3D_TAKES(4);
    writeClip(directory / "clip.mkv", kFewScenes);
    const std::size_t count = plan(30).chunks.size();
    for (int number = 1; number <= static_cast<int>(count); ++number)
        make(number);
    const std::string whole = join();
    const fs::path segment = fileOf(1, ".mp4");
    const std::string good = slurp(segment);
    std::string flipped = good;
    flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 0x10);
    for (const std::string& bad : {flipped, good.substr(0, good.size() - 7), std::string()}) {
        spill(segment, bad);
        const std::string error = errorOf([&] { join(); });
        EXPECT_TRUE(startsWith(error, segment.string() + ": "));
        EXPECT_TRUE(holds(error, "make this chunk again"));
        EXPECT_FALSE(fs::exists(directory / "out.mp4"));
        EXPECT_FALSE(isVideoChunkMade(folder(), 1)); // a scheduler sees that it must be made
        EXPECT_TRUE(isVideoChunkMade(folder(), 2));
        EXPECT_EQ(make(1).keptFrames, 0);
        EXPECT_TRUE(join() == whole);
    }
    for (const char* bad : {"{}", "[", "", "{\"format\":\"altiro3D video chunk\"}"}) {
        spill(fileOf(1, ".json"), bad);
        EXPECT_TRUE(holds(errorOf([&] { join(); }), "chunk.json: "));
        EXPECT_FALSE(isVideoChunkMade(folder(), 1));
        make(1);
        EXPECT_TRUE(join() == whole);
    }
}

TEST_F(VideoChunksTest, AnotherConversionOrInputIsRefused) {
    writeClip(directory / "clip.mkv", kFewScenes);
    plan(30);
    make(1);
    change = [](VideoConversion& all) { all.encoding.crf = 20; };
    const auto isRefused = [&](const std::string& what) {
        for (const std::function<void()>& call :
             {std::function<void()>([&] { make(2); }), std::function<void()>([&] { join(); }),
              std::function<void()>([&] { plan(30); })}) {
            const std::string error = errorOf(call);
            EXPECT_TRUE(startsWith(error, folder().string() + ": "));
            EXPECT_TRUE(holds(error, "with other settings (" + what));
        }
    };
    isRefused("encoder was ");
    change = [](VideoConversion& all) { all.encoding.maxRate = 50; };
    isRefused("encoder was ");
    change = {};
    EXPECT_TRUE(holds(errorOf([&] { plan(40); }), "length of chunks was 30 and is 40"));
    const int threads = cv::getNumThreads();
    cv::setNumThreads(threads == 1 ? 2 : 1);
    isRefused("threads of OpenCV was ");
    cv::setNumThreads(threads);
    fs::last_write_time(directory / "clip.mkv",
                        fs::last_write_time(directory / "clip.mkv") + std::chrono::seconds(1));
    isRefused("the file of the video has changed)");
    EXPECT_FALSE(fs::exists(folder() / "chunks" / "000002"));
}

TEST_F(VideoChunksTest, ChunksOfAnotherPlanDoNotCount) {
    writeClip(directory / "clip.mkv", kFewScenes);
    plan(30);
    make(1);
    fs::rename(folder() / "chunks", directory / "old");
    change = [](VideoConversion& all) {
        all.encoding.crf = 20;
        all.unfinished = UnfinishedRun::Discard;
    };
    plan(30);
    fs::remove_all(folder() / "chunks");
    fs::rename(directory / "old", folder() / "chunks");
    EXPECT_FALSE(isVideoChunkMade(folder(), 1));
    EXPECT_EQ(make(1).keptFrames, 0);
}

TEST_F(VideoChunksTest, PlansAreKeptAndOtherFoldersAreLeftAlone) {
    writeClip(directory / "clip.mkv", kFewScenes);
    EXPECT_TRUE(holds(errorOf([&] { return readVideoChunks(folder()); }), "holds no plan"));
    plan(30);
    const std::string text = slurp(folder() / "plan.json");
    make(1);
    plan(30);
    EXPECT_EQ(slurp(folder() / "plan.json"), text);
    EXPECT_TRUE(isVideoChunkMade(folder(), 1));
    for (const std::string& bad : {std::string("{}"), text.substr(0, text.size() / 2),
                                   std::string("{\"format\":\"altiro3D video plan\"}")}) {
        spill(folder() / "plan.json", bad);
        EXPECT_TRUE(holds(errorOf([&] { make(1); }), "plan.json: "));
    }
    const fs::path mine = directory / "mine";
    fs::create_directory(mine);
    spill(mine / "letter.txt", "dear");
    EXPECT_TRUE(holds(errorOf([&] { return planVideoChunks(conversion("out.mp4"), mine); }),
                      "holds other files (letter.txt), expected a new folder"));
    EXPECT_EQ(std::distance(fs::directory_iterator(mine), fs::directory_iterator()), 1);
}

TEST_F(VideoChunksTest, CancellingLeavesNothing) {
    ALTIRO3D_TAKES(3);
    writeClip(directory / "clip.mkv", kFewScenes);
    const auto stop = [](const VideoProgress& progress) { return progress.frames < 3; };
    VideoChunkOptions options;
    options.seconds = 30;
    EXPECT_TRUE(planVideoChunks(conversion("out.mp4"), folder(), options, stop).cancelled);
    EXPECT_FALSE(fs::exists(folder() / "plan.json"));
    const std::size_t count = plan(30).chunks.size();
    EXPECT_TRUE(makeVideoChunk(conversion("out.mp4"), folder(), 1, stop).cancelled);
    EXPECT_TRUE(fs::is_empty(folder() / "chunks"));
    for (int number = 1; number <= static_cast<int>(count); ++number)
        make(number);
    EXPECT_TRUE(joinVideoChunks(conversion("out.mp4"), folder(), stop).cancelled);
    EXPECT_FALSE(fs::exists(directory / "out.mp4"));
    EXPECT_FALSE(fs::exists(directory / "out.mp4.part"));
    EXPECT_TRUE(join() == oneRun());
}

TEST_F(VideoChunksTest, AnInputThatCanBeReadOnceIsRefused) {
    writeClip(directory / "clip.mkv", kFewScenes);
    if (fs::is_character_file("/dev/null")) {
        change = [](VideoConversion& all) { all.input = "/dev/null"; };
        EXPECT_TRUE(
            holds(errorOf([&] { plan(30); }), "/dev/null: can be read only once, expected a file"));
        change = {};
    }
    EXPECT_TRUE(holds(errorOf([&] { plan(0); }), "seconds: is 0, expected 1..86400"));
}

} // namespace
} // namespace altiro3D::test
