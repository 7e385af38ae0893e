#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace altiro3D::tools {

/// Parses a JSON text of another program. Safe for any bytes: deep ones would overflow the stack.
/// @param source for errors @param expected for errors: "answers of Looking Glass Bridge"
/// @throws Error BadFormat (not JSON, more than 64 levels)
nlohmann::ordered_json parseForeignJson(const std::string& text, const std::string& source,
                                        const std::string& expected);

} // namespace altiro3D::tools
