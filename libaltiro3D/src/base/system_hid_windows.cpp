#include "base/system_hid.hpp"

#include <cerrno>

namespace altiro3D {

// Displays of the first generation, which have their calibration in the USB device, are not found
// here.
int sendFeatureReport(int /*device*/, std::string /*report*/) {
    return ENOTSUP;
}

std::ptrdiff_t readReport(int /*device*/, void* /*to*/, std::size_t /*size*/,
                          std::chrono::milliseconds /*wait*/) {
    errno = ENOTSUP;
    return -1;
}

} // namespace altiro3D
