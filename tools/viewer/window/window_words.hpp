#pragma once

#include "altiro3D/enum_table.hpp"
#include "altiro3D/qt/display_search.hpp"
#include "cli/run_tool.hpp"
#include "viewer/model/making.hpp"

#include <QBoxLayout>
#include <QFile>
#include <QLabel>
#include <QMessageBox>
#include <QObject>
#include <QString>
#include <QStringList>
#include <QTextDocument>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

namespace altiro3D::viewer {

/// One or more keys of the window and their effect.
struct KeyWords {
    const char* keys;
    const char* text;
};
constexpr KeyWords kKeys[] = {
    {"1, 2, 3, 4, 5, 6",
     "Look at one view (Sway), Depth, Quilt, Native, through the lenses (Lens), or with both eyes "
     "(Stereo)."},
    {"X, Shift+Up, Shift+Down",
     "Exchange the pictures of both eyes, make the depth between them larger, smaller."},
    {"Space", "Start or stop the swing of the camera."},
    {"M", "Let the camera follow the mouse, or stop that."},
    {"PgDown, PgUp", "Open the next, the previous file."},
    {"P", "Play or stop the video."},
    {"B", "Paint the depth: brushes and a lasso in a bar of their own; Escape ends it."},
    {"[, ]", "A smaller, a larger brush."},
    {"Shift+Left, Shift+Right", "Go back or on by 5 s in the video, also in a show."},
    {"Shift+M, +, -", "Switch the sound of the video off or on, make it louder, quieter; also "
                      "in a show."},
    {"0", "Reset the frame. Drag a photo to move it, turn the wheel to zoom (1..100)."},
    {"F11", "Show the Native on the light-field display."},
    {"Shift+F11", "Show the picture for two eyes on the screen that Display > Screen names."},
    {"Escape", "Leave the display; F11 and a double click do the same."},
    {"Right, Left, Space", "In a show: the next file, the one before, stop or go on."},
    {"Up, PgUp, Shift+Up",
     "In Display > Lens by eye: turn a number by a fine, coarse, finest step; Down and PgDown "
     "turn it back."},
    {"Ctrl+O, Ctrl+Shift+O, Ctrl+D", "Open a file, a folder, the depth of this photo."},
    {"Ctrl+S, Ctrl+Shift+S, Ctrl+E",
     "Export the Native, the quilt, the Natives of all open files."},
    {"Ctrl+Shift+E", "Export the open video as a Native video."},
    {"Ctrl+Z, Ctrl+Shift+Z, Ctrl+R", "Undo, redo, reset all settings."},
    {"Ctrl+W, Ctrl+Q", "Close the file, quit."},
    {"F1, Ctrl+F1", "Show these keys, the manual."},
};

/// The path for a file name; file names are bytes.
inline std::filesystem::path toPath(const QString& name) {
    return QFile::encodeName(name).toStdString();
}

/// The file name for people.
inline QString toName(const std::filesystem::path& path) {
    return QFile::decodeName(path.string().c_str());
}

/// The name of a file or folder for people, without its place.
inline QString nameOf(const Source& source) {
    const std::filesystem::path& file = source.file; // perhaps "views/"
    return toName(file.has_filename() ? file.filename() : file.parent_path().filename());
}

/// The name of a screen for people, which tells it from the others.
/// @param index of it among all
inline QString nameOf(const qt::ScreenFacts& screen, std::size_t index) {
    return screen.name.empty() ? QObject::tr("Screen %1").arg(index + 1)
                               : QString::fromStdString(screen.name);
}

/// The texts of some items, one per line.
template <class Items, class Text>
QString linesOf(const Items& items, const Text& textOf) {
    QStringList lines;
    for (const auto& item : items)
        lines << textOf(item);
    return lines.join('\n');
}
inline QString linesOf(const std::vector<std::string>& sentences) {
    return linesOf(sentences, QString::fromStdString);
}

/// Text for a tool tip. Names and messages contain texts from files, which must not be interpreted
/// as markup.
inline QString tipOf(const QString& text) {
    return Qt::convertFromPlainText(text, Qt::WhiteSpaceNormal); // long ones are wrapped
}

/// Shows a warning and waits until the user closes it.
inline void warn(QWidget* parent, const QString& title, const QString& text) {
    QMessageBox box(QMessageBox::Warning, title, text, QMessageBox::Ok, parent);
    box.setTextFormat(Qt::PlainText);
    box.exec();
}
inline void warn(QWidget* parent, const QString& title, const std::exception& error) {
    warn(parent, title, QString::fromStdString(tools::sentenceOf(error)));
}

constexpr const char* kVideoFormats =
    "MP4 video (*.mp4 *.m4v);;Matroska video (*.mkv);;QuickTime video (*.mov)";
constexpr const char* kPictureFormats = "PNG picture (*.png);;JPEG picture (*.jpg *.jpeg);;"
                                        "TIFF picture (*.tif *.tiff);;All files (*)";
/// The name of a product in menus, the end of its file's, and the formats that a dialog offers.
struct ProductWords {
    const char* name;
    const char* ending;
    const char* formats;
};
constexpr ProductWords kProducts[] = {
    {"Native", "_native.png",
     "PNG picture (*.png);;TIFF picture (*.tif *.tiff);;BMP picture (*.bmp);;All files (*)"},
    {"Quilt", ".png", kPictureFormats},
    {"Views", "_views", ""},
    {"Depth", "_depth.png", "PNG picture (*.png);;TIFF picture (*.tif *.tiff);;All files (*)"},
    {"Sway video", "_sway.mp4", kVideoFormats},
    {"Stereo picture", "", kPictureFormats},
    {"Page for browsers", ".html", "Page (*.html)"}}; // as Product
inline QString nameOf(Product product) {
    return QObject::tr(entryOf(kProducts, product).name);
}

/// Names a widget for tests and styles, and for people, also for screen readers, which do not see
/// what stands beside it. @return the widget
template <class Widget>
Widget* named(Widget* widget, const char* object, const QString& words, const QString& tip = {}) {
    widget->setObjectName(object);
    widget->setAccessibleName(words);
    widget->setToolTip(tip);
    return widget;
}

/// A label of several lines without markup, as names and messages contain texts from files.
inline QLabel* plainLabel(const QString& text = {}, const char* object = "") {
    auto* label = new QLabel(text);
    label->setObjectName(object);
    label->setTextFormat(Qt::PlainText);
    label->setWordWrap(true);
    return label;
}

/// The words beside a field, whose key (&) leads to it.
inline QLabel* labelOf(QWidget* field, const QString& text) {
    auto* label = new QLabel(text);
    label->setBuddy(field);
    return label;
}

/// A row or a column of widgets and layouts.
/// @param wide index of the part that takes the room which is left, or -1
template <class Box, class... Parts>
Box* boxOf(int wide, Parts*... parts) {
    auto* box = new Box;
    const auto add = [box](auto* part) {
        if constexpr (std::is_base_of_v<QLayout, std::remove_pointer_t<decltype(part)>>)
            box->addLayout(part);
        else
            box->addWidget(part);
    };
    (add(parts), ...);
    box->setStretch(wide, 1);
    return box;
}

} // namespace altiro3D::viewer
