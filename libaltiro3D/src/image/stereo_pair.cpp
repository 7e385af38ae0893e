#include "altiro3D/image_io.hpp"

#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/image_format.hpp"
#include "base/memory_errors.hpp"
#include "base/posix_file.hpp"
#include "base/text.hpp"
#include "image/colour.hpp"
#include "image/depth_parts.hpp"
#include "image/heif_boxes.hpp"
#include "image/heif_file.hpp"
#include "image/image_header.hpp"
#include "image/orientation.hpp"
#include "image/picture_part.hpp"
#include "image/picture_shape.hpp"
#include "image/pixel_values.hpp"

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <utility>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

using std::string_view;

// Files of other formats are not read as a whole.
bool canHoldPair(const fs::path& path) {
    std::string start(512, '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(start.data(), static_cast<std::streamsize>(start.size()));
    start.resize(static_cast<std::size_t>(file.gcount()));
    const ImageFormat format = imageFormat(start);
    return format == ImageFormat::Jpeg || isHeif(format);
}

void addUnused(Notes* notes, const std::string& why) {
    if (notes != nullptr)
        notes->push_back({NoteCode::LeftOut, "the right eye's picture is not used: " + why});
}

// Nothing and a remark if a pair cannot be of one scene.
std::optional<StereoPair> checked(StereoPair pair, Notes* notes) {
    if (canBeEyes(pair.left.size(), pair.right.size())) return pair;
    addUnused(notes, "its shape is not that of the left picture");
    return std::nullopt;
}

// readPhoto() without its remark on further pictures, which are used here.
cv::Mat readFirst(const fs::path& photo, Notes* notes) {
    Notes own;
    cv::Mat picture = readPhoto(photo, &own);
    for (const Note& note : own) {
        if (notes != nullptr && note.code != NoteCode::LeftOut) notes->push_back(note);
    }
    return picture;
}

// JPS: both eyes in one JPEG, the right one's picture at the left.
StereoPair pairOfJps(const fs::path& photo, Notes* notes) {
    StereoPair pair =
        splitStereoPair(readPhoto(photo, notes), StereoLayout::RightLeft, StereoHalves::Automatic);
    pair.origin = "JPS";
    return pair;
}

std::optional<StereoPair> pairOfJpeg(const fs::path& photo, string_view bytes, Notes* notes) {
    const string_view second = findSecondEye(bytes);
    if (second.empty()) return std::nullopt;
    cv::Mat right = decodePart(second, kMaxImagePixels, ImageChannels::Colour);
    if (right.empty()) {
        addUnused(notes, "it is damaged or too large");
        return std::nullopt;
    }
    ColourFacts colours = readColourFacts(second, imageFormat(second));
    if (colours.icc.empty()) colours = readColourFacts(bytes, ImageFormat::Jpeg);
    convertToSrgb(right, colours, nullptr);
    const int orientation = readImageHeader(second, "").orientation;
    StereoPair pair;
    pair.left = readFirst(photo, notes);
    pair.right =
        upright(right, orientation != 1 ? orientation : readImageHeader(bytes, "").orientation);
    pair.origin = "MPO";
    return checked(std::move(pair), notes);
}

cv::Mat eyeOf(const HeifFile& file, std::uint32_t item, Notes* notes) {
    cv::Mat picture = file.decodeItem(item, kMaxImagePixels);
    if (picture.channels() == 4) cv::cvtColor(picture, picture, cv::COLOR_BGRA2BGR);
    ColourFacts colours = readColourFacts(file, item);
    if (colours.icc.empty() && !colours.code) colours = readColourFacts(file);
    convertToSrgb(picture, colours, notes);
    return picture.depth() == CV_16U ? toEightBits(picture) : picture;
}

std::optional<StereoPair> pairOfHeif(string_view bytes, ImageFormat format, Notes* notes) {
    const std::optional<HeifEyes> eyes = findHeifEyes(bytes);
    if (!eyes || !hasHeif()) return std::nullopt;
    try {
        const HeifFile file(bytes);
        StereoPair pair;
        pair.left = eyeOf(file, eyes->left, notes);
        pair.right = eyeOf(file, eyes->right, nullptr);
        pair.origin = format == ImageFormat::Avif ? "stereo AVIF" : "spatial HEIC";
        return checked(std::move(pair), notes);
    } catch (const HeifFailure& failure) {
        addUnused(notes, failure.what());
        return std::nullopt;
    }
}

bool areSqueezed(cv::Size whole, StereoHalves halves) {
    constexpr double kNarrowest = 1.70; // of 3D TV: 16:9 = 1.78
    constexpr double kWidest = 1.85;    // of 3D cinema
    if (halves != StereoHalves::Automatic) return halves == StereoHalves::Squeezed;
    const double aspect = static_cast<double>(whole.width) / whole.height;
    return aspect >= kNarrowest && aspect <= kWidest;
}

} // namespace

std::optional<StereoPair> readStereoPair(const fs::path& photo, Notes* notes) {
    if (givesBytesOnce(photo) || !canHoldPair(photo)) return std::nullopt;
    return orOutOfMemory(photo.string(), "does not fit into memory, expected a smaller picture",
                         [&]() -> std::optional<StereoPair> {
                             if (lowerExtension(photo) == ".jps") return pairOfJps(photo, notes);
                             const std::string bytes = readFile(photo, kMaxImageFileBytes);
                             const ImageFormat format = imageFormat(bytes);
                             if (format == ImageFormat::Jpeg)
                                 return pairOfJpeg(photo, bytes, notes);
                             if (isHeif(format)) return pairOfHeif(bytes, format, notes);
                             return std::nullopt;
                         });
}

StereoPair splitStereoPair(const cv::Mat& picture, StereoLayout layout, StereoHalves halves) {
    checkType(picture, {CV_8UC3}, "picture", "CV_8UC3 (8-bit BGR)");
    const bool isTopBottom = layout == StereoLayout::TopBottom;
    const cv::Size half(isTopBottom ? picture.cols : picture.cols / 2,
                        isTopBottom ? picture.rows / 2 : picture.rows);
    check(!half.empty(), "picture", shapeText(picture) + ", expected two halves");
    const cv::Point second(isTopBottom ? 0 : picture.cols - half.width,
                           isTopBottom ? picture.rows - half.height : 0);
    StereoPair pair;
    pair.left = picture(cv::Rect({0, 0}, half));
    pair.right = picture(cv::Rect(second, half));
    if (layout == StereoLayout::RightLeft) cv::swap(pair.left, pair.right);
    pair.origin = isTopBottom ? "upper and lower half" : "left and right half";
    if (layout == StereoLayout::RightLeft) pair.origin = "right and left half";
    if (areSqueezed(picture.size(), halves)) {
        const cv::Size size(isTopBottom ? half.width : 2 * half.width,
                            isTopBottom ? 2 * half.height : half.height);
        cv::resize(pair.left, pair.left, size, 0, 0, cv::INTER_LINEAR);
        cv::resize(pair.right, pair.right, size, 0, 0, cv::INTER_LINEAR);
        pair.origin += ", squeezed";
    }
    return pair;
}

} // namespace altiro3D
