#include "viewer/window/lens_by_eye_dialog.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/qt/display_search.hpp"
#include "cli/run_tool.hpp"
#include "viewer/window/window_words.hpp"

#include <QAbstractSpinBox>
#include <QClipboard>
#include <QComboBox>
#include <QDialogButtonBox>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QGridLayout>
#include <QGroupBox>
#include <QGuiApplication>
#include <QKeyEvent>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QScreen>
#include <QSettings>
#include <QSpinBox>
#include <QToolButton>
#include <QWindow>
#include <cmath>

namespace altiro3D::viewer {

namespace {

struct KnobWords {
    const char* name;
    const char* object;
    int digits; // after the point
    const char* tip;
};

constexpr KnobWords kKnobs[] = {
    {"Pitch", "pitch", 5, "Lenses per inch, perpendicular to them"},
    {"Slope", "slope", 4, "Rise of a lens over its run, y counts down; type 1e9 for vertical"},
    {"Centre", "centre", 4,
     "Where the lenses lie at a corner of the panel, in lens periods, 0 to "
     "1; it follows pitch and slope, which keep the middle as it is"}}; // as LensKnob

struct StepWords {
    LensStep step;
    const char* signs;
    const char* name;
    const char* keys;
};

constexpr StepWords kSteps[] = {{LensStep::Coarse, "+++", "coarse step", "Page Up, Page Down"},
                                {LensStep::Fine, "++", "fine step", "Up, Down"},
                                {LensStep::Finest, "+", "finest step", "Shift+Up, Shift+Down"}};

constexpr const char* kAdvice =
    "<p>Look at the screen of the lens with one eye, from where you will look later, and move your "
    "head slowly from left to right. One view is lit. With the right numbers all of the screen "
    "lights up at once and goes dark at once.</p><ol>"
    "<li><b>Pitch.</b> Bands stand side by side. If light wanders to the right while your head "
    "goes to the right, press a −; if to the left, a +. Press +++ or −−− once for each band, then "
    "the smaller steps, until left and right light up at once.</li>"
    "<li><b>Slope.</b> Bands lie above each other. If light wanders down while your head goes to "
    "the right, press a −; if up, a +; until top and bottom light up at once. Slanted bands need "
    "both, the pitch first.</li>"
    "<li><b>Sub-pixels.</b> The light is white in its middle and at both ends. If it has colours, "
    "choose another order.</li>"
    "<li><b>Centre.</b> Look from straight ahead. If you must go to the right to see the light, "
    "press a +; if to the left, a −.</li>"
    "<li><b>Check.</b> With more views the light is narrower, and small errors show. Light up a "
    "higher view: the light moves to the right.</li></ol>"
    "<p>If a step makes it worse, turn back. Keys in a number: Up and Down are fine steps, Page Up "
    "and Page Down coarse ones, Shift+Up and Shift+Down the finest.</p>";

cv::Size panelOf(const Calibration& calibration) {
    return {calibration.screenW, calibration.screenH};
}

double screenWidth(const QScreen& screen, cv::Size px) {
    constexpr double kUsualDpi = 96;
    const double width = screen.physicalSize().width();
    return width > 0 ? width : px.width / kUsualDpi * 25.4;
}

// The display if it is for that screen, else one of usual numbers.
Display beginning(const Display& display, const QScreen& screen) {
    const qt::ScreenFacts facts = qt::factsOf(screen);
    const bool isPrint = display.calibration.sheet && display.calibration.sheet->isPrint;
    if (qt::hasSize(facts, display.panelSize()) && !isPrint) return display;
    const QSettings settings;
    return displayOf(LensByEye::screenCalibration(facts.size, screenWidth(screen, facts.size),
                                                  settings.value("filmLpi", 30).toDouble(),
                                                  settings.value("filmAngle", 0).toDouble()));
}

} // namespace

/// A number that may be typed, and turned by steps of three sizes.
class NumberBox : public QAbstractSpinBox {
  public:
    std::function<void(LensStep, int)> onStep;
    std::function<void(double)> onTyped; // NaN: no number

