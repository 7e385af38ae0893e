#pragma once

#include "altiro3D/export.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace altiro3D {

/// A run of bytes that somebody else owns.
struct Bytes {
    const void* data = nullptr; ///< First byte; may be null when `size` is 0.
    std::size_t size = 0;       ///< Number of bytes.
};

/// Reads a whole regular file (or a pipe) into memory.
///
/// @param path the file
/// @param maxBytes files longer than this are refused before they are read, a pipe when it gives
///        more
/// @return the contents
/// @throws Error NotFound, ReadFailed (a directory, no permission), TooLarge or OutOfMemory
ALTIRO3D_EXPORT std::string readFile(const std::filesystem::path& path, std::uintmax_t maxBytes);

/// Writes a file so that the name holds either its old contents or all of the new ones.
///
/// The bytes go to a hidden file beside the target, are flushed to the disk and renamed onto it.
/// Symbolic links are followed. A target that exists and is no regular file (`/dev/stdout`, a
/// pipe) is written in place. On failure the temporary file is removed and the target is as it was.
///
/// @param path the file; its directory must exist
/// @param parts the contents, one run after the other
/// @throws Error WriteFailed (no permission, a directory, a full disk, ...)
ALTIRO3D_EXPORT void writeFile(const std::filesystem::path& path, const std::vector<Bytes>& parts);

/// @overload
/// @param path the file; its directory must exist
/// @param text the contents
/// @throws Error WriteFailed
ALTIRO3D_EXPORT void writeFile(const std::filesystem::path& path, const std::string& text);

} // namespace altiro3D
