#include "viewer/model/studio.hpp"

#include "altiro3D/altiro3D.hpp"
#include "viewer/model/depth_maker.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <tuple>

namespace altiro3D::viewer {

namespace {

// A view of this many px is made within 50 ms on two cores; larger windows show it enlarged.
constexpr double kMaxPreviewPixels = 7e5;
// The same with other depth, which is fitted first.
constexpr double kMaxDraftPixels = 2.5e5;

// The last result and its inputs. Documents and displays are immutable, so equal pointers mean
// equal contents; the key keeps them alive.
template <class Key, class Value>
class Kept {
  public:
    template <class Make>
    const Value& get(const Key& key, const Make& make) {
        if (!key_ || *key_ != key) {
            key_.reset(); // if making fails
            value_ = make();
            key_ = key;
        }
        return value_;
    }

  private:
    std::optional<Key> key_;
    Value value_;
};

using DocumentPointer = std::shared_ptr<const Document>;
using DisplayPointer = std::shared_ptr<const Display>;

cv::Mat sized(const cv::Mat& picture, cv::Size size) {
    if (picture.size() == size) return picture;
    cv::Mat result;
    const bool smaller = size.width <= picture.cols && size.height <= picture.rows;
    cv::resize(picture, result, size, 0, 0, smaller ? cv::INTER_AREA : cv::INTER_LINEAR);
    return result;
}

bool isFlat(const cv::Mat& depth) {
    double low = 0;
    double high = 0;
    cv::minMaxLoc(depth, &low, &high);
    return low == high;
}

// The size, reduced if it has more than `most` px.
cv::Size limited(cv::Size size, double most) {
    if (size.area() <= most) return size;
    const double smaller = std::sqrt(most / size.area());
    return {static_cast<int>(size.width * smaller), static_cast<int>(size.height * smaller)};
}

// The size of what an eye sees of an interlaced picture: half the rows or half the columns.
cv::Size halved(cv::Size eye, EyesPicture picture) {
    if (!isInterlaced(picture)) return eye;
    return picture == EyesPicture::Rows ? cv::Size(eye.width, (eye.height + 1) / 2)
                                        : cv::Size((eye.width + 1) / 2, eye.height);
}

// On black. @param size not smaller
cv::Mat inMiddle(const cv::Mat& picture, cv::Size size) {
    cv::Mat all(size, picture.type(), cv::Scalar::all(0));
    picture.copyTo(all(cv::Rect(cv::Point(size - picture.size()) / 2, picture.size())));
    return all;
}

// The part of a picture that is seen px by px, moved from the middle; `pan` is kept inside.
cv::Mat window(const cv::Mat& picture, cv::Size area, cv::Point& pan) {
    const cv::Size size(std::min(area.width, picture.cols), std::min(area.height, picture.rows));
    const cv::Point most((picture.cols - size.width) / 2, (picture.rows - size.height) / 2);
    pan.x = std::clamp(pan.x, -most.x, most.x);
    pan.y = std::clamp(pan.y, -most.y, most.y);
    return picture(cv::Rect(most - pan, size));
}

} // namespace

struct Studio::State {
    std::shared_ptr<DepthMaker> depthMaker;

    Kept<std::tuple<DocumentPointer, std::string>, PhotoDepth> depth;
    using FitKey =
        std::tuple<std::string, DocumentPointer, cv::Rect, cv::Rect, cv::Size, int, double, double>;
    // A fitted scene, and the flaws of its depth, which a video keeps for a scene.
    struct Fitted {
        Kept<FitKey, Scene> scene;
        std::tuple<std::string, int, std::string, int, int> flawsOf;
        std::optional<DepthFlaws> flaws;
    };
    Fitted preview;
    Kept<FitKey, cv::Mat> photo; // of the preview
    Fitted tiles;
    Fitted panel; // for the Native of a photo
    // Document, depth, display, settings, and whether it is a draft.
    using NativeKey = std::tuple<DocumentPointer, std::string, DisplayPointer, Knobs, bool>;
    Kept<std::tuple<DocumentPointer, DisplayPointer, SplatSight>, DocumentPointer> splats;
    Kept<std::pair<std::string, NativeKey>, Knobs> chosen; // with the file of a video
    Kept<std::pair<NativeKey, cv::Point>, SwayView> views; // the point: their size
    Kept<NativeKey, cv::Mat> quilt;
    Kept<NativeKey, cv::Mat> native;
    Kept<NativeKey, double> hidden;

