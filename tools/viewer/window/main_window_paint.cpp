// Painting depth in the window.

#include "viewer/window/main_window.hpp"
#include "viewer/window/paint_bar.hpp"
#include "viewer/window/picture_view.hpp"
#include "viewer/window/window_words.hpp"

#include <QMessageBox>
#include <QShortcut>

namespace altiro3D::viewer {

void MainWindow::buildPaintBar() {
    paintBar_ = new PaintBar;
    paintBar_->setMovable(false);
    paintBar_->hide();
    addToolBar(Qt::BottomToolBarArea, paintBar_);
    paintBar_->toggleViewAction()->setVisible(false); // the Edit menu shows it
    connect(paintBar_, &PaintBar::changed, this, &MainWindow::usePaintBar);
    connect(paintBar_, &PaintBar::saveWanted, this, [this] { exportDialog(Product::Depth); });
    connect(paintBar_, &PaintBar::discardWanted, this, [this] { controller_.unpaint(); });
    connect(paintBar_, &QToolBar::visibilityChanged, this, [this](bool visible) {
        if (!isVisible() || isMinimized()) return; // the window itself hides
        paintBar_->choose(visible ? std::optional(PaintTool::Nearer) : std::nullopt);
    });
    const std::pair<Qt::Key, std::function<void()>> keys[] = {
        {Qt::Key_BracketLeft, [this] { paintBar_->resizeBrush(-1); }},
        {Qt::Key_BracketRight, [this] { paintBar_->resizeBrush(1); }},
        {Qt::Key_Escape, [this] { paintBar_->hide(); }}};
    for (const auto& [key, what] : keys)
        connect(new QShortcut(key, this), &QShortcut::activated, this, what);
    connect(picture_, &PictureView::strokeBegan, this, &MainWindow::paint);
    connect(picture_, &PictureView::strokeMoved, this, [this](double x, double y) {
        controller_.continueStroke({x, y});
    });
    connect(picture_, &PictureView::strokeEnded, this, [this] { controller_.endStroke(); });
}

void MainWindow::usePaintBar() {
    if (paintBar_->paint()) {
        // strokes are drawn on the view from the middle
        if (controller_.mode() != Mode::Depth) controller_.setMode(Mode::Sway);
        controller_.setSwinging(false);
        if (controller_.position() != 0) controller_.setPosition(0);
    }
    showPointer();
}

void MainWindow::showPointer() {
    const auto paint = paintBar_->paint();
    const Mode mode = controller_.frame().request.mode;
    paintBar_->setPainted(controller_.isPainted());
    if (!paint || (mode != Mode::Sway && mode != Mode::Depth))
        return picture_->setPointer(PictureView::Pointer::Frame, 0);
    picture_->setPointer(paint->tool == PaintTool::Lasso ? PictureView::Pointer::Lasso
                                                         : PictureView::Pointer::Brush,
                         controller_.brushRadius(paint->radius));
}

void MainWindow::paint(double x, double y, bool shift) {
    auto paint = paintBar_->paint();
    if (!paint) return;
    if (shift) {
        paint->amount = -paint->amount;
        if (paint->tool == PaintTool::Nearer)
            paint->tool = PaintTool::Farther;
        else if (paint->tool == PaintTool::Farther)
            paint->tool = PaintTool::Nearer;
    }
    if (controller_.beginStroke(*paint, {x, y})) return;
    if (controller_.position() != 0) {
        controller_.setSwinging(false);
        controller_.setPosition(0);
        say(tr("The camera is back in the middle, where depth can be painted"), 8000);
    } else if (!controller_.canPaint()) {
        say(tr("Depth can be painted on photos, not on videos, quilts and Natives"), 8000);
    }
}

// Asks if depth was painted and not saved.
bool MainWindow::mayLosePaintedDepth() {
    const auto files = controller_.unsavedDepths();
    if (files.empty()) return true;
    std::vector<std::string> names;
    for (const auto& file : files)
        names.push_back(file.string());
    QMessageBox box(QMessageBox::Question, tr("Painted depth"),
                    tr("The depth that you have painted is not saved. Close anyway?"),
                    QMessageBox::Discard | QMessageBox::Cancel, this);
    box.setTextFormat(Qt::PlainText);
    box.setInformativeText(linesOf(names));
    box.setDefaultButton(QMessageBox::Cancel);
    return box.exec() == QMessageBox::Discard;
}

} // namespace altiro3D::viewer
