// .map files, as they are and with checksums that match.

#include "altiro3D/native_lut.hpp"
#include "fuzz.hpp"

#include <cstring>
#include <zlib.h>

using namespace altiro3D;

namespace {

constexpr std::size_t kHeaderBytes = 128;

void putCrc(std::string& bytes, std::size_t at, std::size_t begin, std::size_t end) {
    const auto crc = static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()) + begin, end - begin));
    std::memcpy(bytes.data() + at, &crc, sizeof crc);
}

void load(const fuzz::Directory& directory, std::string_view bytes) {
    const std::filesystem::path file = directory.file("a.map", bytes);
    fuzz::reads([&] {
        const NativeLut lut = NativeLut::load(file);
        const cv::Size quilt = lut.quilt().size();
        for (int c = 0; c < 3; ++c) {
            const cv::Mat& table = lut.channel(c);
            for (int y = 0; y < table.rows; ++y) {
                const auto* pair = table.ptr<std::uint16_t>(y);
                for (int x = 0; x < table.cols; ++x, pair += 2)
                    fuzz::require(pair[0] < quilt.width && pair[1] < quilt.height,
                                  "coordinates lie in the quilt");
            }
        }
    });
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::Directory directory;
    std::string bytes(fuzz::textOf(data, size));
    load(directory, bytes);
    if (size < kHeaderBytes) return 0;
    putCrc(bytes, kHeaderBytes - 8, kHeaderBytes, bytes.size());
    putCrc(bytes, kHeaderBytes - 4, 0, kHeaderBytes - 4);
    load(directory, bytes);
    return 0;
}
