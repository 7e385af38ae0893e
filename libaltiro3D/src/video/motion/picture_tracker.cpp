#include "video/motion/picture_tracker.hpp"

#include "base/state_bytes.hpp"
#include "image/downscale.hpp"
#include "image/pixel_values.hpp"
#include "video/motion/motion_metrics.hpp"
#include "video/motion/motion_search.hpp"
#include "video/motion/small_image.hpp"

#include <cstddef>
#include <cstring>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

// Standard deviation of grey levels below which a picture is blank.
constexpr double kBlank = 3;

} // namespace

std::uint64_t pictureHash(const cv::Mat& picture) {
    const std::size_t rowBytes = static_cast<std::size_t>(picture.cols) * picture.elemSize();
    std::vector<std::uint64_t> rows(static_cast<std::size_t>(picture.rows));
    cv::parallel_for_(cv::Range(0, picture.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            const char* row = reinterpret_cast<const char*>(picture.ptr(y));
            rows[static_cast<std::size_t>(y)] = checksum({row, rowBytes});
        }
    });
    std::uint64_t total = 0;
    for (const std::uint64_t row : rows)
        total = mixIn(total, row);
    return total;
}

bool areEqual(const cv::Mat& a, const cv::Mat& b) {
    return a.size() == b.size() && a.type() == b.type() && a.isContinuous() && b.isContinuous() &&
           std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

PictureTracker::Step PictureTracker::next(const cv::Mat& picture) {
    Step step;
    const std::uint64_t hash = pictureHash(picture);
    const bool sameSize = picture.rows == rows_ && picture.cols == cols_;
    step.repeated = sameSize && hash == hash_;
    if (step.repeated) return step;
    hash_ = hash;
    rows_ = picture.rows;
    cols_ = picture.cols;

    const cv::Mat grey = brightnessOf(smallImage(picture));
    step.cut = !sameSize;
    step.blank = sameSize && contrastOf(grey) < kBlank;
    if (step.blank) return step;
    if (!step.cut) {
        findMotion(grey_, grey, step.motion);
        const cv::Mat misfits = misfit(grey_, grey, step.motion);
        step.cut = dissimilarity(grey_, grey, step.motion, misfits) > kNewScene;
    }
    if (step.cut) step.motion = cv::Mat();
    grey_ = grey;
    return step;
}

void PictureTracker::save(std::string& bytes) const {
    append(bytes, static_cast<std::uint64_t>(rows_));
    append(bytes, static_cast<std::uint64_t>(cols_));
    append(bytes, hash_);
    append(bytes, grey_);
}

bool PictureTracker::load(std::string_view& bytes) {
    std::uint64_t rows = 0;
    std::uint64_t cols = 0;
    constexpr std::uint64_t kMax = std::numeric_limits<int>::max();
    if (!take(bytes, rows) || !take(bytes, cols) || !take(bytes, hash_) ||
        !take(bytes, CV_8UC1, grey_)) {
        return false;
    }
    if (rows > kMax || cols > kMax || (rows == 0) != (cols == 0)) return false;
    rows_ = static_cast<int>(rows);
    cols_ = static_cast<int>(cols);
    // The grey copy of the next picture has that size and is compared with it px by px.
    return grey_.size() == downscaledSize({cols_, rows_}, kSmallSide);
}

} // namespace altiro3D
