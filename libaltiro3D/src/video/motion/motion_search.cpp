#include "video/motion/motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

// The formulas are in docs/mathematics.md, section 5.

namespace altiro3D {

namespace {

constexpr int kWindow = 8;  // side of the compared windows, px
constexpr int kBorder = 24; // px repeated around a picture; limit of motion

// Costs are sums of kWindow^2 grey differences; these were tuned on the clips of docs/lab/video.md.
constexpr int kStillBonus = 48;     // advantage of no motion, so noise is not taken for motion
constexpr int kUnlikeNeighbour = 6; // per px of difference from the neighbours' motion
constexpr int kStillMisfit = 96;    // a still cell with less is not searched further

using Vector = cv::Point;

// One level of the pyramid with a repeated border.
struct Level {
    cv::Size size;
    cv::Mat padded; // [size + 2 kBorder, CV_8UC1]

    explicit Level(const cv::Mat& grey) : size(grey.size()) {
        cv::copyMakeBorder(grey, padded, kBorder, kBorder, kBorder, kBorder,
                           cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
    }
    const uchar* at(int x, int y) const { return padded.ptr(y + kBorder) + x + kBorder; }
};

// Sum of absolute differences of windows; arithmetic (eight bytes per row) limits the speed.
int windowDifference(const uchar* a, const uchar* b, std::size_t stepA, std::size_t stepB) {
    int sum = 0;
    for (int y = 0; y < kWindow; ++y, a += stepA, b += stepB)
        for (int x = 0; x < kWindow; ++x)
            sum += std::abs(a[x] - b[x]);
    return sum;
}

// Motion on one level of the pyramid, cell by cell in reading order.
class CellSearch {
  public:
    CellSearch(const Level& before, const Level& now)
        : before_(&before), now_(&now),
          cells_((now.size.height + kMotionCell - 1) / kMotionCell,
                 (now.size.width + kMotionCell - 1) / kMotionCell, Vector()) {}

    int columns() const { return cells_.cols; }
    int rows() const { return cells_.rows; }
    Vector& cell(int column, int row) { return cells_(row, column); }
    const Vector& nearestCell(int column, int row) const {
        return cells_(std::clamp(row, 0, rows() - 1), std::clamp(column, 0, columns() - 1));
    }

    // Tries all vectors within `reach` px.
    void searchAll(int reach) {
        forEachCell([&](int column, int row) {
            begin(column, row);
            for (int y = -reach; y <= reach; ++y)
                for (int x = -reach; x <= reach; ++x)
                    offer({x, y});
        });
    }

    // Searches around the vectors of the coarser level and of previous cells.
    void refine(const CellSearch& coarser) {
        refineFrom([&](int column, int row) {
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    const Vector& from = coarser.nearestCell(column / 2 + dx, row / 2 + dy);
                    offer({2 * from.x, 2 * from.y});
                }
            }
        });
    }

    // Searches around a given motion and the vectors of previous cells.
    void refine(const cv::Mat& motion) {
        refineFrom([&](int column, int row) {
            const auto& from = motion.at<cv::Vec2f>(
                std::min(kMotionCell * row + kMotionCell / 2, motion.rows - 1),
                std::min(kMotionCell * column + kMotionCell / 2, motion.cols - 1));
            offer({cvRound(from[0]), cvRound(from[1])});
        });
    }

    // Replaces each cell's motion by the median of 3 x 3 cells, separately for x and y.
    void smooth() {
        std::vector<cv::Mat> parts;
        cv::split(cells_, parts);
        for (cv::Mat& part : parts) {
            part.convertTo(part, CV_32F);
            cv::medianBlur(part, part, 3);
            part.convertTo(part, CV_32S);
        }
        cv::merge(parts, cells_);
    }

