#pragma once

#include <csignal>
#include <cstdio>
#include <functional>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace altiro3D::test {

/// Runs the call in a child process, which may change limits and users. @return what it returned
inline std::string inChild(const std::function<std::string()>& call) {
    int ends[2];
    if (pipe(ends) != 0) return "no pipe";
    std::fflush(stdout); // or the child prints it again
    const pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        const std::string text = call();
        const bool told = write(ends[1], text.data(), text.size()) >= 0;
        _exit(told ? 0 : 1);
    }
    close(ends[1]);
    std::string text;
    char part[256];
    for (ssize_t count = 0; (count = read(ends[0], part, sizeof part)) > 0;)
        text.append(part, static_cast<std::size_t>(count));
    close(ends[0]);
    waitpid(child, nullptr, 0);
    return text;
}

/// As inChild(), where files cannot grow beyond a size, in bytes, which then fail as on a full
/// disk.
inline std::string withFileLimit(rlim_t bytes, const std::function<std::string()>& call) {
    return inChild([&] {
        const rlimit limit{bytes, bytes};
        signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &limit);
        return call();
    });
}

} // namespace altiro3D::test
