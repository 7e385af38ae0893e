// What the user changes: the settings of the open files, and depth by painting; with undo.

#include "altiro3D/enum_table.hpp"
#include "viewer/model/controller.hpp"
#include "viewer/model/depth_maker.hpp"

#include <QUndoCommand>
#include <cmath>
#include <utility>

namespace altiro3D::viewer {

namespace {

Knobs standardKnobsOf(const std::filesystem::path& file, const Knobs& knobs) {
    return isVideoName(file) ? ofVideo(knobs) : knobs;
}

quint64 nextRevision() {
    static quint64 last = 0;
    return ++last;
}

QString nameOf(PaintTool tool) {
    constexpr const char* kNames[] = {"brush: nearer", "brush: farther", "brush: smooth",
                                      "brush: copy", "lasso"}; // as PaintTool
    return Controller::tr(entryOf(kNames, tool));
}

// A change that can be undone; those of one gesture are one.
class Step : public QUndoCommand {
  public:
    Step(const QString& what, std::function<void()> undo, std::function<void()> redo,
         int gesture = 0)
        : QUndoCommand(what), undo_(std::move(undo)), redo_(std::move(redo)), gesture_(gesture) {}

    void undo() override { undo_(); }
    void redo() override { redo_(); }
    int id() const override { return gesture_ > 0 ? gesture_ : -1; }
    bool mergeWith(const QUndoCommand* other) override {
        redo_ = static_cast<const Step*>(other)->redo_;
        return true;
    }

