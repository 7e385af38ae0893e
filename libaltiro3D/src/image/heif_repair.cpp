#include "image/heif_repair.hpp"

#include "base/byte_reader.hpp"

#include <algorithm>
#include <cstdint>
#include <set>

namespace altiro3D {

namespace {

using std::string_view;

constexpr std::size_t kBoxHeader = 8;
constexpr std::size_t kFullBoxHeader = 12; // with version and flags
constexpr int kMaxBoxes = 10000;

// A box inside a file; empty if it was not found.
struct Box {
    std::size_t at = 0;
    std::size_t size = 0; // with the header
};

// The first box of a type between two positions. Boxes with 64-bit sizes hold only media data.
Box findBox(const ByteReader& reader, string_view type, std::uint64_t at, std::uint64_t end) {
    for (int i = 0; i < kMaxBoxes && at + kBoxHeader <= end; ++i) {
        const std::uint64_t size = reader.u32(at) == 1 ? reader.u64(at + 8) : reader.u32(at);
        if (size < kBoxHeader || size > end - at) break;
        if (reader.text(at + 4, 4) == type) {
            return {static_cast<std::size_t>(at), static_cast<std::size_t>(size)};
        }
        at += size;
    }
    return {};
}

void append(std::string& bytes, std::uint64_t value, unsigned size) {
    for (unsigned i = size; i-- > 0;)
        bytes.push_back(static_cast<char>(value >> (8 * i) & 0xffU));
}

// The items of the type "tmap" (tone-mapped pictures).
std::set<std::uint64_t> toneMappedItems(const ByteReader& reader, const Box& iinf) {
    std::set<std::uint64_t> items;
    const unsigned version = reader.u8(iinf.at + kBoxHeader);
    std::uint64_t at = iinf.at + kFullBoxHeader + (version == 0 ? 2 : 4);
    const std::uint64_t end = iinf.at + iinf.size;
    for (int i = 0; i < kMaxBoxes; ++i) {
        const Box infe = findBox(reader, "infe", at, end);
        if (infe.size == 0) break;
        const unsigned idSize = reader.u8(infe.at + kBoxHeader) >= 3 ? 4 : 2;
        const std::uint64_t id = infe.at + kFullBoxHeader;
        if (reader.text(id + idSize + 2, 4) == "tmap") items.insert(reader.number(id, idSize));
        at = infe.at + infe.size;
    }
    return items;
}

} // namespace

std::string repairedHeif(string_view bytes) {
    const ByteReader reader(bytes, false);
    const Box meta = findBox(reader, "meta", 0, bytes.size());
    if (meta.size < kFullBoxHeader) return {};
    const std::uint64_t inside = meta.at + kFullBoxHeader;
    const std::uint64_t end = meta.at + meta.size;
    const Box iref = findBox(reader, "iref", inside, end);
    const Box pitm = findBox(reader, "pitm", inside, end);
    const Box iinf = findBox(reader, "iinf", inside, end);
    if (iref.size < kFullBoxHeader || pitm.size < kFullBoxHeader + 2 || iinf.size == 0) return {};
    const unsigned pitmId = reader.u8(pitm.at + kBoxHeader) == 0 ? 2 : 4;
    const std::uint64_t primary = reader.number(pitm.at + kFullBoxHeader, pitmId);
    const std::set<std::uint64_t> toneMapped = toneMappedItems(reader, iinf);

    const unsigned idSize = reader.u8(iref.at + kBoxHeader) == 0 ? 2 : 4;
    std::string kept(bytes.substr(iref.at, kFullBoxHeader));
    std::uint64_t at = iref.at + kFullBoxHeader;
    const std::uint64_t irefEnd = iref.at + iref.size;
    while (at < irefEnd) {
        const std::uint64_t size = reader.u32(at);
        const std::uint64_t from = at + kBoxHeader;
        const std::uint64_t count = reader.u16(from + idSize);
        const std::uint64_t targets = from + idSize + 2;
        if (size < kBoxHeader + idSize + 2 || size > irefEnd - at ||
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
    const std::size_t left = iref.size - kept.size();
    if (left < kBoxHeader) return {};
    std::string length;
    append(length, kept.size(), 4);
    kept.replace(0, 4, length);
    append(kept, left, 4);
    kept += "free";
    kept.resize(iref.size, '\0');
    std::string repaired(bytes);
    repaired.replace(iref.at, iref.size, kept);
    return repaired;
}

} // namespace altiro3D
