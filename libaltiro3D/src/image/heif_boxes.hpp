#pragma once

#include <opencv2/core/types.hpp>
#include <string>
#include <string_view>

namespace altiro3D {

/// Repairs a HEIC file of iOS 18 for libheif before 1.19, which accepts one target per reference
/// of an auxiliary picture ("Too many auxiliary image references").
///
///     iref  auxl: depth -> primary, tone-mapped      becomes  depth -> primary
///           cdsc: XMP   -> primary, tone-mapped      becomes  XMP   -> primary
///           dimg: tone-mapped -> primary, gain map   is left out
///
/// A `free` box takes the place of the bytes that are left over, so no other offset changes.
///
/// @param bytes the whole file
/// @return the repaired file; empty if there is nothing to repair or the file is malformed
std::string repairedHeif(std::string_view bytes);

/// The largest coded picture that the HEVC settings of a HEIC file announce (sequence parameter
/// sets, H.265 7.3.2.2). The decoder allocates it, whatever the size that the file states
/// elsewhere.
/// @param bytes the whole file
/// @return px; empty if the file has no such settings
cv::Size largestCodedPicture(std::string_view bytes);

} // namespace altiro3D
