#include "media/part_file.hpp"

#include "altiro3D/error.hpp"

#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr int kBufferBytes = 1 << 18;

} // namespace

PartFile::PartFile(const fs::path& path) : path_(path), target_(followLinks(path)) {
    if (!target_.has_filename()) failWrite(path, EISDIR);
    struct stat state {};
    const bool exists = ::stat(target_.c_str(), &state) == 0;
    if (!exists && errno != ENOENT) failWrite(path, errno);
    if (exists && S_ISDIR(state.st_mode)) {
        throw Error(ErrorCode::WriteFailed, path.string(), "is a directory, expected a file name");
    }
    if (exists && !S_ISREG(state.st_mode)) {
        throw Error(ErrorCode::WriteFailed, path.string(),
                    "is a device or pipe, expected a file name: a video is written out of order");
    }
    // A writable directory would let the rename replace a write-protected file.
    if (exists && ::access(target_.c_str(), W_OK) != 0) failWrite(path, errno);

    part_ = target_;
    part_ += ".part";
    // A part left by a crash is overwritten; a part that is being written is locked.
    for (struct stat named{}, opened{};;) {
        file_ = openFile(part_, O_RDWR | O_CREAT | O_NOFOLLOW, 0666);
        if (!file_.isOpen()) failWrite(path, errno);
        if (!lockFile(file_)) {
            throw Error(ErrorCode::WriteFailed, path.string(),
                        "is being written by another process (" + part_.filename().string() + ")");
        }
        // Another writer may have renamed it between the two steps.
        if (::stat(part_.c_str(), &named) == 0 && ::fstat(file_.get(), &opened) == 0 &&
            named.st_ino == opened.st_ino && named.st_dev == opened.st_dev) {
            break;
        }
    }
    if (::ftruncate(file_.get(), 0) != 0) {
        const int error = errno;
        close();
        failWrite(path, error);
    }
    if (exists) {
        // If this is not allowed, the new file keeps the default permissions.
        [[maybe_unused]] const int ignored = takeOwnerAndMode(file_.get(), state);
    }
    auto* const buffer = static_cast<std::uint8_t*>(av_malloc(kBufferBytes));
    io_ = buffer != nullptr ? avio_alloc_context(buffer, kBufferBytes, 1, this, nullptr,
                                                 &PartFile::write, &PartFile::seek)
                            : nullptr;
    if (io_ == nullptr) {
        av_free(buffer);
        close();
        checkMemory(nullptr);
    } else {
        io_->min_packet_size =
            kBufferBytes; // else FFmpeg writes each packet, some 200 bytes of sound
    }
}

PartFile::~PartFile() {
    close();
}

void PartFile::close() {
    if (io_ != nullptr) {
        av_freep(&io_->buffer);
        avio_context_free(&io_);
    }
    if (!file_.isOpen()) return;
    ::unlink(part_.c_str());
    file_.close();
}

template <class Byte>
int PartFile::write(void* self, Byte* data, int size) {
    auto& file = *static_cast<PartFile*>(self);
    for (int done = 0; done < size;) {
        const ssize_t count =
            ::write(file.file_.get(), data + done, static_cast<std::size_t>(size - done));
        if (count > 0) {
            done += static_cast<int>(count);
        } else if (count == 0 || errno != EINTR) {
            const int error = count == 0 ? EIO : errno;
            if (file.error_ == 0) file.error_ = error;
            return AVERROR(error);
        }
    }
    return size;
}

std::int64_t PartFile::seek(void* self, std::int64_t offset, int whence) {
    auto& file = *static_cast<PartFile*>(self);
    if (whence == AVSEEK_SIZE) {
        struct stat state {};
        return ::fstat(file.file_.get(), &state) == 0 ? state.st_size : AVERROR(errno);
    }
    const off_t result = ::lseek(file.file_.get(), offset, whence & ~AVSEEK_FORCE);
    return result >= 0 ? result : AVERROR(errno);
}

void PartFile::check() const {
    if (error_ != 0) failWrite(path_, error_);
    if (io_->error < 0) {
        throw Error(ErrorCode::WriteFailed, path_.string(),
                    "cannot be written: " + ffmpegText(io_->error));
    }
}

void PartFile::finish() {
    avio_flush(io_);
    check();
    if (const int error = flushFile(file_.get())) failWrite(path_, error);
    // Closed only after the rename, because closing releases the lock against other writers.
    if (::rename(part_.c_str(), target_.c_str()) != 0) failWrite(path_, errno);
    flushDirectoryOf(target_);
    av_freep(&io_->buffer);
    avio_context_free(&io_);
    if (const int error = file_.close()) failWrite(path_, error);
}

} // namespace altiro3D
