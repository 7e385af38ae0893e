#include "altiro3D/depth2quilt.hpp"

#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "views/view_methods.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <exception>
#include <mutex>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

// Reports progress to a caller. Thread-safe; an exception of the caller's waits until finish(),
// because it must not leave cv::parallel_for_ from a thread of the pool.
class Progress {
  public:
    Progress(const QuiltProgressFunction& goOn, int steps) : goOn_(goOn), steps_(steps) {}

    [[nodiscard]] bool isStopped() const { return isStopped_; }

    void stepDone() {
        if (!goOn_) return;
        const std::lock_guard<std::mutex> locked(mutex_);
        ++done_;
        if (isStopped_) return;
        try {
            isStopped_ = !goOn_(static_cast<double>(done_) / steps_);
        } catch (...) {
            thrown_ = std::current_exception();
            isStopped_ = true;
        }
    }

    // @return false if the work was stopped
    [[nodiscard]] bool finish() const {
        if (thrown_) std::rethrow_exception(thrown_);
        return !isStopped_;
    }

  private:
    const QuiltProgressFunction& goOn_;
    int steps_;
    int done_ = 0;
    std::atomic<bool> isStopped_ = false;
    std::exception_ptr thrown_;
    std::mutex mutex_;
};

} // namespace

Depth2Quilt::Depth2Quilt(const QuiltLayout& layout, const ViewOptions& options)
    : layout_(layout), options_(options) {
    validate(layout);
    validate(options);
}

void Depth2Quilt::render(const Scene& scene, cv::Mat& quilt) const {
    render(scene, quilt, {});
}

bool Depth2Quilt::render(const Scene& scene, cv::Mat& quilt,
                         const QuiltProgressFunction& goOn) const try {
    const cv::Mat& photo = scene.photo;
    const std::unique_ptr<ViewRenderer> renderer = makeRenderer(scene, options_, 1);
    checkApart(quilt, scene, "quilt");
    orOutOfMemory("quilt",
                  "no memory for " + sizeText(layout_.size()) + ", expected a smaller layout",
                  [&] { quilt.create(layout_.size(), CV_8UC3); });
    for (int unused = layout_.viewCount; unused < layout_.columns * layout_.rows; ++unused) {
        quilt(layout_.tile(unused)).setTo(cv::Scalar::all(0));
    }
    const cv::Range shown = shownColumns(scene);
    std::vector<double> shifts;
    for (int i = 0; i < layout_.viewCount; ++i)
        shifts.push_back(shiftOf(options_, shown.size(), viewPosition(i, layout_.viewCount)));
    const bool hasMargins = shown.size() != photo.cols;
    const bool isTileSize = cv::Size(shown.size(), photo.rows) == layout_.tileSize;
    if (isTileSize && renderer->makesRows()) {
        const auto rowBytes = 3 * static_cast<std::size_t>(photo.cols);
        Progress progress(goOn, photo.rows);
        forRows(photo.rows, [&](const cv::Range& rows) {
            const std::unique_ptr<RowRenderer> rowRenderer = renderer->rowRenderer();
            std::vector<std::uint8_t> whole(hasMargins ? rowBytes * shifts.size() : 0);
            std::vector<std::uint8_t*> tiles(shifts.size());
            std::vector<std::uint8_t*> targets(shifts.size());
            for (std::size_t i = 0; hasMargins && i < targets.size(); ++i)
                targets[i] = whole.data() + i * rowBytes;
            for (int y = rows.start; y < rows.end && !progress.isStopped(); ++y) {
                for (int i = 0; i < layout_.viewCount; ++i) {
                    const cv::Point corner = layout_.tile(i).tl();
                    tiles[static_cast<std::size_t>(i)] =
                        quilt.ptr<std::uint8_t>(corner.y + y, corner.x);
                }
                rowRenderer->render(y, shifts, hasMargins ? targets : tiles);
                for (std::size_t i = 0; hasMargins && i < tiles.size(); ++i) {
                    std::memcpy(tiles[i], targets[i] + 3 * static_cast<std::ptrdiff_t>(shown.start),
                                3 * static_cast<std::size_t>(shown.size()));
                }
                progress.stepDone();
            }
        });
        return progress.finish();
    }
    const bool direct = isTileSize && !hasMargins;
    // the views at +-p in pairs
    const int pairCount = (layout_.viewCount + 1) / 2;
    Progress progress(goOn, pairCount);
    cv::parallel_for_(cv::Range(0, pairCount), [&](const cv::Range& pairs) {
        cv::Mat whole[2];
        for (int pair = pairs.start; pair < pairs.end && !progress.isStopped(); ++pair) {
            const int views[] = {layout_.viewCount - 1 - pair, pair};
            cv::Mat tiles[] = {quilt(layout_.tile(views[0])), quilt(layout_.tile(views[1]))};
            for (cv::Mat& view : whole)
                if (!direct) view.create(photo.size(), CV_8UC3);
            cv::Mat* made = direct ? tiles : whole;
            const double shift = shifts[static_cast<std::size_t>(views[0])];
            const double opposite = shifts[static_cast<std::size_t>(views[1])];
            if (shift == -opposite && shift != 0) {
                renderer->renderPair(shift, made[0], made[1]);
            } else {
                renderer->render(shift, made[0]);
                if (views[0] != views[1]) renderer->render(opposite, made[1]);
            }
            for (int i = 0; i < 2 && !direct; ++i)
                if (i == 0 || views[0] != views[1])
                    cv::resize(whole[i].colRange(shown), tiles[i], tiles[i].size(), 0, 0,
                               cv::INTER_AREA);
            progress.stepDone();
        }
    });
    return progress.finish();
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void Depth2Quilt::renderView(const Scene& scene, double position, cv::Mat& view) const try {
    checkNumber(std::isfinite(position), "position", position, "a finite number");
    const std::unique_ptr<ViewRenderer> renderer =
        makeRenderer(scene, options_, std::max(1.0, std::abs(position)));
    const cv::Range shown = shownColumns(scene);
    cv::Mat result(scene.photo.rows, shown.size(), CV_8UC3);
    renderShown(*renderer, scene.photo.size(), shown, shiftOf(options_, shown.size(), position),
                result);
    view = result;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