  private:
    std::function<void()> undo_;
    std::function<void()> redo_;
    int gesture_;
};

} // namespace

void Controller::turn(const Knobs& knobs, const QString& what, int gesture) {
    if (knobs == knobs_) return;
    if (gesture != 0) restTimer_.start();
    undoStack_.push(new Step(
        what, [this, before = knobs_] { setKnobs(before); }, [this, knobs] { setKnobs(knobs); },
        gesture));
}

void Controller::resetKnobs() {
    turn(standardKnobsOf(knobsFile_, Knobs()), tr("reset of all settings"));
}

void Controller::restoreKnobs(const Knobs& knobs) {
    standardKnobs_ = knobs;
    showKnobs(knobs);
}

void Controller::copyKnobsToAll() {
    standardKnobs_ = knobs_;
    standardKnobs_.framing = {};
    standardKnobs_.isFramingChosen = false;
    for (const Source& source : sources_) {
        Knobs knobs = knobs_;
        const Knobs own = knobsOf(source.file);
        knobs.framing = own.framing;
        knobs.isFramingChosen = own.isFramingChosen;
        store_.set(source.file, knobs);
    }
    storeTimer_.start();
}

Knobs Controller::knobsOf(const std::filesystem::path& file) const {
    if (file == knobsFile_) return knobs_;
    return store_.find(file).value_or(standardKnobsOf(file, standardKnobs_));
}

void Controller::changeKnobs() {
    const std::filesystem::path file =
        current_ >= 0 ? sources_[static_cast<std::size_t>(current_)].file : std::filesystem::path();
    if (file == knobsFile_) return;
    undoStack_.clear(); // its steps belong to the previous file
    const Knobs knobs = file.empty() ? standardKnobs_ : knobsOf(file);
    knobsFile_ = file;
    showKnobs(knobs);
}

void Controller::setKnobs(const Knobs& knobs) {
    if (knobsFile_.empty())
        standardKnobs_ = knobs;
    else
        store_.set(knobsFile_, knobs);
    storeTimer_.start();
    showKnobs(knobs);
}

void Controller::showKnobs(const Knobs& knobs) {
    if (knobs == knobs_) return;
    const bool depthTurned = knobs.depth != knobs_.depth;
    if (depthTurned && document_ && document_->kind == Kind::Scene) {
        waiting_ = true; // new depth may take long
        emit documentChanged();
    }
    knobs_ = knobs;
    {
        const std::lock_guard<std::mutex> lock(wishMutex_);
        depthWish_ = knobs.depth;
    }
    emit knobsChanged();
    if (depthTurned && !playerProblem_.isEmpty() && !opening_) {
        readCurrent(); // the video may have stopped because the previous depth failed
        return;
    }
    requestFrame();
    requestNative();
}

void Controller::focusAt(double x, double y) {
    const cv::Mat& depth = frame_.depth;
    if (depth.empty() || frameReading_ != readings_) return;
    const cv::Point at(static_cast<int>(x * depth.cols), static_cast<int>(y * depth.rows));
    Knobs knobs = knobs_;
    const double position = frame_.setup.mode == Mode::Sway ? frame_.setup.position : 0;
    const double seen = depthSeenAt(depth, frame_.setup.knobs.views, position, at);
    knobs.views.focus = std::round(seen * 100) / 100; // as the knob has it
    knobs.choices.focus = false;
    turn(knobs, tr("focus"));
}

bool Controller::canFrame() const {
    const Setup& shown = frame_.setup;
    return document_ && frameReading_ == readings_ && !frame_.picture.empty() &&
           document_->kind == Kind::Scene &&
           (shown.mode == Mode::Sway || shown.mode == Mode::Depth || shown.mode == Mode::Lens);
}

FramedPhoto Controller::framedPhoto() const {
    return {document_->picture.size(), display_->aspect(), knobs_.fit};
}

Knobs Controller::withFrame() const {
    Knobs knobs = knobs_;
    if (knobs.choices.framing) knobs.framing = frame_.setup.knobs.framing;
    knobs.choices.framing = false;
    knobs.isFramingChosen = false;
    return knobs;
}

void Controller::moveFrame(cv::Point2d by, int gesture) {
    if (!canFrame()) return;
    Knobs knobs = withFrame();
    knobs.framing = moved(knobs.framing, framedPhoto(), by);
    turn(knobs, tr("frame"), gesture);
}

void Controller::zoomFrame(cv::Point2d at, double factor, int gesture) {
    if (!canFrame()) return;
    Knobs knobs = withFrame();
    knobs.framing = zoomed(knobs.framing, framedPhoto(), at, factor);
    turn(knobs, tr("zoom"), gesture);
}

void Controller::resetFrame() {
    Knobs knobs = knobs_;
    knobs.framing = {};
    knobs.choices.framing = false;
    turn(knobs, tr("frame"));
}

Controller::PaintKey Controller::paintKey() const {
    if (!document_ || document_->kind != Kind::Scene) return {};
    const Source& source = document_->source;
    return {source.file, source.depth, static_cast<int>(source.reading),
            depthMaker_->choose(knobs_.depth, document_->hasDepth())};
}

PaintedDepth Controller::paintedNow() const {
    const auto found = painted_.find(paintKey());
    return found != painted_.end() ? found->second.depth : PaintedDepth();
}

std::vector<std::filesystem::path> Controller::unsavedDepths() const {
    std::vector<std::filesystem::path> files;
    for (const auto& [key, painted] : painted_) {
        if (!painted.isSaved) files.push_back(std::get<0>(key));
    }
    return files;
}

bool Controller::canPaint() const {
    const Setup& shown = frame_.setup;
    return canFrame() && !document_->video && shown.document == document_ &&
           frame_.knobs.depth == knobs_.depth && shown.position == 0 &&
           (shown.mode == Mode::Sway || shown.mode == Mode::Depth);
}

PhotoFit Controller::shownFit() const {
    const Setup& setup = frame_.setup;
    return fitPhoto(setup.document->picture.size(), setup.display->aspect(), frame_.picture.size(),
                    setup.knobs.fit, framingOf(setup));
}

cv::Point2d Controller::inPhoto(cv::Point2d at) const {
    const PhotoFit fit = shownFit();
    const cv::Size photo = frame_.setup.document->picture.size();
    const double x = (at.x * fit.size.width - fit.target.x) / fit.target.width;
    const double y = (at.y * fit.size.height - fit.target.y) / fit.target.height;
    return {(fit.source.x + x * fit.source.width) / photo.width,
            (fit.source.y + y * fit.source.height) / photo.height};
}

double Controller::brushRadius(double radius) const {
    if (!canFrame()) return 0;
    const PhotoFit fit = shownFit();
    const cv::Size photo = frame_.setup.document->picture.size();
    return radius * std::max(photo.width, photo.height) * fit.target.width / fit.source.width /
           fit.size.width;
}

bool Controller::beginStroke(const Paint& paint, cv::Point2d at) {
    if (!canPaint()) return false;
    const PaintKey key = paintKey();
    if (!canvas_ || canvasKey_ != key) {
        // the frame has the depth to begin with
        const bool isAutomatic = knobs_.choices.any();
        if (frame_.setup.painted.revision != paintedNow().revision ||
            (isAutomatic && frame_.knobs != knobs_))
            return false;
        canvas_ = std::make_unique<DepthCanvas>(document_->picture, depthOf(frame_.setup));
        canvasKey_ = key;
        if (isAutomatic) setKnobs(frame_.setup.knobs); // strokes must not move the picture
    }
    tool_ = paint.tool;
    canvas_->begin(paint, inPhoto(at));
    if (paint.tool != PaintTool::Lasso) showCanvas(0);
    return true;
}

void Controller::continueStroke(cv::Point2d at) {
    if (!canvas_ || !canvas_->isPainting() || frame_.picture.empty()) return;
    if (canvas_->moveTo(inPhoto(at))) showCanvas(0);
}

void Controller::endStroke() {
    if (!canvas_ || !canvas_->isPainting()) return;
    const PaintedPart part = canvas_->end();
    if (part.place.empty()) return;
    showCanvas(1);
    requestNative();
    // it is on the canvas already when it is pushed
    const auto put = [this, key = canvasKey_, place = part.place](const cv::Mat& to, int strokes) {
        putPart(key, place, to, strokes);
    };
    undoStack_.push(new Step(
        nameOf(tool_), [put, before = part.before] { put(before, -1); },
        [put, after = part.after, isNew = true]() mutable {
            if (!std::exchange(isNew, false)) put(after, 1);
        }));
}

void Controller::showCanvas(int strokes) {
    Painted& painted = painted_[canvasKey_];
    painted.depth = {canvas_->depth().clone(), nextRevision()}; // the worker reads the copy
    painted.strokes += strokes;
    painted.isSaved = false;
    requestFrame();
}

void Controller::putPart(const PaintKey& key, const cv::Rect& place, const cv::Mat& part,
                         int strokes) {
    endStroke();
    if (key != paintKey()) return; // the photo was opened anew in another way
    if (!canvas_ || canvasKey_ != key) {
        canvas_ = std::make_unique<DepthCanvas>(document_->picture, paintedNow().depth);
        canvasKey_ = key;
    }
    canvas_->put(place, part);
    showCanvas(strokes);
    if (painted_[key].strokes > 0) return requestNative();
    painted_.erase(key); // the depth as it came, which the canvas keeps for other strokes
    requestFrame();
    requestNative();
}

void Controller::setPainted(const PaintKey& key, const Painted& painted) {
    canvas_.reset();
    if (painted.depth.depth.empty())
        painted_.erase(key);
    else
        painted_[key] = painted;
    requestFrame();
    requestNative();
}

void Controller::setSaved(quint64 revision) {
    for (auto& [key, painted] : painted_)
        if (painted.depth.revision == revision) painted.isSaved = true;
}

void Controller::unpaint() {
    endStroke();
    if (!isPainted()) return;
    const PaintKey key = paintKey();
    undoStack_.push(new Step(
        tr("discard of painted depth"),
        [this, key, painted = painted_[key]] { setPainted(key, painted); },
        [this, key] { setPainted(key, {}); }));
}

} // namespace altiro3D::viewer
