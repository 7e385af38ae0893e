#include "altiro3D/display.hpp"
#include "altiro3D/error.hpp"
#include "base/state_bytes.hpp"
#include "base/system_file.hpp"
#include "base/system_hid.hpp"
#include "base/text.hpp"
#include "display/usb_memory.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void failRead(const std::string& source, int number) {
    if (number == EACCES || number == EPERM) {
        throw Error(ErrorCode::ReadFailed, source,
                    "no permission to read the display, expected the rule 70-altiro3D.rules in "
                    "/etc/udev/rules.d (altiro3D's packages install it) and the display plugged in "
                    "again");
    }
    throw Error(ErrorCode::ReadFailed, source,
                "cannot be read: " + reasonOf(number) + ", expected a connected display");
}

} // namespace

std::string readInputReport(int file, const std::string& source, std::chrono::milliseconds wait) {
    std::array<char, 256> bytes{};
    const std::ptrdiff_t count = readReport(file, bytes.data(), bytes.size(), wait);
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return {};
    if (count <= 0) failRead(source, count < 0 ? errno : ENODEV);
    return {bytes.data(), static_cast<std::size_t>(count)};
}

// Many devices of small makers share this number, so the name decides.
std::vector<UsbDisplay> findUsbDisplays(const fs::path& root) {
    std::vector<UsbDisplay> found;
    std::error_code error;
    for (fs::directory_iterator it(root / "sys/class/hidraw", error), end; !error && it != end;
         it.increment(error)) {
        std::ifstream file(it->path() / "device/uevent");
        const std::string facts{std::istreambuf_iterator<char>(file), {}};
        const std::string name = lowerCase(facts);
        const auto states = [&name](const char* part) { return name.find(part) < name.size(); };
        if (!states(":000004d8:0000ef7e\n") || !states("holoplay")) continue;
        found.push_back({root / "dev" / it->path().filename(), fingerprintText(checksum(facts))});
    }
    std::sort(found.begin(), found.end(),
              [](const UsbDisplay& a, const UsbDisplay& b) { return a.device < b.device; });
    return found;
}

std::string readUsbCalibration(const UsbDisplay& display, const std::string& cached) {
    const std::string source = display.device.string();
    const FileHandle file = openFile(display.device, OpenFor::Device);
    if (!file.isOpen()) failRead(source, errno);
    const HidDevice device{
        [&](const std::string& report) {
            if (const int error = sendFeatureReport(file.get(), report)) failRead(source, error);
        },
        [&](std::chrono::milliseconds wait) { return readInputReport(file.get(), source, wait); }};
    std::string json = readUsbMemory(device, source, cached);
    const DisplayModel* model = findDisplayModel(parseCalibrations(json, source).front());
    if (model != nullptr && model->serialPrefix == "LKG-P") {
        throw Error(ErrorCode::Unsupported, source,
                    "is a Portrait, which gives damaged data by this way, expected its volume to "
                    "be mounted");
    }
    return json;
}

} // namespace altiro3D
