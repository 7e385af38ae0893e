#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <zlib.h>

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

/// Reads bits, the most significant one of a byte first; those beyond the end are 0.
class BitReader {
  public:
    explicit BitReader(std::string_view bytes) : reader_(bytes, false) {}

    std::uint64_t bits(unsigned count) {
        std::uint64_t value = 0;
        for (; count > 0; --count, ++at_)
            value = value << 1 | (reader_.u8(at_ / 8) >> (7 - at_ % 8) & 1U);
        return value;
    }
    void skip(unsigned count) { at_ += count; }
    /// Exponential-Golomb code ue(v).
    std::uint64_t code() {
        unsigned zeros = 0;
        while (zeros < 32 && bits(1) == 0)
            ++zeros;
        return (std::uint64_t{1} << zeros) - 1 + bits(zeros);
    }

  private:
    ByteReader reader_;
    std::uint64_t at_ = 0;
};

/// A NAL unit of H.264 or HEVC without its emulation prevention bytes (0 0 3 stands for 0 0).
inline std::string withoutPrevention(std::string_view nal) {
    std::string bytes;
    int zeros = 0;
    for (const char c : nal) {
        const bool isPrevention = zeros >= 2 && c == 3;
        zeros = c == 0 ? zeros + 1 : 0;
        if (!isPrevention) bytes.push_back(c);
    }
    return bytes;
}

/// The beginning of what a zlib stream holds.
struct Inflated {
    std::string bytes;
    bool isWhole = false; ///< The stream ends here, undamaged.
};

/// The first bytes of what a zlib stream holds; fewer if it is shorter or damaged.
/// @param window as for inflateInit2()
inline Inflated inflated(std::string_view packed, std::uint64_t most, int window) {
    struct Inflater {
        z_stream stream{};
        bool isOpen;
        explicit Inflater(int window) : isOpen(inflateInit2(&stream, window) == Z_OK) {}
        Inflater(const Inflater&) = delete;
        Inflater& operator=(const Inflater&) = delete;
        ~Inflater() {
            if (isOpen) inflateEnd(&stream);
        }
    };
    Inflater inflater(window);
    Inflated result;
    z_stream& stream = inflater.stream;
    int status = inflater.isOpen ? Z_OK : Z_MEM_ERROR;
    while (status == Z_OK && result.bytes.size() < most) {
        // not all at once: the caller may know the number of bytes from a file that lies
        constexpr std::size_t kStep = std::size_t{1} << 16;
        const std::size_t done = result.bytes.size();
        result.bytes.resize(std::min<std::uint64_t>(most, done + kStep));
        const auto in = static_cast<uInt>(std::min(packed.size(), kStep));
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
        stream.avail_in = in;
        stream.next_out = reinterpret_cast<Bytef*>(&result.bytes[done]);
        stream.avail_out = static_cast<uInt>(result.bytes.size() - done);
        status = inflate(&stream, Z_NO_FLUSH);
        result.bytes.resize(result.bytes.size() - stream.avail_out);
        packed.remove_prefix(in - stream.avail_in);
    }
    result.isWhole = status == Z_STREAM_END;
    return result;
}

/// The contents of a zlib stream; empty if it is damaged or has more than `maxBytes`.
inline std::string inflated(std::string_view packed, std::size_t maxBytes) {
    constexpr int kWindow = 15; // the largest
    Inflated result = inflated(packed, maxBytes + 1, kWindow);
    if (!result.isWhole || result.bytes.size() > maxBytes) result.bytes.clear();
    return std::move(result.bytes);
}

} // namespace altiro3D
