#pragma once

#include <filesystem>
#include <sys/stat.h>

/// What all files that appear whole or not at all are written with (writeFile(), PartFile).
namespace altiro3D {

/// Throws WriteFailed with the system's words for an errno.
/// @param path the file as the user wrote it
[[noreturn]] void failWrite(const std::filesystem::path& path, int number);

/// Opens a file, whatever signals come. @return a descriptor, or -1 and errno
int openFile(const std::filesystem::path& path, int flags, mode_t mode = 0);

/// Where a path leads once its links are followed; need not exist.
/// @param isEnd if given, a path that it is true for is not followed any more
/// @throws Error WriteFailed
std::filesystem::path followLinks(const std::filesystem::path& path,
                                  bool (*isEnd)(const std::filesystem::path&) = nullptr);

/// Gives a new file the owner, where that is allowed, and the permissions of the one it will
/// replace. @return 0, or errno where the permissions could not be set
int takeOwnerAndMode(int number, const struct stat& replaced);

/// Brings a file to the disk. Some file systems cannot; that is no failure. @return 0 or errno
int flushFile(int number);

/// Brings the names in a file's directory to the disk; where that fails the data is there.
void flushDirectoryOf(const std::filesystem::path& path);

} // namespace altiro3D
