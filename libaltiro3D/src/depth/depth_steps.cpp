#include "depth/depth_steps.hpp"

#include "base/pixel_rows.hpp"
#include "depth/depth_steps_row.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

namespace altiro3D {

namespace {

// The weights of a Gaussian from its middle to one side.
std::vector<float> gaussian(double sigma) {
    const int radius = std::max(1, static_cast<int>(std::ceil(2.5 * sigma)));
    std::vector<float> half;
    double sum = 0;
    for (int k = 0; k <= radius; ++k) {
        const double weight = std::exp(-k * k / (2 * sigma * sigma));
        half.push_back(static_cast<float>(weight));
        sum += k == 0 ? weight : 2 * weight;
    }
    for (float& weight : half)
        weight = static_cast<float>(static_cast<double>(weight) / sum);
    return half;
}

// Columns of depth, blurred; px at the border are repeated.
void blurDown(const cv::Mat& depth, const std::vector<float>& half, cv::Mat& blurred) {
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        std::vector<const float*> above(half.size());
        std::vector<const float*> below(half.size());
        for (int y = range.start; y < range.end; ++y) {
            for (std::size_t k = 1; k < half.size(); ++k) {
                const int distance = static_cast<int>(k);
                above[k] = depth.ptr<float>(std::max(y - distance, 0));
                below[k] = depth.ptr<float>(std::min(y + distance, depth.rows - 1));
            }
            filterRow(depth.ptr<float>(y), above.data(), below.data(), half.data(), half.size() - 1,
                      static_cast<std::size_t>(depth.cols), blurred.ptr<float>(y));
        }
    });
}

// Undoes most of a Gaussian blur (van Cittert 1931): thin things get their height back.
// @param depth equal to `given` @param buffer of the same size
void deblur(const cv::Mat& given, double sigma, cv::Mat& depth, cv::Mat& buffer) {
    const std::vector<float> half = gaussian(sigma);
    const std::size_t reach = half.size() - 1;
    const auto count = static_cast<std::size_t>(depth.cols);
    constexpr int kPasses = 3;
    for (int pass = 0; pass < kPasses; ++pass) {
        blurDown(depth, half, buffer);
        cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
            std::vector<float> row(count + 2 * reach); // the border repeated on both sides
            std::vector<float> soft(count);
            std::vector<const float*> before(half.size());
            std::vector<const float*> after(half.size());
            float* const middle = row.data() + reach;
            for (std::size_t k = 1; k <= reach; ++k) {
                before[k] = row.data() + (reach - k);
                after[k] = middle + k;
            }
            for (int y = range.start; y < range.end; ++y) {
                const auto* const columns = buffer.ptr<float>(y);
                std::fill_n(row.data(), reach, columns[0]);
                std::copy_n(columns, count, middle);
                std::fill_n(middle + count, reach, columns[count - 1]);
                filterRow(middle, before.data(), after.data(), half.data(), reach, count,
                          soft.data());
                const auto* const from = given.ptr<float>(y);
                auto* const to = depth.ptr<float>(y);
                for (std::size_t x = 0; x < count; ++x)
                    to[x] = std::clamp(to[x] + (from[x] - soft[x]), 0.0F, 1.0F);
            }
        });
    }
}

// Squared slope.
void findSlopes(const cv::Mat& depth, cv::Mat& result) {
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            const auto* const above = depth.ptr<float>(std::max(y - 1, 0));
            const auto* const row = depth.ptr<float>(y);
            const auto* const below = depth.ptr<float>(std::min(y + 1, depth.rows - 1));
            auto* const to = result.ptr<float>(y);
            for (int x = 0; x < depth.cols; ++x) {
                const float across = row[std::min(x + 1, depth.cols - 1)] - row[std::max(x - 1, 0)];
                const float down = below[x] - above[x];
                to[x] = (across * across + down * down) / 4;
            }
        }
    });
}

// All planes of a picture in one piece of memory. The thread keeps it for its next picture: in
// videos, fresh memory cost more than half of the time of the sharpening.
class PlaneMemory {
  public:
    PlaneMemory(cv::Size plane, int planes) : rows_(plane.height) {
        // taken, as a thread that waits for others may begin another picture
        all_ = std::exchange(kept(), cv::Mat());
        if (all_.cols != plane.width || all_.rows < plane.height * planes)
            all_.create(plane.height * planes, plane.width, CV_32FC1);
    }
    ~PlaneMemory() {
        constexpr std::size_t kMostKept = std::size_t{8} << 20; // px, 32 MB
        if (all_.total() <= kMostKept) kept() = all_;
    }
    PlaneMemory(const PlaneMemory&) = delete;
    PlaneMemory& operator=(const PlaneMemory&) = delete;

