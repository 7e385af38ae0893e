// The state of a video's depth, with a checksum that matches.

#include "altiro3D/video_depth.hpp"
#include "base/state_bytes.hpp"
#include "fuzz.hpp"

#include <opencv2/core.hpp>

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::string bytes(fuzz::textOf(data, size));
    const std::uint64_t sum = checksum(bytes);
    append(bytes, sum);
    VideoDepth depth(
        [](const cv::Mat& picture, cv::Mat& raw) { cv::extractChannel(picture, raw, 1); },
        DepthKind::NearWhite);
    fuzz::reads([&] {
        depth.setState({bytes});
        fuzz::require(depth.state().bytes == bytes, "a state comes back as it was");
        cv::Mat picture(12, 16, CV_8UC3);
        cv::RNG(1).fill(picture, cv::RNG::UNIFORM, 0, 255); // the same for every input
        cv::Mat map;
        for (int i = 0; i < 2; ++i) {
            depth.next(picture, map);
            picture += cv::Scalar::all(3);
        }
    });
    return 0;
}
