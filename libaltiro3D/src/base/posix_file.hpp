#pragma once

#include <filesystem>
#include <sys/stat.h>

/// Files by their descriptors: what reading and writing of whole files is built on.
namespace altiro3D {

/// A file descriptor that is closed at the end. Movable.
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

    /// Closes now, as network file systems report a full disk only here. @return 0 or errno
    int close();

  private:
    int release() {
        const int number = number_;
        number_ = -1;
        return number;
    }

    int number_;
};

/// Throws WriteFailed with the system's words for an errno.
/// @param path the file as the user wrote it
[[noreturn]] void failWrite(const std::filesystem::path& path, int number);

/// Opens a file, also when signals interrupt. @return not open: errno tells why
FileHandle openFile(const std::filesystem::path& path, int flags, mode_t mode = 0);

/// Locks an open file or directory against other processes until it is closed.
/// @return false if another process holds the lock; true also where the file system has no locks
bool lockFile(const FileHandle& file);

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
