#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>

namespace altiro3D {

/// Writes a picture for two eyes: as writeImage(), with a mark in PNG (text chunk "altiro3D") and
/// JPEG (header of JPS) that readStereoPair() reads. JPEG that mixes both eyes' pictures (Anaglyph
/// to Rows) has quality 100 and whole colours (4:4:4).
/// @param path, picture as for writeImage()
/// @param kind what the picture is
/// @param swapped the eyes are exchanged in it
/// @throws Error as writeImage()
ALTIRO3D_EXPORT void writeEyes(const std::filesystem::path& path, const cv::Mat& picture,
                               EyesPicture kind, bool swapped = false);

/// splitStereoPair() for a picture of a file: Automatic halves are those of its mark, else those of
/// its name (halvesOf()), else those of its shape. A frame of one colour around both eyes'
/// pictures, and a gap between them, are left out.
/// @param picture, layout, halves as for splitStereoPair()
/// @param file the picture's file
/// @param notes if given, receives remarks: a frame is left out, the shape leaves room for doubt
/// @return the pair
/// @throws Error as splitStereoPair()
[[nodiscard]] ALTIRO3D_EXPORT StereoPair splitStereoFile(const cv::Mat& picture,
                                                         StereoLayout layout, StereoHalves halves,
                                                         const PhotoFile& file,
                                                         Notes* notes = nullptr);

/// Whether a picture seems to mix both eyes' pictures: its red is shifted against its green, or
/// every second row or column is of another picture.
/// @param picture [rows x cols, CV_8UC3, BGR]
/// @return a remark for people ("looks like a red-cyan anaglyph, ..."); empty for other pictures
/// @throws Error InvalidArgument (empty or wrong type)
[[nodiscard]] ALTIRO3D_EXPORT std::string mixedEyes(const cv::Mat& picture);

} // namespace altiro3D
