// altiro3Dnative: the look-up table of a display, a shader that replaces it in players, and a
// description of its calibration.

#include "altiro3D/altiro3D.hpp"
#include "cli/bridge.hpp"
#include "cli/lens_options.hpp"
#include "cli/outputs.hpp"
#include "cli/print_options.hpp"
#include "cli/quilt_options.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace {

std::string exact(double value) {
    return numberText(value, 12);
}

// The views that one lens shows, px by px from the middle of the panel.
std::string lensText(const LensGeometry& g, int views) {
    constexpr double kMostPixels = 16;
    const int y = g.panelHeight / 2;
    const int first = g.panelWidth / 2;
    const int count = static_cast<int>(std::ceil(std::min(g.lensPeriodSubpixels / 3, kMostPixels)));
    std::string text;
    for (int x = first; x < std::min(first + count, g.panelWidth); ++x) {
        if (x > first) text += " |";
        for (int colour = 0; colour < 3; ++colour)
            text += ' ' + std::to_string(g.view(x, y, colour, views));
    }
    return text;
}

void printInfo(const Calibration& c, const LensGeometry& g, const QuiltLayout& layout,
               const Messages& messages) {
    const double lensColumns = g.lensPeriodSubpixels / 3;
    const bool isLying = g.isLying(); // what is counted along a row then says nothing
    if (c.sheet) tellSheet(c, messages);
    messages.say("panel         " + sizeText({g.panelWidth, g.panelHeight}) + ", " +
                 numberText(c.DPI) + " dpi, " +
                 (c.sheet && c.sheet->isPrint ? "no sub-pixels"
                  : g.cells.empty()
                      ? (g.blueFirst ? "BGR stripes" : "RGB stripes")
                      : std::to_string(g.cells.size()) + " sub-pixel cells, pattern " +
                            std::to_string(g.cellPattern)));
    messages.say("lenses (P)    " + exact(g.periodsPerWidth) + " across the panel's width");
    messages.say("tilt (T)      " + exact(g.tilt) + " panel widths over the panel's height");
    messages.say("sub-pixel     " + exact(g.subpixelStep) + " panel widths");
    if (c.lens) messages.say("lens numbers  " + subpixelLensText(c));
    if (isLying) {
        messages.say("lens          " +
                     numberText(g.panelHeight / (std::abs(g.tilt) * g.periodsPerWidth)) +
                     " px down; the lenses lie");
    } else {
        messages.say("lens (Px)     " + exact(g.lensPeriodSubpixels) + " sub-pixels, " +
                     numberText(lensColumns) + " px");
    }
    messages.say("offset (i_off) " + exact(g.offsetSubpixels) + " sub-pixels");
    messages.say("view order    " +
                 std::string(g.inverted ? "reversed under each lens" : "as it is"));
    if (!isLying) {
        messages.say("views per px  " + numberText(layout.viewCount / lensColumns) + " with " +
                     std::to_string(layout.viewCount) + " views");
        messages.say("one lens     " + lensText(g, layout.viewCount) +
                     "  (views of red, green, blue; px by px in the panel's middle)");
    }
    messages.say("default quilt " + defaultQuilt(c).text());
    messages.say("fingerprint   " + fingerprintText(fingerprint(c)));
}

nlohmann::ordered_json layoutJson(const QuiltLayout& layout) {
    return {{"columns", layout.columns},          {"rows", layout.rows},
            {"viewWidth", layout.tileSize.width}, {"viewHeight", layout.tileSize.height},
            {"width", layout.size().width},       {"height", layout.size().height},
            {"views", layout.viewCount}};
}

// Null for displays; 0: unknown.
nlohmann::ordered_json sheetJson(const Calibration& c) {
    if (!c.sheet) return nullptr;
    const LensFacts facts = lensFacts(c);
    return {{"print", c.sheet->isPrint},
            {"widthMm", facts.width},
            {"heightMm", facts.height},
            {"dpiDown", c.sheet->dpiDown},
            {"lpi", facts.lpi},
            {"usefulViews", facts.usefulViews},
            {"viewConeDegrees", facts.viewCone},
            {"visualLpi", facts.visualLpi},
            {"sharpDepthMm", facts.sharpDepth},
            {"sharpStrengthPercent", facts.sharpStrength}};
}

