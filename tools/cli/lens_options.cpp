#include "cli/lens_options.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

namespace altiro3D::tools {

namespace {

using Units = std::vector<std::pair<std::string, double>>; // and how many mm each has

const Units& lengths() {
    static const Units units = {{"mm", 1}, {"cm", 10}, {"in", 25.4}, {"\"", 25.4}};
    return units;
}

// A number and perhaps a unit behind it. @return the unit; nothing if there is no number
std::optional<std::string> readNumber(std::string_view text, double& value) {
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, value);
    if (read.ec != std::errc()) return std::nullopt;
    return std::string(read.ptr, end);
}

std::string number(double value) {
    std::ostringstream text;
    text.precision(6);
    text << value;
    return text.str();
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
    std::istringstream parts(*commandLine.value("lens"));
    const auto fail = [](const std::string& part, const std::string& expected) {
        throw UsageError("--lens: " + part + " is not one of its numbers, expected " + expected);
    };
    bool hasLpi = false;
    bool hasDpi = false;
    bool hasSize = false;
    std::vector<std::string> keys;
    for (std::string part; std::getline(parts, part, ',');) {
        part.erase(std::remove(part.begin(), part.end(), ' '), part.end());
        const std::size_t equals = std::min(part.find('='), part.size());
        const std::string key = part.substr(0, equals);
        if (std::find(keys.begin(), keys.end(), key) != keys.end())
            throw UsageError("--lens: " + key + " is given twice, expected once");
        keys.push_back(key);
        const std::string value = part.substr(std::min(equals + 1, part.size()));
        const auto word = [&](const std::vector<std::string>& words) {
            const auto found = std::find(words.begin(), words.end(), value);
            if (found == words.end()) fail(part, key + "=" + joined(words, "|"));
            return found - words.begin();
        };
        // "720" or, if there is a second number, "720x360"; a unit behind the last counts for both
        const auto pair = [&](double& first, double* second, const Units& units,
                              const std::string& expected) {
            const std::size_t cross = second != nullptr ? value.find('x') : std::string::npos;
            const auto unit = readNumber(std::string_view(value).substr(0, cross), first);
            const auto other = cross == std::string::npos
                                   ? unit
                                   : readNumber(std::string_view(value).substr(cross + 1), *second);
            if (!unit || !other) fail(part, key + "=" + expected);
            const auto scale = [&](const std::string& name, double& number) {
                const auto found = std::find_if(units.begin(), units.end(),
                                                [&](auto& each) { return each.first == name; });
                if (found != units.end()) number *= found->second;
                if (found != units.end() || name.empty()) return;
                throw UsageError("--lens: " + part + " has the unit " + name + ", expected " +
                                 (units.empty() ? "a number without unit" : "mm, cm or in"));
            };
            scale(unit->empty() ? *other : *unit, first);
            if (cross != std::string::npos) scale(*other, *second);
        };
        double views = 0;
        if (key == "lpi") {
            pair(numbers.lpi, nullptr, {}, "60");
            hasLpi = true;
        } else if (key == "dpi") {
            pair(numbers.dpi, &numbers.dpiDown, {}, "720 or 720x360");
            hasDpi = true;
        } else if (key == "size") {
            pair(numbers.width, &numbers.height, lengths(), "100x150mm or 4x6in");
            hasSize = true;
        } else if (key == "angle") {
            pair(numbers.angle, nullptr, {}, "DEGREES");
        } else if (key == "horizontal") {
            numbers.isHorizontal = word({"no", "yes"}) == 1;
        } else if (key == "views" && value != "auto") {
            pair(views, nullptr, {}, "auto or a number");
            if (views != static_cast<int>(std::clamp(views, 2.0, 1.0 * kMaxSheetViews)))
                fail(part, "views=auto or 2.." + std::to_string(kMaxSheetViews));
            numbers.views = static_cast<int>(views);
        } else if (key == "subpixels") {
            numbers.subpixels = static_cast<SubpixelOrder>(word({"none", "rgb", "bgr", "vrgb"}));
        } else if (key == "thickness") {
            pair(numbers.thickness, nullptr, lengths(), "MM");
        } else if (key == "index") {
            pair(numbers.index, nullptr, {}, "1.56");
        } else if (key == "distance") {
            pair(numbers.distance, nullptr, lengths(), "MM");
        } else if (key != "views") {
            fail(part, "lpi, dpi, size, angle, horizontal, views, subpixels, thickness, index or "
                       "distance, such as lpi=60,dpi=720,size=100x150mm");
        }
    }
    if (!hasLpi || !hasDpi || !hasSize) {
        throw UsageError(std::string("--lens: ") +
                         (!hasLpi   ? "lpi"
                          : !hasDpi ? "dpi"
                                    : "size") +
                         " is missing, expected lpi, dpi and size, such as "
                         "lpi=60,dpi=720,size=100x150mm");
    }
    return numbers;
}

std::string sheetText(const Calibration& calibration) {
    const LensFacts facts = lensFacts(calibration);
    return std::string(calibration.sheet->isPrint ? "print" : "screen with a lens film") + " of " +
           sizeInMm(facts) + ", " + number(facts.lpi) + " LPI";
}

void tellSheet(const Calibration& calibration, const Messages& messages) {
    const LensFacts facts = lensFacts(calibration);
    const LensSheet& sheet = *calibration.sheet;
    const double down = sheet.dpiDown;
    messages.say((sheet.isPrint ? "print         " : "screen        ") + sizeInMm(facts) + ", " +
                 number(calibration.DPI) + (down == calibration.DPI ? "" : " x " + number(down)) +
                 " dpi, " + number(facts.lpi) + " LPI");
    messages.say("useful views  " + number(facts.usefulViews) +
                 (sheet.isPrint ? " (dpi / LPI)" : " (sub-pixels under a lens)") +
                 "; more of them blend");
    if (sheet.thickness == 0) return;
    messages.say("viewing cone  " + fixed(facts.viewCone, 1) + " degrees");
    if (facts.visualLpi > 0) {
        messages.say("visual pitch  " + fixed(facts.visualLpi, 3) + " LPI at " +
                     number(sheet.distance) + " mm, if " + number(facts.lpi) +
                     " LPI are the sheet's own; a pitch sheet measures it");
    }
    messages.say("sharp depth   " + fixed(facts.sharpDepth, 1) +
                 " mm from the nearest plane to the farthest, at most --strength " +
                 fixed(facts.sharpStrength, 1));
}

} // namespace altiro3D::tools
