// The look-up table and its .map file, which docs/map-format.md describes.

#include "altiro3D/native_lut.hpp"

#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/system_file.hpp"
#include "base/system_process.hpp"
#include "display/lens_phase.hpp"
#include "native/panel_table.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <string>
#include <system_error>
#include <zlib.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "The .map file is little-endian and is written as the memory has it"
#endif

namespace altiro3D {

// The data of a NativeLut.
struct NativeLutTables {
    cv::Size panelSize;
    QuiltLayout quilt;
    std::uint64_t calibrationFingerprint = 0;
    std::string serial;
    bool inverted = true;
    // R, G, B: [panel rows x cols, CV_16UC2, (X, Y)], continuous, one after the other.
    std::array<cv::Mat, 3> channels;

    // Allocates the three tables. @throws Error OutOfMemory
    void allocate();

    // All three tables in the order of the file.
    std::uint8_t* data() const { return channels[0].data; }
    std::size_t size() const { return 3 * channels[0].total() * channels[0].elemSize(); }
};

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

// The data is processed in pieces of whole pairs that fit into a processor core's cache.
constexpr std::size_t kPiece = std::size_t{1} << 19;

// CRC-32 of `size` bytes, combined from crcOfPiece(begin, size) of the pieces, in parallel.
template <class F>
std::uint32_t crcOfPieces(std::size_t size, const F& crcOfPiece) {
    const std::size_t pieces = (size + kPiece - 1) / kPiece;
    std::vector<std::uint32_t> crcs(pieces);
    const auto sizeOf = [&](std::size_t i) { return std::min(kPiece, size - i * kPiece); };
    cv::parallel_for_(cv::Range(0, static_cast<int>(pieces)), [&](const cv::Range& range) {
        for (auto i = static_cast<std::size_t>(range.start);
             i < static_cast<std::size_t>(range.end); ++i) {
            crcs[i] = crcOfPiece(i * kPiece, sizeOf(i));
        }
    });
    std::uint32_t total = crcOf(nullptr, 0);
    for (std::size_t i = 0; i < pieces; ++i) {
        total = static_cast<std::uint32_t>(
            crc32_combine(total, crcs[i], static_cast<z_off_t>(sizeOf(i))));
    }
    return total;
}

// Reads up to `size` bytes at `begin` and returns their number. Thread-safe.
std::size_t readPart(const FileHandle& file, void* to, std::size_t begin, std::size_t size) {
    std::size_t done = 0;
    while (done < size) {
        const std::ptrdiff_t count =
            readAt(file, static_cast<char*>(to) + done, size - done, begin + done);
        if (count > 0) {
            done += static_cast<std::size_t>(count);
        } else if (count == 0 || errno != EINTR) {
            break;
        }
    }
    return done;
}

void checkHeader(const Header& h, const std::string& name) {
    const auto fail = [&](const std::string& problem) {
        throw Error(ErrorCode::BadFormat, name, problem);
    };
    if (std::memcmp(h.magic, kMagic, sizeof kMagic) != 0)
        fail("is not a look-up table, expected a .map file");
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

} // namespace

void NativeLutTables::allocate() {
    const int rows = panelSize.height;
    const cv::Mat all = panelTable(panelSize, CV_16UC2);
    // without them, a run of photo2native with a map for 3840 x 2160 px takes 12 % more time
    requestLargePages(all.data, all.dataend);
    for (int channel = 0; channel < 3; ++channel)
        channels[static_cast<std::size_t>(channel)] =
            all.rowRange(channel * rows, (channel + 1) * rows);
}

NativeLut::NativeLut(const Calibration& calibration, const QuiltLayout& quilt, InvertViews invert) {
    validate(quilt);
    const LensGeometry g = lensGeometry(calibration, invert);
    requirePanelSize(g, "look-up table");
    auto tables = std::make_shared<NativeLutTables>();
    tables->panelSize = {g.panelWidth, g.panelHeight};
    tables->quilt = quilt;
    tables->calibrationFingerprint = fingerprint(calibration);
    tables->serial = calibration.serial;
    tables->inverted = g.inverted;
    tables->allocate();

    const LensPhases phases(g);
    std::vector<cv::Point> tiles; // upper left corners
    for (int view = 0; view < quilt.columns * quilt.rows; ++view)
        tiles.push_back(quilt.tile(view).tl());
    const auto width = static_cast<std::size_t>(g.panelWidth);
    // places inside a tile
    const std::vector<int> inTile = samplesUnder(g.panelWidth, quilt.tileSize.width, g.mirrorX);
    const std::vector<int> rowsInTile =
        samplesUnder(g.panelHeight, quilt.tileSize.height, g.mirrorY);
    cv::parallel_for_(cv::Range(0, g.panelHeight), [&](const cv::Range& rows) {
        std::vector<std::uint32_t> views(width);
        for (int channel = 0; channel < 3; ++channel) {
            cv::Mat& table = tables->channels[static_cast<std::size_t>(channel)];
            for (int y = rows.start; y < rows.end; ++y) {
                const int yInTile = rowsInTile[static_cast<std::size_t>(y)];
                phases.viewsOfRow(y, channel, quilt.viewCount, views.data());
                auto* out = table.ptr<std::uint16_t>(y);
                for (std::size_t x = 0; x < width; ++x) {
                    const cv::Point& tile = tiles[views[x]];
                    *out++ = static_cast<std::uint16_t>(tile.x + inTile[x]);
                    *out++ = static_cast<std::uint16_t>(tile.y + yInTile);
                }
            }
        }
    });
    tables_ = std::move(tables);
}

NativeLut::NativeLut(std::shared_ptr<const NativeLutTables> tables) : tables_(std::move(tables)) {}

cv::Size NativeLut::panelSize() const {
    return tables_->panelSize;
}

const QuiltLayout& NativeLut::quilt() const {
    return tables_->quilt;
}

std::uint64_t NativeLut::calibrationFingerprint() const {
    return tables_->calibrationFingerprint;
}

const std::string& NativeLut::serial() const {
    return tables_->serial;
}

bool NativeLut::inverted() const {
    return tables_->inverted;
}

const cv::Mat& NativeLut::channel(int channel) const {
    if (channel < 0 || channel > 2) {
        throw Error(ErrorCode::InvalidArgument, "channel",
                    "is " + std::to_string(channel) + ", expected 0 red, 1 green or 2 blue");
    }
    return tables_->channels[static_cast<std::size_t>(channel)];
}

void requireSameDisplay(const NativeLut& lut, const std::string& lutName,
                        const Calibration& calibration, const std::string& calibrationName) {
    const std::uint64_t wanted = fingerprint(calibration);
    if (lut.calibrationFingerprint() == wanted) return;
    const auto name = [](const std::string& serial, std::uint64_t print) {
        return (serial.empty() ? std::string("a display without serial number") : serial) + " (" +
               fingerprintText(print) + ")";
    };
    throw Error(ErrorCode::Mismatch, lutName,
                "was built for " + name(lut.serial(), lut.calibrationFingerprint()) + ", but " +
                    calibrationName + " is the calibration of " + name(calibration.serial, wanted) +
                    "; expected a map built from it");
}

void NativeLut::save(const std::filesystem::path& file) const {
    const NativeLutTables& t = *tables_;
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
    h.dataCrc = crcOfPieces(t.size(), [&](std::size_t begin, std::size_t size) {
        return crcOf(t.data() + begin, size);
    });
    h.headerCrc = crcOf(&h, offsetof(Header, headerCrc));
    writeFile(file, {{&h, sizeof h}, {t.data(), t.size()}});
}

NativeLut NativeLut::load(const std::filesystem::path& file) {
    const std::string name = file.string();
    const auto failRead = [&](const std::string& reason) {
        throw Error(ErrorCode::ReadFailed, name,
                    "cannot be read: " + reason + ", expected a .map file");
    };
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(file, error);
    if (status.type() == std::filesystem::file_type::not_found) {
        throw Error(ErrorCode::NotFound, name, "does not exist, expected a .map file");
    }
    if (error) failRead(error.message());
    const bool isPipe = status.type() == std::filesystem::file_type::fifo;
    if (!isPipe && !std::filesystem::is_regular_file(status)) {
        throw Error(ErrorCode::ReadFailed, name, "is not a regular file, expected a .map file");
    }
    FileHandle opened = openFile(file, OpenFor::Reading);
    if (!opened.isOpen()) failRead(reasonOf(errno));
    constexpr std::uintmax_t kMostOfPipe = std::uintmax_t{1} << 33;
    if (isPipe) opened = unnamedCopy(opened, file, kMostOfPipe);
    const FileState state = stateOf(opened);
    if (!state.exists()) failRead(reasonOf(state.error));
    const std::uintmax_t fileSize = state.size;
    Header h{};
    const auto requireFormat = [&](bool holds, const std::string& problem) {
        if (!holds) throw Error(ErrorCode::BadFormat, name, problem);
    };
    requireFormat(readPart(opened, &h, 0, sizeof h) >= sizeof kMagic,
                  "is not a look-up table, expected a .map file");
    checkHeader(h, name);
    const std::uintmax_t expected = sizeof h + std::uintmax_t{12} * h.panelWidth * h.panelHeight;
    requireFormat(fileSize == expected,
                  (fileSize < expected ? "is cut off: it has " : "is too long: it has ") +
                      std::to_string(fileSize) + " bytes, expected " + std::to_string(expected));

    auto tables = std::make_shared<NativeLutTables>();
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
    const cv::Size quilt = tables->quilt.size();
    std::atomic<bool> complete{true};
    std::atomic<bool> inside{true}; // rendering does not check coordinates
    const auto readPiece = [&](std::size_t begin, std::size_t size) {
        std::uint8_t* const to = tables->data() + begin;
        if (readPart(opened, to, sizeof h + begin, size) != size) {
            complete = false;
            return std::uint32_t{0};
        }
        const auto* const pairs = reinterpret_cast<const std::uint16_t*>(to);
        int x = 0; // the largest ones
        int y = 0;
        for (std::size_t i = 0; i < size / 2; i += 2) {
            x = std::max<int>(x, pairs[i]);
            y = std::max<int>(y, pairs[i + 1]);
        }
        if (x >= quilt.width || y >= quilt.height) inside = false;
        return crcOf(to, size);
    };
    const bool sound = crcOfPieces(tables->size(), readPiece) == h.dataCrc;
    if (!complete) {
        throw Error(ErrorCode::ReadFailed, name,
                    "cannot be read to its end, expected " + std::to_string(expected) + " bytes");
    }
    requireFormat(sound, "is corrupt: its checksum does not match, expected a table that is built "
                         "anew");
    requireFormat(inside, "is corrupt: it names px outside of its quilt, expected px of " +
                              pairText(quilt.width, quilt.height));
    return NativeLut(std::move(tables));
}

} // namespace altiro3D
