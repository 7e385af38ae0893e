#include "cli/system.hpp"

#include <QTextCodec>
#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <io.h>
#include <process.h>

#include <windows.h>

#include <psapi.h>
#include <shellapi.h>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

HANDLE openForFacts(const fs::path& file) {
    return ::CreateFileW(file.c_str(), 0, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE,
                         nullptr, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, nullptr);
}

} // namespace

void prepareProcess() {
    if (::GetStdHandle(STD_OUTPUT_HANDLE) == nullptr &&
        ::AttachConsole(ATTACH_PARENT_PROCESS) != 0) {
        std::freopen("CONOUT$", "w", stdout); // a window started by its name: --help and errors
        std::freopen("CONOUT$", "w", stderr);
    }
    for (const int stream : {0, 1, 2})
        ::_setmode(stream, _O_BINARY); // pictures, and lines that end as on other systems
    ::SetConsoleOutputCP(CP_UTF8);
    for (const DWORD name : {STD_OUTPUT_HANDLE, STD_ERROR_HANDLE}) {
        const HANDLE stream = ::GetStdHandle(name);
        DWORD mode = 0;
        if (::GetConsoleMode(stream, &mode) != 0) // the status line needs it
            ::SetConsoleMode(stream, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);
    }
    ::SetErrorMode(SEM_FAILCRITICALERRORS); // no box for a drive that is empty
    QTextCodec::setCodecForLocale(QTextCodec::codecForName("UTF-8")); // Qt's names of files
}

void onStop(void (*handler)(int)) {
    std::signal(SIGINT, handler);
    std::signal(SIGTERM, handler);
}

std::vector<std::string> argumentsOf(int /*argc*/, char** /*argv*/) {
    int count = 0;
    wchar_t** const words = ::CommandLineToArgvW(::GetCommandLineW(), &count);
    std::vector<std::string> arguments;
    for (int i = 0; i < count; ++i)
        arguments.push_back(fs::path(words[i]).string());
    ::LocalFree(words);
    return arguments;
}

bool isTerminal(std::FILE* stream) {
    DWORD mode = 0; // NUL is a terminal for _isatty()
    return ::GetConsoleMode(reinterpret_cast<HANDLE>(::_get_osfhandle(::_fileno(stream))), &mode) !=
           0;
}

int turnOffStandardError() {
    std::fflush(stderr);
    const int null = ::_wopen(L"NUL", _O_WRONLY | _O_NOINHERIT);
    if (null < 0) return -1;
    const int saved = ::_dup(2);
    if (saved >= 0) ::_dup2(null, 2);
    ::_close(null);
    return saved;
}

void turnOnStandardError(int saved) {
    std::fflush(stderr);
    ::_dup2(saved, 2);
    ::_close(saved);
}

std::string identityOf(const fs::path& file) {
    std::error_code error;
    if (!fs::is_regular_file(file, error)) return {};
    const HANDLE handle = openForFacts(file);
    BY_HANDLE_FILE_INFORMATION facts{};
    const bool isKnown = ::GetFileInformationByHandle(handle, &facts) != 0;
    ::CloseHandle(handle);
    if (!isKnown) return {};
    std::string text;
    for (const DWORD number :
         {facts.dwVolumeSerialNumber, facts.nFileIndexHigh, facts.nFileIndexLow,
          facts.nFileSizeHigh, facts.nFileSizeLow, facts.ftLastWriteTime.dwHighDateTime,
          facts.ftLastWriteTime.dwLowDateTime})
        text += (text.empty() ? "" : " ") + std::to_string(number);
    return text;
}

int checkDirectory(const fs::path& directory) {
    std::error_code error; // who may write in it, only a trial tells
    return fs::is_directory(directory, error) ? 0 : ENOENT;
}

std::string localText(const fs::path& /*folder*/) {
    return {};
}

std::optional<std::string> environment(const char* name) {
    std::wstring value(std::size_t{1} << 15, L'\0');
    value.resize(::GetEnvironmentVariableW(fs::path(name).c_str(), value.data(),
                                           static_cast<DWORD>(value.size())));
    if (value.empty()) return std::nullopt;
    return fs::path(value).string();
}

fs::path userCacheDirectory() {
    const auto local = environment("LOCALAPPDATA");
    return local ? fs::path(*local) : fs::path();
}

bool hasDesktop() {
    return true;
}

void* functionOf(const char* /*library*/, const char* /*name*/) {
    return nullptr;
}

int becomeProgram(std::vector<std::string> words) {
    std::vector<std::wstring> quoted; // it joins them with blanks
    for (const std::string& word : words)
        quoted.push_back(L'"' + fs::path(word).native() + L'"');
    std::vector<const wchar_t*> arguments;
    for (const std::wstring& word : quoted)
        arguments.push_back(word.c_str());
    arguments.push_back(nullptr);
    const std::intptr_t status =
        ::_wspawnvp(_P_WAIT, fs::path(words.front()).c_str(), arguments.data());
    if (status != -1) std::exit(static_cast<int>(status));
    return errno;
}

double peakMegabytes() {
    PROCESS_MEMORY_COUNTERS counters{};
    const bool isKnown =
        ::K32GetProcessMemoryInfo(::GetCurrentProcess(), &counters, sizeof counters) != 0;
    return isKnown ? static_cast<double>(counters.PeakWorkingSetSize) / (1 << 20) : 0;
}

void resetPeakMemory() {} // not possible

void releaseMemory() {}

void fillNewMemory() {}

} // namespace altiro3D::tools
