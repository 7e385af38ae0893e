#include "video/chunks/work_folder.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/posix_file.hpp"

#include <cerrno>
#include <csignal>
#include <fcntl.h>
#include <regex>
#include <sys/stat.h>
#include <sys/types.h>
#include <system_error>
#include <unistd.h>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr const char* kAside = "-old";
constexpr auto kBetweenSigns = std::chrono::minutes(1);
constexpr auto kLongest = std::chrono::hours(1);

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
    static const std::regex kName("([0-9]+|join)\\.(.+)-([1-9][0-9]{0,17})-[0-9]{1,19}(-old)?");
    std::vector<fs::path> stale;
    for (fs::directory_iterator entry(target_.parent_path(), error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string text = entry->path().filename().string();
        std::smatch name;
        if (!std::regex_match(text, name, kName) || (!target.empty() && name[1] != target))
            continue;
        std::error_code failure;
        const bool isKilled =
            name[2] == host && host != "unknown" && !isRunning(std::stoll(name[3]));
        const auto shown = fs::last_write_time(entry->path(), failure);
        if (isKilled || (!failure && now - shown > kLongest)) stale.push_back(entry->path());
    }
    for (const fs::path& folder : stale)
        fs::remove_all(folder, error);
}

} // namespace altiro3D
