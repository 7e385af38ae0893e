#include "video/picture_motion.hpp"

#include "image/shrink.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <vector>

// docs/mathematics.md, section 5, has the formulas.

namespace altiro3D {

namespace {

constexpr int kCell = 4;    // px between the places where motion is looked for
constexpr int kWindow = 8;  // px that are compared there
constexpr int kBorder = 24; // px that are repeated around a picture; motion ends there

// Costs are sums of kWindow^2 grey differences; these were chosen on the clips of docs/tradeoff.md.
constexpr int kStillBonus = 48;     // what a still place is better by: noise is no motion
constexpr int kUnlikeNeighbour = 6; // for each px that it differs from its neighbours' motion
constexpr int kStillMisfit = 96;    // a still place that fits so well is not looked at further

constexpr float kBlack =
    8; // grey levels below 0 at which gains hold: dark cells, where noise rules, count little

struct Vector {
    int x = 0;
    int y = 0;
    bool operator==(const Vector& other) const { return x == other.x && y == other.y; }
};

// One level of the pyramid with its border repeated.
struct Level {
    cv::Size size;
    cv::Mat padded; // [size + 2 kBorder, CV_8UC1]

    explicit Level(const cv::Mat& grey) : size(grey.size()) {
        cv::copyMakeBorder(grey, padded, kBorder, kBorder, kBorder, kBorder, cv::BORDER_REPLICATE);
    }
    const uchar* at(int x, int y) const { return padded.ptr(y + kBorder) + x + kBorder; }
};

cv::Mat halved(const cv::Mat& grey) {
    cv::Mat half((grey.rows + 1) / 2, (grey.cols + 1) / 2, CV_8UC1);
    for (int y = 0; y < half.rows; ++y) {
        const uchar* above = grey.ptr(2 * y);
        const uchar* below = grey.ptr(std::min(2 * y + 1, grey.rows - 1));
        uchar* out = half.ptr(y);
        for (int x = 0; x < half.cols; ++x) {
            const int left = 2 * x;
            const int right = std::min(left + 1, grey.cols - 1);
            out[x] = static_cast<uchar>(
                (above[left] + above[right] + below[left] + below[right] + 2) / 4);
        }
    }
    return half;
}

// Sum of the absolute differences of two windows; bound by arithmetic (eight bytes a row).
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
        : before_(&before), now_(&now), columns_((now.size.width + kCell - 1) / kCell),
          rows_((now.size.height + kCell - 1) / kCell),
          cells_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

