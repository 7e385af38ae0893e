#include "altiro3D/error.hpp"
#include "base/system_library.hpp"
#include "image/opencv_codecs.hpp"

#include <string>

namespace altiro3D {

namespace {

// The library beside this one.
std::string codecsLibrary() {
    constexpr const char* kName = "libaltiro3D-imgcodecs.so." ALTIRO3D_SOVERSION;
    return (ownFile().parent_path() / kName).string();
}

} // namespace

const OpenCvCodecs& openCvCodecs() {
    static const OpenCvCodecs* const codecs = [] {
        const std::string file = codecsLibrary();
        const void* const found = addressIn(openLibrary(file), "kAltiro3dOpenCvCodecs");
        if (found == nullptr) {
            throw Error(ErrorCode::Unsupported, file,
                        "cannot be loaded (" + libraryProblem() +
                            "), expected it beside libaltiro3D; without it, only JPEG, PNG, HEIC "
                            "and AVIF pictures can be read");
        }
        return static_cast<const OpenCvCodecs*>(found);
    }();
    return *codecs;
}

} // namespace altiro3D
