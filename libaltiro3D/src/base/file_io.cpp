#include "altiro3D/file_io.hpp"

#include "altiro3D/error.hpp"
#include "base/system_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <new>
#include <optional>
#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kReadStepBytes = std::size_t{1} << 20;

[[noreturn]] void failRead(const fs::path& path, int number) {
    if (number == EISDIR)
        throw Error(ErrorCode::ReadFailed, path.string(), "is a directory, expected a file");
    throw Error(ErrorCode::ReadFailed, path.string(), "cannot be read: " + reasonOf(number));
}

[[noreturn]] void failTooLarge(const fs::path& path, const std::string& length,
                               std::uintmax_t maxBytes) {
    throw Error(ErrorCode::TooLarge, path.string(),
                "holds " + length + " bytes, expected at most " + std::to_string(maxBytes));
}

// Writes all parts. Returns 0 or errno.
int writeAll(const FileHandle& file, const std::vector<Bytes>& parts) {
    for (const Bytes& part : parts) {
        const char* next = static_cast<const char*>(part.data);
        std::size_t left = part.size;
        while (left > 0) {
            const std::ptrdiff_t count = writeSome(file, next, left);
            if (count > 0) {
                next += count;
                left -= static_cast<std::size_t>(count);
            } else if (count == 0) {
                return EIO;
            } else if (errno != EINTR) {
                return errno;
            }
        }
    }
    return 0;
}

} // namespace

void failWrite(const fs::path& path, int number) {
    std::string problem = "cannot be written: " + reasonOf(number);
    if (number == ENOENT) problem += "; its directory must exist";
    throw Error(ErrorCode::WriteFailed, path.string(), problem);
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

std::string readFile(const fs::path& path, std::uintmax_t maxBytes) {
    if (path.empty()) throw Error(ErrorCode::NotFound, "path", "is empty, expected a file");
    const FileHandle file = openFile(path, OpenFor::Reading);
    if (!file.isOpen()) {
        if (errno == ENOENT || errno == ENOTDIR) {
            throw Error(ErrorCode::NotFound, path.string(), "does not exist, expected a file");
        }
        failRead(path, errno);
    }
    const FileState state = stateOf(file);
    if (!state.exists()) failRead(path, state.error);
    if (state.isDirectory()) failRead(path, EISDIR);
    const std::uintmax_t length = state.isRegular() ? state.size : 0;
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
            const std::ptrdiff_t count = readSome(file, to, full ? 1 : contents.size() - filled);
            if (count < 0) {
                if (errno != EINTR || !state.isRegular())
                    failRead(path, errno); // a signal ends waiting for a pipe
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
    FileState replaced; // if it exists
    std::uint64_t size = 0;

    FileHandle& file() { return temporary ? temporary->file() : inPlace; }
};

FileWriter::FileWriter(const fs::path& path) : impl_(std::make_unique<Impl>()) {
    Impl& self = *impl_;
    if (path.empty()) failWrite("(no name)", ENOENT);
    if (const std::string problem = nameProblem(path); !problem.empty())
        throw Error(ErrorCode::WriteFailed, path.string(), problem + ", expected another name");
    self.path = path;
    self.target =
        followLinks(path, [](const fs::path& at) { return ownDescriptor(at).has_value(); });
    const fs::path& target = self.target;
    if (const std::optional<int> own = ownDescriptor(target)) {
        // Reopening the name would lose the position in a file that is being appended to.
        self.inPlace = duplicate(*own);
        if (!self.inPlace.isOpen()) failWrite(path, errno);
        return;
    }

    self.replaced = stateOf(target);
    const FileState& state = self.replaced;
    if (!state.exists() && state.error != ENOENT) failWrite(path, state.error);
    if (state.exists() && state.isDirectory()) {
        throw Error(ErrorCode::WriteFailed, path.string(), "is a directory, expected a file name");
    }
    if (state.exists() && !state.isRegular()) {
        self.inPlace = openFile(target, OpenFor::Writing);
        if (!self.inPlace.isOpen()) failWrite(path, errno);
        return;
    }
    if (!target.has_filename()) failWrite(path, EISDIR);
    // A writable directory would let the rename replace a write-protected file.
    if (const int error = state.exists() ? checkWritable(target) : 0) failWrite(path, error);
    const fs::path parent = target.parent_path();
    self.temporary.emplace(parent.empty() ? fs::path(".") : parent);
    if (!self.file().isOpen()) failWrite(path, errno);
}

FileWriter::~FileWriter() = default;

void FileWriter::append(const std::vector<Bytes>& parts) {
    if (const int error = writeAll(impl_->file(), parts)) failWrite(impl_->path, error);
    for (const Bytes& part : parts)
        impl_->size += part.size;
}

std::uint64_t FileWriter::size() const {
    return impl_->size;
}

void FileWriter::replace(std::uint64_t at, Bytes bytes) {
    if (at > impl_->size || bytes.size > impl_->size - at)
        throw Error(ErrorCode::InvalidArgument, "place",
                    "is beyond what was appended, expected bytes of it");
    const std::ptrdiff_t written = writeAt(impl_->file(), bytes.data, bytes.size, at);
    if (written != static_cast<std::ptrdiff_t>(bytes.size))
        failWrite(impl_->path, written < 0 ? errno : EIO);
}

void FileWriter::finish() {
    Impl& self = *impl_;
    FileHandle& file = self.file();
    if (!self.temporary) {
        if (const int error = file.close()) failWrite(self.path, error);
        return;
    }
    if (self.replaced.exists()) {
        const int error = takeOwnerAndMode(file, self.replaced);
        if (error != 0 && error != EPERM) failWrite(self.path, error);
    }
    if (const int error = flushFile(file)) failWrite(self.path, error);
    if (const int error = self.temporary->moveTo(self.target)) failWrite(self.path, error);
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
    FileHandle copy = unnamedFile(directory);
    if (!copy.isOpen()) failWrite(directory, errno);
    std::string bytes(kReadStepBytes, '\0');
    std::uintmax_t size = 0;
    for (;;) {
        const std::ptrdiff_t count = readSome(file, bytes.data(), bytes.size());
        if (count < 0) failRead(path, errno);
        if (count == 0) return copy;
        size += static_cast<std::uintmax_t>(count);
        if (size > maxBytes) failTooLarge(path, "more", maxBytes);
        const Bytes part{bytes.data(), static_cast<std::size_t>(count)};
        if (const int failure = writeAll(copy, {part})) failWrite(directory, failure);
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

} // namespace altiro3D
