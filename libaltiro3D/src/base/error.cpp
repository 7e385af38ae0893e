#include "altiro3D/error.hpp"

#include "altiro3D/enum_table.hpp"
#include "altiro3D/version.hpp"

namespace altiro3D {

std::string withoutControls(std::string text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto c = static_cast<unsigned char>(text[i]);
        if (c < 0x20 || c == 0x7f) text[i] = ' ';
        // U+0080..U+009F, control characters for some terminals
        if (c == 0xc2 && i + 1 < text.size() && (text[i + 1] & 0xe0) == 0x80)
            text.replace(i, 2, " ");
    }
    return text;
}

const char* errorCodeName(ErrorCode code) noexcept {
    constexpr const char* kNames[] = {
        "InvalidArgument", "NotFound", "ReadFailed", "WriteFailed", "BadFormat",
        "Unsupported",     "TooLarge", "Mismatch",   "OutOfMemory", "NetworkFailed"};
    return entryOf(kNames, code);
}

Error::Error(ErrorCode code, const std::string& subject, const std::string& problem)
    : std::runtime_error(withoutControls(subject + ": " + problem)), code_(code),
      subjectBytes_(withoutControls(subject).size()) {}

const char* version() noexcept {
    return ALTIRO3D_VERSION;
}

} // namespace altiro3D
