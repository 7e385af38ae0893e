// The .map file; docs/map-format.md is its public description.

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "native_lut_tables.hpp"
#include "text.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <opencv2/core.hpp>
#include <zlib.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "The .map file is little-endian and is written as the memory has it"
#endif

namespace altiro3D {

namespace {

constexpr char kMagic[8] = {'A', 'L', 'T', 'I', 'R', 'O', '3', 'D'};
constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kFlagInverted = 1;
constexpr std::uint32_t kNearestView = 0;

struct Header {
    char magic[8];
    std::uint32_t version;
    std::uint32_t headerSize;
    std::uint32_t panelWidth;
    std::uint32_t panelHeight;
    std::uint32_t quiltWidth;
    std::uint32_t quiltHeight;
    std::uint32_t columns;
    std::uint32_t rows;
    std::uint32_t viewCount;
    std::uint32_t viewFilter;
    std::uint32_t flags;
    std::uint32_t reserved;
    std::uint64_t fingerprint;
    char serial[48]; // UTF-8, padded with zeros
    std::uint32_t unused[2];
    std::uint32_t dataCrc;   // CRC-32 of everything after the header
    std::uint32_t headerCrc; // CRC-32 of the header's bytes before this one
};
static_assert(sizeof(Header) == 128, "the file's header has 128 bytes, without gaps");

std::uint32_t crcOf(const void* data, std::size_t size) {
    return static_cast<std::uint32_t>(
        crc32_z(crc32(0, nullptr, 0), static_cast<const Bytef*>(data), size));
}

// CRC-32 of several runs of bytes, each one computed in parallel pieces.
std::uint32_t crcOf(const std::vector<Bytes>& runs) {
    constexpr std::size_t kPiece = std::size_t{1} << 20;
    std::uint32_t total = crcOf(nullptr, 0);
    for (const Bytes& run : runs) {
        const std::size_t pieces = (run.size + kPiece - 1) / kPiece;
        std::vector<std::uint32_t> crcs(pieces);
        const auto sizeOf = [&](std::size_t i) { return std::min(kPiece, run.size - i * kPiece); };
        cv::parallel_for_(cv::Range(0, static_cast<int>(pieces)), [&](const cv::Range& range) {
            for (auto i = static_cast<std::size_t>(range.start);
                 i < static_cast<std::size_t>(range.end); ++i) {
                crcs[i] = crcOf(static_cast<const char*>(run.data) + i * kPiece, sizeOf(i));
            }
        });
        for (std::size_t i = 0; i < pieces; ++i) {
            total = static_cast<std::uint32_t>(
                crc32_combine(total, crcs[i], static_cast<z_off_t>(sizeOf(i))));
        }
    }
    return total;
}

void checkHeader(const Header& h, const std::string& name) {
    const auto fail = [&](const std::string& problem) {
        throw Error(ErrorCode::BadFormat, name, problem + "; build it again with altiro3Dnative");
    };
    if (std::memcmp(h.magic, kMagic, sizeof kMagic) != 0) {
        throw Error(ErrorCode::BadFormat, name,
                    "is no look-up table, expected a .map file made by altiro3Dnative");
    }
    if (h.version != kVersion) {
        fail("has format version " + std::to_string(h.version) + ", expected " +
             std::to_string(kVersion));
    }
    if (h.headerSize != sizeof(Header) || h.headerCrc != crcOf(&h, offsetof(Header, headerCrc))) {
        fail("has a corrupt header, expected a matching checksum");
    }
    const auto within = [](std::uint32_t value, std::uint32_t low, std::uint32_t high) {
        return value >= low && value <= high;
    };
    const std::uint32_t side = kMaxPanelSide;
    if (!within(h.panelWidth, 16, side) || !within(h.panelHeight, 16, side)) {
        fail("names a panel of " + pairText(h.panelWidth, h.panelHeight) +
             " px, expected 16..16384 px a side");
    }
    if (!within(h.columns, 1, 1024) || !within(h.rows, 1, 1024) ||
        !within(h.viewCount, 1, h.columns * h.rows) ||
        !within(h.quiltWidth, h.columns, kMaxQuiltSide) ||
        !within(h.quiltHeight, h.rows, kMaxQuiltSide) || h.quiltWidth % h.columns != 0 ||
        h.quiltHeight % h.rows != 0) {
        fail("names a quilt of " + pairText(h.quiltWidth, h.quiltHeight) + " px with " +
             pairText(h.columns, h.rows) + " views, expected whole views, at most 65535 px a side");
    }
    if (h.viewFilter != kNearestView) {
        fail("uses view filter " + std::to_string(h.viewFilter) + ", expected 0 (nearest view)");
    }
}

// All coordinates must lie inside the quilt: rendering trusts them.
bool coordinatesInside(const cv::Mat& channel, cv::Size quilt) {
    std::atomic<bool> inside{true};
    cv::parallel_for_(cv::Range(0, channel.rows), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            const auto* row = channel.ptr<std::uint16_t>(y);
            int largestX = 0;
            int largestY = 0;
            for (int x = 0; x < channel.cols; ++x) {
                largestX = std::max<int>(largestX, row[2 * x]);
                largestY = std::max<int>(largestY, row[2 * x + 1]);
            }
            if (largestX >= quilt.width || largestY >= quilt.height) inside = false;
        }
    });
    return inside;
}

} // namespace

