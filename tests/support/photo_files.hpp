#pragma once

#include "support/heif_files.hpp"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// JPEG files with depth inside, made byte by byte as phones write them.
namespace altiro3D::test {

inline std::string toBase64(std::string_view bytes) {
    constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits =
                bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63U];
    }
    return text;
}

inline std::string jpegSegment(unsigned marker, const std::string& body) {
    return '\xff' + bigEndian(marker, 1) + bigEndian(body.size() + 2, 2) + body;
}

/// The JPEG with segments directly after its start.
inline std::string withSegments(const std::string& jpeg, const std::string& segments) {
    return jpeg.substr(0, 2) + segments + jpeg.substr(2);
}

inline std::string exifSegment(unsigned orientation) {
    return jpegSegment(0xe1, std::string("Exif\0\0II*\0\10\0\0\0\1\0\x12\1\3\0\1\0\0\0", 24) +
                                 littleEndian(orientation, 4) + std::string(4, '\0'));
}

inline std::string xmpSegment(const std::string& xmp) {
    return jpegSegment(0xe1, std::string("http://ns.adobe.com/xap/1.0/\0", 29) + xmp);
}

/// Extended XMP in parts of so many bytes.
inline std::string moreXmpSegments(const std::string& xmp, std::size_t partBytes = 60000,
                                   const std::string& guid = "0123456789ABCDEF0123456789ABCDEF") {
    std::string segments;
    for (std::size_t at = 0; at < xmp.size(); at += partBytes) {
        segments += jpegSegment(0xe1, std::string("http://ns.adobe.com/xmp/extension/\0", 35) +
                                          guid + bigEndian(xmp.size(), 4) + bigEndian(at, 4) +
                                          xmp.substr(at, partBytes));
    }
    return segments;
}

/// XMP around the attributes and elements of one description.
inline std::string xmpOf(const std::string& attributes, const std::string& elements = "") {
    return "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF "
           "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\"><rdf:Description " +
           attributes + ">" + elements + "</rdf:Description></rdf:RDF></x:xmpmeta>";
}

struct DynamicItem {
    std::string semantic; ///< "Depth", "GainMap", ...; empty: only the URI tells.
    std::string bytes;
    std::string uri;
};

/// A photo of a Pixel.
/// @param isOld the first generation: another namespace, elements instead of attributes
inline std::string dynamicDepthPhoto(const std::string& jpeg, const std::vector<DynamicItem>& items,
                                     const std::string& format = "RangeInverse",
                                     double nearest = 0.5, double farthest = 10,
                                     bool isOld = false) {
    const std::string space =
        std::string("http://ns.google.com/photos/") + (isOld ? "dd/1.0/" : "1.0/") + "container/";
    const auto entry = [&](const std::string& semantic, std::size_t length,
                           const std::string& uri) {
        if (isOld) {
            return "<rdf:li rdf:parseType='Resource'><Item:Mime>image/jpeg</Item:Mime>"
                   "<Item:Length>" +
                   std::to_string(length) + "</Item:Length><Item:DataURI>" + uri +
                   "</Item:DataURI></rdf:li>";
        }
        return "<rdf:li rdf:parseType='Resource'><Container:Item Item:Mime='image/jpeg' "
               "Item:Length='" +
               std::to_string(length) + "' Item:Semantic='" + semantic + "'/></rdf:li>";
    };
    std::string list = entry("Primary", 0, "primary_image");
    std::string tail;
    for (const DynamicItem& item : items) {
        list += entry(item.semantic, item.bytes.size(), item.uri);
        tail += item.bytes;
    }
    const std::string directory =
        xmpOf("xmlns:Container='" + space + "' xmlns:Item='" + space + "item/'",
              "<Container:Directory><rdf:Seq>" + list + "</rdf:Seq></Container:Directory>");
    const std::string device =
        xmpOf("xmlns:DepthMap='http://ns.google.com/photos/dd/1.0/depthmap/'",
              "<DepthMap:Format>" + format + "</DepthMap:Format><DepthMap:Near>" +
                  std::to_string(nearest) + "</DepthMap:Near><DepthMap:Far>" +
                  std::to_string(farthest) + "</DepthMap:Far>");
    return withSegments(jpeg, xmpSegment(directory) + moreXmpSegments(device)) + tail;
}

