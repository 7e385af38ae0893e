#pragma once

/// @file
/// Symbol visibility: the shared library exports only what is marked here.

/// @def ALTIRO3D_EXPORT
/// Exports a function or class from the shared library.

#ifdef ALTIRO3D_BUILDS_DLL // the DLL for Windows
#define ALTIRO3D_EXPORT __declspec(dllexport)
#elif defined(_WIN32) // MinGW imports without a mark
#define ALTIRO3D_EXPORT
#else
#define ALTIRO3D_EXPORT __attribute__((visibility("default")))
#endif
