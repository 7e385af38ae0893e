// Boxes of HEIC and AVIF files (ISO/IEC 14496-12).

#include "image/heif_file.hpp"

#include "base/byte_reader.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace altiro3D {

namespace {

using std::string_view;

constexpr std::size_t kBoxHeader = 8;
constexpr std::size_t kVersion = 4; // Bytes of version and flags, at the start of some bodies.

// A box inside a file; empty if it was not found.
struct Box {
    std::uint64_t at = 0;
    std::uint64_t body = 0; // After the header of 8 or 16 bytes.
    std::uint64_t end = 0;
    bool isFound() const { return end > 0; }
};

// The first box of a type between two positions. A size of 0 reaches to the end.
Box findBox(const ByteReader& reader, std::string_view type, std::uint64_t at, std::uint64_t end) {
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

Box findBox(const ByteReader& reader, std::string_view type, const Box& inside,
            std::uint64_t skip = 0) {
    return findBox(reader, type, inside.body + skip, inside.end);
}

// Calls `visit(box)` for every box of a type inside another one.
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

void append(std::string& bytes, std::uint64_t value, unsigned size) {
    for (unsigned i = size; i-- > 0;)
        bytes.push_back(static_cast<char>(value >> (8 * i) & 0xffU));
}

// Calls `visit(id, type)` for the items of a box "iinf".
template <class Visit>
void forEachItem(const ByteReader& reader, const Box& iinf, const Visit& visit) {
    const unsigned version = reader.u8(iinf.body);
    forEachBox(reader, "infe", iinf, kVersion + (version == 0 ? 2 : 4), [&](const Box& infe) {
        const unsigned idSize = reader.u8(infe.body) >= 3 ? 4 : 2;
        const std::uint64_t id = infe.body + kVersion;
        visit(reader.number(id, idSize), reader.text(id + idSize + 2, 4));
    });
}

double areaOf(cv::Size size) {
    return static_cast<double>(size.width) * size.height;
}

int sideOf(std::uint64_t value) {
    return static_cast<int>(std::min<std::uint64_t>(value, 0x7fffffff));
}

// H.265 7.3.2.2 up to the size.
cv::Size sizeOfSequence(string_view nal) {
    const std::string bytes = withoutPrevention(nal);
    BitReader reader(bytes);
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
    const int columns = sideOf(reader.code());
    return {columns, sideOf(reader.code())};
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
                if (areaOf(size) > areaOf(largest)) largest = size;
            }
            unit += 2 + length;
        }
    }
    return largest;
}

// The sequence header of an AV1 stream (AV1 5.5.1) up to the size.
cv::Size sizeOfAv1Sequence(string_view unit) {
    BitReader reader(unit);
    reader.skip(3 + 1); // profile, still picture
    if (reader.bits(1) != 0) {
        reader.skip(5); // level
    } else {
        bool hasModel = false;
        unsigned delayBits = 0;
        if (reader.bits(1) != 0) { // timing
            reader.skip(64);
            if (reader.bits(1) != 0) reader.code();
            hasModel = reader.bits(1) != 0;
            if (hasModel) {
                delayBits = static_cast<unsigned>(reader.bits(5)) + 1;
                reader.skip(32 + 5 + 5);
            }
        }
        const bool hasDelay = reader.bits(1) != 0;
        for (std::uint64_t points = reader.bits(5) + 1; points > 0; --points) {
            reader.skip(12);
            if (reader.bits(5) > 7) reader.skip(1);
            if (hasModel && reader.bits(1) != 0) reader.skip(2 * delayBits + 1);
            if (hasDelay && reader.bits(1) != 0) reader.skip(4);
        }
    }
    const auto columnBits = static_cast<unsigned>(reader.bits(4)) + 1;
    const auto rowBits = static_cast<unsigned>(reader.bits(4)) + 1;
    const int columns = sideOf(reader.bits(columnBits) + 1);
    return {columns, sideOf(reader.bits(rowBits) + 1)};
}

// The largest size in the units of an AV1 stream (AV1 5.3).
cv::Size sizeOfAv1(string_view data) {
    constexpr unsigned kSequence = 1;
    const ByteReader reader(data, false);
    cv::Size largest;
    for (std::uint64_t at = 0; at < data.size();) {
        const unsigned header = reader.u8(at++);
        if ((header & 4U) != 0) ++at; // its extension
        std::uint64_t size = data.size() - std::min<std::uint64_t>(at, data.size());
        if ((header & 2U) != 0) {
            size = 0;
            for (unsigned shift = 0; shift < 56; shift += 7) {
                const unsigned byte = reader.u8(at++);
                size |= std::uint64_t{byte & 0x7fU} << shift;
                if ((byte & 0x80U) == 0) break;
            }
        }
        if (size > data.size() || at > data.size() - size) break;
        if ((header >> 3U & 15U) == kSequence) {
            const cv::Size found = sizeOfAv1Sequence(reader.text(at, size));
            if (areaOf(found) > areaOf(largest)) largest = found;
        }
        at += size;
    }
    return largest;
}

// The size of a picture that is put together: a grid or an overlay (ISO/IEC 23008-12, 6.6.2).
cv::Size sizeOfCanvas(string_view data, bool isGrid) {
    const ByteReader reader(data, false);
    const unsigned bytes = (reader.u8(1) & 1U) != 0 ? 4 : 2;
    const std::uint64_t at = isGrid ? 4 : 2 + 8; // after rows and columns; after the colour
    return {sideOf(reader.number(at, bytes)), sideOf(reader.number(at + bytes, bytes))};
}

