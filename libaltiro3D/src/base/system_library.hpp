#pragma once

#include <filesystem>
#include <string>

/// Libraries that are opened when they are first needed.
namespace altiro3D {

/// Opens a library; it stays open. @param name as the system finds it, or its file @return or null
void* openLibrary(const std::string& name);
/// The address of a function or of data. @param library null: the result is null @return or null
void* addressIn(void* library, const char* name);
/// Why the last of these calls has returned null.
std::string libraryProblem();

/// The file that contains this code: the shared library, or the program that it is linked into.
/// @return an absolute path; empty if it is not known
std::filesystem::path ownFile();

/// The prefix of an installation (data_directories.cpp).
/// @param file absolute path of an installed file
/// @param place directory of that file below the prefix, for example `lib/x86_64-linux-gnu`
/// @return empty if the file is not in such a directory, or `place` is absolute
std::filesystem::path prefixOf(const std::filesystem::path& file,
                               const std::filesystem::path& place);

} // namespace altiro3D
