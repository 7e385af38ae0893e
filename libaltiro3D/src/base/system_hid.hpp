#pragma once

#include <chrono>
#include <cstddef>
#include <string>

/// Reports of USB devices, which are open as a descriptor.
namespace altiro3D {

/// Sends a feature report to a device that was opened. @return 0 or errno; ENOTSUP: not here
int sendFeatureReport(int device, std::string report);
/// Waits for an input report. @return its length, or -1 with errno; EAGAIN: none has come
std::ptrdiff_t readReport(int device, void* to, std::size_t size, std::chrono::milliseconds wait);

} // namespace altiro3D
