#include "altiro3D/image_io.hpp"

#include "altiro3D/file_io.hpp"
#include "base/byte_reader.hpp"
#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "image/colour.hpp"
#include "image/depth_parts.hpp"
#include "image/exif.hpp"
#include "image/heif_file.hpp"
#include "image/image_codecs.hpp"
#include "image/image_header.hpp"
#include "image/picture_halves.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

using std::string_view;

constexpr double kMaxDepthPixels = 6.4e7; // the largest seen has 4e6
constexpr std::size_t kMinLevels = 4;     // of 256, between the percentiles 0.5 and 99.5

const char* nameOf(EmbeddedDepthForm form) {
    constexpr const char* kNames[] = {"Apple HEIC",          "Apple JPEG", "Google lens blur",
                                      "Dynamic Depth",       "AVIF",       "Samsung, experimental",
                                      "Huawei, experimental"};
    return kNames[static_cast<int>(form)];
}

// Depth as it is in the file; the reason why it cannot be read instead of samples.
struct RawDepth {
    DepthPart part;
    cv::Mat samples; // [CV_8UC1 or CV_16UC1], upright
    std::string failure;
};

cv::Mat samplesOf(const DepthPart& part) {
    if (!part.raw.empty()) {
        if (static_cast<double>(part.raw.size()) > kMaxDepthPixels) return {};
        const cv::Mat raw(static_cast<int>(part.rows), static_cast<int>(part.columns), CV_8UC1,
                          const_cast<char*>(part.raw.data()));
        return raw.clone();
    }
    cv::Mat picture = decodePart(part.picture(), kMaxDepthPixels, ImageChannels::AsStored);
    if (picture.depth() != CV_8U && picture.depth() != CV_16U) return {};
    if (picture.channels() >= 3) cv::extractChannel(picture, picture, 1); // grey in colours
    return picture.channels() == 1 ? picture : cv::Mat();
}

RawDepth depthOfJpeg(DepthPart part, int photoOrientation) {
    RawDepth raw;
    raw.part = std::move(part);
    const cv::Mat samples = samplesOf(raw.part);
    const int orientation = raw.part.orientation == 0 ? photoOrientation : raw.part.orientation;
    if (samples.empty()) {
        raw.failure = "it is damaged";
    } else {
        raw.samples = upright(samples, orientation);
    }
    return raw;
}

std::optional<RawDepth> depthOfHeif(string_view bytes, ImageFormat format) {
    RawDepth raw;
    raw.part.form =
        format == ImageFormat::Avif ? EmbeddedDepthForm::Avif : EmbeddedDepthForm::AppleHeic;
    try {
        const std::optional<HeifDepth> depth = HeifFile(bytes).decodeDepth(kMaxDepthPixels);
        if (!depth) return std::nullopt;
        raw.samples = depth->samples;
        raw.part.isNearBright = !depth->isDistance;
        raw.part.isDistance = depth->isDistance;
        raw.part.nearest = depth->zNear;
        raw.part.farthest = depth->zFar;
    } catch (const PictureFailure& failure) {
        raw.failure = failure.what();
    }
    return raw;
}

// Relative inverse depth of a sample v of 0..1.
//   RangeInverse: v = (1/near - 1/Z) / (1/near - 1/far)       -> 1 - v
//   RangeLinear:  Z = near + v (far - near), (1/Z - 1/far) / (1/near - 1/far)
//                                                             -> near (1 - v) / Z
class Nearness {
  public:
    explicit Nearness(const DepthPart& part)
        : isNearBright_(part.isNearBright),
          isLinear_(part.isDistance && part.nearest > 0 && part.farthest > part.nearest &&
                    std::isfinite(part.farthest / part.nearest)),
          ratio_(isLinear_ ? part.farthest / part.nearest : 1) {}
    float operator()(double v) const {
        if (isNearBright_) return static_cast<float>(v);
        return static_cast<float>(isLinear_ ? (1 - v) / (1 + v * (ratio_ - 1)) : 1 - v);
    }

  private:
    bool isNearBright_;
    bool isLinear_;
    double ratio_;
};

cv::Mat depthMapOf(const RawDepth& raw) {
    const Nearness nearness(raw.part);
    const int levels = raw.samples.depth() == CV_8U ? 256 : 65536;
    std::vector<float> table(static_cast<std::size_t>(levels));
    for (int i = 0; i < levels; ++i)
        table[static_cast<std::size_t>(i)] = nearness(i / (levels - 1.0));
    const auto look = [&](auto sample) { return table[sample]; };
    return levels == 256 ? mapped<std::uint8_t, float>(raw.samples, look)
                         : mapped<std::uint16_t, float>(raw.samples, look);
}

// Without the extremes, which may be single px.
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

cv::Size uprightSize(const ImageHeader& header) {
    const cv::Size size(static_cast<int>(std::min<std::uint64_t>(header.columns, kMaxImageSide)),
                        static_cast<int>(std::min<std::uint64_t>(header.rows, kMaxImageSide)));
    return header.orientation >= 5 ? cv::Size(size.height, size.width) : size;
}

void addUnused(Notes* notes, const std::string& what, const std::string& why) {
    addNote(notes, NoteCode::LeftOut, what + " in the file is not used: " + why);
}

// Near and Far are not metres: the depth is relative, and 1 and 1000 keep inverse depth nearly
// linear from 1 to 0.
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

std::string EmbeddedDepth::text() const {
    return std::string(nameOf(form)) + ", " + sizeText(depth.size()) + " px";
}

std::optional<EmbeddedDepth> readEmbeddedDepth(const PhotoFile& photo, Notes* notes) try {
    return withinMemory(photo.path(), [&]() -> std::optional<EmbeddedDepth> {
        const string_view bytes = photo.look();
        const ImageFormat format = imageFormat(bytes);
        std::optional<RawDepth> raw;
        cv::Size photoSize;
        if (format == ImageFormat::Jpeg) {
            std::optional<DepthPart> part = findDepthPart(bytes);
            if (!part) return std::nullopt;
            const ImageHeader header = readImageHeader(bytes, "");
            photoSize = uprightSize(header);
            raw = depthOfJpeg(std::move(*part), header.orientation);
        } else if (format == ImageFormat::Heic || format == ImageFormat::Avif) {
            raw = depthOfHeif(bytes, format);
            if (raw) photoSize = uprightSize(readImageHeader(bytes, ""));
        }
        if (!raw || photoSize.empty()) return std::nullopt;
        EmbeddedDepth found;
        found.form = raw->part.form;
        if (!raw->failure.empty()) {
            addUnused(notes, std::string("the depth (") + nameOf(found.form) + ")", raw->failure);
            return std::nullopt;
        }
        found.depth = depthMapOf(*raw);
        const std::string what = "the depth (" + found.text() + ")";
        if (!haveOneShape(found.depth.size(), photoSize)) {
            addUnused(notes, what,
                      "its shape is not that of the photo, " + sizeText(photoSize) + " px");
            return std::nullopt;
        }
        if (isFlat(found.depth)) {
            addUnused(notes, what, "it is flat");
            return std::nullopt;
        }
        return found;
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
            addUnused(notes, "the sharp original",
                      result.empty() ? "it is damaged" : "its shape is not that of the photo");
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
                        " px are too many for JPEG, expected sides of at most " +
                        std::to_string(kMaxImageSide) + " px");
    }
    if (!haveOneShape(depth.size(), photo.size())) {
        throw Error(ErrorCode::Mismatch, "depth",
                    "has " + sizeText(depth.size()) + " px, expected the shape of the photo's " +
                        sizeText(photo.size()) + " px");
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