    int columns() const { return columns_; }
    int rows() const { return rows_; }
    Vector& cell(int column, int row) {
        return cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                      static_cast<std::size_t>(column)];
    }
    const Vector& nearestCell(int column, int row) const {
        column = std::clamp(column, 0, columns_ - 1);
        row = std::clamp(row, 0, rows_ - 1);
        return cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                      static_cast<std::size_t>(column)];
    }

    // Looks everywhere within `reach` px.
    void searchAll(int reach) {
        forEachCell([&](int column, int row) {
            begin(column, row);
            for (int y = -reach; y <= reach; ++y)
                for (int x = -reach; x <= reach; ++x)
                    offer({x, y});
        });
    }

    // Looks around what the coarser level and the cells before say.
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

    // Looks around what a motion says and the cells before.
    void refine(const cv::Mat& motion) {
        refineFrom([&](int column, int row) {
            const auto& from =
                motion.at<cv::Vec2f>(std::min(kCell * row + kCell / 2, motion.rows - 1),
                                     std::min(kCell * column + kCell / 2, motion.cols - 1));
            offer({cvRound(from[0]), cvRound(from[1])});
        });
    }

    // Replaces each cell's motion by the median of it and its neighbours, x and y for themselves.
    void smooth() {
        const std::vector<Vector> found = cells_;
        const auto foundAt = [&](int column, int row) {
            column = std::clamp(column, 0, columns_ - 1);
            row = std::clamp(row, 0, rows_ - 1);
            return found[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                         static_cast<std::size_t>(column)];
        };
        for (int row = 0; row < rows_; ++row) {
            for (int column = 0; column < columns_; ++column) {
                std::array<int, 9> xs{};
                std::array<int, 9> ys{};
                std::size_t i = 0;
                bool alike = true;
                for (int dy = -1; dy <= 1; ++dy) {
                    for (int dx = -1; dx <= 1; ++dx, ++i) {
                        const Vector near = foundAt(column + dx, row + dy);
                        alike = alike && near == foundAt(column, row);
                        xs[i] = near.x;
                        ys[i] = near.y;
                    }
                }
                if (alike) continue;
                std::nth_element(xs.begin(), xs.begin() + 4, xs.end());
                std::nth_element(ys.begin(), ys.begin() + 4, ys.end());
                cell(column, row) = {xs[4], ys[4]};
            }
        }
    }

    // The place between px where the two sides' costs would meet as straight lines.
    cv::Vec2f betweenPixels(int column, int row) {
        const Vector at = cell(column, row);
        if (at == Vector{}) return {0, 0};
        windowX_ = kCell * column - (kWindow - kCell) / 2;
        windowY_ = kCell * row - (kWindow - kCell) / 2;
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
        for (int row = 0; row < rows_; ++row) {
            for (int column = 0; column < columns_; ++column) {
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
            constexpr int kMostSteps = 6;
            for (int step = 0; step < kMostSteps; ++step) {
                const Vector centre = best_;
                for (int dy = -1; dy <= 1; ++dy)
                    for (int dx = -1; dx <= 1; ++dx)
                        offer({centre.x + dx, centre.y + dy});
                if (best_ == centre) break;
            }
        });
    }

    void begin(int column, int row) {
        windowX_ = kCell * column - (kWindow - kCell) / 2;
        windowY_ = kCell * row - (kWindow - kCell) / 2;
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

    // What a motion costs for not being its neighbours'.
    int unrest(Vector vector) const {
        const auto distance = [&](Vector other) {
            return std::abs(vector.x - other.x) + std::abs(vector.y - other.y);
        };
        return kUnlikeNeighbour * std::min({distance(left_), distance(above_), 16});
    }

    // Sides of a picture may be shorter than a window and its border: places stay in the padding.
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
    int columns_;
    int rows_;
    std::vector<Vector> cells_;
    int windowX_ = 0;
    int windowY_ = 0;
    Vector left_;
    Vector above_;
    Vector best_;
    int stillDifference_ = 0;
    int leastCost_ = 0;
};

// The median over cells of 4 x 4 px of how much brighter `now` is, as a factor.
float gainBetween(const cv::Mat& before, const cv::Mat& now) {
    const cv::Mat a = halved(halved(before));
    const cv::Mat b = halved(halved(now));
    std::vector<float> ratios;
    ratios.reserve(a.total());
    for (int y = 0; y < a.rows; ++y) {
        const uchar* rowA = a.ptr(y);
        const uchar* rowB = b.ptr(y);
        for (int x = 0; x < a.cols; ++x)
            ratios.push_back((static_cast<float>(rowB[x]) + kBlack) /
                             (static_cast<float>(rowA[x]) + kBlack));
    }
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return std::clamp(*middle, 0.5F, 2.0F);
}

cv::Mat brightened(const cv::Mat& grey, float gain) {
    std::array<uchar, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
        const float value = gain * (static_cast<float>(i) + kBlack) - kBlack;
        table[i] = static_cast<uchar>(std::clamp(std::lround(value), 0L, 255L));
    }
    cv::Mat result(grey.size(), CV_8UC1);
    for (int y = 0; y < grey.rows; ++y) {
        const uchar* from = grey.ptr(y);
        std::transform(from, from + grey.cols, result.ptr(y),
                       [&](uchar value) { return table[value]; });
    }
    return result;
}

// Where between two px a place falls, with the border repeated.
struct Between {
    int low = 0;
    int high = 0;
    float share = 0; // of `high`
};

Between between(float place, int count) {
    // NaN ends up at 0; places far out do, before they become whole numbers, at the border
    const float inside = place > 0 ? std::min(place, static_cast<float>(count - 1)) : 0.0F;
    Between result;
    result.low = static_cast<int>(inside);
    result.high = std::min(result.low + 1, count - 1);
    result.share = inside - static_cast<float>(result.low);
    return result;
}

template <class T>
T mixed(const T& a, const T& b, float share) {
    return a + (b - a) * share;
}

template <class T>
T sampled(const cv::Mat& values, const Between& x, const Between& y) {
    const T* above = values.ptr<T>(y.low);
    const T* below = values.ptr<T>(y.high);
    return mixed(mixed(above[x.low], above[x.high], x.share),
                 mixed(below[x.low], below[x.high], x.share), y.share);
}

