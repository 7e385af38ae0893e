#include "base/system_library.hpp"
#include "base/system_windows.hpp"

#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

void* openLibrary(const std::string& name) {
    return reinterpret_cast<void*>(::LoadLibraryW(fs::path(name).c_str()));
}

void* addressIn(void* library, const char* name) {
    if (library == nullptr) return nullptr;
    return reinterpret_cast<void*>(::GetProcAddress(static_cast<HMODULE>(library), name));
}

std::string libraryProblem() {
    return std::system_category().message(static_cast<int>(::GetLastError()));
}

fs::path ownFile() {
    static const char here = 0;
    HMODULE module = nullptr;
    ::GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS |
                             GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                         reinterpret_cast<LPCWSTR>(&here), &module);
    std::wstring name(std::size_t{1} << 15, L'\0');
    name.resize(::GetModuleFileNameW(module, name.data(), static_cast<DWORD>(name.size())));
    return name;
}

} // namespace altiro3D
