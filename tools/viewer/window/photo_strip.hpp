#pragma once

#include "viewer/window/thumbnails.hpp"

#include <QListView>

namespace altiro3D::viewer {

/// The open files as one row of icons, below the picture.
class PhotoStrip : public QListView {
    Q_OBJECT
  public:
    explicit PhotoStrip(QWidget* parent = nullptr);

    void setSources(const std::vector<Source>& sources);
    /// Marks a file and scrolls to it, without emitting a signal. @param index -1: none
    void setCurrent(int index);

  signals:
    /// The user has chosen a file, by mouse or keys.
    void chosen(int index);

  protected:
    void currentChanged(const QModelIndex& current, const QModelIndex& previous) override;

  private:
    Thumbnails* thumbnails_;
    bool updating_ = false;
};

} // namespace altiro3D::viewer
