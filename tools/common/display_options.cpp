#include "common/display_options.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr double kSameAspect = 0.0025; // of a panel and its name
constexpr const char* kSampleName = "portrait-sample.json";
constexpr std::uintmax_t kCacheBytes = std::uintmax_t{1} << 30;

std::optional<std::string> environment(const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0' ? std::optional<std::string>(value) : std::nullopt;
}

// The one volume of a display that is mounted, or the one that --serial names.
std::optional<MountedCalibration> mountedVolume(const std::optional<std::string>& serial,
                                                const VolumeSearch& search, Messages& messages) {
    const std::vector<MountedCalibration> volumes = search.find();
    if (serial) {
        const auto named = [&](const MountedCalibration& volume) {
            if (lowerCase(volume.volume) == lowerCase(*serial)) return true;
            try {
                return lowerCase(readCalibration(volume.file).serial) == lowerCase(*serial);
            } catch (const Error&) {
                return false;
            }
        };
        std::string list;
        for (const MountedCalibration& volume : volumes) {
            if (named(volume)) return volume;
            list += (list.empty() ? "" : ", ") + volume.volume;
        }
        throw Error(ErrorCode::NotFound, "--serial",
                    "no mounted display is " + *serial + ", expected " +
                        (list.empty() ? "a display's volume to be mounted" : "one of " + list));
    }
    if (volumes.empty()) return std::nullopt;
    if (volumes.size() == 1) return volumes.front();
    if (search.firstWillDo) {
        messages.warn("several displays are mounted: the calibration of " + volumes.front().volume +
                      " is used");
        return volumes.front();
    }
    std::string list;
    for (const MountedCalibration& volume : volumes) {
        list += (list.empty() ? "" : ", ") + volume.volume + " (" + volume.file.string() + ")";
    }
    throw Error(ErrorCode::InvalidArgument, "calibration",
                "several displays are mounted: " + list + "; expected --serial to choose one");
}

fs::path sampleCalibration() {
    for (const fs::path& directory : dataDirectories()) {
        std::error_code error;
        fs::path sample = directory / "calibration" / kSampleName;
        if (fs::exists(sample, error)) return sample;
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
            const Calibration mounted = readCalibration(volume.file);
            if (fingerprint(mounted) == fingerprint(display.calibration)) return;
        } catch (const Error&) {
            continue; // nothing to compare with
        }
        others += (others.empty() ? "" : ", ") + volume.volume + " (" + volume.file.string() + ")";
    }
    if (others.empty()) return;
    messages.warn(display.source +
                  ": is used, but a display with another calibration is mounted: " + others +
                  "; to use that one, give its file with -c");
}

// The calibration of -c, or the first one found.
ChosenDisplay chooseCalibration(const CommandLine& commandLine, const VolumeSearch& volumes,
                                Messages& messages) {
    const InvertViews invert = invertOption(commandLine);
    const auto chosen = [&](const fs::path& given) {
        const fs::path file = calibrationFile(given);
        return chosenDisplay(readChosenCalibration(file, commandLine, messages), file, invert);
    };
    std::error_code error;
    if (const auto file = commandLine.value("c")) return chosen(*file);
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
    if (fs::exists("visual.json", error)) {
        ChosenDisplay display = chosen("visual.json");
        warnOfAnotherMounted(display, volumes, messages);
        return display;
    }
    if (const auto volume = mountedVolume(commandLine.value("serial"), volumes, messages)) {
        // the volume is chosen already: its file's serial may be cut short
        return chosenDisplay(readCalibration(volume->file), volume->file, invert);
    }
    const fs::path sample = sampleCalibration();
    ChosenDisplay display = chosenDisplay(readCalibration(sample), sample, invert);
    display.source = "the sample calibration of a Portrait";
    display.isSample = true;
    return display;
}

