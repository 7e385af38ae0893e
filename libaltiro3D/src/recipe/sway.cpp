#include "altiro3D/sway.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/video_io.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "views/view_methods.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace altiro3D {

namespace {

constexpr int kLongSide = 1920; // longest sides that decoders of phones and browsers support
constexpr int kShortSide = 1080;
constexpr int kMinSide = 16;
constexpr double kMaxAspect = 100;
constexpr double kShownHeight = 10000; // height of a tile with square px; only its shape matters
constexpr double kCrf = 20;            // sufficient for viewing; a Native needs better quality

// Rounds down to an even number, with a tolerance for rounding errors.
int evenSide(double side) {
    return std::max(kMinSide, 2 * static_cast<int>(std::floor(side / 2 + 1e-6)));
}

void checkPicture(cv::Size picture, double aspect) {
    check(picture.width > 0 && picture.height > 0, "picture",
          "of " + sizeText(picture) + " cannot be shown, expected at least 1 x 1");
    check(aspect > 0 && std::isfinite(aspect), "aspect",
          "is " + numberText(aspect) + ", expected more than 0");
}

// Positions of the px of a side after the side is scaled.
cv::Range scaled(int start, int length, double factor, int most) {
    const int begin = std::clamp(static_cast<int>(std::lround(start * factor)), 0, most - 1);
    const int end =
        std::clamp(static_cast<int>(std::lround((start + length) * factor)), begin + 1, most);
    return {begin, end};
}

double checkedPosition(double position) {
    check(!std::isnan(position), "position", "is nan, expected a number");
    return std::clamp(position, -1.0, 1.0);
}

// A photo and the renderer that reads it.
struct PhotoScene {
    PhotoScene(const Scene& given, const ViewOptions& givenOptions)
        : scene(given), options(givenOptions), renderer(makeRenderer(scene, options, 1)) {}

    Scene scene;
    ViewOptions options;
    std::unique_ptr<ViewRenderer> renderer;
};

} // namespace

void validate(const SwayOptions& options) {
    check(options.secondsPerTurn >= 0.1 && options.secondsPerTurn <= 600, "secondsPerTurn",
          "is " + numberText(options.secondsPerTurn) + " s, expected 0.1..600 s");
    check(options.turns >= 1 && options.turns <= 1000, "turns",
          "is " + std::to_string(options.turns) + ", expected 1..1000");
    check(options.frameRate.isKnown() && options.frameRate.value() >= 1 &&
              options.frameRate.value() <= 240,
          "frameRate",
          "is " + std::to_string(options.frameRate.numerator) + "/" +
              std::to_string(options.frameRate.denominator) + ", expected 1..240 frames a second");
}

int framesPerTurn(const SwayOptions& options) {
    validate(options);
    const double quarter = options.secondsPerTurn * options.frameRate.value() / 4;
    return 4 * std::max(1, static_cast<int>(std::lround(quarter)));
}

double swayPosition(int frame, int framesPerTurn) {
    check(framesPerTurn >= 4 && framesPerTurn % 4 == 0, "framesPerTurn",
          "is " + std::to_string(framesPerTurn) + ", expected a multiple of 4, at least 4");
    check(frame >= 0, "frame", "is " + std::to_string(frame) + ", expected 0 or more");
    // Folded into the first quarter, so equal positions are equal numbers.
    const int quarter = framesPerTurn / 4;
    const int inTurn = frame % framesPerTurn;
    const bool left = inTurn > 2 * quarter;
    const int inHalf = left ? inTurn - 2 * quarter : inTurn;
    const int folded = inHalf > quarter ? 2 * quarter - inHalf : inHalf;
    const double reach = std::sin(CV_PI / 2 * folded / quarter);
    return left ? -reach : reach;
}

cv::Size swaySize(cv::Size picture, double aspect) {
    checkPicture(picture, aspect);
    aspect = std::clamp(aspect, 1 / kMaxAspect, kMaxAspect);
    const double height = std::max<double>(picture.height, picture.width / aspect);
    const double width = height * aspect;
    const double factor =
        std::min({1.0, kLongSide / std::max(width, height), kShortSide / std::min(width, height)});
    const int columns = evenSide(width * factor);
    const int rows = evenSide(height * factor);
    constexpr int kLongest = static_cast<int>(kMaxAspect); // limit in short sides, even if rounded
    return {std::min(columns, kLongest * rows), std::min(rows, kLongest * columns)};
}