/// A photo by lens blur. `original`: the sharp one; empty: none.
inline std::string gDepthPhoto(const std::string& jpeg, const std::string& depth,
                               const std::string& format = "RangeInverse", double nearest = 0.5,
                               double farthest = 10, const std::string& original = "") {
    const std::string facts =
        xmpOf("xmlns:GDepth='http://ns.google.com/photos/1.0/depthmap/' GDepth:Format='" + format +
              "' GDepth:Near='" + std::to_string(nearest) + "' GDepth:Far='" +
              std::to_string(farthest) + "' GDepth:Mime='image/png'");
    std::string data = "xmlns:GDepth=\"http://ns.google.com/photos/1.0/depthmap/\" "
                       "xmlns:GImage=\"http://ns.google.com/photos/1.0/image/\" ";
    if (!original.empty()) data += "GImage:Data=\"" + toBase64(original) + "\" ";
    data += "GDepth:Data=\"" + toBase64(depth) + "\"";
    return withSegments(jpeg, xmpSegment(facts) + moreXmpSegments(xmpOf(data), 5000));
}

/// A JPEG whose XMP says what an iPhone's further pictures are.
inline std::string appleAuxiliary(const std::string& jpeg, const std::string& type,
                                  const std::string& subtype = "") {
    return withSegments(
        jpeg, xmpSegment(xmpOf("xmlns:apdi='http://ns.apple.com/pixeldatainfo/1.0/'",
                               "<apdi:AuxiliaryImageType>" + type + "</apdi:AuxiliaryImageType>" +
                                   (subtype.empty() ? ""
                                                    : "<apdi:AuxiliaryImageSubType>" + subtype +
                                                          "</apdi:AuxiliaryImageSubType>"))));
}

/// A multi-picture file: the photo, then further pictures, as by an iPhone.
/// @param type of the pictures; 0x020002: several eyes
inline std::string appleJpeg(const std::string& jpeg, const std::vector<std::string>& pictures,
                             unsigned type = 0) {
    const std::size_t count = pictures.size() + 1;
    const auto index = [&](std::size_t photoBytes, std::size_t mpfAt) {
        std::string list;
        std::size_t at = photoBytes;
        list += bigEndian(type == 0 ? 0x030000 : 0x20000000 + type, 4) + bigEndian(photoBytes, 4) +
                std::string(8, '\0');
        for (const std::string& picture : pictures) {
            list += bigEndian(type, 4) + bigEndian(picture.size(), 4) + bigEndian(at - mpfAt, 4) +
                    std::string(4, '\0');
            at += picture.size();
        }
        return std::string("MPF\0MM\0*\0\0\0\10\0\1", 14) + bigEndian(0xb002, 2) + bigEndian(7, 2) +
               bigEndian(16 * count, 4) + bigEndian(8 + 2 + 12 + 4, 4) + std::string(4, '\0') +
               list;
    };
    const std::size_t photoBytes = jpeg.size() + 4 + index(0, 0).size();
    std::string file = withSegments(jpeg, jpegSegment(0xe2, index(photoBytes, 10)));
    for (const std::string& picture : pictures)
        file += picture;
    return file;
}

/// An MPO of a 3D camera.
inline std::string mpoFile(const std::string& left, const std::string& right) {
    return appleJpeg(left, {right}, 0x020002);
}

/// The header of JPS. @param flags 1 half height, 2 half width, 4 left eye first
inline std::string jpsSegment(unsigned layout, unsigned flags, unsigned separation = 0,
                              unsigned media = 1) {
    return jpegSegment(0xe3, "_JPSJPS_" + bigEndian(4, 2) + bigEndian(separation, 1) +
                                 bigEndian(flags, 1) + bigEndian(layout, 1) + bigEndian(media, 1) +
                                 bigEndian(4, 2) + "test");
}

} // namespace altiro3D::test
