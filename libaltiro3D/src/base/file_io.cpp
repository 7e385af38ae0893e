#include "altiro3D/file_io.hpp"

#include "altiro3D/error.hpp"
#include "base/posix_file.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <fcntl.h>
#include <new>
#include <optional>
#include <poll.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kReadStepBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxCallBytes = std::size_t{1} << 30; // Linux accepts 2 GiB at most

std::string reason(int number) {
    return std::generic_category().message(number);
}

// After EAGAIN (a non-blocking pipe): waits until the descriptor is ready.
void waitFor(int number, short events) {
    pollfd waiting{number, events, 0};
    ::poll(&waiting, 1, -1);
}

[[noreturn]] void failRead(const fs::path& path, int number) {
    throw Error(ErrorCode::ReadFailed, path.string(), "cannot be read: " + reason(number));
}

[[noreturn]] void failTooLarge(const fs::path& path, const std::string& length,
                               std::uintmax_t maxBytes) {
    throw Error(ErrorCode::TooLarge, path.string(),
                "holds " + length + " bytes, expected at most " + std::to_string(maxBytes));
}

// Writes all parts. Returns 0 or errno.
int writeAll(int number, const std::vector<Bytes>& parts) {
    for (const Bytes& part : parts) {
        const char* next = static_cast<const char*>(part.data);
        std::size_t left = part.size;
        while (left > 0) {
            const ssize_t count = ::write(number, next, std::min(left, kMaxCallBytes));
            if (count > 0) {
                next += count;
                left -= static_cast<std::size_t>(count);
            } else if (count == 0) {
                return EIO;
            } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
                waitFor(number, POLLOUT);
            } else if (errno != EINTR) {
                return errno;
            }
        }
    }
    return 0;
}

// The number of the descriptor of this process that a path such as `/proc/self/fd/N` names.
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

// A temporary file beside the target, which is then renamed to it. It has no name until name(), so
// a killed process leaves nothing behind. It is a hidden file if the file system does not support
// unnamed files, or without /proc. The destructor removes it unless it was renamed.
class TemporaryFile {
  public:
    explicit TemporaryFile(const fs::path& directory) : directory_(directory) {
        if (::access("/proc/self/fd", X_OK) == 0) {
            file_ = openFile(directory, O_WRONLY | O_TMPFILE, 0666);
        }
        if (file_.isOpen()) return;
        tryNames([this] {
            file_ = openFile(path_, O_WRONLY | O_CREAT | O_EXCL, 0666);
            return file_.isOpen();
        });
    }
    ~TemporaryFile() {
        if (!path_.empty()) ::unlink(path_.c_str());
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    FileHandle& file() { return file_; }
    const fs::path& path() const { return path_; }
    // Gives the open file a name. Returns 0 or errno.
    int name() {
        if (!path_.empty()) return 0;
        const std::string self = "/proc/self/fd/" + std::to_string(file_.get());
        return tryNames([&] {
            return ::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, path_.c_str(), AT_SYMLINK_FOLLOW) ==
                   0;
        });
    }
    void renamed() { path_.clear(); }

  private:
    // Calls `take` with new names until it succeeds. Returns 0 or errno.
    template <class Take>
    int tryNames(const Take& take) {
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

    fs::path directory_;
    fs::path path_; // empty: no name
    FileHandle file_;
};

} // namespace

std::string readFile(const fs::path& path, std::uintmax_t maxBytes) {
    if (path.empty()) throw Error(ErrorCode::NotFound, "path", "is empty, expected a file");
    const FileHandle file = openFile(path, O_RDONLY | O_NOCTTY);
    if (!file.isOpen()) {
        if (errno == ENOENT || errno == ENOTDIR) {
            throw Error(ErrorCode::NotFound, path.string(), "does not exist, expected a file");
        }
        failRead(path, errno);
    }
    struct stat state {};
    if (::fstat(file.get(), &state) != 0) failRead(path, errno);
    if (S_ISDIR(state.st_mode)) {
        throw Error(ErrorCode::ReadFailed, path.string(), "is a directory, expected a file");
    }
    std::uintmax_t length = 0;
    if (S_ISREG(state.st_mode)) length = static_cast<std::uintmax_t>(state.st_size);
    if (length > maxBytes) failTooLarge(path, std::to_string(length), maxBytes);

    try {
        std::string contents;
        contents.resize(static_cast<std::size_t>(length));
        std::size_t filled = 0;
        for (;;) {
            // One byte past the expected end shows whether the file has grown.
            char extra = 0;
            const bool full = filled == contents.size();
            char* const to = full ? &extra : contents.data() + filled;
            const std::size_t room = full ? 1 : std::min(contents.size() - filled, kMaxCallBytes);
            const ssize_t count = ::read(file.get(), to, room);
            if (count < 0) {
                if (errno == EAGAIN || errno == EWOULDBLOCK) {
                    waitFor(file.get(), POLLIN);
                } else if (errno != EINTR || !S_ISREG(state.st_mode)) {
                    failRead(path, errno); // a signal ends waiting for a pipe
                }
                continue;
            }
            if (count == 0) break;
            if (full) {
                if (filled >= maxBytes) failTooLarge(path, "more", maxBytes);
                const std::uintmax_t step = std::max<std::uintmax_t>(kReadStepBytes, filled / 2);
                contents.resize(
                    static_cast<std::size_t>(std::min<std::uintmax_t>(maxBytes, filled + step)));
                contents[filled] = extra;
            }
            filled += static_cast<std::size_t>(count);
        }
        contents.resize(filled);
        return contents;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::OutOfMemory, path.string(),
                    "does not fit into memory, expected a smaller file");
    }
}

