#pragma once

#include "val.h"

namespace emscripten {

template <class T>
struct class_ {
    explicit class_(const char* /*name*/) {}
    template <class... A>
    class_& constructor(A... /*bound*/) {
        return *this;
    }
    template <class... A>
    class_& function(const char* /*name*/, A... /*bound*/) {
        return *this;
    }
    template <class... A>
    class_& property(const char* /*name*/, A... /*bound*/) {
        return *this;
    }
};
template <class... A>
void function(const char* /*name*/, A... /*bound*/) {}

} // namespace emscripten

#define EMSCRIPTEN_BINDINGS(name) void name##Bindings() // of no use here
