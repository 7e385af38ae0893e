#pragma once

#include <filesystem>

namespace altiro3D {

/// The prefix of an installation.
/// @param file absolute path of an installed file
/// @param place directory of that file below the prefix, for example `lib/x86_64-linux-gnu`
/// @return empty if the file is not in such a directory, or `place` is absolute
std::filesystem::path prefixOf(const std::filesystem::path& file,
                               const std::filesystem::path& place);

} // namespace altiro3D
