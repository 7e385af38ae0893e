#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core/types.hpp>
#include <string>
#include <string_view>

namespace altiro3D {

/// A number as people write it ("0.75"), independent of the locale.
inline std::string numberText(double value, int significantDigits = 6) {
    char text[64];
#ifdef __cpp_lib_to_chars
    const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general,
                                   significantDigits);
    return {text, end.ptr};
#else // the library of Emscripten, which has one locale
    std::snprintf(text, sizeof text, "%.*g", significantDigits, value);
    return text;
#endif
}

/// A number with a fixed number of decimals ("0.70"), independent of the locale.
inline std::string fixed(double value, int decimals) {
    char text[512]; // long enough for any double
#ifdef __cpp_lib_to_chars
    const auto end =
        std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals);
    return {text, end.ptr};
#else // the library of Emscripten, which has one locale
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
    return text;
#endif
}

/// Reads the number at the beginning of a text ("0.75", "1."), independent of the locale.
/// @param text begins with a digit; has no exponent
/// @return the number of characters that were read; 0 if the number is out of range
inline std::size_t readNumber(std::string_view text, double& number) {
#ifdef __cpp_lib_to_chars
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
    return error == std::errc() ? static_cast<std::size_t>(end - text.data()) : 0;
#else
    const std::size_t point = std::min(text.find_first_not_of("0123456789"), text.size());
    std::size_t end = point;
    if (point < text.size() && text[point] == '.')
        end = std::min(text.find_first_not_of("0123456789", point + 1), text.size());
    number = std::strtod(std::string(text.substr(0, end)).c_str(), nullptr);
    return std::isfinite(number) ? end : 0;
#endif
}

/// The number at the beginning of a text ("-2.5e-3"), independent of the locale.
/// @return 0 if there is none or it is out of range
inline double numberAt(std::string_view text) {
    double number = 0;
#ifdef __cpp_lib_to_chars
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc()) return 0;
#else
    const std::string digits(text.substr(0, text.find_first_not_of("0123456789.eE+-")));
    if (digits.empty() || digits[0] == '+') return 0;
    number = std::strtod(digits.c_str(), nullptr);
#endif
    return std::isfinite(number) ? number : 0;
}

/// "1536 x 2048": width x height, or any other pair.
inline std::string pairText(long long a, long long b) {
    return std::to_string(a) + " x " + std::to_string(b);
}

/// "1536 x 2048 px": width x height.
inline std::string sizeText(cv::Size size) {
    return pairText(size.width, size.height) + " px";
}

/// Shortens a text from a file for a message, to its first 60 bytes.
inline std::string shortened(const std::string& text) {
    constexpr std::size_t kMaxShown = 60;
    return text.size() <= kMaxShown ? text : text.substr(0, kMaxShown) + "...";
}

/// The words of another program about an error, on one line of at most 200 bytes.
inline std::string oneLine(const std::string& words) {
    constexpr std::size_t kMaxShown = 200;
    std::string text;
    for (const char c : words) {
        const bool space = static_cast<unsigned char>(c) <= 0x20;
        if (text.empty() && (space || c == '>'))
            continue; // OpenCV's mark of a text of several lines
        if (!space) text += c;
        if (space && text.back() != ' ') text += ' ';
        if (text.size() > kMaxShown) return text + "...";
    }
    return text.substr(0, text.find_last_not_of(' ') + 1);
}

inline bool startsWith(std::string_view text, std::string_view prefix) {
    return text.substr(0, prefix.size()) == prefix;
}
inline bool endsWith(std::string_view text, std::string_view ending) {
    return text.size() >= ending.size() && text.substr(text.size() - ending.size()) == ending;
}

inline bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

/// A..Z as a..z, independent of the locale.
inline char lowerCase(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}
inline std::string lowerCase(std::string text) {
    for (char& c : text)
        c = lowerCase(c);
    return text;
}

/// The extension of a file name with its dot, in lower case.
inline std::string lowerExtension(const std::filesystem::path& path) {
    return lowerCase(path.extension().string());
}

} // namespace altiro3D
