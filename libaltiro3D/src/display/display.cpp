#include "altiro3D/display.hpp"

#include "altiro3D/error.hpp"
#include "base/system_file.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// columns x rows in a quilt of the given size; the tile size is rounded down.
QuiltLayout quiltOf(QuiltGrid grid, cv::Size quilt) {
    const cv::Size tile(quilt.width / grid.columns, quilt.height / grid.rows);
    return {grid.columns, grid.rows, tile, grid.columns * grid.rows};
}

DisplayModel model(const char* name, const char* prefix, cv::Size panel, double dpi, double cone,
                   QuiltGrid grid, cv::Size quilt) {
    return {name, prefix, panel, dpi, cone, quiltOf(grid, quilt)};
}

// Models that findDisplayModel() tells apart by more than the panel's size.
constexpr const char* kSecond16 = "Looking Glass 16\" (2nd generation)";
constexpr const char* kSecond32 = "Looking Glass 32\" (2nd generation)";
constexpr const char* k16 = "Looking Glass 16\" landscape";
constexpr const char* k27 = "Looking Glass 27\" landscape";
constexpr const char* k27Portrait = "Looking Glass 27\" portrait";
constexpr const char* k32 = "Looking Glass 32\" landscape";
constexpr const char* k65 = "Looking Glass 65\"";
constexpr const char* k65Portrait = "Looking Glass 65\" portrait";

// In the order in which their serial prefixes are tried. Sources:
//   T  the maker's LKG-Toolkit, templates of calibrations and quilts
//   X  the maker's looking-glass-webxr
//   V  Kitware's LookingGlassVTKModule, quilts
//   B  Looking Glass Bridge: its templates of calibrations, as horinoh/LookingGlass lists them
//   C  public programs for the CubeVi C1: views of 540 x 960 px, a cone of 40 degrees
//   U  what Bridge reports of a unit, as quiltwright records it (LKG-J00332, LKG-E14851)
std::vector<DisplayModel> makeDisplayModels() {
    std::vector<DisplayModel> models = {
        // T X
        model("Looking Glass 8.9\"", "LKG-2K", {2560, 1600}, 338, 40, {5, 9}, {4096, 4096}),
        model("Looking Glass 15.6\"", "LKG-4K", {3840, 2160}, 283, 40, {5, 9}, {4096, 4096}),
        model("Looking Glass 8K", "LKG-8K", {7680, 4320}, 280, 40, {5, 9}, {8192, 8192}),
        model("Looking Glass Portrait", "LKG-P", {1536, 2048}, 324, 40, {8, 6}, {3360, 3360}),
        model(kSecond16, "LKG-A", {3840, 2160}, 283, 40, {5, 9}, {4096, 4096}),
        model(kSecond32, "LKG-B", {7680, 4320}, 280, 40, {5, 9}, {8192, 8192}),
        model(k65, "LKG-D", {7680, 4320}, 136, 40, {8, 9}, {8192, 8192}),
        // T
        model("Looking Glass Prototype", "LKG-Q", {7680, 4320}, 136.6, 40, {5, 9}, {4096, 4096}),
        // T X U
        model("Looking Glass Go", "LKG-E", {1440, 2560}, 491, 54, {11, 6}, {4092, 4092}),
        // B; cone as Go, quilt as 15.6"
        model("Looking Glass Go landscape", "LKG-G", {2560, 1440}, 491, 54, {5, 9}, {4096, 4096}),
        // X; the quilt of T has another shape than the panel
        model("Looking Glass Kiosk", "LKG-F", {1536, 2048}, 324, 40, {8, 6}, {3360, 3360}),
        // T X V
        model("Looking Glass 16\" portrait", "LKG-H", {2160, 3840}, 283, 50, {11, 6}, {5995, 6000}),
        // T X; quilt U, the earlier one T X V
        model(k16, "LKG-J", {3840, 2160}, 283, 50, {8, 6}, {7680, 4320}),
        // T X; V has 12 x 4 views in the same quilt
        model("Looking Glass 32\" portrait", "LKG-K", {4320, 7680}, 280, 54, {11, 6}, {8184, 8184}),
        // T X V
        model(k32, "LKG-L", {7680, 4320}, 280, 50, {7, 7}, {8190, 8190}),
        // quilt V; cone as 16" and Go; serial numbers and panel are not known
        model(k27, "", {}, 0, 50, {8, 6}, {7680, 4320}),
        model(k27Portrait, "", {}, 0, 54, {12, 4}, {7680, 4320}),
        // B has its name only; panel as 65" turned, cone and quilt as 32" portrait
        model(k65Portrait, "", {4320, 7680}, 136, 54, {11, 6}, {8184, 8184}),
        // C; after the Go, whose panel has the same size
        model("CubeVi C1", "cubevi-c1", {1440, 2560}, 515.3, 40, {8, 5}, {4320, 4800}),
    };
    for (DisplayModel& m : models)
        if (m.name == k16) m.earlierQuilt = quiltOf({7, 7}, {5999, 5999});
    return models;
}

