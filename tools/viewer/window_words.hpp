#pragma once

#include "viewer/making.hpp"

#include <QFile>
#include <QMessageBox>
#include <QObject>
#include <QString>
#include <QStringList>
#include <filesystem>
#include <string>
#include <vector>

namespace altiro3D::viewer {

/// File names are bytes.
inline std::filesystem::path toPath(const QString& name) {
    return QFile::encodeName(name).toStdString();
}

/// The name for people.
inline QString toName(const std::filesystem::path& path) {
    return QFile::decodeName(path.string().c_str());
}

/// A line for each sentence.
inline QString linesOf(const std::vector<std::string>& sentences) {
    QStringList lines;
    for (const std::string& sentence : sentences)
        lines << QString::fromStdString(sentence);
    return lines.join('\n');
}

/// Says what has gone wrong, and waits until it is read.
inline void warn(QWidget* parent, const QString& title, const QString& text) {
    QMessageBox box(QMessageBox::Warning, title, text, QMessageBox::Ok, parent);
    box.setTextFormat(Qt::PlainText);
    box.exec();
}

/// A product by the name in menus.
inline QString nameOf(Product product) {
    switch (product) {
    case Product::Native:
        return QObject::tr("Native");
    case Product::Quilt:
        return QObject::tr("Quilt");
    case Product::Views:
        return QObject::tr("Views");
    case Product::Depth:
        return QObject::tr("Depth");
    case Product::SwayVideo:
        break;
    }
    return QObject::tr("Sway video");
}

} // namespace altiro3D::viewer