void NativeLut::save(const std::filesystem::path& file) const {
    const Tables& t = *tables_;
    std::vector<Bytes> parts(1);
    for (const cv::Mat& channel : t.channels) {
        parts.push_back({channel.data, channel.total() * channel.elemSize()});
    }
    Header h{};
    std::memcpy(h.magic, kMagic, sizeof kMagic);
    h.version = kVersion;
    h.headerSize = sizeof(Header);
    h.panelWidth = static_cast<std::uint32_t>(t.panelSize.width);
    h.panelHeight = static_cast<std::uint32_t>(t.panelSize.height);
    h.quiltWidth = static_cast<std::uint32_t>(t.quilt.size().width);
    h.quiltHeight = static_cast<std::uint32_t>(t.quilt.size().height);
    h.columns = static_cast<std::uint32_t>(t.quilt.columns);
    h.rows = static_cast<std::uint32_t>(t.quilt.rows);
    h.viewCount = static_cast<std::uint32_t>(t.quilt.viewCount);
    h.viewFilter = kNearestView;
    h.flags = t.inverted ? kFlagInverted : 0;
    h.fingerprint = t.calibrationFingerprint;
    t.serial.copy(h.serial, sizeof h.serial - 1);
    h.dataCrc = crcOf({parts.begin() + 1, parts.end()});
    h.headerCrc = crcOf(&h, offsetof(Header, headerCrc));
    parts[0] = {&h, sizeof h};
    writeFile(file, parts);
}

NativeLut NativeLut::load(const std::filesystem::path& file) {
    const std::string name = file.string();
    std::error_code error;
    if (!std::filesystem::exists(file, error)) {
        throw Error(ErrorCode::NotFound, name, "does not exist, expected a .map file");
    }
    const std::uintmax_t fileSize =
        std::filesystem::is_regular_file(file, error) ? std::filesystem::file_size(file, error) : 0;
    if (error || !std::filesystem::is_regular_file(file, error)) {
        throw Error(ErrorCode::ReadFailed, name, "is no regular file, expected a .map file");
    }
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
        throw Error(ErrorCode::ReadFailed, name, "cannot be opened, expected a readable file");
    }
    Header h{};
    stream.read(reinterpret_cast<char*>(&h), sizeof h);
    if (stream.gcount() < static_cast<std::streamsize>(sizeof kMagic)) {
        throw Error(ErrorCode::BadFormat, name,
                    "is no look-up table, expected a .map file made by altiro3Dnative");
    }
    checkHeader(h, name);
    const std::uintmax_t expected = sizeof h + std::uintmax_t{12} * h.panelWidth * h.panelHeight;
    if (fileSize != expected) {
        throw Error(ErrorCode::BadFormat, name,
                    (fileSize < expected ? "is cut off: it has " : "is too long: it has ") +
                        std::to_string(fileSize) + " bytes, expected " + std::to_string(expected) +
                        "; build it again with altiro3Dnative");
    }

    auto tables = std::make_shared<Tables>();
    tables->panelSize = {static_cast<int>(h.panelWidth), static_cast<int>(h.panelHeight)};
    tables->quilt.columns = static_cast<int>(h.columns);
    tables->quilt.rows = static_cast<int>(h.rows);
    tables->quilt.tileSize = {static_cast<int>(h.quiltWidth / h.columns),
                              static_cast<int>(h.quiltHeight / h.rows)};
    tables->quilt.viewCount = static_cast<int>(h.viewCount);
    tables->calibrationFingerprint = h.fingerprint;
    tables->serial.assign(h.serial, strnlen(h.serial, sizeof h.serial));
    tables->inverted = (h.flags & kFlagInverted) != 0;
    tables->allocate();
    std::vector<Bytes> data;
    for (cv::Mat& channel : tables->channels) {
        const std::size_t size = channel.total() * channel.elemSize();
        stream.read(reinterpret_cast<char*>(channel.data), static_cast<std::streamsize>(size));
        data.push_back({channel.data, size});
    }
    if (!stream) {
        throw Error(ErrorCode::ReadFailed, name,
                    "cannot be read to its end, expected " + std::to_string(expected) + " bytes");
    }
    bool good = crcOf(data) == h.dataCrc;
    for (const cv::Mat& channel : tables->channels) {
        good = good && coordinatesInside(channel, tables->quilt.size());
    }
    if (!good) {
        throw Error(ErrorCode::BadFormat, name,
                    "is corrupt: its checksum does not match; build it again with altiro3Dnative");
    }
    return NativeLut(std::move(tables));
}

} // namespace altiro3D
