#include "altiro3D/image_io.hpp"

#include "base/checks.hpp"
#include "base/image_format.hpp"
#include "image/colour.hpp"
#include "image/depth_parts.hpp"
#include "image/exif.hpp"
#include "image/heif_file.hpp"
#include "image/image_codecs.hpp"
#include "image/image_header.hpp"
#include "image/picture_halves.hpp"
#include "image/pixel_values.hpp"

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <utility>

namespace altiro3D {

namespace {

using std::string_view;

void addUnused(Notes* notes, const std::string& why) {
    addNote(notes, NoteCode::LeftOut, "the right eye's picture is not used: " + why);
}

// Checks a pair; nothing and a remark if it cannot show one scene.
std::optional<StereoPair> checked(StereoPair pair, Notes* notes) {
    if (canBeEyes(pair.left.size(), pair.right.size())) return pair;
    addUnused(notes, "its shape is not that of the left picture");
    return std::nullopt;
}

// readPhoto() without its remark on further pictures, which are used here.
cv::Mat readFirst(const PhotoFile& photo, Notes* notes) {
    Notes own;
    cv::Mat picture = readPhoto(photo, &own);
    for (const Note& note : own) {
        if (notes != nullptr && note.code != NoteCode::LeftOut) notes->push_back(note);
    }
    return picture;
}

std::optional<StereoPair> pairOfJpeg(const PhotoFile& photo, string_view bytes, Notes* notes) {
    const SecondEye second = findSecondEye(bytes);
    const string_view coded = second.picture();
    if (coded.empty()) return std::nullopt;
    cv::Mat right = decodePart(coded, kMaxImagePixels, ImageChannels::Colour);
    if (right.empty()) {
        addUnused(notes, "it is damaged or too large");
        return std::nullopt;
    }
    ColourFacts colours = readColourFacts(coded, imageFormat(coded));
    if (colours.icc.empty()) colours = readColourFacts(bytes, ImageFormat::Jpeg);
    convertToSrgb(right, colours, nullptr);
    StereoPair pair;
    pair.left = readFirst(photo, notes);
    pair.right = upright(right, second.orientation);
    pair.origin = second.coded.empty() ? "Cardboard Camera" : "MPO";
    return checked(std::move(pair), notes);
}

cv::Mat eyeOf(const HeifFile& file, std::uint32_t item, Notes* notes) {
    cv::Mat picture = file.decode(item);
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
    } catch (const PictureFailure& failure) {
        addUnused(notes, failure.what());
        return std::nullopt;
    }
}

} // namespace

std::optional<StereoPair> readStereoPair(const PhotoFile& photo, Notes* notes) try {
    return withinMemory(photo.path(), [&]() -> std::optional<StereoPair> {
        const string_view bytes = photo.look();
        const MarkedEyes marked = findMarkedEyes(photo.path(), bytes, notes);
        if (marked.eyes)
            return splitMarkedEyes(readPhoto(photo, notes), marked, photo.path().string(), notes);
        const ImageFormat format = imageFormat(bytes);
        if (format == ImageFormat::Jpeg) return pairOfJpeg(photo, bytes, notes);
        if (isHeif(format)) return pairOfHeif(bytes, format, notes);
        return std::nullopt;
    });
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

std::optional<StereoLayout> readStereoLayout(const PhotoFile& photo) {
    const MarkedEyes marked = findMarkedEyes(photo.path(), photo.look(), nullptr);
    if (!marked.eyes) return std::nullopt;
    return marked.eyes->layout;
}

StereoPair splitStereoFile(const cv::Mat& picture, StereoLayout layout, StereoHalves halves,
                           const PhotoFile& file, Notes* notes) try {
    return splitNamedHalves(picture, layout, halves, file.path(), file.look(), notes);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
