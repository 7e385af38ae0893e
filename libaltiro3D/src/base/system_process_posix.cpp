#include "base/system_process.hpp"

#include "altiro3D/file_io.hpp"
#include "base/system_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace altiro3D {

namespace {

constexpr char kSurvived = 'y';

// Runs in the child and never returns, because the parent's destructors must not run here.
[[noreturn]] void workApart(const std::function<void()>& work, int result) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL); // without the parent there is no time limit
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_CORE, &none);
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT})
        std::signal(signal, SIG_DFL);
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (nowhere >= 0) {
        ::dup2(nowhere, STDOUT_FILENO);
        ::dup2(nowhere, STDERR_FILENO);
    }
    work();
    while (::write(result, &kSurvived, 1) < 0 && errno == EINTR) {
    }
    ::_exit(0);
}

// Waits until the descriptor can be read or its other end closes. False after the time limit.
bool waitFor(int descriptor, double seconds) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::duration<double>(seconds);
    for (;;) {
        const double left =
            std::max(0.0, std::chrono::duration<double, std::milli>(end - Clock::now()).count());
        pollfd waiting{descriptor, POLLIN, 0};
        const int ready = ::poll(&waiting, 1, static_cast<int>(left) + 1);
        if (ready > 0) return true;
        if (ready == 0 && left <= 0) return false;
        if (ready < 0 && errno != EINTR) return true; // the following read reports the error
    }
}

} // namespace

std::int64_t processNumber() {
    return ::getpid();
}

bool isRunning(std::int64_t process) {
    const auto number = static_cast<pid_t>(process);
    return number != process || ::kill(number, 0) == 0 || errno != ESRCH;
}

ApartEnd runApart(const std::function<void()>& work, const std::vector<std::string>& /*program*/,
                  double seconds) {
    ApartEnd end;
    int ends[2] = {-1, -1};
    if (::pipe2(ends, O_CLOEXEC) != 0) {
        end.error = errno;
        return end;
    }
    const FileHandle answers(ends[0]);
    FileHandle childEnd(ends[1]);
    const pid_t child = ::fork();
    if (child < 0) {
        end.error = errno;
        return end;
    }
    if (child == 0) workApart(work, childEnd.get());
    childEnd.close();
    end.isInTime = waitFor(answers.get(), seconds);
    char answer = 0;
    if (end.isInTime) {
        while (::read(answers.get(), &answer, 1) < 0 && errno == EINTR) {
        }
    }
    if (!end.isInTime) ::kill(child, SIGKILL);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    end.isWhole = answer == kSurvived;
    if (WIFSIGNALED(status)) end.how = std::string(" (") + strsignal(WTERMSIG(status)) + ")";
    return end;
}

std::tm localTime(std::time_t time) {
    std::tm local{};
    ::localtime_r(&time, &local);
    return local;
}

void requestLargePages([[maybe_unused]] const void* begin, [[maybe_unused]] const void* end) {
#ifdef MADV_HUGEPAGE
    constexpr std::uintptr_t kPage = std::uintptr_t{2} << 20;
    const std::uintptr_t first =
        (reinterpret_cast<std::uintptr_t>(begin) + kPage - 1) / kPage * kPage;
    const std::uintptr_t last = reinterpret_cast<std::uintptr_t>(end) / kPage * kPage;
    if (first < last) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
#endif
}

std::string environmentOf(const char* name) {
    const char* const value = std::getenv(name);
    return value != nullptr ? value : "";
}

const char kListSeparator = ':';
const char kShellQuote = '\'';
const char* const kQuoteInShellQuotes = "'\\''";

std::filesystem::path userDataDirectory() {
    // The XDG base directory specification requires that a relative $XDG_DATA_HOME is ignored.
    std::filesystem::path data = environmentOf("XDG_DATA_HOME");
    if (data.is_absolute()) return data;
    const std::filesystem::path home = environmentOf("HOME");
    return home.is_absolute() ? home / ".local" / "share" : std::filesystem::path();
}

std::string hostName() {
    std::array<char, 256> name{};
    if (::gethostname(name.data(), name.size() - 1) != 0) return "unknown";
    return name.data();
}

} // namespace altiro3D
