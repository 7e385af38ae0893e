#include "cli/display_options.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "cli/bridge.hpp"
#include "cli/lens_options.hpp"
#include "cli/quilt_options.hpp"

#include <fstream>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr const char* kSampleName = "portrait-sample.json";

// The one volume of a display that is mounted, or the one that --serial names.
std::optional<MountedCalibration> mountedVolume(const std::string& serial,
                                                const VolumeSearch& search, Messages& messages) {
    const std::vector<MountedCalibration> volumes = search.find(); // and USB displays without any
    if (!serial.empty()) {
        const auto named = [&](const MountedCalibration& volume) {
            if (lowerCase(volume.volume) == lowerCase(serial)) return true;
            try {
                return lowerCase(readCalibration(volume).serial) == lowerCase(serial);
            } catch (const Error&) {
                return false;
            }
        };
        std::vector<std::string> list;
        for (const MountedCalibration& volume : volumes) {
            if (named(volume)) return volume;
            list.push_back(volume.volume);
        }
        throw Error(
            ErrorCode::NotFound, "--serial",
            "no connected display is " + serial + ", expected " +
                (list.empty() ? "a display's volume to be mounted" : "one of " + joined(list)));
    }
    if (volumes.empty()) return std::nullopt;
    if (volumes.size() == 1) return volumes.front();
    if (search.firstWillDo) {
        messages.warn("several displays are connected: the calibration of " +
                      volumes.front().volume + " is used");
        return volumes.front();
    }
    std::vector<std::string> list;
    for (const MountedCalibration& volume : volumes)
        list.push_back(volume.volume + " (" + volume.file.string() + ")");
    throw Error(ErrorCode::InvalidArgument, "calibration",
                "several displays are connected: " + joined(list) +
                    "; expected --serial to choose one");
}

// The calibration in a display's memory, as a file in the cache.
MountedCalibration usbCalibration(const UsbDisplay& display) {
    MountedCalibration found{display.device, "USB display"};
    try {
        const fs::path directory = cacheDirectory();
        if (directory.empty())
            throw Error(ErrorCode::NotFound, "$HOME", "is not set, expected the user's directory");
        const fs::path file = directory / ("usb-" + display.id + ".json");
        const std::string cached = isFile(file) ? readFile(file, 1 << 20) : std::string();
        const std::string json = readUsbCalibration(display, cached);
        if (json != cached) {
            std::error_code ignored;
            fs::create_directories(directory, ignored);
            writeFile(file, json);
        }
        const std::string serial = parseCalibrations(json, file.string()).front().serial;
        if (!serial.empty()) found.volume = serial;
        found.file = file;
    } catch (const Error& problem) {
        found.problem = problem;
    }
    return found;
}

// Instead of options, for people who look at a window.
constexpr const char* kChooseInMenu = "choose its visual.json with Display > Choose calibration";

fs::path sampleCalibration() {
    for (const fs::path& directory : dataDirectories()) {
        fs::path sample = directory / "calibration" / kSampleName;
        if (isThere(sample)) return sample;
    }
    throw Error(ErrorCode::NotFound, "calibration",
                "not found, expected -c visual.json or -m FILE.map");
}

// Warns if a file that was found automatically belongs to a display that is not connected.
void warnOfAnotherMounted(const ChosenDisplay& display, const VolumeSearch& search,
                          Messages& messages) {
    std::string others;
    for (const MountedCalibration& volume : search.find()) {
        try {
            const Calibration mounted = readCalibration(volume);
            if (fingerprint(mounted) == fingerprint(display.calibration)) return;
        } catch (const Error&) {
            continue; // nothing to compare with
        }
        others += (others.empty() ? "" : ", ") + volume.volume + " (" + volume.file.string() + ")";
    }
    if (others.empty()) return;
    messages.warn(display.source +
                  ": is used, but a display with another calibration is connected: " + others +
                  "; to use that one, " +
                  (search.isWindow ? kChooseInMenu : "give its file with -c"));
}

// Warns if the number of a file's serial is not that of the volume that holds it: "655" of
// LKG-P00655 and LKG-PORT-00655.
void warnOfAnotherUnit(const ChosenDisplay& display, Messages& messages) {
    if (display.files.empty()) return; // of Looking Glass Bridge
    const fs::path& file = display.files.front();
    const std::string& serial = display.calibration.serial;
    const std::string volume = fs::absolute(file).parent_path().parent_path().filename().string();
    const auto number = [](const std::string& name) {
        return name.substr(name.find_last_not_of("0123456789") + 1);
    };
    if (lowerCase(volume).rfind("lkg", 0) != 0 || number(volume).empty() ||
        number(serial).empty() || number(volume) == number(serial)) {
        return;
    }
    messages.warn(file.string() + ": is of " + serial + ", but lies on the volume " + volume +
                  ": it may be another unit's");
}

