#include "cli/lens_options.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>

namespace altiro3D::tools {

namespace {

// A number and perhaps a unit behind it. @return the unit; nothing if there is no number
std::optional<std::string> readNumber(std::string_view text, double& value) {
    const char* const end = text.data() + text.size();
    const int plus = !text.empty() && text[0] == '+' ? 1 : 0;
    const auto read = std::from_chars(text.data() + plus, end, value);
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
        "Make the calibration of a print or of a screen with lenses from numbers: lpi=, dpi= "
        "(or ACROSSxDOWN), size=WxHmm or WxHin (of the picture), and optionally angle= (-45..45 "
        "degrees to the right going up), horizontal=yes (horizontal lenses), views= (auto), "
        "subpixels= (none: a print; rgb, bgr, vrgb: a screen), thickness= and index= (of the "
        "sheet: mm; 1.56 for PETG), distance= (of the eye, mm). Instead of lpi=, dpi= and size=, "
        "a screen may have panel=WxH (px, or cubevi-c1) and pitch= (sub-pixels from one lens, or "
        "slit of a barrier, to the next), and optionally slope= (sub-pixels to the right per row, "
        "instead of angle=), offset= (sub-pixels from the left edge of the panel to that of a "
        "lens, in the top row) and order= (views under a lens from left to right, 0 for the "
        "leftmost camera, such as 3:1:2:0).",
        "KEY=VALUE,...");
}

Calibration lensOption(const CommandLine& commandLine) {
    LensNumbers numbers;
    BarrierNumbers barrier;
    cv::Size2d panel;
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
        {"distance", &numbers.distance, nullptr, true, "MM"},
        {"panel", &panel.width, &panel.height, false, "1440x2560 (px) or cubevi-c1"},
        {"pitch", &barrier.pitch, nullptr, false, "SUB-PIXELS"},
        {"slope", &barrier.slope, nullptr, false, "SUB-PIXELS"},
        {"offset", &barrier.offset, nullptr, false, "SUB-PIXELS"}};
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
        } else if (key == "order") {
            std::istringstream order(value);
            for (std::string view; std::getline(order, view, ':');) {
                double number = -1;
                if (readNumber(view, number) != "" ||
                    number != std::clamp(std::floor(number), 0.0, 99.0))
                    fail(part, "order=0:2:1:3, each view under a lens once");
                barrier.order.push_back(static_cast<int>(number));
            }
        } else if (key == "panel" && value == "cubevi-c1") {
            panel = {1440, 2560};
        } else if (known == std::end(numberKeys)) {
            fail(part, "lpi, dpi, size, angle, horizontal, views, subpixels, thickness, index or "
                       "distance, such as lpi=60,dpi=720,size=100x150mm, or panel, pitch, slope, "
                       "offset or order");
        } else if (key != "views" || value != "auto") {
            read(*known);
            if (key != "views") continue;
            numbers.views = static_cast<int>(std::clamp(views, 2.0, 1.0 * kMaxSheetViews));
            if (views != numbers.views)
                fail(part, "views=auto or 2.." + std::to_string(kMaxSheetViews));
        }
    }
    const auto has = [&](const std::string& key) { return keys.count(key) > 0; };
    const auto require = [&](const std::vector<std::string>& needed, const std::string& example) {
        for (const std::string& key : needed)
            if (!has(key))
                throw UsageError("--lens: " + key + " is missing, expected " +
                                 joined(needed, ", ", " and ") + ", such as " + example);
    };
    const auto refuse = [&](const std::vector<std::string>& others, const std::string& why) {
        for (const std::string& key : others)
            if (has(key)) throw UsageError("--lens: " + key + why);
    };
    if (!has("panel") && !has("pitch")) {
        refuse({"slope", "offset", "order"}, " is in sub-pixels, expected panel and pitch with it");
        require({"lpi", "dpi", "size"}, "lpi=60,dpi=720,size=100x150mm");
        return calibrationOf(numbers);
    }
    require({"panel", "pitch"}, "panel=1440x2560,pitch=4.6667");
    refuse({"lpi", "size", "horizontal", "thickness", "index", "distance"},
           " is of a lens sheet, expected panel and pitch without it");
    if (has("slope")) refuse({"angle"}, " and slope are both given, expected one");
    barrier.isBgr = numbers.subpixels == SubpixelOrder::Bgr;
    if (has("subpixels") && !barrier.isBgr && numbers.subpixels != SubpixelOrder::Rgb)
        fail("subpixels", "subpixels=rgb|bgr with panel and pitch");
    barrier.panel = panel;
    if (cv::Size2d(barrier.panel) != panel) fail("panel", "whole px, such as 1440x2560");
    barrier.views = numbers.views;
    if (has("angle")) barrier.slope = -3 * std::tan(numbers.angle * CV_PI / 180);
    if (has("dpi")) barrier.dpi = numbers.dpi;
    return calibrationOf(barrier);
}

std::string subpixelLensText(const Calibration& c) {
    const SubpixelLens& lens = *c.lens;
    const auto text = [](const char* key, double number) { return key + numberText(number + 0.0); };
    std::string all = text("lineNumber ", lens.period) + text(", obliquity ", lens.slope) +
                      text(", deviation ", lens.offset);
    if (lens.slopeInSubpixels) // (1.16)
        all = text("pitch ", lens.period) + text(", slope ", -lens.slope) +
              text(", offset ", -lens.offset) + " sub-pixels";
    for (std::size_t i = 0; i < c.viewOrder.size(); ++i)
        all += (i == 0 ? ", order " : ":") + std::to_string(c.viewOrder[i]);
    return all;
}

std::string sheetText(const Calibration& calibration) {
    const LensFacts facts = lensFacts(calibration);
    if (calibration.lens)
        return "screen of " + sizeText({calibration.screenW, calibration.screenH}) +
               " with lenses of " + numberText(calibration.lens->period) + " sub-pixels";
    return std::string(calibration.sheet->isPrint ? "print" : "screen with a lens film") + " of " +
           sizeInMm(facts) + ", " + numberText(facts.lpi) + " LPI";
}

void tellSheet(const Calibration& calibration, const Messages& messages) {
    if (calibration.lens) return; // its dpi may be any
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
