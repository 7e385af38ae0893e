#pragma once

#include "viewer/document.hpp"
#include "viewer/knobs.hpp"

#include <QWidget>

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QLabel;
class QSlider;
class QSpinBox;
class QToolButton;

namespace altiro3D::viewer {

/// A slider with its number. A double click on the slider brings back the number it had at first.
class KnobSlider : public QWidget {
    Q_OBJECT
  public:
    /// @param decimals digits after the point, of slider and number
    KnobSlider(double low, double high, int decimals, double standard, const QString& suffix,
               QWidget* parent = nullptr);

    double value() const;
    /// Shows a number, without a signal.
    void setValue(double value);
    QSlider& slider() { return *slider_; }

  signals:
    /// The user has turned it. Turns of one drag have the same number.
    void turned(double value, int gesture);

  protected:
    bool eventFilter(QObject* object, QEvent* event) override;

  private:
    double steps_; // of the slider for 1
    double standard_;
    int gesture_ = 0;
    QSlider* slider_;
    QDoubleSpinBox* number_;
};

/// The right side of the window: all knobs.
class KnobPanel : public QWidget {
    Q_OBJECT
  public:
    explicit KnobPanel(QWidget* parent = nullptr);

    /// Shows knobs, without a signal.
    void show(const Knobs& knobs);
    /// Shows what belongs to a document; null: nothing is open.
    void show(const Document* document, const QString& depthSource);
    /// Shows the display and the numbers of its quilt.
    void show(const Display& display, const QuiltLayout& layout);
    void showParallax(double viewPixels);

    KnobSlider& strength() { return *strength_; }
    KnobSlider& focus() { return *focus_; }

  signals:
    void turned(const Knobs& knobs, const QString& what, int gesture);
    void readingChosen(Reading reading);
    void depthImageWanted();
    void calibrationWanted();
    void resetWanted();

  private:
    void build(); // lays them out
    void connectKnobs();
    void turn(const QString& what, int gesture = 0);
    Knobs read() const;
    void enable();

    Knobs shown_;
    bool updating_ = false;
    bool scene_ = false;
    QComboBox* reading_;
    QComboBox* fit_;
    QComboBox* depth_;
    QLabel* depthSource_;
    QToolButton* depthImage_;
    QComboBox* method_;
    QCheckBox* best_;
    KnobSlider* strength_;
    KnobSlider* focus_;
    QSpinBox* refinement_;
    QSpinBox* softEdges_;
    QComboBox* fill_;
    QLabel* parallax_;
    QLabel* display_;
    QSpinBox* columns_;
    QSpinBox* rows_;
    QLabel* layout_;
    std::vector<std::pair<ViewMethod, QWidget*>> ofMethod_; // rows that one method has
    QWidget* viewKnobs_;
    QWidget* depthKnobs_;
};

} // namespace altiro3D::viewer
