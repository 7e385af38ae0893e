#include "viewer/window/photo_strip.hpp"

#include "altiro3D/image_io.hpp"
#include "altiro3D/qt/image.hpp"
#include "altiro3D/video_io.hpp"
#include "cli/run_tool.hpp"
#include "viewer/window/window_words.hpp"

#include <QApplication>
#include <QImageReader>
#include <QPixmap>
#include <QStyle>
#include <opencv2/imgproc.hpp>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

constexpr qint64 kMaxQtPixels = 500'000'000; // larger files are left to the library's limits

// A JPEG at 1/2 to 1/8 of its size, which its format allows; null for other files.
QImage reducedJpeg(const fs::path& file, int side) {
    QImageReader reader(toName(file), "jpeg");
    reader.setAutoTransform(true);
    const QSize size = reader.size();
    if (!size.isValid() || qint64(size.width()) * size.height() > kMaxQtPixels) return {};
    reader.setScaledSize(size.scaled(side, side, Qt::KeepAspectRatio).expandedTo({1, 1}));
    return reader.read();
}

// The size of an icon and its name: the same for each, though icons differ in height.
QSize cellSize() {
    constexpr int kSide = Thumbnails::kSide;
    return {kSide + 12, kSide + QFontMetrics(QApplication::font()).height() + 14};
}

} // namespace

PhotoStrip::PhotoStrip(QWidget* parent)
    : QListView(parent), thumbnails_(new Thumbnails(devicePixelRatioF(), this)) {
    named(this, "strip", tr("Strip of photos"));
    setModel(thumbnails_);
    setViewMode(QListView::IconMode);
    setMovement(QListView::Static);
    setWrapping(false);
    setUniformItemSizes(true);
    setTextElideMode(Qt::ElideMiddle);
    constexpr int kSide = Thumbnails::kSide;
    setIconSize({kSide, kSide});
    const QSize cell = cellSize();
    setGridSize(cell);
    setVerticalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
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

QImage thumbnailOf(const Source& source, int side) {
    std::error_code error;
    fs::path file = source.file;
    const tools::QuietStandardError quiet; // decoders print messages
    try {
        if (fs::is_character_file(file, error)) return {}; // a camera is opened once
        refusePipe(file);
        if (fs::is_directory(file, error)) {
            const std::vector<fs::path> views = listImages(file);
            if (views.empty()) return {};
            file = views[views.size() / 2];
        }
        QImage jpeg = reducedJpeg(file, side);
        if (!jpeg.isNull()) return jpeg;
        const cv::Mat picture = firstPicture(file);
        const double factor = double(side) / std::max(picture.cols, picture.rows);
        const cv::Size size(std::max(1, int(picture.cols * factor)),
                            std::max(1, int(picture.rows * factor)));
        cv::Mat icon;
        cv::resize(picture, icon, size, 0, 0, factor < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
        if (icon.depth() != CV_8U) icon.convertTo(icon, CV_8U, 1 / 257.0);
        return qt::toImage(icon).copy();
    } catch (const std::exception&) {
        return {}; // opening the file says why
    }
}

Thumbnails::Thumbnails(double scale, QObject* parent)
    : QAbstractListModel(parent), scale_(scale), icons_(kIcons) {
    connect(this, &Thumbnails::made, this, &Thumbnails::take, Qt::QueuedConnection);
    thread_ = std::thread([this] { run(); });
}

Thumbnails::~Thumbnails() {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        ending_ = true;
    }
    wake_.notify_one();
    thread_.join();
}

void Thumbnails::setSources(const std::vector<Source>& sources) {
    beginResetModel();
    sources_ = sources;
    failed_.clear();
    endResetModel();
}

int Thumbnails::rowCount(const QModelIndex& parent) const {
    return parent.isValid() ? 0 : static_cast<int>(sources_.size());
}

QVariant Thumbnails::data(const QModelIndex& index, int role) const {
    if (!index.isValid() || index.row() >= rowCount()) return {};
    const Source& source = sources_[static_cast<std::size_t>(index.row())];
    const fs::path& file = source.file;
    switch (role) {
    case Qt::DisplayRole:
    case Qt::AccessibleTextRole:
        return nameOf(source);
    case Qt::SizeHintRole:
        return cellSize();
    case Qt::ToolTipRole: // names are not markup
        return tipOf(toName(file) +
                     (source.depth.empty() ? QString() : "\n" + toName(source.depth)));
    case Qt::DecorationRole: {
        if (const QImage* const icon = icons_.object(toName(file))) {
            QPixmap pixmap = QPixmap::fromImage(*icon);
            pixmap.setDevicePixelRatio(scale_);
            return pixmap;
        }
        if (failed_.contains(toName(file)))
            return QApplication::style()->standardIcon(QStyle::SP_MessageBoxWarning);
        ask(source);
        return QApplication::style()->standardIcon(QStyle::SP_FileIcon);
    }
    default:
        return {};
    }
}

void Thumbnails::ask(const Source& source) const {
    if (asked_.contains(toName(source.file))) return;
    asked_.insert(toName(source.file));
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_.push_back(source);
    if (waiting_.size() > kWaiting) {
        asked_.remove(toName(waiting_.front().file));
        waiting_.pop_front();
    }
    wake_.notify_one();
}

void Thumbnails::run() {
    for (;;) {
        std::unique_lock<std::mutex> lock(mutex_);
        wake_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
        if (ending_) return;
        const Source source = waiting_.back();
        waiting_.pop_back();
        lock.unlock();
        emit made(toName(source.file), thumbnailOf(source, int(kSide * scale_)));
    }
}

void Thumbnails::take(const QString& file, const QImage& image) {
    asked_.remove(file);
    if (image.isNull())
        failed_.insert(file);
    else
        icons_.insert(file, new QImage(image));
    for (int row = 0; row < rowCount(); ++row) {
        if (toName(sources_[static_cast<std::size_t>(row)].file) == file)
            emit dataChanged(index(row), index(row), {Qt::DecorationRole});
    }
}

} // namespace altiro3D::viewer
