#include "video/chunks/work_folder.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/posix_file.hpp"

#include <cerrno>
#include <charconv>
#include <csignal>
#include <fcntl.h>
#include <string>
#include <string_view>
#include <sys/stat.h>
#include <sys/types.h>
#include <system_error>
#include <unistd.h>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kAside = "-old";
constexpr auto kBetweenSigns = std::chrono::minutes(1);
constexpr auto kLongest = std::chrono::hours(1);

// The number after the last '-', which is cut off with it. -1: there is none.
long long takeNumber(std::string_view& text) {
    const std::size_t dash = text.rfind('-');
    if (dash == std::string_view::npos) return -1;
    const std::string_view digits = text.substr(dash + 1);
    long long number = -1;
    const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (read.ec != std::errc() || read.ptr != digits.data() + digits.size() || number < 0)
        return -1;
    text = text.substr(0, dash);
    return number;
}

// What the name of a work folder states.
struct WorkName {
    bool isWork = false;
    std::string_view target;
    std::string_view host;
    long long process = 0;
};

WorkName nameOf(std::string_view text) {
    WorkName name;
    if (text.size() > kAside.size() && text.substr(text.size() - kAside.size()) == kAside)
        text.remove_suffix(kAside.size());
    const std::size_t dot = text.find('.');
    if (dot == std::string_view::npos) return name;
    name.target = text.substr(0, dot);
    name.host = text.substr(dot + 1);
    const long long time = takeNumber(name.host);
    name.process = takeNumber(name.host);
    const bool isNumber = name.target.find_first_not_of("0123456789") == std::string_view::npos;
    const bool isOurs = (isNumber && !name.target.empty()) || name.target == "join";
    name.isWork = isOurs && time >= 0 && name.process > 0 && !name.host.empty();
    return name;
}

bool isRunning(long long process) {
    const auto number = static_cast<pid_t>(process);
    return number != process || kill(number, 0) == 0 || errno != ESRCH;
}

} // namespace

WorkFolder::WorkFolder(const fs::path& target)
    : target_(target), path_(target), shown_(std::chrono::steady_clock::now()) {
    path_ += "." + hostName() + "-" + std::to_string(getpid()) + "-" +
             std::to_string(shown_.time_since_epoch().count());
    std::error_code error;
    fs::create_directory(path_, error);
    if (error) {
        throw Error(ErrorCode::WriteFailed, path_.string(),
                    "cannot be made: " + error.message() +
                        ", expected the folder of the plan to be shared and writable");
    }
}

WorkFolder::~WorkFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
}

void WorkFolder::showLife() {
    const auto now = std::chrono::steady_clock::now();
    if (now - shown_ < kBetweenSigns) return;
    shown_ = now;
    utimensat(AT_FDCWD, path_.c_str(), nullptr, 0); // the time of the file system, not ours
}

bool WorkFolder::finish() {
    std::error_code error;
    fs::rename(path_, target_, error);
    if (error == std::errc::directory_not_empty || error == std::errc::file_exists) return false;
    if (error)
        throw Error(ErrorCode::WriteFailed, target_.string(), "cannot be made: " + error.message());
    path_.clear();
    flushDirectoryOf(target_);
    return true;
}

void WorkFolder::moveAway() {
    std::error_code ignored;
    fs::path aside = path_;
    aside += kAside;
    fs::rename(target_, aside, ignored);
    fs::remove_all(aside, ignored);
}

void WorkFolder::removeStale(const std::string& target) const {
    std::error_code error;
    const auto now = fs::last_write_time(path_, error);
    if (error) return;
    const std::string host = hostName();
    std::vector<fs::path> stale;
    for (fs::directory_iterator entry(target_.parent_path(), error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string text = entry->path().filename().string();
        const WorkName name = nameOf(text);
        if (!name.isWork || (!target.empty() && name.target != target)) continue;
        std::error_code failure;
        const bool isKilled = name.host == host && host != "unknown" && !isRunning(name.process);
        const auto shown = fs::last_write_time(entry->path(), failure);
        if (isKilled || (!failure && now - shown > kLongest)) stale.push_back(entry->path());
    }
    for (const fs::path& folder : stale)
        fs::remove_all(folder, error);
}

} // namespace altiro3D