// The warning about using the sample calibration in place of a display's own.
std::string sampleWarning(DisplayUse use) {
    const std::string none = "no calibration was given or found: ";
    switch (use) {
    case DisplayUse::Show:
        return none + "the sample one of a Portrait is used, and a real display will show the "
                      "picture doubled and blurred; give the display's own file with -c "
                      "visual.json";
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

// Keeps the cache below its limit by removing the least recently used tables.
void trimCache(const fs::path& directory) {
    struct Entry {
        fs::file_time_type used;
        std::uintmax_t bytes;
        fs::path file;
    };
    std::vector<Entry> entries;
    std::uintmax_t total = 0;
    std::error_code error;
    for (fs::directory_iterator it(directory, error), end; !error && it != end;
         it.increment(error)) {
        std::error_code ignored;
        if (it->path().extension() != ".map" || !it->is_regular_file(ignored)) continue;
        entries.push_back({it->last_write_time(ignored), it->file_size(ignored), it->path()});
        total += entries.back().bytes;
    }
    std::sort(entries.begin(), entries.end(),
              [](const Entry& a, const Entry& b) { return a.used < b.used; });
    for (const Entry& entry : entries) {
        if (total <= kCacheBytes) break;
        fs::remove(entry.file, error);
        total -= entry.bytes;
    }
}

// The table of a display from the user's cache. A missing table is built and kept there. The cache
// is optional: if anything is wrong with it, the table is built.
NativeLut cachedLut(const Calibration& calibration, const QuiltLayout& layout, InvertViews invert,
                    Messages& messages) {
    const bool inverted = lensGeometry(calibration, invert).inverted;
    const fs::path directory = cacheDirectory();
    fs::path file;
    if (!directory.empty()) {
        file = directory /
               (fingerprintText(fingerprint(calibration)) + "-" + std::to_string(layout.columns) +
                "x" + std::to_string(layout.rows) + "-" + std::to_string(layout.tileSize.width) +
                "x" + std::to_string(layout.tileSize.height) + "-" +
                std::to_string(layout.viewCount) + (inverted ? "-inverted" : "") + ".map");
        std::error_code error;
        if (fs::exists(file, error)) {
            try {
                NativeLut lut = NativeLut::load(file);
                if (lut.quilt() == layout && lut.inverted() == inverted &&
                    lut.calibrationFingerprint() == fingerprint(calibration)) {
                    fs::last_write_time(file, fs::file_time_type::clock::now(), error);
                    messages.detail("look-up table: from the cache, " + file.string());
                    return lut;
                }
            } catch (const Error& problem) {
                messages.detail(std::string("look-up table in the cache is not used: ") +
                                problem.what());
            }
        }
    }
    NativeLut lut(calibration, layout, invert);
    if (!file.empty()) {
        try {
            std::error_code ignored;
            fs::create_directories(directory, ignored);
            lut.save(file);
            trimCache(directory);
            messages.detail("look-up table: built and kept as " + file.string());
        } catch (const Error& problem) {
            messages.detail(std::string("look-up table: built, not kept: ") + problem.what());
        }
    }
    return lut;
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

// An error of the library about a quilt, with the option's name as its subject.
Error inOptions(const Error& error) {
    const std::string text = error.what();
    for (const auto& [subject, option] : {std::pair("quilt grid", "-q"), {"view size", "-r"}}) {
        const std::string beginning = std::string(subject) + ": ";
        if (text.rfind(beginning, 0) == 0)
            return {error.code(), option, text.substr(beginning.size())};
    }
    return error;
}

// "16:9", or "1.85:1" for what has no short name
std::string aspectText(double aspect) {
    constexpr int kMax = 21;
    for (int height = 1; height <= kMax; ++height) {
        const int width = static_cast<int>(std::lround(aspect * height));
        if (width < 1 || width > kMax || std::min(width, height) > 10) continue;
        if (std::abs(static_cast<double>(width) / height / aspect - 1) < kSameAspect)
            return std::to_string(width) + ":" + std::to_string(height);
    }
    return fixed(aspect, 2) + ":1";
}

} // namespace

fs::path cacheDirectory() {
    const auto cache = environment("XDG_CACHE_HOME");
    if (cache && fs::path(*cache).is_absolute()) return fs::path(*cache) / "altiro3D";
    if (const auto home = environment("HOME")) return fs::path(*home) / ".cache" / "altiro3D";
    return {};
}

void addInvertOption(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"invert"},
        "Reverse the order of the views under a lens: on, off or auto (default: as the "
        "calibration states; always on for panels with sub-pixel cells).",
        "auto|on|off");
}

InvertViews invertOption(const CommandLine& commandLine) {
    constexpr InvertViews kModes[] = {InvertViews::Auto, InvertViews::On, InvertViews::Off};
    return kModes[commandLine.choice("invert", {"auto", "on", "off"}).value_or(0)];
}

