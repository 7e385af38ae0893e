#pragma once

#include "altiro3D/display.hpp"

#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D {

/// Weights of the px around a place, as a sum of products: each column times its row. Sums over the
/// columns first take a fraction of the time.
struct SeparableWeights {
    std::vector<cv::Mat> columns; ///< [height x 1, CV_32FC1]
    cv::Mat rows;                 ///< [products x width, CV_32FC1]
};

/// Removes detail of a photo that the lenses of a display cannot show in one direction. There a
/// lens shows one sub-pixel per row, of one colour; finer detail would come back as coloured noise.
/// docs/mathematics.md, (2.7) to (2.10).
///
/// Immutable and thread-safe. The same bytes for any number of threads and on any processor.
class LensFilter {
  public:
    /// @param geometry of the display, from lensGeometry()
    /// @param size px of a photo that fills the panel, each side at least 1
    LensFilter(const LensGeometry& geometry, cv::Size size);

    /// Filters a photo in linear light. Each colour is filtered to the place of its sub-pixels.
    /// Results stay within the range of the px around them, so edges get no halo.
    /// @param photo [rows x cols, CV_8UC3, BGR]
    /// @param filtered result [as the photo]; must not share memory with it
    void apply(const cv::Mat& photo, cv::Mat& filtered) const;

    /// The weights of the px around a place, for tests. Their sum is 1.
    /// @param colour 0 red, 1 green, 2 blue
    const SeparableWeights& weights(int colour) const {
        return weights_[static_cast<std::size_t>(colour)];
    }

  private:
    void filterRows(const cv::Mat& photo, const cv::Range& rows, cv::Mat& filtered) const;

    std::array<SeparableWeights, 3> weights_; // red, green, blue
    cv::Size reach_;                          // px to each side that are summed
    cv::Size near_;                           // px to each side whose range results stay in
};

} // namespace altiro3D
