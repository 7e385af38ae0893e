#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace altiro3D::tools {

/// What a run reads and writes, checked before any work is done: no output is an input, no two
/// outputs are one file, and what exists is replaced only if the user wants it.
class Outputs {
  public:
    /// @param replace existing files may be replaced (`-y`)
    explicit Outputs(bool replace) : replace_(replace) {}

    /// A file that is read; it may be a network's name, or missing: whoever opens it says so.
    void addInput(const std::filesystem::path& file) { inputs_.push_back(file); }
    /// A file that will be written.
    void addOutput(const std::filesystem::path& file) { outputs_.push_back(file); }

    /// The Native that will be written: a PNG file in its place that is not marked as one may be an
    /// input, where names are in the wrong order, and that is said.
    void addNative(const std::filesystem::path& file);

    /// A directory that outputs go into; makeDirectories() makes it if it is not there.
    void addDirectory(const std::filesystem::path& directory) { directories_.push_back(directory); }

    /// What else is to be said of an output if it exists: "and ...".
    void explainExisting(const std::filesystem::path& file, const std::string& why) {
        why_[file] = ", " + why;
    }

    /// Checks all of it; asks on a terminal where a file exists and `-y` was not given.
    /// @throws UsageError (output = input, two outputs in one), Error (exists, no directory)
    void check() const;
    /// Makes the directories; call it when nothing but the work itself can fail any more.
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

/// Says that an input is missing before anything is said about outputs: names may be in the wrong
/// order. @throws Error NotFound
void requireFile(const std::filesystem::path& file);

/// Refuses a file name that no picture can be written to.
/// @param colours the picture has colours @throws UsageError
void requirePictureName(const std::filesystem::path& file, bool colours = true);

/// Refuses a file name that no video can be written to. @throws UsageError
void requireVideoName(const std::filesystem::path& file);

/// The name of a view among `views` in a directory of its own: "view_07.png".
std::string viewFileName(int view, int views);

} // namespace altiro3D::tools
