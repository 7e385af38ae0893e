#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace altiro3D {

/// Reads numbers out of the bytes of a file with bounds checks; bytes beyond the end read as 0.
class ByteReader {
  public:
    ByteReader(std::string_view bytes, bool littleEndian)
        : bytes_(bytes), littleEndian_(littleEndian) {}

    /// A whole number without sign. @param size its length in bytes, 0..8
    std::uint64_t number(std::uint64_t at, unsigned size) const {
        if (!holds(at, size)) return 0;
        std::uint64_t value = 0;
        for (unsigned i = 0; i < size; ++i) {
            const std::size_t from =
                static_cast<std::size_t>(at) + (littleEndian_ ? size - 1 - i : i);
            value = value << 8 | static_cast<unsigned char>(bytes_[from]);
        }
        return value;
    }
    unsigned u8(std::uint64_t at) const { return static_cast<unsigned>(number(at, 1)); }
    unsigned u16(std::uint64_t at) const { return static_cast<unsigned>(number(at, 2)); }
    std::uint32_t u32(std::uint64_t at) const { return static_cast<std::uint32_t>(number(at, 4)); }
    std::uint64_t u64(std::uint64_t at) const { return number(at, 8); }
    /// Whether all these bytes exist.
    bool holds(std::uint64_t at, std::uint64_t size) const {
        return at <= bytes_.size() && size <= bytes_.size() - at;
    }
    /// These bytes; none if some of them do not exist.
    std::string_view text(std::uint64_t at, std::uint64_t size) const {
        return holds(at, size)
                   ? bytes_.substr(static_cast<std::size_t>(at), static_cast<std::size_t>(size))
                   : std::string_view();
    }

  private:
    std::string_view bytes_;
    bool littleEndian_;
};

} // namespace altiro3D