    NumberBox() {
        setMinimumWidth(fontMetrics().horizontalAdvance("-88.888888") + 40);
        connect(this, &QAbstractSpinBox::editingFinished, this, [this] {
            if (text() == shown_) return;
            bool isNumber = false;
            const double value = text().replace(',', '.').toDouble(&isNumber);
            onTyped(isNumber ? value : std::nan(""));
        });
    }
    void setText(const QString& text) {
        shown_ = text;
        lineEdit()->setText(text);
    }
    void stepBy(int steps) override {
        emit editingFinished(); // what was typed counts
        constexpr int kPage = 10;
        onStep(std::abs(steps) < kPage ? LensStep::Fine : LensStep::Coarse, steps > 0 ? 1 : -1);
    }

  protected:
    StepEnabled stepEnabled() const override { return StepUpEnabled | StepDownEnabled; }
    void keyPressEvent(QKeyEvent* event) override {
        const bool up = event->key() == Qt::Key_Up;
        if (!event->modifiers().testFlag(Qt::ShiftModifier) ||
            (!up && event->key() != Qt::Key_Down))
            return QAbstractSpinBox::keyPressEvent(event);
        emit editingFinished();
        onStep(LensStep::Finest, up ? 1 : -1);
    }

  private:
    QString shown_;
};

LensByEyeDialog::LensByEyeDialog(const Display& display, QScreen& screen, QWidget* parent)
    : QDialog(parent), panel_(qt::factsOf(screen).size), lens_(beginning(display, screen)),
      message_(plainLabel({}, "lensMessage")) {
    setObjectName("lensByEyeDialog");
    setWindowTitle(tr("Lens by eye"));
    auto* advice = named(new QLabel(tr(kAdvice)), "lensAdvice", tr("What to look for"));
    advice->setWordWrap(true);
    advice->setAlignment(Qt::AlignTop);
    auto* beginning = buildBeginning(screenWidth(screen, panel_));
    auto* knobs = buildKnobs();
    setLayout(boxOf<QVBoxLayout>(2, beginning, knobs, advice, message_, buildButtons()));
    redraw_.setSingleShot(true);
    connect(&redraw_, &QTimer::timeout, this, [this] { picture_.setNative(lens_.picture()); });
    message_->setText(linesOf(qt::problemsOf(qt::factsOf(screen), panelOf(lens_.calibration()))));
    showNumbers();
    numbers_[0]->setFocus();
    picture_.setNative(lens_.picture());
    picture_.installEventFilter(this);
    connect(&picture_, &qt::NativeWidget::left, this, &QDialog::reject);
    picture_.showOn(screen);
}

// Activates the dialog when the test picture gets active, as the keys belong to the dialog.
bool LensByEyeDialog::eventFilter(QObject* object, QEvent* event) {
    if (object == &picture_ && event->type() == QEvent::WindowActivate)
        QTimer::singleShot(0, this, [this] { activateWindow(); });
    return QDialog::eventFilter(object, event);
}

void LensByEyeDialog::standOn(const QScreen& screen) {
    const QRect room = screen.availableGeometry();
    resize(sizeHint().boundedTo(room.size()));
    move(room.right() - frameGeometry().width(), room.top() + (room.height() - height()) / 2);
    if (picture_.screen() != &screen) return;
    create();
    windowHandle()->setTransientParent(picture_.windowHandle());
}

QWidget* LensByEyeDialog::buildBeginning(double width) {
    auto* group = new QGroupBox(tr("Begin with what is known"));
    auto* row = new QHBoxLayout(group);
    const auto add = [row](const char* object, const QString& label, double low, double high,
                           int digits, double value, const QString& tip = {}) {
        auto* box = named(new QDoubleSpinBox, object, label, tip);
        box->setRange(low, high);
        box->setDecimals(digits);
        box->setValue(value);
        row->addWidget(labelOf(box, label));
        row->addWidget(box);
        return box;
    };
    const QSettings settings;
    auto* lpi =
        add("lensLpi", tr("Lenses per inch"), 1, 1000, 2, settings.value("filmLpi", 30).toDouble());
    auto* angle =
        add("lensAngle", tr("Angle, °"), -45, 45, 2, settings.value("filmAngle", 0).toDouble(),
            tipOf(tr("Of the lenses from the vertical, to the right going up")));
    auto* across = add("lensWidth", tr("Screen width, mm"), 10, 10000, 1, width);
    auto* begin = named(new QPushButton(tr("Begin")), "lensBegin", tr("Begin with these numbers"));
    begin->setAutoDefault(false);
    row->addWidget(begin);
    connect(begin, &QPushButton::clicked, this, [=] {
        change([=] {
            lens_.setCalibration(LensByEye::screenCalibration(panel_, across->value(), lpi->value(),
                                                              angle->value()));
            QSettings().setValue("filmLpi", lpi->value());
            QSettings().setValue("filmAngle", angle->value());
        });
    });
    return group;
}

void LensByEyeDialog::addKnob(QGridLayout& grid, LensKnob knob) {
    const auto index = static_cast<std::size_t>(knob);
    const KnobWords& words = kKnobs[index];
    const QString name = tr(words.name);
    const int row = grid.rowCount();
    auto* number = named(new NumberBox, words.object, name, tipOf(tr(words.tip)));
    numbers_[index] = number;
    number->onStep = [this, knob](LensStep step, int direction) {
        change([&] { lens_.turn(knob, step, direction); });
    };
    number->onTyped = [this, knob](double value) { change([&] { lens_.set(knob, value); }); };
    grid.addWidget(labelOf(number, name), row, 0);
    grid.addWidget(number, row, 4);
    int column = 1;
    for (const StepWords& step : kSteps) { // --- -- - NUMBER + ++ +++
        for (const int direction : {-1, 1}) {
            const QString what = tr(step.name);
            auto* button =
                named(new QToolButton, "",
                      (direction < 0 ? tr("%1: %2 down") : tr("%1: %2 up")).arg(name, what),
                      tr("%1 (%2)").arg(what, step.keys));
            button->setText(
                QString(step.signs).replace('+', direction < 0 ? QChar(0x2212) : QChar('+')));
            button->setAutoRepeat(true);
            button->setFocusPolicy(Qt::NoFocus); // the keys of the number do the same
            connect(button, &QToolButton::clicked, number,
                    [number, s = step.step, direction] { number->onStep(s, direction); });
            grid.addWidget(button, row, direction < 0 ? column : 8 - column);
        }
        ++column;
    }
    grid.addWidget(bands_[index] = new QLabel, row, 8);
}

QWidget* LensByEyeDialog::buildKnobs() {
    auto* group = new QGroupBox(tr("Lens"));
    auto* grid = new QGridLayout(group);
    for (const LensKnob knob : {LensKnob::Pitch, LensKnob::Slope, LensKnob::Centre})
        addKnob(*grid, knob);
    grid->setColumnStretch(8, 1);
    order_ = named(new QComboBox, "lensOrder", tr("Sub-pixels"));
    order_->addItem("RGB", int(SubpixelOrder::Rgb));
    order_->addItem("BGR", int(SubpixelOrder::Bgr));
    order_->addItem(tr("RGB, vertical"), int(SubpixelOrder::VerticalRgb));
    if (!lens_.order()) order_->addItem(tr("As in the calibration"), int(SubpixelOrder::None));
    connect(order_, QOverload<int>::of(&QComboBox::activated), this, [this] {
        const auto order = static_cast<SubpixelOrder>(order_->currentData().toInt());
        if (order != SubpixelOrder::None) change([&] { lens_.setOrder(order); });
    });
    views_ = named(new QSpinBox, "lensViews", tr("Views"),
                   tipOf(tr("Views of the test picture; the saved file does not depend on it")));
    views_->setRange(3, LensByEye::kMostViews);
    views_->setSingleStep(2);
    connect(views_, QOverload<int>::of(&QSpinBox::valueChanged), this,
            [this](int views) { change([&] { lens_.setViews(views); }); });
    litView_ =
        named(new QSpinBox, "lensLitView", tr("Lit view"), tipOf(tr("0 is seen from the left")));
    connect(litView_, QOverload<int>::of(&QSpinBox::valueChanged), this,
            [this](int view) { change([&] { lens_.setLitView(view); }); });
    auto* row = new QHBoxLayout;
    for (const auto& [text, box] : {std::pair<QString, QWidget*>(tr("Sub-pixels"), order_),
                                    {tr("Views"), views_},
                                    {tr("Lit view"), litView_}}) {
        row->addWidget(labelOf(box, text));
        row->addWidget(box);
    }
    row->addStretch();
    grid->addLayout(row, grid->rowCount(), 0, 1, 9);
    return group;
}

QWidget* LensByEyeDialog::buildButtons() {
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close);
    const auto add = [&](const char* object, const QString& text, const QString& name,
                         const std::function<void()>& what) {
        auto* button = named(new QPushButton(text), object, name);
        buttons->addButton(button, QDialogButtonBox::ActionRole);
        connect(button, &QPushButton::clicked, this, what);
    };
    add("lensCopy", tr("&Copy"), tr("Copy the calibration as text"), [this] {
        QGuiApplication::clipboard()->setText(
            QString::fromStdString(calibrationText(lens_.calibration())));
    });
    add("lensPaste", tr("&Paste"), tr("Take the calibration from the clipboard"),
        [this] { change([this] { paste(); }); });
    add("lensSave", tr("&Save…"), tr("Save the calibration and use it"), [this] { save(); });
    for (QAbstractButton* button : buttons->buttons()) // Return ends the typing of a number
        qobject_cast<QPushButton*>(button)->setAutoDefault(false);
    connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
    return buttons;
}

