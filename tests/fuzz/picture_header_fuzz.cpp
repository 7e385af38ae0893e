// Headers of pictures; the first byte chooses the extension.

#include "altiro3D/image_io.hpp"
#include "fuzz.hpp"
#include "image/image_header.hpp"

#include <array>

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::array<const char*, 8> kExtensions = {"",     ".jpg", ".mpo", ".tif",
                                                        ".nef", ".dng", ".tga", ".cr2"};
    fuzz::Bytes bytes(data, size);
    const char* const extension = kExtensions[bytes.byte() % kExtensions.size()];
    const ImageHeader header = readImageHeader(bytes.rest(), extension);
    fuzz::require(header.orientation >= 1 && header.orientation <= 8, "orientations are 1..8");
    fuzz::require(header.pictures >= 1, "there is a picture at least");
    fuzz::require(header.usableBytes <= size, "usable bytes are in the file");
    fuzz::reads(
        [&] { static_cast<void>(creditOf(PhotoFile(std::string(bytes.rest()), "a.jpg"))); });
    return 0;
}
