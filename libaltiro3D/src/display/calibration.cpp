#include "altiro3D/display.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/lens_sheet.hpp"
#include "base/image_format.hpp"
#include "base/json_reader.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>

namespace altiro3D {

namespace {

constexpr std::uintmax_t kMaxFileBytes = 4 * 1024 * 1024;
constexpr int kMaxContainers = 3;
constexpr std::size_t kMaxCells = 16;
constexpr std::size_t kMaxNumberBytes = 100; // bytes; longer texts are not read
// Lens periods; larger values leave too few digits for the fraction.
constexpr double kMaxCenter = 1e6;
constexpr std::size_t kMaxOrderedViews = 64;

[[noreturn]] void fail(const std::string& source, const std::string& problem) {
    throw Error(ErrorCode::BadFormat, source, problem);
}

std::string show(double value) {
    return numberText(value, 12);
}

void require(bool good, const std::string& source, const char* field, double value,
             const std::string& expected) {
    if (!good) fail(source, std::string(field) + " is " + show(value) + ", expected " + expected);
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

// The keys of a CubeVi's three numbers, in both spellings.
using CubeViKeys = std::array<const char*, 3>;
constexpr CubeViKeys kCubeViSpellings[] = {{"lineNumber", "obliquity", "deviation"},
                                           {"interval", "slope", "x0"}};

// The spelling of the keys that an object has; null if it has neither.
const CubeViKeys* cubeViKeys(const Json& node) {
    if (!node.is_object() || node.contains("pitch")) return nullptr;
    for (const CubeViKeys& keys : kCubeViSpellings) {
        const auto has = [&](const char* key) { return node.contains(key); };
        const int least = &keys == kCubeViSpellings ? 1 : 2; // others have a slope as well
        if (std::count_if(keys.begin(), keys.end(), has) >= least) return &keys;
    }
    return nullptr;
}

// Collects the objects that have pitch and slope, or the keys of a CubeVi: the document itself, or
// objects up to three containers deep. A string that holds an object is treated as that object.
void findCalibrations(const Json& node, int containersLeft, std::vector<Json>& found) {
    if ((node.is_object() && node.contains("pitch") && node.contains("slope")) ||
        cubeViKeys(node) != nullptr) {
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

// The range of a number, and what an error says is expected.
struct Limits {
    double low;
    double high;
    const char* expected;
    bool isRequired = false; // in a file; the others keep the value that they have
    bool zeroIsGood = false; // 0 is allowed and means that the number is not known
};

constexpr double kLargest = std::numeric_limits<double>::max();
constexpr double kAboveZero = std::numeric_limits<double>::denorm_min();
constexpr Limits kAnyNumber{-kLargest, kLargest, "a finite number"};
constexpr Limits kRequiredNumber{-kLargest, kLargest, "a finite number", true};
constexpr Limits kSlope{-kLargest, kLargest, "a number other than 0", true};
constexpr Limits kPattern{0, 4, "a whole number, 0..4"};
constexpr Limits kSide{16, kMaxPanelSide, "whole px, 16..16384", true};
constexpr Limits kPrintSide{16, kMaxPrintSide, "whole px, 16..40000", true};
constexpr const char* kExpectedOrder = "each of the views 0..N-1 once, 2 to 64 of them";

// forNumbers() describes the numbers of an object of a visual.json, in their order there, for
// reading, checking and writing: visit(key, number, limits).
template <class Visit>
void forNumbers(Calibration& c, const Visit& visit) {
    const Limits& side = c.sheet && c.sheet->isPrint ? kPrintSide : kSide;
    visit("pitch", c.pitch, Limits{kAboveZero, kLargest, "lenses per inch, a number > 0", true});
    visit("slope", c.slope, kSlope);
    visit("center", c.center, kRequiredNumber);
    visit("fringe", c.fringe, kAnyNumber);
    visit("viewCone", c.viewCone, Limits{0, 180, "degrees, 0..180"});
    visit("invView", c.invView, kAnyNumber);
    visit("verticalAngle", c.verticalAngle, kAnyNumber);
    visit("DPI", c.DPI, Limits{kAboveZero, kLargest, "px per inch, a number > 0", true});
    visit("screenW", c.screenW, side);
    visit("screenH", c.screenH, side);
    visit("flipImageX", c.flipImageX, kAnyNumber);
    visit("flipImageY", c.flipImageY, kAnyNumber);
    visit("flipSubp", c.flipSubp, kAnyNumber);
    visit("CellPatternMode", c.CellPatternMode, kPattern);
}

template <class Visit>
void forNumbers(SubpixelCell& cell, const Visit& visit) {
    constexpr const char* kNames[3][2] = {
        {"ROffsetX", "ROffsetY"}, {"GOffsetX", "GOffsetY"}, {"BOffsetX", "BOffsetY"}};
    constexpr Limits kOffset{-1, 1, "px, -1..1", true};
    for (std::size_t k = 0; k < 3; ++k) {
        visit(kNames[k][0], cell.x[k], kOffset);
        visit(kNames[k][1], cell.y[k], kOffset);
    }
}

template <class Visit>
void forNumbers(LensSheet& sheet, const Visit& visit) {
    const auto orZero = [](double low, double high, const char* expected) {
        return Limits{low, high, expected, false, true};
    };
    visit("print", sheet.isPrint, Limits{0, 1, "true or false"});
    visit("dpiDown", sheet.dpiDown, Limits{10, 10000, "px per inch, 10..10000"});
    visit("views", sheet.views, orZero(2, kMaxSheetViews, "a whole number, 2..1024, or 0"));
    visit("thickness", sheet.thickness, orZero(0.01, 100, "mm, 0.01..100, or 0"));
    visit("index", sheet.index, orZero(1, 3, "a number, 1..3, or 0"));
    visit("distance", sheet.distance, orZero(1, 1e6, "mm, 1..1e6, or 0"));
}

template <class Visit>
void forNumbers(SubpixelLens& lens, const Visit& visit) {
    visit("period", lens.period, Limits{2, 1000, "sub-pixels across a lens, 2..1000", true});
    visit("slope", lens.slope,
          lens.slopeInSubpixels ? Limits{-3, 3, "sub-pixels per row, -3..3", true}
                                : Limits{-1, 1, "px per row, -1..1", true});
    visit("offset", lens.offset, Limits{-1e4, 1e4, "sub-pixels, -10000..10000", true});
    visit("slopeInSubpixels", lens.slopeInSubpixels, Limits{0, 1, "true or false"});
}

// The limits of the numbers of a CubeVi, in the order of CubeViKeys.
constexpr Limits kCubeViLimits[] = {
    {10, 40, "sub-pixels across a lens, 10..40", true},
    {-0.4999999, 0.4999999, "px per row, above -0.5 and below 0.5", true},
    {-100, 100, "sub-pixels, -100..100", true}};

// Reads the fields of an object; errors name the field.
class FieldReader {
  public:
    FieldReader(const Json& object, std::string source)
        : object_(object), source_(std::move(source)) {}

    template <class Number>
    void read(const char* field, Number& number, const Limits& limits) const {
        const Json* const value = find(field);
        if (value == nullptr && !limits.isRequired) return;
        if (value == nullptr)
            fail(source_, std::string(field) + " is missing, expected " + limits.expected);
        const double read = numberIn(*value, field, limits.expected);
        if constexpr (std::is_same_v<Number, int>)
            require(std::abs(read) <= 1e9 && read == std::floor(read), source_, field, read,
                    limits.expected);
        if constexpr (std::is_same_v<Number, bool>)
            number = read >= 0.5;
        else
            number = static_cast<Number>(read);
    }

    template <class Of>
    void readNumbers(Of& of) const {
        forNumbers(of, [this](const char* field, auto& number, const Limits& limits) {
            this->read(field, number, limits); // Clang 14 does not see it without `this`
        });
    }

    std::string text(const char* field) const {
        const Json* value = find(field);
        return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
    }

    // @return nothing if there is none
    std::optional<FieldReader> object(const char* field) const {
        const Json* const value = find(field);
        if (value == nullptr) return std::nullopt;
        if (!value->is_object())
            fail(source_, std::string(field) + " is " + shownJson(*value) + ", expected an object");
        return FieldReader(*value, source_ + ": " + field);
    }

    const Json* find(const char* field) const {
        auto found = object_.find(field);
        if (found == object_.end()) return nullptr;
        const Json* value = &*found;
        if (value->is_object() && value->contains("value")) value = &value->at("value");
        return value->is_null() ? nullptr : value;
    }

  private:
    double numberIn(const Json& value, const char* field, const char* expected) const {
        if (value.is_number()) return value.get<double>();
        if (value.is_boolean()) return value.get<bool>() ? 1 : 0;
        if (value.is_string()) { // "52.5" is a number, "52.5 lpi" is not, in every locale
            const auto& text = value.get_ref<const std::string&>();
            if (text.size() <= kMaxNumberBytes) {
                const Json inner = parseInner(text);
                if (inner.is_number()) return inner.get<double>();
            }
        }
        fail(source_, std::string(field) + " is " + shownJson(value) + ", expected " + expected);
    }

    const Json& object_;
    std::string source_;
};

void checkNumber(const char* field, double number, const Limits& limits,
                 const std::string& source) {
    const bool isInside = number >= limits.low && number <= limits.high;
    require(isInside || (limits.zeroIsGood && number == 0), source, field, number, limits.expected);
}

template <class Of>
void checkNumbers(Of of, const std::string& source) {
    forNumbers(of, [&](const char* field, double number, const Limits& limits) {
        checkNumber(field, number, limits, source);
    });
}

// @param isWrapped each as {"value": number}
template <class Of>
Json jsonOf(Of of, bool isWrapped = false) {
    Json json;
    forNumbers(of, [&](const char* field, auto number, const Limits& /*limits*/) {
        json[field] = isWrapped ? Json{{"value", number}} : Json(number);
    });
    return json;
}

std::vector<SubpixelCell> readCells(const FieldReader& reader, const std::string& source) {
    std::vector<SubpixelCell> cells;
    const Json* list = reader.find("subpixelCells");
    if (list == nullptr) return cells;
    if (!list->is_array())
        fail(source, "subpixelCells is " + shownJson(*list) + ", expected a list of cells");
    if (list->size() > kMaxCells) cells.resize(list->size()); // validate() refuses them
    for (std::size_t i = cells.size(); i < list->size(); ++i) {
        const std::string name = source + ": subpixelCells[" + std::to_string(i) + "]";
        const Json& cell = (*list)[i];
        if (!cell.is_object())
            fail(name, "is " + shownJson(cell) + ", expected an object with ROffsetX ... BOffsetY");
        FieldReader(cell, name).readNumbers(cells.emplace_back());
    }
    return cells;
}

bool isPermutation(std::vector<int> order) {
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < order.size(); ++i)
        if (order[i] != static_cast<int>(i)) return false;
    return order.size() != 1 && order.size() <= kMaxOrderedViews;
}

std::vector<int> readOrder(const FieldReader& reader, const std::string& source) {
    const Json* const list = reader.find("viewOrder");
    std::vector<int> order;
    if (list == nullptr) return order;
    if (!list->is_array() || list->size() > kMaxOrderedViews)
        fail(source, "viewOrder is " + shownJson(*list) + ", expected " + kExpectedOrder);
    for (const Json& view : *list)
        order.push_back(view.is_number_unsigned() && view < kMaxOrderedViews ? view.get<int>()
                                                                             : -1);
    return order;
}

Calibration readCubeVi(const Json& object, const CubeViKeys& keys, const std::string& source) {
    constexpr double kInches = 5.7; // diagonal of the panel
    double numbers[3] = {};
    for (std::size_t i = 0; i < 3; ++i) {
        FieldReader(object, source).read(keys[i], numbers[i], kCubeViLimits[i]);
        checkNumber(keys[i], numbers[i], kCubeViLimits[i], source);
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

Calibration readFields(const Json& object, const std::string& source) {
    if (const CubeViKeys* const keys = cubeViKeys(object)) return readCubeVi(object, *keys, source);
    const FieldReader reader(object, source);
    Calibration c;
    c.configVersion = reader.text("configVersion");
    c.serial = reader.text("serial");
    if (reader.find("CellPatternMode") == nullptr) // another spelling
        reader.read("cellPatternMode", c.CellPatternMode, kPattern);
    reader.readNumbers(c);
    c.subpixelCells = readCells(reader, source);
    for (const char* field : {"viewCone", "invView"})
        if (reader.find(field) == nullptr) c.missing.emplace_back(field);
    if (const auto sheet = reader.object("lensSheet")) {
        c.sheet.emplace().dpiDown = c.DPI;
        sheet->readNumbers(*c.sheet);
    }
    c.viewOrder = readOrder(reader, source);
    if (const auto lens = reader.object("subpixelLens")) {
        SubpixelLens numbers;
        lens->readNumbers(numbers);
        setLens(c, numbers);
    }
    validate(c, source);
    return c;
}

} // namespace

void validate(const Calibration& c, const std::string& source) {
    if (!isPermutation(c.viewOrder))
        fail(source, std::string("the order of views repeats a view or lacks one, expected ") +
                         kExpectedOrder);
    if (c.lens) checkNumbers(*c.lens, source + ": subpixelLens");
    checkNumbers(c, source);
    require(c.slope != 0, source, "slope", c.slope, kSlope.expected);
    require(std::abs(c.center) <= kMaxCenter, source, "center", c.center,
            "lens periods, -1e6..1e6");
    if (c.sheet) {
        const std::string sheet = source + ": lensSheet";
        checkNumbers(*c.sheet, sheet);
        require((c.sheet->thickness == 0) == (c.sheet->index == 0), sheet, "index", c.sheet->index,
                "thickness and index together");
    }
    if (c.subpixelCells.size() > kMaxCells)
        fail(source, "subpixelCells has " + std::to_string(c.subpixelCells.size()) +
                         " cells, expected at most " + std::to_string(kMaxCells));
    for (std::size_t i = 0; i < c.subpixelCells.size(); ++i) {
        const std::string field = "subpixelCells[" + std::to_string(i) + "] offset";
        SubpixelCell cell = c.subpixelCells[i];
        forNumbers(cell, [&](const char* /*key*/, double offset, const Limits& limits) {
            require(std::abs(offset) <= 1, source, field.c_str(), offset, limits.expected);
        });
    }
    // Fields in range can still have a product that the mapping cannot resolve.
    const double periods = c.pitch * c.screenW / c.DPI;
    const double tilt = c.screenH / (c.screenW * std::abs(c.slope));
    const double down = tilt * periods * std::min(1.0, std::abs(c.slope)); // for horizontal lenses
    if (!(periods >= 1e-3 && periods <= 3.0 * c.screenW) || !(down <= 1e6) || !(tilt <= 1e12))
        fail(source, "pitch " + show(c.pitch) + ", DPI " + show(c.DPI) + " and slope " +
                         show(c.slope) +
                         " describe no lens array, expected 0.001 periods to one per sub-pixel"
                         " across the panel");
}

std::vector<Calibration> parseCalibrations(const std::string& text, const std::string& source) {
    const Json document = parseDocument(text, source); // skips a byte order mark
    std::vector<Json> objects;
    findCalibrations(document, kMaxContainers, objects);
    if (objects.empty()) {
        if (!document.is_object() || !(document.contains("pitch") || document.contains("slope")))
            fail(source, "holds no calibration, expected an object with pitch, slope and center");
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

std::string calibrationText(const Calibration& c) {
    validate(c);
    Json json = {{"configVersion", c.configVersion}, {"serial", c.serial}};
    json.update(jsonOf(c, true));
    json["subpixelCells"] = Json::array();
    for (const SubpixelCell& cell : c.subpixelCells)
        json["subpixelCells"].push_back(jsonOf(cell));
    if (c.lens) json["subpixelLens"] = jsonOf(*c.lens);
    if (!c.viewOrder.empty()) json["viewOrder"] = c.viewOrder;
    if (c.sheet) json["lensSheet"] = jsonOf(*c.sheet);
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
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
    for (SubpixelCell cell : c.subpixelCells)
        forNumbers(cell, [&](const char*, double offset, const Limits&) { add(offset); });
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

double SubpixelLens::wholePlace(int x, int y, int k) const {
    // as published: the same roundings decide where a sub-pixel lies exactly between two views
    if (slopeInSubpixels) return 3 * x + k + 0.5 + y * slope + offset;
    return 3.0 * (x + 1 + (y + 1) * slope) + k + offset;
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
    double right = k * subpixelStep; // from the middle of the px to the colour, in panel widths
    double up = 0;
    if (!cells.empty()) {
        const SubpixelCell& cell = cells[static_cast<std::size_t>(cellIndex(x, y))];
        const auto c = static_cast<std::size_t>(k);
        right = (mirrorX ? -1 : 1) * cell.x[c] / panelWidth; // same sign as the sub-pixel step
        up = cell.y[c] / panelHeight;
    }
    const double a = lens ? lens->wholePlace(x, y, k) / lens->period
                          : ((u + right) + (v + up) * tilt) * periodsPerWidth - center;
    const double z = a - std::floor(a);
    return inverted ? 1 - z : z;
}

int LensGeometry::view(int x, int y, int colour, int views) const {
    const auto viewInOrder = [&](int count) {
        if (!lens) return viewOfPhase(phase(x, y, colour), count);
        const int k = blueFirst ? 2 - colour : colour;
        double place = std::fmod(lens->wholePlace(x, y, k), lens->period);
        if (place < 0) place += lens->period;
        const int fromLeft = std::min(static_cast<int>(count * place / lens->period), count - 1);
        return inverted ? count - 1 - fromLeft : fromLeft;
    };
    const auto count = static_cast<int>(viewOrder.size());
    if (count == 0) return viewInOrder(views);
    if (count == views) return viewOrder[static_cast<std::size_t>(viewInOrder(count))];
    const int fine = viewInOrder(count * views); // at most 64 * 2^20
    return (viewOrder[static_cast<std::size_t>(fine / views)] * views + fine % views) / count;
}

int LensGeometry::viewOfPhase(double phase, int views) {
    const int view = static_cast<int>(phase * views); // phase >= 0: truncation is floor
    return view < views ? view : views - 1;
}

} // namespace altiro3D
