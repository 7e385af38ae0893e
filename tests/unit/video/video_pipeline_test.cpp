#include "video/conversion/video_pipeline.hpp"

#include <atomic>
#include <chrono>
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
                return true;
            }};
}

PipelineOptions withQueue(int queue) {
    PipelineOptions options;
    options.queueFrames = queue;
    return options;
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

} // namespace
} // namespace altiro3D::test
