// Depth that the user paints: strokes, undo, and what is not saved of it.

#include "viewer/model/controller.hpp"

#include "viewer/model/depth_maker.hpp"

#include <QUndoCommand>
#include <utility>

namespace altiro3D::viewer {

namespace {

quint64 nextRevision() {
    static quint64 last = 0;
    return ++last;
}

QString nameOf(PaintTool tool) {
    switch (tool) {
    case PaintTool::Nearer:
        return Controller::tr("brush: nearer");
    case PaintTool::Farther:
        return Controller::tr("brush: farther");
    case PaintTool::Smooth:
        return Controller::tr("brush: smooth");
    case PaintTool::Copy:
        return Controller::tr("brush: copy");
    case PaintTool::Lasso:
        break;
    }
    return Controller::tr("lasso");
}

} // namespace

// A stroke that can be undone. It is on the canvas already when it is pushed.
class Controller::Stroke : public QUndoCommand {
  public:
    Stroke(Controller& controller, PaintedPart part, const QString& what)
        : QUndoCommand(what), controller_(controller), key_(controller.canvasKey_),
          part_(std::move(part)) {}

    void undo() override { controller_.putPart(key_, part_.place, part_.before, -1); }
    void redo() override {
        if (std::exchange(isNew_, false)) return;
        controller_.putPart(key_, part_.place, part_.after, 1);
    }

  private:
    Controller& controller_;
    PaintKey key_;
    PaintedPart part_;
    bool isNew_ = true;
};

// All strokes of a photo, thrown away.
class Controller::Unpaint : public QUndoCommand {
  public:
    Unpaint(Controller& controller, const QString& what)
        : QUndoCommand(what), controller_(controller), key_(controller.paintKey()),
          painted_(controller.painted_[key_]) {}

    void undo() override { controller_.setPainted(key_, painted_); }
    void redo() override { controller_.setPainted(key_, {}); }

  private:
    Controller& controller_;
    PaintKey key_;
    Painted painted_;
};

Controller::PaintKey Controller::paintKey() const {
    if (!document_ || document_->kind != Kind::Scene) return {};
    const Source& source = document_->source;
    return {source.file, source.depth, static_cast<int>(source.reading),
            depthMaker_->choose(knobs_.depth, !document_->rawDepth.empty())};
}

PaintedDepth Controller::paintedNow() const {
    const auto found = painted_.find(paintKey());
    return found != painted_.end() ? found->second.depth : PaintedDepth();
}

bool Controller::isPainted() const {
    return !paintedNow().depth.empty();
}

std::vector<std::filesystem::path> Controller::unsavedDepths() const {
    std::vector<std::filesystem::path> files;
    for (const auto& [key, painted] : painted_) {
        if (!painted.isSaved) files.push_back(std::get<0>(key));
    }
    return files;
}

bool Controller::canPaint() const {
    const Request& shown = frame_.request;
    return canFrame() && !document_->video && shown.document == document_ &&
           shown.knobs.depth == knobs_.depth && shown.position == 0 &&
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
        if (frame_.request.painted.revision != paintedNow().revision) return false;
        canvas_ = std::make_unique<DepthCanvas>(document_->picture, frame_.setup.depth);
        canvasKey_ = key;
        if (knobs_.automatic.any()) setKnobs(withChosen()); // strokes must not move the picture
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
    PaintedPart part = canvas_->end();
    if (part.place.empty()) return;
    showCanvas(1);
    requestNative();
    undoStack_.push(new Stroke(*this, std::move(part), nameOf(tool_)));
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
    if (isPainted()) undoStack_.push(new Unpaint(*this, tr("discard of painted depth")));
}

} // namespace altiro3D::viewer
