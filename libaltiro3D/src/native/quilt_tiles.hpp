#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

/// Tiles of a picture and how alike they are, for the search of a quilt's layout.
namespace altiro3D {

constexpr double kUnit = 16; ///< Steps per grey level.
constexpr double kNoise = 6; ///< Grey levels that count as no contrast.

using Grey = cv::Mat_<std::uint16_t>; ///< In steps of 1 / kUnit grey levels.
using Features = cv::Mat_<std::int16_t>;

/// The rows of a picture, each scaled to `width` samples: means of equal parts, which need not be
/// whole. @param factor of the samples
template <class Sample>
Grey scaleRows(const cv::Mat_<Sample>& picture, int width, double factor);

/// Columns become rows.
template <class Sample>
cv::Mat_<Sample> turned(const cv::Mat_<Sample>& picture) {
    cv::Mat_<Sample> result;
    cv::transpose(picture, result);
    return result;
}

/// Tiles of equal size and what they show.
class Tiles {
  public:
    /// @param picture [tiles of `size` side by side and above each other]
    /// @param radius px of the window that removes brightness and contrast
    Tiles(const Grey& picture, cv::Size size, int radius);

    /// How alike the tiles of each pair are, -1..1: their correlation at the best common shift.
    /// @param shifts px by which the second tile is shifted to the right, [start, end)
    double likeness(const std::vector<std::pair<int, int>>& pairs, cv::Range shifts) const;
    /// The same for shifts of up to `maxShift` px to either side.
    double likeness(const std::vector<std::pair<int, int>>& pairs, int maxShift) const {
        return likeness(pairs, cv::Range(-maxShift, maxShift + 1));
    }

    /// Share of what the tiles show that is not a pattern of rows and columns, 0..1: what the two
    /// largest singular values of their mean leave.
    double detail() const;

  private:
    cv::Size size_;
    std::vector<Features> features_;
    std::vector<std::vector<std::int64_t>> energy_; // per column
};

} // namespace altiro3D
