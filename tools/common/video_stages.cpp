#include "common/video_stages.hpp"

#include "common/picture_options.hpp"

#include <QCryptographicHash>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>

namespace altiro3D::tools {

namespace {

bool same(const cv::Mat& a, const cv::Mat& b) {
    return a.size() == b.size() && a.type() == b.type() && a.isContinuous() && b.isContinuous() &&
           std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

QByteArray digest(const cv::Mat& picture) {
    QCryptographicHash hash(QCryptographicHash::Sha256);
    const std::size_t bytes = static_cast<std::size_t>(picture.cols) * picture.elemSize();
    for (int y = 0; y < picture.rows; ++y)
        hash.addData(picture.ptr<char>(y), static_cast<int>(bytes));
    return hash.result();
}

bool isBeside(DepthSide side) {
    return side == DepthSide::Left || side == DepthSide::Right;
}

NativeOptions nativeOptionsOf(const CommandLine& commandLine,
                              const RenderStage::Settings& settings) {
    NativeOptions options = nativeOptions(commandLine);
    options.views = settings.views;
    options.fit = settings.fit;
    options.keepResolution = settings.keep;
    return options;
}

} // namespace

DepthStage::DepthStage(const std::filesystem::path& given, const VideoReaderOptions& part,
                       const VideoFacts& facts, ChosenDepth source,
                       const VideoDepthOptions& options)
    : source_(std::move(source)), options_(options), unit_(facts.timeBase.value()) {
    if (source_.fromFiles()) given_.emplace(given, part);
    start();
}

void DepthStage::start() {
    const auto estimate = [this](const cv::Mat& picture, cv::Mat& raw) {
        if (raw_.empty()) {
            source_.estimate(picture, raw);
        } else {
            raw_.copyTo(raw);
        }
    };
    depth_.emplace(estimate, source_.kind(), options_);
}

void DepthStage::begin(VideoReader& video) {
    if (given_) given_->begin(video);
}

cv::Size DepthStage::photoSize(cv::Size frame) const {
    if (!source_.rgbdSide()) return frame;
    return isBeside(*source_.rgbdSide()) ? cv::Size(frame.width / 2, frame.height)
                                         : cv::Size(frame.width, frame.height / 2);
}

double DepthStage::photoAspect(double frameAspect) const {
    if (!source_.rgbdSide()) return frameAspect;
    return isBeside(*source_.rgbdSide()) ? frameAspect / 2 : frameAspect * 2;
}

void DepthStage::tell(Messages& messages) const {
    if (given_) given_->tell(messages);
}

std::string DepthStage::state() const {
    return (digest(lastPhoto_) + digest(lastRaw_)).toStdString() + depth_->state();
}

void DepthStage::setState(const std::string& state) {
    const auto bytes =
        2 * static_cast<std::size_t>(QCryptographicHash::hashLength(QCryptographicHash::Sha256));
    kept_ = state.substr(0, bytes);
    depth_->setState(state.substr(kept_.size()));
}

void DepthStage::work(PipelineFrame& frame) {
    if (given_) {
        given_->read(static_cast<double>(frame.source.pts) * unit_, frame.number, raw_);
    } else if (source_.rgbdSide()) {
        cv::Mat photo;
        splitRgbd(frame.source.picture, *source_.rgbdSide(), photo, raw_);
        raw_.convertTo(raw_, CV_8U); // a grey value of a frame
        frame.source.picture = photo;
    } else {
        frame.step = depth_->next(frame.source.picture, frame.depth);
        return;
    }
    useGiven(frame);
}

// Grey values are taken as they are, so that nothing wavers; distances and floats have no range of
// their own and get one that follows them slowly.
void DepthStage::useGiven(PipelineFrame& frame) {
    bool samePhoto = same(frame.source.picture, lastPhoto_);
    bool sameDepth = same(raw_, lastRaw_);
    if (!kept_.empty()) {
        const QByteArray photo = digest(frame.source.picture);
        const QByteArray kept = QByteArray::fromStdString(kept_);
        samePhoto = kept.startsWith(photo);
        sameDepth = kept.mid(photo.size()) == digest(raw_);
        kept_.clear();
    }
    lastPhoto_ = frame.source.picture;
    lastRaw_ = raw_.clone();
    const bool grey = raw_.depth() == CV_8U || raw_.depth() == CV_16U;
    if (grey && source_.kind() != DepthKind::Metric) {
        frame.step.repeated = samePhoto && sameDepth;
        const double most = raw_.depth() == CV_8U ? 255 : 65535;
        const bool farWhite = source_.kind() == DepthKind::FarWhite;
        ownMemory(frame.depth);
        raw_.convertTo(frame.depth, CV_32F, (farWhite ? -1 : 1) / most, farWhite ? 1 : 0);
        return;
    }
    if (samePhoto && !sameDepth) start(); // what moves is not seen in the picture
    frame.step = depth_->next(frame.source.picture, frame.depth);
    frame.step.inferred = false;
}

RenderStage::RenderStage(const CommandLine& commandLine, const ChosenDisplay& display,
                         const Settings& settings, cv::Size photo, double seenAspect,
                         Messages& messages)
    : settings_(settings), panelAspect_(display.aspect()), seenAspect_(seenAspect),
      workSize_(settings.keep ? display.panelSize() : settings.layout.tileSize) {
    if (settings.product != VideoProduct::Rgbd)
        tellCut(seenAspect, panelAspect_, settings.fit, messages);
    switch (settings.product) {
    case VideoProduct::Native:
        maker_.emplace(makeNativeMaker(commandLine, display, settings.layout,
                                       nativeOptionsOf(commandLine, settings), messages,
                                       settings.continuous));
        size_ = display.panelSize();
        break;
    case VideoProduct::Quilt:
        size_ = settings.layout.size();
        break;
    case VideoProduct::Rgbd: // square px, even sides
        workSize_ = {std::max(2, static_cast<int>(std::lround(photo.height * seenAspect / 2)) * 2),
                     std::max(2, photo.height / 2 * 2)};
        size_ = {2 * workSize_.width, workSize_.height};
        break;
    }
    if (!maker_) quilter_.emplace(settings.layout, settings.views);
}

void RenderStage::fitFrame(const PipelineFrame& frame, const PhotoFit& fit) {
    fitScene({frame.source.picture, frame.depth}, fit, settings_.views.focus, fitted_);
}

void RenderStage::work(PipelineFrame& frame) {
    cv::Mat& result = frame.result.picture;
    if (frame.step.repeated && !last_.empty()) {
        result = last_;
        return;
    }
    const cv::Mat& photo = frame.source.picture;
    ownMemory(result);
    if (settings_.product == VideoProduct::Rgbd) {
        fitFrame(frame, fitPhoto(photo.size(), 1, workSize_, FitMode::Stretch));
        joinRgbd(fitted_.photo, fitted_.depth, DepthSide::Right, result);
        last_ = result;
        return;
    }
    // what counts is the shape that is seen: px of the frame need not be square
    const double pixelAspect = seenAspect_ * photo.rows / photo.cols;
    fitFrame(frame, fitPhoto(photo.size(), panelAspect_ / pixelAspect, workSize_, settings_.fit));
    if (maker_) {
        if (maker_->path() == NativePath::OverQuilt) maker_->makeQuilt(fitted_, quilt_);
        maker_->makeNative(fitted_, quilt_, result);
    } else {
        quilter_->render(fitted_.photo, fitted_.depth, result);
    }
    last_ = result;
}

QuiltStage::QuiltStage(const CommandLine& commandLine, const ChosenDisplay& display,
                       const QuiltLayout& layout, const QuiltShape& shape, Messages& messages)
    : shape_(shape), renderer_(makeQuilt2Native(commandLine, display, layout, messages)) {}

void QuiltStage::work(PipelineFrame& frame) {
    if (!last_.empty() && same(frame.source.picture, lastQuilt_)) {
        frame.step.repeated = true;
        frame.result.picture = last_;
        return;
    }
    const cv::Mat quilt = shape_.apply(frame.source.picture, last_.empty() ? &notes_ : nullptr);
    ownMemory(frame.result.picture);
    renderer_.render(quilt, frame.result.picture);
    last_ = frame.result.picture;
    lastQuilt_ = frame.source.picture;
}

} // namespace altiro3D::tools