    // @param type of four bytes per px
    // @return no part of anything larger, for OpenCV's filters
    cv::Mat next(cv::Size size, int type = CV_32FC1) {
        cv::Mat plane = all_.rowRange(used_ * rows_, (used_ + 1) * rows_);
        ++used_;
        return {size, type, plane.data, plane.step};
    }

  private:
    static cv::Mat& kept() {
        thread_local cv::Mat memory;
        return memory;
    }

    int rows_;
    int used_ = 0;
    cv::Mat all_;
};

// What a square window around each px holds.
struct Surroundings {
    static constexpr int kPlanes = 4;

    Surroundings(cv::Size size, PlaneMemory& memory)
        : least(memory.next(size)), most(memory.next(size)), steepest(memory.next(size)),
          slopes(memory.next(size)) {}

    void find(const cv::Mat& depth, int radius);

    cv::Mat least;    // depth
    cv::Mat most;     // depth
    cv::Mat steepest; // largest squared slope
    cv::Mat slopes;   // squared
};

void Surroundings::find(const cv::Mat& depth, int radius) {
    const cv::Mat window = cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8UC1);
    findSlopes(depth, slopes);
    // OpenCV's filters use one thread. They read the rows around a part of a picture, and here no
    // columns beside it.
    const cv::Mat alone(depth.size(), CV_32FC1, const_cast<uchar*>(depth.data), depth.step);
    cv::parallel_for_(
        cv::Range(0, depth.rows),
        [&](const cv::Range& rows) {
            cv::Mat part = least.rowRange(rows);
            cv::erode(alone.rowRange(rows), part, window, {-1, -1}, 1, cv::BORDER_REPLICATE);
            part = most.rowRange(rows);
            cv::dilate(alone.rowRange(rows), part, window, {-1, -1}, 1, cv::BORDER_REPLICATE);
            part = steepest.rowRange(rows);
            cv::dilate(slopes.rowRange(rows), part, window, {-1, -1}, 1, cv::BORDER_REPLICATE);
        },
        cv::getNumThreads());
}

// Takes deblurred depth back where the given depth is steeper than a blur leaves it: there a hard
// step would get a rim on both sides. Formula (4.7a) of docs/mathematics.md.
void keepHardSteps(const cv::Mat& given, double sigma, Surroundings& around, cv::Mat& depth) {
    constexpr float kSoft = 1.8F; // a blurred step has 1, a blurred line 1.5
    constexpr float kHard = 2.4F;
    around.find(given, static_cast<int>(std::lround(2 * sigma)));
    const auto stepWidth = static_cast<float>(std::sqrt(2 * CV_PI) * sigma);
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            const auto* const least = around.least.ptr<float>(y);
            const auto* const most = around.most.ptr<float>(y);
            const auto* const steepest = around.steepest.ptr<float>(y);
            const auto* const from = given.ptr<float>(y);
            auto* const to = depth.ptr<float>(y);
            for (int x = 0; x < depth.cols; ++x) {
                const float height = most[x] - least[x];
                const float slope2 = steepest[x] * stepWidth * stepWidth;
                if (slope2 <= kSoft * kSoft * height * height) continue; // most px
                const float hardness = std::sqrt(slope2) / height;
                const float keep = std::clamp((hardness - kSoft) / (kHard - kSoft), 0.0F, 1.0F);
                to[x] += keep * (from[x] - to[x]);
            }
        }
    });
}

struct Tap {
    int x;
    int y;
    float weight;
};

// How the px of a step are decided.
struct StepRule {
    double width;      // of the steps, px
    int radius;        // of the window that decides on a px
    int samples;       // the window has at most this many on each side of the px
    float part;        // px within this part of a step's height from its middle are decided
    float depthWeight; // of the place of a px between the sides
    float colorWeight; // of its colour
    float minHeight;   // of a step, in units of depth
};

