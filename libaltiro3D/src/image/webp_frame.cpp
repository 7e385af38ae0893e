#include "image/webp_frame.hpp"

#include "base/byte_reader.hpp"

namespace altiro3D {

namespace {

std::string littleEndian(std::uint64_t value, int size) {
    std::string bytes;
    for (int i = 0; i < size; ++i)
        bytes.push_back(static_cast<char>(value >> (8 * i) & 0xffU));
    return bytes;
}

} // namespace

WebPFrame firstWebPFrame(std::string_view bytes) {
    constexpr std::uint64_t kFrameHeader = 16;
    const ByteReader reader(bytes, true);
    for (std::uint64_t at = 12; reader.holds(at, 8);) {
        const std::uint64_t size = reader.u32(at + 4);
        const std::uint64_t data = at + 8;
        if (reader.text(at, 4) != "ANMF" || size < kFrameHeader || !reader.holds(data, size)) {
            at = data + size + (size & 1);
            continue;
        }
        const auto number = [&](std::uint64_t offset) {
            return static_cast<int>(reader.number(data + offset, 3));
        };
        WebPFrame frame;
        frame.area = {2 * number(0), 2 * number(3), number(6) + 1, number(9) + 1};
        const std::string_view chunks = reader.text(data + kFrameHeader, size - kFrameHeader);
        std::string body = "WEBP";
        if (chunks.substr(0, 4) == "ALPH") { // needs the header of an extended file
            body += "VP8X" + littleEndian(10, 4) + littleEndian(0x10, 4) +
                    std::string(reader.text(data + 6, 6));
        }
        body += chunks;
        frame.file = "RIFF" + littleEndian(body.size(), 4) + body;
        return frame;
    }
    return {};
}

} // namespace altiro3D
