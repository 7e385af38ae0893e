#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

/// What a folder of photos, quilts or videos holds.
namespace altiro3D::tools {

/// What a file of a folder is, by its name and its mark.
enum class FileKind {
    Photo,      ///< A picture that is none of the following.
    DepthImage, ///< Of a photo, see photoOfDepthName().
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
    Folder,
    Other
};

/// A file of a folder that a tool converts.
struct FolderFile {
    std::filesystem::path file;
    std::filesystem::path depth;  ///< The depth image beside it; empty: none.
    std::filesystem::path folder; ///< Of the file, relative to the folder that was searched.
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
/// Whether a file name has one of them, in upper or lower case.
bool isVideoFileName(const std::filesystem::path& file);

/// Sorts the files of a folder. Natives are told by their mark, quilts, depth images and what is
/// for headsets by their names, clips of Live Photos by the photo of the same name, all others by
/// their extension.
/// @throws Error as listImages()
FolderContents searchFolder(const std::filesystem::path& folder, const FolderSearch& search);

/// A depth image that no photo takes.
struct SpareDepth {
    std::filesystem::path file;
    std::filesystem::path taken; ///< The depth image that its photo has; empty: there is no photo.
};

/// Gives each photo the first depth image of its name, see photoOfDepthName(): that of a.jpg is
/// a-depth.png in the same folder. @return the other depth images
std::vector<SpareDepth> pairDepthImages(const std::vector<std::filesystem::path>& depths,
                                        std::vector<FolderFile>& photos);

/// A name for the outputs of each file, without extension, in its subfolder: that of the file, with
/// its extension if another file would have the same. The files of one folder have different ones.
std::vector<std::string> outputStems(const std::vector<FolderFile>& files);

/// "3 .heic files, 1 video"
std::string kindsText(const std::vector<LeftOutFile>& files);

} // namespace altiro3D::tools
