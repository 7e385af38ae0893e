#include "viewer/show/show_list.hpp"

#include <algorithm>

namespace altiro3D::viewer {

namespace {

bool holds(const std::vector<Source>& files, const Source& wanted) {
    return std::any_of(files.begin(), files.end(),
                       [&](const Source& file) { return isSame(file, wanted); });
}

} // namespace

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
