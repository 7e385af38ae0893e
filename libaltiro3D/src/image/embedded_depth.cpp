#include "altiro3D/image_io.hpp"

#include "altiro3D/file_io.hpp"
#include "base/byte_reader.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "image/colour.hpp"
#include "image/depth_of_part.hpp"
#include "image/depth_parts.hpp"
#include "image/exif.hpp"
#include "image/exr_file.hpp"
#include "image/heif_file.hpp"
#include "image/image_codecs.hpp"
#include "image/image_header.hpp"
#include "image/picture_halves.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

using std::string_view;

cv::Size uprightSize(const ImageHeader& header) {
    const cv::Size size(static_cast<int>(std::min<std::uint64_t>(header.columns, kMaxImageSide)),
                        static_cast<int>(std::min<std::uint64_t>(header.rows, kMaxImageSide)));
    return header.orientation >= 5 ? cv::Size(size.height, size.width) : size;
}

std::optional<EmbeddedDepth> depthOfHeif(string_view bytes, ImageFormat format, Notes* notes) {
    const EmbeddedDepthForm form =
        format == ImageFormat::Avif ? EmbeddedDepthForm::Avif : EmbeddedDepthForm::AppleHeic;
    try {
        std::optional<HeifDepth> depth = HeifFile(bytes).decodeDepth(kMaxDepthPixels);
        if (!depth) return std::nullopt;
        depth->part.form = form;
        return depthOfPart(depth->part, depth->samples, uprightSize(readImageHeader(bytes, "")),
                           notes);
    } catch (const PictureFailure& failure) {
        addUnusedDepth(notes, nameOf(form), failure.what());
        return std::nullopt;
    }
}

// Depth from the distances that a renderer has stored beside its colours. The nearest 0.5 % of the
// px become 1.
std::optional<EmbeddedDepth> depthOfExr(string_view bytes, Notes* notes) {
    try {
        const std::vector<ExrChannel> channels = exrChannels(bytes);
        const ExrChoice choice = chooseExrDistance(channels);
        if (choice.channels.empty() || chooseExrColours(channels).channels.empty())
            return std::nullopt;
        const cv::Mat distances = readExr(bytes, choice.channels);
        std::vector<float> known;
        std::copy_if(distances.begin<float>(), distances.end<float>(), std::back_inserter(known),
                     [](float distance) { return distance > 0; });
        const float nearest = known.empty() ? 1 : percentileOf(std::move(known), 0.005);
        EmbeddedDepth found;
        found.form = EmbeddedDepthForm::Exr;
        found.depth = mapped<float, float>(distances, [nearest](float distance) {
            return distance > 0 ? std::min(1.0F, nearest / distance) : std::nanf("");
        });
        addExrNotes(choice, "depth", notes);
        const std::string reason =
            reasonAgainstDepth(found.depth, uprightSize(readImageHeader(bytes, "")));
        if (reason.empty()) return found;
        addUnusedDepth(notes, found.text(), reason);
    } catch (const PictureFailure& failure) {
        addUnusedDepth(notes, nameOf(EmbeddedDepthForm::Exr), failure.what());
    }
    return std::nullopt;
}

// Near and Far are not metres: depth is relative; 1 and 1000 keep inverse depth nearly linear.
std::string xmpFor(std::size_t depthBytes) {
    constexpr const char* kText =
        R"(<x:xmpmeta xmlns:x="adobe:ns:meta/" x:xmptk="altiro3D">)"
        R"(<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">)"
        R"(<rdf:Description rdf:about="" xmlns:Container="@1.0/container/")"
        R"( xmlns:Item="@1.0/container/item/" xmlns:Device="@dd/1.0/device/")"
        R"( xmlns:Profile="@dd/1.0/profile/" xmlns:Camera="@dd/1.0/camera/")"
        R"( xmlns:DepthMap="@dd/1.0/depthmap/"><Container:Directory><rdf:Seq>)"
        R"(<rdf:li rdf:parseType="Resource"><Container:Item Item:Mime="image/jpeg")"
        R"( Item:Length="0" Item:Semantic="Primary"/></rdf:li>)"
        R"(<rdf:li rdf:parseType="Resource"><Container:Item Item:Mime="image/jpeg")"
        R"( Item:Length="$" Item:Semantic="Depth" Item:DataURI="android/depthmap"/></rdf:li>)"
        R"(</rdf:Seq></Container:Directory><Device:Profiles><rdf:Seq>)"
        R"(<rdf:li rdf:parseType="Resource"><rdf:value rdf:parseType="Resource">)"
        R"(<Profile:Type>DepthPhoto</Profile:Type><Profile:CameraIndices><rdf:Seq>)"
        R"(<rdf:li>0</rdf:li></rdf:Seq></Profile:CameraIndices></rdf:value>)"
        R"(<rdf:type>@dd/1.0/device/:Profile</rdf:type></rdf:li></rdf:Seq></Device:Profiles>)"
        R"(<Device:Cameras><rdf:Seq><rdf:li rdf:parseType="Resource">)"
        R"(<rdf:value rdf:parseType="Resource"><Camera:DepthMap rdf:parseType="Resource">)"
        R"(<DepthMap:ItemSemantic>Depth</DepthMap:ItemSemantic>)"
        R"(<DepthMap:Format>RangeInverse</DepthMap:Format><DepthMap:Units>None</DepthMap:Units>)"
        R"(<DepthMap:Near>1</DepthMap:Near><DepthMap:Far>1000</DepthMap:Far>)"
        R"(<DepthMap:DepthURI>android/depthmap</DepthMap:DepthURI></Camera:DepthMap></rdf:value>)"
        R"(<rdf:type>@dd/1.0/device/:Camera</rdf:type></rdf:li></rdf:Seq></Device:Cameras>)"
        R"(</rdf:Description></rdf:RDF></x:xmpmeta>)";
    std::string xmp;
    for (const char* c = kText; *c != '\0'; ++c)
        xmp += *c == '@'   ? "http://ns.google.com/photos/"
               : *c == '$' ? std::to_string(depthBytes)
                           : std::string(1, *c);
    return xmp;
}

