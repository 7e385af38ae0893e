#pragma once

#include "display/lens_phase.hpp"

#include <opencv2/core.hpp>

namespace altiro3D {

/// What an eye sees of a Native: the light of the sub-pixel that each lens shows in each row, over
/// the width of the lens, blurred. Mirrored panels stay mirrored.
///
/// @param native [panel, CV_8UC3, BGR]
/// @param phases of the display
/// @param phase that the eye sees
/// @param blur standard deviation for luminance, px, > 0; colour is blurred twice as far
/// @param seen [as native]; no memory in common with it
void seeBlurred(const cv::Mat& native, const LensPhases& phases, double phase, double blur,
                cv::Mat& seen);

} // namespace altiro3D
