// On Windows a std::filesystem::path holds UTF-16. Where it is made from a std::string, or gives
// one, the C++ library converts by this class, which follows the code page of the C library:
// Latin-1. Texts are UTF-8 here, as on other systems, so these definitions take the place of those
// in libstdc++.a. Each program and DLL needs this object file.

#include <codecvt>
#include <locale>

namespace std {

namespace {

using Utf8 = codecvt_utf8_utf16<wchar_t>;

const Utf8& utf8() {
    static const Utf8& converter = *new Utf8; // used until the end of the process
    return converter;
}

} // namespace

using Converter = codecvt<wchar_t, char, mbstate_t>;

codecvt_base::result Converter::do_out(mbstate_t& state, const wchar_t* from,
                                       const wchar_t* fromEnd, const wchar_t*& fromNext, char* to,
                                       char* toEnd, char*& toNext) const {
    return utf8().out(state, from, fromEnd, fromNext, to, toEnd, toNext);
}

codecvt_base::result Converter::do_in(mbstate_t& state, const char* from, const char* fromEnd,
                                      const char*& fromNext, wchar_t* to, wchar_t* toEnd,
                                      wchar_t*& toNext) const {
    return utf8().in(state, from, fromEnd, fromNext, to, toEnd, toNext);
}

int Converter::do_length(mbstate_t& state, const char* from, const char* end, size_t most) const {
    return utf8().length(state, from, end, most);
}

int Converter::do_encoding() const noexcept {
    return 0; // characters have 1 to 4 bytes
}

int Converter::do_max_length() const noexcept {
    return 4;
}

} // namespace std
