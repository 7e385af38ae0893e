#include "altiro3D/quilt2native.hpp"

#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "image/pixel_values.hpp"
#include "native/quilt_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

// All sums are of whole numbers, or of doubles in a fixed order: the result does not depend on the
// processor or on the number of threads.
//
// The constants were chosen on 160 quilts (6 real ones, the others of 22 photos and of drawings, in
// 18 layouts, scaled, cropped and compressed) and 117 other pictures. Neighbouring views of photos
// have a likeness of 0.77 or more; parts of photos 0.2 or less; framed contact sheets about 0.6.

namespace altiro3D {

namespace {

constexpr int kWorkSide = 1024;   // px of the picture that is searched
constexpr int kMinSide = 128;     // px of a picture that can be searched
constexpr int kMaxTiles = 20;     // per side
constexpr int kMinTile = 20;      // px of a tile in the picture that is searched
constexpr int kTile = 48;         // px of a side of the tiles that are compared
constexpr int kStrip = 128;       // px of the long side of columns or rows that are compared
constexpr int kRadius = 8;        // px of the window that removes brightness and contrast
constexpr int kMaxShift = 3;      // px by which views may be shifted against each other
constexpr int kMaxRowShift = 5;   // the same from row to row, where errors of the columns add up
constexpr int kMaxCandidates = 5; // columns and rows that are tried together

constexpr double kQuickColumns = 0.5; // likeness of columns of views at a quick look at least
constexpr double kMinColumns = 0.45;  // likeness of columns of views at least
constexpr double kMinRows = 0.2;      // likeness of rows, between which the camera moves far
constexpr double kCandidate = 0.55;   // share of the best likeness
constexpr double kFinerMargin = 0.12;
constexpr double kClearBorder = 6;    // grey levels
constexpr double kBorderShare = 0.35; // share of the clearest border
constexpr double kMinConfidence = 0.6;
constexpr double kMinLikeness = 0.35; // below, nothing is alike
constexpr double kMinGap = 0.1;       // to another layout
constexpr double kMinDetail = 0.05;   // share of a view that is not a pattern of rows and columns

// Whether there is nothing to compare.
bool isEven(const cv::Mat_<uchar>& grey) {
    double darkest = 0;
    double lightest = 0;
    cv::minMaxLoc(grey, &darkest, &lightest);
    return lightest - darkest < kNoise;
}

// One count of columns or of rows.
struct Count {
    int count = 0;
    double likeness = 0; // likeness of neighbouring columns, or rows
    double border = 0;   // grey levels by which their borders stand out
};

// Mean difference of neighbouring columns, grey levels.
std::vector<double> columnSteps(const cv::Mat_<uchar>& grey) {
    std::vector<std::int64_t> sums(static_cast<std::size_t>(grey.cols) - 1);
    for (int y = 0; y < grey.rows; ++y) {
        const uchar* row = grey[y];
        for (std::size_t x = 0; x < sums.size(); ++x)
            sums[x] += std::abs(row[x + 1] - row[x]);
    }
    std::vector<double> steps;
    for (const std::int64_t sum : sums)
        steps.push_back(static_cast<double>(sum) / grey.rows);
    return steps;
}

// By how much the borders between `count` columns stand out: the median of all.
double borderOf(const std::vector<double>& steps, int count) {
    constexpr int kOff = 2;     // px that a border may be off
    constexpr int kAround = 14; // px that it is compared with
    const int last = static_cast<int>(steps.size()) - 1;
    std::vector<double> heights;
    std::vector<double> around;
    for (int i = 1; i < count; ++i) {
        const double place = static_cast<double>(i) * (last + 2) / count - 1;
        const int low = static_cast<int>(std::floor(place - kOff + 0.5));
        const int high = static_cast<int>(std::ceil(place + kOff - 0.5));
        const auto at = [&](int x) { return steps.begin() + std::clamp(x, 0, last + 1); };
        const double height = *std::max_element(at(low), at(high + 1));
        around.assign(at(low - kAround), at(high + kAround + 1));
        heights.push_back(std::max(0.0, height - valueOfRank(around, around.size() * 3 / 4)));
    }
    return valueOfRank(heights, heights.size() / 2);
}

// The counts of columns for which neighbouring columns are alike, likeliest first.
// @param weakest likeness at least
std::vector<Count> columnCounts(const cv::Mat_<uchar>& grey, double weakest) {
    const Grey flat = turned(scaleRows(turned(grey), kStrip, kUnit));
    const int most = std::min(kMaxTiles, grey.cols / kMinTile);
    if (most < 2) return {};
    std::vector<Count> counts(static_cast<std::size_t>(most) - 1);
    overRows(most - 1, [&](int index) {
        const int count = index + 2;
        const Tiles columns(scaleRows(flat, count * kTile, 1), {kTile, kStrip}, kRadius);
        std::vector<std::pair<int, int>> pairs;
        for (int i = 0; i + 1 < count; ++i)
            pairs.emplace_back(i, i + 1);
        counts[static_cast<std::size_t>(index)] = {count, columns.likeness(pairs, kMaxShift), 0};
    });
    std::stable_sort(counts.begin(), counts.end(),
                     [](const Count& a, const Count& b) { return a.likeness > b.likeness; });
    if (counts.front().likeness < weakest) return {};
    const double least = kCandidate * counts.front().likeness;
    const std::vector<double> steps = columnSteps(grey);
    std::vector<Count> good;
    for (Count& count : counts) {
        if (count.likeness < least || good.size() == kMaxCandidates) break;
        count.border = borderOf(steps, count.count);
        good.push_back(count);
    }
    return good;
}

// A layout that the picture may have.
struct Candidate {
    Count columns;
    Count rows;
    double likeness = 0; // likeness of neighbouring views
    double detail = 0;

