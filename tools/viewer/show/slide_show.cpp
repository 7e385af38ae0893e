#include "viewer/show/slide_show.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>

namespace altiro3D::viewer {

namespace {

bool isSame(const std::optional<Source>& a, const Source& b) {
    return a && isSame(*a, b);
}

bool holds(const std::vector<Source>& files, const Source& wanted) {
    return std::any_of(files.begin(), files.end(),
                       [&](const Source& file) { return isSame(file, wanted); });
}

} // namespace

SlideShow::SlideShow(const Settings& settings, Work work)
    : settings_(settings), work_(std::move(work)),
      list_(settings.shuffles, settings.loops, settings.seed) {}

void SlideShow::setFiles(const std::vector<Source>& files) {
    all_ = files;
    // A file that has gone may come back mended.
    failed_.erase(std::remove_if(failed_.begin(), failed_.end(),
                                 [&](const Source& failed) { return !holds(files, failed); }),
                  failed_.end());
    files_.clear();
    std::copy_if(files.begin(), files.end(), std::back_inserter(files_),
                 [&](const Source& file) { return !holds(failed_, file); });
    list_.set(files_);
    if (wanted_ && !holds(files_, *wanted_)) wanted_.reset();
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

void SlideShow::next() {
    if (list_.next()) wanted_ = list_.current();
}

void SlideShow::previous() {
    if (list_.previous()) wanted_ = list_.current();
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

ShowList::ShowList(bool shuffles, bool loops, unsigned seed)
    : shuffles_(shuffles), loops_(loops), random_(seed) {}

void ShowList::set(const std::vector<Source>& files) {
    const std::optional<Source> now = current();
    // The files of the present order that stay, with the place among them.
    std::vector<Source> kept;
    std::size_t place = 0;
    for (std::size_t i = 0; i < order_.size(); ++i) {
        if (i == at_) place = kept.size();
        if (holds(files, order_[i])) kept.push_back(order_[i]);
    }
    if (at_ >= order_.size()) place = kept.size();
    nextRound_.clear();
    if (!shuffles_) {
        // What follows a file that has gone is found by what is left of the old order.
        const std::optional<Source> anchor =
            place < kept.size() ? std::optional<Source>(kept[place]) : std::nullopt;
        order_ = files;
        at_ = order_.size();
        for (std::size_t i = 0; anchor && i < order_.size(); ++i)
            if (isSame(order_[i], *anchor)) at_ = i;
        isGone_ = !now || !holds(order_, *now);
        if (kept.empty()) at_ = 0;
        return;
    }
    order_ = kept;
    at_ = place;
    isGone_ = !now || !holds(order_, *now);
    for (const Source& file : files) {
        if (holds(kept, file)) continue;
        const std::size_t first = std::min(order_.size(), isGone_ ? at_ : at_ + 1);
        std::uniform_int_distribution<std::size_t> any(first, order_.size());
        order_.insert(order_.begin() + static_cast<std::ptrdiff_t>(any(random_)), file);
    }
}

std::optional<Source> ShowList::current() const {
    if (isGone_ || at_ >= order_.size()) return std::nullopt;
    return order_[at_];
}

std::size_t ShowList::nextIndex() const {
    return isGone_ ? at_ : at_ + 1;
}

std::vector<Source> ShowList::round() {
    std::vector<Source> files = order_;
    if (!shuffles_) return files;
    std::shuffle(files.begin(), files.end(), random_);
    // not the same file twice in a row
    if (const auto now = current(); now && files.size() > 1 && isSame(files.front(), *now))
        std::swap(files.front(), files.back());
    return files;
}

std::optional<Source> ShowList::following() {
    if (order_.empty()) return std::nullopt;
    if (nextIndex() < order_.size()) return order_[nextIndex()];
    if (!loops_) return std::nullopt;
    if (nextRound_.empty()) nextRound_ = round();
    return nextRound_.front();
}

std::optional<Source> ShowList::preceding() const {
    if (order_.empty()) return std::nullopt;
    if (at_ > 0) return order_[at_ - 1];
    return loops_ ? std::optional<Source>(order_.back()) : std::nullopt;
}

bool ShowList::next() {
    if (!following()) return false;
    if (nextIndex() < order_.size()) {
        at_ = nextIndex();
    } else {
        order_.swap(nextRound_);
        nextRound_.clear();
        at_ = 0;
    }
    isGone_ = false;
    return true;
}

bool ShowList::previous() {
    if (!preceding()) return false;
    at_ = at_ > 0 ? at_ - 1 : order_.size() - 1;
    isGone_ = false;
    nextRound_.clear();
    return true;
}

} // namespace altiro3D::viewer
