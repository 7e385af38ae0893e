#pragma once

#include <QObject>
#include <array>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <thread>
#include <utility>

namespace altiro3D::viewer {

/// Calls a function in the thread of an object, when its events are handled; not after its end.
template <typename Function>
void later(QObject* object, Function function) {
    QMetaObject::invokeMethod(object, std::move(function), Qt::QueuedConnection);
}

/// A thread that runs the latest task of each kind: a task that has not begun is replaced by the
/// next one of its kind. A kind that is posted without end leaves every other turn to the others.
class Worker {
  public:
    static constexpr std::size_t kKinds = 3;

    Worker();
    /// Finishes the running task and drops the waiting ones.
    ~Worker();
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    /// Adds a task; waiting tasks of lower kinds run first, but a kind does not run twice in a row
    /// while another one waits.
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

/// Pictures on their way from a thread that reads them to the one that shows them, one at a time.
class Arrivals : public QObject {
    Q_OBJECT
  public:
    /// @return false while the picture before has not been taken; then this one is dropped
    bool put(const cv::Mat& picture) {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            if (!next_.empty()) return false;
            next_ = picture;
        }
        emit arrived();
        return true;
    }
    bool isFree() {
        const std::lock_guard<std::mutex> lock(mutex_);
        return next_.empty();
    }
    /// The picture that waits; empty if none does.
    cv::Mat take() {
        const std::lock_guard<std::mutex> lock(mutex_);
        return std::exchange(next_, cv::Mat());
    }

  signals:
    void arrived();
    /// No more pictures come.
    void ended();

  private:
    std::mutex mutex_;
    cv::Mat next_;
};

} // namespace altiro3D::viewer
