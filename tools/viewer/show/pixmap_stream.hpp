#pragma once

#include <cstdio>
#include <opencv2/core/mat.hpp>

namespace altiro3D::viewer {

/// Reads the next of the 8-bit colour pictures (PPM, P6, without comments) that follow each other
/// in a file. It returns as soon as the last byte of the picture has arrived: FFmpeg waits for
/// bytes of the next one.
///
/// @param file a pipe, mostly
/// @param picture new memory [CV_8UC3, BGR]
/// @return false at the end of the file
/// @throws Error BadFormat (no such picture, a cut off one)
bool readPixmap(std::FILE& file, cv::Mat& picture);

} // namespace altiro3D::viewer