// The neighbourhood of a px that decides to which side it belongs.
std::vector<Tap> windowOf(const StepRule& rule) {
    std::vector<Tap> taps;
    const int radius = rule.radius;
    const int stride = (radius + rule.samples - 1) / rule.samples; // large windows are sampled
    const int reach = radius / stride * stride;
    for (int y = -reach; y <= reach; y += stride) {
        for (int x = -reach; x <= reach; x += stride) {
            const double square = x * x + y * y;
            taps.push_back({x, y, static_cast<float>(std::exp(-square / (2.0 * radius * radius)))});
        }
    }
    return taps;
}

// Similarity of colours by their squared distance >> kStepColorShift.
std::vector<float> makeColorWeights() {
    constexpr double kSigma = 14; // levels; 8 to 20 give the same within 0.05 dB
    std::vector<float> weights;
    for (int i = 0; i < kStepColors; ++i) {
        const double square = (i + 0.5) * (1 << kStepColorShift);
        weights.push_back(static_cast<float>(std::exp(-square / (2 * kSigma * kSigma))));
    }
    weights.push_back(0);
    return weights;
}

// One side of a step: its mean depth, and how similar the photo there is to the px in question.
struct StepSide {
    float depth;
    float color;
};

// Sums over one side for each px of a row.
struct SideRows {
    std::vector<float> depth;
    std::vector<float> weight;
    std::vector<float> color;

    explicit SideRows(std::size_t count)
        : depth(paddedRow<float>(count)), weight(depth), color(depth) {}
    StepSums sums() { return {depth.data(), weight.data(), color.data()}; }
    bool has(std::size_t x) const { return weight[x] > 0; }
    StepSide mean(std::size_t x) const { return {depth[x] / weight[x], color[x] / weight[x]}; }
};

// What the px of one row need.
struct StepBuffers {
    std::vector<std::uint8_t> wanted;
    std::vector<float> middle;
    std::vector<float> scale;
    SideRows nearSide;
    SideRows farSide;
    std::vector<StepTap> taps;

    explicit StepBuffers(std::size_t count)
        : wanted(paddedRow<std::uint8_t>(count)), middle(paddedRow<float>(count)),
          scale(paddedRow<float>(count)), nearSide(count), farSide(count) {}
};

// Photo and depth as StepRow needs them.
class StepPlanes {
  public:
    static constexpr int kPlanes = 3;
    // @param margin largest reach of the taps
    // @return size of a plane
    static cv::Size sizeOf(cv::Size picture, int margin) {
        return {picture.width + 2 * margin + static_cast<int>(kRowPadding), picture.height};
    }

    // @param memory of planes of sizeOf()
    StepPlanes(const cv::Mat& photo, int margin, PlaneMemory& memory)
        : margin_(margin), blueGreen_(memory.next(sizeOf(photo.size(), margin), CV_32SC1)),
          red_(memory.next(sizeOf(photo.size(), margin), CV_32SC1)),
          depth_(memory.next(sizeOf(photo.size(), margin))),
          inside_(depth_(cv::Rect({margin_, 0}, photo.size()))) {
        cv::parallel_for_(cv::Range(0, photo.rows), [&](const cv::Range& range) {
            for (int y = range.start; y < range.end; ++y) {
                clearMargins(blueGreen_.ptr<std::int32_t>(y));
                clearMargins(red_.ptr<std::int32_t>(y));
                clearMargins(depth_.ptr<float>(y));
                const auto* bgr = photo.ptr<std::uint8_t>(y);
                auto* const blueGreen = blueGreen_.ptr<std::int32_t>(y) + margin_;
                auto* const red = red_.ptr<std::int32_t>(y) + margin_;
                for (int x = 0; x < photo.cols; ++x, bgr += 3) {
                    blueGreen[x] = bgr[0] | (bgr[1] << 16);
                    red[x] = bgr[2];
                }
            }
        });
    }
    const cv::Mat& depth() const { return inside_; }
    void setDepth(const cv::Mat& depth) { depth.copyTo(inside_); }
    // Elements from row to row.
    std::ptrdiff_t stride() const { return depth_.cols; }
    // @return the planes of row y
    StepRow row(int y) const {
        StepRow row;
        row.depth = depth_.ptr<float>(y) + margin_;
        row.blueGreen = blueGreen_.ptr<std::int32_t>(y) + margin_;
        row.red = red_.ptr<std::int32_t>(y) + margin_;
        return row;
    }

  private:
    template <class T>
    void clearMargins(T* row) const {
        std::fill_n(row, margin_, T{0});
        std::fill(row + margin_ + inside_.cols, row + depth_.cols, T{0});
    }

