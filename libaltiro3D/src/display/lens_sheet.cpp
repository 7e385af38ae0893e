#include "altiro3D/lens_sheet.hpp"

#include "base/checks.hpp"

#include <algorithm>
#include <cmath>

namespace altiro3D {

namespace {

constexpr double kMmPerInch = 25.4;
constexpr double kVertical = 1e9; // slope: `visual.json` has no infinite one

// Lens periods per px, across and down.
struct LensFrequency {
    double across;
    double down;
};

LensFrequency frequencyOf(const Calibration& c) {
    const LensGeometry g = lensGeometry(c);
    return {g.periodsPerWidth / g.panelWidth, std::abs(g.tilt) * g.periodsPerWidth / g.panelHeight};
}

// Colours one above the other: the centre of red is a third of a px above that of green.
bool hasStripesDown(const Calibration& c) {
    return !c.subpixelCells.empty() && c.subpixelCells.front().y[0] != 0;
}

int sideOf(const char* field, double millimetres, double dpi, int most) {
    const double side = millimetres / kMmPerInch * dpi;
    checkNumber(side >= 16 && side < most + 0.5, field, millimetres,
                numberText(16 * kMmPerInch / dpi, 4) + ".." +
                    numberText(most * kMmPerInch / dpi, 6) + " mm, which are 16.." +
                    std::to_string(most) + " px");
    return static_cast<int>(std::lround(side));
}

void checkOptional(const char* field, double value, double low, double high,
                   const std::string& unit) {
    if (value != 0) checkRange(field, value, low, high, unit);
}

} // namespace

void setSubpixels(Calibration& c, SubpixelOrder order) {
    c.flipSubp = order == SubpixelOrder::Bgr ? 1 : 0;
    c.CellPatternMode = 0;
    c.subpixelCells.clear();
    if (order == SubpixelOrder::None) c.subpixelCells.emplace_back();
    if (order == SubpixelOrder::VerticalRgb)
        c.subpixelCells.push_back({{0, 0, 0}, {1.0 / 3, 0, -1.0 / 3}});
}

Calibration calibrationOf(const LensNumbers& n) {
    const bool isPrint = n.subpixels == SubpixelOrder::None;
    const double dpiDown = n.dpiDown == 0 ? n.dpi : n.dpiDown;
    checkNumber(std::isfinite(n.lpi) && n.lpi > 0, "lpi", n.lpi, "lenses per inch, above 0");
    checkRange("dpi", n.dpi, 10, 10000);
    checkRange("dpi", dpiDown, 10, 10000);
    const int longest = isPrint ? kMaxPrintSide : kMaxPanelSide;
    checkNumber(n.angle >= -45 && n.angle <= 45, "angle", n.angle,
                std::string("-45..45 degrees from the ") +
                    (n.isHorizontal ? "horizontal" : "vertical; lying lenses are horizontal=yes"));
    checkNumber(n.views == 0 || (n.views >= 2 && n.views <= kMaxSheetViews), "views", n.views,
                "2.." + std::to_string(kMaxSheetViews));
    checkOptional("thickness", n.thickness, 0.01, 100, " mm");
    checkOptional("index", n.index, 1, 3, "");
    checkOptional("distance", n.distance, 1, 1e6, " mm");
    check((n.thickness == 0) == (n.index == 0), n.index == 0 ? "index" : "thickness",
          "is missing, expected thickness and index together");

    Calibration c;
    c.configVersion = "1.0";
    c.screenW = sideOf("width", n.width, n.dpi, longest);
    c.screenH = sideOf("height", n.height, dpiDown, longest);
    // lens periods per px; with unequal dpi, slope and pitch are those in px of the width
    const double turn = n.angle * CV_PI / 180;
    const double along = n.lpi * std::cos(turn);
    const double aside = n.lpi * std::sin(turn);
    const double across = (n.isHorizontal ? std::abs(aside) : along) / n.dpi;
    const double down = (n.isHorizontal ? along : std::abs(aside)) / dpiDown;
    const double steepness = std::clamp(across / down, 1 / kVertical, kVertical);
    c.slope = n.angle > 0 ? -steepness : steepness; // y counts down
    c.pitch = std::hypot(across, down) * n.dpi;
    c.DPI = n.dpi;
    setSubpixels(c, n.subpixels);
    c.sheet = LensSheet{isPrint, dpiDown, n.views, n.thickness, n.index, n.distance};
    const double px = isPrint                                     ? std::hypot(across, down)
                      : n.subpixels == SubpixelOrder::VerticalRgb ? std::hypot(across, down / 3)
                                                                  : std::hypot(across / 3, down);
    checkNumber(px <= 0.5, "lpi", n.lpi,
                "at most " + numberText(n.lpi * 0.5 / px, 6) + ", with two " +
                    (isPrint ? "px" : "sub-pixels") + " under a lens");
    validate(c, "lens");
    c.viewCone = lensFacts(c).viewCone;
    return c;
}

void setLens(Calibration& c, const SubpixelLens& lens) {
    const double row = lens.slopeInSubpixels ? lens.slope : 3 * lens.slope;
    c.lens = lens;
    c.slope = std::abs(row) * kVertical > 3 ? -3 / row : kVertical;
    c.pitch = c.DPI * std::hypot(3, row) / lens.period;
    c.center = (1.5 - row * (c.screenH - 0.5) - lens.wholePlace(0, 0, 0)) / lens.period;
    c.center -= std::floor(c.center);
}

Calibration calibrationOf(const BarrierNumbers& n) {
    checkRange("pitch", n.pitch, 2, 1000, " sub-pixels");
    checkRange("slope", n.slope, -3, 3, " sub-pixels per row");
    checkRange("offset", n.offset, -1e4, 1e4, " sub-pixels");
    checkRange("dpi", n.dpi, 10, 10000, " px per inch");
    const auto ordered = static_cast<int>(n.order.size());
    checkNumber(n.views == 0 || ordered == 0 || n.views == ordered, "views", n.views,
                "as many as in order");
    Calibration c;
    c.configVersion = "1.0";
    c.screenW = n.panel.width;
    c.screenH = n.panel.height;
    c.DPI = n.dpi;
    c.viewOrder = n.order;
    c.invView = n.order.empty() ? 1 : 0;
    setSubpixels(c, n.isBgr ? SubpixelOrder::Bgr : SubpixelOrder::Rgb);
    c.sheet = LensSheet{false, n.dpi, n.views == 0 ? ordered : n.views, 0, 0, 0};
    setLens(c, {n.pitch, 0 - n.slope, 0 - n.offset, true});
    validate(c, "lens");
    return c;
}

LensFacts lensFacts(const Calibration& c) {
    const LensFrequency f = frequencyOf(c);
    const LensSheet sheet = c.sheet.value_or(LensSheet{false, c.DPI});
    LensFacts facts;
    facts.width = c.screenW / c.DPI * kMmPerInch;
    facts.height = c.screenH / sheet.dpiDown * kMmPerInch;
    facts.lpi = std::hypot(f.across * c.DPI, f.down * sheet.dpiDown);
    const bool areStripesDown = hasStripesDown(c);
    const double stripesAcross = sheet.isPrint || areStripesDown ? 1 : 3;
    facts.usefulViews = 1 / std::hypot(f.across / stripesAcross, f.down / (areStripesDown ? 3 : 1));
    if (sheet.thickness == 0) return facts;
    const double pitch = kMmPerInch / facts.lpi;
    const double inside = std::sin(std::atan(pitch / (2 * sheet.thickness)));
    facts.viewCone = 360 / CV_PI * std::asin(std::min(1.0, sheet.index * inside));
    if (sheet.distance > 0)
        facts.visualLpi = facts.lpi / (1 + sheet.thickness / (sheet.index * sheet.distance));
    const double views =
        sheet.views > 0 ? std::min<double>(sheet.views, facts.usefulViews) : facts.usefulViews;
    facts.sharpDepth = 2 * views * sheet.thickness / sheet.index;
    // a parallax of two lens pitches between neighbouring views
    facts.sharpStrength = std::min(100.0, 200 * views * pitch / facts.width);
    return facts;
}

} // namespace altiro3D
