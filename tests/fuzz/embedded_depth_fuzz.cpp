// Depth inside photos: segments, multi-picture index, XMP, trailers; pairs of 3D cameras and of
// Cardboard Camera; spheres; marks of JPS and PNS.

#include "altiro3D/image_io.hpp"
#include "fuzz.hpp"
#include "image/depth_parts.hpp"
#include "image/image_header.hpp"
#include "image/panorama.hpp"
#include "image/picture_halves.hpp"

#include <opencv2/core.hpp>

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::Directory directory;
    constexpr double kMaxPixels = 1e5; // time is for our code, not for decoders
    const std::string_view bytes = fuzz::textOf(data, size);
    std::string decoded;
    findUnblurred(bytes, decoded);
    fuzz::reads([&] { refuseSphere("a.jpg", bytes, {64, 32}, nullptr); });
    const SecondEye second = findSecondEye(bytes);
    const std::string_view eye = second.coded;
    fuzz::require(eye.empty() || second.decoded.empty(), "the second eye's picture is one");
    fuzz::require(eye.empty() || (eye.data() >= bytes.data() &&
                                  eye.data() + eye.size() <= bytes.data() + bytes.size()),
                  "the second eye's picture is a part of the file");
    const EyesMark mark = readEyesMark(bytes);
    fuzz::require(!mark.eyes || (mark.damage.empty() && mark.unreadable.empty() && !mark.isOneEye),
                  "a mark that is used is whole");
    const ImageHeader whole = readImageHeader(bytes, "");
    if (mark.eyes &&
        static_cast<double>(whole.columns) * static_cast<double>(whole.rows) <= kMaxPixels) {
        const std::filesystem::path marked = directory.file("a.pns", bytes);
        fuzz::reads([&] {
            const auto pair = readStereoPair(marked);
            fuzz::require(pair && pair->left.size() == pair->right.size(), "eyes have one size");
        });
    }
    const auto part = findDepthPart(bytes);
    if (!part) return 0;
    const ImageHeader header = readImageHeader(part->picture(), "");
    if (static_cast<double>(header.columns) * static_cast<double>(header.rows) > kMaxPixels)
        return 0;
    const std::filesystem::path file = directory.file("a.jpg", bytes);
    Notes notes;
    fuzz::reads([&] {
        const auto depth = readEmbeddedDepth(file, &notes);
        if (!depth) return;
        double least = 0;
        double most = 0;
        cv::minMaxLoc(depth->depth, &least, &most);
        fuzz::require(depth->depth.type() == CV_32FC1 && least >= 0 && most <= 1,
                      "depth is float, 0..1");
    });
    return 0;
}
