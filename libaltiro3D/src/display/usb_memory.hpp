#pragma once

#include <chrono>
#include <functional>
#include <string>

/// The memory of displays of the first generation, which holds their visual.json.
namespace altiro3D {

/// How a HID device is reached.
struct HidDevice {
    /// Sends a feature report, which begins with its number. @throws Error
    std::function<void(const std::string& report)> sendFeature;
    /// Waits for an input report or a part of one. @return its bytes; empty if none came in time
    /// @throws Error
    std::function<std::string(std::chrono::milliseconds wait)> readInput;
};

/// Reads the JSON that the memory holds. Page 0 is read each time.
/// @param device the device
/// @param source its name, for errors
/// @param cached JSON of an earlier run; it is returned if page 0 has its length and its beginning
/// @return the JSON, at most 4096 bytes
/// @throws Error ReadFailed (no answer for 2 s, or 10 s in all), BadFormat (an empty memory),
///         TooLarge
std::string readUsbMemory(const HidDevice& device, const std::string& source,
                          const std::string& cached = {});

/// Reads one input report of an open file, for HidDevice.
/// @param file descriptor
/// @param source its name, for errors
/// @param wait the longest time until it comes
/// @return its bytes; empty if none came
/// @throws Error ReadFailed
std::string readInputReport(int file, const std::string& source, std::chrono::milliseconds wait);

} // namespace altiro3D
