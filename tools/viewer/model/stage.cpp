#include "viewer/model/stage.hpp"

#include "cli/run_tool.hpp"

#include <algorithm>
#include <climits>
#include <cmath>

namespace altiro3D::viewer {

namespace {

constexpr std::size_t kRendering = 0; // kinds of work
constexpr std::size_t kPresenting = 1;
constexpr int kSwingMilliseconds = 33;
constexpr double kSwingPeriodMilliseconds = 4000;

bool has(const std::vector<Mode>& modes, Mode mode) {
    return std::find(modes.begin(), modes.end(), mode) != modes.end();
}

bool isOfLenses(Mode mode) {
    return mode == Mode::Native || mode == Mode::Lens;
}

} // namespace

Stage::Stage(Files& files, Settings& settings)
    : files_(files), settings_(settings), studio_(files.depthMaker()) {
    swingTimer_.setInterval(kSwingMilliseconds);
    connect(&swingTimer_, &QTimer::timeout, this, &Stage::swing);
    connect(&files, &Files::stateChanged, this, &Stage::stateChanged);
    connect(&files, &Files::opened, this, &Stage::takeDocument);
    connect(&files, &Files::pictureCame, this, &Stage::requestAll);
    connect(&settings, &Settings::knobsChanged, this, &Stage::takeKnobs);
    connect(&settings, &Settings::rested, this, [this] {
        const auto& document = files_.document();
        if (isOfLenses(mode_) || (document && document->splats)) requestFrame();
        requestNative();
    });
}

void Stage::takeDocument() {
    const auto& document = files_.document();
    problem_.clear();
    pan_ = {};
    if (!document) frame_ = {};
    if (document && !has(modesOf(document), mode_)) {
        mode_ = modesOf(document).front();
        emit modeChanged();
    }
    waiting_ = document && !area_.empty();
    emit stateChanged();
    if (!document) emit frameReady();
    requestAll();
}

void Stage::takeKnobs() {
    const auto& document = files_.document();
    if (document && document->kind == Kind::Scene && !area_.empty() &&
        frame_.knobs.depth != settings_.knobs().depth) {
        waiting_ = true; // new depth may take long
        emit stateChanged();
    }
    requestAll();
}

void Stage::findNetworks() {
    files_.depthMaker()->findNetworks();
    waiting_ = files_.document() && !area_.empty();
    emit stateChanged();
    requestAll();
}

void Stage::setMode(Mode mode) {
    const auto& document = files_.document();
    if (mode == mode_ || !has(modesOf(document), mode)) return;
    mode_ = mode;
    pan_ = {};
    emit modeChanged();
    requestFrame();
}

void Stage::setPosition(double position) {
    position_ = std::clamp(position, -1.0, 1.0);
    if (mode_ == Mode::Sway || mode_ == Mode::Lens) requestFrame();
}

void Stage::setSwinging(bool swinging) {
    if (swinging == isSwinging()) return;
    if (swinging) {
        swingClock_.start();
        swingTimer_.start();
    } else {
        swingTimer_.stop();
    }
    emit swingingChanged(swinging);
    if (!swinging) setPosition(0);
}

void Stage::swing() {
    if (!files_.document() || (mode_ != Mode::Sway && mode_ != Mode::Lens)) return;
    const double turns = static_cast<double>(swingClock_.elapsed()) / kSwingPeriodMilliseconds;
    setPosition(std::sin(2 * CV_PI * turns));
}

void Stage::setArea(cv::Size area) {
    if (area == area_) return;
    area_ = area;
    requestFrame();
}

void Stage::panBy(cv::Point by) {
    if (mode_ != Mode::Native) return;
    pan_ += by;
    requestFrame();
}

void Stage::setPresenting(bool presenting, cv::Size eyesScreen) {
    presenting_ = presenting;
    eyesScreen_ = eyesScreen;
    requestNative();
}

void Stage::setEyes(const tools::EyesOptions& eyes) {
    eyes_ = eyes;
    emit eyesChanged();
    if (mode_ == Mode::Stereo) requestFrame();
    if (!eyesScreen_.empty()) requestNative();
}

std::optional<Request> Stage::requestOf(Mode mode, cv::Size area) const {
    // no frames of the previous file while another one is read: they would be taken for frames of
    // the new file
    const auto& document = files_.document();
    if (files_.isReading() || !document || area.empty() || !has(modesOf(document), mode))
        return std::nullopt;
    Request request{document, settings_.knobs(), files_.display(), painted(), eyes_, mode};
    request.area = area;
    request.isDraft = (settings_.areMoving() && (isOfLenses(mode) || document->splats)) ||
                      (canvas_ && canvas_->isPainting());
    return request;
}

void Stage::requestFrame() {
    auto request = requestOf(mode_, area_);
    if (!request) return;
    request->position = position_;
    request->pan = pan_;
    worker_.post(kRendering, [this, request = *request, number = files_.readings()] {
        Frame frame;
        QString problem;
        try {
            frame = studio_.render(request);
        } catch (const std::exception& error) {
            problem = QString::fromStdString(tools::sentenceOf(error));
            static_cast<Request&>(frame.setup) = request;
            frame.knobs = request.knobs;
        }
        later(this, [this, frame, problem, number] {
            if (number == files_.readings()) takeFrame(frame, problem);
        });
    });
}

void Stage::takeFrame(const Frame& frame, const QString& problem) {
    frameReading_ = files_.readings();
    const bool changed = waiting_ || problem != problem_;
    waiting_ = frame.knobs.depth != settings_.knobs().depth;
    problem_ = problem;
    frame_ = frame;
    if (frame.setup.mode == Mode::Native && mode_ == Mode::Native) pan_ = frame.setup.pan;
    emit frameReady();
    files_.noteShown(frame.setup.document);
    if (changed) emit stateChanged();
}

void Stage::requestNative() {
    if (!presenting_) return;
    const bool areEyes = !eyesScreen_.empty();
    auto request = areEyes ? requestOf(Mode::Stereo, eyesScreen_)
                           : requestOf(Mode::Native, {INT_MAX, INT_MAX});
    if (!request) return;
    request->fills = areEyes;
    worker_.post(kPresenting, [this, request = *request] {
        cv::Mat native;
        try {
            native = studio_.render(request).picture;
        } catch (const std::exception&) {
            return; // the picture in the window says why
        }
        later(this, [this, native, document = request.document] {
            if (presenting_ && document == files_.document()) emit nativeReady(native);
        });
    });
}

void Stage::requestAll() {
    requestFrame();
    requestNative();
}

void Stage::focusAt(double x, double y) {
    const cv::Mat& depth = frame_.depth;
    if (depth.empty() || !isShown()) return;
    const cv::Point at(static_cast<int>(x * depth.cols), static_cast<int>(y * depth.rows));
    Knobs knobs = settings_.knobs();
    const double position = frame_.setup.mode == Mode::Sway ? frame_.setup.position : 0;
    const double seen = depthSeenAt(depth, frame_.setup.knobs.views, position, at);
    knobs.views.focus = std::round(seen * 100) / 100; // as the knob has it
    knobs.choices.focus = false;
    settings_.turn(knobs, tr("focus"));
}

bool Stage::canFrame() const {
    const Setup& shown = frame_.setup;
    return files_.document() && isShown() && !frame_.picture.empty() &&
           (files_.document()->kind == Kind::Scene || files_.document()->splats) &&
           (shown.mode == Mode::Sway || shown.mode == Mode::Depth || shown.mode == Mode::Lens);
}

void Stage::changeFrame(const QString& what, int gesture,
                        const std::function<Framing(const Framing&, const FramedPhoto&)>& change) {
    if (!canFrame()) return;
    Knobs knobs = settings_.knobs();
    // from the frame that is shown, which the user moves from now on
    if (knobs.choices.framing) knobs.framing = frame_.setup.knobs.framing;
    knobs.choices.framing = false;
    knobs.isFramingChosen = false;
    knobs.framing = change(
        knobs.framing, {files_.document()->picture.size(), files_.display()->aspect(), knobs.fit});
    settings_.turn(knobs, what, gesture);
}

void Stage::moveFrame(cv::Point2d by, int gesture) {
    if (files_.document() && files_.document()->splats)
        return changeFrame(tr("camera"), gesture, [by](Framing framing, const FramedPhoto&) {
            constexpr double kWidthsPerTurn = 2; // the mouse moves so far for a whole turn
            const double x = framing.centre.x - by.x / kWidthsPerTurn;
            framing.centre.x = x - std::floor(x);
            framing.centre.y = std::clamp(framing.centre.y + by.y / kWidthsPerTurn, 0.0, 1.0);
            return framing;
        });
    changeFrame(tr("frame"), gesture, [by](const Framing& framing, const FramedPhoto& photo) {
        return moved(framing, photo, by);
    });
}

void Stage::zoomFrame(cv::Point2d at, double factor, int gesture) {
    if (files_.document() && files_.document()->splats)
        return changeFrame(tr("zoom"), gesture, [factor](Framing framing, const FramedPhoto&) {
            framing.zoom = std::clamp(framing.zoom * factor, 1.0, kMaxZoom);
            return framing;
        });
    changeFrame(tr("zoom"), gesture,
                [at, factor](const Framing& framing, const FramedPhoto& photo) {
                    return zoomed(framing, photo, at, factor);
                });
}

void Stage::resetFrame() {
    Knobs knobs = settings_.knobs();
    knobs.framing = {};
    knobs.choices.framing = false;
    settings_.turn(knobs, tr("frame"));
}

} // namespace altiro3D::viewer
