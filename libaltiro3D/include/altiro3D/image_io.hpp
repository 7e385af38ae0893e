#pragma once

#include "altiro3D/export.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace altiro3D {

/// Remarks a reader makes about a file that it could use all the same ("the file is cut off ...").
using Notes = std::vector<std::string>;

/// Pictures with more pixels than this are refused from their header, before memory is taken.
constexpr double kMaxPicturePixels = 4.0e8;

/// Reads a picture upright (EXIF orientation applied), with its full bit depth.
///
/// Grey, palette, CMYK and alpha pictures become BGR; what is transparent becomes black. The format
/// is told by the contents, not by the name. Sides are limited to 65500 px. Colour profiles and PNG
/// gamma are not applied. The codecs inside OpenCV may print warnings on stderr by themselves.
///
/// @param path PNG, JPEG (also MPO: its first picture), TIFF, WebP, BMP, PNM/PFM, EXR, HDR or
///        JPEG 2000
/// @param notes if given, remarks are added (a cut-off JPEG, several pages, ...)
/// @return [rows x cols, CV_8UC3, CV_16UC3 or CV_32FC3, BGR]
/// @throws Error NotFound, ReadFailed, Unsupported (GIF, PCX, HEIC, ... by name), TooLarge,
///         BadFormat, OutOfMemory
ALTIRO3D_EXPORT cv::Mat readPicture(const std::filesystem::path& path, Notes* notes = nullptr);

/// Reads a photo: readPicture() brought to 8 bits (16-bit values are divided by 257 and rounded,
/// float ones are clamped to 0..1).
///
/// @param path as for readPicture()
/// @param notes as for readPicture()
/// @return [rows x cols, CV_8UC3, BGR]
/// @throws Error as readPicture()
ALTIRO3D_EXPORT cv::Mat readPhoto(const std::filesystem::path& path, Notes* notes = nullptr);

/// The focal length that a photo's EXIF gives for a 35 mm camera with the same view, in mm. Reads
/// the file once more; a pipe, which gives its bytes once, is left alone.
///
/// @param path as for readPicture(); a file of another kind does not say
/// @return mm; 0 if the file does not say (most do not) or is a pipe
/// @throws Error NotFound, ReadFailed, TooLarge (2 GiB), OutOfMemory
ALTIRO3D_EXPORT double readFocalLength35mm(const std::filesystem::path& path);

/// Reads the raw numbers of a depth image: 8-bit, 16-bit or float, of one channel or of the grey
/// value of three; no normalisation (see depth_map.hpp for that). EXIF orientation is applied.
///
/// @param path as for readPicture(); 16-bit PNG/PGM/TIFF, float TIFF, PFM and EXR keep their values
/// @param notes as for readPicture(), and where the picture shows colours
/// @return [rows x cols, CV_32FC1, as in the file]
/// @throws Error as readPicture()
ALTIRO3D_EXPORT cv::Mat readDepthImage(const std::filesystem::path& path, Notes* notes = nullptr);

/// readDepthImage() without the step to float: a quarter or half of the memory for files of 8 and
/// 16 bits, and normalizeDepth() is faster on them and gives the same.
///
/// @param path as for readDepthImage()
/// @param notes as for readDepthImage()
/// @return [rows x cols, CV_8UC1, CV_16UC1 or CV_32FC1, as in the file]
/// @throws Error as readPicture()
ALTIRO3D_EXPORT cv::Mat readDepthSamples(const std::filesystem::path& path, Notes* notes = nullptr);

/// Whether a picture shows colours, as depth does not: in more than 2 % of its px the channels
/// differ by more than a sixteenth of white, of floats a sixteenth of the largest one. From 512
/// rows on some of them tell, evenly spaced.
///
/// @param picture [rows x cols, CV_8UC3, CV_16UC3, CV_32FC3 or CV_64FC3]
/// @return true if it does
/// @throws Error InvalidArgument (empty or wrong type)
ALTIRO3D_EXPORT bool hasColours(const cv::Mat& picture);

/// What a picture file says of itself, for those who take it for something else.
enum class PictureMark {
    None,
    Native ///< A Native: a PNG file gets a text chunk "altiro3D" that says so.
};

/// Writes a picture; the format follows the extension. The file appears whole or not at all.
///
/// PNG files carry no resolution (DPI) and no metadata but the mark. JPEG is written at quality 95,
/// WebP without loss. Where the format holds 8 bits only, 16-bit values are divided by 257 and
/// rounded.
///
/// @param path file name with the extension .png, .jpg, .jpeg, .jpe, .tif, .tiff, .webp, .bmp,
///        .dib, .ppm, .pgm, .pnm or .jp2, in any case
/// @param picture [rows x cols, CV_8UC1, CV_8UC3, CV_16UC1 or CV_16UC3, BGR]
/// @param mark in PNG files only; isMarkedNative() finds it
/// @throws Error InvalidArgument (empty, wrong type), Unsupported (unknown extension, too many px
///         for the format, colours in a .pgm), WriteFailed, OutOfMemory
ALTIRO3D_EXPORT void writePicture(const std::filesystem::path& path, const cv::Mat& picture,
                                  PictureMark mark = PictureMark::None);

/// Whether a PNG file says that it is a Native: such a picture is no photo, though it looks like
/// one. No for Natives in other formats and of other programs, for pipes, and for files that cannot
/// be read. Never throws but for want of memory.
///
/// @param path the file
/// @return true if it does
ALTIRO3D_EXPORT bool isMarkedNative(const std::filesystem::path& path);

/// Whether the file name's extension is one that writePicture() can write.
/// @param path file name; the file is not looked at
/// @return true if it is
ALTIRO3D_EXPORT bool canWritePicture(const std::filesystem::path& path);

/// The pictures in a directory (files with a picture's extension, hidden ones left out), in natural
/// order: `view9.png` before `view10.png`. Directories in it are not looked into.
///
/// @param directory the directory
/// @return their paths, with the directory
/// @throws Error NotFound or ReadFailed (no directory, no permission)
ALTIRO3D_EXPORT std::vector<std::filesystem::path>
listPictures(const std::filesystem::path& directory);

/// Natural order of names: runs of digits compare as numbers, letters without regard to case; names
/// that differ in case or leading zeros alone compare as bytes.
///
/// @param a one name
/// @param b another one
/// @return true if `a` comes before `b`
ALTIRO3D_EXPORT bool naturalLess(const std::string& a, const std::string& b);

} // namespace altiro3D
