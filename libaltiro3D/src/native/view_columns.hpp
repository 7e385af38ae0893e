#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace altiro3D {

/// One row of up to kMaxViews views, from which the sub-pixels of a panel's rows are taken. The
/// bytes that all views have at one place are side by side, so a panel whose neighbouring
/// sub-pixels show the same column of the photo finds them in registers.
class ViewColumns {
  public:
    static constexpr std::size_t kMaxViews = 64;

    /// @param columns of the photo under each column of the panel
    explicit ViewColumns(const std::vector<int>& columns);

    /// Reads the row of each view: 3 * photo width bytes, and up to kRowPadding beyond.
    void set(const std::vector<std::uint8_t*>& views, std::size_t rowBytes);

    /// The sub-pixels of one colour.
    /// @param channel 0 blue, 1 green, 2 red
    /// @param views view of each, padded (kRowPadding) @param values result, padded
    void pick(std::size_t channel, const std::uint8_t* views, std::uint8_t* values) const;

    /// Sub-pixels that show one column.
    struct Run {
        std::size_t begin; ///< The first one.
        std::size_t bytes; ///< Start of the column's views.
    };

  private:
    std::size_t count_;
    std::vector<Run> runs_; // and one behind the last sub-pixel
    std::size_t viewCount_ = 0;
    std::vector<std::uint8_t> bytes_; // kMaxViews for each byte of a row
};

} // namespace altiro3D
