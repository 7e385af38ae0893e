#include "video/conversion/video_pipeline.hpp"

#include <atomic>
#include <chrono>
#include <future>
#include <gtest/gtest.h>
#include <mutex>
#include <opencv2/core.hpp>
#include <set>
#include <stdexcept>
#include <thread>

namespace altiro3D::test {
namespace {

using namespace std::chrono_literals;

// A first stage that gives so many frames, each with its number in a picture.
PipelineStage source(std::int64_t count) {
    return {"decode", [count](PipelineFrame& frame) {
                if (frame.number == count) return false;
                frame.source.picture.create(4, 4, CV_8UC3);
                frame.source.picture = cv::Scalar::all(static_cast<double>(frame.number % 251));
                frame.source.pts = 10 * frame.number;
                return true;
            }};
}

PipelineOptions withQueue(int queue) {
    PipelineOptions options;
    options.queueFrames = queue;
    return options;
}

TEST(Pipeline, EveryFramePassesEveryStageInOrder) {
    std::vector<std::int64_t> seen;
    std::vector<double> values;
    const PipelineReport report =
        runPipeline({source(500),
                     {"render",
                      [](PipelineFrame& frame) {
                          cv::add(frame.source.picture, cv::Scalar::all(1), frame.result.picture);
                          return true;
                      }},
                     {"encode",
                      [&](PipelineFrame& frame) {
                          seen.push_back(frame.number);
                          values.push_back(frame.result.picture.at<cv::Vec3b>(3, 3)[2]);
                          EXPECT_EQ(frame.source.pts, 10 * frame.number);
                          return true;
                      }}},
                    withQueue(1));
    ASSERT_EQ(seen.size(), 500u);
    for (std::size_t i = 0; i < seen.size(); ++i) {
        EXPECT_EQ(seen[i], static_cast<std::int64_t>(i));
        EXPECT_EQ(values[i], static_cast<double>(i % 251 + 1));
    }
    ASSERT_EQ(report.stages.size(), 3u);
    EXPECT_EQ(report.stages[1].name, "render");
    for (const StageReport& stage : report.stages) {
        EXPECT_EQ(stage.frames, 500);
        EXPECT_GE(stage.seconds, stage.longest);
    }
    EXPECT_EQ(report.dropped, 0);
}

TEST(Pipeline, APictureThatIsKeptIsNotWrittenOver) {
    std::vector<cv::Mat> kept;
    runPipeline({source(60),
                 {"keep",
                  [&](PipelineFrame& frame) {
                      kept.push_back(frame.source.picture); // shares memory
                      return true;
                  }},
                 {"end", [](PipelineFrame&) { return true; }}});
    ASSERT_EQ(kept.size(), 60u);
    for (std::size_t i = 0; i < kept.size(); ++i)
        EXPECT_EQ(static_cast<std::size_t>(kept[i].at<cv::Vec3b>(0, 0)[0]), i);
}

TEST(Pipeline, StagesWorkSideBySideAndWaitingFramesAreFew) {
    std::mutex mutex;
    std::set<std::thread::id> threads;
    std::atomic<int> inFlight{0};
    std::atomic<int> most{0};
    const auto note = [&] {
        const std::lock_guard<std::mutex> lock(mutex);
        threads.insert(std::this_thread::get_id());
    };
    PipelineStage first = source(100);
    const auto give = first.work;
    first.work = [&](PipelineFrame& frame) {
        note();
        if (!give(frame)) return false;
        const int now = ++inFlight;
        int before = most.load();
        while (now > before && !most.compare_exchange_weak(before, now)) {
        }
        return true;
    };
    runPipeline({first,
                 {"middle",
                  [&](PipelineFrame&) {
                      note();
                      return true;
                  }},
                 {"slow",
                  [&](PipelineFrame&) {
                      note();
                      std::this_thread::sleep_for(200us);
                      --inFlight;
                      return true;
                  }}},
                withQueue(2));
    EXPECT_EQ(threads.size(), 3u);
    EXPECT_LE(most.load(), 2 + 2 + 3); // two queues of two, and one in each stage
}

TEST(Pipeline, AStagesFailureStopsAllAndIsThrown) {
    for (std::size_t bad = 0; bad < 3; ++bad) {
        std::vector<PipelineStage> stages = {source(1000000),
                                             {"b", [](PipelineFrame&) { return true; }},
                                             {"c", [](PipelineFrame&) { return true; }}};
        const auto before = stages[bad].work;
        stages[bad].work = [before](PipelineFrame& frame) {
            if (frame.number == 20) throw std::runtime_error("the disk is full");
            return before(frame);
        };
        try {
            runPipeline(stages, withQueue(3));
            FAIL() << "no exception";
        } catch (const std::runtime_error& error) {
            EXPECT_STREQ(error.what(), "the disk is full");
        }
    }
}

TEST(Pipeline, OfTwoFailuresAtOnceOneIsThrown) {
    const auto failing = [](PipelineFrame&) -> bool { throw std::runtime_error("gone"); };
    for (int i = 0; i < 50; ++i) { // the second comes while threads are still being started
        EXPECT_THROW(runPipeline({{"a", failing}, {"b", failing}, source(3)}), std::runtime_error);
        EXPECT_THROW(runPipeline({source(1), {"b", failing}, {"c", failing}}), std::runtime_error);
    }
}

// The second stage keeps its first frame until the source has come to its end.
TEST(Pipeline, ALiveSourceIsNeverHeldUpAndTheNewestFrameWins) {
    std::promise<void> kept;
    std::promise<void> ended;
    const auto inTime = [](std::promise<void>& event) {
        return event.get_future().wait_for(60s) == std::future_status::ready;
    };
    PipelineOptions options = withQueue(1);
    options.dropLate = true;
    PipelineStage live = source(100);
    live.work = [&, give = live.work](PipelineFrame& frame) {
        if (frame.number == 1) {
            EXPECT_TRUE(inTime(kept));
        }
        if (give(frame)) return true;
        ended.set_value();
        return false;
    };
    std::vector<std::int64_t> seen;
    const PipelineReport report = runPipeline({live,
                                               {"slow",
                                                [&](PipelineFrame& frame) {
                                                    if (seen.empty()) {
                                                        kept.set_value();
                                                        EXPECT_TRUE(inTime(ended)) << "held up";
                                                    }
                                                    seen.push_back(frame.number);
                                                    return true;
                                                }}},
                                              options);
    EXPECT_EQ(seen, (std::vector<std::int64_t>{0, 99}));
    EXPECT_EQ(report.dropped, 98);
    EXPECT_EQ(report.stages[0].frames, 100);
}

TEST(Pipeline, AnyStageMayEndTheRun) {
    for (const std::size_t last : {std::size_t{1}, std::size_t{2}}) {
        std::int64_t done = 0;
        std::vector<PipelineStage> stages = {source(1000000),
                                             {"b", [](PipelineFrame&) { return true; }},
                                             {"c", [](PipelineFrame&) { return true; }},
                                             {"d", [&](PipelineFrame&) {
                                                  ++done;
                                                  return true;
                                              }}};
        stages[last].work = [](PipelineFrame& frame) { return frame.number < 20; };
        runPipeline(stages, withQueue(1));
        EXPECT_EQ(done, 20) << last;
    }
}

TEST(Pipeline, OneStageIsEnough) {
    EXPECT_EQ(runPipeline({source(7)}).stages[0].frames, 7);
    EXPECT_EQ(runPipeline({source(0), {"b", [](PipelineFrame&) { return true; }}}).stages[1].frames,
              0);
}

} // namespace
} // namespace altiro3D::test
