#include "base/system_process.hpp"

namespace altiro3D {

const char kShellQuote = '\'';
const char* const kQuoteInShellQuotes = "'\\''";

std::tm localTime(std::time_t time) {
    std::tm local{};
    localtime_r(&time, &local);
    return local;
}

void requestLargePages(const void* /*begin*/, const void* /*end*/) {}

} // namespace altiro3D
