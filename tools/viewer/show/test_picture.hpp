#pragma once

#include "altiro3D/display.hpp"

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace altiro3D::viewer {

/// A Native by which the eye tells faults of a display apart.
///
/// The views are red on the left, green in the middle and blue on the right; the fifth of them in
/// the middle is green. A strip of panel px, the same for all views, has a square of lines of 1 px
/// beside a square of the grey that is as bright as their mean (188), and steps of grey. A line of
/// 1 px runs along all four edges.
/// @param display its calibration, quilt and order of views
/// @return [panel, CV_8UC3, BGR]
/// @throws Error as of NativeLut and TooLarge
cv::Mat makeTestPicture(const Display& display);

/// The squares of the strip, px of the panel.
struct TestPictureParts {
    cv::Rect lines;
    cv::Rect grey;
    cv::Rect steps; ///< Eight steps from black to white.
};
TestPictureParts testPictureParts(cv::Size panel);

/// How to read it, a sentence each.
std::vector<std::string> testPictureAdvice();

} // namespace altiro3D::viewer
