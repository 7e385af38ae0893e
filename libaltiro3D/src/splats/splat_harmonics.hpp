#pragma once

#include "splats/splat_collector.hpp"

namespace altiro3D {

/// What the harmonics of a splat add to its colour.
/// @param harmonics red, green, blue of each coefficient
/// @param degree 1..3
/// @param direction from the eye to the splat, of length 1, in the axes of the scene
inline cv::Vec3f colourOfHarmonics(const float* harmonics, int degree, const cv::Vec3f& direction) {
    const float x = direction[0];
    const float y = direction[1];
    const float z = direction[2];
    const float xx = x * x;
    const float yy = y * y;
    const float zz = z * z;
    // Real spherical harmonics in the order and with the signs of 3DGS.
    const float values[15] = {-0.48860251F * y,
                              0.48860251F * z,
                              -0.48860251F * x,
                              1.09254843F * x * y,
                              -1.09254843F * y * z,
                              0.31539157F * (2 * zz - xx - yy),
                              -1.09254843F * x * z,
                              0.54627422F * (xx - yy),
                              -0.59004359F * y * (3 * xx - yy),
                              2.89061144F * x * y * z,
                              -0.45704580F * y * (4 * zz - xx - yy),
                              0.37317633F * z * (2 * zz - 3 * xx - 3 * yy),
                              -0.45704580F * x * (4 * zz - xx - yy),
                              1.44530572F * z * (xx - yy),
                              -0.59004359F * x * (xx - 3 * yy)};
    cv::Vec3f sum;
    const std::size_t count = coefficientsOf(degree);
    for (std::size_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c)
            sum[c] += values[i] * harmonics[3 * i + static_cast<std::size_t>(c)];
    return sum;
}

} // namespace altiro3D
