#include "image/image_list.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "base/image_format.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <fstream>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

// Whether a file without an extension is a picture by its first bytes.
bool isNamelessPicture(const fs::path& file) {
    if (!file.extension().empty()) return false;
    std::string start(512, '\0');
    std::ifstream stream(file, std::ios::binary);
    stream.read(start.data(), static_cast<std::streamsize>(start.size()));
    start.resize(static_cast<std::size_t>(stream.gcount()));
    return imageFormat(start) != ImageFormat::Unknown;
}

} // namespace

bool hasImageExtension(const fs::path& file) {
    constexpr std::array<const char*, 26> kExtensions = {
        ".png",  ".jpg",  ".jpeg", ".jpe", ".jfif", ".mpo",  ".jps", ".pns", ".tif",
        ".tiff", ".webp", ".bmp",  ".dib", ".pnm",  ".ppm",  ".pgm", ".pbm", ".pfm",
        ".exr",  ".hdr",  ".jp2",  ".j2k", ".heic", ".heif", ".hif", ".avif"};
    return std::find(kExtensions.begin(), kExtensions.end(), lowerExtension(file)) !=
           kExtensions.end();
}

std::vector<fs::path> listImages(const fs::path& directory) {
    std::error_code error;
    if (fs::status(directory, error).type() == fs::file_type::not_found) {
        throw Error(ErrorCode::NotFound, directory.string(),
                    "does not exist, expected a directory with pictures");
    }
    std::vector<fs::path> pictures;
    fs::directory_iterator entries(directory, error); // error: why the directory cannot be read
    while (!error && entries != fs::directory_iterator()) {
        const fs::path& path = entries->path();
        const bool isHidden = path.filename().string().rfind('.', 0) == 0;
        std::error_code unreadable; // dangling links are left out
        if (!isHidden && entries->is_regular_file(unreadable) &&
            (hasImageExtension(path) || isNamelessPicture(path)))
            pictures.push_back(path);
        entries.increment(error);
    }
    if (error) {
        throw Error(ErrorCode::ReadFailed, directory.string(),
                    "cannot be listed: " + error.message() + ", expected a directory");
    }
    std::sort(pictures.begin(), pictures.end(), [](const fs::path& a, const fs::path& b) {
        return naturalLess(a.filename().string(), b.filename().string());
    });
    return pictures;
}

bool naturalLess(const std::string& a, const std::string& b) {
    std::size_t i = 0;
    std::size_t j = 0;
    while (i < a.size() && j < b.size()) {
        if (!isDigit(a[i]) || !isDigit(b[j])) {
            const auto left = static_cast<unsigned char>(lowerCase(a[i]));
            const auto right = static_cast<unsigned char>(lowerCase(b[j]));
            if (left != right) return left < right;
            ++i;
            ++j;
            continue;
        }
        while (i < a.size() && a[i] == '0')
            ++i;
        while (j < b.size() && b[j] == '0')
            ++j;
        const auto digitsEnd = [](const std::string& text, std::size_t at) {
            while (at < text.size() && isDigit(text[at]))
                ++at;
            return at;
        };
        const std::size_t endA = digitsEnd(a, i);
        const std::size_t endB = digitsEnd(b, j);
        if (endA - i != endB - j) return endA - i < endB - j;
        const int order = a.compare(i, endA - i, b, j, endB - j);
        if (order != 0) return order < 0;
        i = endA;
        j = endB;
    }
    const std::size_t restA = a.size() - i;
    const std::size_t restB = b.size() - j;
    if ((restA == 0) != (restB == 0)) return restA == 0;
    return a < b; // differ only in case or leading zeros: a fixed order
}

} // namespace altiro3D
