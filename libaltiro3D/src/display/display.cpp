#include "altiro3D/display.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// columns x rows in a quilt of the given size; the tile size is rounded down.
DisplayModel model(const char* name, const char* prefix, cv::Size panel, double dpi, double cone,
                   QuiltGrid grid, cv::Size quilt) {
    const cv::Size tile(quilt.width / grid.columns, quilt.height / grid.rows);
    return {name, prefix, panel,
            dpi,  cone,   {grid.columns, grid.rows, tile, grid.columns * grid.rows}};
}

std::string upper(std::string text) {
    for (char& c : text)
        c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return text;
}

// In the order in which their serial prefixes are tried.
const std::vector<DisplayModel>& displayModels() {
    static const std::vector<DisplayModel> kModels = {
        model("Looking Glass 8.9\"", "LKG-2K", {2560, 1600}, 338, 40, {5, 9}, {4096, 4096}),
        model("Looking Glass 15.6\"", "LKG-4K", {3840, 2160}, 283, 40, {5, 9}, {4096, 4096}),
        model("Looking Glass 8K", "LKG-8K", {7680, 4320}, 280, 40, {5, 9}, {8192, 8192}),
        model("Looking Glass Portrait", "LKG-P", {1536, 2048}, 324, 40, {8, 6}, {3360, 3360}),
        model("Looking Glass 16\" (2nd generation)", "LKG-A", {3840, 2160}, 283, 40, {5, 9},
              {4096, 4096}),
        model("Looking Glass 32\" (2nd generation)", "LKG-B", {7680, 4320}, 280, 40, {5, 9},
              {8192, 8192}),
        model("Looking Glass 65\"", "LKG-D", {7680, 4320}, 136, 40, {8, 9}, {8192, 8192}),
        model("Looking Glass Prototype", "LKG-Q", {7680, 4320}, 136.6, 40, {5, 9}, {4096, 4096}),
        model("Looking Glass Go", "LKG-E", {1440, 2560}, 491, 54, {11, 6}, {4092, 4092}),
        model("Looking Glass Kiosk", "LKG-F", {1536, 2048}, 324, 40, {8, 6}, {3360, 3360}),
        model("Looking Glass 16\" portrait", "LKG-H", {2160, 3840}, 283, 50, {11, 6}, {5995, 6000}),
        model("Looking Glass 16\" landscape", "LKG-J", {3840, 2160}, 283, 50, {7, 7}, {5999, 5999}),
        model("Looking Glass 32\" portrait", "LKG-K", {4320, 7680}, 280, 54, {11, 6}, {8184, 8184}),
        model("Looking Glass 32\" landscape", "LKG-L", {7680, 4320}, 280, 50, {7, 7}, {8190, 8190}),
    };
    return kModels;
}

const DisplayModel* byPrefix(const std::string& prefix) {
    for (const DisplayModel& m : displayModels()) {
        if (m.serialPrefix == prefix) return &m;
    }
    return nullptr;
}

// Some models share a panel; cone, cells and density distinguish them.
const DisplayModel* byPanel(const Calibration& c) {
    const bool third = std::abs(c.viewCone - 50) < 0.5 || !c.subpixelCells.empty();
    const cv::Size panel(c.screenW, c.screenH);
    if (panel == cv::Size(3840, 2160)) return byPrefix(third ? "LKG-J" : "LKG-A");
    if (panel == cv::Size(7680, 4320)) {
        if (third) return byPrefix("LKG-L");
        return byPrefix(c.DPI < 200 ? "LKG-D" : "LKG-B");
    }
    for (const DisplayModel& m : displayModels()) {
        if (m.panelSize == panel) return &m;
    }
    return nullptr;
}

} // namespace

const DisplayModel* findDisplayModel(const Calibration& calibration) {
    const std::string serial = upper(calibration.serial);
    for (const DisplayModel& m : displayModels()) {
        if (startsWith(serial, m.serialPrefix)) return &m;
    }
    return byPanel(calibration);
}

QuiltLayout defaultQuilt(const Calibration& calibration) {
    if (const DisplayModel* m = findDisplayModel(calibration)) return m->quilt;
    // 48 views of the panel's shape on about 4096 x 4096 px.
    const double aspect = static_cast<double>(calibration.screenW) / calibration.screenH;
    constexpr int kViews = 48;
    const double area = 4096.0 * 4096.0 / kViews;
    const double limit = static_cast<double>(kMaxQuiltSide) / 8;
    const auto side = [limit](double px) {
        return static_cast<int>(std::lround(std::min(std::max(px, 1.0), limit)));
    };
    const cv::Size tile(side(std::sqrt(area * aspect)), side(std::sqrt(area / aspect)));
    return aspect < 1 ? QuiltLayout{8, 6, tile, kViews} : QuiltLayout{6, 8, tile, kViews};
}

Notes calibrationWarnings(const Calibration& c) {
    Notes result;
    const DisplayModel* m = findDisplayModel(c);
    if (m != nullptr && m->panelSize != cv::Size(c.screenW, c.screenH)) {
        result.push_back({NoteCode::Doubtful, "serial number " + c.serial + " is that of a " +
                                                  m->name + " with " + sizeText(m->panelSize) +
                                                  " px, but the panel has " +
                                                  pairText(c.screenW, c.screenH) + " px"});
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
        return serial.empty() || upper(calibration.serial) == upper(serial);
    });
    if (chosen == all.end()) {
        throw Error(ErrorCode::NotFound, calibrationFile.string(),
                    "holds no calibration of " + shortened(serial) +
                        ", expected the serial number of " +
                        (all.front().serial.empty() ? "a display in it" : all.front().serial));
    }
    return displayOf(*chosen, calibrationFile.string());
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
            if (startsWith(upper(it->path().filename().string()), "LKG")) {
                const fs::path file = it->path() / "LKG_calibration" / "visual.json";
                if (fs::is_regular_file(file, ignored)) files.insert(file);
            } else if (levels > 0) {
                self(it->path(), self, levels - 1);
            }
        }
    };
    for (const fs::path& parent : parents)
        lookInto(root / parent, lookInto, 1);
    std::vector<MountedCalibration> found;
    for (const fs::path& file : files) {
        found.push_back({file, file.parent_path().parent_path().filename().string()});
    }
    return found;
}

} // namespace altiro3D
