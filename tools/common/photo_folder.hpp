#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// What a folder of photos holds.
namespace altiro3D::tools {

/// A photo of a folder.
struct FolderPhoto {
    std::filesystem::path photo;
    std::filesystem::path depth;  ///< The depth image beside it; empty: none.
    std::filesystem::path folder; ///< Of the photo, relative to the folder that was searched.
};

/// A file of a folder that is not a photo to convert.
struct LeftOutFile {
    std::filesystem::path file;
    std::string kind; ///< For counting: "video", ".heic file".
    std::string why;  ///< For people: "is a video; video2native makes Natives of videos".
};

/// All that a folder holds, except hidden files; in natural order of names.
struct PhotoFolder {
    std::vector<FolderPhoto> photos;
    std::vector<LeftOutFile> leftOut;
};

/// How a folder is searched.
struct FolderSearch {
    bool recursive = false;                     ///< Also its subfolders.
    bool pairDepth = true;                      ///< Find the depth images of photos by their names.
    std::vector<std::filesystem::path> outputs; ///< Subfolders that are not searched.
};

/// Sorts the files of a folder. Natives are told by their mark, quilts and depth images by their
/// names, clips of Live Photos by the photo of the same name, all others by their extension.
/// @throws Error as listImages()
PhotoFolder searchFolder(const std::filesystem::path& folder, const FolderSearch& search);

/// "3 .heic files, 1 video"
std::string kindsText(const std::vector<LeftOutFile>& files);

} // namespace altiro3D::tools
