#include "base/posix_file.hpp"

#include "altiro3D/error.hpp"

#include <cerrno>
#include <fcntl.h>
#include <functional>
#include <string>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>

namespace altiro3D {

namespace fs = std::filesystem;

void failWrite(const fs::path& path, int number) {
    std::string problem = "cannot be written: " + std::generic_category().message(number);
    if (number == ENOENT) problem += "; its directory must exist";
    throw Error(ErrorCode::WriteFailed, path.string(), problem);
}

int FileHandle::close() {
    if (number_ < 0) return 0;
    // On Linux the descriptor is closed after EINTR; a second close could close another file.
    return ::close(release()) == 0 || errno == EINTR ? 0 : errno;
}

FileHandle openFile(const fs::path& path, int flags, mode_t mode) {
    int number = -1;
    do {
        number = ::open(path.c_str(), flags | O_CLOEXEC, mode);
    } while (number < 0 && errno == EINTR && !givesBytesOnce(path));
    return FileHandle(number);
}

bool givesBytesOnce(const fs::path& path) {
    const int number = errno; // callers still report it
    std::error_code error;
    const fs::file_type type = fs::status(path, error).type();
    errno = number;
    return type == fs::file_type::fifo || type == fs::file_type::character ||
           type == fs::file_type::socket;
}

fs::path nameOf(const FileHandle& file) {
    return "/proc/self/fd/" + std::to_string(file.get());
}

bool lockFile(const FileHandle& file) {
    return ::flock(file.get(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

fs::path followLinks(const fs::path& path, bool (*isEnd)(const fs::path&)) {
    fs::path current = path;
    constexpr int kMost = 40; // the kernel's limit
    for (int i = 0; i < kMost; ++i) {
        if (isEnd != nullptr && isEnd(current)) return current;
        std::error_code error;
        if (!fs::is_symlink(fs::symlink_status(current, error))) return current;
        const fs::path next = fs::read_symlink(current, error);
        if (error) failWrite(path, error.value());
        current = next.is_absolute() ? next : current.parent_path() / next;
    }
    failWrite(path, ELOOP);
}

fs::path besideName(const fs::path& path, const std::string& ending) {
    const fs::path parent = path.parent_path();
    const long limit = ::pathconf(parent.empty() ? "." : parent.c_str(), _PC_NAME_MAX);
    std::string name = path.filename().string();
    if (name.size() + ending.size() > static_cast<std::size_t>(limit > 0 ? limit : 255))
        name = ".altiro3D-" + std::to_string(std::hash<std::string>()(name));
    return parent / (name + ending);
}

int takeOwnerAndMode(int number, const struct stat& replaced) {
    // The owner changes only if root replaces another user's file; others cannot change it.
    struct stat made {};
    if (::fstat(number, &made) == 0 &&
        (made.st_uid != replaced.st_uid || made.st_gid != replaced.st_gid)) {
        [[maybe_unused]] const int ignored = ::fchown(number, replaced.st_uid, replaced.st_gid);
    }
    return ::fchmod(number, replaced.st_mode & 07777) == 0 ? 0 : errno;
}

int flushFile(int number) {
    while (::fsync(number) != 0) {
        if (errno == EINTR) continue;
        if (errno == EINVAL || errno == ENOTSUP || errno == ENOSYS || errno == EROFS) return 0;
        return errno;
    }
    return 0;
}

void flushDirectoryOf(const fs::path& path) {
    const fs::path parent = path.parent_path();
    const FileHandle directory =
        openFile(parent.empty() ? fs::path(".") : parent, O_RDONLY | O_DIRECTORY);
    if (directory.isOpen()) flushFile(directory.get());
}

} // namespace altiro3D
