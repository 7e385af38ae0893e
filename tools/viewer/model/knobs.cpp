#include "viewer/model/knobs.hpp"

#include <algorithm>
#include <tuple>

namespace altiro3D::viewer {

namespace {

auto parts(const Knobs& k) {
    return std::tuple_cat(
        std::tie(k.views, k.fit, k.framing, k.isFramingChosen, k.depth, k.best, k.columns, k.rows),
        AutoChoices::fields(k.automatic));
}

// What fills the panel without zoom, in widths and heights of the photo; above 1 where bars show.
cv::Size2d windowOf(const FramedPhoto& photo) {
    constexpr int kFine = 1 << 14; // px of the result; the bars are rounded to them
    const PhotoFit fit = fitPhoto(photo.size, photo.panelAspect, {kFine, kFine}, photo.fit);
    const auto part = [](int source, int whole, int target) {
        return static_cast<double>(source) / whole * kFine / target;
    };
    return {part(fit.source.width, photo.size.width, fit.target.width),
            part(fit.source.height, photo.size.height, fit.target.height)};
}

double centreWithin(double centre, double part) {
    return part >= 1 ? 0.5 : std::clamp(centre, part / 2, 1 - part / 2);
}

cv::Point2d within(cv::Point2d centre, cv::Size2d window, double zoom) {
    return {centreWithin(centre.x, window.width / zoom),
            centreWithin(centre.y, window.height / zoom)};
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

Framing allowed(const Framing& framing, const FramedPhoto& photo) {
    if (framing.zoom <= 1) return framing;
    if (std::min(photo.size.width, photo.size.height) < kMinFramedPixels)
        return {framing.centre, 1};
    const cv::Size2d window = windowOf(photo);
    const double least =
        std::min(window.width * photo.size.width, window.height * photo.size.height);
    return {framing.centre, std::clamp(least / kMinFramedPixels, 1.0, framing.zoom)};
}

Framing moved(const Framing& framing, const FramedPhoto& photo, cv::Point2d by) {
    const cv::Size2d window = windowOf(photo);
    const auto [centre, zoom] = allowed(framing, photo);
    const cv::Point2d from = within(centre, window, zoom);
    const cv::Point2d to(from.x - by.x * window.width / zoom, from.y - by.y * window.height / zoom);
    return {within(to, window, zoom), zoom};
}

Framing zoomed(const Framing& framing, const FramedPhoto& photo, cv::Point2d at, double factor) {
    const cv::Size2d window = windowOf(photo);
    const auto [centre, zoom] = allowed(framing, photo);
    const cv::Point2d from = within(centre, window, zoom);
    Framing result;
    result.zoom = allowed({centre, std::clamp(zoom * factor, 1.0, kMaxZoom)}, photo).zoom;
    const double change = 1 / zoom - 1 / result.zoom;
    const cv::Point2d to(from.x + (at.x - 0.5) * window.width * change,
                         from.y + (at.y - 0.5) * window.height * change);
    result.centre = within(to, window, result.zoom);
    return result;
}

} // namespace altiro3D::viewer
