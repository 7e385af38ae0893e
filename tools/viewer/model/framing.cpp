#include "viewer/model/framing.hpp"

#include <algorithm>

namespace altiro3D::viewer {

namespace {

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
