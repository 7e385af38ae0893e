#include "viewer/model/worker.hpp"

#include <algorithm>
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
    const auto first = [this] {
        return std::find_if(waiting_.begin(), waiting_.end(),
                            [](const auto& task) { return static_cast<bool>(task); });
    };
    for (;;) {
        std::function<void()> task;
        {
            std::unique_lock<std::mutex> lock(mutex_);
            wake_.wait(lock, [&] { return ending_ || first() != waiting_.end(); });
            if (ending_) return;
            std::swap(task, *first());
        }
        task();
    }
}

} // namespace altiro3D::viewer
