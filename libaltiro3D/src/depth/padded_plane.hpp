#pragma once

#include "base/pixel_rows.hpp"

#include <cstddef>
#include <vector>

namespace altiro3D {

/// One number per px, row by row. Each row is padded (kRowPadding), so kernels can read and write
/// whole vectors.
template <class T>
class PaddedPlane {
  public:
    PaddedPlane(std::size_t columns, std::size_t rows)
        : columns_(columns), rows_(rows), values_((columns + kRowPadding) * rows) {}
    std::size_t columns() const { return columns_; }
    std::size_t rows() const { return rows_; }
    T* row(std::size_t y) { return values_.data() + y * (columns_ + kRowPadding); }
    const T* row(std::size_t y) const { return values_.data() + y * (columns_ + kRowPadding); }

  private:
    std::size_t columns_;
    std::size_t rows_;
    std::vector<T> values_;
};

} // namespace altiro3D
