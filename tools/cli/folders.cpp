#include "cli/folders.hpp"

#include "altiro3D/enum_table.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/splats.hpp"
#include "altiro3D/video_io.hpp"
#include "base/image_format.hpp"
#include "cli/inputs.hpp"
#include "cli/json_text.hpp"
#include "cli/outputs.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

// Whether a folder holds copies that systems, disks and programs keep: thumbnails, trash, forks.
bool isSystemFolder(const fs::path& folder) {
    static const std::set<std::string> names = {
        "@eadir",       "#recycle",    "@recycle",     ".@__thumb",
        "$recycle.bin", "recycler",    "__macosx",     "system volume information",
        "lost+found",   ".thumbnails", ".appledouble", ".trashes"};
    const std::string name = lowerCase(folder.filename().string());
    return names.count(name) > 0 || name.rfind(".trash-", 0) == 0;
}

// @param hasHidden also hidden folders of systems
std::vector<fs::path> entriesOf(const fs::path& folder, bool hasHidden) {
    std::vector<fs::path> entries;
    std::error_code error;
    fs::directory_iterator entry(folder, error);
    while (!error && entry != fs::directory_iterator()) {
        const bool isHidden = entry->path().filename().string().rfind('.', 0) == 0;
        if (!isHidden || (hasHidden && isSystemFolder(entry->path()) && isDirectory(entry->path())))
            entries.push_back(entry->path());
        entry.increment(error);
    }
    std::sort(entries.begin(), entries.end(), [](const fs::path& a, const fs::path& b) {
        return naturalLess(a.filename().string(), b.filename().string());
    });
    return entries;
}

// By stem: the files that cameras write as photos, whether or not their format can be read.
using CameraPhotos = std::map<std::u32string, fs::path>;

CameraPhotos cameraPhotos(const std::vector<fs::path>& entries) {
    const std::set<std::string> endings = {".heic", ".heif", ".avif", ".jpg", ".jpeg", ".png"};
    CameraPhotos photos;
    for (const fs::path& entry : entries) {
        if (endings.count(lowerExtension(entry)) > 0)
            photos.emplace(comparableName(entry.stem().string()), entry);
    }
    return photos;
}

// How a kind is counted, and why a file of it is left out.
struct KindWords {
    const char* name;
    const char* why;
};
constexpr std::array<KindWords, 15> kWords = {{
    // as FileKind
    {"photo", "is a picture; photo2native makes Natives of photos"},
    {"depth image", "is a depth image by its name, but its photo is missing"},
    {"Native", "is a Native, which is finished; it is left out"},
    {"quilt", "is a quilt by its name; quilt2native makes Natives of quilts"},
    {"video", "is a video; video2native makes Natives of videos"},
    {"depth video",
     "is the depth of a video by its name; video2native --depth takes it with its video"},
    {"Native video", "is a Native video, which is finished"},
    {"quilt video",
     "is a video of quilts by its name; quilt2native makes a Native of it if it is named itself"},
    {"3D video", "holds both eyes, or photo and depth"},
    {"VR file",
     "is made for headsets (VR) by its name, which is not read; if it is flat, rename it"},
    {"photo saved with depth", "is a photo that was saved with its depth: "},
    {"Live Photo clip", "is the clip of the Live Photo "},
    {"scene of splats", "is a scene of splats by its name; splat2native makes Natives of those"},
    {"folder", "is a folder; --recursive also converts what it holds"},
    {"system folder",
     "is a folder of the system by its name (thumbnails, trash); it is not searched"},
}};

bool isVrName(const fs::path& file) {
    const std::optional<SceneName> name = parseSceneName(file);
    return name && name->contents == SceneName::Contents::Vr;
}

