#include "base/system_file.hpp"
#include "base/system_windows.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <fcntl.h>
#include <functional>
#include <io.h>
#include <map>
#include <mutex>
#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 30;
constexpr DWORD kShare = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE; // as on POSIX
constexpr std::uint64_t kLockedByte = std::uint64_t{1} << 62; // behind all data: a lock keeps
                                                              // others from reading what it covers

// Files that are removed when they are closed. Windows could do it, but then FFmpeg, which allows
// nobody to remove what it reads, cannot open them by their names.
struct Passing {
    std::mutex mutex;
    std::map<int, fs::path> files;
} passing;

HANDLE handleOf(const FileHandle& file) {
    return reinterpret_cast<HANDLE>(::_get_osfhandle(file.get()));
}

OVERLAPPED placeAt(std::uint64_t begin) {
    OVERLAPPED place{};
    place.Offset = static_cast<DWORD>(begin);
    place.OffsetHigh = static_cast<DWORD>(begin >> 32);
    return place;
}

FileHandle openAs(const fs::path& path, DWORD access, DWORD disposition, DWORD attributes) {
    if (!nameProblem(path).empty()) { // a device would be opened
        errno = ENOENT;
        return FileHandle();
    }
    const HANDLE handle = ::CreateFileW(longName(path).c_str(), access, kShare, nullptr,
                                        disposition, attributes, nullptr);
    if (handle == INVALID_HANDLE_VALUE) {
        errno = lastErrno();
        if (errno == EACCES && fs::is_directory(path)) errno = EISDIR;
        return FileHandle();
    }
    const int number =
        ::_open_osfhandle(reinterpret_cast<std::intptr_t>(handle), _O_BINARY | _O_NOINHERIT);
    if (number < 0) ::CloseHandle(handle);
    return FileHandle(number);
}

FileState failedState(int error) {
    FileState failed;
    failed.error = error;
    return failed;
}

FileState stateOf(HANDLE handle) {
    if (::GetFileType(handle) != FILE_TYPE_DISK) {
        FileState state;
        state.error = 0;
        state.type = fs::file_type::unknown;
        return state;
    }
    BY_HANDLE_FILE_INFORMATION facts{};
    if (::GetFileInformationByHandle(handle, &facts) == 0) return failedState(lastErrno());
    const bool isDirectory = (facts.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) != 0;
    FileState state;
    state.error = 0;
    state.type = isDirectory ? fs::file_type::directory : fs::file_type::regular;
    state.size = std::uint64_t{facts.nFileSizeHigh} << 32 | facts.nFileSizeLow;
    state.id = {facts.dwVolumeSerialNumber,
                std::uint64_t{facts.nFileIndexHigh} << 32 | facts.nFileIndexLow};
    return state;
}

FileHandle newFile(const fs::path& path) {
    return openAs(path, GENERIC_READ | GENERIC_WRITE, CREATE_NEW,
                  FILE_ATTRIBUTE_NORMAL | FILE_ATTRIBUTE_HIDDEN);
}

fs::path temporaryName(const fs::path& directory) {
    static std::atomic<unsigned> counter{0};
    return directory / (".altiro3D-" + std::to_string(::GetCurrentProcessId()) + "-" +
                        std::to_string(counter++) + ".tmp");
}

int removeFile(const fs::path& path) {
    return ::DeleteFileW(longName(path).c_str()) != 0 ? 0 : lastErrno();
}

} // namespace

int lastErrno() {
    switch (const DWORD error = ::GetLastError()) {
    case ERROR_SHARING_VIOLATION:
    case ERROR_LOCK_VIOLATION:
        return EBUSY;
    case ERROR_INVALID_NAME:
    case ERROR_BAD_PATHNAME:
    case ERROR_BAD_NETPATH:
    case ERROR_NOT_READY:
        return ENOENT;
    case ERROR_DISK_FULL:
    case ERROR_HANDLE_DISK_FULL:
        return ENOSPC;
    case ERROR_WRITE_PROTECT:
        return EROFS;
    case ERROR_NO_DATA:
        return EPIPE;
    default: {
        const std::error_condition condition =
            std::system_category().default_error_condition(static_cast<int>(error));
        return condition.category() == std::generic_category() ? condition.value() : EIO;
    }
    }
}

