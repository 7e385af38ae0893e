#include "cluster/cluster_plan.hpp"

#include "altiro3D/video_conversion.hpp"
#include "cluster/photo_chunks.hpp"

#include <QCoreApplication>
#include <algorithm>
#include <cctype>
#include <cstdint>
#include <sys/vfs.h>
#include <system_error>

namespace altiro3D::tools {

namespace fs = std::filesystem;

std::string ClusterPlan::program() const {
    const fs::path beside = fs::path(QCoreApplication::applicationDirPath().toStdString()) / tool;
    std::error_code error;
    return fs::is_regular_file(beside, error) ? beside.string() : tool;
}

ClusterPlan readClusterPlan(const fs::path& folder) {
    ClusterPlan plan;
    plan.folder = fs::absolute(folder);
    if (holdsPhotoChunks(plan.folder)) {
        const PhotoChunks photos = readPhotoChunks(plan.folder);
        plan.tool = "photo2native";
        plan.unit = "photo";
        plan.threads = photos.threads;
        for (int number = 1; number <= photos.count(); ++number) {
            const auto [first, end] = photos.photosOf(number);
            plan.units.push_back(static_cast<std::int64_t>(end - first));
        }
        return plan;
    }
    const VideoChunkPlan video = readVideoChunks(plan.folder);
    plan.tool = "video2native";
    plan.unit = "frame";
    plan.threads = video.threads;
    for (const VideoChunk& chunk : video.chunks) {
        plan.units.push_back(chunk.frames);
        if (chunk.frames == 0) ++plan.depthAlone;
    }
    return plan;
}

std::vector<bool> madeChunks(const ClusterPlan& plan) {
    std::vector<bool> made;
    const auto isMade = plan.tool == "photo2native" ? isPhotoChunkMade : isVideoChunkMade;
    for (int number = 1; number <= plan.chunks(); ++number)
        made.push_back(isMade(plan.folder, number));
    return made;
}

std::string rangesText(const std::vector<int>& numbers) {
    std::string text;
    for (std::size_t i = 0; i < numbers.size();) {
        std::size_t end = i + 1;
        while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1)
            ++end;
        if (!text.empty()) text += ",";
        text += std::to_string(numbers[i]);
        if (end > i + 1) text += "-" + std::to_string(numbers[end - 1]);
        i = end;
    }
    return text;
}

std::string localText(const fs::path& folder) {
    for (const char* place : {"/tmp", "/var/tmp", "/dev/shm", "/run"}) {
        const fs::path rest = folder.lexically_relative(place);
        if (!rest.empty() && *rest.begin() != "..")
            return folder.string() + ": lies in " + place + ", which other machines do not see";
    }
    struct statfs state {};
    if (::statfs(folder.c_str(), &state) != 0) return {};
    // of linux/magic.h: ext2 to ext4, XFS, btrfs, tmpfs, overlayfs, F2FS
    for (const std::uint32_t local :
         {0xef53U, 0x58465342U, 0x9123683eU, 0x01021994U, 0x794c7630U, 0xf2f52010U}) {
        if (static_cast<std::uint32_t>(state.f_type) == local) {
            return folder.string() +
                   ": lies on a disk of this machine; other machines see it only if this machine "
                   "shares it";
        }
    }
    return {};
}

std::string shellWord(const std::string& text) {
    const bool isPlain = !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
               std::string("-_./,=:%@+").find(c) != std::string::npos;
    });
    if (isPlain) return text;
    std::string word = "'";
    for (const char c : text)
        word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return word + "'";
}

} // namespace altiro3D::tools
