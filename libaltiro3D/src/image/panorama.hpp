#pragma once

#include "altiro3D/error.hpp"

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <string_view>

namespace altiro3D {

/// Refuses a picture that shows a sphere or a large part of it by its XMP (GPano), and says how to
/// take a flat part of it. Panoramas that are up to 100 degrees high are ordinary pictures. Any
/// bytes give a result.
/// @param file its name @param bytes its contents @param size of the picture, px
/// @param notes if given, receives a remark if the picture does not have the shape that it states
/// @throws Error Unsupported
void refuseSphere(const std::filesystem::path& file, std::string_view bytes, cv::Size size,
                  Notes* notes);

} // namespace altiro3D
