#include "viewer/window/manual.hpp"

#include "altiro3D/file_io.hpp"
#include "cli/run_tool.hpp"
#include "viewer/window/window_words.hpp"

#include <QDialogButtonBox>
#include <QFileInfo>
#include <QLineEdit>
#include <QPushButton>
#include <QScrollBar>
#include <QTextBlock>

namespace altiro3D::viewer {

namespace {

// The name of a heading in links, as GitHub makes it.
QString anchorOf(const QString& heading) {
    QString name;
    for (const QChar c : heading.toLower()) {
        if (c == ' ') name += '-';
        if (c.isLetterOrNumber() || c == '-' || c == '_') name += c;
    }
    return name;
}

QDialogButtonBox* closeButton(QDialog* dialog) {
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close);
    QObject::connect(buttons, &QDialogButtonBox::rejected, dialog, &QDialog::reject);
    return buttons;
}

} // namespace

std::filesystem::path dataFile(const std::string& name) {
    for (const std::filesystem::path& folder : dataDirectories())
        if (tools::isFile(folder / name)) return folder / name;
    return {};
}

ManualBrowser::ManualBrowser(QWidget* parent) : QTextBrowser(parent) {
    named(this, "manual", tr("Manual"));
    setOpenExternalLinks(true);
}

void ManualBrowser::setSource(const QUrl& page) {
    const QUrl file = source().resolved(page);
    if (file.isLocalFile() && !QFileInfo(file.toLocalFile()).isFile()) {
        heading_.clear();
        return; // a page for developers, which is not installed
    }
    QTextBrowser::setSource(file);
    heading_ = file.fragment();
    if (heading_.isEmpty()) return;
    for (QTextBlock block = document()->begin(); block.isValid(); block = block.next()) {
        if (block.blockFormat().headingLevel() == 0 || anchorOf(block.text()) != heading_) continue;
        QTextCursor cursor(block);
        setTextCursor(cursor);
        verticalScrollBar()->setValue(verticalScrollBar()->value() + cursorRect().top());
        return;
    }
    heading_.clear();
}

Manual::Manual(const QUrl& page, QWidget* parent) : QDialog(parent) {
    setWindowTitle(tr("Manual"));
    setAttribute(Qt::WA_DeleteOnClose);
    resize(860, 700);
    auto* browser = new ManualBrowser;
    auto* back = new QPushButton(tr("Back"));
    back->setEnabled(false);
    auto* words =
        named(new QLineEdit, "findInManual", tr("Find"), tr("Enter finds the next place"));
    words->setPlaceholderText(tr("Find"));
    words->setClearButtonEnabled(true);
    setLayout(
        boxOf<QVBoxLayout>(1, boxOf<QHBoxLayout>(1, back, words), browser, closeButton(this)));
    for (QPushButton* button : findChildren<QPushButton*>())
        button->setAutoDefault(false); // Enter finds
    connect(back, &QPushButton::clicked, browser, &QTextBrowser::backward);
    connect(browser, &QTextBrowser::backwardAvailable, back, &QPushButton::setEnabled);
    connect(words, &QLineEdit::returnPressed, browser, [browser, words] {
        if (browser->find(words->text())) return;
        browser->moveCursor(QTextCursor::Start); // again from the beginning
        browser->find(words->text());
    });
    browser->setFocus();
    show(); // a place is scrolled to in a page that is laid out
    browser->setSource(page);
}

QDialog* keysDialog(QWidget* parent) {
    auto* dialog = new QDialog(parent);
    dialog->setWindowTitle(QObject::tr("Keys"));
    dialog->setAttribute(Qt::WA_DeleteOnClose);
    dialog->resize(640, 560);
    QString rows;
    for (const KeyWords& key : kKeys) {
        rows += QString("<tr><td><b>%1</b>&nbsp;&nbsp;</td><td>%2</td></tr>")
                    .arg(QString(key.keys).toHtmlEscaped(), QObject::tr(key.text).toHtmlEscaped());
    }
    auto* table = named(new QTextBrowser, "keys", QObject::tr("Keys"));
    table->setHtml("<table cellpadding=4>" + rows + "</table>");
    dialog->setLayout(boxOf<QVBoxLayout>(-1, table, closeButton(dialog)));
    return dialog;
}

} // namespace altiro3D::viewer