void LensByEyeDialog::change(const std::function<void()>& what) {
    try {
        what();
        message_->clear();
    } catch (const std::exception& error) {
        message_->setText(QString::fromStdString(tools::sentenceOf(error)));
    }
    showNumbers();
    redraw_.start(0);
}

void LensByEyeDialog::show(LensKnob knob) {
    const auto index = static_cast<std::size_t>(knob);
    const double value = lens_.value(knob);
    const double band = lens_.band(knob);
    const int digits = kKnobs[index].digits;
    constexpr double kVertical = 1e6;
    numbers_[index]->setText(std::abs(value) < kVertical ? QString::number(value, 'f', digits)
                                                         : tr("vertical"));
    if (knob != LensKnob::Centre)
        bands_[index]->setText(std::abs(band) < 100 ? tr("a band is %1").arg(band, 0, 'f', digits)
                                                    : QString());
}

void LensByEyeDialog::showNumbers() {
    for (const LensKnob knob : {LensKnob::Pitch, LensKnob::Slope, LensKnob::Centre})
        show(knob);
    const QSignalBlocker noViews(views_);
    const QSignalBlocker noLitView(litView_);
    const auto order = lens_.order().value_or(SubpixelOrder::None);
    order_->setCurrentIndex(order_->findData(int(order)));
    views_->setValue(lens_.views());
    litView_->setRange(0, lens_.views() - 1);
    litView_->setValue(lens_.litView());
}

void LensByEyeDialog::paste() {
    const std::string text = QGuiApplication::clipboard()->text().toStdString();
    const Calibration pasted = parseCalibrations(text, "clipboard").front();
    const cv::Size panel = panelOf(lens_.calibration());
    if (panelOf(pasted) != panel)
        throw Error(ErrorCode::Mismatch, "clipboard",
                    "holds a calibration of " + sizeText(panelOf(pasted)) + ", expected " +
                        sizeText(panel));
    lens_.setCalibration(pasted);
}

void LensByEyeDialog::save() {
    const QString name = QFileDialog::getSaveFileName(this, tr("Save the calibration"),
                                                      "visual.json", tr("Calibrations (*.json)"));
    if (name.isEmpty()) return;
    change([&] {
        const std::filesystem::path file = toPath(name);
        writeFile(file, calibrationText(lens_.calibration()));
        emit saved(lens_.calibration(), file);
    });
    if (message_->text().isEmpty()) message_->setText(tr("Written and used: %1").arg(name));
}

} // namespace altiro3D::viewer