    int margin_;
    cv::Mat blueGreen_;
    cv::Mat red_;
    cv::Mat depth_;
    cv::Mat inside_; // depth_ without its margins
};

// Parameters that were measured on the scenes of docs/lab/views.md.
constexpr float kWholeStep = 1;  // px farther from the middle belong to something else
constexpr float kMiddle = 0.3F;  // px that are left between the sides after the first pass
constexpr double kLeftWidth = 2; // width of what is left
constexpr float kSimilar = 0.8F; // a px that is so similar to both sides is no edge

// In a wide window, lower steps are slopes of a surface.
constexpr double kMinHeight = 0.03; // of a step, in units of depth
constexpr double kMinHeightOfWide = 0.08;
constexpr double kMinHeightPerPixel = 0.006;

// Equally soft steps of a width: the depth knows well where they are.
StepRule evenRule(double width) {
    const int radius = std::max(2, static_cast<int>(std::lround(0.9 * width)));
    const double least = std::clamp(kMinHeightPerPixel * width, kMinHeight, kMinHeightOfWide);
    return {width, radius, 6, kWholeStep, 6, 1, static_cast<float>(least)};
}

// Steps of differing softness: the colour counts more, in a wide window. Where it says nothing,
// they stay soft.
StepRule unevenRule(double width) {
    const int radius = std::max(2, static_cast<int>(std::lround(width)));
    return {width, radius, 4, kWholeStep, 1.2F, 0.6F, static_cast<float>(kMinHeightOfWide)};
}

// The depth of a px in a step: 0 far, 1 near, from its own place between the sides and its colour.
float sideOf(const StepRule& rule, float place, const StepSide& nearSide, const StepSide& farSide) {
    constexpr float kFloor = 0.02F; // the photo may contradict, but not for ever
    const double color =
        std::log(static_cast<double>((nearSide.color + kFloor) / (farSide.color + kFloor)));
    const double side = static_cast<double>(rule.depthWeight * (2 * place - 1)) +
                        static_cast<double>(rule.colorWeight) * color;
    return static_cast<float>((std::clamp(side, -1.0, 1.0) + 1) / 2);
}

class Sharpener {
  public:
    // @param given the depth that stays where the photo has no edge
    // @param planes the depth of which steps are made, and the photo
    // @param around what surrounds each px, of rule.radius
    Sharpener(const cv::Mat& given, const StepRule& rule, const StepPlanes& planes,
              const Surroundings& around)
        : given_(given), depth_(planes.depth()), rule_(rule), planes_(planes), around_(around),
          taps_(windowOf(rule)) {}

    // @param to row y of the result, which holds the depth
    void row(int y, StepBuffers& buffers, float* to) const {
        if (!findSteps(y, buffers)) return;
        static const std::vector<float> colorWeights = makeColorWeights();
        buffers.taps.clear();
        for (const Tap& tap : taps_) {
            if (y + tap.y >= 0 && y + tap.y < depth_.rows)
                buffers.taps.push_back({tap.x, tap.y * planes_.stride() + tap.x, tap.weight});
        }
        StepRow row = planes_.row(y);
        row.count = static_cast<std::size_t>(depth_.cols);
        row.wanted = buffers.wanted.data();
        row.middle = buffers.middle.data();
        row.scale = buffers.scale.data();
        row.taps = buffers.taps.data();
        row.tapCount = buffers.taps.size();
        row.reach = taps_.back().x;
        sumStepSides(row, colorWeights.data(), buffers.nearSide.sums(), buffers.farSide.sums());
        for (int x = 0; x < depth_.cols; ++x) {
            if (buffers.wanted[static_cast<std::size_t>(x)] != 0) to[x] = pixel(x, y, buffers);
        }
    }

