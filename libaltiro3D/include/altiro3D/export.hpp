#pragma once

/// @file
/// What the shared library shows to the outside; all else is hidden.

/// @def ALTIRO3D_EXPORT
/// Marks what a user of the library may link to.

#define ALTIRO3D_EXPORT __attribute__((visibility("default")))
