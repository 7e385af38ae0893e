#include "cli/system.hpp"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <fstream>
#include <malloc.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

namespace altiro3D::tools {

namespace fs = std::filesystem;

void prepareProcess() {
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
}

void onStop(void (*handler)(int)) {
    struct sigaction action {};
    action.sa_handler = handler; // not SA_RESTART: the signal ends waiting for a pipe
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
}

std::vector<std::string> argumentsOf(int argc, char** argv) {
    return {argv, argv + argc};
}

bool isTerminal(std::FILE* stream) {
    return ::isatty(::fileno(stream)) != 0;
}

int turnOffStandardError() {
    std::fflush(stderr);
    const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (null < 0) return -1;
    const int saved = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    if (saved >= 0) ::dup2(null, STDERR_FILENO);
    ::close(null);
    return saved;
}

void turnOnStandardError(int saved) {
    std::fflush(stderr);
    ::dup2(saved, STDERR_FILENO);
    ::close(saved);
}

std::string identityOf(const fs::path& file) {
    struct stat state {};
    if (::stat(file.c_str(), &state) != 0 || !S_ISREG(state.st_mode)) return {};
    std::string text;
    for (const auto number :
         {static_cast<long long>(state.st_dev), static_cast<long long>(state.st_ino),
          static_cast<long long>(state.st_size), static_cast<long long>(state.st_mtim.tv_sec),
          static_cast<long long>(state.st_mtim.tv_nsec),
          static_cast<long long>(state.st_ctim.tv_sec),
          static_cast<long long>(state.st_ctim.tv_nsec)})
        text += (text.empty() ? "" : " ") + std::to_string(number);
    return text;
}

int checkDirectory(const fs::path& directory) {
    return ::access(directory.c_str(), W_OK | X_OK) == 0 ? 0 : errno;
}

std::string localText(const fs::path& folder) {
    for (const char* place : {"/tmp", "/var/tmp", "/dev/shm", "/run"}) {
        const fs::path rest = folder.lexically_relative(place);
        if (!rest.empty() && *rest.begin() != "..")
            return folder.string() + ": lies in " + place + ", which other machines do not see";
    }
    struct statfs state {};
    if (::statfs(folder.c_str(), &state) != 0) return {};
    // of linux/magic.h: ext2 to ext4, XFS, btrfs, tmpfs, overlayfs, F2FS
    for (const std::uint32_t local :
         {0xef53U, 0x58465342U, 0x9123683eU, 0x01021994U, 0x794c7630U, 0xf2f52010U}) {
        if (static_cast<std::uint32_t>(state.f_type) == local) {
            return folder.string() +
                   ": lies on a disk of this machine; other machines see it only if this machine "
                   "shares it";
        }
    }
    return {};
}

std::optional<std::string> environment(const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0' ? std::optional<std::string>(value) : std::nullopt;
}

fs::path userCacheDirectory() {
    fs::path cache = environment("XDG_CACHE_HOME").value_or("");
    if (cache.is_absolute()) return cache;
    const auto home = environment("HOME");
    return home ? fs::path(*home) / ".cache" : fs::path();
}

bool hasDesktop() {
    return environment("QT_QPA_PLATFORM") || environment("DISPLAY") ||
           environment("WAYLAND_DISPLAY");
}

void* functionOf(const char* library, const char* name) {
    void* const opened = ::dlopen(library, RTLD_LAZY);
    return opened != nullptr ? ::dlsym(opened, name) : nullptr;
}

int becomeProgram(std::vector<std::string> words) {
    std::vector<char*> arguments;
    for (std::string& word : words)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    ::execvp(arguments.front(), arguments.data());
    return errno;
}

double peakMegabytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        if (line.compare(0, 6, "VmHWM:") == 0) return std::atof(line.c_str() + 6) / 1024;
    }
    return 0;
}

void resetPeakMemory() {
    std::ofstream("/proc/self/clear_refs") << "5";
}

void releaseMemory() {
    ::malloc_trim(0);
}

void fillNewMemory() {
    ::mallopt(M_PERTURB, 0xff); // sets allocated memory to 0
}

} // namespace altiro3D::tools
