#include "viewer/window/photo_strip.hpp"

#include <QScrollBar>
#include <QStyle>

namespace altiro3D::viewer {

PhotoStrip::PhotoStrip(QWidget* parent)
    : QListView(parent), thumbnails_(new Thumbnails(devicePixelRatioF(), this)) {
    setObjectName("strip");
    setAccessibleName(tr("Strip of photos"));
    setModel(thumbnails_);
    setViewMode(QListView::IconMode);
    setMovement(QListView::Static);
    setFlow(QListView::LeftToRight);
    setWrapping(false);
    setUniformItemSizes(true);
    setTextElideMode(Qt::ElideMiddle);
    setWordWrap(false);
    constexpr int kSide = Thumbnails::kSide;
    setIconSize({kSide, kSide});
    const QSize cell(kSide + 12, kSide + fontMetrics().height() + 14);
    setGridSize(cell);
    setVerticalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOn);
    setFixedHeight(cell.height() + style()->pixelMetric(QStyle::PM_ScrollBarExtent) +
                   2 * frameWidth() + 2);
}

void PhotoStrip::setSources(const std::vector<Source>& sources) {
    updating_ = true;
    thumbnails_->setSources(sources);
    updating_ = false;
}

void PhotoStrip::setCurrent(int index) {
    updating_ = true;
    setCurrentIndex(index >= 0 ? thumbnails_->index(index) : QModelIndex());
    updating_ = false;
}

void PhotoStrip::currentChanged(const QModelIndex& current, const QModelIndex& previous) {
    QListView::currentChanged(current, previous);
    if (!updating_ && current.isValid()) emit chosen(current.row());
}

} // namespace altiro3D::viewer
