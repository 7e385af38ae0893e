#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace altiro3D::tools {

/// Pictures of a folder below this number are not taken for views: bursts have a few pictures.
constexpr std::size_t kFewestViews = 8;

/// Why the pictures of a folder are not views of one scene from a row of cameras. They are if there
/// are enough, of one size, if one number in their names counts in equal steps, if
/// neighbours resemble each other, and if the camera moves in one direction, not up or down.
///
/// @param files all pictures of the folder, in natural order of their names
/// @param fewest number of views at least, 2 or more
/// @return empty if they are views; else "holds 3 pictures". Some pictures are read; if one cannot
///         be read, the reason says so.
std::string reasonAgainstViews(const std::vector<std::filesystem::path>& files,
                               std::size_t fewest = kFewestViews);

} // namespace altiro3D::tools
