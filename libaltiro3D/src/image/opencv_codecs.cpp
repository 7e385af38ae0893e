#include "image/opencv_codecs.hpp"

#include <opencv2/imgcodecs.hpp>

namespace {

cv::Mat decode(const cv::Mat& encoded, int flags) {
    return cv::imdecode(encoded, flags);
}

bool encode(const std::string& extension, const cv::Mat& image, std::vector<unsigned char>& bytes) {
    return cv::imencode(extension, image, bytes);
}

} // namespace

const altiro3D::OpenCvCodecs kAltiro3dOpenCvCodecs = {decode, encode};

// Where it is linked; opencv_codecs_loaded.cpp has the other way.
const altiro3D::OpenCvCodecs& altiro3D::openCvCodecs() {
    return kAltiro3dOpenCvCodecs;
}
