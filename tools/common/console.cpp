#include "common/console.hpp"

#include <mutex>
#include <unistd.h>

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

} // namespace

void writeLine(std::FILE* stream, const std::string& line) {
    const std::lock_guard<std::mutex> lock(console.mutex);
    if (isatty(fileno(stream)) != 0) takeStatusAway();
    put(stream, line + '\n');
}

bool hasStatusLine() {
    return isatty(STDERR_FILENO) != 0;
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

} // namespace altiro3D::tools