    PhotoDepth makeDepth(const Document& document, const std::string& from) {
        PhotoDepth map;
        if (!document.depth.empty() && (from != kGivenDepth || document.rawDepth.empty())) {
            map.depth = document.depth;
            map.depthSource =
                (from == kGivenDepth ? "both eyes" : from) + ", as often as the video needs it";
        } else if (from == kGivenDepth) {
            document.readDepth(map.depth);
            map.hidden = document.hidden;
            scaleHiddenDepth(document.rawDepth, map.depth, map.hidden);
            map.depthSource = !document.source.depth.empty()
                                  ? document.source.depth.filename().string()
                              : document.depthOrigin.empty() ? "in the picture"
                                                             : document.depthOrigin;
        } else {
            Scene scene;
            depthMaker->use(from, [&](DepthSource& source) {
                source.readScene(document.picture, DepthNormalization().flatDepth, scene);
            });
            map.depth = scene.depth;
            map.depthSource = from;
        }
        map.flat = !document.video && isFlat(map.depth);
        return map;
    }

    FitKey fitKey(const std::string& from, const Setup& setup, cv::Size size) const {
        // the bars of Contain lie at the focus, and so does flat depth
        const bool atFocus = setup.knobs.fit == FitMode::Contain || setup.flat;
        const PhotoFit fit = fitOf(setup, size);
        return {from,
                setup.document,
                fit.source,
                fit.filled(),
                fit.size,
                fit.leftMargin,
                atFocus ? setup.knobs.views.focus : 0,
                setup.knobs.depthCurve};
    }

    const Scene& fittedScene(Fitted& kept, const Setup& setup, cv::Size size) {
        return kept.scene.get(fitKey(setup.from, setup, size), [&] {
            const Document& document = *setup.document;
            if (!document.video) return placed(setup, size).scene;
            const std::tuple now(document.source.file.string(), document.scene, setup.from,
                                 size.width, size.height);
            if (now != kept.flawsOf) kept.flaws.reset();
            kept.flawsOf = now;
            return placed(setup, size, kept.flaws).scene;
        });
    }

    // For the window. With painted depth, only the depth changes from stroke to stroke.
    const Scene& fittedPreview(const Setup& setup, cv::Size size) {
        if (setup.painted.depth.empty()) return fittedScene(preview, setup, size);
        return preview.scene.get(fitKey(setup.from, setup, size), [&] {
            return fitted(setup, size, photo.get(fitKey({}, setup, size), [&] {
                return fittedPhoto(setup, size);
            }));
        });
    }

    // A photo at the size of the tiles; nothing for quilts and Natives, which need none.
    Scene fittedTiles(const Setup& setup) {
        if (setup.document->kind != Kind::Scene) return {};
        return fittedScene(tiles, setup, quiltLayout(setup).tileSize);
    }

    // A photo at the size for its Native; nothing for quilts and Natives.
    Scene fittedNative(const Setup& setup) {
        if (setup.document->kind != Kind::Scene) return {};
        const cv::Size size = nativeFitSize(setup);
        return fittedScene(size == quiltLayout(setup).tileSize ? tiles : panel, setup, size);
    }

    NativeKey keyOf(const Setup& setup) const {
        Knobs knobs = setup.document->kind == Kind::Scene ? setup.knobs : Knobs();
        return {setup.document, setup.from, setup.display, knobs, setup.isDraft};
    }

    // Chooses what is automatic. A video stays steady: all pictures of a scene share the choice for
    // the first one that was made with these settings.
    void choose(Setup& setup) {
        if (!setup.knobs.choices.any()) return;
        const Document& document = *setup.document;
        std::string video;
        if (document.video)
            video = document.source.file.string() + ' ' + std::to_string(document.scene);
        const NativeKey key{document.video ? nullptr : setup.document, setup.from, setup.display,
                            setup.knobs, false};
        setup.knobs = chosen.get({video, key}, [&] {
            Setup now = setup;
            chooseAutomatic(now);
            return now.knobs;
        });
    }

    // Splats as the mouse has turned them, and with the focus and strength that were set.
    void lookAtSplats(Setup& setup) {
        const Knobs& knobs = setup.knobs;
        SplatSight sight;
        sight.layout = setup.display->quilt;
        const SplatSight usual = sight;
        if (!knobs.choices.framing) sight.framing = knobs.framing;
        if (!knobs.choices.focus) sight.focus = knobs.views.focus;
        if (!knobs.choices.strength && !knobs.choices.limit)
            sight.strengthPercent = knobs.views.strengthPercent;
        sight.isDraft = setup.isDraft;
        sight.isOneView = setup.isDraft && (setup.mode == Mode::Sway || setup.mode == Mode::Depth);
        if (sight != usual)
            setup.document = splats.get({setup.document, setup.display, sight}, [&] {
                return std::make_shared<const Document>(
                    withSight(*setup.document, *setup.display, sight));
            });
        setup.knobs.framing = sight.framing;
        setup.knobs.views.focus = setup.document->placement->focus;
        setup.knobs.views.strengthPercent = setup.document->placement->strengthPercent;
    }

