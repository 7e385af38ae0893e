#pragma once

#include "support/picture_files.hpp"

#include <string>
#include <string_view>
#include <vector>

/// HEIC and AVIF files made box by box. The coded pictures in them are those of heif-enc (x265,
/// aom) of a picture in four colours, and of a ramp.
namespace altiro3D::test {

inline std::string heifBox(const std::string& type, const std::string& body) {
    return bigEndian(body.size() + 8, 4) + type + body;
}

/// A box with version and flags.
inline std::string heifFullBox(const std::string& type, unsigned version, const std::string& body) {
    return heifBox(type, bigEndian(version, 1) + std::string(3, '\0') + body);
}

/// Base64, without checks.
inline std::string fromBase64(std::string_view text) {
    constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned bits = 0;
    int count = 0;
    for (const char c : text) {
        const std::size_t digit = kDigits.find(c);
        if (digit == std::string_view::npos) break;
        bits = bits << 6 | static_cast<unsigned>(digit);
        if ((count += 6) < 8) continue;
        count -= 8;
        bytes.push_back(static_cast<char>(bits >> count & 0xffU));
    }
    return bytes;
}

struct HeifItem {
    unsigned id = 1;
    std::string type; ///< "hvc1", "av01", "Exif", "mime", "tmap", ...
    std::string data;
    std::vector<std::string> properties; ///< Boxes: ispe, hvcC, irot, auxC, ...
    std::string contentType;             ///< Of "mime".
};

struct HeifReference {
    std::string type;
    unsigned from = 0;
    std::vector<unsigned> to;
};

inline std::string ispe(unsigned columns, unsigned rows) {
    return heifFullBox("ispe", 0, bigEndian(columns, 4) + bigEndian(rows, 4));
}

/// Turns by so many quarters, anticlockwise.
inline std::string irot(unsigned quarters) {
    return heifBox("irot", bigEndian(quarters, 1));
}

inline std::string auxC(const std::string& type) {
    return heifFullBox("auxC", 0, type + '\0');
}

inline std::string nclx(unsigned primaries, unsigned transfer, unsigned matrix = 6) {
    return heifBox("colr", "nclx" + bigEndian(primaries, 2) + bigEndian(transfer, 2) +
                               bigEndian(matrix, 2) + '\x80');
}

inline std::string iccBox(const std::string& profile) {
    return heifBox("colr", "prof" + profile);
}

/// A picture of 128 x 64 px, HEVC. @param coded its data, base64
inline HeifItem hevcItem(unsigned id, const std::string& coded) {
    const std::string settings =
        "AQNwAAAAAAAAAAAAHvAA/P34+AAADwMgAAEAGEABDAH//wNwAAADAJAAAAMAAAMAHroCQCEAAQArQgEB"
        "A3AAAAMAkAAAAwAAAwAeoBAgQWW6kkprm4EBAwIAAAMAAgAAAwACECIAAQAHRAHBcrAiQA==";
    return {
        id, "hvc1", fromBase64(coded), {heifBox("hvcC", fromBase64(settings)), ispe(128, 64)}, ""};
}

/// As hevcItem(), as AV1.
inline HeifItem av1Item(unsigned id, const std::string& coded) {
    return {id,
            "av01",
            fromBase64(coded),
            {heifBox("av1C", fromBase64("gQAMAA==")), ispe(128, 64)},
            ""};
}

/// 128 x 64 px: red (200, 40, 40), green (40, 180, 60); below, blue (40, 60, 200) and light grey
/// 230.
inline HeifItem hevcColours(unsigned id) {
    return hevcItem(
        id, "AAAAhigBrwT47FrpOu3/39////SZjsv7Kw0nz+KD+JG1L/YlL//8rx0CnR+jLi/ihsK3R5E4ToAL8VeF"
            "q7ZUgSwyhKap4RG+h86fonypPEfAtaArKtDNljdvDwxTiNN/TF+38qNmaBye197/Zd//8bo//04nt31U"
            "hX+zvZxPjwC6+144FMn+DItQ");
}

/// 128 x 64 px: a ramp from black on the left to white.
inline HeifItem hevcRamp(unsigned id) {
    return hevcItem(
        id, "AAAAQSgBrwngI8Lhs57MR+09aKuvLp9Y/OSi1sDnCZBF9+sPzp9oIA82Yxh+UUR0N4aO3+3Mo5SSYNUG"
            "X+9/2EDh4X/A");
}

/// As hevcColours(), as AV1.
inline HeifItem av1Colours(unsigned id) {
    return av1Item(
        id, "EgAKCRgZf/7BAgIGhDIxEaABBBBCALRVVYPpKVyB9t52Ctq6/z4AUjK9+WUrcRF5qQJM9QL+tYP33lQL"
            "fvJ1SA==");
}

/// As hevcRamp(), as AV1.
inline HeifItem av1Ramp(unsigned id) {
    return av1Item(
        id, "EgAKCRgZf/7BAgIGhDIsEyADDDDCALXEDruaE3aricswoAFbOLCwZ+CalEpu3bTNvAKcZjlheubJy4A=");
}

/// The file. The first item is the main picture.
/// @param groups the box `grpl`; empty: none
inline std::string heifFile(const std::string& brand, const std::vector<HeifItem>& items,
                            const std::vector<HeifReference>& references = {},
                            const std::string& groups = "") {
    std::string infos;
    std::string properties;
    std::string associations;
    std::string data;
    unsigned propertyCount = 0;
    for (const HeifItem& item : items) {
        infos += heifFullBox("infe", 2,
                             bigEndian(item.id, 2) + bigEndian(0, 2) + item.type + '\0' +
                                 (item.contentType.empty() ? "" : item.contentType + '\0'));
        associations += bigEndian(item.id, 2) + bigEndian(item.properties.size(), 1);
        for (const std::string& property : item.properties) {
            properties += property;
            associations += bigEndian(++propertyCount, 1);
        }
        data += item.data;
    }
    std::string links;
    for (const HeifReference& reference : references) {
        std::string body = bigEndian(reference.from, 2) + bigEndian(reference.to.size(), 2);
        for (const unsigned target : reference.to)
            body += bigEndian(target, 2);
        links += heifBox(reference.type, body);
    }
    const std::string ftyp = heifBox("ftyp", brand + std::string(4, '\0') + "mif1" + brand);
    const auto metaAt = [&](std::size_t dataAt) { // its size does not depend on the offsets
        std::string places = std::string("\x44\x00", 2) + bigEndian(items.size(), 2);
        for (const HeifItem& item : items) {
            places += bigEndian(item.id, 2) + bigEndian(0, 2) + bigEndian(1, 2) +
                      bigEndian(dataAt, 4) + bigEndian(item.data.size(), 4);
            dataAt += item.data.size();
        }
        return heifFullBox(
            "meta", 0,
            heifFullBox("hdlr", 0, std::string(4, '\0') + "pict" + std::string(13, '\0')) +
                heifFullBox("pitm", 0, bigEndian(items.front().id, 2)) +
                heifFullBox("iloc", 0, places) +
                heifFullBox("iinf", 0, bigEndian(items.size(), 2) + infos) +
                (links.empty() ? "" : heifFullBox("iref", 0, links)) +
                heifBox("iprp",
                        heifBox("ipco", properties) +
                            heifFullBox("ipma", 0, bigEndian(items.size(), 4) + associations)) +
                groups);
    };
    const std::size_t dataAt = ftyp.size() + metaAt(0).size() + 8;
    return ftyp + metaAt(dataAt) + heifBox("mdat", data);
}

/// The group of the two eyes' pictures.
inline std::string stereoGroup(unsigned left, unsigned right) {
    return heifBox("grpl", heifFullBox("ster", 0,
                                       bigEndian(77, 4) + bigEndian(2, 4) + bigEndian(left, 4) +
                                           bigEndian(right, 4)));
}

/// A spatial photo. @param left, right 1 = hevcColours(), 2 = hevcRamp(); the main picture is 1
inline std::string spatialHeic(unsigned left = 1, unsigned right = 2) {
    return heifFile("heic", {hevcColours(1), hevcRamp(2)}, {}, stereoGroup(left, right));
}

/// A portrait of an iPhone: the picture, its depth, and the XMP of the depth.
inline std::string appleHeic(bool isIos18 = false, const std::vector<std::string>& more = {}) {
    HeifItem photo = hevcColours(1);
    HeifItem depth = hevcRamp(2);
    depth.properties.push_back(auxC("urn:mpeg:hevc:2015:auxid:2"));
    photo.properties.insert(photo.properties.end(), more.begin(), more.end());
    depth.properties.insert(depth.properties.end(), more.begin(), more.end());
    const std::string xmp = "<x:xmpmeta xmlns:x='adobe:ns:meta/'/>";
    if (!isIos18) {
        return heifFile("heic", {photo, depth, {3, "mime", xmp, {}, "application/rdf+xml"}},
                        {{"auxl", 2, {1}}, {"cdsc", 3, {2}}});
    }
    HeifItem gain = hevcRamp(5);
    gain.properties.push_back(auxC("urn:com:apple:photo:2020:aux:hdrgainmap"));
    HeifItem toneMapped{4, "tmap", std::string(62, '\0'), {ispe(128, 64)}, ""};
    return heifFile(
        "heic", {photo, depth, {3, "mime", xmp, {}, "application/rdf+xml"}, toneMapped, gain},
        {{"auxl", 2, {1, 4}}, {"auxl", 5, {1}}, {"cdsc", 3, {1, 4}}, {"dimg", 4, {1, 5}}});
}

} // namespace altiro3D::test
