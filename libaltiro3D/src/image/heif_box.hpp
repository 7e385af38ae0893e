#pragma once

#include "base/byte_reader.hpp"

#include <cstdint>
#include <string_view>

/// Boxes of HEIC and AVIF files (ISO/IEC 14496-12).
namespace altiro3D {

constexpr std::size_t kBoxHeader = 8;
constexpr std::size_t kVersion = 4; ///< Bytes of version and flags, at the start of some bodies.

/// A box inside a file; empty if it was not found.
struct Box {
    std::uint64_t at = 0;
    std::uint64_t body = 0; ///< After the header of 8 or 16 bytes.
    std::uint64_t end = 0;
    bool isFound() const { return end > 0; }
};

/// The first box of a type between two positions. A size of 0 reaches to the end.
inline Box findBox(const ByteReader& reader, std::string_view type, std::uint64_t at,
                   std::uint64_t end) {
    while (at + kBoxHeader <= end) {
        const std::uint64_t stated = reader.u32(at);
        const std::uint64_t header = stated == 1 ? 2 * kBoxHeader : kBoxHeader;
        const std::uint64_t size = stated == 1   ? reader.u64(at + kBoxHeader)
                                   : stated == 0 ? end - at
                                                 : stated;
        if (size < header || size > end - at) break;
        if (reader.text(at + 4, 4) == type) return {at, at + header, at + size};
        at += size;
    }
    return {};
}

inline Box findBox(const ByteReader& reader, std::string_view type, const Box& inside,
                   std::uint64_t skip = 0) {
    return findBox(reader, type, inside.body + skip, inside.end);
}

/// Calls `visit(box)` for every box of a type inside another one.
template <class Visit>
void forEachBox(const ByteReader& reader, std::string_view type, const Box& inside,
                std::uint64_t skip, const Visit& visit) {
    for (std::uint64_t at = inside.body + skip;;) {
        const Box box = findBox(reader, type, at, inside.end);
        if (!box.isFound()) return;
        visit(box);
        at = box.end;
    }
}

} // namespace altiro3D
