// What a device answers that is read as the USB memory of a display.

#include "altiro3D/display.hpp"
#include "display/usb_memory.hpp"
#include "fuzz.hpp"

using namespace altiro3D;

// Each request frees some of the reports. A report begins with its length; of two kinds that are
// hard to guess, right answers and their two parts, the device fills in the head.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::string_view left = fuzz::textOf(data, size);
    const auto byte = [&left] {
        const unsigned char value = left.empty() ? 0 : static_cast<unsigned char>(left.front());
        left.remove_prefix(left.empty() ? 0 : 1);
        return value;
    };
    std::string echo;
    std::string rest; // second part
    int free = 0;
    const HidDevice device{[&](const std::string& report) {
                               fuzz::require(report.size() == 68, "a request has 68 bytes");
                               echo = report.substr(1, 3);
                               free = 1 + byte() % 4;
                           },
                           [&](std::chrono::milliseconds /*wait*/) {
                               if (!rest.empty()) return std::exchange(rest, {});
                               if (free == 0 || left.empty()) return std::string();
                               --free;
                               const unsigned char kind = byte();
                               const bool isAnswer = kind >= 0xfe;
                               std::string report(left.substr(0, isAnswer ? 64 : kind));
                               left.remove_prefix(report.size());
                               if (!isAnswer) return report;
                               report.resize(64);
                               report.insert(0, '\0' + echo);
                               if (kind == 0xff) {
                                   rest = report.substr(64);
                                   report.resize(64);
                               }
                               return report;
                           }};
    fuzz::reads([&] {
        const std::string json = readUsbMemory(device, "/dev/hidraw0");
        fuzz::require(!json.empty() && json.size() <= 4096, "a calibration has 1..4096 bytes");
        parseCalibrations(json, "/dev/hidraw0");
    });
    return 0;
}
