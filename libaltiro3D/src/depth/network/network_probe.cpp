#include "altiro3D/depth_network.hpp"
#include "base/checks.hpp"
#include "base/posix_file.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <opencv2/core.hpp>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr char kSurvived = 'y';

// Runs in the child and never returns, because the parent's destructors must not run here.
[[noreturn]] void tryNetwork(const fs::path& file, const NetworkProfile& profile, cv::Size size,
                             InferenceEngine engine, int result) {
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
    try {
        cv::setNumThreads(1); // fork() does not copy the parent's threads
        DepthNetwork network(file, profile, InferenceTarget::Cpu, size, engine);
        cv::Mat raw;
        network.infer(cv::Mat(network.inputSize(), CV_8UC3, cv::Scalar::all(128)), raw);
    } catch (const std::exception&) { // the parent gets the same error and reports it
    }
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

void probeNetwork(const fs::path& file, const NetworkProfile& profile, cv::Size inputSize,
                  double seconds, InferenceEngine engine) {
    checkRange("seconds", seconds, 0.1, 3600);
    int ends[2] = {-1, -1};
    const auto refuse = [&] {
        throw Error(ErrorCode::ReadFailed, file.string(),
                    "cannot be tested in a separate process: " +
                        std::generic_category().message(errno));
    };
    if (::pipe2(ends, O_CLOEXEC) != 0) refuse();
    const FileHandle answers(ends[0]);
    FileHandle childEnd(ends[1]);
    const pid_t child = ::fork();
    if (child < 0) refuse();
    if (child == 0) tryNetwork(file, profile, inputSize, engine, childEnd.get());
    childEnd.close();
    const bool inTime = waitFor(answers.get(), seconds);
    char answer = 0;
    if (inTime) {
        while (::read(answers.get(), &answer, 1) < 0 && errno == EINTR) {
        }
    }
    if (!inTime) ::kill(child, SIGKILL);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (!inTime) {
        throw Error(ErrorCode::NetworkFailed, file.string(),
                    "does not finish within " + numberText(seconds) +
                        " s, expected a depth network that the engine can run");
    }
    if (answer == kSurvived) return;
    const std::string signal =
        WIFSIGNALED(status) ? std::string(" (") + strsignal(WTERMSIG(status)) + ")" : "";
    throw Error(ErrorCode::NetworkFailed, file.string(),
                "crashes when it is loaded or run" + signal +
                    ", expected a depth network that the engine can run");
}

} // namespace altiro3D
