#include "image/heif_boxes.hpp"

#include "image/heif_box.hpp"

#include <algorithm>
#include <cstdint>
#include <set>

namespace altiro3D {

namespace {

using std::string_view;

void append(std::string& bytes, std::uint64_t value, unsigned size) {
    for (unsigned i = size; i-- > 0;)
        bytes.push_back(static_cast<char>(value >> (8 * i) & 0xffU));
}

// The items of the type "tmap" (tone-mapped pictures).
std::set<std::uint64_t> toneMappedItems(const ByteReader& reader, const Box& iinf) {
    std::set<std::uint64_t> items;
    const unsigned version = reader.u8(iinf.body);
    forEachBox(reader, "infe", iinf, kVersion + (version == 0 ? 2 : 4), [&](const Box& infe) {
        const unsigned idSize = reader.u8(infe.body) >= 3 ? 4 : 2;
        const std::uint64_t id = infe.body + kVersion;
        if (reader.text(id + idSize + 2, 4) == "tmap") items.insert(reader.number(id, idSize));
    });
    return items;
}

} // namespace

std::string repairedHeif(string_view bytes) {
    const ByteReader reader(bytes, false);
    const Box meta = findBox(reader, "meta", 0, bytes.size());
    const Box iref = findBox(reader, "iref", meta, kVersion);
    const Box pitm = findBox(reader, "pitm", meta, kVersion);
    const Box iinf = findBox(reader, "iinf", meta, kVersion);
    // libheif reads iref with the usual header
    if (iref.end < iref.at + kBoxHeader + kVersion || iref.body != iref.at + kBoxHeader ||
        pitm.end < pitm.body + kVersion + 2 || !pitm.isFound() || !iinf.isFound()) {
        return {};
    }
    const unsigned pitmId = reader.u8(pitm.body) == 0 ? 2 : 4;
    const std::uint64_t primary = reader.number(pitm.body + kVersion, pitmId);
    const std::set<std::uint64_t> toneMapped = toneMappedItems(reader, iinf);

    const unsigned idSize = reader.u8(iref.body) == 0 ? 2 : 4;
    const std::size_t irefSize = static_cast<std::size_t>(iref.end - iref.at);
    std::string kept(reader.text(iref.at, kBoxHeader + kVersion));
    std::uint64_t at = iref.body + kVersion;
    while (at < iref.end) {
        const std::uint64_t size = reader.u32(at);
        const std::uint64_t from = at + kBoxHeader;
        const std::uint64_t count = reader.u16(from + idSize);
        const std::uint64_t targets = from + idSize + 2;
        if (size < kBoxHeader + idSize + 2 || size > iref.end - at ||
            count * idSize > at + size - targets) {
            return {};
        }
        const string_view type = reader.text(at + 4, 4);
        bool refersToPrimary = false;
        for (std::uint64_t i = 0; i < count; ++i)
            refersToPrimary |= reader.number(targets + i * idSize, idSize) == primary;
        if ((type == "auxl" || type == "cdsc") && count > 1 && refersToPrimary) {
            append(kept, kBoxHeader + 2 * idSize + 2, 4);
            kept += type;
            kept += reader.text(from, idSize);
            append(kept, 1, 2);
            append(kept, primary, idSize);
        } else if (type != "dimg" || toneMapped.count(reader.number(from, idSize)) == 0) {
            kept += reader.text(at, size);
        }
        at += size;
    }
    const std::size_t left = irefSize - kept.size();
    if (left < kBoxHeader) return {};
    std::string length;
    append(length, kept.size(), 4);
    kept.replace(0, 4, length);
    append(kept, left, 4);
    kept += "free";
    kept.resize(irefSize, '\0');
    std::string repaired(bytes);
    repaired.replace(static_cast<std::size_t>(iref.at), irefSize, kept);
    return repaired;
}

unsigned heifFrames(string_view bytes) {
    const ByteReader reader(bytes, false);
    unsigned most = 0;
    forEachBox(reader, "trak", findBox(reader, "moov", 0, bytes.size()), 0, [&](const Box& track) {
        Box box = track;
        for (const char* const type : {"mdia", "minf", "stbl", "stsz"})
            box = findBox(reader, type, box);
        if (box.isFound()) most = std::max(most, reader.u32(box.body + kVersion + 4));
    });
    return most;
}

std::optional<HeifEyes> findHeifEyes(string_view bytes) {
    const ByteReader reader(bytes, false);
    const Box meta = findBox(reader, "meta", 0, bytes.size());
    const Box groups = findBox(reader, "grpl", meta, kVersion);
    const Box pair = findBox(reader, "ster", groups);
    // {version and flags, u32 number of the group, u32 count, u32 items...}
    const std::uint64_t facts = pair.body + kVersion;
    if (!pair.isFound() || pair.end < facts + 16 || reader.u32(facts + 4) != 2) return std::nullopt;
    const HeifEyes eyes{reader.u32(facts + 8), reader.u32(facts + 12)};
    if (eyes.left == eyes.right) return std::nullopt;
    return eyes;
}

} // namespace altiro3D
