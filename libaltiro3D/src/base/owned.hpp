#pragma once

#include <type_traits>

namespace altiro3D {

/// Deleter for objects of C libraries: calls a function with the object, or with the address of its
/// pointer. std::unique_ptr<TIFF, Free<TIFFClose>>
template <auto kFree>
struct Free {
    template <class Object>
    void operator()(Object* object) const {
        if constexpr (std::is_invocable_v<decltype(kFree), Object*>) {
            kFree(object);
        } else {
            kFree(&object);
        }
    }
};

} // namespace altiro3D
