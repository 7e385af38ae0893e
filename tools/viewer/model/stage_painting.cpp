// Strokes that change the depth of the photo that is shown; with undo.

#include "altiro3D/enum_table.hpp"
#include "viewer/model/stage.hpp"

#include <algorithm>
#include <utility>

namespace altiro3D::viewer {

namespace {

quint64 nextRevision() {
    static quint64 last = 0;
    return ++last;
}

QString nameOf(PaintTool tool) {
    constexpr const char* kNames[] = {"brush: nearer", "brush: farther", "brush: smooth",
                                      "brush: copy", "lasso"}; // as PaintTool
    return Stage::tr(entryOf(kNames, tool));
}

} // namespace

Stage::PaintKey Stage::paintKey() const {
    const auto& document = files_.document();
    if (!document || document->kind != Kind::Scene) return {};
    const Source& source = document->source;
    return {source.file, source.depth, source.reading,
            files_.depthMaker()->choose(settings_.knobs().depth, document->hasDepth())};
}

PaintedDepth Stage::painted() const {
    const auto found = painted_.find(paintKey());
    return found != painted_.end() ? found->second.depth : PaintedDepth();
}

std::map<std::string, PaintedDepth> Stage::painted(const Source& source) const {
    std::map<std::string, PaintedDepth> result;
    for (const auto& [key, painted] : painted_) {
        const auto& [file, depth, reading, from] = key;
        if (std::tie(file, depth, reading) == std::tie(source.file, source.depth, source.reading))
            result[from] = painted.depth;
    }
    return result;
}

std::vector<std::filesystem::path> Stage::unsavedDepths() const {
    std::vector<std::filesystem::path> files;
    for (const auto& [key, painted] : painted_) {
        if (!painted.isSaved) files.push_back(std::get<0>(key));
    }
    return files;
}

void Stage::setSaved(quint64 revision) {
    for (auto& [key, painted] : painted_)
        if (painted.depth.revision == revision) painted.isSaved = true;
}

bool Stage::canPaint() const {
    const Setup& shown = frame_.setup;
    return canFrame() && !files_.document()->video && shown.document == files_.document() &&
           frame_.knobs.depth == settings_.knobs().depth && shown.position == 0 &&
           (shown.mode == Mode::Sway || shown.mode == Mode::Depth);
}

PhotoFit Stage::shownFit() const {
    const Setup& setup = frame_.setup;
    return fitPhoto(setup.document->picture.size(), setup.display->aspect(), frame_.picture.size(),
                    setup.knobs.fit, framingOf(setup));
}

cv::Point2d Stage::inPhoto(cv::Point2d at) const {
    const PhotoFit fit = shownFit();
    const cv::Size photo = frame_.setup.document->picture.size();
    const double x = (at.x * fit.size.width - fit.target.x) / fit.target.width;
    const double y = (at.y * fit.size.height - fit.target.y) / fit.target.height;
    return {(fit.source.x + x * fit.source.width) / photo.width,
            (fit.source.y + y * fit.source.height) / photo.height};
}

double Stage::brushRadius(double radius) const {
    if (!canFrame()) return 0;
    const PhotoFit fit = shownFit();
    const cv::Size photo = frame_.setup.document->picture.size();
    return radius * std::max(photo.width, photo.height) * fit.target.width / fit.source.width /
           fit.size.width;
}

void Stage::useCanvas(const PaintKey& key, const cv::Mat& depth) {
    canvas_ = std::make_unique<DepthCanvas>(files_.document()->picture, depth);
    canvasKey_ = key;
}

bool Stage::beginStroke(const Paint& paint, cv::Point2d at) {
    if (!canPaint()) return false;
    const PaintKey key = paintKey();
    if (!canvas_ || canvasKey_ != key) {
        // the frame has the depth to begin with
        if (frame_.setup.painted.revision != painted().revision) return false;
        if (settings_.knobs().choices.any()) { // strokes must not move the picture
            if (frame_.knobs != settings_.knobs()) return false;
            settings_.set(frame_.setup.knobs);
        }
        useCanvas(key, depthOf(frame_.setup));
    }
    canvas_->begin(paint, inPhoto(at));
    if (paint.tool != PaintTool::Lasso) showCanvas(0);
    return true;
}

void Stage::continueStroke(cv::Point2d at) {
    if (!canvas_ || !canvas_->isPainting() || frame_.picture.empty()) return;
    if (canvas_->moveTo(inPhoto(at))) showCanvas(0);
}

void Stage::endStroke() {
    if (!canvas_ || !canvas_->isPainting()) return;
    const PaintedPart part = canvas_->end();
    if (part.place.empty()) return;
    showCanvas(1);
    requestNative();
    // it is on the canvas already when it is pushed
    const auto put = [this, key = canvasKey_, place = part.place](const cv::Mat& to, int strokes) {
        putPart(key, place, to, strokes);
    };
    settings_.push(
        nameOf(canvas_->tool()), [put, before = part.before] { put(before, -1); },
        [put, after = part.after, isNew = true]() mutable {
            if (!std::exchange(isNew, false)) put(after, 1);
        });
}

void Stage::showCanvas(int strokes) {
    Painted& painted = painted_[canvasKey_];
    painted.depth = {canvas_->depth().clone(), nextRevision()}; // the worker reads the copy
    painted.strokes += strokes;
    painted.isSaved = false;
    requestFrame();
}

void Stage::putPart(const PaintKey& key, const cv::Rect& place, const cv::Mat& part, int strokes) {
    endStroke();
    if (key != paintKey()) return; // the photo was opened anew in another way
    if (!canvas_ || canvasKey_ != key) useCanvas(key, painted().depth);
    canvas_->put(place, part);
    showCanvas(strokes);
    // without a stroke left, the depth is as it came; the canvas keeps it for the next stroke
    if (painted_[key].strokes <= 0) painted_.erase(key);
    requestAll();
}

void Stage::setPainted(const PaintKey& key, const Painted& painted) {
    canvas_.reset();
    if (painted.depth.depth.empty())
        painted_.erase(key);
    else
        painted_[key] = painted;
    requestAll();
}

void Stage::unpaint() {
    endStroke();
    const PaintKey key = paintKey();
    const auto found = painted_.find(key);
    if (found == painted_.end()) return;
    settings_.push(
        tr("discard of painted depth"),
        [this, key, painted = found->second] { setPainted(key, painted); },
        [this, key] { setPainted(key, {}); });
}

} // namespace altiro3D::viewer
