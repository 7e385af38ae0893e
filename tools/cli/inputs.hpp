#pragma once

#include "altiro3D/image_io.hpp"
#include "cli/messages.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>

namespace altiro3D::tools {

/// A picture to read. Standard input is read now. @throws Error ReadFailed, TooLarge
PhotoFile pictureToRead(const std::filesystem::path& file);

/// Reports a missing input. Call it before any check of outputs, because the names may be in the
/// wrong order. @throws Error NotFound
void requireFile(const std::filesystem::path& file);

/// Whether a name states the layout of more than one view.
bool isQuiltName(const std::filesystem::path& file);

/// Warns if the name of a photo or video says that it is a quilt.
/// @param instead the tool or option that reads quilts
void warnIfQuilt(const std::filesystem::path& file, const std::string& instead, Messages& messages);

/// Refuses a Native where another picture is expected; usually the names are in the wrong order.
/// @param expected "a photo" @throws Error BadFormat
void refuseNative(const PhotoFile& file, const std::string& expected);

/// Reads a photo or quilt; remarks about the file become warnings.
cv::Mat readPhotoFile(const PhotoFile& file, Messages& messages);

} // namespace altiro3D::tools
