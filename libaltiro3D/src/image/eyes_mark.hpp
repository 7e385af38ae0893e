#pragma once

#include "altiro3D/image_io.hpp"
#include "image/picture_halves.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace altiro3D {

/// How a picture file states that it holds the pictures of both eyes.
struct StatedEyes {
    StereoLayout layout = StereoLayout::RightLeft;
    Squeeze squeeze = Squeeze::None;
    int gap = 0; ///< px between the two pictures.
};

/// What a JPEG or PNG file states of eyes.
struct EyesMark {
    std::optional<StatedEyes> eyes;
    std::string damage;     ///< Why a mark is not used: the end of a sentence; empty: none or good.
    std::string unreadable; ///< A layout that is not read ("interleaved"); empty otherwise.
    bool isOneEye = false;  ///< The mark says that the picture is of one eye.
};

/// Reads the JPS header of a JPEG (the first segment APP3 "_JPSJPS_", before the first scan) or the
/// chunk sTER of a PNG (before the pixels). Any bytes give a result.
EyesMark readEyesMark(std::string_view bytes);

} // namespace altiro3D