// The photo that a_with_depth.jpg was made of; empty if it is not there.
// @param pictures of the same folder
fs::path originalOf(const fs::path& file, const std::vector<fs::path>& pictures) {
    constexpr std::string_view kEnding = "_with_depth"; // as --save-photo-with-depth names it
    const std::string stem = file.stem().string();
    if (stem.size() <= kEnding.size() || !endsWith(stem, kEnding)) return {};
    const std::u32string name = comparableName(stem.substr(0, stem.size() - kEnding.size()));
    const auto found = std::find_if(pictures.begin(), pictures.end(), [&](const fs::path& picture) {
        return comparableName(picture.stem().string()) == name;
    });
    return found == pictures.end() ? fs::path() : *found;
}

FileKind kindOfPicture(const fs::path& file, const std::vector<fs::path>& pictures,
                       const FolderSearch& how) {
    if (isMarkedNative(file)) return FileKind::Native;
    if (isQuiltName(file)) return FileKind::Quilt;
    if (how.pairDepth && !photoOfDepthName(file).empty()) return FileKind::DepthImage;
    if (how.leavesOutVr && isVrName(file)) return FileKind::Vr;
    if (how.pairDepth && !originalOf(file, pictures).empty()) return FileKind::WithDepth;
    return FileKind::Photo;
}

// The clip of a Live Photo has some 3 s.
bool isBrief(const fs::path& video) {
    constexpr double kMaxSeconds = 5;
    try {
        return VideoReader(video).facts().duration.value_or(0) <= kMaxSeconds;
    } catch (const Error&) {
        return true; // cannot be read, so nothing is lost if it counts as such a clip
    }
}

FileKind kindOfVideo(const fs::path& file, const CameraPhotos& photos) {
    if (isQuiltName(file)) return FileKind::QuiltVideo;
    if (isVrName(file)) return FileKind::Vr;
    if (photos.count(comparableName(file.stem().string())) > 0 && isBrief(file))
        return FileKind::LiveClip;
    return photoOfDepthName(file).empty() ? FileKind::Video : FileKind::DepthVideo;
}

const KindWords* wordsOf(FileKind kind) {
    static_assert(kWords.size() + 1 == enumCount<FileKind>(), "all but Other");
    return kind == FileKind::Other ? nullptr : &kWords[static_cast<std::size_t>(kind)];
}

LeftOutFile leftOutFile(const fs::path& file, FileKind kind) {
    const KindWords* const words = wordsOf(kind);
    if (words == nullptr && isRawExtension(lowerExtension(file)))
        return {file, kind,
                "is a raw picture of a camera, which is not read; export it from a photo program"};
    return {file, kind,
            words != nullptr ? words->why : "is no picture or video of a format that can be read"};
}

// Without the number.
std::string kindText(const LeftOutFile& file) {
    if (const KindWords* const words = wordsOf(file.kind)) return words->name;
    const std::string ending = lowerExtension(file.file);
    if (isRawExtension(ending)) return "raw picture";
    return ending.empty() ? "other file" : ending + " file";
}

