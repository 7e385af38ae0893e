#pragma once

#include "viewer/model/depth_canvas.hpp"

#include <QToolBar>
#include <optional>

class QActionGroup;
class QCheckBox;
class QSlider;

namespace altiro3D::viewer {

/// The tool bar for painting depth: brushes, lasso, their size and strength.
class PaintBar : public QToolBar {
    Q_OBJECT
  public:
    explicit PaintBar(QWidget* parent = nullptr);

    /// The settings for the next stroke; nothing if no tool is chosen.
    std::optional<Paint> paint() const;
    /// Chooses a tool, or none.
    void choose(std::optional<PaintTool> tool);
    /// Makes the brush larger (1) or smaller (-1).
    void resizeBrush(int steps);
    /// Enables what is for painted depth only.
    void setPainted(bool painted);

  signals:
    /// paint() has changed.
    void changed();
    void saveWanted();
    void discardWanted();

  private:
    QSlider* addSlider(const QString& label, const QString& tip, const char* name);
    int& strengthOf(PaintTool tool) {
        return tool == PaintTool::Smooth || tool == PaintTool::Copy ? replace_ : lift_;
    }

    QActionGroup* tools_;
    QSlider* size_;
    QSlider* strength_;
    QCheckBox* edges_;
    QAction* save_;
    QAction* discard_;
    int lift_ = 10;     // %, of the tools that move depth
    int replace_ = 100; // %, of the others
};

} // namespace altiro3D::viewer