    const cv::Mat& quiltOf(const Setup& setup) {
        return quilt.get(keyOf(setup), [&] { return makeQuilt(setup, fittedTiles(setup)); });
    }

    // @param position -1 leftmost .. +1 rightmost
    void viewOf(const Setup& setup, double position, cv::Size size, cv::Mat& view) {
        if (setup.document->kind != Kind::Quilt)
            return views.get({keyOf(setup), cv::Point(size)}, [&] {
                return photoViews(fittedPreview(setup, size), setup.knobs.views);
            })(position, view);
        const QuiltLayout layout = quiltLayout(setup);
        const double place = (position + 1) / 2 * (layout.viewCount - 1);
        const int index = std::clamp(static_cast<int>(std::lround(place)), 0, layout.viewCount - 1);
        view = sized(setup.document->picture(layout.tile(index)), size);
    }

    StereoPair eyesOf(const Setup& setup, cv::Size size) {
        if (setup.document->kind == Kind::Quilt) {
            const StereoPair eyes = makeEyes(setup);
            return {sized(eyes.left, size), sized(eyes.right, size), {}};
        }
        const Setup whole = forEyes(setup);
        return renderEyes(fittedScene(preview, whole, size), whole.knobs.views, setup.eyes.from);
    }

    // What eyes see that are an eighth of the cone to the left and right of a position.
    StereoPair eyesAround(const Setup& setup, cv::Size size) {
        constexpr double kApart = 0.25;
        const double middle = std::clamp(setup.position, kApart - 1, 1 - kApart);
        Setup whole = forEyes(setup);
        whole.knobs.views.strengthPercent = setup.knobs.views.strengthPercent;
        StereoPair eyes;
        viewOf(whole, middle - kApart, size, eyes.left);
        viewOf(whole, middle + kApart, size, eyes.right);
        return eyes;
    }

