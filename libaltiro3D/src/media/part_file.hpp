#pragma once

#include "base/posix_file.hpp"
#include "media/ffmpeg.hpp"

#include <filesystem>

namespace altiro3D {

/// A file that FFmpeg writes as `<name>.part` beside its target and that is renamed to it at the
/// end. Not movable, because FFmpeg keeps its address.
class PartFile {
  public:
    /// @throws Error WriteFailed (a directory, not a regular file, no permission, another writer)
    explicit PartFile(const std::filesystem::path& path);
    /// Removes the part unless it was finished.
    ~PartFile();
    PartFile(const PartFile&) = delete;
    PartFile& operator=(const PartFile&) = delete;

    AVIOContext* io() { return io_; }
    const std::filesystem::path& partPath() const { return part_; }

    /// Throws the error of the first failed write, if any. @throws Error WriteFailed
    void check() const;
    /// Flushes to the disk and renames. @throws Error WriteFailed
    void finish();

  private:
    template <class Byte> // const from FFmpeg 7 on
    static int write(void* self, Byte* data, int size);
    static std::int64_t seek(void* self, std::int64_t offset, int whence);
    void close();

    std::filesystem::path path_;   // as given, for errors
    std::filesystem::path target_; // without links
    std::filesystem::path part_;
    FileHandle file_;
    int error_ = 0; // errno of the first failure
    AVIOContext* io_ = nullptr;
};

} // namespace altiro3D