void search(const fs::path& folder, const fs::path& relative, const FolderSearch& how,
            FolderContents& found) {
    const std::vector<fs::path> pictures = listImages(folder);
    const std::set<fs::path> readable(pictures.begin(), pictures.end());
    const std::vector<fs::path> entries = entriesOf(folder, how.recursive);
    const CameraPhotos photos = cameraPhotos(entries);
    std::vector<FolderFile> files;
    std::vector<NamedDepth> depths;
    std::vector<fs::path> folders;
    for (const fs::path& entry : entries) {
        FileKind kind = FileKind::Other;
        if (isDirectory(entry)) {
            folders.push_back(entry);
            continue;
        }
        if (readable.count(entry) > 0) {
            kind = kindOfPicture(entry, pictures, how);
        } else if (isVideoFileName(entry)) {
            kind = kindOfVideo(entry, photos);
        } else if (isSplatFileName(entry)) {
            kind = FileKind::Splats;
        }
        if (how.wanted.count(kind) > 0) {
            files.push_back({entry, {}, relative});
        } else if (kind == FileKind::DepthImage) {
            depths.push_back({entry, photoOfDepthName(entry)});
        } else {
            found.leftOut.push_back(leftOutFile(entry, kind));
            if (kind == FileKind::LiveClip)
                found.leftOut.back().why +=
                    photos.at(comparableName(entry.stem().string())).filename().string();
            if (kind == FileKind::WithDepth)
                found.leftOut.back().why +=
                    originalOf(entry, pictures).filename().string() + " is taken";
        }
    }
    for (const SpareDepth& depth : pairDepthImages(depths, files)) {
        found.leftOut.push_back(leftOutFile(depth.file, FileKind::DepthImage));
        if (!depth.why.empty())
            found.leftOut.back().why = "is a depth image by its name, but " + depth.why;
    }
    found.files.insert(found.files.end(), files.begin(), files.end());
    for (const fs::path& subfolder : folders) {
        const bool isOutput = std::any_of(how.outputs.begin(), how.outputs.end(),
                                          [&subfolder](const fs::path& output) {
                                              std::error_code error;
                                              return fs::equivalent(subfolder, output, error);
                                          });
        if (isOutput) continue;
        std::error_code error;
        std::string why;
        if (isSystemFolder(subfolder)) {
            found.leftOut.push_back(leftOutFile(subfolder, FileKind::SystemFolder));
            continue;
        }
        if (how.recursive && fs::is_symlink(subfolder, error)) {
            why = "is a link to a folder";
        } else if (how.recursive) {
            try {
                search(subfolder, relative / subfolder.filename(), how, found);
                continue;
            } catch (const Error& problem) {
                why = std::string("cannot be searched: ") + problem.what();
            }
        }
        found.leftOut.push_back(leftOutFile(subfolder, FileKind::Folder));
        if (!why.empty()) found.leftOut.back().why = why;
    }
}

bool isFailureOfMachine(const std::exception& error) {
    if (const auto* ours = dynamic_cast<const Error*>(&error))
        return ours->code() == ErrorCode::WriteFailed || ours->code() == ErrorCode::OutOfMemory ||
               ours->code() == ErrorCode::NetworkFailed;
    if (const auto* fromOpenCv = dynamic_cast<const cv::Exception*>(&error))
        return fromOpenCv->code == cv::Error::StsNoMem;
    return dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
           dynamic_cast<const std::system_error*>(&error) != nullptr;
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
    return std::find(endings.begin(), endings.end(), lowerExtension(file)) != endings.end();
}

FolderContents searchFolder(const fs::path& folder, const FolderSearch& how) {
    FolderContents found;
    search(folder, {}, how, found);
    return found;
}

