#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/photo_fit.hpp"
#include "common/display_options.hpp"

#include <string>
#include <vector>

namespace altiro3D::viewer {

/// Depth as the picture has it, else by standardNetwork(), else by the estimator that is built in.
constexpr const char* kBestDepth = "best";
/// Depth as the picture has it.
constexpr const char* kGivenDepth = "given";
/// Depth by the estimator that is built in.
constexpr const char* kBuiltInDepth = "built-in";

/// Everything that can be turned while looking; the same for all pictures.
struct Knobs {
    ViewOptions views;              ///< Method, strength, focus and what goes with the method.
    FitMode fit = FitMode::Cover;   ///< How a photo is brought to the panel's shape.
    std::string depth = kBestDepth; ///< One of the words above, or a network's name.
    bool best = false;              ///< See makesBestNative().
    int columns = 0;                ///< Columns of the quilt; 0: the display's own.
    int rows = 0;                   ///< Rows of the quilt; 0: the display's own.
};

bool operator==(const Knobs& a, const Knobs& b);
inline bool operator!=(const Knobs& a, const Knobs& b) {
    return !(a == b);
}

/// The Native is read at the panel's resolution and from any position, as by photo2native -k
/// --continuous. Not by method Real, which makes whole views only.
inline bool makesBestNative(const Knobs& knobs) {
    return knobs.best && knobs.views.method != ViewMethod::Real;
}

/// The quilt that the knobs mean for a display: its own with other columns and rows in it.
QuiltLayout layoutOf(const Knobs& knobs, const Display& display);

} // namespace altiro3D::viewer