struct FileWriter::Impl {
    fs::path path;                          // as the user wrote it
    fs::path target;                        // after following its links
    std::optional<TemporaryFile> temporary; // none: the target is written in place
    FileHandle inPlace;
    std::optional<struct stat> replaced;
    std::uint64_t size = 0;

    FileHandle& file() { return temporary ? temporary->file() : inPlace; }
};

FileWriter::FileWriter(const fs::path& path) : impl_(std::make_unique<Impl>()) {
    Impl& self = *impl_;
    if (path.empty()) failWrite("(no name)", ENOENT);
    self.path = path;
    self.target =
        followLinks(path, [](const fs::path& at) { return ownDescriptor(at).has_value(); });
    const fs::path& target = self.target;
    if (const std::optional<int> own = ownDescriptor(target)) {
        // Reopening the name would lose the position in a file that is being appended to.
        self.inPlace = FileHandle(::fcntl(*own, F_DUPFD_CLOEXEC, 0));
        if (!self.inPlace.isOpen()) failWrite(path, errno);
        return;
    }

    struct stat state {};
    const bool exists = ::stat(target.c_str(), &state) == 0;
    if (!exists && errno != ENOENT) failWrite(path, errno);
    if (exists && S_ISDIR(state.st_mode)) {
        throw Error(ErrorCode::WriteFailed, path.string(), "is a directory, expected a file name");
    }
    if (exists && !S_ISREG(state.st_mode)) {
        self.inPlace = openFile(target, O_WRONLY | O_NOCTTY);
        if (!self.inPlace.isOpen()) failWrite(path, errno);
        return;
    }
    if (!target.has_filename()) failWrite(path, EISDIR);
    // A writable directory would let the rename replace a write-protected file.
    if (exists && ::access(target.c_str(), W_OK) != 0) failWrite(path, errno);
    if (exists) self.replaced = state;
    const fs::path parent = target.parent_path();
    self.temporary.emplace(parent.empty() ? fs::path(".") : parent);
    if (!self.file().isOpen()) failWrite(path, errno);
}

FileWriter::~FileWriter() = default;

void FileWriter::append(const std::vector<Bytes>& parts) {
    if (const int error = writeAll(impl_->file().get(), parts)) failWrite(impl_->path, error);
    for (const Bytes& part : parts)
        impl_->size += part.size;
}

std::uint64_t FileWriter::size() const {
    return impl_->size;
}

void FileWriter::replace(std::uint64_t at, Bytes bytes) {
    const int file = impl_->file().get();
    const auto written = ::pwrite(file, bytes.data, bytes.size, static_cast<off_t>(at));
    if (written != static_cast<ssize_t>(bytes.size))
        failWrite(impl_->path, written < 0 ? errno : EIO);
}

void FileWriter::finish() {
    Impl& self = *impl_;
    FileHandle& file = self.file();
    if (!self.temporary) {
        if (const int error = file.close()) failWrite(self.path, error);
        return;
    }
    if (self.replaced) {
        const int error = takeOwnerAndMode(file.get(), *self.replaced);
        if (error != 0 && error != EPERM) failWrite(self.path, error);
    }
    if (const int error = flushFile(file.get())) failWrite(self.path, error);
    if (const int error = self.temporary->name()) failWrite(self.path, error);
    if (const int error = file.close()) failWrite(self.path, error);
    if (::rename(self.temporary->path().c_str(), self.target.c_str()) != 0)
        failWrite(self.path, errno);
    self.temporary->renamed();
    flushDirectoryOf(self.target);
}

void writeFile(const fs::path& path, const std::vector<Bytes>& parts) {
    FileWriter file(path);
    file.append(parts);
    file.finish();
}

void writeFile(const fs::path& path, const std::string& text) {
    writeFile(path, std::vector<Bytes>{{text.data(), text.size()}});
}

FileHandle unnamedCopy(const FileHandle& file, const fs::path& path, std::uintmax_t maxBytes) {
    std::error_code error;
    const fs::path directory = fs::temp_directory_path(error);
    FileHandle copy = openFile(directory, O_RDWR | O_TMPFILE, 0600);
    if (!copy.isOpen()) failWrite(directory, errno);
    std::string bytes(kReadStepBytes, '\0');
    std::uintmax_t size = 0;
    for (;;) {
        const ssize_t count = ::read(file.get(), bytes.data(), bytes.size());
        if (count < 0 && errno == EAGAIN) {
            waitFor(file.get(), POLLIN);
            continue;
        }
        if (count < 0) failRead(path, errno);
        if (count == 0) return copy;
        size += static_cast<std::uintmax_t>(count);
        if (size > maxBytes) failTooLarge(path, "more", maxBytes);
        const Bytes part{bytes.data(), static_cast<std::size_t>(count)};
        if (const int failure = writeAll(copy.get(), {part})) failWrite(directory, failure);
    }
}

std::string fileStamp(const fs::path& path) {
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(path, error);
    if (error) return {};
    const auto time = // 128 bits in some libraries
        static_cast<std::int64_t>(fs::last_write_time(path, error).time_since_epoch().count());
    return error ? std::string() : std::to_string(bytes) + " bytes of " + std::to_string(time);
}

std::string hostName() {
    std::array<char, 256> name{};
    if (gethostname(name.data(), name.size() - 1) != 0) return "unknown";
    return name.data();
}

} // namespace altiro3D
