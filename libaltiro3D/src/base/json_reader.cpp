#include "base/json_reader.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <set>
#include <string_view>
#include <vector>

namespace altiro3D {

namespace {

// Position of a byte in the text, "line 3, column 7", counted from 1.
std::string placeOf(const std::string& text, std::size_t byte) {
    const std::size_t end = std::min(byte > 0 ? byte - 1 : 0, text.size());
    const std::string before = text.substr(0, end);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t lineStart = before.rfind('\n') + 1; // npos + 1 = 0: the first line
    return "line " + std::to_string(line) + ", column " + std::to_string(end - lineStart + 1);
}

// The limit that a text exceeds; empty if none. Scans brackets only, before the parser allocates.
std::string exceededLimit(std::string_view text, const JsonLimits& limits) {
    std::vector<int> members; // member counts of the open objects and lists
    bool inString = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (inString) {
            if (c == '\\') {
                ++i;
            } else if (c == '"') {
                inString = false;
            }
        } else if (c == '"') {
            inString = true;
        } else if (c == '{' || c == '[') {
            if (members.size() == limits.levels)
                return "nests deeper than " + std::to_string(limits.levels) + " levels";
            members.push_back(0);
        } else if (c == '}' || c == ']') {
            if (!members.empty()) members.pop_back();
        } else if (c == ':') {
            if (!members.empty() && ++members.back() > limits.members) {
                return "has an object with more than " + std::to_string(limits.members) +
                       " members";
            }
        }
    }
    return {};
}

} // namespace

Json parseJson(const std::string& text, const std::string& source, const std::string& expected,
               const JsonLimits& limits) {
    const auto fail = [&](const std::string& problem) {
        throw Error(ErrorCode::BadFormat, source, problem + ", expected " + expected);
    };
    const std::string exceeded = exceededLimit(text, limits);
    if (!exceeded.empty()) fail(exceeded);
    std::vector<std::set<std::string>> keys; // keys of the open objects
    const auto checkKey = [&](int, Json::parse_event_t event, Json& parsed) {
        if (event == Json::parse_event_t::object_start) keys.emplace_back();
        if (event == Json::parse_event_t::object_end) keys.pop_back();
        if (event == Json::parse_event_t::key) {
            const auto& key = parsed.get_ref<const std::string&>();
            if (!keys.back().insert(key).second) {
                throw Error(ErrorCode::BadFormat, source,
                            "the key \"" + shortened(key) +
                                "\" occurs twice in one object, expected it once");
            }
        }
        return true;
    };
    try {
        return limits.refuseRepeated ? Json::parse(text, checkKey) : Json::parse(text);
    } catch (const Json::parse_error& error) {
        fail("is not valid JSON (" + placeOf(text, error.byte) + ")");
    } catch (const Json::exception&) { // a number beyond double, for example 1e999
        fail("holds a number that is out of range");
    }
    return {};
}

std::string shownJson(const Json& value) {
    if (value.is_array()) return "a list";
    if (value.is_object()) return "an object";
    return shortened(value.dump(-1, ' ', false, Json::error_handler_t::replace));
}

} // namespace altiro3D
