#pragma once

#include "altiro3D/export.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace altiro3D {

/// A non-owning range of bytes.
struct Bytes {
    const void* data = nullptr; ///< First byte; may be null when `size` is 0.
    std::size_t size = 0;       ///< Number of bytes.
};

/// Reads a whole regular file (or a pipe) into memory.
/// @param path the file
/// @param maxBytes limit: a longer file is refused before it is read, a pipe when it delivers more
/// @return the contents
/// @throws Error NotFound, ReadFailed (a directory, no permission), TooLarge or OutOfMemory
[[nodiscard]] ALTIRO3D_EXPORT std::string readFile(const std::filesystem::path& path,
                                                   std::uintmax_t maxBytes);

/// Writes a file atomically: the name holds either its old contents or all of the new ones.
///
/// The bytes are written to a temporary file next to the target, hidden or still without a name,
/// and flushed to the disk; the file is then renamed to the target. Symbolic links are followed. A
/// target that exists and is not a regular file (`/dev/stdout`, a pipe) is written in place. On
/// failure the temporary file is removed and the target is unchanged.
/// @param path the file; its directory must exist
/// @param parts the contents, written one after the other
/// @throws Error WriteFailed (no permission, a directory, a full disk, ...)
ALTIRO3D_EXPORT void writeFile(const std::filesystem::path& path, const std::vector<Bytes>& parts);

/// @overload
/// @param path the file; its directory must exist
/// @param text the contents
/// @throws Error WriteFailed
ALTIRO3D_EXPORT void writeFile(const std::filesystem::path& path, const std::string& text);

/// Normalizes a file name for comparisons in which neither the case of A..Z nor the encoding of
/// letters with marks matters: A..Z become a..z, and a letter and its mark, as a Mac writes them
/// (NFD), become one code point (NFC) if Latin, Greek, Cyrillic, Japanese or Korean has one. If
/// several names are comparable to a given name, prefer the one that equals it byte for byte.
/// @param name a file name, UTF-8; other bytes are only equal to themselves
/// @return code points; equal for names that are comparable
[[nodiscard]] ALTIRO3D_EXPORT std::u32string comparableName(const std::string& name);

/// Quotes a text for a POSIX shell, for example a file name in a command that a message advises.
/// @param text any text
/// @return the text, in single quotes if it needs them
[[nodiscard]] ALTIRO3D_EXPORT std::string shellWord(const std::string& text);

/// writeFile() piece by piece: the name has its old contents until finish(). One thread at a time.
class ALTIRO3D_EXPORT FileWriter {
  public:
    /// Creates the temporary file, or opens a target that is written in place.
    /// @param path the file; its directory must exist
    /// @throws Error WriteFailed
    explicit FileWriter(const std::filesystem::path& path);
    ~FileWriter();
    FileWriter(const FileWriter&) = delete;
    FileWriter& operator=(const FileWriter&) = delete;

    /// Appends bytes.
    /// @param parts the contents, written one after the other
    /// @throws Error WriteFailed
    void append(const std::vector<Bytes>& parts);
    /// Size of what was appended. @return number of bytes
    [[nodiscard]] std::uint64_t size() const;
    /// Overwrites bytes that were appended.
    /// @param at offset of the first one
    /// @param bytes the new contents
    /// @throws Error InvalidArgument (beyond size()), WriteFailed, also for a pipe
    void replace(std::uint64_t at, Bytes bytes);
    /// Completes the file and gives it its name; call it once. @throws Error WriteFailed
    void finish();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// A file's size and modification time as text, to detect changes.
/// @param path the file; it is not opened
/// @return the text; empty if there is no such file
[[nodiscard]] ALTIRO3D_EXPORT std::string fileStamp(const std::filesystem::path& path);

/// The name of this machine. @return the name, or "unknown"
[[nodiscard]] ALTIRO3D_EXPORT std::string hostName();

/// Directories that are searched for files (`models/`, `calibration/`), in this order:
/// - `share/altiro3D` of the installation that contains this library or program, even if the
///   installation was moved as a whole;
/// - the source tree, if the build enables it;
/// - `share/altiro3D` of the prefix that the build was configured for.
///
/// Directories that do not exist are skipped.
/// @return the directories in search order
[[nodiscard]] ALTIRO3D_EXPORT std::vector<std::filesystem::path> dataDirectories();

} // namespace altiro3D
