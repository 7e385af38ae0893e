#pragma once

#include <chrono>
#include <filesystem>
#include <string>

/// Folders of work in progress, on file systems that many machines share.
namespace altiro3D {

/// A folder beside its final name. It is removed unless it is renamed. Its name states the machine
/// and the process: "000007.host-123-456".
class WorkFolder {
  public:
    /// @param target the final name @throws Error WriteFailed
    explicit WorkFolder(const std::filesystem::path& target);
    ~WorkFolder();
    WorkFolder(const WorkFolder&) = delete;
    WorkFolder& operator=(const WorkFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    /// Sets the time of the folder to now, at most once a minute, so that removeStale() of other
    /// machines leaves it alone. Call it often.
    void showLife();
    /// Renames the folder to its target. @return false if the target exists
    /// @throws Error WriteFailed
    bool finish();
    /// Moves another folder out of the way of finish().
    void moveAway();
    /// Removes the work folders beside this one whose processes were killed: on this machine, if
    /// the process does not exist; on any, if the folder has shown no life for an hour before this
    /// one was made, by the clock of the file system. A process whose folder is removed by mistake
    /// fails, and can be repeated. Failures are ignored.
    /// @param target name of their targets: "000007"; empty: all
    void removeStale(const std::string& target) const;

  private:
    std::filesystem::path target_;
    std::filesystem::path path_;
    std::chrono::steady_clock::time_point shown_;
};

} // namespace altiro3D
