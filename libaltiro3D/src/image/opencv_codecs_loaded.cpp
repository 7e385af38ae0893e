#include "altiro3D/error.hpp"
#include "altiro3D/version.hpp"
#include "image/opencv_codecs.hpp"

#include <dlfcn.h>

namespace altiro3D {

const OpenCvCodecs& openCvCodecs() {
    static const OpenCvCodecs* const codecs = [] {
        constexpr const char* kLibrary = "libaltiro3D-imgcodecs.so." ALTIRO3D_SOVERSION;
        void* const library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
        void* const found = library != nullptr ? dlsym(library, "kAltiro3dOpenCvCodecs") : nullptr;
        if (found == nullptr) {
            const char* const problem = dlerror();
            throw Error(
                ErrorCode::Unsupported, kLibrary,
                std::string("cannot be loaded (") + (problem != nullptr ? problem : "") +
                    "), expected it beside libaltiro3D; without it, only JPEG, PNG, HEIC and "
                    "AVIF pictures can be read");
        }
        return static_cast<const OpenCvCodecs*>(found);
    }();
    return *codecs;
}

} // namespace altiro3D
