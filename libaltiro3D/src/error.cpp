#include "altiro3D/error.hpp"

namespace altiro3D {

namespace {

// What comes from files and users may hold line breaks; an error stays one line.
std::string oneLine(std::string text) {
    for (char& c : text) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    }
    return text;
}

} // namespace

Error::Error(ErrorCode code, const std::string& subject, const std::string& problem)
    : std::runtime_error(oneLine(subject + ": " + problem)), code_(code) {}

} // namespace altiro3D
