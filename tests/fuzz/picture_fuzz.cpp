// Pictures, depth and RGB-D through OpenCV's decoders; the first byte chooses the reader.

#include "altiro3D/depth_map.hpp"
#include "altiro3D/image_io.hpp"
#include "fuzz.hpp"
#include "image/image_header.hpp"

#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>

using namespace altiro3D;

namespace {

constexpr double kMaxPixels = 1e5; // time is for our code, not for decoders

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::Directory directory;
    static const auto quiet = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    static_cast<void>(quiet);
    fuzz::Bytes bytes(data, size);
    const unsigned kind = bytes.byte();
    const ImageHeader header = readImageHeader(bytes.rest(), "");
    if (static_cast<double>(header.columns) * static_cast<double>(header.rows) > kMaxPixels &&
        header.columns <= 65500 && header.rows <= 65500) {
        return 0;
    }
    const std::filesystem::path file =
        directory.file((kind & 128U) != 0 ? "a.mpo" : "a.png", bytes.rest());
    Notes notes;
    fuzz::reads([&] {
        switch (kind % 4) {
        case 0: {
            const cv::Mat photo = readPhoto(file, &notes);
            fuzz::require(photo.type() == CV_8UC3 && !photo.empty(), "photos are 8-bit BGR");
            break;
        }
        case 1: {
            const cv::Mat depth = readDepthImage(file, &notes);
            fuzz::require(depth.type() == CV_32FC1 && !depth.empty(), "depth is float");
            DepthNormalization options;
            options.kind = static_cast<DepthKind>(kind / 4 % 3);
            cv::Mat map;
            normalizeDepth(depth, map, options);
            double least = 0;
            double most = 0;
            cv::minMaxLoc(map, &least, &most);
            fuzz::require(least >= 0 && most <= 1, "depth maps are 0..1");
            break;
        }
        case 2: {
            const cv::Mat picture = readImage(file, &notes);
            cv::Mat photo;
            cv::Mat raw;
            splitRgbd(picture, static_cast<DepthSide>(kind / 4 % 4), photo, raw);
            fuzz::require(photo.size() == raw.size(), "the halves have one size");
            break;
        }
        default:
            isMarkedNative(file);
            hasColours(readDepthSamples(file, &notes));
        }
    });
    return 0;
}
