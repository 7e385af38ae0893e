#include "cli/messages.hpp"

#include "cli/command_line.hpp"
#include "cli/system.hpp"

#include <algorithm>
#include <mutex>
#include <new>
#include <opencv2/core.hpp>
#include <system_error>

namespace altiro3D::tools {

namespace {

struct Console {
    std::mutex mutex;
    bool showsStatus = false;
} console;

void put(std::FILE* stream, const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stream);
    std::fflush(stream);
}

// The caller holds the mutex.
void takeStatusAway() {
    if (console.showsStatus) put(stderr, "\r\033[K");
    console.showsStatus = false;
}

// Standard error belongs to the process: the first object turns it off, the last one on again.
struct Quiet {
    std::mutex mutex;
    int users = 0;
    int saved = -1;
} quiet;

} // namespace

void writeLine(std::FILE* stream, const std::string& line) {
    const std::lock_guard<std::mutex> lock(console.mutex);
    if (isTerminal(stream)) takeStatusAway();
    put(stream, line + '\n');
}

bool hasStatusLine() {
    return isTerminal(stderr);
}

void showStatus(const std::string& text) {
    if (!hasStatusLine()) return;
    const std::lock_guard<std::mutex> lock(console.mutex);
    // Line wrap is off, because only the last row of a wrapped line could be erased.
    put(stderr, "\r\033[K\033[?7l" + text + "\033[?7h");
    console.showsStatus = true;
}

void clearStatus() {
    const std::lock_guard<std::mutex> lock(console.mutex);
    takeStatusAway();
}

std::string oneLine(std::string text) {
    return withoutControls(std::move(text));
}

void Messages::say(const std::string& line) const {
    if (text_ != nullptr && (!quiet_ || verbose_)) writeLine(text_, oneLine(ofSubject(line)));
}

void Messages::warn(const std::string& line) {
    const std::string text = oneLine(line);
    if (std::find(all_.begin(), all_.end(), text) != all_.end()) return;
    all_.push_back(text);
    waiting_.push_back(text);
}

void Messages::warn(const std::vector<std::string>& lines) {
    for (const std::string& line : lines)
        warn(line);
}

void Messages::warn(const Notes& notes) {
    for (const Note& note : notes)
        warn(note.text);
}

void Messages::flushWarnings() {
    for (const std::string& line : waiting_)
        writeLine(stderr, tool_ + ": warning: " + line);
    waiting_.clear();
}

void Messages::dropWarnings() {
    all_.resize(all_.size() - waiting_.size()); // those that wait are the newest
    waiting_.clear();
}

void Messages::fail(const std::string& line) const {
    writeLine(stderr, tool_ + ": error: " + oneLine(line));
}

std::string sentenceOf(const std::exception& error) {
    if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
        return "out of memory, expected more free memory or smaller pictures";
    }
    const auto* const fromSystem = dynamic_cast<const std::system_error*>(&error);
    if (fromSystem != nullptr &&
        fromSystem->code() == std::errc::resource_unavailable_try_again) { // of std::thread
        return "no thread can be started, expected more memory or processes to be allowed";
    }
    std::string text = error.what();
    if (const auto* fromOpenCv = dynamic_cast<const cv::Exception*>(&error)) {
        text = fromOpenCv->code == cv::Error::StsNoMem
                   ? "out of memory, expected more free memory or smaller pictures"
                   : "OpenCV: " + fromOpenCv->err;
    }
    return oneLine(text);
}

std::string codeOf(const std::exception& error) {
    if (const auto* known = dynamic_cast<const Error*>(&error)) return errorCodeName(known->code());
    if (dynamic_cast<const UsageError*>(&error) != nullptr) return "Usage";
    const auto* const fromOpenCv = dynamic_cast<const cv::Exception*>(&error);
    const bool isMemory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
                          (fromOpenCv != nullptr && fromOpenCv->code == cv::Error::StsNoMem);
    return isMemory ? errorCodeName(ErrorCode::OutOfMemory) : "Unknown";
}

QuietStandardError::QuietStandardError() {
    const std::lock_guard<std::mutex> lock(quiet.mutex);
    if (quiet.users++ > 0) return;
    quiet.saved = turnOffStandardError();
}

QuietStandardError::~QuietStandardError() {
    const std::lock_guard<std::mutex> lock(quiet.mutex);
    if (--quiet.users > 0 || quiet.saved < 0) return;
    turnOnStandardError(quiet.saved);
    quiet.saved = -1;
}

} // namespace altiro3D::tools
