#include "viewer/window/paint_bar.hpp"

#include "viewer/window/window_words.hpp"

#include <QAction>
#include <QActionGroup>
#include <QCheckBox>
#include <QSlider>
#include <cmath>

namespace altiro3D::viewer {

namespace {

struct ToolWords {
    PaintTool tool;
    const char* text;
    const char* tip;
};

const ToolWords kTools[] = {
    {PaintTool::Nearer, "Nearer", "Bring what you paint nearer"},
    {PaintTool::Farther, "Farther", "Push what you paint back"},
    {PaintTool::Smooth, "Smooth", "Smooth the depth of surfaces"},
    {PaintTool::Copy, "Copy", "Paint with the depth of the place where you press"},
    {PaintTool::Lasso, "Lasso", "Circle a thing to bring it nearer; hold Shift to push it back"}};

constexpr int kSteps = 100;
constexpr double kMinRadius = 0.004; // of the photo's longer side
constexpr double kMaxRadius = 0.25;
constexpr int kUsualSize = 55; // of kSteps

} // namespace

PaintBar::PaintBar(QWidget* parent) : QToolBar(parent) {
    setObjectName("paintBar");
    setWindowTitle(tr("Paint depth"));
    tools_ = new QActionGroup(this);
    tools_->setExclusionPolicy(QActionGroup::ExclusionPolicy::ExclusiveOptional);
    for (const ToolWords& words : kTools) {
        QAction* action = addAction(tr(words.text));
        action->setCheckable(true);
        action->setToolTip(tr(words.tip));
        action->setData(static_cast<int>(words.tool));
        action->setObjectName(words.text);
        tools_->addAction(action);
    }
    addSeparator();
    size_ = addSlider(tr("&Size"), tr("Size of the brush ([ and ])"), "brushSize");
    size_->setValue(kUsualSize);
    strength_ = addSlider(tr("S&trength"),
                          tr("Nearer, Farther, Lasso: change of the depth, in % of its range. "
                             "Smooth, Copy: share of the change."),
                          "brushStrength");
    strength_->setValue(lift_);
    edges_ = new QCheckBox(tr("Stop at &edges"));
    edges_->setToolTip(tr("The brush stays on the surface under its middle"));
    edges_->setChecked(true);
    addWidget(edges_);
    addSeparator();
    save_ = addAction(tr("Save depth…"));
    save_->setToolTip(tr("Export the depth as an image beside the photo, where all tools find it"));
    discard_ = addAction(tr("Discard"));
    discard_->setToolTip(tr("Discard everything that was painted on this photo"));
    setPainted(false);
    connect(save_, &QAction::triggered, this, &PaintBar::saveWanted);
    connect(discard_, &QAction::triggered, this, &PaintBar::discardWanted);
    connect(tools_, &QActionGroup::triggered, this, [this] {
        if (const auto now = paint()) {
            const QSignalBlocker blocker(strength_);
            strength_->setValue(strengthOf(now->tool));
        }
        emit changed();
    });
    connect(size_, &QSlider::valueChanged, this, &PaintBar::changed);
    connect(strength_, &QSlider::valueChanged, this, [this](int value) {
        if (const auto now = paint()) strengthOf(now->tool) = value;
        emit changed();
    });
    connect(edges_, &QCheckBox::toggled, this, &PaintBar::changed);
}

QSlider* PaintBar::addSlider(const QString& label, const QString& tip, const char* name) {
    auto* slider = named(new QSlider(Qt::Horizontal), name, QString(label).remove('&'), tip);
    slider->setRange(1, kSteps);
    slider->setMaximumWidth(110);
    addWidget(labelOf(slider, " " + label + " "));
    addWidget(slider);
    return slider;
}

std::optional<Paint> PaintBar::paint() const {
    const QAction* const chosen = tools_->checkedAction();
    if (chosen == nullptr) return std::nullopt;
    Paint paint;
    paint.tool = static_cast<PaintTool>(chosen->data().toInt());
    paint.radius = kMinRadius * std::pow(kMaxRadius / kMinRadius, size_->value() / double(kSteps));
    paint.amount = strength_->value() / 100.0;
    paint.keepsEdges = edges_->isChecked();
    return paint;
}

void PaintBar::choose(std::optional<PaintTool> tool) {
    for (QAction* action : tools_->actions()) {
        const bool isIt = tool && action->data().toInt() == static_cast<int>(*tool);
        if (isIt != action->isChecked()) action->trigger();
    }
}

void PaintBar::resizeBrush(int steps) {
    constexpr int kStep = 5;
    size_->setValue(size_->value() + kStep * steps);
}

void PaintBar::setPainted(bool painted) {
    save_->setEnabled(painted);
    discard_->setEnabled(painted);
}

} // namespace altiro3D::viewer
