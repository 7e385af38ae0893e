#include "viewer/show/slide_show.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>

namespace altiro3D::viewer {

namespace {

bool isSame(const std::optional<Source>& a, const Source& b) {
    return a && isSame(*a, b);
}

} // namespace

SlideShow::SlideShow(const Settings& settings, Work work)
    : settings_(settings), work_(std::move(work)),
      list_(settings.shuffles, settings.loops, settings.seed) {}

void SlideShow::setFiles(const std::vector<Source>& files) {
    all_ = files;
    // A file that has gone may come back mended.
    failed_.erase(std::remove_if(failed_.begin(), failed_.end(),
                                 [&](const Source& failed) {
                                     return std::none_of(
                                         files.begin(), files.end(),
                                         [&](const Source& file) { return isSame(file, failed); });
                                 }),
                  failed_.end());
    files_.clear();
    for (const Source& file : files) {
        if (std::none_of(failed_.begin(), failed_.end(),
                         [&](const Source& failed) { return isSame(file, failed); }))
            files_.push_back(file);
    }
    list_.set(files_);
    if (wanted_ && std::none_of(files_.begin(), files_.end(),
                                [&](const Source& file) { return isSame(file, *wanted_); }))
        wanted_.reset();
    if (!files_.empty()) isOver_ = false;
}

void SlideShow::put(const Slide& slide) {
    if (!isSame(making_, slide.source)) return; // nobody waits for it any more
    making_.reset();
    if (slide.problem.empty()) {
        kept_.push_back(slide);
        return;
    }
    work_.report(slide.problem);
    failed_.push_back(slide.source);
    if (isSame(wanted_, slide.source)) wanted_.reset();
    setFiles(std::vector<Source>(all_));
}

const Slide* SlideShow::ready(const Source& source) const {
    if (shown_ && isSame(shown_->source, source)) return &*shown_;
    const auto slide = std::find_if(kept_.begin(), kept_.end(),
                                    [&](const Slide& s) { return isSame(s.source, source); });
    return slide != kept_.end() ? &*slide : nullptr;
}

void SlideShow::show(const Slide& slide) {
    const Slide now = slide; // which may lie in kept_
    if (shown_) {
        if (settings_.fade > 0 && shown_->native.size() == now.native.size())
            before_ = shown_->native;
        if (!isSame(shown_->source, now.source)) kept_.push_back(*shown_);
    }
    shown_ = now;
    kept_.erase(std::remove_if(kept_.begin(), kept_.end(),
                               [&](const Slide& kept) { return isSame(kept.source, now.source); }),
                kept_.end());
    since_ = fadeSince_ = now_;
    ++changes_;
}

void SlideShow::goTo(const std::optional<Source>& source) {
    if (source) wanted_ = source;
}

void SlideShow::next() {
    if (list_.next()) goTo(list_.current());
}

void SlideShow::previous() {
    if (list_.previous()) goTo(list_.current());
}

void SlideShow::setPaused(bool paused) {
    isPaused_ = paused;
}

void SlideShow::endVideo() {
    if (!list_.following()) {
        isOver_ = true;
    } else if (!wanted_) {
        next();
    }
}

void SlideShow::request() {
    if (making_) return;
    for (const std::optional<Source>& source : {wanted_, list_.following()}) {
        if (!source || ready(*source) != nullptr) continue;
        making_ = source;
        work_.make(*source);
        return;
    }
}

void SlideShow::prune() {
    const std::optional<Source> following = list_.following();
    const std::optional<Source> preceding = list_.preceding();
    kept_.erase(std::remove_if(kept_.begin(), kept_.end(),
                               [&](const Slide& slide) {
                                   return !isSame(wanted_, slide.source) &&
                                          !isSame(following, slide.source) &&
                                          !isSame(preceding, slide.source);
                               }),
                kept_.end());
}

void SlideShow::tick(double now) {
    if (isPaused_) since_ += now - now_;
    now_ = now;
    if (isOver_) return;
    if (!before_.empty() && now_ - fadeSince_ >= settings_.fade) before_.release();
    const bool isTimeUp = shown_ && !shown_->isVideo() && now_ - since_ >= settings_.each;
    if (!wanted_ && (!shown_ || (isTimeUp && !isPaused_))) {
        if (!list_.following()) {
            // Of a list that loops, a single file stays; a folder that is empty now may fill again.
            isOver_ = !settings_.loops || (files_.empty() && !shown_);
            return;
        }
        next();
    }
    if (wanted_) {
        if (const Slide* slide = ready(*wanted_)) {
            wanted_.reset();
            show(*slide);
        }
    }
    prune();
    request();
}

void SlideShow::blend(const cv::Mat& native, cv::Mat& blended) const {
    if (before_.empty() || before_.size() != native.size()) {
        blended = native;
        return;
    }
    const double share = std::clamp((now_ - fadeSince_) / settings_.fade, 0.0, 1.0);
    cv::Mat mixed;
    cv::addWeighted(native, share, before_, 1 - share, 0, mixed);
    blended = mixed;
}

} // namespace altiro3D::viewer
