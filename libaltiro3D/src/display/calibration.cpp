#include "altiro3D/display.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/image_format.hpp"
#include "base/json_reader.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>

namespace altiro3D {

namespace {

constexpr std::uintmax_t kMaxFileBytes = 4 * 1024 * 1024;
constexpr int kMaxContainers = 3;
constexpr std::size_t kMaxCells = 16;
constexpr std::size_t kMaxNumberBytes = 100; // bytes; longer texts are not read
// Lens periods; larger values leave too few digits for the fraction.
constexpr double kMaxCenter = 1e6;

[[noreturn]] void fail(const std::string& source, const std::string& problem) {
    throw Error(ErrorCode::BadFormat, source, problem);
}

std::string show(double value) {
    return numberText(value, 12);
}

Json parseDocument(const std::string& text, const std::string& source) {
    if (imageFormat(text) != ImageFormat::Unknown)
        fail(source, "is a picture, expected a display's visual.json");
    return parseJson(text, source, "a display's visual.json");
}

// Parses a string of the document as JSON; null if it is not JSON.
Json parseInner(const std::string& text) {
    try {
        return parseJson(text, {}, {});
    } catch (const Error&) {
        return nullptr;
    }
}

// Which spelling of a CubeVi's numbers an object has, perhaps not all of them; nothing for others.
std::optional<int> cubeViSpelling(const Json& node) {
    const auto has = [&](const char* key) { return node.contains(key) ? 1 : 0; };
    if (!node.is_object() || node.contains("pitch")) return std::nullopt;
    if (has("lineNumber") + has("obliquity") + has("deviation") > 0) return 0;
    if (has("interval") + has("slope") + has("x0") > 1) return 1; // a slope alone is another's
    return std::nullopt;
}

// Collects the objects that have pitch and slope, or the keys of a CubeVi: the document itself, or
// objects up to three containers deep. A string that holds an object is treated as that object.
void findCalibrations(const Json& node, int containersLeft, std::vector<Json>& found) {
    if ((node.is_object() && node.contains("pitch") && node.contains("slope")) ||
        cubeViSpelling(node)) {
        found.push_back(node);
    } else if (node.is_string()) {
        const auto& text = node.get_ref<const std::string&>();
        if (text.empty() || text[0] != '{') return;
        findCalibrations(parseInner(text), containersLeft, found);
    } else if (node.is_structured() && containersLeft > 0) {
        for (const auto& child : node)
            findCalibrations(child, containersLeft - 1, found);
    }
}

// Reads the fields of one calibration object; errors name the field.
class FieldReader {
  public:
    FieldReader(const Json& object, std::string source)
        : object_(object), source_(std::move(source)) {}

    // @param fallback not given: the field is required
    double read(const char* field, const std::string& expected,
                std::optional<double> fallback = std::nullopt) const {
        const Json* value = find(field);
        if (value != nullptr) return number(*value, field, expected);
        if (fallback) return *fallback;
        fail(source_, std::string(field) + " is missing, expected " + expected);
    }

    int readInteger(const char* field, const std::string& expected,
                    std::optional<double> fallback = std::nullopt) const {
        const double value = read(field, expected, fallback);
        if (!(std::abs(value) <= 1e9) || value != std::floor(value)) {
            fail(source_, std::string(field) + " is " + show(value) + ", expected " + expected);
        }
        return static_cast<int>(value);
    }

    std::string text(const char* field) const {
        const Json* value = find(field);
        return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
    }

    const Json* find(const char* field) const {
        auto found = object_.find(field);
        if (found == object_.end()) return nullptr;
        const Json* value = &*found;
        if (value->is_object() && value->contains("value")) value = &value->at("value");
        return value->is_null() ? nullptr : value;
    }

