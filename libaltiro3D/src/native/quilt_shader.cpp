#include "altiro3D/quilt2native.hpp"

#include "base/text.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace altiro3D {

namespace {

// A literal of GLSL with the nine digits that a float needs, independent of the locale.
std::string literal(double value) {
    const std::string text = numberText(value, 9);
    return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string pair(double x, double y) {
    return "vec2(" + literal(x) + ", " + literal(y) + ")";
}

double fraction(double a) {
    return a - std::floor(a);
}

// The fraction of the periods per px, as the sum of two numbers. The product of the first one and
// the number of a px fits into the 24 bits of a float, so its fraction is exact.
struct Step {
    double high;
    double low;

    Step(double periods, int length) {
        const int bits = 24 - std::ilogb(2 * length - 1); // numbers of px are below `length`
        high = std::ldexp(std::floor(std::ldexp(fraction(periods), bits)), -bits);
        low = fraction(periods) - high;
    }
};

// z of the panel's top left pixel (1.4) to (1.9), if it had this cell: red, green, blue.
std::string startOf(const SubpixelCell& cell, const LensGeometry& g) {
    std::string text = "vec3(";
    for (int colour = 0; colour < 3; ++colour) {
        const auto k = static_cast<std::size_t>(g.blueFirst ? 2 - colour : colour);
        const double u = (0.5 + (g.mirrorX ? -1 : 1) * cell.x[k]) / g.panelWidth;
        const double v = 1 - (0.5 - cell.y[k]) / g.panelHeight;
        const double a = (u + v * g.tilt) * g.periodsPerWidth - g.center;
        text += literal(fraction(g.inverted ? -a : a)) + (colour < 2 ? ", " : ")");
    }
    return text;
}

// Colours of stripes, as the cell of (1.6).
SubpixelCell stripes() {
    SubpixelCell cell;
    cell.x = {0, 1.0 / 3, 2.0 / 3};
    return cell;
}

} // namespace

std::string quiltShader(const Calibration& calibration, const QuiltLayout& quilt,
                        QuiltSampling sampling, InvertViews invert) {
    validate(quilt);
    const LensGeometry g = lensGeometry(calibration, invert);
    if (!g.viewOrder.empty())
        throw Error(
            ErrorCode::Unsupported, "calibration",
            "has views in another order, which the shader does not know, expected a Native");
    const int sign = g.inverted ? -1 : 1;
    const Step across(sign * g.periodsPerWidth / g.panelWidth, g.panelWidth);
    const Step down(-sign * g.tilt * g.periodsPerWidth / g.panelHeight, g.panelHeight);

    std::vector<SubpixelCell> cells = g.cells;
    if (cells.empty()) cells = {stripes()};
    cells.resize(std::min<std::size_t>(cells.size(), 4)); // LensGeometry::cellIndex()
    const std::string count = std::to_string(cells.size());
    std::string starts;
    for (const SubpixelCell& cell : cells)
        starts += (starts.empty() ? "" : ",\n    ") + startOf(cell, g);
    constexpr const char* kCellIndices[] = {"0.0", "mod(p.x + up, 2.0)", "mod(p.x, 2.0)",
                                            "mod(up + 2.0 * mod(p.x, 2.0), 4.0)", "mod(up, 2.0)"};

    const std::string width = std::to_string(g.panelWidth);
    const std::string height = std::to_string(g.panelHeight);
    std::string text = "//!DESC altiro3D: quilt of " + std::to_string(quilt.columns) +
                       " columns x " + std::to_string(quilt.rows) + " rows to Native of " + width +
                       " x " + height +
                       " px\n"
                       "//!HOOK MAINPRESUB\n"
                       "//!BIND HOOKED\n"
                       "//!WIDTH " +
                       width + "\n//!HEIGHT " + height + "\n\n";
    text += "const vec2 panel = " + pair(g.panelWidth, g.panelHeight) + ";\n";
    text += "const vec2 grid = " + pair(quilt.columns, quilt.rows) + ";\n";
    text += "const float views = " + literal(quilt.viewCount) + ";\n";
    text += "// lens periods per px: the first part times a whole number is exact\n";
    text += "const vec2 across = " + pair(across.high, across.low) + ";\n";
    text += "const vec2 down = " + pair(down.high, down.low) + ";\n";
    text += "// phase of the top left pixel, for each kind of pixel\n";
    text += "const vec3 starts[" + count + "] = vec3[" + count + "](\n    " + starts + ");\n";
    text += R"(
// The colour of a view at a place in it, 0..1 from its top left.
vec4 colourOf(float view, vec2 place) {
    float up = floor((view + 0.5) / grid.x);
    vec2 tile = vec2(view - up * grid.x, grid.y - 1.0 - up);
    vec2 size = HOOKED_size / grid;
    vec2 corner = tile * size;
    vec2 first = ceil(corner - 0.01) + 0.5;
    vec2 last = floor((tile + 1.0) * size + 0.01) - 0.5;
)";
    text += sampling.inTile == TileSampling::Linear
                ? "    vec2 px = corner + place * size;\n"
                : "    vec2 px = floor(corner) + floor(fract(corner) + place * size + 0.0001) + "
                  "0.5;\n";
    text += R"(    return HOOKED_tex(clamp(px, first, last) / HOOKED_size);
}

vec4 shown(float phase, vec2 place) {
)";
    text += sampling.views == ViewFilter::Linear
                ? "    float view = clamp(phase * views - 0.5, 0.0, views - 1.0);\n"
                  "    float next = min(floor(view) + 1.0, views - 1.0);\n"
                  "    return mix(colourOf(floor(view), place), colourOf(next, place), "
                  "fract(view));\n"
                : "    return colourOf(min(floor(phase * views), views - 1.0), place);\n";
    text += R"(}

vec4 hook() {
    vec2 p = floor(HOOKED_pos * panel); // column, row from the top
    float up = panel.y - 1.0 - p.y;
)";
    text += std::string("    int cell = int(mod(") + kCellIndices[g.cellPattern] + " + 0.5, " +
            literal(static_cast<double>(cells.size())) + "));\n";
    text += R"(    float x = fract(p.x * across.x) + p.x * across.y;
    float y = fract(p.y * down.x) + p.y * down.y;
    vec3 phase = fract(vec3(x + y) + starts[cell]);
    vec2 place = (p + 0.5) / panel;
)";
    if (g.mirrorX) text += "    place.x = 1.0 - place.x;\n";
    if (g.mirrorY) text += "    place.y = 1.0 - place.y;\n";
    text += R"(    return vec4(shown(phase.r, place).r, shown(phase.g, place).g,
                shown(phase.b, place).b, 1.0);
}
)";
    return text;
}

} // namespace altiro3D
