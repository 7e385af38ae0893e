#pragma once

#include "altiro3D/image_io.hpp"
#include "image/depth_parts.hpp"

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace altiro3D {

/// Depth with more px is not read. The largest seen has 4e6.
constexpr double kMaxDepthPixels = 6.4e7;

/// The depth numbers of a part, upright.
/// @param picture the part's picture as it was decoded, 8 or 16 bits, not turned; empty if it is
///        damaged, and for raw numbers
/// @return [CV_8UC1 or CV_16UC1]; empty if it cannot be read
cv::Mat samplesOf(const DepthPart& part, const cv::Mat& picture);

/// The depth of a part.
/// @param samples from samplesOf(), or of an auxiliary picture
/// @param photo size of the upright photo, px
/// @param notes if given, receives a remark if the depth is not used
/// @return nothing if it is damaged, flat, or does not have the photo's shape
std::optional<EmbeddedDepth> depthOfPart(const DepthPart& part, const cv::Mat& samples,
                                         cv::Size photo, Notes* notes);

/// Adds a remark that depth in a file is not used. @param what its form
void addUnusedDepth(Notes* notes, const std::string& what, const std::string& why);

/// The name of a form, for people.
const char* nameOf(EmbeddedDepthForm form);

} // namespace altiro3D
