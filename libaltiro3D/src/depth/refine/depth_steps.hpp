#pragma once

#include "altiro3D/depth_map.hpp"
#include "base/pixel_rows.hpp"

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

// Its sources: depth_refine.cpp (sharpenSteps), depth_contours.cpp (decideContours),
// depth_step_sides.cpp (the sides of steps).

/// Turns the soft steps of a depth map into hard ones where the photo has an edge. Each px of a
/// step takes the side to which its depth and its colour belong. Contours are smoothed by a median.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param flaws softness (> 0 px) and blur of the steps, which are equally soft
/// @param depth [as photo, CV_32FC1, 0..1], changed in place
void sharpenSteps(const cv::Mat& photo, const DepthFlaws& flaws, cv::Mat& depth);

/// Similarity of colours by their squared distance >> kStepColorShift, in steps of 16 and at most
/// kStepColors.
constexpr int kStepColorShift = 4;
constexpr int kStepColors = 512;

/// One px of the neighbourhood that decides to which side of a step a px belongs.
struct StepTap {
    int column;            ///< Relative to the px.
    std::ptrdiff_t offset; ///< Elements of a plane from the px to this one.
    float weight;
};

/// A row of px and what surrounds it. Pointers are to the row's first px. Planes are padded on all
/// sides by the reach of the taps; rows of all arrays end with kRowPadding.
struct StepRow {
    std::size_t count = 0;        ///< Px of the row; taps beyond it are left out.
    const float* depth = nullptr; ///< Plane of depth.
    /// Plane of weights: px as members of a side. Null: all count fully, also those that are
    /// farther from the middle than the height of the step.
    const float* sure = nullptr;
    const std::int32_t* blueGreen = nullptr; ///< Plane of colours: blue + 65536 green.
    const std::int32_t* red = nullptr;       ///< Plane of colours: red.
    const std::uint8_t* wanted = nullptr;    ///< Not 0: the px is wanted.
    const float* middle = nullptr;           ///< Depth between the sides of the step.
    const float* scale = nullptr;            ///< 2 / height of the step.
    const StepTap* taps = nullptr;           ///< Taps whose rows exist.
    std::size_t tapCount = 0;
    int reach = 0; ///< Largest column of the taps; the least one is its negative.
};

/// Sums over one side of the steps of a row, per px and padded (kRowPadding).
struct StepSums {
    float* depth = nullptr;  ///< Sum of weighted depth.
    float* weight = nullptr; ///< Sum of the weights.
    float* color = nullptr;  ///< Sum of weighted similarities with the px.
};

/// A symmetric filter of `count` values: to[x] = weights[0] middle[x] + the sum of weights[k]
/// (before[k][x] + after[k][x]) for k = 1..reach, added in this order.
/// @param before @param after `reach` + 1 pointers; those at 0 are not used
/// @param to result; must not overlap the others
void filterRow(const float* middle, const float* const* before, const float* const* after,
               const float* weights, std::size_t reach, std::size_t count, float* to);

/// Extremes in a square window around each px of a depth map.
struct Surroundings {
    cv::Mat least;    ///< [as depth, CV_32FC1] depth
    cv::Mat most;     ///< [as depth, CV_32FC1] depth
    cv::Mat steepest; ///< [as depth, CV_32FC1] largest squared slope
    cv::Mat slopes;   ///< [as depth, CV_32FC1] squared slope of the px itself

    /// @param depth [rows x cols, CV_32FC1] @param radius of the window, px
    void find(const cv::Mat& depth, int radius);
};

/// Least and largest depth in a square window.
void findExtremes(const cv::Mat& depth, int radius, cv::Mat& least, cv::Mat& most);

/// A px of the neighbourhood that decides to which side of a step a px belongs.
struct StepNeighbour {
    int x;
    int y;
    float weight;
};

/// One side of a step: its mean depth, and how similar the photo there is to the px in question.
struct StepSide {
    float depth;
    float color;
};

/// Sums over one side for each px of a row.
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

/// Data of the px of one row; the first three are as in StepRow.
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

/// Photo and depth, and the neighbourhood of each px in them: sums of both sides of steps.
class StepSides {
  public:
    /// @param photo [rows x cols, CV_8UC3, BGR] @param neighbours by rows, then columns
    StepSides(const cv::Mat& photo, std::vector<StepNeighbour> neighbours);

    /// @param depth [as photo, CV_32FC1]
    /// @param sure [as photo, CV_32FC1, 0..1] weights of px as members of a side; px farther from
    ///        the middle than the step's height then belong elsewhere. Empty: all px count fully.
    void setDepth(const cv::Mat& depth, const cv::Mat& sure = {});
    const cv::Mat& depth() const { return depth_; }

    /// Sums both sides of the wanted px of a row.
    /// @param buffers `wanted`, `middle` and `scale` are given, the rest is the result
    void sum(int y, StepBuffers& buffers) const;

  private:
    cv::Mat padded(int type) const;
    cv::Mat inside(const cv::Mat& plane) const;

    cv::Size size_;
    std::vector<StepNeighbour> neighbours_;
    int margin_; // largest reach of the neighbours
    cv::Mat blueGreen_;
    cv::Mat red_;
    cv::Mat depthPlane_;
    cv::Mat surePlane_;
    cv::Mat depth_; // depthPlane_ without its margins
};

/// Turns the soft steps of a depth map into hard contours where there is evidence for them: the
/// step is steep, and the colours of the photo distinguish its two sides. Other steps stay as soft
/// as they are, because views stretch a slope, but tear a step. The steps may differ in softness,
/// as those of depth networks do. (4.12) to (4.15) of docs/mathematics.md.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1, finite, about 0..1, 1 = nearest] changed in place
void decideContours(const cv::Mat& photo, cv::Mat& depth);

} // namespace altiro3D
