#pragma once

#include <cstdint>
#include <fstream>
#include <gtest/gtest.h>
#ifndef _WIN32
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>
#endif

/// Skips the test if a limit of the address space cannot work: sanitizers reserve terabytes, and
/// the emulator QEMU ignores it. Windows has none.
#ifdef ALTIRO3D_SANITIZED
#define ALTIRO3D_REQUIRE_MEMORY_LIMITS() GTEST_SKIP() << "a sanitizer has the memory"
#else
#define ALTIRO3D_REQUIRE_MEMORY_LIMITS()                                                           \
    if (!::altiro3D::test::memoryLimitsHold()) GTEST_SKIP() << "limits of memory do not hold here"
#endif

namespace altiro3D::test {

#ifdef _WIN32

class MemoryLimit {
  public:
    explicit MemoryLimit(std::uint64_t /*megabytes*/) {}
};

inline bool memoryLimitsHold() {
    return false;
}

#else

/// Limits the memory that the process can allocate further, while the object exists.
class MemoryLimit {
  public:
    explicit MemoryLimit(std::uint64_t megabytes) {
        rlim_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        getrlimit(RLIMIT_AS, &before_);
        rlimit now = before_;
        now.rlim_cur = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (megabytes << 20U);
        setrlimit(RLIMIT_AS, &now);
    }
    ~MemoryLimit() { setrlimit(RLIMIT_AS, &before_); }
    MemoryLimit(const MemoryLimit&) = delete;
    MemoryLimit& operator=(const MemoryLimit&) = delete;

  private:
    rlimit before_{};
};

inline bool memoryLimitsHold() {
    constexpr std::size_t bytes = 64U << 20U;
    const MemoryLimit limit(1);
    void* const block = mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (block == MAP_FAILED) return true;
    munmap(block, bytes);
    return false;
}

#endif

} // namespace altiro3D::test