const std::vector<DisplayModel>& displayModels() {
    static const std::vector<DisplayModel> kModels = makeDisplayModels();
    return kModels;
}

const DisplayModel* byName(const std::string& name) {
    for (const DisplayModel& m : displayModels()) {
        if (m.name == name) return &m;
    }
    return nullptr;
}

// Some models share a panel; cone, cells, density and diagonal distinguish them.
const DisplayModel* byPanel(const Calibration& c) {
    const bool third = std::abs(c.viewCone - 50) < 0.5 || !c.subpixelCells.empty();
    const cv::Size panel(c.screenW, c.screenH);
    const bool sparse = c.DPI < 200;
    const double diagonalInches = std::hypot(c.screenW, c.screenH) / c.DPI;
    if (std::abs(diagonalInches - 27) < 1) return byName(c.screenW < c.screenH ? k27Portrait : k27);
    if (panel == cv::Size(3840, 2160)) return byName(third ? k16 : kSecond16);
    if (panel == cv::Size(7680, 4320)) {
        if (third) return byName(k32);
        return byName(sparse ? k65 : kSecond32);
    }
    if (panel == cv::Size(4320, 7680) && sparse) return byName(k65Portrait);
    for (const DisplayModel& m : displayModels()) {
        if (m.panelSize == panel) return &m;
    }
    return nullptr;
}

// Px from lens to lens.
double pixelsOfLens(const Calibration& c) {
    const LensGeometry g = lensGeometry(c);
    return 1 /
           std::hypot(g.periodsPerWidth / g.panelWidth, g.tilt * g.periodsPerWidth / g.panelHeight);
}

int viewsOf(const Calibration& c) {
    if (!c.sheet || (!c.sheet->isPrint && c.sheet->views == 0)) return 48;
    if (c.sheet->views > 0) return c.sheet->views;
    return std::clamp(static_cast<int>(std::lround(pixelsOfLens(c))), 2, kMaxSheetViews);
}

} // namespace

const DisplayModel* findDisplayModel(const Calibration& calibration) {
    if (calibration.sheet) return nullptr; // self-made, whatever its size
    const std::string serial = lowerCase(calibration.serial);
    for (const DisplayModel& m : displayModels()) {
        if (!m.serialPrefix.empty() && startsWith(serial, lowerCase(m.serialPrefix))) return &m;
    }
    return byPanel(calibration);
}

QuiltLayout defaultQuilt(const Calibration& calibration) {
    if (const DisplayModel* m = findDisplayModel(calibration)) return m->quilt;
    // Views of the panel's shape. For prints, as many as are useful, with two px per lens; else 48
    // on about 4096 x 4096 px.
    const double aspect = Display{calibration, {}, {}, {}}.aspect();
    const int views = viewsOf(calibration);
    double area = 4096.0 * 4096.0 / views;
    if (calibration.sheet && calibration.sheet->isPrint) {
        const double width = 2 * calibration.screenW / pixelsOfLens(calibration);
        area = std::min(4 * area, width * width / aspect);
    }
    const double limit = static_cast<double>(kMaxQuiltSide) / 8;
    const auto side = [limit](double px) {
        return static_cast<int>(std::lround(std::min(std::max(px, 1.0), limit)));
    };
    const cv::Size tile(side(std::sqrt(area * aspect)), side(std::sqrt(area / aspect)));
    if (views == 48) return aspect < 1 ? QuiltLayout{8, 6, tile, 48} : QuiltLayout{6, 8, tile, 48};
    const int columns = static_cast<int>(std::ceil(std::sqrt(views)));
    return {columns, (views + columns - 1) / columns, tile, views};
}

