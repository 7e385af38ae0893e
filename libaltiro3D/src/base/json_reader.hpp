#pragma once

#include <nlohmann/json.hpp> // slow to compile: included only by the sources of readers
#include <string>

namespace altiro3D {

/// Objects keep the order of the file.
using Json = nlohmann::ordered_json;

/// Limits of a JSON text from a file. Deep documents overflow the stack when they are destroyed,
/// and finding a member of an ordered object takes time proportional to the number of its members.
struct JsonLimits {
    std::size_t levels = 64;     ///< Nested objects and lists.
    int members = 1000;          ///< Members of one object.
    bool refuseRepeated = false; ///< A repeated key in an object is an error.
};

/// Parses a JSON text. Safe for any bytes.
/// @param source file name, for errors
/// @param expected for errors: "a display's visual.json"
/// @throws Error BadFormat: beyond the limits, or invalid, with line and column
Json parseJson(const std::string& text, const std::string& source, const std::string& expected,
               const JsonLimits& limits = {});

/// Formats a value for an error message: lists and objects are only named, strings are shortened.
std::string shownJson(const Json& value);

} // namespace altiro3D
