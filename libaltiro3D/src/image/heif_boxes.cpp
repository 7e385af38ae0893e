#include "image/heif_boxes.hpp"

#include "base/byte_reader.hpp"

#include <algorithm>
#include <cstdint>
#include <set>

namespace altiro3D {

namespace {

using std::string_view;

constexpr std::size_t kBoxHeader = 8;
constexpr std::size_t kVersion = 4; // bytes of version and flags, at the start of some bodies

// A box inside a file; empty if it was not found.
struct Box {
    std::uint64_t at = 0;
    std::uint64_t body = 0; // after the header of 8 or 16 bytes
    std::uint64_t end = 0;
    bool isFound() const { return end > 0; }
};

// The first box of a type between two positions. A size of 0 reaches to the end.
Box findBox(const ByteReader& reader, string_view type, std::uint64_t at, std::uint64_t end) {
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

Box findBox(const ByteReader& reader, string_view type, const Box& inside, std::uint64_t skip = 0) {
    return findBox(reader, type, inside.body + skip, inside.end);
}

// Calls `visit(box)` for every box of a type inside another one.
template <class Visit>
void forEachBox(const ByteReader& reader, string_view type, const Box& inside, std::uint64_t skip,
                const Visit& visit) {
    for (std::uint64_t at = inside.body + skip;;) {
        const Box box = findBox(reader, type, at, inside.end);
        if (!box.isFound()) return;
        visit(box);
        at = box.end;
    }
}

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

// Reads the bits of a NAL unit: without its emulation prevention bytes (0 0 3 stands for 0 0).
class BitReader {
  public:
    explicit BitReader(string_view nal) {
        int zeros = 0;
        for (const char c : nal) {
            if (zeros >= 2 && c == 3) {
                zeros = 0;
                continue;
            }
            zeros = c == 0 ? zeros + 1 : 0;
            bytes_.push_back(c);
        }
    }
    // 0 beyond the end
    std::uint64_t bits(unsigned count) {
        std::uint64_t value = 0;
        for (; count > 0; --count, ++at_) {
            const std::size_t byte = at_ / 8;
            const unsigned bit =
                byte < bytes_.size()
                    ? static_cast<unsigned char>(bytes_[byte]) >> (7 - at_ % 8) & 1U
                    : 0U;
            value = value << 1 | bit;
        }
        return value;
    }
    void skip(unsigned count) { at_ += count; }
    // Exponential-Golomb code ue(v)
    std::uint64_t code() {
        unsigned zeros = 0;
        while (zeros < 32 && bits(1) == 0)
            ++zeros;
        return (std::uint64_t{1} << zeros) - 1 + bits(zeros);
    }

  private:
    std::string bytes_;
    std::size_t at_ = 0;
};

// H.265 7.3.2.2 up to the size.
cv::Size sizeOfSequence(string_view nal) {
    BitReader reader(nal);
    reader.skip(16 + 4); // header of the unit, parameter set
    const auto layers = static_cast<unsigned>(reader.bits(3));
    reader.skip(1 + 96); // nesting, profile and level
    std::uint64_t present = 0;
    if (layers > 0) present = reader.bits(16); // two bits for each of eight layers
    for (unsigned i = 0; i < layers; ++i) {
        if ((present >> (15 - 2 * i) & 1U) != 0) reader.skip(88);
        if ((present >> (14 - 2 * i) & 1U) != 0) reader.skip(8);
    }
    reader.code();                          // its number
    if (reader.code() == 3) reader.skip(1); // 4:4:4
    const auto side = [&] {
        return static_cast<int>(std::min<std::uint64_t>(reader.code(), 0x7fffffff));
    };
    const int columns = side();
    return {columns, side()};
}

// The largest size in the parameter sets of a picture's settings (hvcC).
cv::Size sizeOfSettings(const ByteReader& reader, const Box& settings) {
    constexpr unsigned kSequence = 33; // type of the unit
    cv::Size largest;
    std::uint64_t unit = settings.body + 22;
    for (unsigned arrays = reader.u8(unit++); arrays > 0 && unit < settings.end; --arrays) {
        const unsigned type = reader.u8(unit) & 0x3fU;
        unsigned count = reader.u16(unit + 1);
        for (unit += 3; count > 0 && unit < settings.end; --count) {
            const unsigned length = reader.u16(unit);
            if (type == kSequence) {
                const cv::Size size = sizeOfSequence(reader.text(unit + 2, length));
                if (static_cast<double>(size.width) * size.height >
                    static_cast<double>(largest.width) * largest.height) {
                    largest = size;
                }
            }
            unit += 2 + length;
        }
    }
    return largest;
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

cv::Size largestCodedPicture(string_view bytes) {
    const ByteReader reader(bytes, false);
    cv::Size largest;
    const auto readSettings = [&](const Box& settings) {
        const cv::Size size = sizeOfSettings(reader, settings);
        if (static_cast<double>(size.width) * size.height >
            static_cast<double>(largest.width) * largest.height) {
            largest = size;
        }
    };
    forEachBox(reader, "meta", {0, 0, bytes.size()}, 0, [&](const Box& meta) {
        forEachBox(reader, "iprp", meta, kVersion, [&](const Box& properties) {
            forEachBox(reader, "ipco", properties, 0,
                       [&](const Box& all) { forEachBox(reader, "hvcC", all, 0, readSettings); });
        });
    });
    return largest;
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
