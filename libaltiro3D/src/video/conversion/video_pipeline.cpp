#include "video/conversion/video_pipeline.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

namespace altiro3D {

namespace {

using Clock = std::chrono::steady_clock;
using FramePointer = std::unique_ptr<PipelineFrame>;

double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// Frames between two stages.
class FrameQueue {
  public:
    FrameQueue(std::size_t most, bool dropLate) : most_(most), dropLate_(dropLate) {}

    // Waits for space; false if the queue was cancelled.
    bool push(FramePointer frame) {
        std::unique_lock<std::mutex> lock(mutex_);
        while (dropLate_ && frames_.size() >= most_) {
            frames_.pop_front();
            ++dropped_;
        }
        changed_.wait(lock, [&] { return frames_.size() < most_ || cancelled_; });
        if (cancelled_) return false;
        frames_.push_back(std::move(frame));
        changed_.notify_all();
        return true;
    }

    // Waits for a frame; null at the end.
    FramePointer pop() {
        std::unique_lock<std::mutex> lock(mutex_);
        changed_.wait(lock, [&] { return !frames_.empty() || ended_ || cancelled_; });
        if (cancelled_ || frames_.empty()) return nullptr;
        FramePointer frame = std::move(frames_.front());
        frames_.pop_front();
        changed_.notify_all();
        return frame;
    }

    // Marks the end: no more frames follow.
    void end() { set(ended_); }
    // Wakes all waiting threads and refuses further frames.
    void cancel() { set(cancelled_); }

    std::int64_t dropped() const { return dropped_; }

  private:
    void set(bool& flag) {
        const std::lock_guard<std::mutex> lock(mutex_);
        flag = true;
        changed_.notify_all();
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<FramePointer> frames_;
    std::size_t most_;
    bool dropLate_;
    bool ended_ = false;
    bool cancelled_ = false;
    std::int64_t dropped_ = 0;
};

bool work(const PipelineStage& stage, PipelineFrame& frame, StageReport& report) {
    const Clock::time_point start = Clock::now();
    if (!stage.work(frame)) return false;
    const double seconds = secondsSince(start);
    report.seconds += seconds;
    report.longest = std::max(report.longest, seconds);
    ++report.frames;
    return true;
}

} // namespace

PipelineReport runPipeline(const std::vector<PipelineStage>& stages,
                           const PipelineOptions& options) {
    const Clock::time_point start = Clock::now();
    PipelineReport report;
    for (const PipelineStage& stage : stages)
        report.stages.push_back({stage.name, 0, 0, 0});
    std::vector<std::unique_ptr<FrameQueue>> queues; // queue i is before stage i + 1
    for (std::size_t i = 0; i + 1 < stages.size(); ++i) {
        queues.push_back(
            std::make_unique<FrameQueue>(options.queueFrames, options.dropLate && i == 0));
    }
    std::mutex mutex;
    std::exception_ptr failure; // the first one
    const auto keepFailure = [&] {
        {
            const std::lock_guard<std::mutex> lock(mutex);
            if (!failure) failure = std::current_exception();
        }
        for (const auto& queue : queues)
            queue->cancel();
    };
    const auto runStage = [&](std::size_t i) {
        try {
            for (std::int64_t number = 0;; ++number) {
                FramePointer frame =
                    i == 0 ? std::make_unique<PipelineFrame>() : queues[i - 1]->pop();
                if (!frame) break;
                if (i == 0) frame->number = number;
                if (!work(stages[i], *frame, report.stages[i])) break;
                if (i + 1 < stages.size() && !queues[i]->push(std::move(frame))) break;
            }
            if (i > 0) queues[i - 1]->cancel(); // ended early: earlier stages must not wait
            if (i < queues.size()) queues[i]->end();
        } catch (...) {
            keepFailure();
        }
    };
    std::vector<std::thread> threads;
    try {
        for (std::size_t i = 0; i + 1 < stages.size(); ++i)
            threads.emplace_back(runStage, i);
        runStage(stages.size() - 1); // does nothing if an earlier stage has failed
    } catch (...) {                  // no thread could be created
        keepFailure();
    }
    for (std::thread& thread : threads)
        thread.join();
    for (const auto& queue : queues)
        report.dropped += queue->dropped();
    if (failure) std::rethrow_exception(failure);
    report.seconds = secondsSince(start);
    return report;
}

} // namespace altiro3D