// Position after the start of the image and the JFIF segment, which comes first.
std::size_t startOfMetadata(const std::vector<unsigned char>& jpeg) {
    const ByteReader reader({reinterpret_cast<const char*>(jpeg.data()), jpeg.size()}, false);
    return reader.u16(2) == 0xffe0 ? 4 + reader.u16(4) : 2;
}

} // namespace

std::optional<EmbeddedDepth> readEmbeddedDepth(const PhotoFile& photo, Notes* notes) try {
    return withinMemory(photo.path(), [&]() -> std::optional<EmbeddedDepth> {
        const string_view bytes = photo.look();
        const ImageFormat format = imageFormat(bytes);
        if (format == ImageFormat::Heic || format == ImageFormat::Avif)
            return depthOfHeif(bytes, format, notes);
        if (format == ImageFormat::Exr) return depthOfExr(bytes, notes);
        if (format != ImageFormat::Jpeg) return std::nullopt;
        const std::optional<DepthPart> part = findDepthPart(bytes);
        if (!part) return std::nullopt;
        const cv::Mat picture =
            decodePart(part->picture(), kMaxDepthPixels, ImageChannels::AsStored);
        return depthOfPart(*part, samplesOf(*part, picture),
                           uprightSize(readImageHeader(bytes, "")), notes);
    });
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

cv::Mat readUnblurredPhoto(const PhotoFile& photo, Notes* notes) {
    return withinMemory(photo.path(), [&]() -> cv::Mat {
        const string_view bytes = photo.look();
        if (imageFormat(bytes) != ImageFormat::Jpeg) return {};
        std::string decoded;
        const string_view original = findUnblurred(bytes, decoded);
        if (original.empty()) return {};
        cv::Mat picture = decodePart(original, kMaxImagePixels, ImageChannels::Colour);
        ColourFacts colours = readColourFacts(original, imageFormat(original));
        if (colours.icc.empty()) colours = readColourFacts(bytes, ImageFormat::Jpeg);
        convertToSrgb(picture, colours, notes);
        const ImageHeader header = readImageHeader(bytes, "");
        cv::Mat result = upright(picture, header.orientation);
        if (result.empty() || !haveOneShape(result.size(), uprightSize(header))) {
            addNote(notes, NoteCode::LeftOut,
                    std::string("the sharp original in the file is not used: ") +
                        (result.empty() ? "it is damaged" : "its shape is not that of the photo"));
            return {};
        }
        return result;
    });
}

void writePhotoWithDepth(const std::filesystem::path& path, const cv::Mat& photo,
                         const cv::Mat& depth) try {
    const std::string extension = lowerExtension(path);
    if (extension != ".jpg" && extension != ".jpeg") {
        throw Error(ErrorCode::Unsupported, path.string(),
                    "a photo with depth is a JPEG, expected the extension .jpg");
    }
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    for (const cv::Mat& picture : {photo, depth}) {
        if (std::max(picture.cols, picture.rows) <= kMaxImageSide) continue;
        throw Error(ErrorCode::Unsupported, path.string(),
                    sizeText(picture.size()) +
                        " are too many for JPEG, expected sides of at most " +
                        std::to_string(kMaxImageSide) + " px");
    }
    if (!haveOneShape(depth.size(), photo.size())) {
        throw Error(ErrorCode::Mismatch, "depth",
                    "has " + sizeText(depth.size()) + ", expected the shape of the photo's " +
                        sizeText(photo.size()));
    }
    withinMemory(path, [&] {
        cv::Mat dark = depth.clone();
        cv::patchNaNs(dark, 0);
        cv::min(dark, 1, dark); // huge values would leave the range of int
        cv::max(dark, 0, dark);
        dark.convertTo(dark, CV_8U, -255, 255); // RangeInverse: near = dark
        const std::vector<unsigned char> coded = encodeJpeg(photo);
        const std::vector<unsigned char> codedDepth = encodeJpeg(dark);
        if (coded.empty() || codedDepth.empty()) {
            throw Error(ErrorCode::WriteFailed, path.string(), "cannot be encoded as JPEG");
        }
        const std::string body =
            std::string("http://ns.adobe.com/xap/1.0/\0", 29) + xmpFor(codedDepth.size());
        std::string segment("\xff\xe1", 2);
        segment.push_back(static_cast<char>((body.size() + 2) >> 8));
        segment.push_back(static_cast<char>((body.size() + 2) & 0xffU));
        segment += body;
        const std::size_t start = startOfMetadata(coded);
        writeFile(path, {{coded.data(), start},
                         {segment.data(), segment.size()},
                         {coded.data() + start, coded.size() - start},
                         {codedDepth.data(), codedDepth.size()}});
    });
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
