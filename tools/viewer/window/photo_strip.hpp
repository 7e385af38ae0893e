#pragma once

#include "viewer/model/document.hpp"

#include <QAbstractListModel>
#include <QCache>
#include <QImage>
#include <QListView>
#include <QSet>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

namespace altiro3D::viewer {

/// A small picture of a file, for an icon. JPEG files are decoded at a fraction of their size.
/// @param side most px of its width and height
/// @return null if the file cannot be read
QImage thumbnailOf(const Source& source, int side);

/// The open files as a list with icons, for a view. A thread of its own makes the icons that are
/// asked for, the latest first; the kIcons latest ones are kept.
class Thumbnails : public QAbstractListModel {
    Q_OBJECT
  public:
    static constexpr int kSide = 88;            ///< An icon's, px before scaling.
    static constexpr int kIcons = 300;          ///< About 10 MB.
    static constexpr std::size_t kWaiting = 64; ///< Older wishes are dropped; views ask again.

    /// @param scale px of the screen per px of the window
    explicit Thumbnails(double scale, QObject* parent = nullptr);
    /// Waits for the icon that is being made.
    ~Thumbnails() override;

    void setSources(const std::vector<Source>& sources);

    int rowCount(const QModelIndex& parent = {}) const override;
    QVariant data(const QModelIndex& index, int role) const override;

  signals:
    /// From the thread. @param image null if the file cannot be read
    void made(const QString& file, const QImage& image);

  private:
    void run();
    void ask(const Source& source) const;
    void take(const QString& file, const QImage& image);

    std::vector<Source> sources_;
    double scale_;
    mutable QCache<QString, QImage> icons_;
    mutable QSet<QString> asked_;
    QSet<QString> failed_;
    mutable std::mutex mutex_;
    mutable std::condition_variable wake_;
    mutable std::deque<Source> waiting_;
    bool ending_ = false;
    std::thread thread_; // last: it uses the others
};

/// The open files as one row of icons, below the picture.
class PhotoStrip : public QListView {
    Q_OBJECT
  public:
    explicit PhotoStrip(QWidget* parent = nullptr);

    void setSources(const std::vector<Source>& sources);
    /// Marks a file and scrolls to it, without emitting a signal. @param index -1: none
    void setCurrent(int index);

  signals:
    /// The user has chosen a file, by mouse or keys.
    void chosen(int index);

  protected:
    void currentChanged(const QModelIndex& current, const QModelIndex& previous) override;

  private:
    Thumbnails* thumbnails_;
    bool updating_ = false;
};

} // namespace altiro3D::viewer