    double number(const Json& value, const std::string& field, const std::string& expected) const {
        if (value.is_number()) return value.get<double>();
        if (value.is_boolean()) return value.get<bool>() ? 1 : 0;
        if (value.is_string()) { // "52.5" is a number, "52.5 lpi" is not, in every locale
            const auto& text = value.get_ref<const std::string&>();
            if (text.size() <= kMaxNumberBytes) {
                const Json inner = parseInner(text);
                if (inner.is_number()) return inner.get<double>();
            }
        }
        fail(source_, field + " is " + shownJson(value) + ", expected " + expected);
    }

  private:
    const Json& object_;
    std::string source_;
};

constexpr const char* kExpectedPitch = "lenses per inch, a number > 0";
constexpr const char* kExpectedSlope = "a number other than 0";
constexpr const char* kExpectedNumber = "a finite number";
constexpr const char* kExpectedCenter = "lens periods, -1e6..1e6";
constexpr const char* kExpectedDpi = "px per inch, a number > 0";
constexpr const char* kExpectedSide = "whole px, 16..16384";
constexpr const char* kExpectedPrintSide = "whole px, 16..40000";
constexpr const char* kExpectedCone = "degrees, 0..180";
constexpr const char* kExpectedPattern = "a whole number, 0..4";
constexpr const char* kExpectedOffset = "px, -1..1";

std::vector<SubpixelCell> readCells(const FieldReader& reader, const std::string& source) {
    std::vector<SubpixelCell> cells;
    const Json* list = reader.find("subpixelCells");
    if (list == nullptr) return cells;
    if (!list->is_array()) {
        fail(source, "subpixelCells is " + shownJson(*list) + ", expected a list of cells");
    }
    if (list->size() > kMaxCells) {
        fail(source, "subpixelCells has " + std::to_string(list->size()) +
                         " cells, expected at most " + std::to_string(kMaxCells));
    }
    constexpr const char* kNames[3][2] = {
        {"ROffsetX", "ROffsetY"}, {"GOffsetX", "GOffsetY"}, {"BOffsetX", "BOffsetY"}};
    for (std::size_t i = 0; i < list->size(); ++i) {
        const std::string name = source + ": subpixelCells[" + std::to_string(i) + "]";
        if (!(*list)[i].is_object()) {
            fail(name,
                 "is " + shownJson((*list)[i]) + ", expected an object with ROffsetX ... BOffsetY");
        }
        const FieldReader cellReader((*list)[i], name);
        SubpixelCell cell;
        for (std::size_t k = 0; k < 3; ++k) {
            cell.x[k] = cellReader.read(kNames[k][0], kExpectedOffset);
            cell.y[k] = cellReader.read(kNames[k][1], kExpectedOffset);
        }
        cells.push_back(cell);
    }
    return cells;
}

void require(bool good, const std::string& source, const char* field, double value,
             const std::string& expected) {
    if (!good) fail(source, std::string(field) + " is " + show(value) + ", expected " + expected);
}

// The range of each number of a sheet; 0 stands for one that is not known.
struct SheetNumber {
    const char* field;
    double LensSheet::*number;
    double low;
    double high;
    const char* expected;
};
constexpr SheetNumber kSheetNumbers[] = {
    {"thickness", &LensSheet::thickness, 0.01, 100, "mm, 0.01..100, or 0"},
    {"index", &LensSheet::index, 1, 3, "a number, 1..3, or 0"},
    {"distance", &LensSheet::distance, 1, 1e6, "mm, 1..1e6, or 0"}};
constexpr const char* kExpectedViews = "a whole number, 2..1024, or 0";

std::optional<LensSheet> readSheet(const FieldReader& reader, double dpi,
                                   const std::string& source) {
    const Json* const object = reader.find("lensSheet");
    if (object == nullptr) return std::nullopt;
    if (!object->is_object())
        fail(source, "lensSheet is " + shownJson(*object) + ", expected an object");
    const FieldReader fields(*object, source + ": lensSheet");
    LensSheet sheet;
    sheet.isPrint = fields.read("print", "true or false", 0) >= 0.5;
    sheet.dpiDown = fields.read("dpiDown", kExpectedDpi, dpi);
    sheet.views = fields.readInteger("views", kExpectedViews, 0);
    for (const SheetNumber& of : kSheetNumbers)
        sheet.*of.number = fields.read(of.field, of.expected, 0);
    return sheet;
}

constexpr std::size_t kMaxOrderedViews = 64;
constexpr const char* kExpectedPeriod = "sub-pixels across a lens, 2..1000";
constexpr const char* kExpectedOrder = "each of the views 0..N-1 once, 2 to 64 of them";

bool isPermutation(std::vector<int> order) {
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < order.size(); ++i)
        if (order[i] != static_cast<int>(i)) return false;
    return order.size() != 1 && order.size() <= kMaxOrderedViews;
}

// c has DPI and panel.
void readLens(const FieldReader& reader, const std::string& source, Calibration& c) {
    if (const Json* const order = reader.find("viewOrder")) {
        if (!order->is_array() || order->size() > kMaxOrderedViews)
            fail(source, "viewOrder is " + shownJson(*order) + ", expected " + kExpectedOrder);
        for (const Json& view : *order)
            c.viewOrder.push_back(view.is_number_unsigned() && view < 64 ? view.get<int>() : -1);
    }
    const Json* const object = reader.find("subpixelLens");
    if (object == nullptr) return;
    if (!object->is_object())
        fail(source, "subpixelLens is " + shownJson(*object) + ", expected an object");
    const FieldReader fields(*object, source + ": subpixelLens");
    setLens(c, {fields.read("period", kExpectedPeriod), fields.read("slope", kExpectedNumber),
                fields.read("offset", kExpectedNumber),
                fields.read("slopeInSubpixels", "true or false", 0) >= 0.5});
}

struct CubeViNumber {
    const char* keys[2]; // two spellings
    double low;
    double high;
    const char* expected;
};
constexpr CubeViNumber kCubeViNumbers[] = {
    {{"lineNumber", "interval"}, 10, 40, "sub-pixels across a lens, 10..40"},
    {{"obliquity", "slope"}, -0.4999999, 0.4999999, "px per row, above -0.5 and below 0.5"},
    {{"deviation", "x0"}, -100, 100, "sub-pixels, -100..100"}};

Calibration readCubeVi(const Json& object, int spelling, const std::string& source) {
    constexpr double kInches = 5.7; // diagonal of the panel
    const FieldReader reader(object, source);
    double numbers[3];
    for (std::size_t i = 0; i < 3; ++i) {
        const CubeViNumber& of = kCubeViNumbers[i];
        const char* const key = of.keys[spelling];
        numbers[i] = reader.read(key, of.expected);
        if (!(numbers[i] >= of.low && numbers[i] <= of.high) || !reader.find(key)->is_number())
            fail(source, std::string(key) + " is " + shownJson(*reader.find(key)) + ", expected " +
                             of.expected);
    }
    Calibration c;
    c.serial = "cubevi-c1";
    c.screenW = 1440;
    c.screenH = 2560;
    c.DPI = std::hypot(c.screenW, c.screenH) / kInches;
    c.viewCone = 40;
    setLens(c, {numbers[0], numbers[1], numbers[2], false});
    return c;
}

void validateSheet(const LensSheet& sheet, const std::string& source) {
    require(sheet.dpiDown >= 10 && sheet.dpiDown <= 10000, source, "dpiDown", sheet.dpiDown,
            "px per inch, 10..10000");
    require(sheet.views == 0 || (sheet.views >= 2 && sheet.views <= kMaxSheetViews), source,
            "views", sheet.views, kExpectedViews);
    for (const SheetNumber& of : kSheetNumbers) {
        const double value = sheet.*of.number;
        require(value == 0 || (value >= of.low && value <= of.high), source, of.field, value,
                of.expected);
    }
    require((sheet.thickness == 0) == (sheet.index == 0), source, "index", sheet.index,
            "thickness and index together");
}

Calibration readFields(const Json& object, const std::string& source) {
    if (const auto spelling = cubeViSpelling(object)) return readCubeVi(object, *spelling, source);
    const FieldReader reader(object, source);
    Calibration c;
    c.configVersion = reader.text("configVersion");
    c.serial = reader.text("serial");
    c.pitch = reader.read("pitch", kExpectedPitch);
    c.slope = reader.read("slope", kExpectedSlope);
    c.center = reader.read("center", kExpectedNumber);
    c.DPI = reader.read("DPI", kExpectedDpi);
    c.screenW = reader.readInteger("screenW", kExpectedSide);
    c.screenH = reader.readInteger("screenH", kExpectedSide);
    c.fringe = reader.read("fringe", kExpectedNumber, c.fringe);
    c.viewCone = reader.read("viewCone", kExpectedCone, c.viewCone);
    c.invView = reader.read("invView", kExpectedNumber, c.invView);
    c.verticalAngle = reader.read("verticalAngle", kExpectedNumber, c.verticalAngle);
    c.flipImageX = reader.read("flipImageX", kExpectedNumber, c.flipImageX);
    c.flipImageY = reader.read("flipImageY", kExpectedNumber, c.flipImageY);
    c.flipSubp = reader.read("flipSubp", kExpectedNumber, c.flipSubp);
    const char* pattern =
        reader.find("CellPatternMode") != nullptr ? "CellPatternMode" : "cellPatternMode";
    c.CellPatternMode = reader.readInteger(pattern, kExpectedPattern, c.CellPatternMode);
    c.subpixelCells = readCells(reader, source);
    for (const char* field : {"viewCone", "invView"})
        if (reader.find(field) == nullptr) c.missing.emplace_back(field);
    c.sheet = readSheet(reader, c.DPI, source);
    readLens(reader, source, c);
    validate(c, source);
    return c;
}

} // namespace