// From cells to px: linear where the four cells around move alike, else as the one of them whose
// motion fits best.
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
        return (static_cast<float>(pixel) + 0.5F) / kCell - 0.5F;
    };
    for (int y = 0; y < now.size.height; ++y) {
        auto* out = motion.ptr<cv::Vec2f>(y);
        const Between down = between(placeOf(y), cells.rows);
        const auto* above = cells.ptr<cv::Vec2f>(down.low);
        const auto* below = cells.ptr<cv::Vec2f>(down.high);
        for (int x = 0; x < now.size.width; ++x) {
            const Between right = between(placeOf(x), cells.cols);
            const std::array<cv::Vec2f, 4> around{above[right.low], above[right.high],
                                                  below[right.low], below[right.high]};
            float spread = 0;
            for (int i = 0; i < 2; ++i) {
                const auto bounds =
                    std::minmax({around[0][i], around[1][i], around[2][i], around[3][i]});
                spread = std::max(spread, bounds.second - bounds.first);
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

cv::Mat smallPicture(const cv::Mat& picture) {
    return shrink(picture, kSmallSide);
}

cv::Mat greyOf(const cv::Mat& small) {
    cv::Mat grey(small.size(), CV_8UC1);
    for (int y = 0; y < small.rows; ++y) {
        const uchar* pixel = small.ptr(y);
        uchar* out = grey.ptr(y);
        for (int x = 0; x < small.cols; ++x, pixel += 3)
            out[x] =
                static_cast<uchar>((29 * pixel[0] + 150 * pixel[1] + 77 * pixel[2] + 128) / 256);
    }
    return grey;
}

void findMotion(const cv::Mat& before, const cv::Mat& now, cv::Mat& motion) {
    motion.create(now.size(), CV_32FC2);
    std::vector<Level> befores{Level(brightened(before, gainBetween(before, now)))};
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
    const Level beforeLevel(brightened(before, gainBetween(before, now)));
    const Level nowLevel(now);
    CellSearch search(beforeLevel, nowLevel);
    search.refine(motion);
    spread(search, beforeLevel, nowLevel, motion);
}

cv::Mat joinMotion(const cv::Mat& earlier, const cv::Mat& later) {
    cv::Mat joined(later.size(), CV_32FC2);
    for (int y = 0; y < later.rows; ++y) {
        const auto* last = later.ptr<cv::Vec2f>(y);
        auto* out = joined.ptr<cv::Vec2f>(y);
        for (int x = 0; x < later.cols; ++x) {
            const Between right = between(static_cast<float>(x) + last[x][0], earlier.cols);
            const Between down = between(static_cast<float>(y) + last[x][1], earlier.rows);
            out[x] = last[x] + sampled<cv::Vec2f>(earlier, right, down);
        }
    }
    return joined;
}

cv::Mat misfit(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion) {
    cv::Mat moved(now.size(), CV_8UC1);
    for (int y = 0; y < now.rows; ++y) {
        const auto* vector = motion.ptr<cv::Vec2f>(y);
        uchar* out = moved.ptr(y);
        for (int x = 0; x < now.cols; ++x) {
            const Between right = between(static_cast<float>(x) + vector[x][0], before.cols);
            const Between down = between(static_cast<float>(y) + vector[x][1], before.rows);
            const uchar* above = before.ptr(down.low);
            const uchar* below = before.ptr(down.high);
            const auto mix = [](uchar a, uchar b, float share) {
                return mixed(static_cast<float>(a), static_cast<float>(b), share);
            };
            out[x] = static_cast<uchar>(mixed(mix(above[right.low], above[right.high], right.share),
                                              mix(below[right.low], below[right.high], right.share),
                                              down.share) +
                                        0.5F);
        }
    }
    moved = brightened(moved, gainBetween(moved, now));
    cv::Mat difference(now.rows + 2, now.cols + 2, CV_8UC1); // with a border of one px
    for (int y = 0; y < difference.rows; ++y) {
        const int fromY = std::clamp(y - 1, 0, now.rows - 1);
        for (int x = 0; x < difference.cols; ++x) {
            const int fromX = std::clamp(x - 1, 0, now.cols - 1);
            difference.at<uchar>(y, x) = static_cast<uchar>(
                std::abs(moved.at<uchar>(fromY, fromX) - now.at<uchar>(fromY, fromX)));
        }
    }
    cv::Mat result(now.size(), CV_32FC1);
    for (int y = 0; y < now.rows; ++y) {
        const uchar* above = difference.ptr(y);
        const uchar* middle = difference.ptr(y + 1);
        const uchar* below = difference.ptr(y + 2);
        auto* out = result.ptr<float>(y);
        for (int x = 0; x < now.cols; ++x) {
            int sum = 0;
            for (int i = x; i < x + 3; ++i)
                sum += above[i] + middle[i] + below[i];
            out[x] = static_cast<float>(sum) / 9;
        }
    }
    return result;
}

double contrastOf(const cv::Mat& grey) {
    std::int64_t sum = 0;
    std::int64_t squares = 0;
    for (int y = 0; y < grey.rows; ++y) {
        const uchar* row = grey.ptr(y);
        for (int x = 0; x < grey.cols; ++x) {
            sum += row[x];
            squares += row[x] * row[x];
        }
    }
    const auto count = static_cast<double>(grey.total());
    const double mean = static_cast<double>(sum) / count;
    return std::sqrt(std::max(0.0, static_cast<double>(squares) / count - mean * mean));
}

double unlikeness(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion,
                  const cv::Mat& misfits) {
    constexpr double kNoise = 4;      // grey levels; plain pictures differ by noise only
    constexpr float kWild = 3;        // px from one cell to the next
    constexpr double kWildShare = .5; // what wild motion counts beside the misfit
    double sum = 0;
    int pairs = 0;
    int wild = 0;
    for (int y = 0; y < now.rows; ++y) {
        const auto* row = misfits.ptr<float>(y);
        for (int x = 0; x < now.cols; ++x)
            sum += static_cast<double>(row[x]);
        if (y % kCell != 0 || y + kCell >= now.rows) continue;
        const auto* vectors = motion.ptr<cv::Vec2f>(y);
        const auto* below = motion.ptr<cv::Vec2f>(y + kCell);
        const auto differ = [](const cv::Vec2f& a, const cv::Vec2f& b) {
            const cv::Vec2f d = a - b;
            return d[0] * d[0] + d[1] * d[1] > kWild * kWild;
        };
        for (int x = 0; x + kCell < now.cols; x += kCell, pairs += 2) {
            wild += static_cast<int>(differ(vectors[x], vectors[x + kCell]));
            wild += static_cast<int>(differ(vectors[x], below[x]));
        }
    }
    const double contrast = std::min(contrastOf(before), contrastOf(now));
    const double wildness = pairs == 0 ? 0.0 : static_cast<double>(wild) / pairs;
    return sum / static_cast<double>(now.total()) / (kNoise + contrast) + kWildShare * wildness;
}

void carry(const cv::Mat& before, const cv::Mat& motion, cv::Mat& moved) {
    CV_Assert(moved.data != before.data || before.empty());
    moved.create(before.size(), CV_32FC1);
    const float perX = static_cast<float>(motion.cols) / static_cast<float>(before.cols);
    const float perY = static_cast<float>(motion.rows) / static_cast<float>(before.rows);
    cv::parallel_for_(cv::Range(0, before.rows), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            const Between down = between((static_cast<float>(y) + 0.5F) * perY - 0.5F, motion.rows);
            const auto* same = before.ptr<float>(y);
            auto* out = moved.ptr<float>(y);
            for (int x = 0; x < before.cols; ++x) {
                const Between right =
                    between((static_cast<float>(x) + 0.5F) * perX - 0.5F, motion.cols);
                const auto vector = sampled<cv::Vec2f>(motion, right, down);
                if (vector[0] == 0 && vector[1] == 0) {
                    out[x] = same[x];
                    continue;
                }
                out[x] = sampled<float>(
                    before, between(static_cast<float>(x) + vector[0] / perX, before.cols),
                    between(static_cast<float>(y) + vector[1] / perY, before.rows));
            }
        }
    });
}

cv::Mat stretched(const cv::Mat& values, int rows, int cols) {
    cv::Mat result(rows, cols, CV_32FC1);
    const float perX = static_cast<float>(values.cols) / static_cast<float>(cols);
    const float perY = static_cast<float>(values.rows) / static_cast<float>(rows);
    for (int y = 0; y < rows; ++y) {
        const Between down = between((static_cast<float>(y) + 0.5F) * perY - 0.5F, values.rows);
        auto* out = result.ptr<float>(y);
        for (int x = 0; x < cols; ++x) {
            out[x] = sampled<float>(
                values, between((static_cast<float>(x) + 0.5F) * perX - 0.5F, values.cols), down);
        }
    }
    return result;
}

} // namespace altiro3D
