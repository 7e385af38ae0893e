#include "altiro3D/placement.hpp"

#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"
#include "scene/framing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

// Whether a network has estimated the depth: no other source aligns its edges.
bool isEstimated(const Scene& scene) {
    return scene.edges == DepthEdges::Aligned;
}

// The depth of a part of a photo, with no more px than are needed to show its steps.
cv::Mat depthOf(const Scene& scene, const cv::Rect& part) {
    constexpr int kMost = 1024;
    const cv::Size photo = scene.photo.size();
    const cv::Size size(std::min(scene.depth.cols, kMost), std::min(scene.depth.rows, kMost));
    const auto range = [](int first, int length, int from, int to) {
        const auto at = [&](int place) {
            return static_cast<int>(std::int64_t{place} * to / from);
        };
        const int start = std::min(at(first), to - 1);
        return cv::Range(start, std::max(at(first + length), start + 1));
    };
    return sampledDepth(scene.depth, size)(range(part.y, part.height, photo.height, size.height),
                                           range(part.x, part.width, photo.width, size.width));
}

// How much depth falls along a row, from one side or the other; mean of the rows.
double fallOfRows(const cv::Mat& depth) {
    double right = 0;
    double left = 0;
    for (int y = 0; y < depth.rows; ++y) {
        const float* const row = depth.ptr<float>(y);
        for (int x = 1; x < depth.cols; ++x) {
            const double step = static_cast<double>(row[x]) - static_cast<double>(row[x - 1]);
            (step < 0 ? right : left) += std::abs(step);
        }
    }
    return std::max(right, left) / depth.rows;
}

// The strength at which kMaxAutoHidden % of an outermost view consist of px that the photo hides or
// that are stretched; (7.4). Infinite if the depth is level.
double strengthLimit(const cv::Mat& depth) {
    return 2 * kMaxAutoHidden / fallOfRows(depth);
}

double strengthOf(const Scene& scene, double aspect, const QuiltLayout& quilt,
                  const PlacementOptions& options, const AutoChoices& choices) {
    const cv::Rect shown = shownPart(scene.photo.size(), aspect, options.fit, options.framing);
    const cv::Mat depth = depthOf(scene, shown);
    const double limit = strengthLimit(depth);
    if (!choices.strength) return std::min(options.views.strengthPercent, limit);
    cv::Vec2d range(0, 1);
    if (!choices.isVideo) cv::minMaxLoc(depth, &range[0], &range[1]);
    return std::min(strengthOfRange(options.views.focus, quilt, range), limit);
}

// Leaves out the sides of a border that views would show.
// @param inside the photo without its border @param uncut fit of the photo with it
cv::Rect withoutSeenBorder(cv::Size photo, const cv::Rect& inside, const PhotoFit& uncut) {
    const double scale = static_cast<double>(uncut.source.width) / uncut.target.width;
    const cv::Point end = uncut.source.br();
    const int left = uncut.source.x - uncut.leftMargin * scale < inside.x ? inside.x : 0;
    const int top = uncut.source.y < inside.y ? inside.y : 0;
    const int right =
        end.x + uncut.rightMargin * scale > inside.br().x ? inside.br().x : photo.width;
    const int bottom = end.y > inside.br().y ? inside.br().y : photo.height;
    return {left, top, right - left, bottom - top};
}

// Framing and focus, if they are requested.
void chooseSubject(const Scene& scene, double aspect, const AutoChoices& choices,
                   PlacementOptions& options) {
    if (!choices.framing && !choices.focus) return;
    check(!choices.framing || options.fit == FitMode::Cover, "framing",
          "cannot be chosen automatically with this fit, expected cover");
    cv::Mat weights;
    subjectWeights(scene.photo, scene.depth, weights);
    const cv::Size size = scene.photo.size();
    Framing& framing = options.framing;
    if (choices.framing) framing.centre = frameSubject(weights, size, aspect, framing.zoom).centre;
    if (!choices.focus) return;
    const cv::Rect part = shownPart(size, aspect, options.fit, framing);
    const cv::Rect2d share(static_cast<double>(part.x) / size.width,
                           static_cast<double>(part.y) / size.height,
                           static_cast<double>(part.width) / size.width,
                           static_cast<double>(part.height) / size.height);
    options.views.focus = subjectDepth(weights, scene.depth, share);
}

} // namespace

double strengthOfRange(double focus, const QuiltLayout& quilt, cv::Vec2d depthRange) {
    const double reach = std::max(std::abs(depthRange[0] - focus), std::abs(depthRange[1] - focus));
    double widths = kMaxAutoParallax / 100; // shift of content at `reach`
    if (quilt.viewCount > 1) {
        const double pixels = kParallaxBudgetPixels * (quilt.viewCount - 1);
        widths = std::min(widths, pixels / quilt.tileSize.width);
    }
    const double strength = 100 * widths / reach; // infinite for a flat picture in focus
    return strength < kMaxAutoStrength ? strength : kMaxAutoStrength;
}

