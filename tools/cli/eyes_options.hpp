#pragma once

#include "altiro3D/image_io.hpp"
#include "altiro3D/quilt.hpp"
#include "altiro3D/stereo_views.hpp"
#include "cli/run_tool.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D::tools {

/// How pictures or videos for two eyes are made.
struct EyesOptions {
    EyesPicture picture = EyesPicture::SideBySide;
    bool areFiles = false; ///< Two pictures, each of one eye.
    EyesFrom from = EyesFrom::Both;
    bool swapped = false;
    double strengthPercent = kEyesStrength; ///< `--strength`; its default is that of displays.
};

/// --stereo-layout --stereo-keep --stereo-swap
/// @param output the option that asks for the file @param files whether the layout "files" exists
/// @param keep whether --stereo-keep exists
void addEyesOptions(CommandLine& commandLine, const std::string& output, bool files,
                    bool keep = true);
/// @param output, files as above; without `output`, the others are refused
/// @throws UsageError
EyesOptions eyesOptions(const CommandLine& commandLine, const std::string& output,
                        bool files = false);

/// The end of the names of such files: "_LRF.png".
std::string eyesEnding(const EyesOptions& options);
/// Both eyes in one picture, as the options say.
cv::Mat joinedEyes(const StereoPair& eyes, const EyesOptions& options);
/// A sentence that says which tag players look for, if a name lacks it; else empty.
std::string eyesTagAdvice(const std::filesystem::path& file, const EyesOptions& options);
/// Says it.
void tellEyesTag(const std::filesystem::path& file, const EyesOptions& options,
                 const Messages& messages);

/// The views of a quilt that the left and the right eye see: an eighth of the cone to the left and
/// to the right. That is the distance of eyes if the outermost views have the usual parallax.
std::pair<int, int> viewsOfEyes(const QuiltLayout& layout);
/// Their pictures with square px. @param aspect width : height of a view as it is shown
StereoPair eyesOfQuilt(const cv::Mat& quilt, const QuiltLayout& layout, double aspect);

/// --save-stereo FILE: a picture for two eyes, or one for each.
class EyesFiles {
  public:
    /// --save-stereo and addEyesOptions(). @param of the last sentence of its help
    static void add(CommandLine& commandLine, const std::string& of, bool keep = true);
    EyesFiles() = default;
    /// @throws UsageError
    explicit EyesFiles(const CommandLine& commandLine);
    /// The same for another file.
    EyesFiles(const EyesFiles& same, std::filesystem::path file);

    const EyesOptions& options() const { return options_; }
    const std::filesystem::path& name() const { return file_; } ///< As given; empty: none.
    std::string ending() const {
        return eyesEnding(options_);
    } ///< The names of files in a folder end so.
    /// The files to write: none, one, or those of the left and the right eye.
    std::vector<std::filesystem::path> files() const;
    /// Their names, for people.
    std::string names() const;
    /// What they are, for people: "side by side".
    const char* words() const {
        return options_.areFiles ? "the pictures of both eyes" : nameOf(options_.picture).words;
    }
    /// Writes them. Says which tag players look for. @throws Error
    void write(const StereoPair& eyes, Messages& messages) const;

  private:
    EyesOptions options_;
    std::filesystem::path file_;
};

} // namespace altiro3D::tools