  private:
    // Marks the px of a row that may have to be decided. @return whether there are any
    bool findSteps(int y, StepBuffers& buffers) const {
        const auto* const least = around_.least.ptr<float>(y);
        const auto* const most = around_.most.ptr<float>(y);
        const auto* const steepest = around_.steepest.ptr<float>(y);
        const auto* const depth = depth_.ptr<float>(y);
        const float ramp = 1.5F * (static_cast<float>(rule_.width) + 1);
        // The means of the sides lie in their halves of least..most, so px that are farther from
        // the middle than this are not within rule_.part.
        constexpr float kRounding = 0.01F;
        const float reach = rule_.part + 0.5F + kRounding;
        bool any = false;
        for (int x = 0; x < depth_.cols; ++x) {
            const auto at = static_cast<std::size_t>(x);
            const float height = most[x] - least[x];
            buffers.wanted[at] = 0;
            // A slope is not a step: it is higher than its steepest place makes a step of this
            // width.
            if (height < rule_.minHeight || height * height > ramp * ramp * steepest[x]) continue;
            const float middle = (most[x] + least[x]) / 2;
            const float scale = 2 / height;
            if (std::abs(depth[x] - middle) * scale > reach) continue;
            buffers.wanted[at] = 1;
            buffers.middle[at] = middle;
            buffers.scale[at] = scale;
            any = true;
        }
        return any;
    }

    float pixel(int x, int y, const StepBuffers& buffers) const {
        const auto at = static_cast<std::size_t>(x);
        const float here = depth_.ptr<float>(y)[x];
        if (!buffers.nearSide.has(at) || !buffers.farSide.has(at)) return here;
        const StepSide nearSide = buffers.nearSide.mean(at);
        const StepSide farSide = buffers.farSide.mean(at);
        if (!(nearSide.depth > farSide.depth)) return here; // equal but for rounding
        const float place = (here - farSide.depth) / (nearSide.depth - farSide.depth);
        if (std::abs(place - 0.5F) > rule_.part) return here;
        if (nearSide.color > kSimilar && farSide.color > kSimilar) return given_.ptr<float>(y)[x];
        return farSide.depth +
               (nearSide.depth - farSide.depth) * sideOf(rule_, place, nearSide, farSide);
    }

    cv::Mat given_;
    cv::Mat depth_;
    StepRule rule_;
    const StepPlanes& planes_;
    const Surroundings& around_;
    std::vector<Tap> taps_;
};

// Smooths the contours of steps that were moved: each px that has moved becomes the median of the
// 3 x 3 px around it; px at the border are repeated.
// @param given the depth map before @param buffer of the same size
void smoothContours(const cv::Mat& given, cv::Mat& depth, cv::Mat& buffer) {
    constexpr float kMoved = 0.005F;
    cv::medianBlur(depth, buffer, 3);
    cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
        for (int y = range.start; y < range.end; ++y) {
            const auto* const before = given.ptr<float>(y);
            const auto* const medians = buffer.ptr<float>(y);
            auto* const row = depth.ptr<float>(y);
            for (int x = 0; x < depth.cols; ++x)
                row[x] = std::abs(row[x] - before[x]) > kMoved ? medians[x] : row[x];
        }
    });
}

} // namespace

void sharpenSteps(const cv::Mat& photo, const DepthFlaws& flaws, cv::Mat& depth) {
    const double softness = flaws.softnessPixels;
    const bool isBlurred = flaws.isBlurred && !flaws.isUneven; // enlarged depth would be harmed
    const StepRule rule =
        flaws.isUneven ? unevenRule(softness) : evenRule(isBlurred ? softness / 2 : softness);
    StepRule left = evenRule(kLeftWidth);
    left.part = kMiddle;
    const int margin = std::max(rule.radius, left.radius);
    PlaneMemory memory(StepPlanes::sizeOf(depth.size(), margin),
                       1 + Surroundings::kPlanes + StepPlanes::kPlanes);
    cv::Mat given = memory.next(depth.size());
    depth.copyTo(given);
    Surroundings around(depth.size(), memory);
    if (isBlurred) {
        const double sigma = (softness + 1) / 2.5;
        deblur(given, sigma, depth, around.slopes);
        keepHardSteps(given, sigma, around, depth);
    }
    StepPlanes planes(photo, margin, memory);
    const auto sharpen = [&](const cv::Mat& flat, const StepRule& how) {
        around.find(depth, how.radius);
        planes.setDepth(depth);
        const Sharpener sharpener(flat, how, planes, around);
        cv::parallel_for_(cv::Range(0, depth.rows), [&](const cv::Range& range) {
            StepBuffers buffers(static_cast<std::size_t>(depth.cols));
            for (int y = range.start; y < range.end; ++y)
                sharpener.row(y, buffers, depth.ptr<float>(y));
        });
    };
    sharpen(given, rule);
    sharpen(planes.depth(), left);
    smoothContours(given, depth, around.slopes);
}

} // namespace altiro3D
