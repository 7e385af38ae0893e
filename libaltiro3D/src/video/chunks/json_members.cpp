#include "video/chunks/json_members.hpp"

#include "altiro3D/error.hpp"

#include <limits>

namespace altiro3D {

namespace {

constexpr std::size_t kMaxEntries = 1000000;

} // namespace

std::int64_t JsonMembers::whole(const char* name, std::int64_t least, std::int64_t most) const {
    const Json& value = at(name);
    if (!value.is_number_integer()) fail();
    if (value.is_number_unsigned() &&
        value.get<std::uint64_t>() >
            static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
        fail();
    }
    const auto number = value.get<std::int64_t>();
    if (number < least || number > most) fail();
    return number;
}

std::uint64_t JsonMembers::bits(const char* name) const {
    const Json& value = at(name);
    if (!value.is_number_unsigned()) fail();
    return value.get<std::uint64_t>();
}

std::string JsonMembers::text(const char* name) const {
    const Json& value = at(name);
    if (!value.is_string()) fail();
    return value.get<std::string>();
}

const Json& JsonMembers::list(const char* name) const {
    const Json& value = at(name);
    if (!value.is_array() || value.size() > kMaxEntries) fail();
    return value;
}

const Json& JsonMembers::at(const char* name) const {
    if (!object_.is_object() || !object_.contains(name)) fail();
    return object_[name];
}

void JsonMembers::fail() const {
    throw Error(ErrorCode::BadFormat, file_.string(),
                "is damaged, expected the file as it was written");
}

} // namespace altiro3D
