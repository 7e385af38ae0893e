#include "cli/foreign_json.hpp"

#include "altiro3D/error.hpp"

#include <nlohmann/json.hpp>

namespace altiro3D::tools {

using Json = nlohmann::ordered_json;

Json parseForeignJson(const std::string& text, const std::string& source,
                      const std::string& expected) {
    constexpr int kMaxLevels = 64;
    const auto check = [&](int level, Json::parse_event_t, const Json&) {
        if (level > kMaxLevels)
            throw Error(ErrorCode::BadFormat, source, "nests too deep, expected " + expected);
        return true;
    };
    try {
        return Json::parse(text, check);
    } catch (const Json::exception&) {
        throw Error(ErrorCode::BadFormat, source, "is not valid JSON, expected " + expected);
    }
}

} // namespace altiro3D::tools
