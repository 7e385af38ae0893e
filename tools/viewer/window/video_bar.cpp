#include "viewer/window/video_bar.hpp"

#include "viewer/window/window_words.hpp"

#include <QAction>
#include <QComboBox>
#include <QPainter>
#include <QSignalBlocker>
#include <QSlider>
#include <QStyle>
#include <QToolButton>
#include <algorithm>
#include <tuple>

namespace altiro3D::viewer {

namespace {

constexpr int kTick = 100;             // ms
constexpr double kSliderSteps = 10;    // per s
constexpr double kLongestSlider = 1e8; // s, so that steps fit into an int
constexpr double kSpeeds[] = {0.5, 0.75, 1, 1.25, 1.5, 2};

QString wordsOf(const VideoStreamFacts& track, int number) {
    QStringList words{QString::number(number)};
    for (const std::string& text : {track.language, track.title})
        if (!text.empty()) words << QString::fromStdString(text);
    return words.join(' ');
}

// In the colour of text: those of styles are black, also on dark ground.
QIcon iconOf(const QWidget& widget, QStyle::StandardPixmap which) {
    QPixmap pixmap = widget.style()->standardIcon(which).pixmap(32);
    QPainter painter(&pixmap);
    painter.setCompositionMode(QPainter::CompositionMode_SourceIn);
    painter.fillRect(pixmap.rect(), widget.palette().buttonText());
    return pixmap;
}

} // namespace

QString timeText(double seconds) {
    const auto all = static_cast<qint64>(std::clamp(seconds, 0.0, 1e9));
    const QString minutes = QString::number(all / 60 % 60);
    const QString rest = QString("%1").arg(all % 60, 2, 10, QChar('0'));
    if (all < 3600) return minutes + ":" + rest;
    return QString::number(all / 3600) + ":" + minutes.rightJustified(2, '0') + ":" + rest;
}

VideoBar::VideoBar(Files& files)
    : files_(files), play_(new QToolButton), position_(new QSlider(Qt::Horizontal)),
      time_(new QLabel), mute_(new QToolButton), volume_(new QSlider(Qt::Horizontal)),
      track_(new QComboBox), speed_(new QComboBox), loop_(new QToolButton) {
    setObjectName("videoBar");
    buildControls();
    connectControls();
    showSettings();
    showVideo();
}

void VideoBar::buildControls() {
    auto* row = new QHBoxLayout(this);
    row->setContentsMargins(4, 2, 4, 2);
    const std::tuple<QWidget*, const char*, QString> controls[] = {
        {play_, "playVideo", tr("Play or stop (P)")},
        {position_, "videoPosition", tr("Position in the video (Shift+Left, Shift+Right)")},
        {time_, "videoTime", tr("Time and length of the video")},
        {mute_, "muteVideo", tr("Sound off (Shift+M)")},
        {volume_, "videoVolume", tr("Volume (+, -)")},
        {track_, "soundTrack", tr("Sound track")},
        {speed_, "videoSpeed", tr("Speed; the pitch of the sound changes with it")},
        {loop_, "loopVideo", tr("Begin again at the end")}};
    for (const auto& [control, object, words] : controls) {
        row->addWidget(named(control, object, words, words));
        control->setFocusPolicy(Qt::TabFocus); // keys of the window go on working after a click
    }
    row->setStretchFactor(position_, 1);
    position_->setPageStep(qRound(kSeekStep * kSliderSteps));
    mute_->setCheckable(true);
    volume_->setRange(0, 100);
    volume_->setPageStep(kVolumeStep);
    volume_->setFixedWidth(80);
    track_->setSizeAdjustPolicy(QComboBox::AdjustToContents);
    for (const double speed : kSpeeds)
        speed_->addItem(tr("%1x").arg(speed));
    loop_->setCheckable(true);
    loop_->setIcon(style()->standardIcon(QStyle::SP_BrowserReload));
}

void VideoBar::connectControls() {
    const auto step = [this](double by) { files_.seekVideo(files_.videoState().position + by); };
    const auto louder = [this](int by) {
        change([by](PlaySettings& to) { to.volume = std::clamp(to.volume + by, 0, 100); });
    };
    const std::pair<QKeySequence, std::function<void()>> keys[] = {
        {QKeySequence(tr("Shift+Left")), [step] { step(-kSeekStep); }},
        {QKeySequence(tr("Shift+Right")), [step] { step(kSeekStep); }},
        {QKeySequence(tr("Shift+M")), [this] { mute_->toggle(); }},
        {QKeySequence(Qt::Key_Plus), [louder] { louder(kVolumeStep); }},
        {QKeySequence(Qt::Key_Minus), [louder] { louder(-kVolumeStep); }}};
    for (const auto& [shortcut, what] : keys) {
        auto* key = new QAction(this);
        key->setShortcut(shortcut);
        connect(key, &QAction::triggered, this, what);
        addAction(key);
    }
    connect(play_, &QToolButton::clicked, this,
            [this] { files_.setPlaying(files_.videoState().paused); });
    connect(position_, &QSlider::valueChanged, this,
            [this](int value) { files_.seekVideo(value / kSliderSteps); });
    connect(mute_, &QToolButton::toggled, this,
            [this](bool on) { change([on](PlaySettings& to) { to.muted = on; }); });
    connect(volume_, &QSlider::valueChanged, this,
            [this](int value) { change([value](PlaySettings& to) { to.volume = value; }); });
    connect(track_, qOverload<int>(&QComboBox::activated), this, [this](int index) {
        const int track = tracks_[static_cast<std::size_t>(index)];
        change([track](PlaySettings& to) { to.track = track; });
    });
    connect(speed_, qOverload<int>(&QComboBox::activated), this, [this](int index) {
        change([index](PlaySettings& to) { to.speed = kSpeeds[index]; });
    });
    connect(loop_, &QToolButton::toggled, this, [this](bool on) {
        change([on](PlaySettings& to) { to.atEnd = on ? AtEnd::Loop : AtEnd::Stop; });
    });
    connect(&files_, &Files::opened, this, &VideoBar::showVideo);
    connect(&files_, &Files::playSettingsChanged, this, &VideoBar::showSettings);
    connect(&ticks_, &QTimer::timeout, this, &VideoBar::showState);
}

void VideoBar::change(const std::function<void(PlaySettings&)>& what) {
    PlaySettings settings = files_.playSettings();
    what(settings);
    files_.setPlaySettings(settings);
}

void VideoBar::showVideo() {
    const auto& document = files_.document();
    const bool plays = document && document->video;
    setVisible(plays);
    if (!plays) return ticks_.stop();
    if (!ticks_.isActive()) ticks_.start(kTick);
    showState();
}

void VideoBar::showState() {
    const VideoPlayer::State state = files_.videoState();
    if (state.paused && files_.isPlaying()) files_.setPlaying(false); // at the end
    play_->setIcon(iconOf(*this, state.paused ? QStyle::SP_MediaPlay : QStyle::SP_MediaPause));
    mute_->setIcon(iconOf(*this, QStyle::SP_MediaVolumeMuted));
    const double length = std::min(state.duration, kLongestSlider);
    const QSignalBlocker blocker(position_);
    position_->setEnabled(length > 0);
    position_->setRange(0, static_cast<int>(length * kSliderSteps));
    if (!position_->isSliderDown())
        position_->setValue(static_cast<int>(std::min(state.position, length) * kSliderSteps));
    time_->setText(length > 0 ? tr("%1 / %2").arg(timeText(state.position), timeText(length))
                              : timeText(state.position));
    for (QWidget* control : std::initializer_list<QWidget*>{mute_, volume_, track_})
        control->setEnabled(state.sounds);
    std::vector<int> tracks;
    for (const VideoStreamFacts& track : state.tracks)
        tracks.push_back(track.index);
    if (tracks != tracks_) {
        track_->clear();
        for (const VideoStreamFacts& track : state.tracks)
            track_->addItem(wordsOf(track, track_->count() + 1));
        tracks_ = tracks;
    }
    track_->setVisible(tracks.size() > 1);
}

void VideoBar::showSettings() {
    const PlaySettings& settings = files_.playSettings();
    const QSignalBlocker blockers[] = {QSignalBlocker(mute_), QSignalBlocker(volume_),
                                       QSignalBlocker(loop_)};
    mute_->setChecked(settings.muted);
    volume_->setValue(settings.volume);
    loop_->setChecked(settings.atEnd == AtEnd::Loop);
    const auto* const found = std::find(std::begin(kSpeeds), std::end(kSpeeds), settings.speed);
    speed_->setCurrentIndex(found != std::end(kSpeeds) ? int(found - std::begin(kSpeeds)) : 2);
}

QWidget* withVideoBar(QWidget* picture, Files& files) {
    auto* both = new QWidget;
    auto* column = boxOf<QVBoxLayout>(0, picture, new VideoBar(files));
    column->setContentsMargins(0, 0, 0, 0);
    column->setSpacing(0);
    both->setLayout(column);
    return both;
}

} // namespace altiro3D::viewer
