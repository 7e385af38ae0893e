#include "base/byte_reader.hpp"
#include "base/checks.hpp"
#include "splats/splat_collector.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <zlib.h>
#ifdef ALTIRO3D_HAVE_ZSTD
#include <zstd.h>
#endif

namespace altiro3D {

// Niantic's format. Layout: https://github.com/nianticlabs/spz

namespace {

constexpr std::uint32_t kMagic = 0x5053474E; // "NGSP"
constexpr std::size_t kHeader = 16;
constexpr std::uint32_t kAxesRecord = 0xADBE0003; // Adobe's extension of version 4
constexpr int kBitsOfFraction = 12;               // of files that we write
constexpr double kColourScale = 0.15;
constexpr int kGzip = 15 + 16; // window of zlib, header of gzip

struct SpzHeader {
    std::uint32_t version = 0;
    std::uint64_t count = 0;
    int degree = 0;
    int fractionBits = 0;
    bool isAntialiased = false;
    bool hasExtensions = false;
    std::uint32_t streams = 0; // of version 4

    // Bytes of positions, opacities, colours, radii, rotations and harmonics.
    std::array<std::uint64_t, 6> sizes() const {
        return {count * (version == 1 ? 6 : 9),
                count,
                3 * count,
                3 * count,
                count * (version >= 3 ? 4 : 3),
                count * 3 * coefficientsOf(degree)};
    }
    std::uint64_t bytes() const {
        const auto all = sizes();
        return std::accumulate(all.begin(), all.end(), std::uint64_t{0});
    }
};

SpzHeader headerOf(std::string_view bytes, const std::string& name) {
    const ByteReader reader(bytes, true);
    const auto require = [&](bool condition, const std::string& problem,
                             ErrorCode code = ErrorCode::BadFormat) {
        if (!condition) throw Error(code, name, problem);
    };
    require(bytes.size() >= kHeader && reader.u32(0) == kMagic,
            "is not a scene of splats, expected .spz");
    SpzHeader header;
    header.version = reader.u32(4);
    header.count = reader.u32(8);
    header.degree = static_cast<int>(reader.u8(12));
    header.fractionBits = static_cast<int>(reader.u8(13));
    header.isAntialiased = (reader.u8(14) & 1U) != 0;
    header.hasExtensions = (reader.u8(14) & 2U) != 0;
    header.streams = reader.u8(15);
    require(header.version >= 1 && header.version <= 4,
            "is .spz of version " + std::to_string(header.version) + ", expected 1 to 4",
            ErrorCode::Unsupported);
    require(header.degree <= 4,
            "has harmonics of degree " + std::to_string(header.degree) + ", expected at most 4");
    require(header.fractionBits <= 23, "has positions with " + std::to_string(header.fractionBits) +
                                           " bits of fraction, expected at most 23");
    require(header.count <= kMaxSplats,
            "has " + std::to_string(header.count) + " splats, expected at most " +
                std::to_string(kMaxSplats),
            ErrorCode::TooLarge);
    return header;
}

[[noreturn]] void tellDamage(const std::string& name) {
    throw Error(ErrorCode::BadFormat, name, "is damaged or ends early, expected a whole .spz file");
}

// The arrays of versions 1 to 3, one after the other.
std::string unpacked(std::string_view packed, const SpzHeader& header, const std::string& name) {
    const std::uint64_t whole = kHeader + header.bytes();
    constexpr std::uint64_t kMostPacked = 1040; // gzip turns a byte into at most so many
    std::string bytes;
    if (whole / kMostPacked <= packed.size()) bytes = inflated(packed, whole, kGzip).bytes;
    if (bytes.size() < whole) // arrays follow each other, so all splats lack something
        throw Error(ErrorCode::BadFormat, name,
                    "ends after " + std::to_string(bytes.size()) + " of " + std::to_string(whole) +
                        " bytes of its " + std::to_string(header.count) +
                        " splats, expected a whole file");
    return bytes.erase(0, kHeader);
}

#ifdef ALTIRO3D_HAVE_ZSTD
// The arrays of version 4.
std::string unpacked4(std::string_view bytes, const SpzHeader& header, const std::string& name) {
    const ByteReader reader(bytes, true);
    std::uint64_t entry = reader.u32(16); // of the table
    std::uint64_t at = entry + std::uint64_t{16} * header.streams;
    std::uint32_t streams = 0;
    std::uint64_t whole = 0;
    for (const std::uint64_t size : header.sizes())
        whole += size;
    constexpr std::uint64_t kMostPacked = 1040; // as deflate, so that small files stay small
    if (whole / kMostPacked > bytes.size()) tellDamage(name);
    std::string result;
    result.reserve(whole);
    for (const std::uint64_t size : header.sizes()) {
        if (size == 0) continue;
        const std::uint64_t packed = reader.u64(entry);
        const std::string_view stream = reader.text(at, packed);
        // the stream's own word first: memory is allocated for what it says it holds
        if (streams++ >= header.streams || !reader.holds(at, packed) ||
            reader.u64(entry + 8) != size ||
            ZSTD_getFrameContentSize(stream.data(), stream.size()) != size)
            tellDamage(name);
        const std::size_t done = result.size();
        result.resize(done + size);
        if (ZSTD_decompress(&result[done], size, stream.data(), stream.size()) != size)
            tellDamage(name);
        entry += 16;
        at += packed;
    }
    return result;
}
#endif

// What the extension of version 4 says of the axes.
std::optional<SplatAxes> axesRecord(std::string_view bytes, const std::string& name) {
    constexpr std::uint64_t kFirst = 32;
    const ByteReader reader(bytes, true);
    const std::uint64_t end = reader.u32(16);
    for (std::uint64_t at = kFirst; at + 8 <= end && reader.holds(at, 8);
         at += std::uint64_t{8} + reader.u32(at + 4)) {
        if (reader.u32(at) != kAxesRecord) continue;
        const std::uint32_t axes = reader.u32(at + 8);
        constexpr std::uint32_t kRub = 4;
        constexpr std::uint32_t kRdf = 6;
        if (axes == 0 || axes == kRub) return SplatAxes::Rub;
        if (axes == kRdf) return SplatAxes::Rdf;
        throw Error(ErrorCode::Unsupported, name,
                    "has axes of the kind " + std::to_string(axes) +
                        ", expected RUB (4) or RDF (6)");
    }
    return std::nullopt;
}

// A half float. OpenCV does not have this type on every processor.
float halfFloat(std::uint32_t bits) {
    const auto exponent = static_cast<int>(bits >> 10 & 31U);
    const auto fraction = static_cast<float>(bits & 1023U) / 1024;
    const float size = exponent == 0    ? std::ldexp(fraction, -14)
                       : exponent == 31 ? std::numeric_limits<float>::quiet_NaN()
                                        : std::ldexp(1 + fraction, exponent - 15);
    return (bits & 0x8000U) != 0 ? -size : size;
}

// The rotation of versions 1 and 2: x, y and z.
cv::Vec4f firstThree(float x, float y, float z) {
    return {std::sqrt(std::max(1 - x * x - y * y - z * z, 0.0F)), x, y, z};
}

// That of versions 3 and 4.
cv::Vec4f rotationOf(std::uint32_t packed) {
    const cv::Vec4f xyzw = smallestThree(packed, [](std::uint32_t code) {
        const double size = (code & 511U) / 511.0 * std::sqrt(0.5);
        return (code & 512U) != 0 ? -size : size;
    });
    return {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
}

} // namespace

SplatScene parseSpz(std::string_view bytes, const std::string& name, SplatAxes axes, Notes* notes) {
    const bool isPlain = startsWith(bytes, "NGSP");
    const SpzHeader header = headerOf(isPlain ? std::string(bytes.substr(0, kHeader))
                                              : inflated(bytes, kHeader, kGzip).bytes,
                                      name);
    if (isPlain != (header.version == 4)) tellDamage(name);
    std::string all;
    if (!isPlain) {
        all = unpacked(bytes, header, name);
    } else {
        if (axes == SplatAxes::Auto && header.hasExtensions)
            axes = axesRecord(bytes, name).value_or(axes);
#ifdef ALTIRO3D_HAVE_ZSTD
        all = unpacked4(bytes, header, name);
#else
        throw Error(ErrorCode::Unsupported, name,
                    "is .spz of version 4, for which this build lacks libzstd, expected version 3");
#endif
    }
    std::array<std::string_view, 6> arrays;
    std::uint64_t start = 0;
    for (std::size_t i = 0; i < arrays.size(); start += header.sizes()[i++])
        arrays[i] = std::string_view(all).substr(start, header.sizes()[i]);
    const auto code = [&](std::size_t array, std::uint64_t at) {
        return static_cast<float>(static_cast<unsigned char>(arrays[array][at]));
    };
    const ByteReader positions(arrays[0], true);
    const ByteReader rotations(arrays[4], true);
    const auto unit = static_cast<float>(std::ldexp(1.0, -header.fractionBits));
    SplatCollector collector(header.count, header.degree);
    std::vector<double> harmonics(3 * coefficientsOf(header.degree));
    for (std::uint64_t i = 0; i < header.count; ++i) {
        Splat splat;
        cv::Vec3f xyz; // of the rotation
        for (int k = 0; k < 3; ++k) {
            const std::uint64_t n = 3 * i + static_cast<std::uint64_t>(k);
            if (header.version == 1) {
                splat.centre[k] = halfFloat(positions.u16(2 * n));
            } else {
                const auto raw = static_cast<std::int32_t>(positions.number(3 * n, 3) << 8);
                const std::int32_t steps = raw / 256; // with its sign
                splat.centre[k] = static_cast<float>(steps) * unit;
            }
            const double dc = (static_cast<double>(code(2, n)) / 255 - 0.5) / kColourScale;
            splat.colour[k] = static_cast<float>(0.5 + kHarmonic0 * dc);
            splat.radii[k] = radiusOf(code(3, n) / 16 - 10);
            if (header.version < 3) xyz[k] = code(4, n) / 127.5F - 1;
        }
        splat.opacity = code(1, i) / 255;
        splat.rotation = header.version < 3 ? firstThree(xyz[0], xyz[1], xyz[2])
                                            : rotationOf(rotations.u32(4 * i));
        for (std::size_t k = 0; k < harmonics.size(); ++k)
            harmonics[k] = (static_cast<double>(code(5, i * harmonics.size() + k)) - 128) / 128;
        collector.add(splat, harmonics.data());
    }
    SplatScene scene = collector.finish(name, notes);
    scene.isAntialiased = header.isAntialiased;
    if (axes != SplatAxes::Rdf) turnAboutX(scene);
    return scene;
}

namespace {

char codeOf(double value) {
    return static_cast<char>(
        static_cast<unsigned char>(std::clamp(std::floor(value + 0.5), 0.0, 255.0)));
}

std::uint32_t packedRotation(const cv::Vec4f& wxyz) {
    const float q[4] = {wxyz[1], wxyz[2], wxyz[3], wxyz[0]};
    std::uint32_t largest = 0;
    for (std::uint32_t i = 1; i < 4; ++i)
        if (std::abs(q[i]) > std::abs(q[largest])) largest = i;
    std::uint32_t packed = largest;
    for (std::uint32_t i = 0; i < 4; ++i) {
        if (i == largest) continue;
        const auto size = static_cast<std::uint32_t>(
            511 * std::abs(static_cast<double>(q[i])) / std::sqrt(0.5) + 0.5);
        const bool isNegative = (q[i] < 0) != (q[largest] < 0);
        packed = packed << 10 | (isNegative ? 512U : 0U) | std::min(size, 511U);
    }
    return packed;
}

std::string gzipped(const std::string& bytes) {
    z_stream stream{};
    constexpr int kMemory = 8;
    if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) !=
        Z_OK)
        throw std::bad_alloc();
    std::string packed(deflateBound(&stream, bytes.size()), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    deflate(&stream, Z_FINISH);
    packed.resize(packed.size() - stream.avail_out);
    deflateEnd(&stream);
    return packed;
}

} // namespace

std::string spzBytes(const SplatScene& whole, const std::string& name) {
    SplatScene scene = whole;
    turnAboutX(scene);
    std::array<std::string, 6> arrays;
    for (const Splat& splat : scene.splats) {
        for (int k = 0; k < 3; ++k) {
            const auto place = static_cast<double>(splat.centre[k]);
            const double steps = std::round(std::ldexp(place, kBitsOfFraction));
            if (!(std::abs(steps) < (1 << 23)))
                throw Error(ErrorCode::InvalidArgument, name,
                            "cannot hold a splat at " + numberText(place) +
                                ", expected places of -2048..2048; a .ply holds all");
            addBytes(arrays[0], static_cast<std::int32_t>(steps), 3);
            arrays[2] += codeOf(255 * (kColourScale * harmonicOf(splat.colour[k]) + 0.5));
            arrays[3] += codeOf(16 * (std::log(static_cast<double>(splat.radii[k])) + 10));
        }
        arrays[1] += codeOf(255 * static_cast<double>(splat.opacity));
        addBytes(arrays[4], packedRotation(splat.rotation));
    }
    const std::size_t count = coefficientsOf(scene.degree);
    for (std::size_t i = 0; i < scene.harmonics.size(); ++i) {
        // 5 bits for degree 1, 4 for higher ones, as the format's own library rounds
        const int step = i / 3 % count < 3 ? 8 : 16;
        const int value =
            static_cast<int>(std::lround(static_cast<double>(scene.harmonics[i]) * 128)) + 128;
        const int steps = (value + step / 2) / step;
        arrays[5] += codeOf(steps * step);
    }
    std::string bytes = "NGSP";
    addBytes(bytes, std::uint32_t{3});
    addBytes(bytes, static_cast<std::uint32_t>(scene.splats.size()));
    bytes += {static_cast<char>(scene.degree), static_cast<char>(kBitsOfFraction),
              static_cast<char>(scene.isAntialiased ? 1 : 0), '\0'};
    for (const std::string& array : arrays)
        bytes += array;
    return gzipped(bytes);
}

} // namespace altiro3D