void validate(const Calibration& c, const std::string& source) {
    if (!isPermutation(c.viewOrder))
        fail(source, std::string("the order of views repeats a view or lacks one, expected ") +
                         kExpectedOrder);
    if (c.lens) {
        const SubpixelLens& lens = *c.lens;
        const double steepest = lens.slopeInSubpixels ? 3 : 1;
        require(lens.period >= 2 && lens.period <= 1000, source, "period of the lens", lens.period,
                kExpectedPeriod);
        require(std::abs(lens.slope) <= steepest, source, "slope of the lens", lens.slope,
                lens.slopeInSubpixels ? "sub-pixels per row, -3..3" : "px per row, -1..1");
        require(std::abs(lens.offset) <= 1e4, source, "offset of the lens", lens.offset,
                "sub-pixels, -10000..10000");
    }
    require(std::isfinite(c.pitch) && c.pitch > 0, source, "pitch", c.pitch, kExpectedPitch);
    require(std::isfinite(c.slope) && c.slope != 0, source, "slope", c.slope, kExpectedSlope);
    require(std::abs(c.center) <= kMaxCenter, source, "center", c.center, kExpectedCenter);
    require(std::isfinite(c.DPI) && c.DPI > 0, source, "DPI", c.DPI, kExpectedDpi);
    const bool isPrint = c.sheet && c.sheet->isPrint;
    for (const auto& [field, side] : {std::pair("screenW", c.screenW), {"screenH", c.screenH}}) {
        require(side >= 16 && side <= (isPrint ? kMaxPrintSide : kMaxPanelSide), source, field,
                side, isPrint ? kExpectedPrintSide : kExpectedSide);
    }
    if (c.sheet) validateSheet(*c.sheet, source + ": lensSheet");
    require(c.viewCone >= 0 && c.viewCone <= 180, source, "viewCone", c.viewCone, kExpectedCone);
    const std::pair<const char*, double> plainNumbers[] = {{"fringe", c.fringe},
                                                           {"invView", c.invView},
                                                           {"verticalAngle", c.verticalAngle},
                                                           {"flipImageX", c.flipImageX},
                                                           {"flipImageY", c.flipImageY},
                                                           {"flipSubp", c.flipSubp}};
    for (const auto& [field, value] : plainNumbers) {
        require(std::isfinite(value), source, field, value, kExpectedNumber);
    }
    require(c.CellPatternMode >= 0 && c.CellPatternMode <= 4, source, "CellPatternMode",
            c.CellPatternMode, kExpectedPattern);
    if (c.subpixelCells.size() > kMaxCells) {
        fail(source, "subpixelCells has " + std::to_string(c.subpixelCells.size()) +
                         " cells, expected at most " + std::to_string(kMaxCells));
    }
    for (std::size_t i = 0; i < c.subpixelCells.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            for (double offset : {c.subpixelCells[i].x[k], c.subpixelCells[i].y[k]}) {
                const std::string field = "subpixelCells[" + std::to_string(i) + "] offset";
                require(std::abs(offset) <= 1, source, field.c_str(), offset, kExpectedOffset);
            }
        }
    }
    // Fields in range can still have a product that the mapping cannot resolve.
    const double periods = c.pitch * c.screenW / c.DPI;
    const double tilt = c.screenH / (c.screenW * std::abs(c.slope));
    const double down = tilt * periods * std::min(1.0, std::abs(c.slope)); // for horizontal lenses
    if (!(periods >= 1e-3 && periods <= 3.0 * c.screenW) || !(down <= 1e6) || !(tilt <= 1e12)) {
        fail(source, "pitch " + show(c.pitch) + ", DPI " + show(c.DPI) + " and slope " +
                         show(c.slope) +
                         " describe no lens array, expected 0.001 periods to one per sub-pixel"
                         " across the panel");
    }
}

