#pragma once

#include <filesystem>

namespace altiro3D {

/// Whether a file name has the extension of a picture, as for listImages().
bool hasImageExtension(const std::filesystem::path& file);

} // namespace altiro3D
