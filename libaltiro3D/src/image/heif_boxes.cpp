#include "image/heif_boxes.hpp"

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

cv::Size largestCodedPicture(string_view bytes) {
    constexpr unsigned kSequence = 33; // type of the unit
    const ByteReader reader(bytes, false);
    const Box meta = findBox(reader, "meta", 0, bytes.size());
    if (meta.size < kFullBoxHeader) return {};
    const Box iprp =
        findBox(reader, "iprp", meta.at + kFullBoxHeader, meta.at + std::uint64_t{meta.size});
    if (iprp.size == 0) return {};
    const Box ipco = findBox(reader, "ipco", iprp.at + kBoxHeader, iprp.at + iprp.size);
    cv::Size largest;
    std::uint64_t at = ipco.at + kBoxHeader;
    for (int i = 0; ipco.size > 0 && i < kMaxBoxes; ++i) {
        const Box settings = findBox(reader, "hvcC", at, ipco.at + ipco.size);
        if (settings.size == 0) break;
        at = settings.at + settings.size;
        std::uint64_t unit = settings.at + kBoxHeader + 22;
        for (unsigned arrays = reader.u8(unit++); arrays > 0 && unit < at; --arrays) {
            const unsigned type = reader.u8(unit) & 0x3fU;
            unsigned count = reader.u16(unit + 1);
            for (unit += 3; count > 0 && unit < at; --count) {
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
    }
    return largest;
}

std::optional<HeifEyes> findHeifEyes(string_view bytes) {
    const ByteReader reader(bytes, false);
    const Box meta = findBox(reader, "meta", 0, bytes.size());
    if (meta.size < kFullBoxHeader) return std::nullopt;
    const Box groups = findBox(reader, "grpl", meta.at + kFullBoxHeader, meta.at + meta.size);
    if (groups.size == 0) return std::nullopt;
    const Box pair =
        findBox(reader, "ster", groups.at + kBoxHeader, groups.at + std::uint64_t{groups.size});
    // {version and flags, u32 number of the group, u32 count, u32 items...}
    if (pair.size < kFullBoxHeader + 16 || reader.u32(pair.at + kFullBoxHeader + 4) != 2)
        return std::nullopt;
    const HeifEyes eyes{reader.u32(pair.at + kFullBoxHeader + 8),
                        reader.u32(pair.at + kFullBoxHeader + 12)};
    if (eyes.left == eyes.right) return std::nullopt;
    return eyes;
}

} // namespace altiro3D