// One calibration of a file.
Calibration readChosenCalibration(const fs::path& file, const std::string& serial, bool isWindow,
                                  Messages& messages) {
    if (!serial.empty()) return readDisplay(file, serial).calibration;
    const std::vector<Calibration> all = readCalibrations(file);
    if (all.size() > 1) {
        messages.warn(file.string() + " holds " + std::to_string(all.size()) +
                      " calibrations; the first, " + all.front().serial + ", is used" +
                      (isWindow ? "" : " (--serial chooses another)"));
    }
    return all.front();
}

// The display of -c bridge.
ChosenDisplay displayOfBridge(const DisplayOptions& options) {
    const BridgeDevice device = deviceOfBridge(options.bridge, options.serial);
    ChosenDisplay display{displayOf(device.calibration, bridgeName(options.bridge)), {}, {}};
    display.invert = options.invert;
    if (device.quilt) display.quilt = *device.quilt;
    return display;
}

// The calibration of -c, or the first one found.
ChosenDisplay chooseCalibration(const DisplayOptions& options, const VolumeSearch& volumes,
                                Messages& messages) {
    const auto displayIn = [&](Calibration calibration, const fs::path& file) {
        ChosenDisplay display{displayOf(std::move(calibration), file.string()), {file}, {}};
        display.invert = options.invert;
        return display;
    };
    const auto chosen = [&](const fs::path& given) {
        const fs::path file = calibrationFile(given);
        return displayIn(readChosenCalibration(file, options.serial, volumes.isWindow, messages),
                         file);
    };
    if (isBridge(options.calibration)) return displayOfBridge(options);
    if (!options.calibration.empty()) return chosen(options.calibration);
    if (const auto named = environment("LKG_CALIBRATION")) {
        try {
            ChosenDisplay display = chosen(*named);
            display.source = *named + " ($LKG_CALIBRATION)";
            warnOfAnotherMounted(display, volumes, messages);
            return display;
        } catch (const Error& problem) {
            throw Error(problem.code(), "$LKG_CALIBRATION", problem.what());
        }
    }
    if (isThere("visual.json")) {
        ChosenDisplay display = chosen("visual.json");
        warnOfAnotherMounted(display, volumes, messages);
        return display;
    }
    if (const auto volume = mountedVolume(options.serial, volumes, messages)) {
        // --serial has chosen the volume; it is not compared with the file, whose serial may be cut
        return displayIn(readCalibration(*volume), volume->file);
    }
    const fs::path sample = sampleCalibration();
    ChosenDisplay display = displayIn(readCalibration(sample), sample);
    display.source = "the sample calibration of a Portrait";
    display.isSample = true;
    return display;
}

// The warning about using the sample calibration in place of a display's own.
std::string sampleWarning(DisplayUse use, bool isWindow) {
    const std::string none = "no calibration was given or found: ";
    switch (use) {
    case DisplayUse::Show:
        return none +
               "the sample one of a Portrait is used, and a real display will show the "
               "picture doubled and blurred; " +
               (isWindow ? kChooseInMenu : "give the display's own file with -c visual.json");
    case DisplayUse::Simulate:
        return none + "the sample one of a Portrait is simulated, in which a Native for a real "
                      "display looks doubled and blurred; give the file of that display with -c "
                      "visual.json";
    case DisplayUse::Quilt:
        return none + "the quilt has the shape and the layout of a Portrait's; give another "
                      "display's file with -c visual.json";
    case DisplayUse::Describe:
        return none + "this is the sample one of a Portrait; give your display's visual.json";
    case DisplayUse::None:
        break;
    }
    return {};
}

void tellDisplay(const ChosenDisplay& display, DisplayUse use, bool isWindow, Messages& messages) {
    if (use == DisplayUse::None) return;
    if (display.isSample) {
        messages.say("display: none was given or found; " + display.source + ", panel " +
                     sizeText(display.panelSize()));
        messages.warn(sampleWarning(use, isWindow));
        return;
    }
    const Calibration& known = display.calibration;
    if (!display.isMapOnly) messages.warn(calibrationWarnings(known));
    const DisplayModel* const model = findDisplayModel(known);
    const std::string name = known.sheet        ? sheetText(known)
                             : model != nullptr ? model->name
                                                : "unknown model";
    messages.say("display: " + name + (known.serial.empty() ? "" : ", serial " + known.serial) +
                 ", panel " + sizeText(display.panelSize()) + ", " +
                 (use == DisplayUse::Simulate ? "simulated from " : "from ") + display.source);
}

// Adds to the error of a damaged table how to repair it.
NativeLut readMap(const fs::path& file) {
    try {
        return NativeLut::load(file);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadFormat) throw;
        const std::string subject = file.string();
        throw Error(error.code(), subject,
                    std::string(error.what()).substr(subject.size() + 2) +
                        "; altiro3Dnative makes tables");
    }
}

} // namespace

std::vector<MountedCalibration> withUsbDisplays(std::vector<MountedCalibration> volumes) {
    const bool hasVolumes = !volumes.empty();
    for (const UsbDisplay& display : findUsbDisplays()) {
        MountedCalibration found = usbCalibration(display);
        if (!found.problem || !hasVolumes) volumes.push_back(std::move(found));
    }
    return volumes;
}

