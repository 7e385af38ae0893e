#pragma once

#include "altiro3D/error.hpp"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <unistd.h>

/// Common code of the fuzz targets. Each target is one file with LLVMFuzzerTestOneInput(): it
/// passes foreign bytes to one reader of the library and aborts unless the reader returns a result
/// or throws an altiro3D::Error of one line.
namespace altiro3D::fuzz {

inline std::string_view textOf(const std::uint8_t* data, std::size_t size) {
    return {reinterpret_cast<const char*>(data), size};
}

/// Ends the process, so that the fuzzer keeps the input.
[[noreturn]] inline void fail(const char* what) {
    std::fprintf(stderr, "broken promise: %s\n", what);
    std::abort();
}

inline void require(bool condition, const char* promise) {
    if (!condition) fail(promise);
}

/// Calls a reader. An altiro3D::Error is accepted if it is one line. Any other exception ends the
/// process.
/// @return whether there was a result
template <class Call>
bool reads(const Call& call) {
    try {
        call();
        return true;
    } catch (const Error& error) {
        const std::string_view text = error.what();
        require(text.find(": ") != std::string_view::npos, "an error names what is to blame");
        require(text.find('\n') == std::string_view::npos, "an error is one line");
        return false;
    }
}

/// A directory in memory that is removed when the process ends normally.
class Directory {
  public:
    Directory() {
        std::string name = (std::filesystem::is_directory("/dev/shm") ? "/dev/shm" : "/tmp") +
                           std::string("/altiro3D-fuzz-XXXXXX");
        if (mkdtemp(name.data()) == nullptr) fail("a directory for inputs can be made");
        path_ = name;
    }
    ~Directory() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Directory(const Directory&) = delete;
    Directory& operator=(const Directory&) = delete;

    /// Writes a file, for readers that take no bytes.
    std::filesystem::path file(const std::string& name, std::string_view contents) const {
        std::filesystem::path path = path_ / name;
        std::ofstream(path, std::ios::binary | std::ios::trunc)
            .write(contents.data(), static_cast<std::streamsize>(contents.size()));
        return path;
    }
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// Takes numbers and texts from the front of the bytes; returns 0 and empty texts at their end.
class Bytes {
  public:
    Bytes(const std::uint8_t* data, std::size_t size) : rest_(textOf(data, size)) {}

    std::uint8_t byte() {
        if (rest_.empty()) return 0;
        const auto first = static_cast<std::uint8_t>(rest_.front());
        rest_.remove_prefix(1);
        return first;
    }
    /// Up to the next line break.
    std::string line() {
        const std::size_t end = std::min(rest_.find('\n'), rest_.size());
        std::string text(rest_.substr(0, end));
        rest_.remove_prefix(std::min(end + 1, rest_.size()));
        return text;
    }
    std::string_view rest() const { return rest_; }

  private:
    std::string_view rest_;
};

} // namespace altiro3D::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
