#pragma once

#include "base/byte_reader.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace altiro3D {

/// Skips the entropy-coded data of a JPEG that starts at `at`; returns the position of the next
/// marker's 0xFF, or the number of bytes.
inline std::size_t skipEntropyData(std::string_view bytes, std::size_t at) {
    while (at + 1 < bytes.size()) {
        const void* const found = std::memchr(bytes.data() + at, 0xff, bytes.size() - 1 - at);
        if (found == nullptr) break;
        at = static_cast<std::size_t>(static_cast<const char*>(found) - bytes.data());
        const auto code = static_cast<unsigned char>(bytes[at + 1]);
        if (code == 0xff) { // a fill byte
            ++at;
        } else if (code == 0 ||
                   (code >= 0xd0 && code <= 0xd7)) { // a stuffed byte or a restart marker
            at += 2;
        } else {
            return at;
        }
    }
    return bytes.size();
}

/// Where the walk over a JPEG ended.
struct JpegEnd {
    bool hasEnd = false;         ///< There is an end-of-image marker.
    std::size_t after = 0;       ///< Position after that marker; all bytes without one.
    std::size_t usableBytes = 0; ///< Without a last segment that is cut off.
    unsigned scans = 0;          ///< Scans after which something follows.
};

/// Visits the segments of a JPEG up to its end-of-image marker. Any bytes give a result; junk
/// between segments is skipped.
/// @param bytes the file, or what follows its start in a longer file
/// @param visit `bool(unsigned marker, std::size_t at, std::string_view body)`: a segment, the
///        position of its body, and the body; false ends the walk
template <class Visit>
JpegEnd walkJpeg(std::string_view bytes, const Visit& visit) {
    const ByteReader reader(bytes, false);
    JpegEnd end;
    end.after = bytes.size();
    end.usableBytes = bytes.size();
    std::size_t at = 2;
    while (at + 1 < bytes.size()) {
        const unsigned marker = reader.u8(at + 1);
        if (reader.u8(at) != 0xff || marker == 0xff) {
            ++at;
            continue;
        }
        if (marker == 0xd9) {
            end.hasEnd = true;
            end.after = at + 2;
            break;
        }
        if (marker == 0 || marker == 1 ||
            (marker >= 0xd0 && marker <= 0xd8)) { // markers without a body
            at += 2;
            continue;
        }
        const std::size_t size = reader.u16(at + 2);
        if (!reader.holds(at + 2, std::max<std::size_t>(size, 2))) {
            end.usableBytes = at;
            break;
        }
        if (size < 2) {
            at += 2;
            continue;
        }
        if (!visit(marker, at + 4, reader.text(at + 4, size - 2))) break;
        at += 2 + size;
        if (marker == 0xda) {
            at = skipEntropyData(bytes, at);
            if (at < bytes.size()) ++end.scans;
        }
    }
    return end;
}

/// Visits the chunks of a PNG up to the first one that is cut off.
/// @param visit `bool(std::string_view name, std::uint64_t at, std::uint64_t size)`: a chunk, the
///        position and the size of its data; false ends the walk
template <class Visit>
void walkPng(std::string_view bytes, const Visit& visit) {
    const ByteReader reader(bytes, false);
    for (std::uint64_t at = 8; reader.holds(at, 12);) {
        const std::uint64_t size = reader.u32(at);
        if (!reader.holds(at + 8, size + 4) || !visit(reader.text(at + 4, 4), at + 8, size)) return;
        at += size + 12;
    }
}

/// Visits the chunks of a WebP. The data of the last one may be cut off.
/// @param visit as for walkPng()
template <class Visit>
void walkWebP(std::string_view bytes, const Visit& visit) {
    const ByteReader reader(bytes, true);
    for (std::uint64_t at = 12; reader.holds(at, 8);) {
        const std::uint64_t size = reader.u32(at + 4);
        if (!visit(reader.text(at, 4), at + 8, size)) return;
        at += 8 + size + (size & 1);
    }
}

} // namespace altiro3D
