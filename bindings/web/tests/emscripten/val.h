#pragma once

/// @file
/// The part of Emscripten's headers that altiro3d.cpp uses, without a function: other compilers
/// then see whether it fits the library. scripts/build-web.sh builds it in earnest.

#include <cstddef>
#include <string>

namespace emscripten {

struct MemoryView {};
template <class T>
MemoryView typed_memory_view(std::size_t /*count*/, const T* /*values*/) {
    return {};
}
struct allow_raw_pointers {};

class val {
  public:
    val() = default;
    template <class T>
    explicit val(const T& /*value*/) {}
    static val global(const char* /*name*/) { return {}; }
    static val object() { return {}; }
    static val array() { return {}; }
    template <class... T>
    val new_(T&&... /*arguments*/) const {
        return {};
    }
    template <class Result, class... T>
    Result call(const char* /*name*/, T&&... /*arguments*/) const {
        return Result();
    }
    template <class Key>
    val operator[](const Key& /*key*/) const {
        return {};
    }
    template <class Key, class T>
    void set(const Key& /*key*/, const T& /*value*/) {}
    template <class T>
    T as() const {
        return T();
    }
    [[noreturn]] void throw_() const;
    bool isUndefined() const { return false; }
    bool isNull() const { return false; }
    bool isString() const { return false; }
    bool isNumber() const { return false; }
    bool isTrue() const { return false; }
};

} // namespace emscripten
