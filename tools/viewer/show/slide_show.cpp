#include "viewer/show/slide_show.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "cli/folders.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <system_error>
#include <utility>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

bool holds(const std::vector<Source>& files, const Source& wanted) {
    return std::find(files.begin(), files.end(), wanted) != files.end();
}

template <class Item, class Condition>
void eraseIf(std::vector<Item>& items, const Condition& condition) {
    items.erase(std::remove_if(items.begin(), items.end(), condition), items.end());
}

tools::FolderContents contentsOf(const fs::path& folder) {
    using tools::FileKind;
    tools::FolderSearch how;
    how.wanted = {FileKind::Photo, FileKind::Quilt, FileKind::Native, FileKind::Video,
                  FileKind::QuiltVideo};
    return tools::searchFolder(folder, how);
}

FileStamps stampsOf(const std::vector<fs::path>& folders) {
    FileStamps stamps;
    for (const fs::path& folder : folders) {
        std::error_code error;
        fs::directory_iterator entry(folder, error);
        while (!error && entry != fs::directory_iterator()) {
            stamps[entry->path()] = fileStamp(entry->path());
            entry.increment(error);
        }
    }
    return stamps;
}

} // namespace

SlideShow::SlideShow(const Settings& settings, Work work)
    : settings_(settings), work_(std::move(work)),
      list_(settings.shuffles, settings.loops, settings.seed) {}

void SlideShow::setFiles(const std::vector<Source>& files) {
    all_ = files;
    // A file that has gone may come back mended.
    eraseIf(failed_, [&](const Source& failed) { return !holds(files, failed); });
    files_ = files;
    eraseIf(files_, [&](const Source& file) { return holds(failed_, file); });
    list_.set(files_);
    if (wanted_ && !holds(files_, *wanted_)) wanted_.reset();
    if (!files_.empty()) isOver_ = false;
}

void SlideShow::put(const Slide& slide) {
    if (making_ != slide.source) return; // nobody waits for it any more
    making_.reset();
    if (slide.problem.empty()) return kept_.push_back(slide);
    work_.report(slide.problem);
    failed_.push_back(slide.source);
    if (wanted_ == slide.source) wanted_.reset();
    setFiles(std::vector<Source>(all_));
}

const Slide* SlideShow::ready(const Source& source) const {
    if (shown_ && shown_->source == source) return &*shown_;
    for (const Slide& slide : kept_)
        if (slide.source == source) return &slide;
    return nullptr;
}

void SlideShow::show(const Slide& slide) {
    const Slide now = slide; // which may lie in kept_
    if (shown_) {
        if (settings_.fade > 0 && shown_->native.size() == now.native.size())
            before_ = shown_->native;
        if (shown_->source != now.source) kept_.push_back(*shown_);
    }
    shown_ = now;
    eraseIf(kept_, [&](const Slide& kept) { return kept.source == now.source; });
    since_ = fadeSince_ = now_;
    ++changes_;
}

void SlideShow::endVideo() {
    if (!list_.following())
        isOver_ = true;
    else if (!wanted_)
        next();
}

void SlideShow::request() {
    if (making_) return;
    for (const std::optional<Source>& source : {wanted_, list_.following()}) {
        if (!source || ready(*source) != nullptr) continue;
        making_ = source;
        return work_.make(*source);
    }
}

void SlideShow::prune() {
    const std::optional<Source> following = list_.following();
    const std::optional<Source> preceding = list_.preceding();
    eraseIf(kept_, [&](const Slide& slide) {
        return wanted_ != slide.source && following != slide.source && preceding != slide.source;
    });
}