// Windows allows more than 259 characters where the name is absolute and says so.
std::wstring longName(const fs::path& path) {
    constexpr std::size_t kMostShort = 240;
    const std::wstring& name = path.native();
    if (name.size() < kMostShort || name.rfind(LR"(\\?\)", 0) == 0) return name;
    std::error_code error;
    const std::wstring whole =
        fs::absolute(path, error).lexically_normal().make_preferred().native();
    if (error) return name;
    return whole.rfind(LR"(\\)", 0) == 0 ? LR"(\\?\UNC\)" + whole.substr(2) : LR"(\\?\)" + whole;
}

std::string reasonOf(int number) {
    if (number == EBUSY) return "another program has it open";
    return std::generic_category().message(number);
}

int FileHandle::close() {
    if (number_ < 0) return 0;
    fs::path removed;
    {
        const std::lock_guard<std::mutex> lock(passing.mutex);
        const auto found = passing.files.find(number_);
        if (found != passing.files.end()) {
            removed = found->second;
            passing.files.erase(found);
        }
    }
    const int error = ::_close(release()) == 0 ? 0 : errno;
    if (!removed.empty()) removeFile(removed);
    return error;
}

FileHandle openFile(const fs::path& path, OpenFor use) {
    switch (use) {
    case OpenFor::Writing:
        return openAs(path, GENERIC_WRITE, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL);
    case OpenFor::Part:
        return openAs(path, GENERIC_READ | GENERIC_WRITE, OPEN_ALWAYS, FILE_ATTRIBUTE_NORMAL);
    case OpenFor::Directory: // cannot be locked: locks a file in it, deleted on closing
        return openAs(path / ".lock", GENERIC_READ | GENERIC_WRITE | DELETE, OPEN_ALWAYS,
                      FILE_ATTRIBUTE_HIDDEN | FILE_FLAG_DELETE_ON_CLOSE);
    case OpenFor::Device:
        return openAs(path, GENERIC_READ | GENERIC_WRITE, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL);
    case OpenFor::Reading:
        break;
    }
    return openAs(path, GENERIC_READ, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL);
}

FileHandle duplicate(int number) {
    return FileHandle(::_dup(number));
}

FileHandle standardInput() {
    return duplicate(0);
}

fs::path standardInputFile() {
    const FileHandle file = standardInput();
    if (!file.isOpen() || !stateOf(file).isRegular() || ::_lseeki64(file.get(), 0, SEEK_CUR) != 0)
        return {};
    return nameOf(file);
}

std::optional<int> ownDescriptor(const fs::path& /*path*/) {
    return std::nullopt; // they have no names here
}

fs::path nameOf(const FileHandle& file) {
    std::wstring name(std::size_t{1} << 15, L'\0');
    name.resize(::GetFinalPathNameByHandleW(handleOf(file), name.data(),
                                            static_cast<DWORD>(name.size()), 0));
    constexpr std::size_t kDrive = 7; // \\?\C:\ ...
    if (name.size() > kDrive && name[5] == L':' && name.size() < MAX_PATH) name.erase(0, 4);
    return name;
}

FileState stateOf(const fs::path& path) {
    if (!nameProblem(path).empty()) return failedState(ENOENT);
    const HANDLE handle = ::CreateFileW(longName(path).c_str(), 0, kShare, nullptr, OPEN_EXISTING,
                                        FILE_FLAG_BACKUP_SEMANTICS, nullptr);
    if (handle == INVALID_HANDLE_VALUE) return failedState(lastErrno());
    FileState state = stateOf(handle);
    ::CloseHandle(handle);
    return state;
}

FileState stateOf(const FileHandle& file) {
    return file.isOpen() ? stateOf(handleOf(file)) : failedState(EBADF);
}

