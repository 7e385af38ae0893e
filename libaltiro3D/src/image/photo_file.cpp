#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "base/posix_file.hpp"
#include "image/image_header.hpp"

#include <fstream>
#include <mutex>

namespace altiro3D {

namespace fs = std::filesystem;

struct PhotoFile::State {
    fs::path path;
    std::mutex mutex; // of the following
    std::string bytes;
    bool isRead = false;
};

PhotoFile::PhotoFile(fs::path path, std::shared_ptr<State> /*state*/)
    : state_(std::make_shared<State>()) {
    state_->path = std::move(path);
}

PhotoFile::PhotoFile(std::string bytes, fs::path name) : PhotoFile(std::move(name), nullptr) {
    state_->bytes = std::move(bytes);
    state_->isRead = true;
}

const fs::path& PhotoFile::path() const {
    return state_->path;
}

const std::string& PhotoFile::bytes() const {
    const std::lock_guard lock(state_->mutex);
    if (!state_->isRead) {
        state_->bytes = readFile(state_->path, kMaxImageFileBytes);
        state_->isRead = true;
    }
    return state_->bytes;
}

std::string_view PhotoFile::look() const {
    {
        const std::lock_guard lock(state_->mutex);
        if (!state_->isRead && givesBytesOnce(state_->path)) return {};
    }
    return bytes();
}

std::string PhotoFile::start(std::size_t count) const {
    const std::lock_guard lock(state_->mutex);
    if (state_->isRead) return state_->bytes.substr(0, count);
    if (givesBytesOnce(state_->path)) return {};
    std::string start(count, '\0');
    std::ifstream file(state_->path, std::ios::binary);
    file.read(start.data(), static_cast<std::streamsize>(count));
    start.resize(static_cast<std::size_t>(file.gcount()));
    return start;
}

} // namespace altiro3D
