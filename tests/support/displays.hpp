#pragma once

#include "altiro3D/display.hpp"

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

/// A stripe panel with 3 columns and 2 rows of views of that size.
inline Display sixViewDisplay(int width, int height, cv::Size view) {
    Display display = displayOf(stripePanel(width, height), "small.json");
    display.quilt.columns = 3;
    display.quilt.rows = 2;
    display.quilt.viewCount = 6;
    display.quilt.tileSize = view;
    return display;
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
