// The settings of the open files: changes, undo, and what is kept of them.

#include "viewer/model/controller.hpp"

#include <QUndoCommand>
#include <cmath>

namespace altiro3D::viewer {

namespace {

Knobs standardKnobsOf(const std::filesystem::path& file, const Knobs& knobs) {
    return isVideoName(file) ? ofVideo(knobs) : knobs;
}

} // namespace

// A change of settings that can be undone.
class Controller::Turn : public QUndoCommand {
  public:
    Turn(Controller& controller, Knobs before, Knobs after, const QString& what, int gesture)
        : QUndoCommand(what), controller_(controller), before_(std::move(before)),
          after_(std::move(after)), gesture_(gesture) {}

    void undo() override { controller_.setKnobs(before_); }
    void redo() override { controller_.setKnobs(after_); }
    int id() const override { return gesture_ > 0 ? gesture_ : -1; }
    bool mergeWith(const QUndoCommand* other) override {
        after_ = static_cast<const Turn*>(other)->after_;
        return true;
    }

  private:
    Controller& controller_;
    Knobs before_;
    Knobs after_;
    int gesture_;
};

void Controller::turn(const Knobs& knobs, const QString& what, int gesture) {
    if (knobs == knobs_) return;
    if (gesture != 0) restTimer_.start();
    undoStack_.push(new Turn(*this, knobs_, knobs, what, gesture));
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
        const std::lock_guard<std::mutex> lock(arrivalMutex_);
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
    const double position = frame_.request.mode == Mode::Sway ? frame_.request.position : 0;
    const double seen = depthSeenAt(depth, frame_.setup.knobs.views, position, at);
    knobs.views.focus = std::round(seen * 100) / 100; // as the knob has it
    knobs.automatic.focus = false;
    turn(knobs, tr("focus"));
}

bool Controller::canFrame() const {
    const Request& shown = frame_.request;
    return document_ && frameReading_ == readings_ && !frame_.picture.empty() &&
           document_->kind == Kind::Scene &&
           (shown.mode == Mode::Sway || shown.mode == Mode::Depth || shown.mode == Mode::Lens);
}

FramedPhoto Controller::framedPhoto() const {
    return {document_->picture.size(), display_->aspect(), knobs_.fit};
}

Knobs Controller::withFrame() const {
    Knobs knobs = knobs_;
    if (knobs.automatic.framing) knobs.framing = frame_.setup.knobs.framing;
    knobs.automatic.framing = false;
    knobs.isFramingChosen = false;
    return knobs;
}

Knobs Controller::withChosen() const {
    const AutoChoices choices = knobs_.automatic;
    const ViewOptions& chosen = frame_.setup.knobs.views;
    Knobs knobs = withFrame();
    knobs.isFramingChosen = choices.framing || knobs_.isFramingChosen;
    if (choices.focus) knobs.views.focus = chosen.focus;
    if (choices.strength || choices.limit) knobs.views.strengthPercent = chosen.strengthPercent;
    knobs.automatic = {};
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
    knobs.automatic.framing = false;
    turn(knobs, tr("frame"));
}

} // namespace altiro3D::viewer
