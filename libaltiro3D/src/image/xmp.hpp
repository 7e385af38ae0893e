#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace altiro3D {

/// What precedes XMP in an APP1 segment of a JPEG.
constexpr std::string_view kXmpMark("http://ns.adobe.com/xap/1.0/\0", 29);

/// One entry of a `Container:Directory`: a file that follows the picture (Dynamic Depth).
struct XmpItem {
    std::string semantic;      ///< "Primary", "Depth", "Original", ...; may be empty.
    std::string uri;           ///< "android/depthmap"; may be empty.
    std::uint64_t length = 0;  ///< Bytes.
    std::uint64_t padding = 0; ///< Bytes after it.
};

/// A property: an attribute, or an element that holds only text. The entries of a list have the
/// name of the list.
struct XmpProperty {
    std::string space; ///< URI of the namespace.
    std::string name;  ///< Local name.
    std::string value;
};

/// The properties of XMP data (XML), in document order. Attributes and elements count the same.
///
/// Long values, such as a picture in base64, are not copied: they are views into the text.
class Xmp {
  public:
    /// Malformed XML gives the properties before the fault.
    /// @param text XMP; must outlive the object
    explicit Xmp(std::string_view text);

    /// The value of the first property whose namespace contains `space`; empty if there is none.
    std::string_view value(std::string_view space, std::string_view name) const;
    bool has(std::string_view space, std::string_view name) const;
    /// The value as a number; 0 if it is missing or no finite number.
    double number(std::string_view space, std::string_view name) const;
    /// The entries of `Container:Directory`.
    const std::vector<XmpItem>& items() const { return items_; }

  private:
    const XmpProperty* find(std::string_view space, std::string_view name) const;

    std::vector<XmpProperty> properties_;
    std::vector<std::string_view> longValues_;
    std::vector<XmpItem> items_;
};

/// Decodes base64. Skips white space and references (`&#xA;`); the first other character ends it.
std::string decodeBase64(std::string_view text);

} // namespace altiro3D