void SlideShow::tick(double now) {
    if (isPaused_) since_ += now - now_;
    now_ = now;
    if (isOver_) return;
    if (!before_.empty() && now_ - fadeSince_ >= settings_.fade) before_.release();
    const bool isTimeUp = shown_ && !shown_->isVideo() && now_ - since_ >= settings_.each;
    if (!wanted_ && (!shown_ || (isTimeUp && !isPaused_))) {
        if (!list_.following()) {
            // In a list that loops, a single file stays; a folder that is empty now may fill again.
            isOver_ = !settings_.loops || (files_.empty() && !shown_);
            return;
        }
        next();
    }
    if (const Slide* slide = wanted_ ? ready(*wanted_) : nullptr) {
        wanted_.reset();
        show(*slide);
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
        order_ = files;
        at_ = kept.empty() ? 0 : order_.size();
        for (std::size_t i = 0; place < kept.size() && i < order_.size(); ++i)
            if (order_[i] == kept[place]) at_ = i;
    } else {
        order_ = kept;
        at_ = place;
    }
    isGone_ = !now || !holds(order_, *now);
    if (!shuffles_) return;
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

std::vector<Source> ShowList::round() {
    std::vector<Source> files = order_;
    if (!shuffles_) return files;
    std::shuffle(files.begin(), files.end(), random_);
    // not the same file twice in a row
    if (const auto now = current(); now && files.size() > 1 && files.front() == *now)
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

std::set<fs::path> SteadyFiles::look(const FileStamps& stamps, double now) {
    std::map<fs::path, Known> known;
    std::set<fs::path> steady;
    isWaiting_ = false;
    for (const auto& [file, stamp] : stamps) {
        Known entry{stamp, hasLooked_ ? now : now - kSeconds};
        const auto before = known_.find(file);
        if (before != known_.end() && before->second.stamp == stamp)
            entry.since = before->second.since;
        if (now - entry.since >= kSeconds)
            steady.insert(file);
        else
            isWaiting_ = true;
        known.emplace(file, entry);
    }
    known_.swap(known);
    hasLooked_ = true;
    return steady;
}

ShowFiles::ShowFiles(const std::vector<fs::path>& names) {
    std::optional<Error> problem; // the first one
    const auto leaveOut = [&](const Error& error) {
        if (!problem) problem = error;
        notes_.push_back({NoteCode::LeftOut, error.what()});
    };
    for (const fs::path& name : names) {
        std::error_code error;
        const bool exists = fs::exists(name, error);
        if (error) {
            leaveOut({ErrorCode::ReadFailed, name.string(), "cannot be read: " + error.message()});
        } else if (!exists) {
            leaveOut({ErrorCode::NotFound, name.string(),
                      "does not exist, expected a file or a folder"});
        } else if (names_.push_back(name); fs::is_directory(name, error)) {
            folders_.push_back(name);
            const tools::FolderContents found = contentsOf(name);
            if (found.files.empty()) {
                leaveOut({ErrorCode::NotFound, name.string(),
                          "holds no pictures and no videos, expected some"});
            } else if (!found.leftOut.empty()) {
                notes_.push_back({NoteCode::LeftOut, name.string() + ": not opened: " +
                                                         tools::kindsText(found.leftOut)});
            }
        }
    }
    static_cast<void>(refresh(0));
    if (files_.empty() && problem) throw Error(*problem);
}

bool ShowFiles::refresh(double now) {
    FileStamps stamps = stampsOf(folders_);
    const bool wasWaiting = steady_.isWaiting();
    const std::set<fs::path> steady = steady_.look(stamps, now);
    if (stamps == stamps_ && !wasWaiting && !files_.empty()) return true;
    stamps_ = std::move(stamps);
    std::vector<Source> files;
    std::vector<fs::path> single; // a photo and its depth image may be named one after the other
    const auto addSingle = [&] {
        for (const Source& source : pairUp(single))
            files.push_back(source);
        single.clear();
    };
    for (const fs::path& name : names_) {
        if (std::find(folders_.begin(), folders_.end(), name) == folders_.end()) {
            if (tools::isThere(name)) single.push_back(name);
            continue;
        }
        addSingle();
        tools::FolderContents found;
        try {
            found = contentsOf(name);
        } catch (const Error&) { // nothing to show now
        }
        for (const tools::FolderFile& file : found.files) {
            if (steady.count(file.file) == 0) continue;
            const bool hasDepth = steady.count(file.depth) > 0;
            files.push_back({file.file, hasDepth ? file.depth : fs::path(), Reading::Automatic});
        }
    }
    addSingle();
    files_ = files;
    return !steady_.isWaiting();
}

} // namespace altiro3D::viewer
