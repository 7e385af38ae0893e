#pragma once

/// @file
/// Symbol visibility: the shared library exports only what is marked here.

/// @def ALTIRO3D_EXPORT
/// Exports a function or class from the shared library.

#ifdef _WIN32 // a static library only
#define ALTIRO3D_EXPORT
#else
#define ALTIRO3D_EXPORT __attribute__((visibility("default")))
#endif
