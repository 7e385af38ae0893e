#include "display/usb_memory.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"

#include <algorithm>

namespace altiro3D {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kPageBytes = 64;
constexpr std::size_t kHeadBytes = 4; // head of an answer: buttons, then the request's 00 and page
constexpr std::size_t kReportBytes = kHeadBytes + kPageBytes;
constexpr std::size_t kFirstPartBytes = 64; // first part of a report that arrives in two parts
constexpr std::size_t kMaxJsonBytes = 4096; // known memories hold 1024 bytes
constexpr int kAttempts = 4;                // 2 s for a page
constexpr std::chrono::milliseconds kAttempt{500};
constexpr std::chrono::seconds kMost{10}; // for all pages
constexpr int kMostOldReports = 100;

// Skips reports whose echo differs from the request; they report buttons.
std::string readPage(const HidDevice& device, const std::string& source, std::size_t page,
                     Clock::time_point end) {
    std::string request(kReportBytes, '\0'); // report 0, command 0 (read), page
    request[2] = static_cast<char>(page >> 8);
    request[3] = static_cast<char>(page);
    for (int old = 0; old < kMostOldReports && !device.readInput({}).empty();)
        ++old;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
        device.sendFeature(request);
        const Clock::time_point until = std::min(Clock::now() + kAttempt, end);
        std::string report;
        for (Clock::time_point now = Clock::now(); now < until; now = Clock::now()) {
            const std::string part =
                device.readInput(std::chrono::ceil<std::chrono::milliseconds>(until - now));
            if (part.empty()) break;
            const bool isSecond =
                report.size() == kFirstPartBytes && part.size() == kReportBytes - kFirstPartBytes;
            report = isSecond ? report + part : part;
            if (report.size() >= kReportBytes && report.compare(1, 3, request, 1, 3) == 0)
                return report.substr(kHeadBytes, kPageBytes);
        }
    }
    throw Error(ErrorCode::ReadFailed, source,
                "the display does not answer, expected page " + std::to_string(page) +
                    " of its memory within 2 s; plug it in again");
}

} // namespace

std::string readUsbMemory(const HidDevice& device, const std::string& source,
                          const std::string& cached) {
    const Clock::time_point end = Clock::now() + kMost;
    const std::string first = readPage(device, source, 0, end);
    std::size_t length = 0; // big-endian
    for (std::size_t i = 0; i < 4; ++i)
        length = length << 8 | static_cast<unsigned char>(first[i]);
    if (length == 0 || length == 0xffffffff)
        throw Error(ErrorCode::BadFormat, source, "its memory is empty, expected a calibration");
    if (length > kMaxJsonBytes) {
        throw Error(ErrorCode::TooLarge, source,
                    "its memory states a calibration of " + std::to_string(length) +
                        " bytes, expected at most " + std::to_string(kMaxJsonBytes));
    }
    std::string json = first.substr(4, length);
    if (cached.size() == length && startsWith(cached, json)) return cached;
    for (std::size_t page = 1; json.size() < length; ++page)
        json += readPage(device, source, page, end);
    json.resize(length);
    return json;
}

} // namespace altiro3D
