#include "base/system_library.hpp"

#include <dlfcn.h>
#include <system_error>

namespace altiro3D {

void* openLibrary(const std::string& name) {
    return ::dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
}

void* addressIn(void* library, const char* name) {
    return library != nullptr ? ::dlsym(library, name) : nullptr;
}

std::string libraryProblem() {
    const char* const problem = ::dlerror();
    return problem != nullptr ? problem : "";
}

std::filesystem::path ownFile() {
    Dl_info info{};
    std::error_code error;
    static const char here = 0;
    std::filesystem::path file;
    if (::dladdr(&here, &info) != 0 && info.dli_fname != nullptr) file = info.dli_fname;
    // the name that a program was started with may have no folder, or one that has changed since
    if (file.has_parent_path()) file = std::filesystem::canonical(file, error);
    if (error || !file.is_absolute()) file = std::filesystem::canonical("/proc/self/exe", error);
    return file;
}

} // namespace altiro3D