QuiltLayout usualQuilt(const Display& display, const QuiltRequest& request) {
    const DisplayModel* m = findDisplayModel(display.calibration);
    if (m == nullptr || !m->earlierQuilt) return display.quilt;
    const QuiltLayout& earlier = *m->earlierQuilt;
    const bool isMeant = request.grid ? request.grid->columns == earlier.columns &&
                                            request.grid->rows == earlier.rows
                                      : request.quiltSize == earlier.size();
    return isMeant ? earlier : display.quilt;
}

Notes calibrationWarnings(const Calibration& c) {
    Notes result;
    const DisplayModel* m = findDisplayModel(c);
    if (m != nullptr && !m->panelSize.empty() && m->panelSize != cv::Size(c.screenW, c.screenH)) {
        result.push_back({NoteCode::Doubtful, "serial number " + c.serial + " is that of a " +
                                                  m->name + " with " + sizeText(m->panelSize) +
                                                  ", but the panel has " +
                                                  pairText(c.screenW, c.screenH) + " px"});
    }
    if (m != nullptr && (m->serialPrefix == "LKG-H" || m->serialPrefix == "LKG-J") &&
        c.subpixelCells.empty()) {
        result.push_back(
            {NoteCode::Doubtful, "a " + m->name +
                                     " has sub-pixel cells, but the file has none, as of old "
                                     "firmware: most sub-pixels will show a wrong view"});
    }
    if (c.fringe != 0)
        result.push_back({NoteCode::AsItIs, "fringe is not 0; this correction is not applied"});
    if (c.flipImageX >= 0.5 || c.flipImageY >= 0.5) {
        result.push_back(
            {NoteCode::Doubtful,
             "the flip flags are set, as in no display known so far: check the picture"});
    }
    return result;
}

Display displayOf(Calibration calibration, const std::string& source) {
    validate(calibration, source.empty() ? "calibration" : source);
    Display display;
    display.quilt = defaultQuilt(calibration);
    display.calibration = std::move(calibration);
    display.source = source;
    return display;
}

Display readDisplay(const fs::path& calibrationFile, const std::string& serial) {
    const std::vector<Calibration> all = readCalibrations(calibrationFile);
    const auto chosen = std::find_if(all.begin(), all.end(), [&](const Calibration& calibration) {
        return serial.empty() || lowerCase(calibration.serial) == lowerCase(serial);
    });
    if (chosen == all.end()) {
        throw Error(ErrorCode::NotFound, calibrationFile.string(),
                    "holds no calibration of " + shortened(serial) +
                        ", expected the serial number of " +
                        (all.front().serial.empty() ? "a display in it" : all.front().serial));
    }
    return displayOf(*chosen, calibrationFile.string());
}

Calibration readCalibration(const MountedCalibration& found) {
    if (found.problem) throw Error(*found.problem);
    return readCalibration(found.file);
}

std::vector<MountedCalibration> findMountedCalibrations(const fs::path& root) {
    // Volumes are mounted directly in these, or in a subdirectory such as a user's.
    const fs::path parents[] = {"media", "run/media", "mnt", "Volumes"};
    std::set<fs::path> files;
    const auto lookInto = [&files](const fs::path& directory, const auto& self,
                                   int levels) -> void {
        std::error_code error;
        for (fs::directory_iterator it(directory, error), end; !error && it != end;
             it.increment(error)) {
            std::error_code ignored;
            if (!it->is_directory(ignored)) continue;
            if (startsWith(lowerCase(it->path().filename().string()), "lkg")) {
                const fs::path file = it->path() / "LKG_calibration" / "visual.json";
                if (fs::is_regular_file(file, ignored)) files.insert(file);
            } else if (levels > 0) {
                self(it->path(), self, levels - 1);
            }
        }
    };
    for (const fs::path& parent : parents)
        lookInto(root / parent, lookInto, 1);
    if (root == "/") {
        for (const fs::path& drive : driveRoots()) {
            const fs::path file = drive / "LKG_calibration" / "visual.json";
            std::error_code ignored;
            if (fs::is_regular_file(file, ignored)) files.insert(file);
        }
    }
    std::vector<MountedCalibration> found;
    for (const fs::path& file : files) {
        found.push_back({file, file.parent_path().parent_path().filename().string()});
    }
    return found;
}

} // namespace altiro3D