    double upward = 0; // likeness where a row goes on in the row above
    double turned = 0; // the same if it went on in the row below

    int tiles() const { return columns.count * rows.count; }
    // Each tile of `other` consists of whole tiles of this layout.
    bool divides(const Candidate& other) const {
        return columns.count % other.columns.count == 0 && rows.count % other.rows.count == 0;
    }
};

// @param missing views that are not compared
Candidate examine(const cv::Mat_<uchar>& grey, const Count& columns, const Count& rows,
                  const std::vector<int>& missing = {}) {
    Candidate candidate{columns, rows, 0, 0, 0, 0};
    const Grey wide = scaleRows(grey, columns.count * kTile, kUnit);
    const Tiles tiles(turned(scaleRows(turned(wide), rows.count * kTile, 1)), {kTile, kTile},
                      kRadius);
    std::vector<std::pair<int, int>> inRows;
    std::vector<std::pair<int, int>> betweenRows;
    std::vector<std::pair<int, int>> betweenTurned;
    const auto add = [&missing](std::vector<std::pair<int, int>>& pairs, int a, int b) {
        const auto isMissing = [&](int view) {
            return std::find(missing.begin(), missing.end(), view) != missing.end();
        };
        if (!isMissing(a) && !isMissing(b)) pairs.emplace_back(a, b);
    };
    for (int view = 0; view + 1 < candidate.tiles(); ++view)
        add((view + 1) % columns.count == 0 ? betweenRows : inRows, view, view + 1);
    for (int first = 0; first + columns.count < candidate.tiles(); first += columns.count)
        add(betweenTurned, first + 2 * columns.count - 1, first);
    candidate.turned = tiles.likeness(betweenTurned, kMaxRowShift);
    candidate.upward = tiles.likeness(betweenRows, kMaxRowShift);
    candidate.likeness = tiles.likeness(inRows, kMaxShift);
    if (rows.count > 1) candidate.likeness = std::min(candidate.likeness, candidate.upward);
    if (candidate.likeness >= kMinLikeness) candidate.detail = tiles.detail();
    return candidate;
}

// Where views continue after a row; in a quilt, in the row above. Clear only if the camera moves.
enum class RowOrder { Upward, Downward, Unclear };

RowOrder rowOrder(const Candidate& candidate) {
    constexpr double kClear = 0.002;    // measured on real quilts: 0.01 to 0.1
    constexpr double kRecoded = 0.0005; // by compression
    constexpr double kEqual = 0.995;    // all views are equal: the order does not matter
    const double lead = candidate.upward - candidate.turned;
    if (candidate.rows.count == 1 || lead > kClear) return RowOrder::Upward;
    if (lead < -kRecoded) return RowOrder::Downward;
    return candidate.upward > kEqual ? RowOrder::Upward : RowOrder::Unclear;
}

void sortBestFirst(std::vector<Candidate>& candidates) {
    std::stable_sort(
        candidates.begin(), candidates.end(),
        [](const Candidate& a, const Candidate& b) { return a.likeness > b.likeness; });
}

// Quilts of one row, best first. Photos side by side, such as stereo pairs, have fewer columns.
std::vector<Candidate> singleRows(const cv::Mat_<uchar>& grey, const std::vector<Count>& columns) {
    constexpr int kFewest = 4;
    constexpr double kAlike = 0.85;
    std::vector<Candidate> found;
    for (const Count& count : columns) {
        if (count.count < kFewest || count.likeness < kAlike) continue;
        const Candidate candidate = examine(grey, count, Count{1, 0, 0});
        if (candidate.likeness >= kAlike && candidate.detail >= kMinDetail)
            found.push_back(candidate);
    }
    sortBestFirst(found);
    return found;
}

// The finest layout that is as good as the best one: a quilt is also alike if two tiles, or two
// rows, are taken as one.
// @param all best first
const Candidate& finest(const std::vector<Candidate>& all) {
    const Candidate& best = all.front();
    double clearColumns = kClearBorder;
    double clearRows = kClearBorder;
    const double least = best.likeness - kFinerMargin;
    for (const Candidate& candidate : all) {
        if (candidate.likeness < least) break;
        clearColumns = std::max(clearColumns, candidate.columns.border);
        clearRows = std::max(clearRows, candidate.rows.border);
    }
    const auto hasBorders = [&](const Candidate& candidate) {
        return (clearColumns == kClearBorder ||
                candidate.columns.border >= kBorderShare * clearColumns) &&
               (clearRows == kClearBorder || candidate.rows.border >= kBorderShare * clearRows);
    };
    const Candidate* found = &best;
    for (const Candidate& candidate : all) {
        if (candidate.likeness < least) break;
        if (candidate.divides(best) && candidate.tiles() > found->tiles() && hasBorders(candidate))
            found = &candidate;
    }
    return *found;
}

// All layouts of more than one row that the picture may have, best first.
std::vector<Candidate> candidatesOf(const cv::Mat_<uchar>& grey,
                                    const std::vector<Count>& columns) {
    const std::vector<Count> rows = columnCounts(turned(grey), kMinRows);
    std::vector<Candidate> candidates(columns.size() * rows.size());
    overRows(static_cast<int>(candidates.size()), [&](int i) {
        const auto index = static_cast<std::size_t>(i);
        candidates[index] = examine(grey, columns[index / rows.size()], rows[index % rows.size()]);
    });
    sortBestFirst(candidates);
    return candidates;
}

// Whether no rows of views are found. If there are some, a single row would fit as well.
bool mayBeOneRow(const std::vector<Candidate>& candidates) {
    if (candidates.empty()) return true;
    return finest(candidates).likeness < kMinConfidence &&
           std::all_of(candidates.begin(), candidates.end(), [](const Candidate& candidate) {
               return candidate.rows.likeness < kMinColumns;
           });
}

// A quick look at some of the rows, which recognizes most photos: 2 ms instead of 20 ms for 12
// megapixels. Columns are alike if the picture is like itself when shifted by the width of one.
bool mayBeQuilt(const cv::Mat& picture) {
    constexpr int kSide = 512;  // px
    constexpr int kColumn = 24; // px of a column at least
    constexpr int kHeight = 64; // px to which the picture is squeezed
    constexpr int kWindow = 4;  // px, as kRadius
    constexpr int kPart = 8;    // views may be shifted by this part of their width
    // fewest and most columns that are searched in a picture of one size
    constexpr std::pair<int, int> kSizes[] = {{2, 3}, {4, 6}, {7, 11}, {12, kMaxTiles}};
    const int step = std::max(1, 2 * picture.rows / kSide);
    const cv::Mat some(picture.rows / step, picture.cols, picture.type(), picture.data,
                       picture.step[0] * static_cast<std::size_t>(step));
    const cv::Mat_<uchar> grey = brightnessOf(downscale(some, kSide));
    if (isEven(grey)) return true; // nothing to tell it by
    const Grey flat = turned(scaleRows(turned(grey), kHeight, kUnit));
    return std::any_of(std::begin(kSizes), std::end(kSizes), [&](const auto& counts) {
        const int width = counts.second * kColumn;
        const Tiles whole(scaleRows(flat, width, 1), {width, kHeight}, kWindow);
        for (int count = counts.first; count <= counts.second; ++count) {
            const cv::Range shifts(width * (kPart - 1) / (kPart * count),
                                   width * (kPart + 1) / (kPart * count) + 2);
            if (whole.likeness({{0, 0}}, shifts) >= kQuickColumns) return true;
        }
        return false;
    });
}

} // namespace

FoundQuilt findQuiltLayout(const cv::Mat& picture) try {
    checkType(picture, {CV_8UC3}, "picture", "CV_8UC3 (8-bit BGR)");
    FoundQuilt found;
    if (std::min(picture.cols, picture.rows) < kMinSide) {
        found.verdict = QuiltVerdict::Unsure;
        return found;
    }
    if (!mayBeQuilt(picture)) return found;
    const cv::Mat_<uchar> grey = brightnessOf(downscale(picture, kWorkSide));
    if (isEven(grey)) {
        found.verdict = QuiltVerdict::Unsure; // nothing to compare
        return found;
    }
    const std::vector<Count> columns = columnCounts(grey, kMinColumns);
    if (columns.empty()) return found;
    std::vector<Candidate> candidates = candidatesOf(grey, columns);
    if (mayBeOneRow(candidates)) {
        std::vector<Candidate> rows = singleRows(grey, columns);
        if (!rows.empty()) candidates = std::move(rows);
    }
    if (candidates.empty()) return found;
    const Candidate& quilt = finest(candidates);
    found.confidence = std::clamp(quilt.likeness, 0.0, 1.0);
    if (found.confidence < kMinLikeness) return found;
    double other = 0;
    for (const Candidate& candidate : candidates) {
        if (!candidate.divides(quilt) && !quilt.divides(candidate))
            other = std::max(other, candidate.likeness);
    }
    found.confidence *= std::clamp((quilt.likeness - other) / kMinGap, 0.0, 1.0);
    found.confidence *= std::min(1.0, quilt.detail / kMinDetail);
    found.verdict = found.confidence >= kMinConfidence ? QuiltVerdict::Quilt : QuiltVerdict::Unsure;
    found.layout = {quilt.columns.count,
                    quilt.rows.count,
                    {picture.cols / quilt.columns.count, picture.rows / quilt.rows.count},
                    quilt.tiles()};
    if (found.verdict == QuiltVerdict::Quilt && rowOrder(quilt) != RowOrder::Upward) {
        found.verdict = QuiltVerdict::Unsure;
        found.isFromTop = rowOrder(quilt) == RowOrder::Downward;
    }
    return found;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

Notes checkQuiltLayout(const cv::Mat& picture, const QuiltLayout& layout) try {
    checkType(picture, {CV_8UC3}, "picture", "CV_8UC3 (8-bit BGR)");
    validate(layout);
    constexpr int kMinSideOfView = 16;   // px
    constexpr double kClear = 0.002;     // as of rowOrder()
    constexpr double kBlack = 8;         // grey levels
    constexpr double kMaxOfPhoto = 0.25; // likeness of parts of a photo
    Notes notes;
    const cv::Mat_<uchar> grey = brightnessOf(downscale(picture, kWorkSide));
    const cv::Size size(grey.cols / layout.columns, grey.rows / layout.rows);
    if (layout.viewCount < 2 || std::min(size.width, size.height) < kMinSideOfView) return notes;
    std::vector<int> black;
    std::vector<int> plain;
    std::vector<cv::Scalar> colours;
    for (int view = 0; view < layout.viewCount; ++view) {
        const cv::Point place(view % layout.columns, layout.rows - 1 - view / layout.columns);
        const auto inside = [&](cv::Size all, int rim) { // neighbours reach into the rim
            return cv::Rect(place.x * all.width / layout.columns + rim,
                            place.y * all.height / layout.rows + rim,
                            all.width / layout.columns - 2 * rim,
                            all.height / layout.rows - 2 * rim);
        };
        const cv::Mat_<uchar> tile = grey(inside(grey.size(), 2));
        colours.push_back(cv::mean(picture(inside(picture.size(), 0))));
        if (isEven(tile)) plain.push_back(view);
        if (cv::norm(tile, cv::NORM_INF) <= kBlack) black.push_back(view);
    }
    // plain tiles may number the views; black ones among them show nothing
    const auto areFew = [&](const std::vector<int>& views) {
        return !views.empty() && 2 * static_cast<int>(views.size()) < layout.viewCount;
    };
    const std::vector<int> missing = areFew(plain)   ? plain
                                     : areFew(black) ? black
                                                     : std::vector<int>();
    std::string names;
    for (const int view : missing)
        names += (names.empty() ? "" : ", ") + std::to_string(view);
    if (!missing.empty())
        notes.push_back(
            {NoteCode::AsItIs,
             "of its views 0 to " + std::to_string(layout.viewCount - 1) + " there is nothing in " +
                 names + ": they have one colour, which the display shows in their directions"});
    if (std::min(picture.cols, picture.rows) < kMinSide) return notes;
    const Candidate stated = examine(grey, {layout.columns, 0, 0}, {layout.rows, 0, 0}, missing);
    // Colours change slowly from view to view, in all rows.
    int steps = 0;
    int turnedSteps = 0;
    for (int first = 0; first + 2 * layout.columns <= layout.viewCount; first += layout.columns) {
        const auto at = [&](int view) { return colours[static_cast<std::size_t>(first + view)]; };
        const double upward = cv::norm(at(layout.columns - 1) - at(layout.columns));
        const double downward = cv::norm(at(0) - at(2 * layout.columns - 1));
        ++steps;
        if (upward > 3 * downward + 1.5) ++turnedSteps;
    }
    if ((stated.turned > kMinConfidence && stated.turned > stated.upward + kClear) ||
        (steps > 1 && turnedSteps == steps)) {
        notes.push_back({NoteCode::Doubtful,
                         "its rows of views seem to run from the top to the bottom, expected the "
                         "first view at the bottom left: the depth jumps from row to row"});
    } else if (stated.likeness < kMinLikeness && missing.empty()) {
        const FoundQuilt found = findQuiltLayout(picture);
        if (found.verdict == QuiltVerdict::NoQuilt && stated.likeness < kMaxOfPhoto)
            notes.push_back({NoteCode::Doubtful,
                             "its parts do not look like views of one scene: it may be a photo"});
        if (found.verdict == QuiltVerdict::Quilt)
            notes.push_back({NoteCode::Doubtful,
                             "its parts do not look like views in " + std::to_string(layout.rows) +
                                 " rows of " + std::to_string(layout.columns) + ", but in " +
                                 std::to_string(found.layout.rows) + " rows of " +
                                 std::to_string(found.layout.columns) + " (-q " +
                                 std::to_string(found.layout.rows) + "x" +
                                 std::to_string(found.layout.columns) + ")"});
    }
    return notes;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

double likenessOfViews(const std::vector<cv::Mat>& pictures) try {
    const auto count = static_cast<int>(pictures.size());
    Grey strip(kTile, count * kTile);
    std::vector<std::pair<int, int>> pairs;
    for (int i = 0; i < count; ++i) {
        const cv::Mat& picture = pictures[static_cast<std::size_t>(i)];
        checkType(picture, {CV_8UC3}, "picture", "CV_8UC3 (8-bit BGR)");
        const Grey wide =
            scaleRows<uchar>(brightnessOf(downscale(picture, kWorkSide)), kTile, kUnit);
        turned(scaleRows(turned(wide), kTile, 1))
            .copyTo(strip.colRange(i * kTile, (i + 1) * kTile));
        if (i > 0) pairs.emplace_back(i - 1, i);
    }
    if (pairs.empty()) return 1;
    const double likeness = Tiles(strip, {kTile, kTile}, kRadius).likeness(pairs, kMaxRowShift);
    return likeness == -1 ? 1 : std::clamp(likeness, 0.0, 1.0);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
