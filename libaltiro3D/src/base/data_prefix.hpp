#pragma once

#include <filesystem>

namespace altiro3D {

/// The prefix of an installation.
/// @param file a file of it, absolute
/// @param place the folder of that file below the prefix, as `lib/x86_64-linux-gnu`
/// @return empty if the file does not lie in such a folder, or the place is absolute
std::filesystem::path prefixOf(const std::filesystem::path& file,
                               const std::filesystem::path& place);

} // namespace altiro3D