std::vector<Calibration> parseCalibrations(const std::string& text, const std::string& source) {
    const Json document = parseDocument(text, source); // skips a byte order mark
    std::vector<Json> objects;
    findCalibrations(document, kMaxContainers, objects);
    if (objects.empty()) {
        const bool half =
            document.is_object() && (document.contains("pitch") || document.contains("slope"));
        if (!half) {
            fail(source, "holds no calibration, expected an object with pitch, slope and center");
        }
        objects.push_back(document); // the reader then names the missing field
    }
    std::vector<Calibration> calibrations;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const bool several = objects.size() > 1;
        calibrations.push_back(readFields(
            objects[i], several ? source + ": calibration " + std::to_string(i + 1) : source));
    }
    return calibrations;
}

std::vector<Calibration> readCalibrations(const std::filesystem::path& file) {
    return parseCalibrations(readFile(file, kMaxFileBytes), file.string());
}

Calibration readCalibration(const std::filesystem::path& file) {
    return readCalibrations(file).front();
}

std::uint64_t fingerprint(const Calibration& c) {
    std::uint64_t hash = 0xcbf29ce484222325; // FNV-1a, 64 bit
    const auto add = [&hash](double value) {
        if (value == 0) value = 0; // -0 and 0 must give the same hash
        std::uint64_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        for (int byte = 0; byte < 8; ++byte) {
            hash = (hash ^ ((bits >> (8 * byte)) & 0xff)) * 0x100000001b3;
        }
    };
    const auto flag = [](double value) { return value >= 0.5 ? 1.0 : 0.0; };
    const bool cells = !c.subpixelCells.empty();
    for (double value : {c.pitch, c.slope, c.center, c.DPI, double(c.screenW), double(c.screenH),
                         flag(c.invView), flag(c.flipImageX), flag(c.flipImageY), flag(c.flipSubp),
                         cells ? double(c.CellPatternMode) : 0.0}) {
        add(value);
    }
    for (const SubpixelCell& cell : c.subpixelCells) {
        for (std::size_t k = 0; k < 3; ++k) {
            add(cell.x[k]);
            add(cell.y[k]);
        }
    }
    if (c.lens) // its pitch, slope and center are rounded
        for (double value : {c.lens->period, c.lens->slope, c.lens->offset})
            add(value);
    for (int view : c.viewOrder)
        add(view);
    return hash;
}

