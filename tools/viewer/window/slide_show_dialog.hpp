#pragma once

#include "viewer/show/slide_show.hpp"

#include <QDialog>

class QCheckBox;
class QDoubleSpinBox;
class QLabel;
class QRadioButton;

namespace altiro3D::viewer {

/// Asks what a slide show shows, and how; the answers are those of the next time.
class SlideShowDialog : public QDialog {
    Q_OBJECT
  public:
    /// @param openFiles number of them
    SlideShowDialog(std::size_t openFiles, QWidget* parent);

    /// The folder to show; empty: the open files.
    QString folder() const;
    SlideShow::Settings settings() const;

    void accept() override;

  private:
    void chooseFolder();
    void showFolder(const QString& folder);

    QRadioButton* ofFolder_;
    QLabel* name_;
    QString folder_;
    QDoubleSpinBox* each_;
    QCheckBox* shuffles_;
    QCheckBox* loops_;
};

} // namespace altiro3D::viewer
