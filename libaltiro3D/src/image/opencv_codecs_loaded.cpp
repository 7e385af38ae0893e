#include "altiro3D/error.hpp"
#include "image/opencv_codecs.hpp"

#include <dlfcn.h>
#include <filesystem>
#include <string>

namespace altiro3D {

namespace {

// The library beside this one.
std::string codecsLibrary() {
    constexpr const char* kName = "libaltiro3D-imgcodecs.so." ALTIRO3D_SOVERSION;
    Dl_info here{};
    if (dladdr(reinterpret_cast<const void*>(&openCvCodecs), &here) == 0) return kName;
    return (std::filesystem::path(here.dli_fname).parent_path() / kName).string();
}

} // namespace

const OpenCvCodecs& openCvCodecs() {
    static const OpenCvCodecs* const codecs = [] {
        const std::string file = codecsLibrary();
        void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
        void* const found = library != nullptr ? dlsym(library, "kAltiro3dOpenCvCodecs") : nullptr;
        if (found == nullptr) {
            const char* const problem = dlerror();
            throw Error(ErrorCode::Unsupported, file,
                        std::string("cannot be loaded (") + (problem != nullptr ? problem : "") +
                            "), expected it beside libaltiro3D; without it, only JPEG, PNG, HEIC "
                            "and AVIF pictures can be read");
        }
        return static_cast<const OpenCvCodecs*>(found);
    }();
    return *codecs;
}

} // namespace altiro3D