Scene withDepthCurve(const Scene& scene, double exponent) try {
    Scene bent = scene;
    if (exponent == 1) return bent;
    bent.depth = bendDepth(scene.depth, exponent);
    if (!scene.hidden.depth.empty()) bent.hidden.depth = bendDepth(scene.hidden.depth, exponent);
    return bent;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

PhotoFit withMargins(const PhotoFit& fit, cv::Size picture, const ViewOptions& options) {
    validate(options);
    constexpr int kSteps = 32;          // steps per width
    constexpr double kInterpolated = 2; // px beside the last position
    const double shift =
        options.strengthPercent / 200 * fit.size.width * std::max(options.focus, 1 - options.focus);
    if (shift == 0) return fit;
    const int step = std::max(1, fit.size.width / kSteps);
    const double steps = std::ceil((shift + kInterpolated) / step);
    const int pixels = static_cast<int>(std::min(steps * step, fit.size.width / 2.0));
    return withMargins(fit, picture, pixels);
}

PhotoFit fitWithMargins(cv::Size photo, double aspect, cv::Size size,
                        const PlacementOptions& options) {
    return withMargins(fitPhoto(photo, aspect, size, options.fit, options.framing), photo,
                       options.views);
}

Placement placeScene(const Scene& given, double aspect, cv::Size size,
                     const PlacementOptions& options) try {
    const Scene scene = withDepthCurve(given, options.depthCurve);
    Placement placed;
    placed.fit = fitWithMargins(scene.photo.size(), aspect, size, options);
    const double focus = options.views.focus;
    // docs/lab/edges.md
    const bool isFast = options.views.method == ViewMethod::Fast && isEstimated(scene);
    if (isFast && (!options.refine.flaws || options.refine.keepsDepth())) {
        applyFit(scene.photo, placed.fit, placed.scene.photo);
        applyFitToDepth(scene.depth, scene.photo.size(), placed.fit, {}, focus, placed.scene.depth);
        placed.scene.shown = placed.fit.shown();
        placed.scene.edges = scene.edges;
    } else {
        placed.flaws = fitScene(scene, placed.fit, focus, placed.scene, options.refine);
    }
    return placed;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

ChosenOptions chooseFromScene(const Scene& given, double aspect, const QuiltLayout& quilt,
                              const PlacementOptions& options, const AutoChoices& choices) try {
    validate(options.views);
    if (choices.strength || choices.limit) validate(quilt);
    const Scene scene = withDepthCurve(given, options.depthCurve);
    ChosenOptions chosen{options, {{}, scene.photo.size()}};
    PlacementOptions& now = chosen.options;
    chooseSubject(scene, aspect, choices, now);
    const bool isLimited = choices.limit && isEstimated(scene);
    if (choices.strength || isLimited)
        now.views.strengthPercent = strengthOf(scene, aspect, quilt, now, choices);
    if (choices.framing && !choices.isVideo) {
        const cv::Size photo = scene.photo.size();
        const cv::Rect inside = withoutScanBorder(scene.photo);
        const Framing wanted = now.framing;
        PlacementOptions uncut = now; // as if the photo had no border
        uncut.framing = insideViews(scene, {{}, photo}, aspect, wanted, now.views);
        now.framing = insideViews(scene, inside, aspect, wanted, now.views);
        if (now.framing != uncut.framing) { // else no border is seen
            constexpr int kFine = 1024;
            const cv::Size size(kFine, std::max(1, cvRound(kFine / aspect)));
            chosen.inside =
                withoutSeenBorder(photo, inside, fitWithMargins(photo, aspect, size, uncut));
        }
    }
    return chosen;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

Network2Quilt::Network2Quilt(DepthNetwork network, const QuiltLayout& layout,
                             const ViewOptions& options, double panelAspect, FitMode fit)
    : source_(depthFromNetwork(std::move(network))), depth2quilt_(layout, options),
      panelAspect_(panelAspect), fit_(fit) {
    // Checks the aspect early.
    static_cast<void>(fitPhoto(layout.tileSize, panelAspect, layout.tileSize, fit));
}

void Network2Quilt::render(const cv::Mat& photo, cv::Mat& quilt) try {
    const ViewOptions& views = depth2quilt_.options();
    Scene scene;
    source_->readScene(photo, views.focus, scene);
    depth_ = scene.depth;
    const cv::Size tile = depth2quilt_.layout().tileSize;
    depth2quilt_.render(placeScene(scene, panelAspect_, tile, {views, fit_, {}, {}}).scene, quilt);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
