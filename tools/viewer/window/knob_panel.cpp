#include "viewer/window/knob_panel.hpp"

#include "altiro3D/depth_network.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/stereo_views.hpp"
#include "viewer/window/window_words.hpp"

#include <QCheckBox>
#include <QComboBox>
#include <QCoreApplication>
#include <QDoubleSpinBox>
#include <QEvent>
#include <QFormLayout>
#include <QGraphicsOpacityEffect>
#include <QGroupBox>
#include <QKeyEvent>
#include <QLabel>
#include <QPushButton>
#include <QSignalBlocker>
#include <QSlider>
#include <QToolButton>
#include <cmath>

namespace altiro3D::viewer {

namespace {

constexpr double kMaxSlider = 40; // larger numbers are typed
constexpr const char* kAuto = "auto";

using Choices = std::vector<std::pair<QString, QVariant>>;

// A combo box that holds a value with each of its words.
QComboBox* choiceOf(const char* object, const QString& name, const Choices& words) {
    auto* box = named(new QComboBox, object, name);
    for (const auto& [word, value] : words)
        box->addItem(word, value);
    return box;
}

void choose(QComboBox& box, const QVariant& value) {
    box.setCurrentIndex(std::max(0, box.findData(value)));
}

QSpinBox* numbers(const char* object, const QString& name, int high, int low = 1) {
    auto* box = named(new QSpinBox, object, name);
    box->setRange(low, high);
    return box;
}

QToolButton* button(const char* object, const QString& name, const QString& text) {
    auto* button = named(new QToolButton, object, name);
    button->setText(text);
    return button;
}

QLabel* faintLabel(const char* object) {
    auto* label = plainLabel({}, object);
    auto* faint = new QGraphicsOpacityEffect(label); // in every palette
    faint->setOpacity(0.65);
    label->setGraphicsEffect(faint);
    return label;
}

QString textOf(const RecipeField& field, const Recipe& recipe) {
    return QString::fromStdString(field.text(recipe));
}

// The words of a field, as they are.
Choices choicesOf(const RecipeField& field) {
    Choices choices;
    for (const QString& word : QString::fromStdString(field.valueName).split('|'))
        choices.emplace_back(word.left(1).toUpper() + word.mid(1), word);
    return choices;
}

QFormLayout& addGroup(QBoxLayout& column, QGroupBox* group) {
    auto* form = new QFormLayout(group);
    form->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
    form->setLabelAlignment(Qt::AlignLeft | Qt::AlignVCenter);
    form->setVerticalSpacing(6);
    form->setContentsMargins(9, 6, 9, 8);
    column.addWidget(group);
    return *form;
}

// Adds a row with a setting and its words, which have its tip too.
template <class Row>
QWidget* addRow(QFormLayout& form, const QString& words, QWidget* setting, const QString& tip,
                Row* row) {
    setting->setToolTip(tipOf(tip));
    form.addRow(words, row);
    QWidget* const label = form.labelForField(row);
    label->setToolTip(setting->toolTip());
    return label;
}
QWidget* addRow(QFormLayout& form, const QString& words, QWidget* setting, const QString& tip) {
    return addRow(form, words, setting, tip, setting);
}

} // namespace

KnobSlider::KnobSlider(const char* object, const QString& words, double low, double high,
                       int decimals, double standard, const QString& suffix, double most)
    : steps_(std::pow(10, decimals)), standard_(standard), slider_(new QSlider(Qt::Horizontal)),
      number_(new QDoubleSpinBox) {
    slider_->setRange(static_cast<int>(std::lround(low * steps_)),
                      static_cast<int>(std::lround(high * steps_)));
    slider_->setPageStep(std::max(1, (slider_->maximum() - slider_->minimum()) / 10));
    slider_->setMinimumWidth(90);
    slider_->installEventFilter(this);
    number_->setRange(low, std::max(high, most));
    number_->setDecimals(decimals);
    number_->setSingleStep(decimals == 2 ? 0.05 : 0.5);
    number_->setSuffix(suffix);
    number_->setAlignment(Qt::AlignRight);
    number_->setFixedWidth(number_->fontMetrics().horizontalAdvance("100.00 % ") + 36);
    auto* row = new QHBoxLayout(this);
    row->setContentsMargins(0, 0, 0, 0);
    row->addWidget(slider_, 1);
    row->addWidget(number_);
    setValue(standard);
    named(this, object, words);
    slider_->setAccessibleName(words);
    number_->setAccessibleName(words);
    connect(slider_, &QSlider::sliderPressed, this, [this] { gesture_ = nextGesture(); });
    connect(slider_, &QSlider::sliderReleased, this, [this] { gesture_ = 0; });
    connect(slider_, &QSlider::valueChanged, this, [this](int step) {
        const QSignalBlocker blocker(number_);
        number_->setValue(step / steps_);
        emit turned(value(), gesture_ > 0 ? gesture_ : nextGesture());
    });
    connect(number_, qOverload<double>(&QDoubleSpinBox::valueChanged), this, [this](double value) {
        const QSignalBlocker blocker(slider_);
        slider_->setValue(static_cast<int>(std::lround(value * steps_)));
        emit turned(value, nextGesture());
    });
}

double KnobSlider::value() const {
    return number_->value();
}

void KnobSlider::setValue(double value) {
    const QSignalBlocker blockers[] = {QSignalBlocker(slider_), QSignalBlocker(number_)};
    slider_->setValue(static_cast<int>(std::lround(value * steps_)));
    number_->setValue(value);
}

bool KnobSlider::eventFilter(QObject* object, QEvent* event) {
    if (object == slider_ && event->type() == QEvent::MouseButtonDblClick) {
        number_->setValue(standard_);
        return true;
    }
    return QWidget::eventFilter(object, event);
}

KnobPanel::KnobPanel(QWidget* parent) : QWidget(parent) {
    auto* column = new QVBoxLayout(this);
    column->setSpacing(6);
    column->setContentsMargins(8, 4, 8, 8);
    buildPicture(*column);
    buildViews(*column);
    buildDisplay(*column);
    column->addStretch(1);
    auto* reset =
        named(new QPushButton(tr("Reset all settings")), "reset", {},
              tipOf(tr("Sets everything back to the usual settings. Undo brings yours back.")));
    connect(reset, &QPushButton::clicked, this, &KnobPanel::resetWanted);
    column->addWidget(reset);
    showNetworks(false);
    for (auto* widget : findChildren<QWidget*>()) {
        auto* const number = qobject_cast<QAbstractSpinBox*>(widget);
        if (number != nullptr) number->setKeyboardTracking(false); // what is typed is one step
        if (number == nullptr && qobject_cast<QComboBox*>(widget) == nullptr &&
            qobject_cast<QSlider*>(widget) == nullptr)
            continue;
        widget->setFocusPolicy(Qt::StrongFocus); // not by the wheel
        widget->installEventFilter(this);
    }
    show(Knobs());
    show(nullptr, {});
}

void KnobPanel::addKnob(QFormLayout& form, const char* name, const QString& words,
                        const QString& tip, const QString& autoTip, const Choices& choices) {
    const RecipeField& field = recipeField(name);
    QWidget* setting = nullptr;
    QCheckBox* automatic = nullptr;
    std::function<void(const QString&)> show;
    Recipe any;
    if (field.valueName.find('|') != std::string::npos) {
        auto* box = choiceOf(name, words, choices.empty() ? choicesOf(field) : choices);
        setting = box;
        show = [box](const QString& value) { choose(*box, value); };
        connect(box, qOverload<int>(&QComboBox::currentIndexChanged), this,
                [this, &field, box] { turn(field, box->currentData().toString()); });
    } else if (field.most <= field.least) { // true or false
        auto* box = named(new QCheckBox, name, words);
        setting = box;
        show = [box](const QString& value) { box->setChecked(value == "true"); };
        connect(box, &QCheckBox::toggled, this,
                [this, &field](bool on) { turn(field, on ? "true" : "false"); });
    } else if (!field.read(any, std::to_string(field.least + 0.5))) { // whole numbers
        auto* box = numbers(name, words, int(field.most), int(field.least));
        setting = box;
        show = [box](const QString& value) { box->setValue(value.toInt()); };
        connect(box, qOverload<int>(&QSpinBox::valueChanged), this,
                [this, &field](int value) { turn(field, QString::number(value)); });
    } else {
        const bool isPercent = field.valueName == "PERCENT";
        auto* slider = new KnobSlider(name, words, field.least, std::min(field.most, kMaxSlider),
                                      isPercent ? 1 : 2, textOf(field, Recipe()).toDouble(),
                                      isPercent ? tr(" %") : QString(), field.most);
        setting = slider;
        connect(slider, &KnobSlider::turned, this, [this, &field](double value, int gesture) {
            turn(field, QString::number(value), gesture);
        });
        if (field.read(any, kAuto)) {
            automatic = named(new QCheckBox(tr("Auto")), (std::string("auto-") + name).c_str(),
                              tr("%1, automatic").arg(words), tipOf(autoTip));
            connect(automatic, &QCheckBox::toggled, this, [this, &field, slider](bool on) {
                turn(field, on ? kAuto : QString::number(slider->value()));
            });
        }
        show = [slider, automatic](const QString& value) {
            if (automatic != nullptr) automatic->setChecked(value == kAuto);
            if (value != kAuto) slider->setValue(value.toDouble()); // else showChosen() does
        };
    }
    const QString help = tip.isEmpty() ? QString::fromStdString(field.help) : tip;
    QWidget* const label = automatic != nullptr ? addRow(form, words, setting, help,
                                                         boxOf<QHBoxLayout>(0, setting, automatic))
                                                : addRow(form, words, setting, help);
    knobs_.push_back({&field, {label, setting}, show});
}

void KnobPanel::buildPicture(QBoxLayout& column) {
    reading_ = choiceOf("reading", tr("Read as"),
                        {{tr("Automatic"), int(Reading::Automatic)},
                         {tr("Photo"), int(Reading::Photo)},
                         {tr("Photo, depth right"), int(Reading::RgbdRight)},
                         {tr("Photo, depth left"), int(Reading::RgbdLeft)},
                         {tr("Photo, depth above"), int(Reading::RgbdTop)},
                         {tr("Photo, depth below"), int(Reading::RgbdBottom)},
                         {tr("Stereo pair, left beside right"), int(Reading::EyesLeftRight)},
                         {tr("Stereo pair, right beside left"), int(Reading::EyesRightLeft)},
                         {tr("Stereo pair, left above right"), int(Reading::EyesTopBottom)},
                         {tr("Quilt"), int(Reading::Quilt)},
                         {tr("Native"), int(Reading::Native)},
                         {tr("Real views from a moving camera"), int(Reading::Slide)}});
    connect(reading_, qOverload<int>(&QComboBox::activated), this,
            [this] { emit readingChosen(static_cast<Reading>(reading_->currentData().toInt())); });
    QFormLayout& picture = addGroup(column, new QGroupBox(tr("Picture")));
    addRow(picture, tr("Read as"), reading_,
           tr("What the file is. Change it if it was taken for something else."));
    addKnob(picture, "fit", tr("Shape"),
            tr("How the picture gets the shape of the display: by cutting, by bars, or by "
               "stretching. \"Keep the subject\" chooses what is cut off."),
            {},
            {{tr("Fill, cut off the rest"), "cover"},
             {tr("Fill, keep the subject"), kAuto},
             {tr("Show all, with bars"), "contain"},
             {tr("Stretch"), "stretch"}});

    depthKnobs_ = new QGroupBox(tr("Depth"));
    QFormLayout& form = addGroup(column, depthKnobs_);
    depth_ = named(new QComboBox, "depth", tr("Depth from"));
    connect(depth_, qOverload<int>(&QComboBox::currentIndexChanged), this, [this] {
        turn(tr("depth"),
             [this](Knobs& to) { to.depth = depth_->currentData().toString().toStdString(); });
    });
    depthImage_ = button("depthImage", tr("Choose a depth image"), tr("Image…"));
    connect(depthImage_, &QToolButton::clicked, this, &KnobPanel::depthImageWanted);
    depthImage_->setToolTip(
        tipOf(tr("Choose a picture that holds the depth of this photo; near is white.")));
    addRow(form, tr("From"), depth_,
           tr("Where the depth comes from: the photo's own file, or a network that estimates it. "
              "\"Best available\" prefers depth that comes with the photo."),
           boxOf<QHBoxLayout>(0, depth_, depthImage_));
    form.addRow(depthSource_ = faintLabel("depthSource"));
    form.addRow(betterDepth_ = button("betterDepth", tr("Better depth"), tr("Better depth…")));
    connect(betterDepth_, &QToolButton::clicked, this, &KnobPanel::betterDepthWanted);
    betterDepth_->setToolTip(tipOf(
        tr("Download a network that estimates depth more accurately. You see first what it is.")));
    addKnob(form, "depth-curve", tr("Curve"),
            tr("Who gets the depth: above 1 near things become rounder and the background flatter, "
               "below 1 the other way round. A double click on the slider resets it."));
}

void KnobPanel::buildViews(QBoxLayout& column) {
    viewKnobs_ = new QGroupBox(tr("Views"));
    QFormLayout& form = addGroup(column, viewKnobs_);
    addKnob(form, "strength", tr("Strength"),
            tr("How deep the scene is: how far things move between the outermost views, in % of "
               "the width. Too much makes edges double. A double click on the slider resets it."),
            tr("As much depth as the display shows without double edges."));
    eyesStrength_ = new KnobSlider("eyesStrength", tr("Depth between the eyes"), 0,
                                   kMaxEyesStrength, 2, kEyesStrength, tr(" %"));
    connect(eyesStrength_, &KnobSlider::turned, this, &KnobPanel::eyesStrengthTurned);
    eyesStrengthLabel_ =
        addRow(form, tr("For two eyes"), eyesStrength_,
               tr("How far things move between the pictures of two eyes, in % of the width. Much "
                  "less than for a display of lenses is comfortable."));
    addKnob(form, "focus", tr("Focus"),
            tr("Which depth lies on the display's surface, where it is sharpest: 0 is the "
               "farthest, 1 the nearest. A click on the picture chooses it too, a double click on "
               "the slider resets it."),
            tr("The subject of the picture lies on the display's surface."));
    addKnob(form, "method", tr("Method"));
    addKnob(form, "fill", tr("Behind edges"), {}, {},
            {{tr("Painted background"), "background"}, {tr("Continued rows"), "continue"}});
    addKnob(form, "refine", tr("Refinement"));
    form.addRow(parallax_ = faintLabel("parallax"));
    parallax_->setToolTip(tipOf(tr("How far things move from one view to the next. Edges show "
                                   "double if it is much more than a pixel.")));
}

void KnobPanel::buildDisplay(QBoxLayout& column) {
    QFormLayout& form = addGroup(column, new QGroupBox(tr("Display")));
    display_ = faintLabel("display");
    auto* calibration = button("calibration", tr("Choose the calibration"), tr("Choose…"));
    calibration->setToolTip(tipOf(
        tr("Choose the calibration of a display, its file visual.json. Each unit has its own.")));
    connect(calibration, &QToolButton::clicked, this, &KnobPanel::calibrationWanted);
    auto* row = boxOf<QHBoxLayout>(0, display_, calibration);
    row->setAlignment(calibration, Qt::AlignTop);
    form.addRow(row);
    columns_ = numbers("columns", tr("Columns of the quilt"), 64);
    rows_ = numbers("rows", tr("Rows of the quilt"), 64);
    for (QSpinBox* box : {columns_, rows_}) {
        connect(box, qOverload<int>(&QSpinBox::valueChanged), this, [this] {
            turn(tr("views"), [this](Knobs& to) {
                to.columns = columns_->value();
                to.rows = rows_->value();
            });
        });
    }
    rows_->setToolTip(
        tipOf(tr("Rows of the quilt. More views move more smoothly and have fewer pixels each.")));
    auto* grid = boxOf<QHBoxLayout>(0, columns_, new QLabel(tr("×")), rows_);
    grid->setStretch(2, 1);
    addRow(form, tr("Views"), columns_,
           tr("Columns of the quilt. Columns times rows is the number of views."), grid);
    form.addRow(layout_ = faintLabel("layout"));
}

// The wheel scrolls the panel unless a setting was chosen before. Enter and Escape leave a number,
// so that the keys of the window work again.
bool KnobPanel::eventFilter(QObject* object, QEvent* event) {
    if (event->type() == QEvent::Wheel && !static_cast<QWidget*>(object)->hasFocus()) {
        event->ignore();
        return true;
    }
    auto* const number = qobject_cast<QAbstractSpinBox*>(object);
    const bool isShortcut = event->type() == QEvent::ShortcutOverride;
    if (number == nullptr || (!isShortcut && event->type() != QEvent::KeyPress)) return false;
    const auto* const key = static_cast<QKeyEvent*>(event);
    const bool escapes = key->key() == Qt::Key_Escape;
    if (isShortcut) {
        event->setAccepted(escapes); // else the window takes it
        return escapes;
    }
    if (key->text() == ",") { // of German keyboards
        QKeyEvent point(QEvent::KeyPress, Qt::Key_Period, key->modifiers(), ".");
        return QCoreApplication::sendEvent(object, &point);
    }
    if (!escapes && key->key() != Qt::Key_Return && key->key() != Qt::Key_Enter) return false;
    if (escapes) number->setProperty("value", number->property("value")); // drops what was typed
    number->interpretText();
    emit numberLeft();
    return true;
}

void KnobPanel::turn(const RecipeField& field, const QString& value, int gesture) {
    const QString what = QString::fromStdString(field.name).replace('-', ' ');
    turn(
        what,
        [&](Knobs& to) {
            field.read(to, value.toStdString());
            // the slider's own strength is not limited
            if (field.name == "strength" && gesture > 0) to.choices.limit = false;
        },
        gesture);
}

void KnobPanel::turn(const QString& what, const std::function<void(Knobs&)>& change, int gesture) {
    if (updating_) return;
    Knobs knobs = shown_;
    change(knobs);
    emit turned(knobs, what, gesture);
}

void KnobPanel::show(const Knobs& knobs) {
    updating_ = true;
    shown_ = knobs;
    for (const Knob& knob : knobs_) {
        const RecipeField& field = *knob.field;
        knob.show(textOf(field, knobs));
        for (QWidget* widget : knob.widgets)
            if (field.method) widget->setVisible(*field.method == knobs.views.method);
    }
    choose(*depth_, QString::fromStdString(knobs.depth));
    updating_ = false;
}

void KnobPanel::showChosen(const Knobs& chosen) {
    updating_ = true;
    Knobs numbers = chosen;
    numbers.choices = {};
    for (const char* name : {"strength", "focus"})
        findChild<KnobSlider*>(name)->setValue(textOf(recipeField(name), numbers).toDouble());
    updating_ = false;
}

void KnobPanel::show(const Document* document, const QString& depthSource) {
    const bool isScene = document != nullptr && document->kind == Kind::Scene;
    depthImage_->setEnabled(isScene && !document->video); // its own, not that of the whole group
    choose(*reading_, int(document != nullptr ? document->source.reading : Reading::Automatic));
    depthSource_->setText(depthSource.isEmpty() ? tr("–") : tr("Used: %1").arg(depthSource));
    for (QWidget* knob : std::initializer_list<QWidget*>{findChild<QWidget*>("fit"), depthKnobs_,
                                                         viewKnobs_, columns_, rows_})
        knob->setEnabled(isScene);
}

void KnobPanel::showEyes(bool areShown, double strength) {
    eyesStrength_->setValue(strength);
    eyesStrength_->setVisible(areShown);
    eyesStrengthLabel_->setVisible(areShown);
    for (const char* name : {"strength", "auto-strength"}) // no effect
        findChild<QWidget*>(name)->setEnabled(!areShown);
}

void KnobPanel::show(const Display& display, const QuiltLayout& layout) {
    updating_ = true;
    const std::string& serial = display.calibration.serial;
    display_->setText(
        tr("%1\n%2 × %3 px")
            .arg(QString::fromStdString(serial.empty() ? std::string("Display") : serial))
            .arg(display.panelSize().width)
            .arg(display.panelSize().height));
    display_->setToolTip(tipOf(QString::fromStdString(display.source)));
    columns_->setValue(layout.columns);
    rows_->setValue(layout.rows);
    layout_->setText(tr("%1 views of %2 × %3 px")
                         .arg(layout.viewCount)
                         .arg(layout.tileSize.width)
                         .arg(layout.tileSize.height));
    updating_ = false;
}

void KnobPanel::showNetworks(bool isBetterKnown) {
    const QSignalBlocker blocker(depth_);
    const QVariant chosen = depth_->currentData();
    depth_->clear();
    depth_->addItem(tr("Best available"), kBestDepth);
    depth_->addItem(tr("From its file"), kGivenDepth);
    try {
        for (const InstalledNetwork& network : installedNetworks())
            depth_->addItem(QString::fromStdString(network.profile.name),
                            QString::fromStdString(network.profile.name));
    } catch (const Error& error) {
        depth_->setToolTip(tipOf(QString::fromUtf8(error.what())));
    }
    choose(*depth_, chosen);
    betterDepth_->setVisible(isBetterKnown);
}

void KnobPanel::showParallax(double viewPixels, double hiddenPercent) {
    QString text = tr("%1 px from view to view").arg(viewPixels, 0, 'f', 2);
    if (viewPixels > kParallaxBudgetPixels) text += tr(": edges will show double");
    if (hiddenPercent > 1.5 * kMaxAutoHidden)
        text += tr("\n%1 % of the outer views is not in the photo and will look smeared: lower the "
                   "strength")
                    .arg(hiddenPercent, 0, 'f', 0);
    parallax_->setText(viewPixels > 0 ? text : tr("–"));
}

} // namespace altiro3D::viewer
