#include "viewer/show/show_files.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "cli/folder_search.hpp"

#include <algorithm>
#include <optional>
#include <system_error>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

tools::FolderContents contentsOf(const fs::path& folder) {
    using tools::FileKind;
    tools::FolderSearch how;
    how.wanted = {FileKind::Photo, FileKind::Quilt, FileKind::Native, FileKind::Video,
                  FileKind::QuiltVideo};
    return tools::searchFolder(folder, how);
}

FileStamps stampsOf(const std::vector<fs::path>& folders) {
    FileStamps stamps;
    for (const fs::path& folder : folders) {
        std::error_code error;
        fs::directory_iterator entry(folder, error);
        while (!error && entry != fs::directory_iterator()) {
            stamps[entry->path()] = fileStamp(entry->path());
            entry.increment(error);
        }
    }
    return stamps;
}

} // namespace

std::set<fs::path> SteadyFiles::look(const FileStamps& stamps, double now) {
    std::map<fs::path, Known> known;
    std::set<fs::path> steady;
    isWaiting_ = false;
    for (const auto& [file, stamp] : stamps) {
        Known entry{stamp, hasLooked_ ? now : now - kSeconds};
        const auto before = known_.find(file);
        if (before != known_.end() && before->second.stamp == stamp)
            entry.since = before->second.since;
        if (now - entry.since >= kSeconds) {
            steady.insert(file);
        } else {
            isWaiting_ = true;
        }
        known.emplace(file, entry);
    }
    known_.swap(known);
    hasLooked_ = true;
    return steady;
}

ShowFiles::ShowFiles(const std::vector<fs::path>& names) {
    std::optional<Error> problem; // the first one
    const auto leaveOut = [&](const Error& error) {
        if (!problem) problem = error;
        notes_.push_back({NoteCode::LeftOut, error.what()});
    };
    for (const fs::path& name : names) {
        std::error_code error;
        const bool exists = fs::exists(name, error);
        if (error) {
            leaveOut({ErrorCode::ReadFailed, name.string(), "cannot be read: " + error.message()});
        } else if (!exists) {
            leaveOut({ErrorCode::NotFound, name.string(),
                      "does not exist, expected a file or a folder"});
        } else if (!fs::is_directory(name, error)) {
            names_.push_back(name);
        } else {
            names_.push_back(name);
            folders_.push_back(name);
            const tools::FolderContents found = contentsOf(name);
            if (found.files.empty()) {
                leaveOut({ErrorCode::NotFound, name.string(),
                          "holds no pictures and no videos, expected some"});
            } else if (!found.leftOut.empty()) {
                notes_.push_back({NoteCode::LeftOut, name.string() + ": not opened: " +
                                                         tools::kindsText(found.leftOut)});
            }
        }
    }
    static_cast<void>(refresh(0));
    if (files_.empty() && problem) throw Error(*problem);
}

bool ShowFiles::refresh(double now) {
    FileStamps stamps = stampsOf(folders_);
    const bool wasWaiting = steady_.isWaiting();
    const std::set<fs::path> steady = steady_.look(stamps, now);
    if (stamps == stamps_ && !wasWaiting && !files_.empty()) return true;
    stamps_ = std::move(stamps);
    std::vector<Source> files;
    std::vector<fs::path> single; // a photo and its depth image may be named one after the other
    const auto addSingle = [&] {
        for (const Source& source : pairUp(single))
            files.push_back(source);
        single.clear();
    };
    for (const fs::path& name : names_) {
        std::error_code error;
        if (std::find(folders_.begin(), folders_.end(), name) == folders_.end()) {
            if (fs::exists(name, error)) single.push_back(name);
            continue;
        }
        addSingle();
        tools::FolderContents found;
        try {
            found = contentsOf(name);
        } catch (const Error&) { // nothing to show now
        }
        for (const tools::FolderFile& file : found.files) {
            if (steady.count(file.file) == 0) continue;
            const bool hasDepth = steady.count(file.depth) > 0;
            files.push_back({file.file, hasDepth ? file.depth : fs::path(), Reading::Automatic});
        }
    }
    addSingle();
    files_ = files;
    return !steady_.isWaiting();
}

} // namespace altiro3D::viewer
