#include "image/depth_of_part.hpp"

#include "altiro3D/enum_table.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "image/exif.hpp"
#include "image/picture_halves.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr std::size_t kMinLevels = 4; // levels of 256 between the percentiles 0.5 and 99.5

// Relative inverse depth of samples v of 0..1.
//   RangeInverse: v = (1/near - 1/Z) / (1/near - 1/far)       -> 1 - v
//   RangeLinear:  Z = near + v (far - near), (1/Z - 1/far) / (1/near - 1/far)
//                                                             -> near (1 - v) / Z
cv::Mat depthMapOf(const DepthPart& part, const cv::Mat& samples) {
    const double ratio = part.isDistance && part.nearest > 0 ? part.farthest / part.nearest : 0;
    const bool isLinear = ratio > 1 && std::isfinite(ratio);
    const int levels = samples.depth() == CV_8U ? 256 : 65536;
    std::vector<float> table;
    for (int i = 0; i < levels; ++i) {
        const double v = i / (levels - 1.0);
        const double far = isLinear ? (1 - v) / (1 + v * (ratio - 1)) : 1 - v;
        table.push_back(static_cast<float>(part.isNearBright ? v : far));
    }
    const auto look = [&](auto sample) { return table[sample]; };
    return levels == 256 ? mapped<std::uint8_t, float>(samples, look)
                         : mapped<std::uint16_t, float>(samples, look);
}

// Whether the depth has hardly any range. The 0.5 % at each end may be single px and do not count.
bool isFlat(const cv::Mat& depth) {
    std::array<std::int64_t, 256> counts{};
    for (int y = 0; y < depth.rows; ++y) {
        const float* const row = depth.ptr<float>(y);
        for (int x = 0; x < depth.cols; ++x)
            ++counts[static_cast<std::size_t>(std::lround(row[x] * 255))];
    }
    const std::int64_t extremes = static_cast<std::int64_t>(depth.total()) / 200; // 0.5 %
    std::size_t low = 0;
    for (std::int64_t below = counts[low]; below <= extremes; below += counts[low])
        ++low;
    std::size_t high = 255;
    for (std::int64_t above = counts[high]; above <= extremes; above += counts[high])
        --high;
    return high < low + kMinLevels;
}

} // namespace

const char* nameOf(EmbeddedDepthForm form) {
    constexpr const char* kNames[] = {"Apple HEIC",    "Apple JPEG", "Google lens blur",
                                      "Dynamic Depth", "AVIF",       "EXR"};
    return entryOf(kNames, form);
}

void addUnusedDepth(Notes* notes, const std::string& what, const std::string& why) {
    addNote(notes, NoteCode::LeftOut, "the depth (" + what + ") in the file is not used: " + why);
}

std::string EmbeddedDepth::text() const {
    return std::string(nameOf(form)) + ", " + sizeText(depth.size());
}

cv::Mat samplesOf(const DepthPart& part, const cv::Mat& picture) {
    cv::Mat samples;
    if (picture.depth() != CV_8U && picture.depth() != CV_16U) return {};
    if (picture.channels() == 1) samples = picture;
    if (picture.channels() >= 3) cv::extractChannel(picture, samples, 1); // grey in colours
    return samples.empty() ? samples : upright(samples, part.orientation);
}

std::optional<EmbeddedDepth> depthOfPart(const DepthPart& part, const cv::Mat& samples,
                                         cv::Size photo, Notes* notes) {
    if (photo.empty()) return std::nullopt;
    if (samples.empty()) {
        addUnusedDepth(notes, nameOf(part.form), "it is damaged");
        return std::nullopt;
    }
    EmbeddedDepth found;
    found.form = part.form;
    found.depth = depthMapOf(part, samples);
    if (!haveOneShape(found.depth.size(), photo)) {
        addUnusedDepth(notes, found.text(),
                       "its shape is not that of the photo, " + sizeText(photo));
        return std::nullopt;
    }
    if (isFlat(found.depth)) {
        addUnusedDepth(notes, found.text(), "it is flat");
        return std::nullopt;
    }
    return found;
}

} // namespace altiro3D
