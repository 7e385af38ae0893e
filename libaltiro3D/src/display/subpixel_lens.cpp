#include "altiro3D/lens_sheet.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D {

namespace {

constexpr double kVertical = 1e9; // slope: `visual.json` has no infinite one

double perRow(const SubpixelLens& lens) {
    return lens.slopeInSubpixels ? lens.slope : 3 * lens.slope;
}

} // namespace

double SubpixelLens::wholePlace(int x, int y, int k) const {
    // as published: the same roundings decide where a sub-pixel lies exactly between two views
    if (slopeInSubpixels) return 3 * x + k + 0.5 + y * slope + offset;
    return 3.0 * (x + 1 + (y + 1) * slope) + k + offset;
}

void setLens(Calibration& c, const SubpixelLens& lens) {
    const double row = perRow(lens);
    c.lens = lens;
    c.slope = std::abs(row) * kVertical > 3 ? -3 / row : kVertical;
    c.pitch = c.DPI * std::hypot(3, row) / lens.period;
    c.center = (1.5 - row * (c.screenH - 0.5) - lens.wholePlace(0, 0, 0)) / lens.period;
    c.center -= std::floor(c.center);
}

int LensGeometry::slot(int x, int y, int colour, int slots) const {
    if (!lens) return viewOfPhase(phase(x, y, colour), slots);
    double place = std::fmod(lens->wholePlace(x, y, blueFirst ? 2 - colour : colour), lens->period);
    if (place < 0) place += lens->period;
    const int fromLeft = std::min(static_cast<int>(slots * place / lens->period), slots - 1);
    return inverted ? slots - 1 - fromLeft : fromLeft;
}

int LensGeometry::view(int x, int y, int colour, int views) const {
    const auto count = static_cast<int>(viewOrder.size());
    if (count == 0) return slot(x, y, colour, views);
    if (count == views) return viewOrder[static_cast<std::size_t>(slot(x, y, colour, count))];
    const int fine = slot(x, y, colour, count * views); // at most 64 * 2^20
    const int place = viewOrder[static_cast<std::size_t>(fine / views)] * views + fine % views;
    return place / count;
}

Calibration calibrationOf(const BarrierNumbers& n) {
    Calibration c;
    c.configVersion = "1.0";
    c.screenW = n.panel.width;
    c.screenH = n.panel.height;
    c.DPI = n.dpi;
    c.viewOrder = n.order;
    c.invView = n.order.empty() ? 1 : 0;
    setSubpixels(c, n.isBgr ? SubpixelOrder::Bgr : SubpixelOrder::Rgb);
    const auto ordered = static_cast<int>(n.order.size());
    if (n.views != 0 && ordered != 0 && n.views != ordered)
        throw Error(ErrorCode::BadFormat, "lens",
                    "views is " + std::to_string(n.views) + ", expected as many as in order");
    c.sheet = LensSheet{false, n.dpi, n.views == 0 ? ordered : n.views, 0, 0, 0};
    setLens(c, {n.pitch, 0 - n.slope, 0 - n.offset, true});
    validate(c, "lens");
    return c;
}

} // namespace altiro3D
