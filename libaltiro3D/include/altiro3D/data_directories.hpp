#pragma once

#include "altiro3D/export.hpp"

#include <filesystem>
#include <vector>

namespace altiro3D {

/// Directories that are searched for the files of the library (`models/`, `calibration/`). In this
/// order:
/// - `share/altiro3D` of the installation that contains this library or program, also after the
///   installation was moved as a whole;
/// - the source tree, if the build enables it;
/// - `share/altiro3D` of the prefix that the build was configured for.
///
/// Directories that do not exist are left out.
///
/// @return the directories in search order
ALTIRO3D_EXPORT std::vector<std::filesystem::path> dataDirectories();

} // namespace altiro3D
