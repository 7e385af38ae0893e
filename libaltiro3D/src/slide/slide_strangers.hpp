#pragma once

#include "altiro3D/error.hpp"
#include "slide/slide_tracks.hpp"

#include <string>
#include <vector>

namespace altiro3D {

/// Names for messages.
struct SlideNames {
    const std::string& clip;
    const std::vector<std::string>& pictures; ///< May be fewer than there are pictures.
};

/// Leaves out pictures that do not show the scene of the others: black, white, blurred or of
/// another scene.
/// @param pictures keeps the others @param notes receives what is left out
/// @return steps of the pictures that stay
/// @throws Error BadFormat (more than a tenth of the pictures, or too few corners)
PictureSteps leaveOutStrangers(std::vector<SlidePicture>& pictures, const SlideNames& names,
                               Notes& notes);

} // namespace altiro3D
