#include "base/system_hid.hpp"

#include <cerrno>
#include <poll.h>
#include <unistd.h>

#ifdef __linux__
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#endif

namespace altiro3D {

int sendFeatureReport([[maybe_unused]] int device, [[maybe_unused]] std::string report) {
#ifdef __linux__
    return ::ioctl(device, HIDIOCSFEATURE(report.size()), report.data()) < 0 ? errno : 0;
#else
    return ENOTSUP;
#endif
}

std::ptrdiff_t readReport(int device, void* to, std::size_t size, std::chrono::milliseconds wait) {
    pollfd waiting{device, POLLIN, 0};
    if (::poll(&waiting, 1, static_cast<int>(wait.count())) > 0) return ::read(device, to, size);
    errno = EAGAIN;
    return -1;
}

} // namespace altiro3D
