// HEIC and AVIF: what they say about themselves, stereo pairs, and the repair of files of iOS 18.

#include "fuzz.hpp"
#include "image/heif_file.hpp"
#include "image/image_header.hpp"

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view bytes = fuzz::textOf(data, size);
    const std::string repaired = repairedHeif(bytes);
    fuzz::require(repaired.empty() || repaired.size() == size, "a repair keeps all offsets");
    if (!repaired.empty()) fuzz::require(repairedHeif(repaired).empty(), "one repair is enough");
    fuzz::require(heifProblem(bytes, 4e8).size() < 200, "a problem is a part of a sentence");
    const auto eyes = findHeifEyes(bytes);
    fuzz::require(!eyes || eyes->left != eyes->right, "two eyes have two pictures");
    const ImageHeader header = readImageHeader(bytes, ".heic");
    fuzz::require(header.orientation >= 1 && header.orientation <= 8, "orientations are 1..8");
    return 0;
}
