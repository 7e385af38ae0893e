#include "viewer/model/settings.hpp"

#include <QUndoCommand>
#include <utility>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

constexpr int kRestMilliseconds = 200;
constexpr int kStoreMilliseconds = 2000; // a crash loses the settings of this time

Knobs standardOf(const fs::path& file, const Knobs& knobs) {
    return isVideoName(file) ? ofVideo(knobs) : knobs;
}

// A change that can be undone; those of one gesture are one.
class Step : public QUndoCommand {
  public:
    Step(const QString& what, std::function<void()> undo, std::function<void()> redo, int gesture)
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

Settings::Settings() {
    restTimer_.setSingleShot(true);
    restTimer_.setInterval(kRestMilliseconds);
    connect(&restTimer_, &QTimer::timeout, this, &Settings::rested);
    storeTimer_.setSingleShot(true);
    storeTimer_.setInterval(kStoreMilliseconds);
    connect(&storeTimer_, &QTimer::timeout, this, [this] { store_.save(); });
}

Settings::~Settings() {
    store_.save();
}

void Settings::push(const QString& what, std::function<void()> undo, std::function<void()> redo,
                    int gesture) {
    undoStack_.push(new Step(what, std::move(undo), std::move(redo), gesture));
}

void Settings::turn(const Knobs& knobs, const QString& what, int gesture) {
    if (knobs == knobs_) return;
    if (gesture != 0) restTimer_.start();
    push(
        what, [this, before = knobs_] { set(before); }, [this, knobs] { set(knobs); }, gesture);
}

void Settings::reset() {
    turn(standardOf(file_, Knobs()), tr("reset of all settings"));
}

void Settings::restore(const Knobs& knobs) {
    standardKnobs_ = knobs;
    show(knobs);
}

void Settings::copyTo(const std::vector<Source>& files) {
    const auto withFrame = [this](const Knobs& frame) {
        Knobs knobs = knobs_;
        knobs.framing = frame.framing;
        knobs.isFramingChosen = frame.isFramingChosen;
        return knobs;
    };
    standardKnobs_ = withFrame(Knobs());
    for (const Source& source : files)
        store_.set(source.file, withFrame(knobsOf(source.file)));
    storeTimer_.start();
}

Knobs Settings::knobsOf(const fs::path& file) const {
    if (file == file_) return knobs_;
    return store_.find(file).value_or(standardOf(file, standardKnobs_));
}

void Settings::use(const fs::path& file) {
    if (file == file_) return;
    undoStack_.clear(); // its steps belong to the previous file
    const Knobs knobs = file.empty() ? standardKnobs_ : knobsOf(file);
    file_ = file;
    show(knobs);
}

void Settings::set(const Knobs& knobs) {
    if (file_.empty())
        standardKnobs_ = knobs;
    else
        store_.set(file_, knobs);
    storeTimer_.start();
    show(knobs);
}

void Settings::show(const Knobs& knobs) {
    if (knobs == knobs_) return;
    knobs_ = knobs;
    emit knobsChanged();
}

} // namespace altiro3D::viewer