    // Refines a vector to fractions of px: where the costs of both sides, as straight lines, meet.
    cv::Vec2f betweenPixels(int column, int row) {
        const Vector at = cell(column, row);
        if (at == Vector{}) return {0, 0};
        windowX_ = kMotionCell * column - (kWindow - kMotionCell) / 2;
        windowY_ = kMotionCell * row - (kWindow - kMotionCell) / 2;
        const int centre = difference(at);
        const auto offset = [&](Vector low, Vector high) {
            const int lower = difference(low);
            const int higher = difference(high);
            const int steepest = std::max(lower, higher) - centre;
            if (steepest <= 0 || std::min(lower, higher) < centre) return 0.0F;
            return 0.5F * static_cast<float>(lower - higher) / static_cast<float>(steepest);
        };
        return {static_cast<float>(at.x) + offset({at.x - 1, at.y}, {at.x + 1, at.y}),
                static_cast<float>(at.y) + offset({at.x, at.y - 1}, {at.x, at.y + 1})};
    }

  private:
    template <class Visit>
    void forEachCell(Visit visit) {
        for (int row = 0; row < rows(); ++row) {
            for (int column = 0; column < columns(); ++column) {
                visit(column, row);
                cell(column, row) = best_;
            }
        }
    }

    template <class OfferSome>
    void refineFrom(OfferSome offerSome) {
        forEachCell([&](int column, int row) {
            begin(column, row);
            if (stillEnough()) return;
            offerSome(column, row);
            offer(left_);
            offer(above_);
            constexpr int kMaxSteps = 6;
            for (int step = 0; step < kMaxSteps; ++step) {
                const Vector centre = best_;
                for (int dy = -1; dy <= 1; ++dy)
                    for (int dx = -1; dx <= 1; ++dx)
                        offer({centre.x + dx, centre.y + dy});
                if (best_ == centre) break;
            }
        });
    }

    void begin(int column, int row) {
        windowX_ = kMotionCell * column - (kWindow - kMotionCell) / 2;
        windowY_ = kMotionCell * row - (kWindow - kMotionCell) / 2;
        left_ = column > 0 ? cell(column - 1, row) : Vector{};
        above_ = row > 0 ? cell(column, row - 1) : Vector{};
        best_ = {};
        stillDifference_ = difference(best_);
        leastCost_ = stillDifference_ - kStillBonus + unrest(best_);
    }

    bool stillEnough() const {
        return stillDifference_ <= kStillMisfit && left_ == Vector{} && above_ == Vector{};
    }

    void offer(Vector vector) {
        vector.x = std::clamp(vector.x, -kBorder - windowX_,
                              now_->size.width + kBorder - kWindow - windowX_);
        vector.y = std::clamp(vector.y, -kBorder - windowY_,
                              now_->size.height + kBorder - kWindow - windowY_);
        if (vector == best_ || vector == Vector{}) return;
        const int extra = unrest(vector);
        if (extra >= leastCost_) return;
        const int cost = difference(vector) + extra;
        if (cost >= leastCost_) return;
        leastCost_ = cost;
        best_ = vector;
    }

    // Cost of the difference from the neighbours' motion.
    int unrest(Vector vector) const {
        const auto distance = [&](Vector other) {
            return std::abs(vector.x - other.x) + std::abs(vector.y - other.y);
        };
        return kUnlikeNeighbour * std::min({distance(left_), distance(above_), 16});
    }

    // Pictures may be smaller than a window and border, so positions are clamped to the padding.
    int difference(Vector vector) const {
        const int x =
            std::clamp(windowX_ + vector.x, -kBorder, now_->size.width + kBorder - kWindow);
        const int y =
            std::clamp(windowY_ + vector.y, -kBorder, now_->size.height + kBorder - kWindow);
        return windowDifference(now_->at(windowX_, windowY_), before_->at(x, y), now_->padded.step,
                                before_->padded.step);
    }

