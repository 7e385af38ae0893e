#pragma once

#include <opencv2/core/types.hpp>
#include <string>
#include <string_view>

namespace altiro3D {

/// The first picture of an animated WebP file.
struct WebPFrame {
    std::string file; ///< The picture as a WebP file of its own; empty if there is none.
    cv::Rect area;    ///< Its place in the animation; not checked.
};

/// Finds the first picture of an animated WebP file. Any bytes give a result.
WebPFrame firstWebPFrame(std::string_view bytes);

} // namespace altiro3D