PhotoFit swayFit(cv::Size picture, double aspect, cv::Size result, FitMode mode) {
    checkPicture(picture, aspect);
    check(aspect >= 1 / kMaxAspect && aspect <= kMaxAspect, "aspect",
          "is " + numberText(aspect) + ", expected 0.01..100");
    const double resultAspect = static_cast<double>(result.width) / std::max(1, result.height);
    const bool square = std::abs(picture.width - picture.height * aspect) < 1e-6 * picture.width;
    const cv::Size odd = picture - result;
    if (square && odd.width >= 0 && odd.width <= 1 && odd.height >= 0 && odd.height <= 1)
        return {{cv::Point(0, 0), result}, {cv::Point(0, 0), result}, result};
    if (square) return fitPhoto(picture, resultAspect, result, mode); // whole px throughout
    const cv::Size shown(static_cast<int>(std::lround(kShownHeight * aspect)),
                         static_cast<int>(kShownHeight));
    PhotoFit fit = fitPhoto(shown, resultAspect, result, mode);
    const cv::Range columns =
        scaled(fit.source.x, fit.source.width, static_cast<double>(picture.width) / shown.width,
               picture.width);
    const cv::Range rows =
        scaled(fit.source.y, fit.source.height, static_cast<double>(picture.height) / shown.height,
               picture.height);
    fit.source = {columns.start, rows.start, columns.size(), rows.size()};
    return fit;
}

SwayView photoViews(const Scene& scene, const ViewOptions& options) try {
    validate(options);
    const auto shared = std::make_shared<const PhotoScene>(scene, options);
    return [shared](double position, cv::Mat& picture) {
        try {
            const cv::Mat& photo = shared->scene.photo;
            const cv::Range shown = shownColumns(shared->scene);
            picture.create(photo.rows, shown.size(), CV_8UC3);
            renderShown(*shared->renderer, photo.size(), shown,
                        shiftOf(shared->options, shown.size(), checkedPosition(position)), picture);
        } catch (const cv::Exception& exception) {
            leaveAsOurs(exception);
        }
    };
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

SwayView quiltViews(const cv::Mat& quilt, const QuiltLayout& layout, const PhotoFit& fit,
                    ViewFilter between) {
    validate(layout);
    checkType(quilt, {CV_8UC3}, "quilt", "CV_8UC3 (8-bit BGR)");
    if (quilt.size() != layout.size())
        throw Error(ErrorCode::Mismatch, "quilt",
                    "has " + sizeText(quilt.size()) + ", expected " +
                        pairText(layout.size().width, layout.size().height));
    const auto tile = [quilt, layout, fit](int view, cv::Mat& picture) {
        applyFit(quilt(layout.tile(view)), fit, picture);
    };
    return [tile, layout, between](double position, cv::Mat& picture) {
        const double place = (checkedPosition(position) + 1) / 2 * (layout.viewCount - 1);
        if (between == ViewFilter::Nearest)
            return tile(static_cast<int>(std::lround(place)), picture);
        const int first = static_cast<int>(std::floor(place));
        const double part = place - first;
        tile(first, picture);
        if (part == 0) return;
        cv::Mat next;
        tile(first + 1, next);
        cv::addWeighted(picture, 1 - part, next, part, 0, picture);
    };
}

bool writeSway(const std::filesystem::path& path, cv::Size size, const SwayOptions& options,
               const SwayView& view, const VideoProgressFunction& goOn) try {
    checkFunction(view, "view");
    const int turn = framesPerTurn(options);
    VideoWriterOptions video;
    video.size = size;
    video.compatible = true;
    video.crf = kCrf;
    video.timeBase = {options.frameRate.denominator, options.frameRate.numerator};
    video.frameRate = options.frameRate;
    video.constantRate = true;
    VideoWriter writer(path, video);
    const int frames = turn * options.turns;
    VideoProgress progress;
    progress.framesInAll = frames;
    progress.length = frames / options.frameRate.value();
    VideoFrame frame;
    frame.duration = 1;
    for (int i = 0; i < frames; ++i) {
        progress.frames = i;
        progress.end = i / options.frameRate.value();
        if (goOn && !goOn(progress)) return false;
        view(swayPosition(i, turn), frame.picture);
        frame.pts = i;
        writer.write(frame);
    }
    writer.finish();
    return true;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