std::vector<SpareDepth> pairDepthImages(const std::vector<NamedDepth>& depths,
                                        std::vector<FolderFile>& photos) {
    using Photos = std::vector<FolderFile*>;
    std::map<std::pair<fs::path, std::u32string>, Photos> byName; // in its folder
    const auto named = [&byName](const fs::path& photo) -> Photos& {
        return byName[{photo.parent_path(), comparableName(photo.filename().string())}];
    };
    const auto nameOf = [](const FolderFile* photo) {
        return photo->file.parent_path() / photo->file.stem();
    };
    for (FolderFile& photo : photos)
        named(nameOf(&photo)).push_back(&photo);
    std::vector<SpareDepth> spare;
    for (const bool isEqual : {true, false}) { // comparable names come after equal ones
        for (const NamedDepth& depth : depths) {
            Photos to = named(depth.photo);
            const auto isOther = [&](const FolderFile* photo) {
                return nameOf(photo) != depth.photo;
            };
            const auto equal = std::stable_partition(to.begin(), to.end(), isOther);
            if ((equal != to.end()) != isEqual) continue;
            if (isEqual) to.erase(to.begin(), equal);
            const auto second = std::find_if(to.begin(), to.end(), [&](const FolderFile* photo) {
                return nameOf(photo) != nameOf(to.front());
            });
            const auto textOf = [](const fs::path& file) { return file.filename().string(); };
            if (to.empty()) {
                spare.push_back({depth.file, {}});
            } else if (second != to.end()) {
                spare.push_back({depth.file, textOf(to.front()->file) + " and " +
                                                 textOf((*second)->file) + " could take it"});
            } else if (const fs::path& taken = to.front()->depth; !taken.empty()) {
                spare.push_back({depth.file, textOf(taken) + " is used"});
            } else {
                for (FolderFile* photo : to)
                    photo->depth = depth.file;
            }
        }
    }
    return spare;
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
    std::vector<std::pair<std::string, int>> kinds; // in order of the first file
    for (const LeftOutFile& file : files) {
        const std::string kind = kindText(file);
        auto found = std::find_if(kinds.begin(), kinds.end(),
                                  [&kind](const auto& known) { return known.first == kind; });
        if (found == kinds.end()) found = kinds.insert(found, {kind, 0});
        ++found->second;
    }
    std::string text;
    for (const auto& [kind, count] : kinds)
        text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + kind +
                (count == 1 ? "" : "s");
    return text;
}

void addRecursiveOption(CommandLine& commandLine, const std::string& things) {
    commandLine.addAdvanced({"recursive"},
                            "Also convert the " + things + " in the subfolders of DIR.");
}

std::vector<FolderFile> listFiles(const fs::path& folder, const FolderSearch& search,
                                  std::vector<LeftOutFile>& leftOut, Messages& messages) {
    FolderContents found = searchFolder(folder, search);
    for (const LeftOutFile& file : found.leftOut) {
        const std::string line = file.file.string() + ": " + file.why;
        if (file.kind == FileKind::Native) { // from an earlier run, or a mistake
            messages.warn(line);
        } else {
            messages.say(line);
        }
        leftOut.push_back(file);
    }
    return std::move(found.files);
}

std::vector<FolderFile> listNamed(const std::vector<fs::path>& names, const FolderSearch& search,
                                  std::vector<LeftOutFile>& leftOut, const std::string& expected,
                                  Messages& messages) {
    std::vector<FolderFile> files;
    for (const fs::path& name : names) {
        if (!isDirectory(name)) {
            files.push_back({name});
            continue;
        }
        for (const FolderFile& file : listFiles(name, search, leftOut, messages))
            files.push_back(file);
    }
    if (files.empty())
        throw Error(ErrorCode::NotFound, names.front().string(), "holds " + expected);
    return files;
}

void requireDirectoryName(const fs::path& name, const std::string& things,
                          const std::string& remedy) {
    if (isDirectory(name)) return;
    if (!isThere(name) && !canWriteImage(name) && !canWriteVideo(name)) return;
    throw UsageError(name.string() +
                     ": names one file, expected a directory for the outputs of several " + things +
                     remedy);
}

bool isFileWithContents(const fs::path& file) {
    std::error_code error;
    return fs::is_regular_file(file, error) && fs::file_size(file, error) > 0 && !error;
}

void FolderEnd::addTo(nlohmann::ordered_json& list, const char* key, const FolderItem& item) const {
    const std::string file = item.input.string();
    if (isSkipped) list.push_back({{key, file}, {"skipped", true}});
    if (!leftOut.empty()) list.push_back({{key, file}, {"leftOut", leftOut}});
    if (!error.empty()) list.push_back({{key, file}, {"error", error}, {"code", code}});
}

FolderEnd failedEnd(const std::exception& error) {
    FolderEnd end;
    end.error = sentenceOf(error);
    end.code = codeOf(error);
    return end;
}

