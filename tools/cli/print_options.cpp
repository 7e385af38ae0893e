#include "cli/print_options.hpp"

#include "cli/outputs.hpp"

namespace altiro3D::tools {

void addPrintOptions(CommandLine& commandLine) {
    commandLine.addSection("Print");
    commandLine.add({"print"},
                    "Make a print for a lens sheet: -c is its calibration (altiro3Dnative --lens), "
                    "OUT a .png, .tif or .pdf with its exact size.");
    commandLine.addAdvanced({"bleed"},
                            "Extra width of the picture at each side, which is cut off, 0..50 mm "
                            "(default 5).",
                            "MM");
    commandLine.addAdvanced({"no-marks"},
                            "Leave out alignment strips, crop marks and the line of text.");
    commandLine.addAdvanced({"print-text"}, "Add to that line of text: the printer, for example.",
                            "TEXT");
}

std::optional<PrintOptions> printOptions(const CommandLine& commandLine) {
    commandLine.refuseWithout("print", {"bleed", "no-marks", "print-text"},
                              " is for prints, expected --print with it");
    if (!commandLine.has("print")) return std::nullopt;
    commandLine.exclude("print", "m");
    commandLine.exclude("no-marks", "print-text");
    PrintOptions options;
    commandLine.take({{"bleed", options.bleed, 0, 50},
                      {"no-marks", options.hasMarks, false},
                      {"print-text", options.text}});
    return options;
}

std::optional<PrintSheet> printSheet(const std::optional<PrintOptions>& options,
                                     ChosenDisplay& display, Messages& messages) {
    if (!options) {
        if (display.calibration.sheet && display.calibration.sheet->isPrint)
            messages.say("the calibration is that of a print: with --print the picture gets its "
                         "size in mm, bleed and marks");
        return std::nullopt;
    }
    if (!display.calibration.sheet || !display.calibration.sheet->isPrint) {
        throw UsageError("--print: " + display.source +
                         " is the calibration of a display, expected that of a print with -c; "
                         "altiro3Dnative --lens makes it");
    }
    PrintSheet sheet(display, *options);
    static_cast<Display&>(display) = sheet.display();
    messages.say("print: " + printText(sheet));
    return sheet;
}

void requireNativeName(const std::filesystem::path& file, bool isPrint) {
    if (!isPrint) return requirePictureName(file);
    if (isStandardStream(file) || !PrintSheet::canWrite(file)) {
        throw UsageError(nameOf(file, "standard output") +
                         ": is not the name of a print, expected .png, .tif or .pdf");
    }
}

std::string printText(const PrintSheet& sheet) {
    const Calibration& c = sheet.display().calibration;
    const auto millimetres = [&](cv::Size size) {
        return fixed(size.width / c.DPI * 25.4, 1) + " x " +
               fixed(size.height / c.sheet->dpiDown * 25.4, 1) + " mm";
    };
    return sizeText(sheet.size()) + ", " + millimetres(sheet.size()) + ", to be cut to " +
           millimetres(sheet.picture().size());
}

} // namespace altiro3D::tools
