#pragma once

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// What the system does with files: the base for reading and writing whole files. Failures are
/// numbers of errno.
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
    int release() { return std::exchange(number_, -1); }

    int number_;
};

/// What a file is opened for.
enum class OpenFor {
    Reading,   ///< A file or a pipe.
    Writing,   ///< Something that exists, such as a device or a pipe; it is not emptied.
    Part,      ///< Reading and writing a file, which is created if it does not exist; never a link.
    Directory, ///< Locking a directory.
    Device     ///< Reading and writing a device; reading does not wait.
};

/// Opens a file. Retries after signals, except while it waits for the other end of a pipe.
/// @return if not open, errno is set
FileHandle openFile(const std::filesystem::path& path, OpenFor use);
/// Another descriptor of what an open one of this process names. @return if not open, errno is set
FileHandle duplicate(int number);
/// The standard input. @return if not open, errno is set
FileHandle standardInput();
/// A name that opens the standard input again. @return empty unless it is a file of which nothing
/// has been read
std::filesystem::path standardInputFile();
/// The number of the descriptor of this process that a path such as `/proc/self/fd/N` names.
std::optional<int> ownDescriptor(const std::filesystem::path& path);
/// A name that opens an open file again.
std::filesystem::path nameOf(const FileHandle& file);

/// What is known about a file. The other fields are valid if `error` is 0.
struct FileState {
    int error = ENOENT; ///< errno; 0: the file exists
    std::filesystem::file_type type = std::filesystem::file_type::none;
    std::uintmax_t size = 0;
    std::pair<std::uint64_t, std::uint64_t> id; ///< No two files have the same.
    unsigned owner = 0;
    unsigned group = 0;
    unsigned permissions = 0;

    bool exists() const { return error == 0; }
    bool isDirectory() const { return type == std::filesystem::file_type::directory; }
    bool isRegular() const { return type == std::filesystem::file_type::regular; }
};
/// The state of what a path names, after following links.
FileState stateOf(const std::filesystem::path& path);
FileState stateOf(const FileHandle& file);

/// What a number of errno means, for a sentence: "No space left on device".
std::string reasonOf(int number);
/// Why a file cannot have this name. @return "is ...", "has ..."; empty if it can
std::string nameProblem(const std::filesystem::path& path);
/// Whether this user may write a file. @return 0 or errno
int checkWritable(const std::filesystem::path& path);
/// Whether a file can be read only once, as a pipe can; a second read might wait forever.
bool givesBytesOnce(const std::filesystem::path& path);
/// The first bytes that wait in a pipe; they stay there. Empty if it is another file.
std::string waitingBytes(const FileHandle& pipe);

/// Reads or writes up to 1 GiB. If a pipe is non-blocking, waits until it is ready.
/// @return the number of bytes, or -1 with errno
std::ptrdiff_t readSome(const FileHandle& file, void* to, std::size_t size);
std::ptrdiff_t writeSome(const FileHandle& file, const void* from, std::size_t size);
/// The same at a position of a file. Thread-safe.
std::ptrdiff_t readAt(const FileHandle& file, void* to, std::size_t size, std::uint64_t begin);
std::ptrdiff_t writeAt(const FileHandle& file, const void* from, std::size_t size,
                       std::uint64_t begin);

/// Locks an open file or directory against other processes until it is closed.
/// @return false if another process holds the lock; true also where the file system has no locks
bool lockFile(const FileHandle& file);
/// Gives up the lock of a directory before the directory is removed, on systems that cannot remove
/// a locked one.
void unlockToRemove(FileHandle& lock);

/// A name beside a file: its own with an ending, or a number if that is too long.
std::filesystem::path besideName(const std::filesystem::path& path, const std::string& ending);

/// Copies the owner (if allowed) and the permissions of the replaced file to a new file. @return 0,
/// or errno if the permissions could not be set
int takeOwnerAndMode(const FileHandle& file, const FileState& replaced);

/// Flushes a file to the disk. A file system without it is not an error. @return 0 or errno
int flushFile(const FileHandle& file);

/// Flushes the directory of a file to the disk. Failures are ignored: the data is on the disk.
void flushDirectoryOf(const std::filesystem::path& path);

/// Renames a file or directory. A file replaces one of that name. @return 0 or errno; ENOTEMPTY or
/// EEXIST: a directory of that name is not empty
int moveFile(const std::filesystem::path& from, const std::filesystem::path& to);

/// The roots of the drives, as `D:\\`; empty where the system has one tree for all.
std::vector<std::filesystem::path> driveRoots();

/// Sets the time of a file or directory to now, by its file system. Failures are ignored.
void touch(const std::filesystem::path& path);

/// A temporary file in the directory of a file that it replaces. It has no name until moveTo(), so
/// a killed process leaves nothing behind. It is a hidden file where the file system does not
/// support unnamed files, or without /proc. The destructor removes it unless it was moved.
class TemporaryFile {
  public:
    /// If file() is not open afterwards, errno is set.
    explicit TemporaryFile(const std::filesystem::path& directory);
    ~TemporaryFile();
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    FileHandle& file() { return file_; }
    /// Closes the file and gives it its name, in the same directory. @return 0 or errno
    int moveTo(const std::filesystem::path& target);

  private:
    template <class Take>
    int tryNames(const Take& take);

    std::filesystem::path directory_;
    std::filesystem::path path_; // empty: no name
    FileHandle file_;
};

/// A file without a name, which is gone when it is closed.
/// @param directory where it takes its space @return if not open, errno is set
FileHandle unnamedFile(const std::filesystem::path& directory);

// The following functions are built on those above, alike for every system (file_io.cpp).

/// Throws WriteFailed with the system's message for an errno.
/// @param path the file as the user wrote it
[[noreturn]] void failWrite(const std::filesystem::path& path, int number);

/// Copies what is left of a pipe to an unnamed temporary file.
/// @param path for errors
/// @throws Error ReadFailed, WriteFailed, TooLarge
FileHandle unnamedCopy(const FileHandle& file, const std::filesystem::path& path,
                       std::uintmax_t maxBytes);

/// Follows the links of a path. The target need not exist.
/// @param isEnd if given, following stops at a path for which it returns true
/// @throws Error WriteFailed
std::filesystem::path followLinks(const std::filesystem::path& path,
                                  bool (*isEnd)(const std::filesystem::path&) = nullptr);

} // namespace altiro3D
