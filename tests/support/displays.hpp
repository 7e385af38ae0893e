#pragma once

#include "altiro3D/display.hpp"
#include "altiro3D/native_lut.hpp"
#include "support/pixels.hpp"

#include <vector>

namespace altiro3D::test {

/// A stripe panel of any size with a Portrait's lens numbers.
inline Calibration stripePanel(int width = 101, int height = 67) {
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

/// How many sub-pixels of a look-up table lie in another view than twin(x, y, colour) says.
template <class Twin>
int wrongViews(const Calibration& c, const QuiltLayout& layout, const Twin& twin) {
    const NativeLut lut(c, layout);
    int wrong = 0;
    forPixels({c.screenW, c.screenH}, [&](int x, int y) {
        for (int k = 0; k < 3; ++k) {
            const auto at = lut.channel(k).at<cv::Vec<std::uint16_t, 2>>(y, x);
            wrong += layout.tile(twin(x, y, k)).contains({at[0], at[1]}) ? 0 : 1;
        }
    });
    return wrong;
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