    const Level* before_;
    const Level* now_;
    cv::Mat_<Vector> cells_;
    int windowX_ = 0;
    int windowY_ = 0;
    Vector left_;
    Vector above_;
    Vector best_;
    int stillDifference_ = 0;
    int leastCost_ = 0;
};

// The largest difference between four motions along x or y, px.
float spreadOf(const std::array<cv::Vec2f, 4>& motions) {
    float spread = 0;
    for (int i = 0; i < 2; ++i) {
        const auto bounds =
            std::minmax({motions[0][i], motions[1][i], motions[2][i], motions[3][i]});
        spread = std::max(spread, bounds.second - bounds.first);
    }
    return spread;
}

// Converts motion from cells to px: linear if the four surrounding cells move alike, else the
// vector that fits best.
void spread(CellSearch& search, const Level& before, const Level& now, cv::Mat& motion) {
    search.smooth();
    cv::Mat cells(search.rows(), search.columns(), CV_32FC2);
    for (int row = 0; row < cells.rows; ++row)
        for (int column = 0; column < cells.cols; ++column)
            cells.at<cv::Vec2f>(row, column) = search.betweenPixels(column, row);

    constexpr float kAlike = 1.5F;
    const auto misfitOf = [&](int x, int y, const cv::Vec2f& vector) {
        const int fromX = std::clamp(x + static_cast<int>(std::lround(vector[0])), 1 - kBorder,
                                     now.size.width + kBorder - 2);
        const int fromY = std::clamp(y + static_cast<int>(std::lround(vector[1])), 1 - kBorder,
                                     now.size.height + kBorder - 2);
        int sum = 0;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx)
                sum += std::abs(*now.at(x + dx, y + dy) - *before.at(fromX + dx, fromY + dy));
        return sum;
    };
    const auto placeOf = [](int pixel) {
        return (static_cast<float>(pixel) + 0.5F) / kMotionCell - 0.5F;
    };
    for (int y = 0; y < now.size.height; ++y) {
        auto* out = motion.ptr<cv::Vec2f>(y);
        const Between down = between(placeOf(y), cells.rows);
        const auto* above = cells.ptr<cv::Vec2f>(down.low);
        const auto* below = cells.ptr<cv::Vec2f>(down.high);
        std::array<cv::Vec2f, 4> around; // the motion of the four cells around px x
        float spread = 0;
        int low = -1; // the left two of them
        for (int x = 0; x < now.size.width; ++x) {
            const Between right = between(placeOf(x), cells.cols);
            if (right.low != low) {
                low = right.low;
                around = {above[low], above[right.high], below[low], below[right.high]};
                spread = spreadOf(around);
            }
            if (spread <= kAlike) {
                out[x] = spread == 0 ? around[0] : sampled<cv::Vec2f>(cells, right, down);
                continue;
            }
            int least = 0;
            for (std::size_t i = 0; i < around.size(); ++i) {
                const int sum = misfitOf(x, y, around[i]);
                if (i > 0 && sum >= least) continue;
                least = sum;
                out[x] = around[i];
            }
        }
    }
}

} // namespace

void findMotion(const cv::Mat& before, const cv::Mat& now, cv::Mat& motion) {
    motion.create(now.size(), CV_32FC2);
    std::vector<Level> befores{Level(matchedBrightness(before, now))};
    std::vector<Level> nows{Level(now)};
    constexpr int kCoarsestSide = 48;
    for (int side = std::max(now.cols, now.rows); side > kCoarsestSide; side = (side + 1) / 2) {
        const cv::Rect inside(cv::Point(kBorder, kBorder), nows.back().size);
        befores.emplace_back(halved(befores.back().padded(inside)));
        nows.emplace_back(halved(nows.back().padded(inside)));
    }
    CellSearch search(befores.back(), nows.back());
    constexpr int kReach = 6;
    search.searchAll(kReach);
    for (std::size_t level = nows.size() - 1; level-- > 0;) {
        CellSearch finer(befores[level], nows[level]);
        finer.refine(search);
        search = std::move(finer);
    }
    spread(search, befores.front(), nows.front(), motion);
}

void refineMotion(const cv::Mat& before, const cv::Mat& now, cv::Mat& motion) {
    const Level beforeLevel(matchedBrightness(before, now));
    const Level nowLevel(now);
    CellSearch search(beforeLevel, nowLevel);
    search.refine(motion);
    spread(search, beforeLevel, nowLevel, motion);
}

} // namespace altiro3D