// The data of the items of a file, and what is known about them.
class Items {
  public:
    Items(const ByteReader& reader, std::uint64_t fileSize)
        : reader_(reader), fileSize_(fileSize), left_(4 * fileSize + 65536) {}

    // The types of an item; several only in hostile files.
    void readTypes(const Box& meta) {
        forEachBox(reader_, "iinf", meta, kVersion, [&](const Box& iinf) {
            forEachItem(reader_, iinf, [&](std::uint64_t id, string_view type) {
                if (type == "grid" || type == "iovl" || type == "av01") types_.emplace(id, type);
            });
        });
    }

    // Calls `visit(type, data)` for the items of these types. @return false if the data of the
    // items is many times as long as the file
    template <class Visit>
    bool forEach(const Box& meta, const Visit& visit) {
        const Box idat = findBox(reader_, "idat", meta, kVersion);
        forEachBox(reader_, "iloc", meta, kVersion, [&](const Box& iloc) {
            const unsigned version = reader_.u8(iloc.body);
            const unsigned sizes = reader_.u16(iloc.body + kVersion);
            const unsigned offsetSize = sizes >> 12U;
            const unsigned lengthSize = sizes >> 8U & 15U;
            const unsigned baseSize = sizes >> 4U & 15U;
            const unsigned indexSize = version > 0 ? sizes & 15U : 0;
            const unsigned idSize = version < 2 ? 2 : 4;
            std::uint64_t at = iloc.body + kVersion + 2;
            std::uint64_t count = reader_.number(at, idSize);
            for (at += idSize; count > 0 && at < iloc.end; --count) {
                const std::uint64_t id = reader_.number(at, idSize);
                at += idSize;
                const unsigned method = version > 0 ? reader_.u16(at) & 15U : 0;
                at += version > 0 ? 4 : 2; // and the data reference
                const std::uint64_t base = reader_.number(at, baseSize);
                at += baseSize;
                std::uint64_t extents = reader_.u16(at);
                at += 2;
                const auto types = types_.equal_range(id);
                std::string data;
                for (; extents > 0 && at < iloc.end; --extents) {
                    at += indexSize;
                    const std::uint64_t offset = reader_.number(at, offsetSize);
                    const std::uint64_t length = reader_.number(at + offsetSize, lengthSize);
                    at += offsetSize + lengthSize;
                    if (types.first == types.second) continue;
                    data += textAt((method == 1 ? idat.body : 0) + base + offset, length);
                }
                for (auto type = types.first; type != types.second; ++type)
                    visit(type->second, data);
            }
        });
        return left_ > 0;
    }

  private:
    string_view textAt(std::uint64_t at, std::uint64_t length) {
        if (at >= fileSize_ || left_ == 0) return {};
        const std::uint64_t there = fileSize_ - at;
        const std::uint64_t size = length == 0 ? there : std::min(length, there);
        left_ -= std::min(left_, size);
        return reader_.text(at, size);
    }

    const ByteReader& reader_;
    std::uint64_t fileSize_;
    std::uint64_t left_; // bytes that may still be looked at
    std::multimap<std::uint64_t, string_view> types_;
};

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
    std::set<std::uint64_t> toneMapped;
    forEachItem(reader, iinf, [&](std::uint64_t id, string_view type) {
        if (type == "tmap") toneMapped.insert(id);
    });

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

std::string heifProblem(string_view bytes, double maxPixels) {
    const ByteReader reader(bytes, false);
    cv::Size coded;
    std::set<std::pair<std::uint32_t, std::uint32_t>> stated;
    std::string problem;
    Items items(reader, bytes.size());
    const auto takeCoded = [&coded](cv::Size size) {
        if (areaOf(size) > areaOf(coded)) coded = size;
    };
    const Box file{0, 0, bytes.size()};
    forEachBox(reader, "meta", file, 0, [&](const Box& meta) {
        items.readTypes(meta);
        forEachBox(reader, "iprp", meta, kVersion, [&](const Box& properties) {
            forEachBox(reader, "ipco", properties, 0, [&](const Box& all) {
                forEachBox(reader, "hvcC", all, 0, [&](const Box& settings) {
                    takeCoded(sizeOfSettings(reader, settings));
                });
                forEachBox(reader, "ispe", all, 0, [&](const Box& ispe) {
                    stated.emplace(reader.u32(ispe.body + kVersion),
                                   reader.u32(ispe.body + kVersion + 4));
                });
            });
        });
    });
    forEachBox(reader, "meta", file, 0, [&](const Box& meta) {
        const bool isSane = items.forEach(meta, [&](string_view type, string_view data) {
            if (type == "av01") return takeCoded(sizeOfAv1(data));
            const cv::Size canvas = sizeOfCanvas(data, type == "grid");
            const auto columns = static_cast<std::uint32_t>(canvas.width);
            if (areaOf(canvas) > maxPixels ||
                stated.count({columns, static_cast<std::uint32_t>(canvas.height)}) == 0) {
                problem =
                    "its parts make a picture of " + sizeText(canvas) + ", which it does not state";
            }
        });
        if (!isSane) problem = "its items share their data";
    });
    if (areaOf(coded) > maxPixels) return "its coded picture has " + sizeText(coded);
    return problem;
}

} // namespace altiro3D
