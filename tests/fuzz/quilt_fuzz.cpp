// -q, -r and quilt names: a line each, then bytes that choose which of them are used.

#include "altiro3D/quilt.hpp"
#include "fuzz.hpp"

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes(data, size);
    const std::string name = bytes.line();
    const std::string grid = bytes.line();
    const std::string tile = bytes.line();
    const unsigned flags = bytes.byte();
    QuiltRequest request;
    fuzz::reads([&] { request.name = parseQuiltName(name); });
    if ((flags & 1U) != 0) fuzz::reads([&] { request.grid = parseQuiltGrid(grid); });
    if ((flags & 2U) != 0) fuzz::reads([&] { request.tileSize = parseTileSize(tile); });
    if ((flags & 4U) != 0)
        request.quiltSize = cv::Size(1 + 257 * bytes.byte(), 1 + 257 * bytes.byte());
    fuzz::reads([&] {
        const ResolvedQuilt resolved = resolveQuilt(request, {}, 0.75);
        validate(resolved.layout);
        const std::filesystem::path named = quiltFileName(name, resolved.layout, 0.75);
        constexpr std::size_t kMaxNameBytes = 200; // no file's is much longer
        if (name.size() > kMaxNameBytes) return;
        const std::optional<QuiltName> again = parseQuiltName(named);
        fuzz::require(again.has_value(), "a quilt's name says what it holds");
    });
    return 0;
}
