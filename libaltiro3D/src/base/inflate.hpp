#pragma once

#include <string>
#include <string_view>
#include <zlib.h>

namespace altiro3D {

/// The contents of a zlib stream; empty if it is damaged or has more than `maxBytes`.
inline std::string inflated(std::string_view packed, std::size_t maxBytes) {
    struct Inflater {
        z_stream stream{};
        bool isOpen = inflateInit(&stream) == Z_OK;
        Inflater() = default;
        Inflater(const Inflater&) = delete;
        Inflater& operator=(const Inflater&) = delete;
        ~Inflater() {
            if (isOpen) inflateEnd(&stream);
        }
    };
    Inflater inflater;
    if (!inflater.isOpen) return {};
    z_stream& stream = inflater.stream;
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    std::string text;
    int result = Z_OK;
    while (result == Z_OK && text.size() <= maxBytes) {
        constexpr std::size_t kStep = std::size_t{1} << 16;
        const std::size_t done = text.size();
        text.resize(done + kStep);
        stream.next_out = reinterpret_cast<Bytef*>(text.data() + done);
        stream.avail_out = static_cast<uInt>(kStep);
        result = inflate(&stream, Z_NO_FLUSH);
        text.resize(text.size() - stream.avail_out);
    }
    return result == Z_STREAM_END && text.size() <= maxBytes ? text : std::string();
}

} // namespace altiro3D