std::string fingerprintText(std::uint64_t value) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
    return text;
}

LensGeometry lensGeometry(const Calibration& c, InvertViews invert) {
    validate(c, c.serial.empty() ? "calibration" : "calibration of " + c.serial);
    LensGeometry g;
    const double mirror = c.flipImageX >= 0.5 ? -1 : 1;
    // cos(atan(1/s)) without the two roundings of trigonometry; 1 from 1e8 on
    const double steepness = std::min(std::abs(c.slope), 1e100); // its square is finite
    const double cosine = steepness / std::sqrt(1 + steepness * steepness);
    g.panelWidth = c.screenW;
    g.panelHeight = c.screenH;
    g.periodsPerWidth = c.pitch * c.screenW / c.DPI * cosine;
    g.tilt = c.screenH / (c.screenW * c.slope) * mirror;
    g.subpixelStep = 1.0 / (3.0 * c.screenW) * mirror;
    g.center = c.center;
    g.lensPeriodSubpixels = 3.0 * c.screenW / g.periodsPerWidth;
    g.offsetSubpixels = c.center * g.lensPeriodSubpixels - 1.5 - 3.0 * (c.screenH - 0.5) / c.slope;
    g.cells = c.subpixelCells;
    g.cellPattern = g.cells.empty() ? 0 : c.CellPatternMode;
    g.inverted = invert == InvertViews::On ||
                 (invert == InvertViews::Auto && (!g.cells.empty() || c.invView >= 0.5));
    g.mirrorX = c.flipImageX >= 0.5;
    g.mirrorY = c.flipImageY >= 0.5;
    g.blueFirst = c.flipSubp >= 0.5;
    if (g.cells.empty() && !g.mirrorX) g.lens = c.lens;
    g.viewOrder = c.viewOrder;
    return g;
}

