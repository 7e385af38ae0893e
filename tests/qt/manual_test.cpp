#include "viewer/window/manual.hpp"

#include "viewer/window/window_words.hpp"
#include "window_actions.hpp"

#include <QScrollBar>
#include <QSettings>
#include <QTextBlock>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

using namespace viewer;

TEST(ViewerManual, OpensAtWhatTheWindowIsAboutAndFollowsLinks) {
    QSettings().clear();
    const auto window = shownWindow();
    window->findChild<QAction*>("manual")->trigger();
    auto* const page = window->findChild<ManualBrowser*>("manual");
    ASSERT_NE(page, nullptr);
    EXPECT_TRUE(page->source().path().endsWith("docs/guide.md"));
    EXPECT_EQ(page->heading(), "look-and-show"); // a heading of that page
    EXPECT_GT(page->verticalScrollBar()->value(), 0);
    EXPECT_EQ(page->textCursor().block().text(), "Look and show");
    // every page that it refers to is there
    int links = 0;
    const QTextDocument& text = *page->document();
    for (QTextBlock block = text.begin(); block.isValid(); block = block.next()) {
        for (const auto& format : block.textFormats()) {
            const QUrl link = page->source().resolved(QUrl(format.format.anchorHref()));
            if (format.format.anchorHref().isEmpty() || !link.isLocalFile()) continue;
            ++links;
            EXPECT_TRUE(QFileInfo(link.toLocalFile()).isFile()) << link.path().toStdString();
        }
    }
    EXPECT_GE(links, 10);
    // a click follows a link to a heading of another page
    QTextCursor place = page->document()->find("stereo pairs");
    while (!place.isNull() && place.charFormat().anchorHref() != "depth.md#stereo-pairs")
        place = page->document()->find("stereo pairs", place);
    ASSERT_FALSE(place.isNull());
    place.setPosition(place.position() - 1);
    page->setTextCursor(place);
    QTest::mouseClick(page->viewport(), Qt::LeftButton, Qt::NoModifier,
                      page->cursorRect(place).center());
    EXPECT_EQ(page->heading(), "stereo-pairs");
    EXPECT_TRUE(page->source().path().endsWith("docs/depth.md"));
    page->setSource(QUrl("no-such-page.md"));
    EXPECT_TRUE(page->source().path().endsWith("docs/depth.md"));
}

TEST(ViewerManual, ListsTheKeysOfTheTableWithoutWordsOfATerminal) {
    QSettings().clear();
    const auto window = shownWindow();
    window->findChild<QAction*>("keys")->trigger();
    const QString text = window->findChild<QTextBrowser*>("keys")->toPlainText();
    for (const KeyWords& key : kKeys) {
        EXPECT_TRUE(text.contains(key.keys)) << key.keys;
        EXPECT_TRUE(text.contains(key.text)) << key.text;
    }
    EXPECT_FALSE(text.contains("--"));
}

} // namespace
} // namespace altiro3D::test
