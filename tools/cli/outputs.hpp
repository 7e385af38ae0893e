#pragma once

#include "altiro3D/image_io.hpp"

#include "cli/run_tool.hpp"

#include <filesystem>
#include <map>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace altiro3D::tools {

/// A name made of a text from a file, such as a serial number: not a path or an option, without
/// characters that a shell, a terminal or a file system interprets.
std::string inFileName(std::string text);

/// As writeImage(); on standard output, a PNG.
void writePicture(const std::filesystem::path& file, const cv::Mat& picture,
                  ImageMark mark = ImageMark::None);

/// Refuses to write a picture or video to a terminal. @throws UsageError
void requireNoTerminal(const std::filesystem::path& file);

/// The inputs and outputs of a run, checked before any work: no output is an input, no two outputs
/// are the same file, and existing files are replaced only with the user's consent.
class Outputs {
  public:
    /// @param replace existing files may be replaced (`-y`)
    explicit Outputs(bool replace) : replace_(replace) {}

    using Files = std::vector<std::filesystem::path>; ///< Without those of empty names.
    /// Adds files that are read. They may be names of networks or missing; opening them reports
    /// that. Standard input is left out.
    void addInputs(const Files& files) { add(files, inputs_); }
    /// Adds files that are written. Standard output is refused.
    void addOutputs(const Files& files) { add(files, outputs_); }
    /// Adds the result of the run, which may go to standard output.
    void addResult(const std::filesystem::path& file) {
        if (!isStandardStream(file)) addOutputs({file});
    }

    /// Adds the Native that will be written. If a PNG file of that name exists and is not marked as
    /// a Native, the names may be in the wrong order; the message about the file says so.
    void addNative(const std::filesystem::path& file);

    /// Adds a directory for outputs; makeDirectories() creates it if it does not exist.
    void addDirectory(const std::filesystem::path& directory) { directories_.push_back(directory); }

    /// Adds the file of a folder and its output, whose folder will be created.
    void addPair(const std::filesystem::path& input, const std::filesystem::path& output) {
        addInputs({input});
        addDirectory(output.parent_path());
        addOutputs({output});
    }

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
    static void add(const Files& files, Files& all) {
        for (const std::filesystem::path& file : files)
            if (!file.empty()) all.push_back(file);
    }
    std::string existText(const Files& files) const;

    bool replace_;
    std::map<std::filesystem::path, std::string> why_;
    Files inputs_;
    Files outputs_;
    Files directories_;
};

/// Refuses a file name whose format cannot hold the picture.
/// @param colours true if the picture has colours @throws UsageError
void requirePictureName(const std::filesystem::path& file, bool colours = true);

/// Refuses a file name whose format cannot hold a video. @throws UsageError
void requireVideoName(const std::filesystem::path& file);

/// Refuses a file name that splats are not written to; an empty one is none. @throws UsageError
void requireSplatName(const std::filesystem::path& file);

/// The file name of one of `views` views: "view_07.png".
std::string viewFileName(int view, int views);

/// Warns if the file format does not preserve a Native's sub-pixels.
void warnAboutNativeFormat(const std::filesystem::path& file, Messages& messages);

/// Warns if the file format mixes the pictures of both eyes: coloured or interlaced ones.
void warnAboutEyesFormat(const std::filesystem::path& file, Messages& messages);

/// Warns if the file format stores a depth map with less precision than another one would.
void warnAboutDepthFormat(const std::filesystem::path& file, Messages& messages);

} // namespace altiro3D::tools
