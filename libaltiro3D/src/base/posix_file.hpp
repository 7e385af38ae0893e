#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <sys/stat.h>

/// File descriptors, the base for reading and writing whole files.
namespace altiro3D {

/// Owns a file descriptor and closes it in the destructor. Movable.
class FileHandle {
  public:
    /// @param number a descriptor to own; -1 = none
    explicit FileHandle(int number = -1) : number_(number) {}
    ~FileHandle() { close(); }
    FileHandle(FileHandle&& other) noexcept : number_(other.release()) {}
    FileHandle& operator=(FileHandle&& other) noexcept {
        if (this != &other) {
            close();
            number_ = other.release();
        }
        return *this;
    }
    FileHandle(const FileHandle&) = delete;
    FileHandle& operator=(const FileHandle&) = delete;

    int get() const { return number_; }
    bool isOpen() const { return number_ >= 0; }

    /// Closes the file. Network file systems may report a full disk only here. @return 0 or errno
    int close();

  private:
    int release() {
        const int number = number_;
        number_ = -1;
        return number;
    }

    int number_;
};

/// Throws WriteFailed with the system's message for an errno.
/// @param path the file as the user wrote it
[[noreturn]] void failWrite(const std::filesystem::path& path, int number);

/// Opens a file. Retries after signals, except while it waits for the writer of a pipe.
/// @return if not open, errno is set
FileHandle openFile(const std::filesystem::path& path, int flags, mode_t mode = 0);

/// Whether a file can be read only once, as a pipe can; a second read might wait forever.
bool givesBytesOnce(const std::filesystem::path& path);

/// Copies what is left of a pipe to an unnamed temporary file.
/// @param path for errors
/// @throws Error ReadFailed, WriteFailed, TooLarge
FileHandle unnamedCopy(const FileHandle& file, const std::filesystem::path& path,
                       std::uintmax_t maxBytes);
/// A name that opens an open file again.
std::filesystem::path nameOf(const FileHandle& file);

/// Locks an open file or directory against other processes until it is closed.
/// @return false if another process holds the lock; true also where the file system has no locks
bool lockFile(const FileHandle& file);

/// Follows the links of a path. The target need not exist.
/// @param isEnd if given, following stops at a path for which it returns true
/// @throws Error WriteFailed
std::filesystem::path followLinks(const std::filesystem::path& path,
                                  bool (*isEnd)(const std::filesystem::path&) = nullptr);

/// A name beside a file: its own with an ending, or a number if that is too long.
std::filesystem::path besideName(const std::filesystem::path& path, const std::string& ending);

/// Copies the owner (if allowed) and the permissions of the replaced file to a new file. @return 0,
/// or errno if the permissions could not be set
int takeOwnerAndMode(int number, const struct stat& replaced);

/// Flushes a file to the disk. A file system without it is not an error. @return 0 or errno
int flushFile(int number);

/// Flushes the directory of a file to the disk. Failures are ignored: the data is on the disk.
void flushDirectoryOf(const std::filesystem::path& path);

/// The prefix of an installation.
/// @param file absolute path of an installed file
/// @param place directory of that file below the prefix, for example `lib/x86_64-linux-gnu`
/// @return empty if the file is not in such a directory, or `place` is absolute
std::filesystem::path prefixOf(const std::filesystem::path& file,
                               const std::filesystem::path& place);

} // namespace altiro3D
