#pragma once

#include "viewer/model/document.hpp"
#include "viewer/model/knobs.hpp"

#include <QVariant>
#include <QWidget>
#include <functional>

class QBoxLayout;
class QComboBox;
class QDoubleSpinBox;
class QFormLayout;
class QGroupBox;
class QLabel;
class QSlider;
class QSpinBox;
class QToolButton;

namespace altiro3D::viewer {

/// A slider with a number field. A double click on the slider restores the default value.
class KnobSlider : public QWidget {
    Q_OBJECT
  public:
    /// @param object, words its names, see named()
    /// @param decimals digits after the decimal point, for slider and number field
    /// @param most the largest number, beyond the slider's `high`
    KnobSlider(const char* object, const QString& words, double low, double high, int decimals,
               double standard, const QString& suffix, double most = 0);

    double value() const;
    /// Sets the value without emitting a signal.
    void setValue(double value);
    QSlider& slider() { return *slider_; }

  signals:
    /// The user has changed the value. All changes of one drag have the same gesture number.
    void turned(double value, int gesture);

  protected:
    bool eventFilter(QObject* object, QEvent* event) override;

  private:
    double steps_; // slider steps per unit of the value
    double standard_;
    int gesture_ = 0;
    QSlider* slider_;
    QDoubleSpinBox* number_;
};

constexpr double kMaxEyesStrength = 10; ///< Between two eyes, % of the width.

/// The right side of the window with all settings.
class KnobPanel : public QWidget {
    Q_OBJECT
  public:
    explicit KnobPanel(QWidget* parent = nullptr);

    /// Shows settings without emitting a signal.
    void show(const Knobs& knobs);
    /// Shows the values that were chosen for what is automatic, without emitting a signal.
    void showChosen(const Knobs& chosen);
    /// Shows the properties of a document and enables its settings; null: nothing is open.
    void show(const Document* document, const QString& depthSource);
    /// Shows the display and the numbers of its quilt.
    void show(const Display& display, const QuiltLayout& layout);
    /// @param hiddenPercent see Frame
    void showParallax(double viewPixels, double hiddenPercent);
    /// Lists the installed depth networks, and whether there is a better one to download.
    void showNetworks(bool isBetterKnown);

    /// Shows the strength between two eyes. @param areShown whether the picture is for two eyes
    void showEyes(bool areShown, double strength);

  signals:
    void turned(const Knobs& knobs, const QString& what, int gesture);
    void readingChosen(Reading reading);
    void depthImageWanted();
    void betterDepthWanted();
    void calibrationWanted();
    void resetWanted();
    /// Enter or Escape has ended the typing of a number.
    void numberLeft();
    void eyesStrengthTurned(double strength);

  protected:
    bool eventFilter(QObject* object, QEvent* event) override;

  private:
    /// The row of a setting in the recipe.
    struct Knob {
        const RecipeField* field;
        std::vector<QWidget*> widgets;            ///< What people see of it.
        std::function<void(const QString&)> show; ///< Shows a value.
    };

    void buildPicture(QBoxLayout& column); // and its depth
    void buildViews(QBoxLayout& column);
    void buildDisplay(QBoxLayout& column);
    /// Adds the row of a field of the recipe, which tells how its value is chosen.
    /// @param words beside it @param tip else the field's help @param autoTip of its box "Auto"
    /// @param choices words of its values, in this order; else those of the field
    void addKnob(QFormLayout& form, const char* field, const QString& words,
                 const QString& tip = {}, const QString& autoTip = {},
                 const std::vector<std::pair<QString, QVariant>>& choices = {});
    void turn(const RecipeField& field, const QString& value, int gesture = 0);
    void turn(const QString& what, const std::function<void(Knobs&)>& change, int gesture = 0);

    Knobs shown_;
    bool updating_ = false;
    std::vector<Knob> knobs_;
    QComboBox* reading_;
    QComboBox* depth_;
    QLabel* depthSource_;
    QToolButton* depthImage_;
    QToolButton* betterDepth_;
    KnobSlider* eyesStrength_;
    QWidget* eyesStrengthLabel_;
    QLabel* parallax_;
    QLabel* display_;
    QSpinBox* columns_;
    QSpinBox* rows_;
    QLabel* layout_;
    QGroupBox* viewKnobs_;
    QGroupBox* depthKnobs_;
};

} // namespace altiro3D::viewer