int checkWritable(const fs::path& path) {
    const FileHandle file = openAs(path, GENERIC_WRITE, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL);
    return file.isOpen() ? 0 : errno;
}

std::string nameProblem(const fs::path& path) {
    if (path.native().find(L'\0') != std::wstring::npos) return "holds a NUL byte";
    const std::string name = path.filename().string();
    const std::string stem = lowerCase(name.substr(0, name.find_first_of(".:")));
    constexpr std::array kDevices = {"con", "prn", "aux", "conin$", "conout$"};
    const bool isPort = stem.size() == 4 && (startsWith(stem, "com") || startsWith(stem, "lpt")) &&
                        stem[3] >= '1' && stem[3] <= '9';
    const bool isNull = stem == "nul" && name.size() > 3;
    if (isPort || isNull || std::find(kDevices.begin(), kDevices.end(), stem) != kDevices.end())
        return "is a name that Windows keeps for a device";
    const auto wrong = name.find_first_of("<>:\"|?*");
    if (wrong != std::string::npos)
        return std::string("has a ") + name[wrong] + " in its name, which Windows does not allow";
    if (name.size() > 2 && (name.back() == '.' || name.back() == ' '))
        return "ends in a point or a blank, which Windows takes away";
    return {};
}

bool givesBytesOnce(const fs::path& path) {
    const int number = errno; // callers still report it
    const FileState state = stateOf(path);
    errno = number;
    return state.exists() && state.type == fs::file_type::unknown;
}

std::string waitingBytes(const FileHandle& pipe) {
    std::string bytes(std::size_t{1} << 16, '\0');
    DWORD count = 0;
    // waits for the first byte, as the reading end of a pipe does
    for (DWORD there = 0; there == 0; ::Sleep(there == 0 ? 5 : 0)) {
        if (::PeekNamedPipe(handleOf(pipe), nullptr, 0, nullptr, &there, nullptr) == 0) return {};
    }
    ::PeekNamedPipe(handleOf(pipe), bytes.data(), static_cast<DWORD>(bytes.size()), &count, nullptr,
                    nullptr);
    bytes.resize(count);
    return bytes;
}

std::ptrdiff_t readSome(const FileHandle& file, void* to, std::size_t size) {
    return ::_read(file.get(), to, static_cast<unsigned>(std::min(size, kMostBytes)));
}

std::ptrdiff_t writeSome(const FileHandle& file, const void* from, std::size_t size) {
    return ::_write(file.get(), from, static_cast<unsigned>(std::min(size, kMostBytes)));
}

std::ptrdiff_t readAt(const FileHandle& file, void* to, std::size_t size, std::uint64_t begin) {
    OVERLAPPED place = placeAt(begin);
    DWORD count = 0;
    const auto most = static_cast<DWORD>(std::min(size, kMostBytes));
    if (::ReadFile(handleOf(file), to, most, &count, &place) != 0) return count;
    if (::GetLastError() == ERROR_HANDLE_EOF) return 0;
    errno = lastErrno();
    return -1;
}

std::ptrdiff_t writeAt(const FileHandle& file, const void* from, std::size_t size,
                       std::uint64_t begin) {
    const HANDLE handle = handleOf(file);
    LARGE_INTEGER before{}; // WriteFile() moves on, unlike pwrite()
    ::SetFilePointerEx(handle, {}, &before, FILE_CURRENT);
    OVERLAPPED place = placeAt(begin);
    DWORD count = 0;
    const auto most = static_cast<DWORD>(std::min(size, kMostBytes));
    const bool isDone = ::WriteFile(handle, from, most, &count, &place) != 0;
    errno = isDone ? 0 : lastErrno();
    ::SetFilePointerEx(handle, before, nullptr, FILE_BEGIN);
    return isDone ? static_cast<std::ptrdiff_t>(count) : -1;
}

