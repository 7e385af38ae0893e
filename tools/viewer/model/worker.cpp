#include "viewer/model/worker.hpp"

#include <utility>

namespace altiro3D::viewer {

Worker::Worker() : thread_([this] { run(); }) {}

Worker::~Worker() {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        ending_ = true;
    }
    wake_.notify_one();
    thread_.join();
}

void Worker::post(std::size_t kind, std::function<void()> task) {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        std::swap(waiting_[kind], task); // the replaced task is destroyed after the lock
    }
    wake_.notify_one();
}

void Worker::run() {
    std::size_t last = kKinds; // the kind that ran last
    const auto next = [&] {    // kKinds if none waits
        std::size_t repeated = kKinds;
        for (std::size_t kind = 0; kind < kKinds; ++kind) {
            if (!waiting_[kind]) continue;
            if (kind != last) return kind;
            repeated = kind;
        }
        return repeated;
    };
    for (;;) {
        std::function<void()> task;
        {
            std::unique_lock<std::mutex> lock(mutex_);
            wake_.wait(lock, [&] { return ending_ || next() != kKinds; });
            if (ending_) return;
            last = next();
            std::swap(task, waiting_[last]);
        }
        task();
    }
}

} // namespace altiro3D::viewer
