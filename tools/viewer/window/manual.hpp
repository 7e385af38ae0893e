#pragma once

#include <QDialog>
#include <QTextBrowser>
#include <filesystem>

namespace altiro3D::viewer {

/// A file that is installed with the viewer or in the source tree; empty if it is not there.
/// @param name relative to the folder of altiro3D's data, such as "docs/guide.md"
std::filesystem::path dataFile(const std::string& name);

/// Shows pages in Markdown from files; a link may name a heading, as on GitHub ("#look-and-show").
class ManualBrowser : public QTextBrowser {
    Q_OBJECT
  public:
    explicit ManualBrowser(QWidget* parent = nullptr);

    void setSource(const QUrl& page) override;
    /// The heading that the last link named; empty: none, or it does not exist.
    const QString& heading() const { return heading_; }

  private:
    QString heading_;
};

/// The manual in a window of its own, with a field to search it. It needs no network.
class Manual : public QDialog {
    Q_OBJECT
  public:
    /// @param page with its heading, or the text to show if it is not installed
    Manual(const QUrl& page, QWidget* parent);
};

/// All keys of the window, from the table that the manual page is made of.
QDialog* keysDialog(QWidget* parent);

} // namespace altiro3D::viewer
