#pragma once

#include "viewer/model/document.hpp"
#include "viewer/model/knobs.hpp"

#include <QObject>
#include <QTimer>
#include <QUndoStack>
#include <functional>

namespace altiro3D::viewer {

/// The settings of the files, kept from run to run, and what of them can be undone.
class Settings : public QObject {
    Q_OBJECT
  public:
    Settings();
    ~Settings() override;

    /// The settings of the current file: those that the user made for it, in this run or an earlier
    /// one, else standardKnobs().
    const Knobs& knobs() const { return knobs_; }
    /// The settings of files without their own.
    const Knobs& standardKnobs() const { return standardKnobs_; }
    Knobs knobsOf(const std::filesystem::path& file) const;
    /// Why settings are not kept from run to run, one sentence; empty if they are.
    const std::string& storeNote() const { return store_.note(); }
    /// True for a moment after a setting has moved: what takes long may be a draft.
    bool areMoving() const { return restTimer_.isActive(); }

    /// Makes a file the current one, so that the undo of another one ends. @param file empty: none
    void use(const std::filesystem::path& file);
    /// Changes settings; the user can undo it until another file is opened.
    /// @param what name of the setting, for the undo menu
    /// @param gesture consecutive changes with the same number (not 0) are undone together
    void turn(const Knobs& knobs, const QString& what, int gesture = 0);
    /// As turn(), without undo.
    void set(const Knobs& knobs);
    void reset(); ///< As turn(), to the defaults.
    /// Sets standardKnobs(), and the current settings; this cannot be undone.
    void restore(const Knobs& knobs);
    /// Gives the current settings to files, and to those that are opened later and have none of
    /// their own. Each keeps its frame.
    void copyTo(const std::vector<Source>& files);

    QUndoStack& undoStack() { return undoStack_; }
    /// Calls `redo` and lets the user undo it. @param gesture as for turn()
    void push(const QString& what, std::function<void()> undo, std::function<void()> redo,
              int gesture = 0);

  signals:
    void knobsChanged();
    /// areMoving() is false again.
    void rested();

  private:
    void show(const Knobs& knobs);

    Knobs knobs_;
    Knobs standardKnobs_;
    std::filesystem::path file_; // the file that knobs_ belongs to; empty: none
    KnobStore store_{KnobStore::standardFile()};
    QTimer storeTimer_;
    QTimer restTimer_;
    QUndoStack undoStack_;
};

} // namespace altiro3D::viewer