int LensGeometry::cellIndex(int x, int y) const {
    if (cells.empty()) return 0;
    const int fromBottom = panelHeight - 1 - y;
    const int indices[] = {0, (x + fromBottom) % 2, x % 2, (fromBottom + 2 * (x % 2)) % 4,
                           fromBottom % 2};
    return indices[cellPattern] % static_cast<int>(cells.size());
}

double LensGeometry::phase(int x, int y, int colour) const {
    const int k = blueFirst ? 2 - colour : colour;
    const double u = (x + 0.5) / panelWidth;
    const double v = 1 - (y + 0.5) / panelHeight;
    double a = 0;
    if (lens) {
        a = lens->wholePlace(x, y, k) / lens->period;
    } else if (cells.empty()) {
        a = (u + k * subpixelStep + v * tilt) * periodsPerWidth - center;
    } else {
        const SubpixelCell& cell = cells[static_cast<std::size_t>(cellIndex(x, y))];
        const auto c = static_cast<std::size_t>(k);
        const double mirror = mirrorX ? -1 : 1; // same sign as the sub-pixel step
        a = ((u + mirror * cell.x[c] / panelWidth) + (v + cell.y[c] / panelHeight) * tilt) *
                periodsPerWidth -
            center;
    }
    const double z = a - std::floor(a);
    return inverted ? 1 - z : z;
}

int LensGeometry::viewOfPhase(double phase, int views) {
    const int view = static_cast<int>(phase * views); // phase >= 0: truncation is floor
    return view < views ? view : views - 1;
}

} // namespace altiro3D
