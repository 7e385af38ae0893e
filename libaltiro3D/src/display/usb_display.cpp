#include "altiro3D/display.hpp"
#include "altiro3D/error.hpp"
#include "base/posix_file.hpp"
#include "base/state_bytes.hpp"
#include "base/text.hpp"
#include "display/usb_memory.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <poll.h>
#include <system_error>
#include <unistd.h>

#ifdef __linux__
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#endif

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
                "cannot be read: " + std::generic_category().message(number) +
                    ", expected a connected display");
}

void sendFeatureReport(int file, const std::string& source, std::string report) {
#ifdef __linux__
    if (::ioctl(file, HIDIOCSFEATURE(report.size()), report.data()) < 0) failRead(source, errno);
#else
    static_cast<void>(file);
    static_cast<void>(report);
    throw Error(ErrorCode::Unsupported, source, "is read under Linux only, expected visual.json");
#endif
}

} // namespace

std::string readInputReport(int file, const std::string& source, std::chrono::milliseconds wait) {
    pollfd waiting{file, POLLIN, 0};
    if (::poll(&waiting, 1, static_cast<int>(wait.count())) <= 0) return {};
    std::array<char, 256> bytes{};
    const ssize_t count = ::read(file, bytes.data(), bytes.size());
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
    const FileHandle file = openFile(display.device, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (!file.isOpen()) failRead(source, errno);
    const HidDevice device{
        [&](const std::string& report) { sendFeatureReport(file.get(), source, report); },
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