void addQuiltOptions(CommandLine& commandLine) {
    commandLine.add({"q", "layout"},
                    "Views in the quilt, rows x columns (default: the display model's; 6x8 on a "
                    "Portrait: 6 rows of 8 columns).",
                    "RxC");
    commandLine.addOldName("layout", "quilt");
    commandLine.addAdvanced(
        {"r", "resolution"},
        "Size of one view, height x width in px (default: the display model's; 560x420 "
        "on a Portrait).",
        "HxW");
}

void addDisplayOptions(CommandLine& commandLine) {
    commandLine.addSection("Display");
    commandLine.addAdvanced({"m", "map"}, "Look-up table of the display, made by altiro3Dnative.",
                            "FILE.map");
    commandLine.add({"c", "calibration"},
                    "Calibration of the display. Without -m and -c: $LKG_CALIBRATION, "
                    "./visual.json, a display's own volume if it is mounted, else a sample.",
                    "visual.json");
    commandLine.addAdvanced(
        {"serial"}, "Choose among several displays by serial number or volume name.", "NAME");
    addInvertOption(commandLine);
    commandLine.addSection("Quilt");
    addQuiltOptions(commandLine);
    using Chapter = CommandLine::Chapter;
    commandLine.addTerm(Chapter::Files, "visual.json",
                        "Calibration of a display. Its USB volume holds it as "
                        "LKG_calibration/visual.json.");
    commandLine.addTerm(Chapter::Files,
                        std::string("PREFIX/share/altiro3D/calibration/") + kSampleName,
                        "The sample calibration, of a Portrait. PREFIX is where the tools are "
                        "installed, such as /usr.");
    commandLine.addTerm(Chapter::Files, "~/.cache/altiro3D/",
                        "Look-up tables and measurements of earlier runs. It may be deleted.");
    commandLine.addTerm(Chapter::Environment, "LKG_CALIBRATION",
                        "Calibration that is used without -m and -c: a file, or a display's "
                        "volume.");
    commandLine.addTerm(Chapter::Environment, "XDG_CACHE_HOME",
                        "Directory that is used instead of ~/.cache.");
}

void addSamplingOptions(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"view-filter"},
        "Views that a sub-pixel shows: nearest (default) or linear, a blend of two; "
        "not with -m.",
        "nearest|linear");
    commandLine.addAdvanced(
        {"sampling"},
        "Pixels inside a view: nearest (default) or linear, a blend of four; not with "
        "-m.",
        "nearest|linear");
}

QuiltSampling samplingOption(const CommandLine& commandLine) {
    const auto views = commandLine.choice("view-filter", {"nearest", "linear"});
    const auto inTile = commandLine.choice("sampling", {"nearest", "linear"});
    QuiltSampling sampling;
    if (views.value_or(0) == 1) sampling.views = ViewFilter::Linear;
    if (inTile.value_or(0) == 1) sampling.inTile = TileSampling::Linear;
    return sampling;
}

bool blends(const QuiltSampling& sampling) {
    return sampling.views != ViewFilter::Nearest || sampling.inTile != TileSampling::Nearest;
}

fs::path calibrationFile(const fs::path& given) {
    std::error_code error;
    std::string beginning(8, '\0');
    if (fs::is_regular_file(given, error)) // a pipe gives its bytes once
        std::ifstream(given, std::ios::binary).read(beginning.data(), 8);
    if (beginning == "ALTIRO3D") {
        throw Error(ErrorCode::BadFormat, given.string(),
                    "is a look-up table, expected a display's visual.json (tools that use tables "
                    "take them with -m)");
    }
    for (const char* place : {"visual.json", "LKG_calibration/visual.json"}) {
        if (fs::is_regular_file(given / place, error)) return given / place;
    }
    return given;
}

Calibration readChosenCalibration(const fs::path& file, const CommandLine& commandLine,
                                  Messages& messages) {
    const std::vector<Calibration> all = readCalibrations(file);
    const auto serial = commandLine.value("serial");
    if (serial) {
        for (const Calibration& calibration : all) {
            if (lowerCase(calibration.serial) == lowerCase(*serial)) return calibration;
        }
        throw Error(ErrorCode::NotFound, file.string(),
                    "holds no calibration of " + *serial + ", expected the serial number of " +
                        (all.front().serial.empty() ? "a display in it" : all.front().serial));
    }
    if (all.size() > 1) {
        messages.warn(file.string() + " holds " + std::to_string(all.size()) +
                      " calibrations; the first, " + all.front().serial +
                      ", is used (--serial chooses another)");
    }
    return all.front();
}

