#pragma once

#include "base/pixel_rows.hpp"
#include "depth/refine/depth_steps_row.hpp"

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

/// What a square window around each px of a depth map holds.
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

/// What the px of one row need.
struct StepBuffers {
    std::vector<std::uint8_t> wanted; ///< Not 0: to be decided.
    std::vector<float> middle;        ///< Depth between the sides.
    std::vector<float> scale;         ///< 2 / height of the step.
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
    ///        the middle than the height of the step then belong to something else. Empty: all
    ///        px count fully.
    void setDepth(const cv::Mat& depth, const cv::Mat& sure = {});
    /// The depth as set. @return [as photo, CV_32FC1]
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

} // namespace altiro3D
