#include "cli/lens_options.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>

namespace altiro3D::tools {

namespace {

// A number and perhaps a unit behind it. @return the unit; nothing if there is no number
std::optional<std::string> readNumber(std::string_view text, double& value) {
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, value);
    if (read.ec != std::errc()) return std::nullopt;
    return std::string(read.ptr, end);
}

std::string sizeInMm(const LensFacts& facts) {
    return fixed(facts.width, 1) + " x " + fixed(facts.height, 1) + " mm";
}

} // namespace

void addLensOption(CommandLine& commandLine) {
    commandLine.add(
        {"lens"},
        "Make the calibration of a print or of a screen with a lens film from numbers: lpi=, dpi= "
        "(or ACROSSxDOWN), size=WxHmm or WxHin (of the picture), and if wanted angle= (-45..45 "
        "degrees to the right going up), horizontal=yes (lying lenses), views= (auto), subpixels= "
        "(none: a print; rgb, bgr, vrgb: a screen), thickness= and index= (of the sheet: mm, 1.56 "
        "of PETG), distance= (of the eye, mm).",
        "KEY=VALUE,...");
}

LensNumbers lensOption(const CommandLine& commandLine) {
    LensNumbers numbers;
    std::string list;
    commandLine.take({{"lens", list}});
    std::istringstream parts(list);
    const auto fail = [](const std::string& part, const std::string& expected) {
        throw UsageError("--lens: " + part + " is not one of its numbers, expected " + expected);
    };
    struct NumberKey {
        std::string_view key;
        double* first;
        double* second; // null: it has one number
        bool isLength;
        const char* expected;
    };
    double views = 0;
    const NumberKey numberKeys[] = {
        {"lpi", &numbers.lpi, nullptr, false, "60"},
        {"dpi", &numbers.dpi, &numbers.dpiDown, false, "720 or 720x360"},
        {"size", &numbers.width, &numbers.height, true, "100x150mm or 4x6in"},
        {"angle", &numbers.angle, nullptr, false, "DEGREES"},
        {"views", &views, nullptr, false, "auto or a number"},
        {"thickness", &numbers.thickness, nullptr, true, "MM"},
        {"index", &numbers.index, nullptr, false, "1.56"},
        {"distance", &numbers.distance, nullptr, true, "MM"}};
    std::set<std::string> keys;
    for (std::string part; std::getline(parts, part, ',');) {
        part.erase(std::remove(part.begin(), part.end(), ' '), part.end());
        const std::size_t equals = std::min(part.find('='), part.size());
        const std::string key = part.substr(0, equals);
        if (!keys.insert(key).second)
            throw UsageError("--lens: " + key + " is given twice, expected once");
        const std::string value = part.substr(std::min(equals + 1, part.size()));
        const auto word = [&](const std::vector<std::string>& words) {
            const auto found = std::find(words.begin(), words.end(), value);
            if (found == words.end()) fail(part, key + "=" + joined(words, "|"));
            return found - words.begin();
        };
        // "720" or, if there is a second number, "720x360"; a unit behind the last counts for both
        const auto read = [&](const NumberKey& of) {
            const std::size_t cross = of.second != nullptr ? value.find('x') : std::string::npos;
            const bool hasTwo = cross != std::string::npos;
            const std::string_view text(value);
            const auto unit = readNumber(text.substr(0, cross), *of.first);
            const auto other = hasTwo ? readNumber(text.substr(cross + 1), *of.second) : unit;
            if (!unit || !other) fail(part, key + "=" + of.expected);
            const auto scale = [&](const std::string& name, double& number) {
                static const std::map<std::string, double> kLengths = {
                    {"mm", 1}, {"cm", 10}, {"in", 25.4}, {"\"", 25.4}};
                if (name.empty()) return;
                const auto found = kLengths.find(name);
                if (!of.isLength || found == kLengths.end())
                    throw UsageError("--lens: " + part + " has the unit " + name + ", expected " +
                                     (of.isLength ? "mm, cm or in" : "a number without unit"));
                number *= found->second;
            };
            scale(unit->empty() ? *other : *unit, *of.first);
            if (hasTwo) scale(*other, *of.second);
        };
        const auto* const known = std::find_if(std::begin(numberKeys), std::end(numberKeys),
                                               [&](const NumberKey& of) { return of.key == key; });
        if (key == "horizontal") {
            numbers.isHorizontal = word({"no", "yes"}) == 1;
        } else if (key == "subpixels") {
            numbers.subpixels = static_cast<SubpixelOrder>(word({"none", "rgb", "bgr", "vrgb"}));
        } else if (known == std::end(numberKeys)) {
            fail(part, "lpi, dpi, size, angle, horizontal, views, subpixels, thickness, index or "
                       "distance, such as lpi=60,dpi=720,size=100x150mm");
        } else if (key != "views" || value != "auto") {
            read(*known);
            if (key != "views") continue;
            numbers.views = static_cast<int>(std::clamp(views, 2.0, 1.0 * kMaxSheetViews));
            if (views != numbers.views)
                fail(part, "views=auto or 2.." + std::to_string(kMaxSheetViews));
        }
    }
    for (const char* needed : {"lpi", "dpi", "size"})
        if (keys.count(needed) == 0)
            throw UsageError(std::string("--lens: ") + needed +
                             " is missing, expected lpi, dpi and size, such as "
                             "lpi=60,dpi=720,size=100x150mm");
    return numbers;
}

std::string sheetText(const Calibration& calibration) {
    const LensFacts facts = lensFacts(calibration);
    return std::string(calibration.sheet->isPrint ? "print" : "screen with a lens film") + " of " +
           sizeInMm(facts) + ", " + numberText(facts.lpi) + " LPI";
}

void tellSheet(const Calibration& calibration, const Messages& messages) {
    const LensFacts facts = lensFacts(calibration);
    const LensSheet& sheet = *calibration.sheet;
    const double down = sheet.dpiDown;
    messages.say((sheet.isPrint ? "print         " : "screen        ") + sizeInMm(facts) + ", " +
                 numberText(calibration.DPI) +
                 (down == calibration.DPI ? "" : " x " + numberText(down)) + " dpi, " +
                 numberText(facts.lpi) + " LPI");
    messages.say("useful views  " + numberText(facts.usefulViews) +
                 (sheet.isPrint ? " (dpi / LPI)" : " (sub-pixels under a lens)") +
                 "; more of them blend");
    if (sheet.thickness == 0) return;
    messages.say("viewing cone  " + fixed(facts.viewCone, 1) + " degrees");
    if (facts.visualLpi > 0)
        messages.say("visual pitch  " + fixed(facts.visualLpi, 3) + " LPI at " +
                     numberText(sheet.distance) + " mm, if " + numberText(facts.lpi) +
                     " LPI are the sheet's own; a pitch sheet measures it");
    messages.say("sharp depth   " + fixed(facts.sharpDepth, 1) +
                 " mm from the nearest plane to the farthest, at most --strength " +
                 fixed(facts.sharpStrength, 1));
}

} // namespace altiro3D::tools