ChosenDisplay chosenDisplay(Calibration calibration, const fs::path& file, InvertViews invert) {
    ChosenDisplay display{displayOf(std::move(calibration), file.string()), {file}, {}};
    display.invert = invert;
    return display;
}

void tellDisplay(const ChosenDisplay& display, DisplayUse use, Messages& messages) {
    if (use == DisplayUse::None) return;
    if (display.isSample) {
        messages.say("display: none was given or found; " + display.source + ", panel " +
                     sizeText(display.panelSize()));
        messages.warn(sampleWarning(use));
        return;
    }
    const Calibration& known = display.calibration;
    if (!display.isMapOnly) messages.warn(calibrationWarnings(known));
    const DisplayModel* const model = findDisplayModel(known);
    messages.say("display: " + (model != nullptr ? model->name : std::string("unknown model")) +
                 (known.serial.empty() ? "" : ", serial " + known.serial) + ", panel " +
                 sizeText(display.panelSize()) + ", " +
                 (use == DisplayUse::Simulate ? "simulated from " : "from ") + display.source);
}

ChosenDisplay findCalibration(const CommandLine& commandLine, Messages& messages,
                              const VolumeSearch& volumes, DisplayUse use) {
    ChosenDisplay display = chooseCalibration(commandLine, volumes, messages);
    tellDisplay(display, use, messages);
    return display;
}

ChosenDisplay findDisplay(const CommandLine& commandLine, Messages& messages,
                          const VolumeSearch& volumes, DisplayUse use) {
    samplingOption(commandLine); // reports wrong usage before any work
    ChosenDisplay display;
    if (const auto file = commandLine.value("m")) {
        if (fs::path(*file).extension() == ".json") {
            throw UsageError(*file + ": is a calibration, expected a look-up table (.map); "
                                     "calibrations are given with -c");
        }
        commandLine.exclude("m", "invert");
        commandLine.exclude("m", "view-filter");
        commandLine.exclude("m", "sampling");
        display.invert = invertOption(commandLine);
        display.map = readMap(*file);
        display.files = {*file};
        display.source = *file;
        display.quilt = display.map->quilt();
        if (const auto given = commandLine.value("c")) {
            const fs::path other = calibrationFile(*given);
            display.calibration = readChosenCalibration(other, commandLine, messages);
            display.files.emplace_back(other);
            requireSameDisplay(*display.map, *file, display.calibration, other);
        } else {
            display.isMapOnly = true;
            display.calibration.serial = display.map->serial();
            display.calibration.screenW = display.map->panelSize().width;
            display.calibration.screenH = display.map->panelSize().height;
        }
    } else {
        display = chooseCalibration(commandLine, volumes, messages);
    }
    tellDisplay(display, use, messages);
    return display;
}

void tellShape(const QuiltShape& shape, Messages& messages) {
    if (!shape.fitsUnasked()) return;
    messages.say("fit: by the file name the shape of the views differs from the panel's; black "
                 "bars keep it (--fit cover or stretch fills the panel)");
}

std::string quiltText(const QuiltLayout& layout, double aspect) {
    std::string text = layout.text();
    const double ofTile = static_cast<double>(layout.tileSize.width) / layout.tileSize.height;
    if (!haveSameShape(ofTile, aspect)) text += ", shown " + aspectText(aspect);
    return text;
}

ResolvedQuilt resolveLayout(const QuiltRequest& request, const QuiltLayout& standard,
                            double panelAspect) {
    try {
        ResolvedQuilt resolved = resolveQuilt(request, standard, panelAspect);
        for (Note& note : resolved.notes)
            note.text += request.tileSize ? " (-q takes rows x columns, -r height x width)"
                                          : " (-q takes rows x columns)";
        return resolved;
    } catch (const Error& error) {
        throw inOptions(error);
    }
}

std::optional<QuiltGrid> gridOption(const CommandLine& commandLine) {
    const auto text = commandLine.value("q");
    if (!text) return std::nullopt;
    try {
        return parseQuiltGrid(*text);
    } catch (const Error& error) {
        throw UsageError(inOptions(error).what());
    }
}

