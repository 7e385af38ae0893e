#include "viewer/window/knob_panel.hpp"

#include "altiro3D/depth_network.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/placement.hpp"
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
#include <QHBoxLayout>
#include <QKeyEvent>
#include <QLabel>
#include <QPushButton>
#include <QSignalBlocker>
#include <QSlider>
#include <QToolButton>
#include <cmath>

namespace altiro3D::viewer {

namespace {

constexpr double kMaxStrength = 40; // of the slider
constexpr int kAutoFit = -1;        // cover, with the part that is chosen

struct Tip {
    const char* object;
    const char* text;
};
// What each setting does.
constexpr Tip kTips[] = {
    {"reading",
     QT_TRANSLATE_NOOP("tips", "What the file is. Change it if it was taken for something else.")},
    {"fit",
     QT_TRANSLATE_NOOP(
         "tips",
         "How the picture gets the shape of the display: by cutting, by bars, or by stretching. "
         "\"Keep the subject\" chooses what is cut off.")},
    {"depth",
     QT_TRANSLATE_NOOP(
         "tips",
         "Where the depth comes from: the photo's own file, or a network that estimates it. "
         "\"Best available\" prefers depth that comes with the photo.")},
    {"depthImage",
     QT_TRANSLATE_NOOP("tips",
                       "Choose a picture that holds the depth of this photo; near is white.")},
    {"betterDepth",
     QT_TRANSLATE_NOOP("tips", "Download a network that estimates depth more accurately. You see "
                               "first what it is.")},
    {"depthCurve",
     QT_TRANSLATE_NOOP(
         "tips",
         "Who gets the depth: above 1 near things become rounder and the background flatter, "
         "below 1 the other way round. A double click on the slider resets it.")},
    {"strength",
     QT_TRANSLATE_NOOP(
         "tips",
         "How deep the scene is: how far things move between the outermost views, in % of "
         "the width. Too much makes edges double. A double click on the slider resets it.")},
    {"eyesStrength",
     QT_TRANSLATE_NOOP("tips",
                       "How far things move between the pictures of two eyes, in % of the width. "
                       "Much less than for a display of lenses is comfortable.")},
    {"autoStrength",
     QT_TRANSLATE_NOOP("tips", "As much depth as the display shows without double edges.")},
    {"focus",
     QT_TRANSLATE_NOOP(
         "tips",
         "Which depth lies on the display's surface, where it is sharpest: 0 is the farthest, 1 "
         "the nearest. A click on the picture chooses it too, a double click on the slider resets "
         "it.")},
    {"autoFocus",
     QT_TRANSLATE_NOOP("tips", "The subject of the picture lies on the display's surface.")},
    {"method",
     QT_TRANSLATE_NOOP(
         "tips",
         "How the views are made. Layered has the cleanest edges; Fast is quick; Real works like a "
         "camera that moves.")},
    {"fill",
     QT_TRANSLATE_NOOP(
         "tips", "What appears behind the edges of near things, where the photo shows nothing.")},
    {"refinement",
     QT_TRANSLATE_NOOP("tips", "Steps that make edges more accurate. More steps are slower.")},
    {"parallax",
     QT_TRANSLATE_NOOP(
         "tips",
         "How far things move from one view to the next. Edges show double if it is much more "
         "than a pixel.")},
    {"calibration",
     QT_TRANSLATE_NOOP(
         "tips",
         "Choose the calibration of a display, its file visual.json. Each unit has its own.")},
    {"columns",
     QT_TRANSLATE_NOOP("tips", "Columns of the quilt. Columns times rows is the number of views.")},
    {"rows",
     QT_TRANSLATE_NOOP(
         "tips", "Rows of the quilt. More views move more smoothly and have fewer pixels each.")},
    {"reset", QT_TRANSLATE_NOOP(
                  "tips", "Sets everything back to the usual settings. Undo brings yours back.")},
};

QHBoxLayout* rowOf(QWidget* first, QWidget* second) {
    auto* row = new QHBoxLayout;
    row->addWidget(first, 1);
    row->addWidget(second);
    return row;
}

// A combo box that holds a number of an enumeration with each of its words.
QComboBox* choices(const char* object, const QString& name,
                   const std::vector<std::pair<QString, int>>& words) {
    auto* box = named(new QComboBox, object, name);
    for (const auto& [word, value] : words)
        box->addItem(word, value);
    return box;
}

void choose(QComboBox& box, const QVariant& value) {
    const QSignalBlocker blocker(box);
    box.setCurrentIndex(std::max(0, box.findData(value)));
}

QSpinBox* numbers(const char* object, const QString& name, int low, int high) {
    auto* box = named(new QSpinBox, object, name);
    box->setRange(low, high);
    return box;
}

QLabel* faintLabel(const QString& name) {
    auto* label = new QLabel;
    label->setObjectName(name);
    label->setTextFormat(Qt::PlainText); // what files say is no markup
    label->setWordWrap(true);
    auto* faint = new QGraphicsOpacityEffect(label); // in every palette
    faint->setOpacity(0.65);
    label->setGraphicsEffect(faint);
    return label;
}

bool choosesStrength(const Knobs& knobs) {
    return knobs.choices.strength || knobs.choices.limit;
}

QFormLayout* formOf(QWidget* widget) {
    auto* form = new QFormLayout(widget);
    form->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
    form->setLabelAlignment(Qt::AlignLeft | Qt::AlignVCenter);
    form->setVerticalSpacing(6);
    form->setContentsMargins(9, 6, 9, 8);
    return form;
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
    const Knobs standard;
    reading_ = choices("reading", tr("Read as"),
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
    fit_ = choices("fit", tr("Shape"),
                   {{tr("Fill, cut off the rest"), int(FitMode::Cover)},
                    {tr("Fill, keep the subject"), kAutoFit},
                    {tr("Show all, with bars"), int(FitMode::Contain)},
                    {tr("Stretch"), int(FitMode::Stretch)}});
    depth_ = named(new QComboBox, "depth", tr("Depth from"));
    depthImage_ = named(new QToolButton, "depthImage", tr("Choose a depth image"));
    depthImage_->setText(tr("Image…"));
    betterDepth_ = named(new QToolButton, "betterDepth", tr("Better depth"));
    betterDepth_->setText(tr("Better depth…"));
    depthSource_ = faintLabel("depthSource");
    const RecipeField& curve = recipeField("depth-curve");
    depthCurve_ = new KnobSlider("depthCurve", tr("Depth curve"), curve.least, curve.most, 2,
                                 standard.depthCurve, {});
    method_ = choices("method", tr("Method of views"),
                      {{tr("Layered"), int(ViewMethod::Layered)},
                       {tr("Fast"), int(ViewMethod::Fast)},
                       {tr("Real"), int(ViewMethod::Real)}});
    strength_ =
        new KnobSlider("strength", tr("Strength"), 0, kMaxStrength, 1,
                       standard.views.strengthPercent, tr(" %"), recipeField("strength").most);
    eyesStrength_ = new KnobSlider("eyesStrength", tr("Depth between the eyes"), 0,
                                   kMaxEyesStrength, 2, kEyesStrength, tr(" %"));
    autoStrength_ = named(new QCheckBox(tr("Auto")), "autoStrength", tr("Strength, automatic"));
    autoFocus_ = named(new QCheckBox(tr("Auto")), "autoFocus", tr("Focus, automatic"));
    focus_ = new KnobSlider("focus", tr("Focus"), 0, 1, 2, standard.views.focus, {});
    refinement_ =
        numbers("refinement", tr("Refinement"), 0, static_cast<int>(recipeField("refine").most));
    fill_ = choices("fill", tr("Content behind edges"),
                    {{tr("Painted background"), int(LayeredFill::BackgroundLayer)},
                     {tr("Continued rows"), int(LayeredFill::Continue)}});
    parallax_ = faintLabel("parallax");
    display_ = faintLabel("display");
    columns_ = numbers("columns", tr("Columns of the quilt"), 1, 64);
    rows_ = numbers("rows", tr("Rows of the quilt"), 1, 64);
    layout_ = faintLabel("layout");
    build();
    showNetworks(false);
    connectKnobs();
    for (auto* widget : findChildren<QWidget*>()) {
        auto* const number = qobject_cast<QAbstractSpinBox*>(widget);
        if (number != nullptr) number->setKeyboardTracking(false); // what is typed is one step
        if (number == nullptr && qobject_cast<QComboBox*>(widget) == nullptr &&
            qobject_cast<QSlider*>(widget) == nullptr)
            continue;
        widget->setFocusPolicy(Qt::StrongFocus); // not by the wheel
        widget->installEventFilter(this);
    }
    show(standard);
    show(nullptr, {});
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

void KnobPanel::connectKnobs() {
    const std::pair<QComboBox*, QString> choices[] = {
        {fit_, tr("fit")}, {depth_, tr("depth")}, {method_, tr("method")}, {fill_, tr("fill")}};
    for (const auto& [box, what] : choices) {
        connect(box, qOverload<int>(&QComboBox::currentIndexChanged), this,
                [this, what = what] { turn(what); });
    }
    connect(refinement_, qOverload<int>(&QSpinBox::valueChanged), this,
            [this] { turn(tr("refinement")); });
    for (QSpinBox* box : {columns_, rows_}) {
        connect(box, qOverload<int>(&QSpinBox::valueChanged), this, [this] {
            if (updating_) return;
            Knobs knobs = read();
            knobs.columns = columns_->value();
            knobs.rows = rows_->value();
            emit turned(knobs, tr("views"), 0);
        });
    }
    const auto onSlider = [this](KnobSlider* slider, QCheckBox* automatic, const QString& what) {
        connect(slider, &KnobSlider::turned, this,
                [this, slider, automatic, what](double, int gesture) {
                    const QSignalBlocker blocker(automatic);
                    automatic->setChecked(false);
                    if (slider == strength_) shown_.choices.limit = false;
                    turn(what, gesture);
                });
        connect(automatic, &QCheckBox::toggled, this, [this, what] { turn(what); });
    };
    onSlider(strength_, autoStrength_, tr("strength"));
    connect(depthCurve_, &KnobSlider::turned, this,
            [this](double, int gesture) { turn(tr("depth curve"), gesture); });
    connect(eyesStrength_, &KnobSlider::turned, this,
            [this](double strength) { emit eyesStrengthTurned(strength); });
    onSlider(focus_, autoFocus_, tr("focus"));
    connect(reading_, qOverload<int>(&QComboBox::activated), this,
            [this] { emit readingChosen(static_cast<Reading>(reading_->currentData().toInt())); });
    connect(depthImage_, &QToolButton::clicked, this, &KnobPanel::depthImageWanted);
    connect(betterDepth_, &QToolButton::clicked, this, &KnobPanel::betterDepthWanted);
}

void KnobPanel::build() {
    auto* column = new QVBoxLayout(this);
    column->setSpacing(6);
    column->setContentsMargins(8, 4, 8, 8);

    auto* picture = new QGroupBox(tr("Picture"));
    auto* form = formOf(picture);
    form->addRow(tr("Read as"), reading_);
    form->addRow(tr("Shape"), fit_);
    column->addWidget(picture);

    auto* depth = new QGroupBox(tr("Depth"));
    depthKnobs_ = depth;
    form = formOf(depth);
    form->addRow(tr("From"), rowOf(depth_, depthImage_));
    form->addRow(depthSource_);
    form->addRow(betterDepth_);
    form->addRow(tr("Curve"), depthCurve_);
    column->addWidget(depth);

    auto* views = new QGroupBox(tr("Views"));
    viewKnobs_ = views;
    form = formOf(views);
    form->addRow(tr("Strength"), rowOf(strength_, autoStrength_));
    form->addRow(tr("For two eyes"), eyesStrength_);
    eyesStrengthLabel_ = form->labelForField(eyesStrength_);
    form->addRow(tr("Focus"), rowOf(focus_, autoFocus_));
    form->addRow(tr("Method"), method_);
    const auto addFor = [&](ViewMethod method, const QString& label, QWidget* field) {
        form->addRow(label, field);
        ofMethod_.emplace_back(method, field);
        ofMethod_.emplace_back(method, form->labelForField(field));
    };
    addFor(ViewMethod::Layered, tr("Behind edges"), fill_);
    addFor(ViewMethod::Fast, tr("Refinement"), refinement_);
    form->addRow(parallax_);
    column->addWidget(views);

    auto* display = new QGroupBox(tr("Display"));
    form = formOf(display);
    auto* calibration = named(new QToolButton, "calibration", tr("Choose the calibration"));
    calibration->setText(tr("Choose…"));
    connect(calibration, &QToolButton::clicked, this, &KnobPanel::calibrationWanted);
    QHBoxLayout* const displayRow = rowOf(display_, calibration);
    displayRow->setAlignment(calibration, Qt::AlignTop);
    form->addRow(displayRow);
    auto* grid = new QHBoxLayout;
    grid->addWidget(columns_, 1);
    grid->addWidget(new QLabel(tr("×")));
    grid->addWidget(rows_, 1);
    form->addRow(tr("Views"), grid);
    form->addRow(layout_);
    column->addWidget(display);

    column->addStretch(1);
    auto* reset = new QPushButton(tr("Reset all settings"));
    reset->setObjectName("reset");
    connect(reset, &QPushButton::clicked, this, &KnobPanel::resetWanted);
    column->addWidget(reset);
    addTips();
}

// To the settings and the words beside them.
void KnobPanel::addTips() {
    for (const Tip& tip : kTips) {
        auto* const widget = findChild<QWidget*>(tip.object);
        const QString text = tipOf(QCoreApplication::translate("tips", tip.text));
        if (widget->toolTip().isEmpty()) widget->setToolTip(text); // else it tells a problem
        for (auto* form : findChildren<QFormLayout*>()) {
            for (int row = 0; row < form->rowCount(); ++row) {
                QLayoutItem* const label = form->itemAt(row, QFormLayout::LabelRole);
                QLayoutItem* const field = form->itemAt(row, QFormLayout::FieldRole);
                if (label == nullptr || field == nullptr) continue;
                const bool isIts = field->layout() != nullptr
                                       ? field->layout()->indexOf(widget) == 0
                                       : field->widget() == widget;
                if (isIts) label->widget()->setToolTip(text);
            }
        }
    }
}

Knobs KnobPanel::read() const {
    Knobs knobs = shown_;
    ViewOptions& views = knobs.views;
    views.method = static_cast<ViewMethod>(method_->currentData().toInt());
    knobs.choices = {fit_->currentData().toInt() == kAutoFit, autoFocus_->isChecked(),
                     autoStrength_->isChecked(), shown_.choices.limit};
    // sliders show what was chosen
    if (!choosesStrength(knobs)) views.strengthPercent = strength_->value();
    if (!knobs.choices.focus) views.focus = focus_->value();
    views.refinement = refinement_->value();
    views.layered.fill = static_cast<LayeredFill>(fill_->currentData().toInt());
    knobs.fit =
        knobs.choices.framing ? FitMode::Cover : static_cast<FitMode>(fit_->currentData().toInt());
    knobs.depthCurve = depthCurve_->value();
    knobs.depth = depth_->currentData().toString().toStdString();
    return knobs;
}

void KnobPanel::turn(const QString& what, int gesture) {
    if (updating_) return;
    emit turned(read(), what, gesture);
}

void KnobPanel::show(const Knobs& knobs) {
    updating_ = true;
    shown_ = knobs;
    const ViewOptions& views = knobs.views;
    choose(*method_, int(views.method));
    autoStrength_->setChecked(knobs.choices.strength);
    autoFocus_->setChecked(knobs.choices.focus);
    if (!knobs.choices.strength) strength_->setValue(views.strengthPercent);
    if (!knobs.choices.focus) focus_->setValue(views.focus);
    refinement_->setValue(views.refinement);
    choose(*fill_, int(views.layered.fill));
    choose(*fit_, knobs.choices.framing ? kAutoFit : int(knobs.fit));
    depthCurve_->setValue(knobs.depthCurve);
    choose(*depth_, QString::fromStdString(knobs.depth));
    for (const auto& [method, widget] : ofMethod_)
        widget->setVisible(method == views.method);
    updating_ = false;
    enable();
}

void KnobPanel::showChosen(const Knobs& chosen) {
    if (choosesStrength(shown_)) strength_->setValue(chosen.views.strengthPercent);
    if (shown_.choices.focus) focus_->setValue(chosen.views.focus);
}

void KnobPanel::show(const Document* document, const QString& depthSource) {
    scene_ = document != nullptr && document->kind == Kind::Scene;
    depthImage_->setEnabled(scene_ && !document->video); // its own, not that of the whole group
    choose(*reading_, int(document != nullptr ? document->source.reading : Reading::Automatic));
    depthSource_->setText(depthSource.isEmpty() ? tr("–") : tr("Used: %1").arg(depthSource));
    enable();
}

void KnobPanel::showEyes(bool areShown, double strength) {
    eyesStrength_->setValue(strength);
    eyesStrength_->setVisible(areShown);
    eyesStrengthLabel_->setVisible(areShown);
    strength_->setEnabled(!areShown); // no effect
    autoStrength_->setEnabled(!areShown);
}

void KnobPanel::enable() {
    fit_->setEnabled(scene_);
    depthKnobs_->setEnabled(scene_);
    viewKnobs_->setEnabled(scene_);
    columns_->setEnabled(scene_);
    rows_->setEnabled(scene_);
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
