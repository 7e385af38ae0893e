#pragma once

#include "altiro3D/export.hpp"

#include <filesystem>
#include <vector>

namespace altiro3D {

/// Where the files that come with the library are looked for (`models/`, `calibration/`), in this
/// order: `share/altiro3D` of the installation that this library or program lies in, wherever it
/// was moved to as a whole; the source tree, where the build was told to; `share/altiro3D` of the
/// prefix that the build was made for. Directories that do not exist are left out.
///
/// @return the directories, first choice first
ALTIRO3D_EXPORT std::vector<std::filesystem::path> dataDirectories();

} // namespace altiro3D
