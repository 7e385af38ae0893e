#include "common/folder_search.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/quilt.hpp"
#include "common/run_tool.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

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

// How a kind is counted, and why a file of it is left out.
struct KindWords {
    FileKind kind;
    const char* name;
    const char* why;
};
constexpr std::array<KindWords, 8> kWords = {{
    {FileKind::Photo, "photo", "is a picture; photo2native makes Natives of photos"},
    {FileKind::DepthImage, "depth image", "is a depth image by its name, but its photo is missing"},
    {FileKind::Native, "Native", "is a Native, not a photo; it is left out"},
    {FileKind::Quilt, "quilt", "is a quilt by its name; quilt2native makes Natives of quilts"},
    {FileKind::Video, "video", "is a video; video2native makes Natives of videos"},
    {FileKind::DepthVideo, "depth video",
     "is the depth of a video by its name; video2native --depth takes it with its video"},
    {FileKind::QuiltVideo, "quilt video",
     "is a video of quilts by its name; quilt2native makes a Native of it"},
    {FileKind::Folder, "folder", "is a folder; --recursive also converts what it holds"},
}};

FileKind kindOfPicture(const fs::path& file, const FolderSearch& how) {
    if (isMarkedNative(file)) return FileKind::Native;
    if (isQuiltName(file)) return FileKind::Quilt;
    if (how.pairDepth && !photoOfDepthName(file).empty()) return FileKind::DepthImage;
    return FileKind::Photo;
}

FileKind kindOfVideo(const fs::path& file, const std::vector<fs::path>& entries) {
    if (photoBeside(file, entries)) return FileKind::LiveClip;
    if (isQuiltName(file)) return FileKind::QuiltVideo;
    return photoOfDepthName(file).empty() ? FileKind::Video : FileKind::DepthVideo;
}

LeftOutFile leftOutFile(const fs::path& file, FileKind kind, const std::vector<fs::path>& entries) {
    if (kind == FileKind::LiveClip) {
        return {file, "Live Photo clip",
                "is the clip of the Live Photo " + photoBeside(file, entries)->filename().string()};
    }
    for (const KindWords& words : kWords) {
        if (words.kind == kind) return {file, words.name, words.why};
    }
    const std::string ending = lowerCase(file.extension().string());
    return {file, ending.empty() ? "other file" : ending + " file",
            "is no picture or video of a format that can be read"};
}

// Gives photos the depth images beside them; the others are left out.
void pairDepthImages(const std::vector<fs::path>& depths, std::vector<FolderFile>& files,
                     std::vector<LeftOutFile>& leftOut) {
    for (const fs::path& depth : depths) {
        const fs::path stem = photoOfDepthName(depth);
        std::optional<fs::path> other; // depth image of the photo
        bool isUsed = false;
        for (FolderFile& photo : files) {
            if (photo.file.parent_path() / photo.file.stem() != stem) continue;
            if (photo.depth.empty()) {
                photo.depth = depth;
                isUsed = true;
            } else {
                other = photo.depth;
            }
        }
        if (isUsed) continue;
        leftOut.push_back(leftOutFile(depth, FileKind::DepthImage, {}));
        if (other) {
            leftOut.back().why =
                "is a depth image by its name, but " + other->filename().string() + " is used";
        }
    }
}

void search(const fs::path& folder, const fs::path& relative, const FolderSearch& how,
            FolderContents& found) {
    const std::vector<fs::path> pictures = listImages(folder);
    const std::set<fs::path> readable(pictures.begin(), pictures.end());
    const std::vector<fs::path> entries = entriesOf(folder);
    std::vector<FolderFile> files;
    std::vector<fs::path> depths;
    std::vector<fs::path> folders;
    for (const fs::path& entry : entries) {
        std::error_code error;
        FileKind kind = FileKind::Other;
        if (fs::is_directory(entry, error)) {
            folders.push_back(entry);
            continue;
        }
        if (readable.count(entry) > 0) {
            kind = kindOfPicture(entry, how);
        } else if (isVideoFileName(entry)) {
            kind = kindOfVideo(entry, entries);
        }
        if (how.wanted.count(kind) > 0) {
            files.push_back({entry, {}, relative});
        } else if (kind == FileKind::DepthImage) {
            depths.push_back(entry);
        } else {
            found.leftOut.push_back(leftOutFile(entry, kind, entries));
        }
    }
    pairDepthImages(depths, files, found.leftOut);
    found.files.insert(found.files.end(), files.begin(), files.end());
    for (const fs::path& subfolder : folders) {
        const bool isOutput = std::any_of(how.outputs.begin(), how.outputs.end(),
                                          [&subfolder](const fs::path& output) {
                                              std::error_code error;
                                              return fs::equivalent(subfolder, output, error);
                                          });
        if (isOutput) continue;
        std::error_code error;
        if (how.recursive && !fs::is_symlink(subfolder, error)) {
            search(subfolder, relative / subfolder.filename(), how, found);
            continue;
        }
        found.leftOut.push_back(leftOutFile(subfolder, FileKind::Folder, entries));
        if (how.recursive) found.leftOut.back().why = "is a link to a folder";
    }
}

} // namespace

const std::vector<std::string>& videoEndings() {
    static const std::vector<std::string> endings = {".mp4", ".m4v", ".mov",  ".mkv", ".webm",
                                                     ".avi", ".mpg", ".mpeg", ".ts",  ".mts",
                                                     ".3gp", ".ogv", ".wmv",  ".flv"};
    return endings;
}

bool isVideoFileName(const fs::path& file) {
    const std::vector<std::string>& endings = videoEndings();
    return std::find(endings.begin(), endings.end(), lowerCase(file.extension().string())) !=
           endings.end();
}

FolderContents searchFolder(const fs::path& folder, const FolderSearch& how) {
    FolderContents found;
    search(folder, {}, how, found);
    return found;
}

std::vector<std::string> outputStems(const std::vector<FolderFile>& files) {
    std::map<std::string, int> uses;
    std::set<std::string> names;
    for (const FolderFile& file : files) {
        ++uses[(file.folder / file.file.stem()).string()];
        names.insert((file.folder / file.file.filename()).string());
    }
    std::vector<std::string> stems;
    for (const FolderFile& file : files) {
        const std::string stem = (file.folder / file.file.stem()).string();
        const bool isFree = uses[stem] == 1 && names.count(stem) == 0;
        stems.push_back(isFree ? stem : (file.folder / file.file.filename()).string());
    }
    return stems;
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
