#include "altiro3D/lens_sheet.hpp"

#include "base/checks.hpp"
#include "base/json_reader.hpp"

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

std::string calibrationText(const Calibration& c) {
    validate(c);
    const auto wrapped = [](auto value) { return Json{{"value", value}}; };
    Json json = {{"configVersion", c.configVersion},
                 {"serial", c.serial},
                 {"pitch", wrapped(c.pitch)},
                 {"slope", wrapped(c.slope)},
                 {"center", wrapped(c.center)},
                 {"fringe", wrapped(c.fringe)},
                 {"viewCone", wrapped(c.viewCone)},
                 {"invView", wrapped(c.invView)},
                 {"verticalAngle", wrapped(c.verticalAngle)},
                 {"DPI", wrapped(c.DPI)},
                 {"screenW", wrapped(c.screenW)},
                 {"screenH", wrapped(c.screenH)},
                 {"flipImageX", wrapped(c.flipImageX)},
                 {"flipImageY", wrapped(c.flipImageY)},
                 {"flipSubp", wrapped(c.flipSubp)},
                 {"CellPatternMode", wrapped(c.CellPatternMode)}};
    json["subpixelCells"] = Json::array();
    for (const SubpixelCell& cell : c.subpixelCells) {
        json["subpixelCells"].push_back({{"ROffsetX", cell.x[0]},
                                         {"ROffsetY", cell.y[0]},
                                         {"GOffsetX", cell.x[1]},
                                         {"GOffsetY", cell.y[1]},
                                         {"BOffsetX", cell.x[2]},
                                         {"BOffsetY", cell.y[2]}});
    }
    if (c.lens) {
        json["subpixelLens"] = {{"period", c.lens->period},
                                {"slope", c.lens->slope},
                                {"offset", c.lens->offset},
                                {"slopeInSubpixels", c.lens->slopeInSubpixels}};
    }
    if (!c.viewOrder.empty()) json["viewOrder"] = c.viewOrder;
    if (c.sheet) {
        json["lensSheet"] = {{"print", c.sheet->isPrint}, {"dpiDown", c.sheet->dpiDown},
                             {"views", c.sheet->views},   {"thickness", c.sheet->thickness},
                             {"index", c.sheet->index},   {"distance", c.sheet->distance}};
    }
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
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
    // two lenses between neighbouring views
    facts.sharpStrength = std::min(100.0, 200 * views * pitch / facts.width);
    return facts;
}

} // namespace altiro3D