void addInvertOption(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"invert"},
        "Reverse the order of the views under a lens: on, off or auto (default: as the "
        "calibration states; always on for panels with sub-pixel cells).",
        "auto|on|off");
}

InvertViews invertOption(const CommandLine& commandLine) {
    constexpr std::pair<const char*, InvertViews> kWords[] = {
        {"auto", InvertViews::Auto}, {"on", InvertViews::On}, {"off", InvertViews::Off}};
    InvertViews invert = InvertViews::Auto;
    commandLine.take({{"invert", invert, kWords}});
    return invert;
}

DisplayOptions displayOptions(const CommandLine& commandLine) {
    DisplayOptions options;
    commandLine.take({{"m", options.map}});
    if (options.map.extension() == ".json")
        throw UsageError(options.map.string() +
                         ": is a calibration, expected a look-up table (.map); "
                         "calibrations are given with -c");
    commandLine.exclude("m", {"invert", "view-filter", "sampling"});
    bool isBridge = false;
    commandLine.take({{"c", options.calibration},
                      {"serial", options.serial},
                      {"bridge", options.bridge},
                      {"bridge", isBridge}});
    options.invert = invertOption(commandLine);
    if (isBridge && options.map.empty() && options.calibration.empty())
        options.calibration = "bridge";
    return options;
}

void addDisplayOptions(CommandLine& commandLine) {
    commandLine.addSection("Display");
    commandLine.addAdvanced({"m", "map"}, "Look-up table of the display, made by altiro3Dnative.",
                            "FILE.map");
    commandLine.add({"c", "calibration"},
                    "Calibration of the display. Without -m and -c: $LKG_CALIBRATION, "
                    "./visual.json, a connected display's own volume or memory, else a sample. "
                    "bridge: that of the display of Looking Glass Bridge.",
                    "visual.json");
    commandLine.addAdvanced(
        {"serial"}, "Choose among several displays by serial number or volume name.", "NAME");
    addInvertOption(commandLine);
    commandLine.addSection("Quilt");
    addQuiltOptions(commandLine);
    using Chapter = CommandLine::Chapter;
    commandLine.addTerm(Chapter::Files, "visual.json",
                        "Calibration of a display. Its USB volume holds it as "
                        "LKG_calibration/visual.json; altiro3Dnative --read-usb saves that of the "
                        "first generation.");
    commandLine.addTerm(Chapter::Files,
                        std::string("PREFIX/share/altiro3D/calibration/") + kSampleName,
                        "The sample calibration, of a Portrait. PREFIX is where the tools are "
                        "installed, such as /usr.");
    commandLine.addTerm(Chapter::Files, "~/.cache/altiro3D/",
                        "Look-up tables, calibrations of USB displays and measurements of earlier "
                        "runs. It may be deleted.");
    commandLine.addTerm(Chapter::Environment, "LKG_CALIBRATION",
                        "Calibration that is used without -m and -c: a file, or a display's "
                        "volume.");
    commandLine.addTerm(Chapter::Environment, "XDG_CACHE_HOME",
                        "Directory that is used instead of ~/.cache.");
}

fs::path calibrationFile(const fs::path& given) {
    std::string beginning(8, '\0');
    if (isFile(given)) // a pipe gives its bytes once
        std::ifstream(given, std::ios::binary).read(beginning.data(), 8);
    if (beginning == "ALTIRO3D") {
        throw Error(ErrorCode::BadFormat, given.string(),
                    "is a look-up table, expected a display's visual.json (tools that use tables "
                    "take them with -m)");
    }
    for (const char* place : {"visual.json", "LKG_calibration/visual.json"}) {
        if (isFile(given / place)) return given / place;
    }
    return given;
}

ChosenDisplay findDisplay(const DisplayOptions& options, Messages& messages,
                          const VolumeSearch& volumes, DisplayUse use) {
    ChosenDisplay display;
    if (options.map.empty()) {
        display = chooseCalibration(options, volumes, messages);
        if (use == DisplayUse::Describe && !display.isSample) {
            if (!options.calibration.empty()) warnOfAnotherMounted(display, volumes, messages);
            warnOfAnotherUnit(display, messages);
        }
        tellDisplay(display, use, volumes.isWindow, messages);
        return display;
    }
    display.invert = options.invert;
    display.map = readMap(options.map);
    display.files = {options.map};
    display.source = options.map.string();
    display.quilt = display.map->quilt();
    if (isBridge(options.calibration))
        throw UsageError("-m and -c bridge exclude each other, expected one of them");
    if (!options.calibration.empty()) {
        const fs::path file = calibrationFile(options.calibration);
        display.calibration =
            readChosenCalibration(file, options.serial, volumes.isWindow, messages);
        display.files.push_back(file);
        requireSameDisplay(*display.map, options.map.string(), display.calibration, file.string());
    } else {
        display.isMapOnly = true;
        display.calibration.serial = display.map->serial();
        display.calibration.screenW = display.map->panelSize().width;
        display.calibration.screenH = display.map->panelSize().height;
    }
    tellDisplay(display, use, volumes.isWindow, messages);
    return display;
}

} // namespace altiro3D::tools
