#pragma once

#include <array>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace altiro3D::viewer {

/// A thread that runs the latest task of each kind: a task that has not begun is replaced by the
/// next one of its kind.
class Worker {
  public:
    static constexpr std::size_t kKinds = 3;

    Worker();
    /// Finishes the running task and drops the waiting ones.
    ~Worker();
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    /// Adds a task; waiting tasks of lower kinds run first.
    /// @param kind 0..kKinds-1 @param task must not throw
    void post(std::size_t kind, std::function<void()> task);

  private:
    void run();

    std::mutex mutex_;
    std::condition_variable wake_;
    std::array<std::function<void()>, kKinds> waiting_;
    bool ending_ = false;
    std::thread thread_; // last: it uses the others
};

} // namespace altiro3D::viewer
