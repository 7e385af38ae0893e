#pragma once

/// @file
/// What the shared library shows to the outside; all else is hidden.

/// @def ALTIRO3D_EXPORT
/// Marks what a user of the library may link to.

#if defined(ALTIRO3D_STATIC)
#define ALTIRO3D_EXPORT
#elif defined(_WIN32)
#if defined(ALTIRO3D_BUILDING)
#define ALTIRO3D_EXPORT __declspec(dllexport)
#else
#define ALTIRO3D_EXPORT __declspec(dllimport)
#endif
#else
#define ALTIRO3D_EXPORT __attribute__((visibility("default")))
#endif
