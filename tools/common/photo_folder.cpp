#include "common/photo_folder.hpp"

#include "altiro3D/embedded_depth.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/quilt.hpp"
#include "common/run_tool.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <set>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

bool isClipName(const fs::path& file) {
    constexpr std::array<const char*, 14> kEndings = {".mp4", ".mov", ".m4v",  ".mkv", ".webm",
                                                      ".avi", ".mpg", ".mpeg", ".ts",  ".mts",
                                                      ".3gp", ".ogv", ".wmv",  ".flv"};
    const std::string ending = lowerCase(file.extension().string());
    return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

bool isQuiltName(const fs::path& file) {
    try {
        const std::optional<QuiltName> name = parseQuiltName(file);
        return name && name->grid.columns * name->grid.rows > 1;
    } catch (const Error&) {
        return false; // a name of its own
    }
}

std::vector<fs::path> entriesOf(const fs::path& folder) {
    std::vector<fs::path> entries;
    std::error_code error;
    fs::directory_iterator entry(folder, error);
    while (!error && entry != fs::directory_iterator()) {
        if (entry->path().filename().string().rfind('.', 0) != 0) entries.push_back(entry->path());
        entry.increment(error);
    }
    std::sort(entries.begin(), entries.end(), [](const fs::path& a, const fs::path& b) {
        return naturalLess(a.filename().string(), b.filename().string());
    });
    return entries;
}

// The photo beside a file that has its name, whether or not its format can be read.
std::optional<fs::path> photoBeside(const fs::path& clip, const std::vector<fs::path>& entries) {
    constexpr std::array<const char*, 6> kCameraEndings = {".heic", ".heif", ".avif",
                                                           ".jpg",  ".jpeg", ".png"};
    for (const fs::path& entry : entries) {
        const std::string ending = lowerCase(entry.extension().string());
        if (entry.stem() == clip.stem() &&
            std::find(kCameraEndings.begin(), kCameraEndings.end(), ending) != kCameraEndings.end())
            return entry;
    }
    return std::nullopt;
}

// What a file without a picture's extension is.
LeftOutFile otherFile(const fs::path& file, const std::vector<fs::path>& entries) {
    if (isClipName(file)) {
        if (const auto photo = photoBeside(file, entries)) {
            return {file, "Live Photo clip",
                    "is the clip of the Live Photo " + photo->filename().string()};
        }
        return {file, "video", "is a video; video2native makes Natives of videos"};
    }
    const std::string ending = lowerCase(file.extension().string());
    return {file, ending.empty() ? "other file" : ending + " file",
            "is no picture of a format that can be read"};
}

void search(const fs::path& folder, const fs::path& relative, const FolderSearch& how,
            PhotoFolder& found) {
    const std::vector<fs::path> pictures = listImages(folder);
    const std::set<fs::path> readable(pictures.begin(), pictures.end());
    const std::vector<fs::path> entries = entriesOf(folder);
    const auto leaveOut = [&found](const fs::path& file, const char* kind, const std::string& why) {
        found.leftOut.push_back({file, kind, why});
    };
    std::vector<FolderPhoto> photos;
    std::vector<fs::path> depths;
    std::vector<fs::path> folders;
    for (const fs::path& entry : entries) {
        std::error_code error;
        if (fs::is_directory(entry, error)) {
            folders.push_back(entry);
        } else if (readable.count(entry) == 0) {
            found.leftOut.push_back(otherFile(entry, entries));
        } else if (isMarkedNative(entry)) {
            leaveOut(entry, "Native", "is a Native, not a photo; it is left out");
        } else if (isQuiltName(entry)) {
            leaveOut(entry, "quilt",
                     "is a quilt by its name; quilt2native makes Natives of quilts");
        } else if (how.pairDepth && !photoOfDepthName(entry).empty()) {
            depths.push_back(entry);
        } else {
            photos.push_back({entry, {}, relative});
        }
    }
    for (const fs::path& depth : depths) {
        const fs::path stem = photoOfDepthName(depth);
        std::optional<fs::path> other; // depth image of the photo
        bool isUsed = false;
        for (FolderPhoto& photo : photos) {
            if (photo.photo.parent_path() / photo.photo.stem() != stem) continue;
            if (photo.depth.empty()) {
                photo.depth = depth;
                isUsed = true;
            } else {
                other = photo.depth;
            }
        }
        if (isUsed) continue;
        leaveOut(depth, "depth image",
                 other ? "is a depth image by its name, but " + other->filename().string() +
                             " is used"
                       : "is a depth image by its name, but its photo is missing");
    }
    found.photos.insert(found.photos.end(), photos.begin(), photos.end());
    for (const fs::path& subfolder : folders) {
        const bool isOutput = std::any_of(how.outputs.begin(), how.outputs.end(),
                                          [&subfolder](const fs::path& output) {
                                              std::error_code error;
                                              return fs::equivalent(subfolder, output, error);
                                          });
        if (isOutput) continue;
        std::error_code error;
        if (!how.recursive) {
            leaveOut(subfolder, "folder", "is a folder; --recursive converts its photos too");
        } else if (fs::is_symlink(subfolder, error)) {
            leaveOut(subfolder, "folder", "is a link to a folder");
        } else {
            search(subfolder, relative / subfolder.filename(), how, found);
        }
    }
}

} // namespace

PhotoFolder searchFolder(const fs::path& folder, const FolderSearch& how) {
    PhotoFolder found;
    search(folder, {}, how, found);
    return found;
}

std::string kindsText(const std::vector<LeftOutFile>& files) {
    std::vector<std::string> kinds;
    for (const LeftOutFile& file : files) {
        if (std::find(kinds.begin(), kinds.end(), file.kind) == kinds.end())
            kinds.push_back(file.kind);
    }
    std::string text;
    for (const std::string& kind : kinds) {
        const auto count = std::count_if(
            files.begin(), files.end(), [&](const LeftOutFile& file) { return file.kind == kind; });
        text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + kind +
                (count == 1 ? "" : "s");
    }
    return text;
}

} // namespace altiro3D::tools
