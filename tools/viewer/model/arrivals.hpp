#pragma once

#include <QObject>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <utility>

namespace altiro3D::viewer {

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
