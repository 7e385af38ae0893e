#pragma once

#include <filesystem>
#include <string>

#include <windows.h>

/// What the sources for Windows share. No other source includes this.
namespace altiro3D {

/// The number of errno that stands for GetLastError(). EBUSY: another program has the file open.
int lastErrno();
/// The name of a file for the functions of Windows, which may have more than 259 characters.
std::wstring longName(const std::filesystem::path& path);

} // namespace altiro3D
