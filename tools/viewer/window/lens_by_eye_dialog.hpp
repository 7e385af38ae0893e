#pragma once

#include "altiro3D/qt/native_widget.hpp"
#include "viewer/model/lens_by_eye.hpp"

#include <QDialog>
#include <QTimer>
#include <array>
#include <filesystem>
#include <functional>

class QComboBox;
class QGridLayout;
class QLabel;
class QScreen;
class QSpinBox;

namespace altiro3D::viewer {

class NumberBox;

/// The panel of "Lens by eye": knobs for the numbers of a lens, and what to look for. The test
/// picture fills a screen as long as the dialog is shown.
class LensByEyeDialog : public QDialog {
    Q_OBJECT
  public:
    /// @param display where to begin, if it is for a screen of that size
    /// @param screen of the lens @throws Error as LensByEye
    LensByEyeDialog(const Display& display, QScreen& screen, QWidget* parent);

    /// Places the panel at the right of a screen, above the picture if that is there.
    void standOn(const QScreen& screen);

    const qt::NativeWidget& picture() const { return picture_; }

  signals:
    /// The calibration was written.
    void saved(const Calibration& calibration, const std::filesystem::path& file);

  protected:
    bool eventFilter(QObject* object, QEvent* event) override;

  private:
    QWidget* buildBeginning(double width);
    QWidget* buildKnobs();
    void addKnob(QGridLayout& grid, LensKnob knob);
    QWidget* buildButtons();
    /// Changes the numbers, shows them, or says why they cannot be so.
    void change(const std::function<void()>& what);
    void show(LensKnob knob);
    void showNumbers();
    void paste();
    void save();

    cv::Size panel_; // px of the screen
    LensByEye lens_;
    qt::NativeWidget picture_;
    QTimer redraw_;                       // several steps at once are drawn once
    std::array<NumberBox*, 3> numbers_{}; // by LensKnob
    std::array<QLabel*, 3> bands_{};
    QComboBox* order_;
    QSpinBox* views_;
    QSpinBox* litView_;
    QLabel* message_;
};

} // namespace altiro3D::viewer
