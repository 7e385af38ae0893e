#pragma once

#include <cstddef>
#include <string_view>

/// Tables with an entry per enumerator; for GCC and Clang.
namespace altiro3D {

/// Whether a value of an enumeration has a name. The compiler writes a value with a name as
/// `Enum::Name`, and one without as `(Enum)3`. @return true if it has one
template <auto kValue>
constexpr bool isEnumerator() {
    constexpr std::string_view kStart = "kValue = ";
    constexpr std::string_view kName = __PRETTY_FUNCTION__;
    return kName[kName.find(kStart) + kStart.size()] != '(';
}

/// Counts the enumerators of an enumeration that counts from 0 without gaps. @return their number
template <class Enum, std::size_t kFrom = 0>
constexpr std::size_t enumCount() {
    if constexpr (isEnumerator<static_cast<Enum>(kFrom)>()) {
        return enumCount<Enum, kFrom + 1>();
    } else {
        return kFrom;
    }
}

/// The entry of an enumerator. A table that lacks one does not compile.
/// @param table an entry for each enumerator, in their order
/// @param value the enumerator
/// @return its entry
template <class Enum, class Entry, std::size_t kEntries>
constexpr const Entry& entryOf(const Entry (&table)[kEntries], Enum value) {
    static_assert(kEntries == enumCount<Enum>(), "expected an entry for each enumerator");
    return table[static_cast<std::size_t>(value)];
}

} // namespace altiro3D
