#pragma once

#include "cli/command_line.hpp"
#include "cli/run_tool.hpp"

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <vector>

/// What a folder of photos, quilts or videos holds, and the run of a tool over many files.
namespace altiro3D::tools {

/// What a file of a folder is, by its name and its mark.
enum class FileKind {
    Photo,      ///< A picture that is none of the following.
    DepthImage, ///< The depth of a photo, see photoOfDepthName().
    Native,     ///< A picture that is marked as one.
    Quilt,
    Video,
    DepthVideo,
    NativeVideo, ///< Only its frames tell.
    QuiltVideo,
    HalvesVideo, ///< Frames hold both eyes, or photo and depth; only they tell.
    Vr,          ///< A picture or video for headsets, by its name.
    WithDepth,   ///< A photo that photo2native saved with its depth, beside the photo itself.
    LiveClip,    ///< The video of a Live Photo, beside the photo of the same name.
    Splats,      ///< A scene of Gaussian splats, by its name.
    Folder,
    SystemFolder, ///< Thumbnails, trash and the like, by its name.
    Other
};

/// A file of a folder that a tool converts.
struct FolderFile {
    std::filesystem::path file;
    std::filesystem::path depth{}; ///< The depth image beside it; empty: none.
    /// Where the file lies, relative to the folder that was searched.
    std::filesystem::path folder{};
};

/// A file of a folder that is not converted.
struct LeftOutFile {
    std::filesystem::path file;
    FileKind kind;
    std::string why; ///< For people: "is a video; video2native makes Natives of videos".
};

/// All that a folder holds, except hidden files; in natural order of names.
struct FolderContents {
    std::vector<FolderFile> files;
    std::vector<LeftOutFile> leftOut;
};

/// How a folder is searched.
struct FolderSearch {
    std::set<FileKind> wanted = {FileKind::Photo}; ///< What is converted.
    bool recursive = false;                        ///< Also its subfolders.
    bool pairDepth = true;                         ///< Find the depth images of photos.
    bool leavesOutVr = true;                       ///< Pictures whose names say VR are left out.
    std::vector<std::filesystem::path> outputs;    ///< Subfolders that are not searched.
};

/// Extensions of the videos that folders are searched for, with the dot, in lower case.
const std::vector<std::string>& videoEndings();
bool isVideoFileName(const std::filesystem::path& file);

/// Sorts the files of a folder. Natives are told by their mark, quilts, depth images and what is
/// for headsets by their names, clips of Live Photos by the photo of the same name, all others by
/// their extension.
/// @throws Error as listImages()
FolderContents searchFolder(const std::filesystem::path& folder, const FolderSearch& search);

/// A depth image, or the picture of a right eye, and what it belongs to by its name.
struct NamedDepth {
    std::filesystem::path file;
    std::filesystem::path photo; ///< Without extension.
};

/// A depth image that no photo takes.
struct SpareDepth {
    std::filesystem::path file;
    std::string why; ///< "a-depth.png is used"; empty: there is no photo of its name.
};

/// Gives each photo the first depth image of its name, else one of a comparableName() that fits one
/// photo only.
/// @return the other depth images
std::vector<SpareDepth> pairDepthImages(const std::vector<NamedDepth>& depths,
                                        std::vector<FolderFile>& photos);

/// A name for the outputs of each file, without extension, in its subfolder: that of the file, with
/// its extension if another file would have the same. The files of one folder have different ones.
std::vector<std::string> outputStems(const std::vector<FolderFile>& files);

/// "3 .heic files, 1 video"
std::string kindsText(const std::vector<LeftOutFile>& files);

/// --recursive @param things "photos"
void addRecursiveOption(CommandLine& commandLine, const std::string& things);

/// Searches a folder and says what is left out, which `leftOut` receives.
/// @return what is to be converted @throws Error as searchFolder()
std::vector<FolderFile> listFiles(const std::filesystem::path& folder, const FolderSearch& search,
                                  std::vector<LeftOutFile>& leftOut, Messages& messages);

/// The files that are named, and those of the folders among the names.
/// @param expected for the error: "no pictures, expected quilts"
/// @throws Error as listFiles(), NotFound (there are none)
std::vector<FolderFile> listNamed(const std::vector<std::filesystem::path>& names,
                                  const FolderSearch& search, std::vector<LeftOutFile>& leftOut,
                                  const std::string& expected, Messages& messages);

/// Refuses an output that names one file. @throws UsageError
/// @param things "photos" @param remedy further help, or nothing
void requireDirectoryName(const std::filesystem::path& name, const std::string& things,
                          const std::string& remedy = {});

bool isFileWithContents(const std::filesystem::path& file);

/// Thrown for a file of a folder that turns out to be something else than its name says.
struct NotTaken {
    LeftOutFile file;
};

/// A file of a run over many.
struct FolderItem {
    std::filesystem::path input;
    std::filesystem::path output;
    bool isMade = false; ///< Its outputs exist already; it is skipped.
};

/// How a file of such a run ended.
struct FolderEnd {
    bool isSkipped = false;
    std::string leftOut; ///< Why it is not converted; empty: it is.
    std::string error;   ///< Why it failed, if an exception says so.
    std::string code;    ///< The code of `error`.

    /// Adds it to the list of a report, unless it was converted: its work has added more.
    /// @param key of the file's name
    void addTo(nlohmann::ordered_json& list, const char* key, const FolderItem& item) const;
};

/// A failure, as the end of a file. @param error the exception
FolderEnd failedEnd(const std::exception& error);

/// Converts one file that was named; a failure is thrown.
/// @param thing "photo", for the progress @param make converts it
/// @param notMade is called if it is skipped or fails
/// @param json write the progress as JSON
/// @return exit status: success, or the user's stop
int convertOne(const std::string& thing, const FolderItem& item, const std::function<void()>& make,
               const std::function<void(const FolderEnd&)>& notMade, Messages& messages, bool json);

/// Converts files one after the other until the user stops (Ctrl-C, SIGTERM): one that fails does
/// not stop the rest, and the end counts what was made, skipped, left out and failed. Messages
/// begin with the name of the file.
class FolderRun {
  public:
    /// @param thing "photo", for the summary
    /// @param leftOut what the search left out already
    /// @param json write the progress as JSON
    FolderRun(std::string thing, std::vector<LeftOutFile> leftOut, Messages& messages,
              bool json = false);

    /// @param work converts the file of an index; returns an exit status, or throws NotTaken,
    ///        Stopped or an exception that means failure
    /// @param ended receives how each file has ended
    /// @return the exit status: that of the user's stop, failure, or success
    int convert(const std::vector<FolderItem>& items, const std::function<int(std::size_t)>& work,
                const std::function<void(std::size_t, const FolderEnd&)>& ended);
    /// Whether a file failed for a reason that another run may not have: a full disk, no memory.
    bool mayRecover() const { return mayRecover_; }
    /// Number of files that were begun, from 1, and of all: "[2/7]".
    std::string place() const {
        return "[" + std::to_string(begun_) + "/" + std::to_string(files_) + "]";
    }

  private:
    FolderEnd convert(const std::filesystem::path& file, const std::function<int()>& work);
    std::string summary() const;

    std::string thing_;
    bool json_;
    Messages& messages_;
    std::vector<LeftOutFile> leftOut_;
    std::size_t files_ = 0; // to convert
    std::size_t begun_ = 0;
    std::size_t made_ = 0;
    std::size_t skipped_ = 0;
    std::size_t failed_ = 0;
    std::size_t stopped_ = 0;
    bool mayRecover_ = false;
};

} // namespace altiro3D::tools
