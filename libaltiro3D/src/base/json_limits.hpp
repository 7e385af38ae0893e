#pragma once

#include <string_view>
#include <vector>

namespace altiro3D {

/// True if a JSON text nests no deeper and no object in it has more members: deep documents
/// overflow the stack when they are taken apart again, and ordered objects find a member by looking
/// at all of them. Total: any text is fine, also one that is no JSON.
inline bool isHandy(std::string_view json, std::size_t mostLevels, int mostMembers) {
    std::vector<int> members; // of the objects and lists that are open
    bool inString = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (inString) {
            if (c == '\\') {
                ++i;
            } else if (c == '"') {
                inString = false;
            }
        } else if (c == '"') {
            inString = true;
        } else if (c == '{' || c == '[') {
            if (members.size() == mostLevels) return false;
            members.push_back(0);
        } else if (c == '}' || c == ']') {
            if (!members.empty()) members.pop_back();
        } else if (c == ':') {
            if (!members.empty() && ++members.back() > mostMembers) return false;
        }
    }
    return true;
}

} // namespace altiro3D
