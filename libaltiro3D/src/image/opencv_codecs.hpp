#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace altiro3D {

/// A channel of an EXR file.
struct ExrChannel {
    int part = 0;     ///< Number of its part.
    std::string name; ///< In its part: "R", "ViewLayer.Depth.Z".
    std::string full; ///< The same after the name of its part, if the file has several.
};

/// cv::imdecode(), cv::imencode() and OpenEXR, behind pointers: OpenCV's image formats bring more
/// than a hundred libraries, which would take two thirds of the start of every program. The shared
/// library loads them with the first picture that is neither JPEG nor PNG; a static one links them.
struct OpenCvCodecs {
    /// @param encoded [1 x bytes, CV_8UC1]
    cv::Mat (*decode)(const cv::Mat& encoded, int flags);
    bool (*encode)(const std::string& extension, const cv::Mat& image,
                   std::vector<unsigned char>& bytes);
    /// As the functions of these names in exr_file.hpp; null without OpenEXR.
    /// @throws std::exception
    std::vector<ExrChannel> (*exrChannels)(std::string_view bytes);
    cv::Mat (*readExr)(std::string_view bytes, const std::vector<ExrChannel>& channels);
};

/// @throws Error Unsupported if their library cannot be loaded
const OpenCvCodecs& openCvCodecs();

} // namespace altiro3D

/// What the loaded library exports.
extern "C" __attribute__((visibility("default")))
const altiro3D::OpenCvCodecs kAltiro3dOpenCvCodecs;
