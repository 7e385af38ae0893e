#pragma once

/// @file
/// Symbol visibility: the shared library exports only what is marked here.

/// @def ALTIRO3D_EXPORT
/// Exports a function or class from the shared library.

#define ALTIRO3D_EXPORT __attribute__((visibility("default")))
