#pragma once

#include "altiro3D/depth_source.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace altiro3D {

/// Depth of pictures in memory, like that of files: see storedDepthOr().

/// The left eye's picture with its depth by matching.
/// @param notes receives the remarks on the match, without the name of the file
/// @return rawDepth is empty if the pictures do not match
PhotoDepth matchedDepth(const StereoPair& pair, Notes& notes);

/// The left half of a picture whose name says that it holds both eyes, with its depth by matching.
/// @param file name of the picture's file @param bytes its contents
/// @param notes if given, receives remarks
/// @return nothing, and a remark, unless the halves match so well that they are certainly eyes
std::optional<PhotoDepth> matchedDepth(const SceneName& name, const cv::Mat& picture,
                                       const std::filesystem::path& file, std::string_view bytes,
                                       Notes* notes);

/// Adds a remark that a picture is not what its name says. @param why "says that it holds ..."
void addReadAsPhoto(Notes* notes, const SceneName& name, const std::string& why);

} // namespace altiro3D
