// The names of depth images: which photo one is for, and which one lies beside a photo.

#include "altiro3D/embedded_depth.hpp"
#include "altiro3D/image_io.hpp"
#include "base/text.hpp"
#include "image/image_list.hpp"

#include <array>
#include <string_view>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kSeparators = "-_. ";
constexpr std::array<std::string_view, 4> kWords = {"depth", "depthmap", "depth_map", "disparity"};

bool endsWithAnyCase(std::string_view text, std::string_view smallEnding) {
    if (text.size() < smallEnding.size()) return false;
    text.remove_prefix(text.size() - smallEnding.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (lowerCase(text[i]) != smallEnding[i]) return false;
    }
    return true;
}

} // namespace

fs::path photoOfDepthName(const fs::path& depth) {
    const std::string stem = depth.stem().string();
    for (const std::string_view word : kWords) {
        if (!endsWithAnyCase(stem, word) || stem.size() < word.size() + 2) continue;
        const std::size_t separator = stem.size() - word.size() - 1;
        if (kSeparators.find(stem[separator]) != std::string_view::npos)
            return depth.parent_path() / stem.substr(0, separator);
    }
    return {};
}

fs::path findDepthBeside(const fs::path& photo) {
    const fs::path directory = photo.parent_path();
    const std::string stem = photo.stem().string();
    if (stem.empty()) return {};
    fs::path best;
    std::error_code error;
    fs::directory_iterator entry(directory.empty() ? fs::path(".") : directory, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        if (!startsWith(name, stem) || !hasImageExtension(name) || photoOfDepthName(name) != stem)
            continue;
        std::error_code unreadable; // dangling links are left out
        if (!entry->is_regular_file(unreadable)) continue;
        if (best.empty() || naturalLess(name, best.string())) best = name;
    }
    return best.empty() ? fs::path() : directory / best;
}

} // namespace altiro3D
