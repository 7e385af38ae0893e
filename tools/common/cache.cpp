#include "common/cache.hpp"

#include "altiro3D/error.hpp"

#include <algorithm>
#include <vector>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t kMaxCacheBytes = std::uintmax_t{1} << 30;

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
        if (total <= kMaxCacheBytes) break;
        fs::remove(entry.file, error);
        total -= entry.bytes;
    }
}

// The name of a table in the cache.
std::string tableName(std::uint64_t calibration, const QuiltLayout& layout, bool inverted) {
    return fingerprintText(calibration) + "-" + std::to_string(layout.columns) + "x" +
           std::to_string(layout.rows) + "-" + std::to_string(layout.tileSize.width) + "x" +
           std::to_string(layout.tileSize.height) + "-" + std::to_string(layout.viewCount) +
           (inverted ? "-inverted" : "") + ".map";
}

// A table that an earlier run kept; nothing if it is missing, damaged or of another display.
std::optional<NativeLut> keptLut(const fs::path& file, std::uint64_t calibration,
                                 const QuiltLayout& layout, bool inverted, Messages& messages) {
    std::error_code error;
    if (!fs::exists(file, error)) return std::nullopt;
    try {
        NativeLut lut = NativeLut::load(file);
        if (lut.quilt() != layout || lut.inverted() != inverted ||
            lut.calibrationFingerprint() != calibration)
            return std::nullopt;
        fs::last_write_time(file, fs::file_time_type::clock::now(), error);
        messages.detail("look-up table: from the cache, " + file.string());
        return lut;
    } catch (const Error& problem) {
        messages.detail(std::string("look-up table in the cache is not used: ") + problem.what());
        return std::nullopt;
    }
}

void keepLut(const NativeLut& lut, const fs::path& file, Messages& messages) {
    try {
        std::error_code ignored;
        fs::create_directories(file.parent_path(), ignored);
        lut.save(file);
        trimCache(file.parent_path());
        messages.detail("look-up table: built and kept as " + file.string());
    } catch (const Error& problem) {
        messages.detail(std::string("look-up table: built, not kept: ") + problem.what());
    }
}

} // namespace

fs::path cacheDirectory() {
    const auto cache = environment("XDG_CACHE_HOME");
    if (cache && fs::path(*cache).is_absolute()) return fs::path(*cache) / "altiro3D";
    if (const auto home = environment("HOME")) return fs::path(*home) / ".cache" / "altiro3D";
    return {};
}

NativeLut cachedLut(const Calibration& calibration, const QuiltLayout& layout, InvertViews invert,
                    Messages& messages) {
    const fs::path directory = cacheDirectory();
    if (directory.empty()) return NativeLut(calibration, layout, invert);
    const bool inverted = lensGeometry(calibration, invert).inverted;
    const std::uint64_t display = fingerprint(calibration);
    const fs::path file = directory / tableName(display, layout, inverted);
    if (auto kept = keptLut(file, display, layout, inverted, messages)) return std::move(*kept);
    NativeLut lut(calibration, layout, invert);
    keepLut(lut, file, messages);
    return lut;
}

} // namespace altiro3D::tools