void printJson(const Calibration& c, const LensGeometry& g, const QuiltLayout& layout,
               const Messages& messages) {
    const DisplayModel* model = findDisplayModel(c);
    const nlohmann::ordered_json info = {
        {"model", model != nullptr ? nlohmann::ordered_json(model->name) : nullptr},
        {"serial", c.serial},
        {"panelWidth", g.panelWidth},
        {"panelHeight", g.panelHeight},
        {"dpi", c.DPI},
        {"viewConeDegrees", c.viewCone},
        {"P", g.periodsPerWidth},
        {"T", g.tilt},
        {"subpixelStep", g.subpixelStep},
        {"Px", g.lensPeriodSubpixels},
        {"iOff", g.offsetSubpixels},
        {"center", g.center},
        {"inverted", g.inverted},
        {"subpixelCells", g.cells.size()},
        {"cellPattern", g.cellPattern},
        {"viewsPerPixel", 3.0 * layout.viewCount / g.lensPeriodSubpixels},
        {"quilt", layoutJson(layout)},
        {"defaultQuilt", layoutJson(defaultQuilt(c))},
        {"lens", sheetJson(c)},
        {"viewOrder", c.viewOrder},
        {"fingerprint", fingerprintText(fingerprint(c))}};
    messages.print(info.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

// The command line.
struct TableJob {
    DisplayOptions display; // calibration: empty with --info to find one
    QuiltRequest layout;
    std::filesystem::path table;  // empty: named after the display
    std::filesystem::path shader; // instead of a table; empty: none
    std::filesystem::path saved;  // with --read-usb, --read-bridge and --lens: the file to write
    bool readsUsb = false;
    QuiltSampling sampling; // of the shader
    bool replace = false;
    bool info = false;
    bool json = false;
    std::optional<Calibration> lens;
    std::filesystem::path pitchSheet; // with --lens; empty: none
    PitchSheetOptions pitches;
};

// The numbers of --lens and the files to make of them.
void takeLens(const CommandLine& commandLine, TableJob& job) {
    const std::vector<std::filesystem::path>& names = commandLine.files();
    commandLine.take({{"pitch-sheet", job.pitchSheet}});
    if (names.size() > 1 || (names.empty() && job.pitchSheet.empty()))
        commandLine.failNames("the calibration to write", 1);
    commandLine.refuse({"info", "json", "map", "layout", "resolution", "serial", "invert",
                        "mpv-shader", "read-usb", "read-bridge", "bridge", "view-filter",
                        "sampling"},
                       " is about a calibration that exists, expected --lens without it");
    if (!names.empty()) job.saved = names.front();
    commandLine.refuseWithout("pitch-sheet", {"around", "step"},
                              " is of a pitch sheet, expected --pitch-sheet");
    if (!job.pitchSheet.empty()) requireNativeName(job.pitchSheet, true);
    commandLine.take(
        {{"around", job.pitches.around, 1, 5000}, {"step", job.pitches.step, 1e-6, 100}});
    job.lens = lensOption(commandLine);
}

TableJob tableJob(const CommandLine& commandLine) {
    const std::vector<std::filesystem::path>& names = commandLine.files();
    TableJob job;
    bool isLens = false;
    bool readsBridge = false;
    commandLine.take({{"lens", isLens}, {"y", job.replace}});
    commandLine.refuseWithout("lens", {"pitch-sheet", "around", "step"},
                              " is for the numbers of a lens, expected --lens with it");
    if (isLens) {
        takeLens(commandLine, job);
        return job;
    }
    commandLine.take({{"serial", job.display.serial},
                      {"bridge", job.display.bridge},
                      {"read-usb", job.readsUsb},
                      {"read-bridge", readsBridge},
                      {"info", job.info},
                      {"json", job.info},
                      {"json", job.json},
                      {"m", job.table},
                      {"mpv-shader", job.shader}});
    for (const char* option : {"read-usb", "read-bridge"})
        commandLine.exclude(option, {"info", "json", "m", "q", "r", "invert", "mpv-shader"});
    if (job.readsUsb || readsBridge) commandLine.takeNames("one file to write", {&job.saved});
    commandLine.exclude("read-usb", "read-bridge");
    if (!job.saved.empty()) return job;
    commandLine.exclude("mpv-shader", {"m", "r", "info", "json"});
    commandLine.refuseWithout("mpv-shader", {"view-filter", "sampling"},
                              " applies to --mpv-shader");
    if (!job.info || !names.empty()) // else it is found
        commandLine.takeNames("one calibration (the table's name goes with -m)",
                              {&job.display.calibration});
    job.display.invert = invertOption(commandLine);
    job.layout = quiltRequest(commandLine);
    job.sampling = samplingOption(commandLine, TileSampling::Linear);
    return job;
}

// A calibration by the numbers of --lens.
int makeLensFile(const TableJob& job, Messages& messages) {
    const Calibration calibration = *job.lens;
    Outputs outputs(job.replace);
    outputs.addOutputs({job.saved, job.pitchSheet});
    outputs.check();
    tellSheet(calibration, messages);
    if (!job.pitchSheet.empty()) {
        writePitchSheet(job.pitchSheet, calibration, job.pitches);
        const double lenses = pitchSheetReach(calibration, job.pitches);
        if (lenses < 1) {
            messages.warn("the outermost bands differ from the middle one by only " +
                          fixed(lenses, 2) +
                          " of a lens over the width: make the sheet wider or "
                          "the step larger to see where the tone changes");
        }
        messages.say(job.pitchSheet.string() + ": pitch sheet of " + std::to_string(kPitchBands) +
                     " bands; under the lenses the right one has one tone from end to end");
    }
    if (job.saved.empty()) return kExitDone;
    writeFile(job.saved, calibrationText(calibration));
    messages.say(job.saved.string() + ": calibration of a " + sheetText(calibration));
    return kExitDone;
}

// Saves the calibration that a display holds in its memory, to a file. All of the memory is read.
int saveUsbCalibration(const TableJob& job, Messages& messages) {
    const std::vector<UsbDisplay> displays = findUsbDisplays();
    const std::string& wanted = job.display.serial;
    std::vector<std::string> found;
    for (const UsbDisplay& display : displays) {
        const std::string json = readUsbCalibration(display);
        const std::string serial = parseCalibrations(json, display.device.string()).front().serial;
        found.push_back(serial + " (" + display.device.string() + ")");
        const bool isMeant =
            wanted.empty() ? displays.size() == 1 : lowerCase(serial) == lowerCase(wanted);
        if (!isMeant) continue;
        writeFile(job.saved, json);
        messages.say(job.saved.string() + ": calibration of " + found.back());
        return kExitDone;
    }
    if (!found.empty()) {
        throw Error(ErrorCode::NotFound, "--serial",
                    (wanted.empty() ? "is missing" : "is " + wanted) + ", expected one of " +
                        joined(found));
    }
    throw Error(ErrorCode::NotFound, "USB",
                "no display was found, expected a connected one of the first generation (8.9\", "
                "15.6\", 8K)");
}

// Writes the calibration of a display that Looking Glass Bridge knows.
int saveBridgeCalibration(const TableJob& job, Messages& messages) {
    const BridgeDevice device = deviceOfBridge(job.display.bridge, job.display.serial);
    writeFile(job.saved, device.calibrationText);
    messages.say(job.saved.string() + ": calibration of " + device.name);
    return kExitDone;
}

int makeTable(const TableJob& job, Messages& messages) {
    if (job.json) messages.leaveStandardOutput();
    const ChosenDisplay display =
        findDisplay(job.display, messages, {}, job.info ? DisplayUse::Describe : DisplayUse::Show);
    const std::filesystem::path file = display.files.empty() ? "bridge" : display.files.front();
    const Calibration& calibration = display.calibration;
    const QuiltLayout layout = chooseQuilt(job.layout, display, messages);
    if (job.shader.empty()) messages.say("quilt: " + layout.text());
    if (job.info) {
        const LensGeometry geometry = lensGeometry(calibration, display.invert);
        if (job.json) {
            printJson(calibration, geometry, layout, messages);
        } else {
            if (!calibration.missing.empty()) {
                messages.warn(display.source + ": lacks " + joined(calibration.missing) +
                              ", as of old firmware; the usual values are taken");
            }
            printInfo(calibration, geometry, layout, messages);
        }
        if (job.table.empty()) return kExitDone;
    }

    Outputs outputs(job.replace);
    outputs.addInputs(display.files);
    if (!job.shader.empty()) {
        outputs.addOutputs({job.shader});
        outputs.check();
        writeFile(job.shader, quiltShader(calibration, layout, job.sampling, display.invert));
        messages.say(job.shader.string() + ": shader for quilts of any size in mpv, " +
                     sizeText(display.panelSize()));
        return kExitDone;
    }
    const std::string stem =
        calibration.serial.empty() ? file.stem().string() : inFileName(calibration.serial);
    const std::filesystem::path output =
        !job.table.empty() ? job.table
                           : std::filesystem::path(stem + "-" + std::to_string(layout.rows) + "x" +
                                                   std::to_string(layout.columns) + ".map");
    outputs.addOutputs({output});
    outputs.check();
    StageTimes times;
    const NativeLut lut(calibration, layout, display.invert);
    times.end("build");
    lut.save(output);
    times.end("write");
    messages.say(output.string() + ": look-up table for " + sizeText(lut.panelSize()));
    messages.detail(times.text());
    return kExitDone;
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine("altiro3Dnative",
                            "Makes the look-up table of a display from its calibration file: for "
                            "every sub-pixel of the panel, the quilt pixel that it shows.");
    commandLine.addUsage("[-m OUT.map] [-q RxC] [-r HxW] visual.json");
    commandLine.addUsage("--mpv-shader OUT.glsl [-q RxC] visual.json");
    commandLine.addUsage("--read-bridge OUT.json");
    commandLine.addUsage("--info [--json] [visual.json]");
    commandLine.addUsage("--read-usb OUT.json");
    commandLine.addUsage("--lens KEY=VALUE,... LENS.json");
    commandLine.addUsage("--lens KEY=VALUE,... --pitch-sheet OUT.png");
    commandLine.addSection("Output");
    commandLine.add({"m", "map"}, "Table to write (default: SERIAL-RxC.map).", "OUT.map");
    commandLine.addAdvanced({"mpv-shader"},
                            "Write a shader with which mpv and other players with libplacebo turn "
                            "quilts of any size, also videos, into Natives while they play them.",
                            "OUT.glsl");
    commandLine.add({"y"}, "Replace the output if it exists.");
    commandLine.add({"info"}, "Show what the calibration means; writes a table only with -m.");
    commandLine.add({"json"}, "As --info, for programs.");
    commandLine.addAdvanced({"read-usb"},
                            "Save the calibration that a connected display of the first "
                            "generation (8.9\", 15.6\", 8K) holds in its memory (Linux).");
    commandLine.addAdvanced({"read-bridge"},
                            "Save the calibration of the display of Looking Glass Bridge.");
    addLensOption(commandLine);
    commandLine.add({"pitch-sheet"},
                    "With --lens: write a sheet to print, whose bands find the pitch.", "OUT.png");
    commandLine.addAdvanced({"around"}, "LPI of its middle band (default: lpi= of --lens).", "LPI");
    commandLine.addAdvanced({"step"},
                            "Difference in LPI from band to band (default: 0.125 % of lpi=; with "
                            "--around, a tenth of that).",
                            "LPI");
    commandLine.addSection("Display and quilt");
    addQuiltOptions(commandLine);
    commandLine.add({"serial"},
                    "Choose among several calibrations in the file, or several displays.", "NAME");
    addInvertOption(commandLine);
    addBridgeOptions(commandLine, "Source of the calibration named bridge:", false);
    addSamplingOptions(commandLine, "linear for --mpv-shader");
    commandLine.addExample("--info visual.json", "Show what the calibration means.");
    commandLine.addExample("-m portrait.map visual.json",
                           "Write the map for the usual quilt of the display.");
    commandLine.addExample("-q 6x8 -r 560x420 -m portrait-6x8.map visual.json",
                           "Write it for 6 rows of 8 views of 420 x 560 px.");
    commandLine.addExample("--mpv-shader portrait.glsl visual.json",
                           "Write the shader with which mpv shows quilts on the display.");
    commandLine.addExample("--lens lpi=60,dpi=720,size=100x150mm lens.json",
                           "Write the calibration of a print under a lens sheet of 60 LPI.");
    commandLine.addExample("--lens lpi=60,dpi=720,size=100x150mm --pitch-sheet pitch.png",
                           "Write the sheet that finds the exact pitch.");
    commandLine.addTerm(CommandLine::Chapter::Files, "visual.json",
                        "Calibration of a display. Its USB volume holds it as "
                        "LKG_calibration/visual.json. If none is named, --info looks for it as "
                        "the other tools do. The word bridge stands for the calibration of "
                        "Looking Glass Bridge.");
    return runTool(argc, argv, commandLine, [](const CommandLine& given, Messages& messages) {
        const TableJob job = tableJob(given);
        if (job.lens) return makeLensFile(job, messages);
        if (job.saved.empty()) return makeTable(job, messages);
        Outputs outputs(job.replace);
        outputs.addOutputs({job.saved});
        outputs.check();
        return job.readsUsb ? saveUsbCalibration(job, messages)
                            : saveBridgeCalibration(job, messages);
    });
}
