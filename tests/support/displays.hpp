#pragma once

#include "altiro3D/calibration.hpp"

#include <vector>

namespace altiro3D::test {

/// A stripe panel of any size with a Portrait's lens numbers.
inline Calibration stripePanel(int width, int height) {
    Calibration c;
    c.serial = "TEST";
    c.pitch = 52.58;
    c.slope = -7.18;
    c.center = 0.46;
    c.DPI = 324;
    c.screenW = width;
    c.screenH = height;
    return c;
}

/// Two cells, red and green beside each other above or below blue.
inline std::vector<SubpixelCell> deltaCells() {
    SubpixelCell a;
    a.x = {-0.31, 0.28, 0};
    a.y = {0.25, 0.25, -0.25};
    SubpixelCell b;
    b.x = a.x;
    b.y = {-0.25, -0.25, 0.25};
    return {a, b};
}

} // namespace altiro3D::test