int convertOne(const std::string& thing, const FolderItem& item, const std::function<void()>& make,
               const std::function<void(const FolderEnd&)>& notMade, Messages& messages,
               bool json) {
    const std::string output = nameOf(item.output, "standard output");
    if (item.isMade) {
        messages.say(item.input.string() + ": skipped, as " + output + " exists");
        FolderEnd end;
        end.isSkipped = true;
        notMade(end);
        return kExitDone;
    }
    Progress progress(1, json ? thing : std::string()); // only as JSON
    progress.step(item.input.string(), item.input);
    catchStop();
    try {
        make();
        progress.end(kExitDone, 1);
        return kExitDone;
    } catch (const Stopped&) {
        messages.dropWarnings();
        messages.warn("stopped; " + output + " was not made");
        progress.end(kExitStopped, 0);
        return kExitStopped;
    } catch (const std::exception& error) {
        notMade(failedEnd(error));
        progress.end(kExitFailed, 0);
        throw;
    }
}

FolderRun::FolderRun(std::string thing, std::vector<LeftOutFile> leftOut, Messages& messages,
                     bool json)
    : thing_(std::move(thing)), json_(json), messages_(messages), leftOut_(std::move(leftOut)) {
    messages.flushWarnings(); // these belong to no file
}

int FolderRun::convert(const std::vector<FolderItem>& items,
                       const std::function<int(std::size_t)>& work,
                       const std::function<void(std::size_t, const FolderEnd&)>& ended) {
    const auto start = std::chrono::steady_clock::now();
    files_ = static_cast<std::size_t>(std::count_if(
        items.begin(), items.end(), [](const FolderItem& item) { return !item.isMade; }));
    Progress progress(files_, json_ ? thing_ : std::string());
    catchStop();
    for (std::size_t i = 0; i < items.size() && !isStopWanted(); ++i) {
        const std::string name = items[i].input.filename().string();
        FolderEnd end;
        if (items[i].isMade) {
            messages_.detail(name + ": skipped, as " + items[i].output.string() + " exists");
            end.isSkipped = true;
            ++skipped_;
        } else {
            progress.step(name, items[i].input);
            end = convert(items[i].input, [&] { return work(i); });
        }
        ended(i, end);
    }
    const int status = stopped_ > 0 || isStopWanted() ? kExitStopped
                       : failed_ == 0                 ? kExitDone
                                                      : kExitFailed;
    progress.end(status, made_);
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    messages_.say(summary() + ", in " + fixed(spent.count(), spent.count() < 10 ? 1 : 0) + " s");
    return status;
}

FolderEnd FolderRun::convert(const fs::path& file, const std::function<int()>& work) {
    FolderEnd end;
    ++begun_;
    messages_.setSubject(file.filename().string());
    try {
        const int status = work();
        ++(status == kExitDone ? made_ : status == kExitStopped ? stopped_ : failed_);
        messages_.flushWarnings();
    } catch (const NotTaken& other) {
        messages_.dropWarnings();
        messages_.say(other.file.why);
        leftOut_.push_back(other.file);
        end.leftOut = other.file.why;
    } catch (const Stopped&) {
        messages_.dropWarnings();
        ++stopped_;
    } catch (const std::exception& error) {
        end = failedEnd(error);
        messages_.dropWarnings();
        messages_.fail(end.error);
        ++failed_;
        mayRecover_ = mayRecover_ || isFailureOfMachine(error);
    }
    messages_.setSubject({});
    return end;
}

std::string FolderRun::summary() const {
    std::string text = counted(made_, thing_) + " made";
    const auto add = [&text](std::size_t count, const std::string& what) {
        if (count > 0) text += ", " + std::to_string(count) + " " + what;
    };
    add(skipped_, "skipped as the outputs exist");
    add(stopped_, "stopped");
    add(files_ - begun_, "not begun");
    add(failed_, "failed");
    add(leftOut_.size(), "left out (" + kindsText(leftOut_) + ")");
    return text;
}

} // namespace altiro3D::tools
