#include "viewer/knobs.hpp"

#include <tuple>

namespace altiro3D::viewer {

namespace {

auto parts(const Knobs& k) {
    const ViewOptions& v = k.views;
    return std::make_tuple(v.method, v.strengthPercent, v.focus, v.refinement,
                           v.layered.edgeDilationPixels, v.layered.fill, v.layered.softBorders,
                           v.real.inpainting, v.real.backgroundOnly, k.fit, k.framing.centre.x,
                           k.framing.centre.y, k.framing.zoom, k.isFramingChosen,
                           k.automatic.framing, k.automatic.focus, k.automatic.strength,
                           k.automatic.limit, k.depth, k.best, k.columns, k.rows);
}

} // namespace

int nextGesture() {
    static int last = 0;
    return ++last;
}

bool operator==(const Knobs& a, const Knobs& b) {
    return parts(a) == parts(b);
}

QuiltLayout layoutOf(const Knobs& knobs, const Display& display) {
    QuiltLayout layout = display.quilt;
    if (knobs.columns <= 0 && knobs.rows <= 0) return layout;
    const cv::Size quilt = layout.size();
    if (knobs.columns > 0) layout.columns = knobs.columns;
    if (knobs.rows > 0) layout.rows = knobs.rows;
    layout.tileSize = {quilt.width / layout.columns, quilt.height / layout.rows};
    layout.viewCount = layout.columns * layout.rows;
    return layout;
}

} // namespace altiro3D::viewer
