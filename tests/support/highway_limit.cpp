// Hides instruction sets of the processor from a program, so that Highway chooses other kernels.
// Load it before the program's libraries:
//
//   HIGHWAY_LEAVE_OUT=1 LD_PRELOAD=libaltiro3D_highway_limit.so photo2native ...
//
// hides the best instruction set of this processor, 2 the best two. If none is left, the program
// ends with status 99, so that a script knows when to stop.

#include <cstdint>
#include <cstdlib>
#define HWY_WANT_AVX3_DL 1 // as libaltiro3D: what it does not know it cannot hide
#include <hwy/highway.h>
#include <unistd.h>

namespace {

__attribute__((constructor)) void leaveOut() {
    const char* number = std::getenv("HIGHWAY_LEAVE_OUT");
    if (number == nullptr) return;
    std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS;
    std::int64_t leftOut = 0;
    for (int i = std::atoi(number); i > 0 && left != 0; --i) { // the lowest bit is the best
        leftOut |= left & -left;
        left &= left - 1;
    }
    if (left == 0) _exit(99);
    hwy::DisableTargets(leftOut);
}

} // namespace
