#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace altiro3D::tools {

/// The inputs and outputs of a run, checked before any work: no output is an input, no two outputs
/// are the same file, and existing files are replaced only with the user's consent.
class Outputs {
  public:
    /// @param replace existing files may be replaced (`-y`)
    explicit Outputs(bool replace) : replace_(replace) {}

    /// Adds a file that is read. It may be a network's name or missing; opening it reports that.
    void addInput(const std::filesystem::path& file) { inputs_.push_back(file); }
    /// Adds a file that will be written.
    void addOutput(const std::filesystem::path& file) { outputs_.push_back(file); }

    /// Adds the Native that will be written. If a PNG file of that name exists and is not marked as
    /// a Native, the names may be in the wrong order; the message about the file says so.
    void addNative(const std::filesystem::path& file);

    /// Adds a directory for outputs; makeDirectories() creates it if it does not exist.
    void addDirectory(const std::filesystem::path& directory) { directories_.push_back(directory); }

    /// Sets the end of the message for an output that exists: "and ...".
    void explainExisting(const std::filesystem::path& file, const std::string& why) {
        why_[file] = ", " + why;
    }

    /// Checks all names. If a file exists and `-y` was not given, asks on a terminal.
    /// @throws UsageError (output = input, two outputs = one file), Error (exists, no directory)
    void check() const;
    /// Creates the directories; call it after all checks, immediately before the work.
    /// @throws Error WriteFailed
    void makeDirectories() const;

  private:
    std::string existText(const std::vector<std::filesystem::path>& files) const;

    bool replace_;
    std::map<std::filesystem::path, std::string> why_;
    std::vector<std::filesystem::path> inputs_;
    std::vector<std::filesystem::path> outputs_;
    std::vector<std::filesystem::path> directories_;
};

/// Reports a missing input. Call it before any check of outputs, because the names may be in the
/// wrong order. @throws Error NotFound
void requireFile(const std::filesystem::path& file);

/// Refuses a file name whose format cannot hold the picture.
/// @param colours true if the picture has colours @throws UsageError
void requirePictureName(const std::filesystem::path& file, bool colours = true);

/// Refuses a file name whose format cannot hold a video. @throws UsageError
void requireVideoName(const std::filesystem::path& file);

/// The file name of one of `views` views: "view_07.png".
std::string viewFileName(int view, int views);

} // namespace altiro3D::tools
