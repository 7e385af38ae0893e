#include "base/system_file.hpp"

#include "base/text.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <fcntl.h>
#include <functional>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 30; // of a call; Linux accepts 2 GiB

FileHandle openAs(const fs::path& path, int flags, mode_t mode = 0) {
    int number = -1;
    do {
        number = ::open(path.c_str(), flags | O_CLOEXEC, mode);
    } while (number < 0 && errno == EINTR && !givesBytesOnce(path));
    return FileHandle(number);
}

int flagsOf(OpenFor use) {
    switch (use) {
    case OpenFor::Writing:
        return O_WRONLY | O_NOCTTY;
    case OpenFor::Part:
        return O_RDWR | O_CREAT | O_NOFOLLOW;
    case OpenFor::Directory:
        return O_RDONLY | O_DIRECTORY;
    case OpenFor::Device:
        return O_RDWR | O_NONBLOCK;
    case OpenFor::Reading:
        break;
    }
    return O_RDONLY | O_NOCTTY;
}

FileState stateFrom(const struct stat& state) {
    const auto typeOf = [&] {
        if (S_ISREG(state.st_mode)) return fs::file_type::regular;
        return S_ISDIR(state.st_mode) ? fs::file_type::directory : fs::file_type::unknown;
    };
    return {0,
            typeOf(),
            static_cast<std::uintmax_t>(state.st_size),
            {state.st_dev, state.st_ino},
            state.st_uid,
            state.st_gid,
            state.st_mode & 07777U};
}

// Repeats a call until the descriptor is ready, which may be that of a non-blocking pipe.
template <class Call>
std::ptrdiff_t whenReady(const FileHandle& file, short event, const Call& call) {
    for (;;) {
        const std::ptrdiff_t count = call();
        if (count >= 0 || (errno != EAGAIN && errno != EWOULDBLOCK)) return count;
        pollfd waiting{file.get(), event, 0};
        ::poll(&waiting, 1, -1);
    }
}

} // namespace

int FileHandle::close() {
    if (number_ < 0) return 0;
    // On Linux the descriptor is closed after EINTR; a second close could close another file.
    return ::close(release()) == 0 || errno == EINTR ? 0 : errno;
}

FileHandle openFile(const fs::path& path, OpenFor use) {
    return openAs(path, flagsOf(use), 0666);
}

FileHandle duplicate(int number) {
    return FileHandle(::fcntl(number, F_DUPFD_CLOEXEC, 0));
}

FileHandle standardInput() {
    return duplicate(STDIN_FILENO);
}

fs::path standardInputFile() {
    std::error_code error;
    const fs::path name = "/dev/stdin";
    const bool isFile = fs::is_regular_file(name, error) && ::lseek(STDIN_FILENO, 0, SEEK_CUR) == 0;
    return isFile ? name : fs::path();
}

std::optional<int> ownDescriptor(const fs::path& path) {
    const std::string name = path.filename().string();
    if (name.empty() || name.size() > 6 || !std::all_of(name.begin(), name.end(), isDigit))
        return std::nullopt;
    std::error_code error;
    const fs::path directory = fs::canonical(path.parent_path(), error);
    const std::string self = "/proc/" + std::to_string(::getpid());
    if (error || (directory != self + "/fd" && directory.string().rfind(self + "/task/", 0) != 0)) {
        return std::nullopt;
    }
    return std::stoi(name);
}

fs::path nameOf(const FileHandle& file) {
    return "/proc/self/fd/" + std::to_string(file.get());
}

FileState stateOf(const fs::path& path) {
    struct stat state {};
    if (::stat(path.c_str(), &state) == 0) return stateFrom(state);
    FileState failed;
    failed.error = errno;
    return failed;
}

FileState stateOf(const FileHandle& file) {
    struct stat state {};
    if (::fstat(file.get(), &state) == 0) return stateFrom(state);
    FileState failed;
    failed.error = errno;
    return failed;
}

std::string reasonOf(int number) {
    return std::generic_category().message(number);
}

std::string nameProblem(const fs::path& path) {
    // the system refuses all else that it cannot have
    return path.native().find('\0') == std::string::npos ? "" : "holds a NUL byte";
}

int checkWritable(const fs::path& path) {
    return ::access(path.c_str(), W_OK) == 0 ? 0 : errno;
}

bool givesBytesOnce(const fs::path& path) {
    const int number = errno; // callers still report it
    std::error_code error;
    const fs::file_type type = fs::status(path, error).type();
    errno = number;
    return type == fs::file_type::fifo || type == fs::file_type::character ||
           type == fs::file_type::socket;
}

