#pragma once

#include <cstdint>
#include <optional>
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

/// Why a HEIC or AVIF file must not be decoded: a decoder allocates what the file says in these
/// places, whatever size it states elsewhere.
/// - HEVC settings (sequence parameter sets, H.265 7.3.2.2) and AV1 sequence headers of more px
///   than allowed.
/// - Grids and overlays whose size no picture of the file states.
/// @param bytes the whole file
/// @return a part of a sentence; empty if nothing was found
std::string heifProblem(std::string_view bytes, double maxPixels);

/// The number of pictures of an animation (AVIF and HEIC sequences): the samples of the longest
/// track; 0 if the file has none.
/// @param bytes the whole file
unsigned heifFrames(std::string_view bytes);

/// The items of the two pictures of a stereo pair.
struct HeifEyes {
    std::uint32_t left = 0;
    std::uint32_t right = 0;
};

/// The first stereo pair of a HEIC or AVIF file: the group `ster` in the box `grpl` (ISO/IEC
/// 23008-12), whose first entity is the left eye's.
/// @param bytes the whole file
/// @return the pair; nothing if the file has none
std::optional<HeifEyes> findHeifEyes(std::string_view bytes);

} // namespace altiro3D