bool lockFile(const FileHandle& file) {
    OVERLAPPED place = placeAt(kLockedByte);
    return ::LockFileEx(handleOf(file), LOCKFILE_EXCLUSIVE_LOCK | LOCKFILE_FAIL_IMMEDIATELY, 0, 1,
                        0, &place) != 0 ||
           (::GetLastError() != ERROR_LOCK_VIOLATION && ::GetLastError() != ERROR_IO_PENDING);
}

void unlockToRemove(FileHandle& lock) {
    lock.close();
}

fs::path besideName(const fs::path& path, const std::string& ending) {
    constexpr std::size_t kMost = 255; // characters of a name, in every file system of Windows
    std::wstring name = path.filename().native();
    if (name.size() + ending.size() > kMost)
        name = L".altiro3D-" + std::to_wstring(std::hash<std::wstring>()(name));
    return path.parent_path() / (name + fs::path(ending).native());
}

int takeOwnerAndMode(const FileHandle& /*file*/, const FileState& /*replaced*/) {
    return 0; // a new file has the permissions of its directory
}

int flushFile(const FileHandle& file) {
    if (::FlushFileBuffers(handleOf(file)) != 0) return 0;
    const DWORD error = ::GetLastError();
    return error == ERROR_INVALID_FUNCTION || error == ERROR_INVALID_HANDLE ? 0 : lastErrno();
}

void flushDirectoryOf(const fs::path& /*path*/) {} // the file system does

void touch(const fs::path& path) {
    const HANDLE handle =
        ::CreateFileW(longName(path).c_str(), FILE_WRITE_ATTRIBUTES, kShare, nullptr, OPEN_EXISTING,
                      FILE_FLAG_BACKUP_SEMANTICS, nullptr);
    if (handle == INVALID_HANDLE_VALUE) return;
    FILETIME now{};
    ::GetSystemTimeAsFileTime(&now);
    ::SetFileTime(handle, nullptr, nullptr, &now);
    ::CloseHandle(handle);
}

int moveFile(const fs::path& from, const fs::path& to) {
    if (::MoveFileExW(longName(from).c_str(), longName(to).c_str(), MOVEFILE_REPLACE_EXISTING) != 0)
        return 0;
    const int error = lastErrno();
    return error == EACCES && stateOf(to).isDirectory() ? EEXIST
                                                        : error; // it denies access to them
}

TemporaryFile::TemporaryFile(const fs::path& directory) : directory_(directory) {
    for (int attempt = 0; attempt < 1000; ++attempt) {
        path_ = temporaryName(directory_);
        file_ = newFile(path_);
        if (file_.isOpen()) return;
        if (errno != EEXIST) break;
    }
    path_.clear(); // the name belongs to another file
}

TemporaryFile::~TemporaryFile() {
    if (path_.empty()) return;
    file_.close(); // no open file can be removed
    removeFile(path_);
}

int TemporaryFile::moveTo(const fs::path& target) {
    if (const int error = file_.close()) return error;
    ::SetFileAttributesW(longName(path_).c_str(), FILE_ATTRIBUTE_NORMAL); // no longer hidden
    if (const int error = moveFile(path_, target)) return error;
    path_.clear();
    return 0;
}

FileHandle unnamedFile(const fs::path& directory) {
    const fs::path path = temporaryName(directory);
    FileHandle file = newFile(path);
    if (file.isOpen()) {
        const std::lock_guard<std::mutex> lock(passing.mutex);
        passing.files[file.get()] = path;
    }
    return file;
}

std::vector<fs::path> driveRoots() {
    std::vector<fs::path> roots;
    const DWORD drives = ::GetLogicalDrives();
    for (int i = 0; i < 26; ++i) {
        if ((drives >> i & 1U) == 0) continue;
        const std::wstring root{static_cast<wchar_t>(L'A' + i), L':', L'\\'};
        if (const UINT type = ::GetDriveTypeW(root.c_str());
            type == DRIVE_REMOVABLE || type == DRIVE_FIXED)
            roots.emplace_back(root);
    }
    return roots;
}

} // namespace altiro3D
