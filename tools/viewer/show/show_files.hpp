#pragma once

#include "viewer/model/document.hpp"

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace altiro3D::viewer {

/// Sizes and times of files: another text means that the contents have changed.
using FileStamps = std::map<std::filesystem::path, std::string>;

/// Tells files that are still being written: their size or time has changed within kSeconds.
class SteadyFiles {
  public:
    static constexpr double kSeconds = 2;

    /// @param stamps those of all files; at the first call all of them are steady
    /// @param now s, from any start
    /// @return the files that are steady
    std::set<std::filesystem::path> look(const FileStamps& stamps, double now);
    /// Whether some were not steady at the last look.
    bool isWaiting() const { return isWaiting_; }

  private:
    struct Known {
        std::string stamp;
        double since; // s
    };
    std::map<std::filesystem::path, Known> known_;
    bool hasLooked_ = false;
    bool isWaiting_ = false;
};

/// The files of a show: those that were named, and what the named folders hold now, by the rules of
/// photo2native's folders.
class ShowFiles {
  public:
    /// What does not exist and what is left out becomes a note.
    /// @param names files and folders
    /// @throws Error NotFound (there is nothing to show), ReadFailed, and as searchFolder()
    explicit ShowFiles(const std::vector<std::filesystem::path>& names);

    /// In the order of the names, those of a folder in natural order.
    const std::vector<Source>& files() const { return files_; }
    const std::vector<std::filesystem::path>& folders() const { return folders_; }
    const Notes& notes() const { return notes_; }

    /// Reads the folders again if they have changed. Files that have gone leave. Those that are
    /// being written stay out until they are steady, and come back with their new contents.
    /// @param now s, from any start
    /// @return false if such a file waits: call it again
    bool refresh(double now);

  private:
    std::vector<std::filesystem::path> names_;
    std::vector<std::filesystem::path> folders_;
    std::vector<Source> files_;
    Notes notes_;
    FileStamps stamps_; // of the last refresh()
    SteadyFiles steady_;
};

} // namespace altiro3D::viewer