bool isLayoutStated(const CommandLine& commandLine, const fs::path& quiltFile) {
    return commandLine.has("q") || commandLine.has("r") || parseQuiltName(quiltFile).has_value();
}

std::optional<QuiltGrid> certainLayout(const FoundQuilt& found, const fs::path& file, cv::Size size,
                                       const QuiltLayout& usual) {
    const QuiltGrid grid{found.layout.columns, found.layout.rows};
    switch (found.verdict) {
    case QuiltVerdict::Quilt:
        return grid;
    case QuiltVerdict::NoQuilt:
        throw Error(ErrorCode::BadFormat, file.string(),
                    "is a photo or another picture of one view, expected a quilt (photo2native "
                    "makes a Native of a photo; -q ROWSxCOLUMNS reads any picture as a quilt)");
    case QuiltVerdict::Unsure:
        break;
    }
    // a few px more or less, where views have a fractional size
    if (usual.tileSize == cv::Size(size.width / usual.columns, size.height / usual.rows))
        return std::nullopt;
    std::string problem = "its name does not state the layout, and the picture shows none clearly";
    if (found.confidence > 0) {
        problem += " (perhaps " + std::to_string(grid.columns) + " columns x " +
                   std::to_string(grid.rows) + " rows)";
    }
    throw UsageError(file.string() + ": " + problem +
                     ", expected -q ROWSxCOLUMNS, or a name that ends in "
                     "_qs<columns>x<rows>a<aspect>");
}

bool isQuiltPicture(const FoundQuilt& found, cv::Size picture, const QuiltLayout& usual) {
    if (found.verdict != QuiltVerdict::Unsure) return found.verdict == QuiltVerdict::Quilt;
    return cv::Size(picture.width / usual.columns, picture.height / usual.rows) == usual.tileSize;
}

std::string foundText(const FoundQuilt& found) {
    if (found.verdict != QuiltVerdict::Quilt) return "";
    return "; found in the picture, " + fixed(100 * found.confidence, 0) + " % sure";
}

QuiltLayout chooseQuilt(const CommandLine& commandLine, const ChosenDisplay& display,
                        Messages& messages, const std::optional<fs::path>& quiltFile,
                        std::optional<cv::Size> quiltSize, const std::optional<FoundQuilt>& found) {
    QuiltRequest request;
    request.grid = gridOption(commandLine);
    try {
        if (const auto tile = commandLine.value("r")) request.tileSize = parseTileSize(*tile);
    } catch (const Error& error) {
        throw UsageError(inOptions(error).what());
    }
    if (quiltFile) request.name = parseQuiltName(*quiltFile);
    request.quiltSize = quiltSize;
    const bool stated = display.map && found && found->verdict != QuiltVerdict::Quilt; // by the map
    if (found && !stated)
        request.found = certainLayout(*found, *quiltFile, *quiltSize, display.quilt);
    const ResolvedQuilt resolved = resolveLayout(request, display.quilt, display.aspect());
    QuiltLayout layout = resolved.layout;
    if (display.map) {
        const QuiltLayout& mapped = display.map->quilt();
        layout.viewCount = mapped.viewCount;
        if (layout != mapped) {
            throw Error(ErrorCode::Mismatch, display.source,
                        "is made for a quilt of " + sizeText(mapped.size()) + " with " +
                            mapped.text() + ", but this one has " + sizeText(layout.size()) +
                            " with " + layout.text() + "; expected the map's");
        }
    }
    // of a nameless quilt the map states what it is
    if (!display.map || request.grid || request.tileSize || request.name)
        messages.warn(resolved.notes);
    return layout;
}

NativeLut lookUpTable(const ChosenDisplay& display, const QuiltLayout& layout, Messages& messages) {
    return display.map ? *display.map
                       : cachedLut(display.calibration, layout, display.invert, messages);
}

Quilt2Native makeQuilt2Native(const CommandLine& commandLine, const ChosenDisplay& display,
                              const QuiltLayout& layout, Messages& messages) {
    const QuiltSampling sampling = samplingOption(commandLine);
    if (blends(sampling)) return {display.calibration, layout, sampling, display.invert};
    return Quilt2Native(lookUpTable(display, layout, messages));
}

} // namespace altiro3D::tools
