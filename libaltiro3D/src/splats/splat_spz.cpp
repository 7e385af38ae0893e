#include "base/byte_reader.hpp"
#include "base/checks.hpp"
#include "splats/splat_collector.hpp"

#include <algorithm>
#include <array>
#include <cstring>
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
};

// The first bytes of a gzip stream. @return fewer if it has fewer or is damaged
std::string gunzipped(std::string_view packed, std::uint64_t wanted) {
    z_stream stream{};
    constexpr int kGzip = 15 + 16;
    if (inflateInit2(&stream, kGzip) != Z_OK) return {};
    std::string bytes;
    std::size_t done = 0;
    const char* from = packed.data();
    std::size_t left = packed.size();
    int result = Z_OK;
    while (result == Z_OK && done < wanted) {
        constexpr std::size_t kStep = std::size_t{1} << 22;
        // not all at once: a header may lie about the number of splats
        bytes.resize(std::min<std::uint64_t>(wanted, done + kStep));
        const auto in = static_cast<uInt>(std::min(left, kStep));
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(from));
        stream.avail_in = in;
        stream.next_out = reinterpret_cast<Bytef*>(bytes.data() + done);
        stream.avail_out = static_cast<uInt>(bytes.size() - done);
        result = inflate(&stream, Z_NO_FLUSH);
        const std::size_t made = bytes.size() - done - stream.avail_out;
        const std::size_t taken = in - stream.avail_in;
        if (made == 0 && taken == 0) break;
        done += made;
        from += taken;
        left -= taken;
    }
    inflateEnd(&stream);
    bytes.resize(done);
    return bytes;
}

SpzHeader headerOf(std::string_view bytes, const std::string& name) {
    const ByteReader reader(bytes, true);
    const auto require = [&](bool condition, ErrorCode code, const std::string& problem) {
        if (!condition) throw Error(code, name, problem);
    };
    require(bytes.size() >= kHeader && reader.u32(0) == kMagic, ErrorCode::BadFormat,
            "is not a scene of splats, expected .spz");
    SpzHeader header;
    header.version = reader.u32(4);
    header.count = reader.u32(8);
    header.degree = static_cast<int>(reader.u8(12));
    header.fractionBits = static_cast<int>(reader.u8(13));
    const unsigned flags = reader.u8(14);
    header.isAntialiased = (flags & 1U) != 0;
    header.hasExtensions = (flags & 2U) != 0;
    header.streams = reader.u8(15);
    require(header.version >= 1 && header.version <= 4, ErrorCode::Unsupported,
            "is .spz of version " + std::to_string(header.version) + ", expected 1 to 4");
    require(header.degree <= 4, ErrorCode::BadFormat,
            "has harmonics of degree " + std::to_string(header.degree) + ", expected at most 4");
    require(header.fractionBits <= 23, ErrorCode::BadFormat,
            "has positions with " + std::to_string(header.fractionBits) +
                " bits of fraction, expected at most 23");
    require(header.count <= kMaxSplats, ErrorCode::TooLarge,
            "has " + std::to_string(header.count) + " splats, expected at most " +
                std::to_string(kMaxSplats));
    return header;
}

[[noreturn]] void tellDamage(const std::string& name) {
    throw Error(ErrorCode::BadFormat, name, "is damaged or ends early, expected a whole .spz file");
}

std::array<std::string, 6> legacyStreams(std::string_view packed, const SpzHeader& header,
                                         const std::string& name) {
    std::uint64_t whole = kHeader;
    for (const std::uint64_t size : header.sizes())
        whole += size;
    constexpr std::uint64_t kMostPacked = 1040; // gzip makes of a byte at most so many
    std::string bytes =
        whole / kMostPacked > packed.size() ? std::string() : gunzipped(packed, whole);
    if (bytes.size() < whole) {
        // positions come first, so all splats end early together
        throw Error(ErrorCode::BadFormat, name,
                    "ends after " + std::to_string(bytes.size()) + " of " + std::to_string(whole) +
                        " bytes of its " + std::to_string(header.count) +
                        " splats, expected a whole file");
    }
    std::array<std::string, 6> streams;
    std::uint64_t at = kHeader;
    for (std::size_t i = 0; i < streams.size(); ++i) {
        streams[i] = bytes.substr(at, header.sizes()[i]);
        at += header.sizes()[i];
    }
    return streams;
}

#ifdef ALTIRO3D_HAVE_ZSTD
std::array<std::string, 6> streamsOf4(std::string_view bytes, const SpzHeader& header,
                                      const std::string& name) {
    const ByteReader reader(bytes, true);
    const std::uint64_t table = reader.u32(16);
    std::uint64_t at = table + std::uint64_t{16} * header.streams;
    std::array<std::string, 6> streams;
    for (std::size_t i = 0; i < streams.size(); ++i) {
        const std::uint64_t size = header.sizes()[i];
        if (size == 0) continue;
        const std::uint64_t packed = reader.u64(table + 16 * i);
        if (i >= header.streams || !reader.holds(at, packed) ||
            reader.u64(table + 16 * i + 8) != size)
            tellDamage(name);
        const std::string_view stream = reader.text(at, packed);
        // the stream's own word first: memory is allocated for what it says it holds
        if (ZSTD_getFrameContentSize(stream.data(), stream.size()) != size) tellDamage(name);
        streams[i].resize(size);
        if (ZSTD_decompress(streams[i].data(), size, stream.data(), stream.size()) != size)
            tellDamage(name);
        at += packed;
    }
    return streams;
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

float halfFloat(std::uint32_t bits) {
    const auto exponent = static_cast<int>(bits >> 10 & 31U);
    const auto fraction = static_cast<float>(bits & 1023U) / 1024;
    const float size = exponent == 0    ? std::ldexp(fraction, -14)
                       : exponent == 31 ? std::numeric_limits<float>::quiet_NaN()
                                        : std::ldexp(1 + fraction, exponent - 15);
    return (bits & 0x8000U) != 0 ? -size : size;
}

// The rotation of versions 3 and 4: the largest of x, y, z, w is left out.
cv::Vec4f smallestThree(std::uint32_t packed) {
    const auto largest = static_cast<int>(packed >> 30);
    double xyzw[4] = {};
    double rest = 1;
    for (int i = 3; i >= 0; --i) {
        if (i == largest) continue;
        const double size = (packed & 511U) / 511.0 * std::sqrt(0.5);
        xyzw[i] = (packed >> 9 & 1U) != 0 ? -size : size;
        rest -= size * size;
        packed >>= 10;
    }
    xyzw[largest] = std::sqrt(std::max(rest, 0.0));
    return {static_cast<float>(xyzw[3]), static_cast<float>(xyzw[0]), static_cast<float>(xyzw[1]),
            static_cast<float>(xyzw[2])};
}

cv::Vec4f firstThree(float x, float y, float z) {
    return {std::sqrt(std::max(1 - x * x - y * y - z * z, 0.0F)), x, y, z};
}

} // namespace

