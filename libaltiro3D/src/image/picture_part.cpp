#include "image/picture_part.hpp"

#include "image/image_header.hpp"

#include <algorithm>
#include <opencv2/core.hpp>

namespace altiro3D {

cv::Mat decodePart(std::string_view bytes, double maxPixels, ImageChannels channels) {
    const ImageHeader header = readImageHeader(bytes, "");
    const double pixels = static_cast<double>(header.columns) * static_cast<double>(header.rows);
    const bool isKnown = header.format == ImageFormat::Jpeg || header.format == ImageFormat::Png;
    if (!isKnown || !header.unreadable.empty() || header.isCutOff || pixels < 1 ||
        pixels > maxPixels || std::max(header.columns, header.rows) > 65500) {
        return {};
    }
    try {
        return decodeImage(bytes, header.format, channels);
    } catch (const cv::Exception& exception) {
        if (exception.code == cv::Error::StsNoMem) throw;
        return {};
    }
}

} // namespace altiro3D
