#pragma once

#include "viewer/model/document.hpp"

#include <cstddef>
#include <optional>
#include <random>
#include <vector>

namespace altiro3D::viewer {

/// Whether two sources are the same: their file and depth are.
inline bool isSame(const Source& a, const Source& b) {
    return a.file == b.file && a.depth == b.depth;
}

/// The files of a show in the order in which they are shown, and the place in it. Files may join
/// and leave while the show runs.
class ShowList {
  public:
    /// @param shuffles shows the files in random order, each once before any is shown again
    /// @param loops begins again after the last file
    /// @param seed of the random order
    ShowList(bool shuffles, bool loops, unsigned seed);

    /// Sets the files, in their natural order. The current file stays current; if it is gone,
    /// next() goes to the file that would have followed. With `shuffles` new files join the present
    /// round.
    void set(const std::vector<Source>& files);

    std::size_t size() const { return order_.size(); }
    /// The file at the present place. Nothing if there are no files, or its file has gone.
    std::optional<Source> current() const;
    /// What next() and previous() would make current. Nothing at the ends if the list does not
    /// loop.
    std::optional<Source> following();
    std::optional<Source> preceding() const;
    /// Goes on or back. @return false at the end: the place stays
    bool next();
    bool previous();

  private:
    std::vector<Source> round(); // a new order of all files
    std::size_t nextIndex() const;

    bool shuffles_;
    bool loops_;
    std::mt19937 random_;
    std::vector<Source> order_;
    std::vector<Source> nextRound_; // empty: not yet decided
    std::size_t at_ = 0;            // of order_; the file itself, or the one that follows it
    bool isGone_ = true;            // the current file has gone, or there was none yet
};

} // namespace altiro3D::viewer