SplatScene parseSpz(std::string_view bytes, const std::string& name, SplatAxes axes, Notes* notes) {
    const bool isPlain = startsWith(bytes, "NGSP");
    const SpzHeader header =
        headerOf(isPlain ? std::string(bytes.substr(0, kHeader)) : gunzipped(bytes, kHeader), name);
    if (isPlain != (header.version == 4)) tellDamage(name);
    std::array<std::string, 6> streams;
    if (isPlain) {
        if (axes == SplatAxes::Auto && header.hasExtensions)
            axes = axesRecord(bytes, name).value_or(axes);
#ifdef ALTIRO3D_HAVE_ZSTD
        streams = streamsOf4(bytes, header, name);
#else
        throw Error(ErrorCode::Unsupported, name,
                    "is .spz of version 4, for which this build lacks libzstd, expected version 3");
#endif
    } else {
        streams = legacyStreams(bytes, header, name);
    }
    const auto code = [&](std::size_t stream, std::uint64_t at) {
        return static_cast<float>(static_cast<unsigned char>(streams[stream][at]));
    };
    const ByteReader positions(streams[0], true);
    const ByteReader rotations(streams[4], true);
    const auto unit = static_cast<float>(std::ldexp(1.0, -header.fractionBits));
    SplatCollector collector(header.count, header.degree);
    std::vector<float> harmonics(3 * coefficientsOf(header.degree));
    for (std::uint64_t i = 0; i < header.count; ++i) {
        Splat splat;
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
        }
        splat.opacity = code(1, i) / 255;
        splat.rotation = header.version >= 3 ? smallestThree(rotations.u32(4 * i))
                                             : firstThree(code(4, 3 * i) / 127.5F - 1,
                                                          code(4, 3 * i + 1) / 127.5F - 1,
                                                          code(4, 3 * i + 2) / 127.5F - 1);
        for (std::size_t k = 0; k < harmonics.size(); ++k)
            harmonics[k] = (code(5, i * harmonics.size() + k) - 128) / 128;
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
    constexpr int kGzip = 15 + 16;
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
    std::array<std::string, 6> streams;
    for (const Splat& splat : scene.splats) {
        for (int k = 0; k < 3; ++k) {
            const double steps =
                std::round(std::ldexp(static_cast<double>(splat.centre[k]), kBitsOfFraction));
            if (!(std::abs(steps) < (1 << 23)))
                throw Error(ErrorCode::InvalidArgument, name,
                            "cannot hold a splat at " +
                                numberText(static_cast<double>(splat.centre[k])) +
                                ", expected places of -2048..2048; a .ply holds all");
            const auto raw = static_cast<std::uint32_t>(static_cast<std::int32_t>(steps));
            for (unsigned shift = 0; shift < 24; shift += 8)
                streams[0].push_back(static_cast<char>(raw >> shift & 255U));
            const double dc = (static_cast<double>(splat.colour[k]) - 0.5) / kHarmonic0;
            streams[2].push_back(codeOf(255 * (kColourScale * dc + 0.5)));
            streams[3].push_back(codeOf(16 * (std::log(static_cast<double>(splat.radii[k])) + 10)));
        }
        streams[1].push_back(codeOf(255 * static_cast<double>(splat.opacity)));
        const std::uint32_t rotation = packedRotation(splat.rotation);
        for (unsigned shift = 0; shift < 32; shift += 8)
            streams[4].push_back(static_cast<char>(rotation >> shift & 255U));
    }
    const std::size_t count = coefficientsOf(scene.degree);
    for (std::size_t i = 0; i < scene.harmonics.size(); ++i) {
        // 5 bits for degree 1, 4 for higher ones, as the format's own library rounds
        const int step = i / 3 % count < 3 ? 8 : 16;
        const int value =
            static_cast<int>(std::lround(static_cast<double>(scene.harmonics[i]) * 128)) + 128;
        const int rounded = (value + step / 2) / step * step;
        streams[5].push_back(codeOf(rounded));
    }
    std::string bytes = "NGSP";
    for (const std::uint32_t number : {3U, static_cast<std::uint32_t>(scene.splats.size())})
        for (unsigned shift = 0; shift < 32; shift += 8)
            bytes.push_back(static_cast<char>(number >> shift & 255U));
    bytes += {static_cast<char>(scene.degree), static_cast<char>(kBitsOfFraction),
              static_cast<char>(scene.isAntialiased ? 1 : 0), '\0'};
    for (const std::string& stream : streams)
        bytes += stream;
    return gzipped(bytes);
}

} // namespace altiro3D
