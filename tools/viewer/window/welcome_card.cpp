#include "viewer/window/welcome_card.hpp"

#include "altiro3D/file_io.hpp"

#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>

namespace altiro3D::viewer {

WelcomeCard::WelcomeCard(QWidget* parent)
    : QFrame(parent), headline_(new QLabel), advice_(new QLabel) {
    setObjectName("welcome");
    setFrameShape(QFrame::StyledPanel);
    setAutoFillBackground(true);
    QFont large = headline_->font();
    large.setPointSizeF(large.pointSizeF() * 1.3);
    large.setBold(true);
    headline_->setFont(large);
    for (QLabel* label : {headline_, advice_}) {
        label->setTextFormat(Qt::PlainText); // the name comes from a file
        label->setWordWrap(true);
    }
    auto* open = new QPushButton(tr("Open a &photo…"));
    open->setObjectName("welcomeOpen");
    auto* close = new QPushButton(tr("&Close this"));
    close->setObjectName("welcomeClose");
    connect(open, &QPushButton::clicked, this, &WelcomeCard::openWanted);
    connect(close, &QPushButton::clicked, this, &WelcomeCard::closed);
    auto* buttons = new QHBoxLayout;
    buttons->addWidget(open);
    buttons->addStretch();
    buttons->addWidget(close);
    auto* all = new QVBoxLayout(this);
    all->addWidget(headline_);
    all->addWidget(advice_);
    all->addLayout(buttons);
    greet({});
}

void WelcomeCard::greet(const QString& display) {
    const QString own = tr("This is a sample. Drop a photo, a video or a folder anywhere in the "
                           "window, or press Ctrl+O. ");
    if (display.isEmpty()) {
        headline_->setText(tr("Welcome. No light-field display was found."));
        advice_->setText(own + tr("The sway shows what a display would show; Lens shows what an "
                                  "eye would see. Export writes files for a display."));
    } else {
        headline_->setText(tr("Welcome, %1").arg(display));
        advice_->setText(own + tr("F11 shows the picture on the display, and Display > Test "
                                  "picture shows whether it is set up well."));
    }
    setAccessibleName(headline_->text());
    setAccessibleDescription(advice_->text());
}

std::optional<std::filesystem::path> samplePhoto() {
    for (const std::filesystem::path& directory : dataDirectories()) {
        for (const char* const folder : {"examples", "docs/examples"}) {
            const std::filesystem::path photo = directory / folder / "sample.jpg";
            std::error_code error;
            if (std::filesystem::is_regular_file(photo, error)) return photo;
        }
    }
    return std::nullopt;
}

} // namespace altiro3D::viewer
