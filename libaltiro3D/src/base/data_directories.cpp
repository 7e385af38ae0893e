#include "altiro3D/file_io.hpp"

#include "base/system_library.hpp"

#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

fs::path prefixOf(const fs::path& file, const fs::path& place) {
    if (place.has_root_directory() || place.empty()) return {};
    fs::path directory = file.parent_path();
    for (fs::path part = place; !part.empty(); part = part.parent_path()) {
        if (part.filename() != directory.filename()) return {};
        directory = directory.parent_path();
    }
    return directory;
}

std::vector<fs::path> dataDirectories() {
    std::vector<fs::path> candidates;
    const fs::path own = ownFile();
    for (const char* place : {ALTIRO3D_INSTALL_LIBDIR, ALTIRO3D_INSTALL_BINDIR}) {
        const fs::path prefix = prefixOf(own, place);
        if (!prefix.empty()) candidates.push_back(prefix / ALTIRO3D_INSTALL_DATADIR / "altiro3D");
    }
    candidates.emplace_back(ALTIRO3D_SOURCE_DATA_DIR);
    candidates.emplace_back(ALTIRO3D_INSTALL_DATA_DIR);

    std::vector<fs::path> directories;
    for (const fs::path& candidate : candidates) {
        std::error_code error; // an unreadable directory counts as missing
        if (fs::is_directory(candidate, error)) directories.push_back(candidate);
    }
    return directories;
}

} // namespace altiro3D