    const cv::Mat& nativeOf(const Setup& setup) {
        return native.get(keyOf(setup), [&] { return makeNative(setup, fittedNative(setup)); });
    }
};

Studio::Studio(std::shared_ptr<DepthMaker> depthMaker) : state_(std::make_unique<State>()) {
    state_->depthMaker = std::move(depthMaker);
}

Studio::~Studio() = default;

cv::Size inside(cv::Size area, double aspect) {
    const double width = std::min<double>(area.width, area.height * aspect);
    return {std::max(1, static_cast<int>(std::lround(width))),
            std::max(1, static_cast<int>(std::lround(width / aspect)))};
}

double depthSeenAt(const cv::Mat& depth, const ViewOptions& views, double position, cv::Point at) {
    const double shift = position * views.strengthPercent / 100 * depth.cols / 2;
    const int y = std::clamp(at.y, 0, depth.rows - 1);
    // several contents may move to this place, each by its own depth; the nearest hides the others
    double best = -1;
    for (int x = 0; x < depth.cols; ++x) {
        const double d = static_cast<double>(depth.at<float>(y, x));
        if (std::abs(x - shift * (d - views.focus) - at.x) <= 1) best = std::max(best, d);
    }
    return best >= 0 ? best
                     : static_cast<double>(depth.at<float>(y, std::clamp(at.x, 0, depth.cols - 1)));
}

Setup Studio::prepare(const Request& request) {
    Setup setup{request, {}};
    const Document& document = *request.document;
    if (document.splats) state_->lookAtSplats(setup);
    if (document.kind != Kind::Scene) return setup;
    setup.from = state_->depthMaker->choose(request.knobs.depth, document.hasDepth());
    setup.edges = setup.from != kGivenDepth                 ? DepthEdges::Aligned
                  : document.origin == DepthOrigin::Matched ? DepthEdges::Matched
                                                            : DepthEdges::Unknown;
    if (!request.painted.depth.empty()) {
        setup.depth = request.painted.depth;
        setup.depthSource = "painted by hand";
        setup.from += " painted " + std::to_string(request.painted.revision);
        return setup;
    }
    static_cast<PhotoDepth&>(setup) = state_->depth.get(
        {request.document, setup.from}, [&] { return state_->makeDepth(document, setup.from); });
    return setup;
}

Frame Studio::render(const Request& request) {
    Frame frame;
    frame.knobs = request.knobs;
    Setup& setup = frame.setup;
    setup = prepare(request);
    const Kind kind = request.document->kind;
    const double aspect = request.display->aspect();
    if (kind == Kind::Scene) {
        state_->choose(setup);
        const QuiltLayout layout = quiltLayout(setup);
        double low = 0;
        double high = 1;
        cv::minMaxLoc(depthOf(setup), &low, &high);
        for (double* end : {&low, &high})
            *end = std::pow(*end, setup.knobs.depthCurve);
        frame.parallaxPixels =
            adjacentParallax(setup.knobs.views, layout, request.display->panelSize(), {low, high})
                .viewPixels;
        if (!request.document->video)
            frame.hiddenPercent =
                state_->hidden.get(state_->keyOf(setup), [&] { return hiddenPercent(setup); });
    }
    frame.target = request.mode == Mode::Native ? cv::Size() : inside(request.area, aspect);
    const cv::Size size =
        limited(frame.target, request.isDraft ? kMaxDraftPixels : kMaxPreviewPixels);
    switch (request.mode) {
    case Mode::Sway:
    case Mode::Depth: {
        if (setup.document->splats)
            frame.depth = sized(setup.document->depth, size);
        else if (kind == Kind::Scene)
            frame.depth = shownDepth(state_->fittedPreview(setup, size));
        if (request.mode == Mode::Sway) {
            state_->viewOf(setup, request.position, size, frame.picture);
            break;
        }
        cv::Mat grey;
        frame.depth.convertTo(grey, CV_8U, 255);
        cv::cvtColor(grey, frame.picture, cv::COLOR_GRAY2BGR);
        break;
    }
    case Mode::Quilt: {
        const cv::Mat& quilt = state_->quiltOf(setup);
        frame.target = inside(request.area, static_cast<double>(quilt.cols) / quilt.rows);
        frame.picture = sized(quilt, frame.target);
        break;
    }
    case Mode::Native:
        frame.picture = window(state_->nativeOf(setup), request.area, setup.pan);
        frame.target = frame.picture.size();
        break;
    case Mode::Lens: {
        const Calibration& calibration = request.display->calibration;
        const double angle = request.position * viewConeDegrees(calibration) / 2;
        LensEye eye = eyeAtAngle(calibration, angle);
        const double panelPixels = static_cast<double>(calibration.screenW) / size.width;
        if (panelPixels > 1) // the eye averages light; scaling averages codes
            eye.blur = std::min(std::max(eyeBlur(calibration), panelPixels / 2), 64.0);
        cv::Mat seen;
        simulateView(state_->nativeOf(setup), calibration, eye, seen, request.display->invert);
        frame.picture = sized(seen, size);
        break;
    }
    case Mode::Stereo: {
        // half of the sub-pixels under the lenses are those of an eye
        const EyesPicture picture =
            request.throughLens ? EyesPicture::Columns : request.eyes.picture;
        // how often an eye's picture goes into the whole one, across and down
        const cv::Size parts = eyesSize({2, 2}, picture) / 2;
        const cv::Size part(std::max(1, request.area.width / parts.width),
                            std::max(1, request.area.height / parts.height));
        cv::Size eye = inside(part, eyesAspect(setup));
        frame.target = eyesSize(eye, picture);
        // not for interlaced pictures: the window would enlarge their rows, which then fit no eye
        if (!request.fills && !isInterlaced(picture)) eye = limited(eye, kMaxPreviewPixels);
        StereoPair eyes = request.follows ? state_->eyesAround(setup, halved(eye, picture))
                                          : state_->eyesOf(setup, eye);
        const bool isStretched = request.follows && !request.throughLens;
        for (cv::Mat* half : {&eyes.left, &eyes.right})
            if (isStretched) cv::resize(*half, *half, eye, 0, 0, cv::INTER_NEAREST);
        if (request.fills) {
            const cv::Size whole = request.throughLens ? halved(part, picture) : part;
            eyes = {inMiddle(eyes.left, whole), inMiddle(eyes.right, whole), {}};
            frame.target = eyesSize(part, picture);
        }
        if (request.throughLens)
            eyesToNative(eyes.left, eyes.right, *request.display, request.position, frame.picture);
        else
            frame.picture = tools::joinedEyes(eyes, request.eyes);
        break;
    }
    }
    return frame;
}

} // namespace altiro3D::viewer
