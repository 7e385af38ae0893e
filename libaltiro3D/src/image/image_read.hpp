#pragma once

#include "altiro3D/image_io.hpp"

#include <functional>
#include <opencv2/core.hpp>
#include <string>

namespace altiro3D {

/// As readImage(), but only the colours of a part are converted to sRGB: other parts hold depth.
/// @param photoPart the part of an upright picture of a given size; empty: all of it
/// @throws Error as readImage()
cv::Mat readImageParts(const PhotoFile& file, const std::function<cv::Rect(cv::Size)>& photoPart,
                       Notes* notes);

/// Whether a file name has the extension of a picture, as for listImages().
bool hasImageExtension(const std::filesystem::path& file);

/// A colour picture as grey of at most 256 px per side; values without a number count as 0.
/// @param picture [rows x cols, three channels]
/// @return [CV_32FC1]
cv::Mat smallGrey(const cv::Mat& picture);

/// Turns depth that is drawn in colours back into numbers. The colour maps turbo, jet, Spectral,
/// inferno, magma, viridis, plasma and hue (full saturation and brightness) are recognised: nearly
/// all px lie near the curve of one of them, and they spread over a part of it. Black px, which
/// most maps do not contain, are unknown.
/// @param picture [rows x cols, CV_8UC3 or CV_16UC3, BGR]; other types are not recognised
/// @param subject the file or argument, for errors
/// @param notes if given, receives a remark that names the map
/// @return [rows x cols, CV_8UC1, 255 = warm or bright end of the map, or hue 1; unknown: 0]; empty
///         if the picture is not drawn in one of the maps
/// @throws Error BadFormat if the colours fit two maps that contradict each other
cv::Mat undoColourMap(const cv::Mat& picture, const std::string& subject, Notes* notes);

} // namespace altiro3D
