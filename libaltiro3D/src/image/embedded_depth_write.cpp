// Dynamic Depth 1.0: a JPEG whose XMP lists what follows it.

#include "altiro3D/image_io.hpp"

#include "altiro3D/file_io.hpp"
#include "base/byte_reader.hpp"
#include "base/checks.hpp"
#include "base/memory_errors.hpp"
#include "base/text.hpp"
#include "image/image_codecs.hpp"
#include "image/image_header.hpp"
#include "image/picture_shape.hpp"

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace altiro3D {

namespace {

// Near and Far are not metres: the depth is relative, and 1 and 1000 keep inverse depth nearly
// linear from 1 to 0.
std::string xmpFor(std::size_t depthBytes) {
    const std::string photos = "http://ns.google.com/photos/";
    return "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\" x:xmptk=\"altiro3D\">"
           "<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">"
           "<rdf:Description rdf:about=\"\""
           " xmlns:Container=\"" +
           photos +
           "1.0/container/\""
           " xmlns:Item=\"" +
           photos +
           "1.0/container/item/\""
           " xmlns:Device=\"" +
           photos +
           "dd/1.0/device/\""
           " xmlns:Profile=\"" +
           photos +
           "dd/1.0/profile/\""
           " xmlns:Camera=\"" +
           photos +
           "dd/1.0/camera/\""
           " xmlns:DepthMap=\"" +
           photos +
           "dd/1.0/depthmap/\">"
           "<Container:Directory><rdf:Seq>"
           "<rdf:li rdf:parseType=\"Resource\"><Container:Item Item:Mime=\"image/jpeg\""
           " Item:Length=\"0\" Item:Semantic=\"Primary\"/></rdf:li>"
           "<rdf:li rdf:parseType=\"Resource\"><Container:Item Item:Mime=\"image/jpeg\""
           " Item:Length=\"" +
           std::to_string(depthBytes) +
           "\" Item:Semantic=\"Depth\""
           " Item:DataURI=\"android/depthmap\"/></rdf:li>"
           "</rdf:Seq></Container:Directory>"
           "<Device:Profiles><rdf:Seq><rdf:li rdf:parseType=\"Resource\">"
           "<rdf:value rdf:parseType=\"Resource\"><Profile:Type>DepthPhoto</Profile:Type>"
           "<Profile:CameraIndices><rdf:Seq><rdf:li>0</rdf:li></rdf:Seq></Profile:CameraIndices>"
           "</rdf:value><rdf:type>" +
           photos +
           "dd/1.0/device/:Profile</rdf:type>"
           "</rdf:li></rdf:Seq></Device:Profiles>"
           "<Device:Cameras><rdf:Seq><rdf:li rdf:parseType=\"Resource\">"
           "<rdf:value rdf:parseType=\"Resource\"><Camera:DepthMap rdf:parseType=\"Resource\">"
           "<DepthMap:ItemSemantic>Depth</DepthMap:ItemSemantic>"
           "<DepthMap:Format>RangeInverse</DepthMap:Format>"
           "<DepthMap:Units>None</DepthMap:Units>"
           "<DepthMap:Near>1</DepthMap:Near><DepthMap:Far>1000</DepthMap:Far>"
           "<DepthMap:DepthURI>android/depthmap</DepthMap:DepthURI>"
           "</Camera:DepthMap></rdf:value>"
           "<rdf:type>" +
           photos +
           "dd/1.0/device/:Camera</rdf:type>"
           "</rdf:li></rdf:Seq></Device:Cameras>"
           "</rdf:Description></rdf:RDF></x:xmpmeta>";
}

// Position after the start of the image and the JFIF segment, which comes first.
std::size_t startOfMetadata(const std::vector<unsigned char>& jpeg) {
    const ByteReader reader({reinterpret_cast<const char*>(jpeg.data()), jpeg.size()}, false);
    return reader.u16(2) == 0xffe0 ? 4 + reader.u16(4) : 2;
}

} // namespace

void writePhotoWithDepth(const std::filesystem::path& path, const cv::Mat& photo,
                         const cv::Mat& depth) {
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
    orOutOfMemory(path.string(), "does not fit into memory, expected a smaller picture", [&] {
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
}

} // namespace altiro3D
