#include "viewer/model/knobs.hpp"

#include <tuple>

namespace altiro3D::viewer {

namespace {

auto parts(const Knobs& k) {
    return std::tuple_cat(
        std::tie(k.views, k.fit, k.framing, k.isFramingChosen, k.depth, k.best, k.columns, k.rows),
        AutoChoices::fields(k.automatic));
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