std::string waitingBytes(const FileHandle& pipe) {
    std::string bytes(std::size_t{1} << 16, '\0');
    int ends[2] = {-1, -1};
    if (::pipe2(ends, O_CLOEXEC) != 0) return {};
    const FileHandle from(ends[0]);
    const FileHandle to(ends[1]);
    ssize_t count = ::tee(pipe.get(), to.get(), bytes.size(), 0);
    if (count > 0) count = ::read(from.get(), bytes.data(), bytes.size());
    bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    return bytes;
}

std::ptrdiff_t readSome(const FileHandle& file, void* to, std::size_t size) {
    return whenReady(file, POLLIN,
                     [&] { return ::read(file.get(), to, std::min(size, kMostBytes)); });
}

std::ptrdiff_t writeSome(const FileHandle& file, const void* from, std::size_t size) {
    return whenReady(file, POLLOUT,
                     [&] { return ::write(file.get(), from, std::min(size, kMostBytes)); });
}

std::ptrdiff_t readAt(const FileHandle& file, void* to, std::size_t size, std::uint64_t begin) {
    return ::pread(file.get(), to, size, static_cast<off_t>(begin));
}

std::ptrdiff_t writeAt(const FileHandle& file, const void* from, std::size_t size,
                       std::uint64_t begin) {
    return ::pwrite(file.get(), from, size, static_cast<off_t>(begin));
}

bool lockFile(const FileHandle& file) {
    return ::flock(file.get(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

void unlockToRemove(FileHandle& /*lock*/) {}

fs::path besideName(const fs::path& path, const std::string& ending) {
    const fs::path parent = path.parent_path();
    const long limit = ::pathconf(parent.empty() ? "." : parent.c_str(), _PC_NAME_MAX);
    std::string name = path.filename().string();
    if (name.size() + ending.size() > static_cast<std::size_t>(limit > 0 ? limit : 255))
        name = ".altiro3D-" + std::to_string(std::hash<std::string>()(name));
    return parent / (name + ending);
}

int takeOwnerAndMode(const FileHandle& file, const FileState& replaced) {
    // The owner changes only if root replaces another user's file; others cannot change it.
    const FileState made = stateOf(file);
    if (made.exists() && (made.owner != replaced.owner || made.group != replaced.group)) {
        [[maybe_unused]] const int ignored = ::fchown(file.get(), replaced.owner, replaced.group);
    }
    return ::fchmod(file.get(), replaced.permissions) == 0 ? 0 : errno;
}

int flushFile(const FileHandle& file) {
    while (::fsync(file.get()) != 0) {
        if (errno == EINTR) continue;
        if (errno == EINVAL || errno == ENOTSUP || errno == ENOSYS || errno == EROFS) return 0;
        return errno;
    }
    return 0;
}

void flushDirectoryOf(const fs::path& path) {
    const fs::path parent = path.parent_path();
    const FileHandle directory =
        openFile(parent.empty() ? fs::path(".") : parent, OpenFor::Directory);
    if (directory.isOpen()) flushFile(directory);
}

void touch(const fs::path& path) {
    ::utimensat(AT_FDCWD, path.c_str(), nullptr, 0);
}

int moveFile(const fs::path& from, const fs::path& to) {
    return ::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

std::vector<fs::path> driveRoots() {
    return {};
}

TemporaryFile::TemporaryFile(const fs::path& directory) : directory_(directory) {
    if (::access("/proc/self/fd", X_OK) == 0) file_ = openAs(directory, O_WRONLY | O_TMPFILE, 0666);
    if (file_.isOpen()) return;
    tryNames([this] {
        file_ = openAs(path_, O_WRONLY | O_CREAT | O_EXCL, 0666);
        return file_.isOpen();
    });
}

TemporaryFile::~TemporaryFile() {
    if (!path_.empty()) ::unlink(path_.c_str());
}

int TemporaryFile::moveTo(const fs::path& target) {
    if (path_.empty()) {
        const fs::path self = nameOf(file_);
        const int error = tryNames([&] {
            return ::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, path_.c_str(), AT_SYMLINK_FOLLOW) ==
                   0;
        });
        if (error != 0) return error;
    }
    if (const int error = file_.close()) return error;
    if (const int error = moveFile(path_, target)) return error;
    path_.clear();
    return 0;
}

// Calls `take` with new names until it succeeds. Returns 0 or errno.
template <class Take>
int TemporaryFile::tryNames(const Take& take) {
    static std::atomic<unsigned> counter{0};
    for (int attempt = 0; attempt < 1000; ++attempt) {
        path_ = directory_ / (".altiro3D-" + std::to_string(::getpid()) + "-" +
                              std::to_string(counter++) + ".tmp");
        if (take()) return 0;
        if (errno != EEXIST) break;
    }
    path_.clear(); // the name belongs to another file
    return errno;
}

FileHandle unnamedFile(const fs::path& directory) {
    return openAs(directory, O_RDWR | O_TMPFILE, 0600);
}

} // namespace altiro3D
