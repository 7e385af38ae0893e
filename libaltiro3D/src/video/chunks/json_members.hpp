#pragma once

#include "base/json_reader.hpp"

#include <cstdint>
#include <filesystem>
#include <string>

namespace altiro3D {

/// Reads the members of an object that this library wrote. A member that is missing, of another
/// type or out of range is reported as damage of the file.
class JsonMembers {
  public:
    /// @param object is kept by reference
    /// @param file it was read from, for messages; is kept by reference
    JsonMembers(const Json& object, const std::filesystem::path& file)
        : object_(object), file_(file) {}

    /// A whole number least..most.
    std::int64_t whole(const char* name, std::int64_t least, std::int64_t most) const;
    /// A number of 64 bits, such as a checksum.
    std::uint64_t bits(const char* name) const;
    std::string text(const char* name) const;
    /// A list of at most 1000000 values.
    const Json& list(const char* name) const;
    const Json& at(const char* name) const;
    /// @throws Error BadFormat: the file is damaged
    [[noreturn]] void fail() const;

  private:
    const Json& object_;
    const std::filesystem::path& file_;
};

} // namespace altiro3D
