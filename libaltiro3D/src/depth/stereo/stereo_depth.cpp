#include "altiro3D/depth_source.hpp"

#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "base/text.hpp"
#include "depth/stereo/stereo_parts.hpp"
#include "image/picture_halves.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kMatchSide = 1000;       // px; longest side at which pictures are matched
constexpr double kMatchPixels = 7.5e5; // and most px
constexpr int kCoarseSide = 250;       // px; at which the range of disparities is found
constexpr double kSearch = 0.35;       // share of the width, to both sides of zero
constexpr double kMinMatched = 0.25;   // share of px
constexpr double kMinLikeness = 0.5;   // least correlation of matched detail of a pair
constexpr int kMinDetail = 4;          // grey levels beside the mean of the surroundings
constexpr double kFlatRange = 0.0015;  // share of the width
constexpr int kMinSide = 16;           // px; smaller pictures are not matched
constexpr int kUnknown = -32768;       // disparity
constexpr int kOne = 16;               // StereoSGBM counts in 1/16 px

// Disparities from `first` on, in px.
struct Range {
    int first = 0;
    int count = 16; // a multiple of 16
};

Range rangeAround(double smallest, double largest) {
    Range range;
    range.first = static_cast<int>(std::floor(smallest));
    const int needed = static_cast<int>(std::ceil(largest)) + 1 - range.first;
    range.count = std::max(16, (needed + 15) / 16 * 16);
    return range;
}

// The column of the right picture that shows column x of the left one.
int seenAt(int x, int disparity) {
    return x - (disparity + (disparity >= 0 ? kOne / 2 : -kOne / 2)) / kOne;
}

cv::Mat sized(const cv::Mat& picture, cv::Size size) {
    if (picture.size() == size) return picture;
    cv::Mat result;
    cv::resize(picture, result, size, 0, 0, cv::INTER_AREA);
    return result;
}

// The detail that the mean of 9 x 9 px leaves.
cv::Mat detailOf(const cv::Mat& grey) {
    cv::Mat mean;
    cv::boxFilter(grey, mean, CV_16S, {9, 9}, {-1, -1}, true,
                  cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
    cv::Mat detail;
    cv::subtract(grey, mean, detail, cv::noArray(), CV_16S);
    return detail;
}

// Correlation of the detail of matched px with their matches': smooth pictures match anyway.
double likenessOf(const cv::Mat& left, const cv::Mat& right, const cv::Mat& disparity) {
    const cv::Mat a = detailOf(left);
    const cv::Mat b = detailOf(right);
    std::int64_t sumAA = 0;
    std::int64_t sumBB = 0;
    std::int64_t sumAB = 0;
    for (int y = 0; y < disparity.rows; ++y) {
        const auto* const shift = disparity.ptr<std::int16_t>(y);
        const auto* const rowA = a.ptr<std::int16_t>(y);
        const auto* const rowB = b.ptr<std::int16_t>(y);
        for (int x = 0; x < disparity.cols; ++x) {
            if (shift[x] == kUnknown) continue;
            const int seen = seenAt(x, shift[x]);
            sumAA += rowA[x] * rowA[x];
            sumBB += rowB[seen] * rowB[seen];
            sumAB += rowA[x] * rowB[seen];
        }
    }
    if (sumAA == 0 || sumBB == 0) return 0;
    return static_cast<double>(sumAB) /
           std::sqrt(static_cast<double>(sumAA) * static_cast<double>(sumBB));
}

struct Light {
    double mean = 0;
    double deviation = 0;
};
Light lightOf(const cv::Mat& grey) {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(grey, mean, deviation);
    return {mean[0], deviation[0]};
}

// Gives a picture the mean and the deviation of another one.
cv::Mat withLightOf(const cv::Mat& picture, const cv::Mat& like) {
    const Light now = lightOf(picture);
    const Light wanted = lightOf(like);
    if (now.deviation < 1 || wanted.deviation < 1) return picture;
    const double gain = std::clamp(wanted.deviation / now.deviation, 0.5, 2.0);
    cv::Mat result;
    picture.convertTo(result, CV_8U, gain, wanted.mean - gain * now.mean);
    return result;
}

// The same for each channel.
cv::Mat withColoursOf(const cv::Mat& picture, const cv::Mat& like) {
    std::vector<cv::Mat> channels;
    std::vector<cv::Mat> wanted;
    cv::split(picture, channels);
    cv::split(like, wanted);
    for (std::size_t i = 0; i < channels.size(); ++i)
        channels[i] = withLightOf(channels[i], wanted[i]);
    cv::Mat result;
    cv::merge(channels, result);
    return result;
}

// Semi-global matching: for each px of `left` its disparity in 1/16 px, or kUnknown.
cv::Mat matchOneWay(const cv::Mat& left, const cv::Mat& right, const Range& range) {
    constexpr int kBlock = 5;
    constexpr int kArea = kBlock * kBlock;
    // the matcher leaves out columns that do not have the whole range beside them
    const int before = std::max(0, range.first + range.count);
    const int after = std::max(0, -range.first);
    cv::Mat wideLeft;
    cv::Mat wideRight;
    constexpr int kBorder = cv::BORDER_REPLICATE | cv::BORDER_ISOLATED;
    cv::copyMakeBorder(left, wideLeft, 0, 0, before, after, kBorder);
    cv::copyMakeBorder(right, wideRight, 0, 0, before, after, kBorder);
    const cv::Ptr<cv::StereoSGBM> matcher =
        cv::StereoSGBM::create(range.first, range.count, kBlock, 8 * kArea, 32 * kArea, -1, 63, 5,
                               0, 0, cv::StereoSGBM::MODE_SGBM);
    cv::Mat disparity;
    matcher->compute(wideLeft, wideRight, disparity);
    disparity = disparity.colRange(before, before + left.cols).clone();
    const auto outside = static_cast<std::int16_t>((range.first - 1) * kOne);
    disparity.setTo(cv::Scalar(kUnknown), disparity == outside);
    return disparity;
}

// Disparities of both pictures.
struct BothWays {
    cv::Mat left;  // [size of the picture, CV_16SC1, 1/16 px or kUnknown]
    cv::Mat right; // the same of the mirrored right picture
};

// Keeps the disparities that lead to a px which leads back.
// @param other disparities of the other picture, mirrored
void keepAgreed(cv::Mat& disparity, const cv::Mat& other) {
    for (int y = 0; y < disparity.rows; ++y) {
        auto* const to = disparity.ptr<std::int16_t>(y);
        const auto* const back = other.ptr<std::int16_t>(y);
        for (int x = 0; x < disparity.cols; ++x) {
            if (to[x] == kUnknown) continue;
            const int seen = seenAt(x, to[x]);
            const bool isInside = seen >= 0 && seen < disparity.cols;
            const int there = isInside ? back[disparity.cols - 1 - seen] : kUnknown;
            if (there == kUnknown || std::abs(there - to[x]) > kOne)
                to[x] = static_cast<std::int16_t>(kUnknown);
        }
    }
    cv::filterSpeckles(disparity, kUnknown, disparity.rows * disparity.cols / 4000, kOne);
}

// Matches in both directions; keeps what both agree on.
BothWays matchBothWays(const cv::Mat& left, const cv::Mat& right, const Range& range) {
    BothWays found;
    cv::Mat& forward = found.left;
    cv::Mat& backward = found.right;
    overRows(2, [&](int way) {
        if (way == 0) {
            forward = matchOneWay(left, right, range);
            return;
        }
        cv::Mat mirroredLeft;
        cv::Mat mirroredRight;
        cv::flip(left, mirroredLeft, 1);
        cv::flip(right, mirroredRight, 1);
        backward = matchOneWay(mirroredRight, mirroredLeft, range);
    });
    const cv::Mat all = forward.clone();
    keepAgreed(forward, backward);
    keepAgreed(backward, all);
    return found;
}

// The disparities of px with detail, sorted, in px: plain surfaces match anywhere.
std::vector<double> certainOf(const cv::Mat& disparity, const cv::Mat& grey) {
    const cv::Mat detail = detailOf(grey);
    std::vector<double> certain;
    for (int y = 0; y < disparity.rows; ++y) {
        const auto* const row = disparity.ptr<std::int16_t>(y);
        const auto* const details = detail.ptr<std::int16_t>(y);
        for (int x = 0; x < disparity.cols; ++x) {
            if (row[x] != kUnknown && std::abs(details[x]) >= kMinDetail)
                certain.push_back(static_cast<double>(row[x]) / kOne);
        }
    }
    std::sort(certain.begin(), certain.end());
    return certain;
}

// Leaves out disparities beyond a range in px.
void limit(cv::Mat& disparity, double low, double high) {
    for (std::int16_t& value : cv::Mat_<std::int16_t>(disparity)) {
        if (value < low * kOne || value > high * kOne) value = static_cast<std::int16_t>(kUnknown);
    }
}

double percentile(const std::vector<double>& sorted, double percent) {
    const auto last = static_cast<double>(sorted.size() - 1);
    return sorted[static_cast<std::size_t>(std::lround(percent / 100 * last))];
}

double matchedShareOf(const cv::Mat& disparity) {
    return cv::countNonZero(disparity != kUnknown) / static_cast<double>(disparity.total());
}

// The range of disparities at full size, from a small copy.
Range findRange(const cv::Mat& left, const cv::Mat& right) {
    const double scale =
        std::min(1.0, static_cast<double>(kCoarseSide) / std::max(left.cols, left.rows));
    const cv::Size size(std::max(1, cvRound(left.cols * scale)),
                        std::max(1, cvRound(left.rows * scale)));
    const cv::Mat smallLeft = sized(left, size);
    const cv::Mat smallRight = sized(right, size);
    const double most = kSearch * size.width;
    const std::vector<double> certain =
        certainOf(matchBothWays(smallLeft, smallRight, rangeAround(-most, most)).left, smallLeft);
    const double factor = static_cast<double>(left.cols) / size.width;
    if (certain.empty()) return rangeAround(-most * factor, most * factor);
    const double low = percentile(certain, 0.5);
    const double high = percentile(certain, 99.5);
    const double margin = 2 + 0.1 * (high - low);
    return rangeAround(std::max(low - margin, -most) * factor,
                       std::min(high + margin, most) * factor);
}

void toShares(const cv::Mat& disparity, cv::Mat& shares) {
    shares.create(disparity.size(), CV_32FC1);
    const double px = 1.0 / (static_cast<double>(kOne) * disparity.cols);
    for (int y = 0; y < disparity.rows; ++y) {
        const auto* const from = disparity.ptr<std::int16_t>(y);
        auto* const to = shares.ptr<float>(y);
        for (int x = 0; x < disparity.cols; ++x) {
            to[x] = from[x] == kUnknown ? std::numeric_limits<float>::quiet_NaN()
                                        : static_cast<float>(from[x] * px);
        }
    }
}

std::string percentText(double share) {
    return fixed(100 * share, 1) + " %";
}

} // namespace

HiddenLooks looksOfHidden(const cv::Mat& disparity, const cv::Mat& grey, double pixels) {
    constexpr double kMinStep = 3; // px of disparity
    constexpr int kEdge = 2;       // px beside a step, which the matcher smears
    constexpr int kSide = 4;       // px that are compared at each side
    const auto meanOf = [&grey](int y, int from, int to) {
        const std::uint8_t* const row = grey.ptr(y);
        int sum = 0;
        for (int x = from; x < to; ++x)
            sum += row[x];
        return static_cast<double>(sum) / (to - from);
    };
    HiddenLooks looks;
    for (int y = 0; y < disparity.rows; ++y) {
        const float* const row = disparity.ptr<float>(y);
        for (int x = 1; x < disparity.cols; ++x) {
            if (!std::isnan(row[x]) || std::isnan(row[x - 1])) continue;
            int end = x;
            while (end < disparity.cols && std::isnan(row[end]))
                ++end;
            if (end == disparity.cols) break;
            constexpr double kRounding = 0.01;
            const double step =
                std::floor(static_cast<double>(row[end] - row[x - 1]) * pixels + kRounding);
            const int width = end - x;
            const bool isHidden = step >= kMinStep && width >= step / 2 - 0.5 && width <= 2 * step;
            const int first = x - kEdge - kSide;
            const int last = end + kEdge + kSide;
            if (isHidden && width > kEdge && first >= 0 && last <= disparity.cols) {
                const double hidden = meanOf(y, x, end);
                const double left = std::abs(meanOf(y, first, first + kSide) - hidden);
                const double right = std::abs(meanOf(y, last - kSide, last) - hidden);
                if (left < right) ++looks.behind;
                if (right < left) ++looks.front;
            }
            x = end;
        }
    }
    return looks;
}

RowDisparities matchRows(const cv::Mat& left, const cv::Mat& right, double low, double high) {
    const BothWays both = matchBothWays(left, right, rangeAround(low, high));
    RowDisparities found;
    cv::Mat mirrored;
    toShares(both.left, found.left);
    toShares(both.right, mirrored);
    cv::flip(mirrored, found.right, 1);
    found.left *= left.cols;
    found.right *= left.cols;
    return found;
}

std::string StereoMatch::text() const {
    std::string line = "shift " + percentText(shift) + ", " +
                       std::to_string(static_cast<int>(std::lround(100 * matchedShare))) +
                       " % matched";
    if (isFlat) line += ", flat";
    if (std::abs(verticalOffset) > 0.002)
        line += ", the right picture " + percentText(std::abs(verticalOffset)) +
                (verticalOffset > 0 ? " lower" : " higher");
    if (std::abs(rollDegrees) > 0.3) line += ", turned by " + numberText(rollDegrees, 2) + "°";
    return line;
}

Notes StereoMatch::remarks(const std::string& pair) const {
    Notes notes;
    if (!isReliable) {
        notes.push_back(
            {NoteCode::LeftOut, "the stereo pair (" + pair +
                                    ") is not used, because its pictures do not match (" + text() +
                                    "): the left eye's picture alone is shown"});
    } else if (looksSwapped) {
        notes.push_back({NoteCode::Doubtful,
                         "the eyes of the stereo pair (" + pair +
                             ") look swapped: the background appears in front of the foreground"});
    }
    return notes;
}

StereoMatch matchStereo(const cv::Mat& left, const cv::Mat& right, cv::Mat& disparity,
                        HiddenLayer* hidden) try {
    if (hidden != nullptr) *hidden = {};
    checkType(left, {CV_8UC3}, "left", "CV_8UC3 (8-bit BGR)");
    checkType(right, {CV_8UC3}, "right", "CV_8UC3 (8-bit BGR)");
    if (!canBeEyes(left.size(), right.size())) {
        throw Error(ErrorCode::Mismatch, "right",
                    "has " + sizeText(right.size()) + ", expected the shape of the left " +
                        sizeText(left.size()));
    }
    const double scale =
        std::min({1.0, static_cast<double>(kMatchSide) / std::max(left.cols, left.rows),
                  std::sqrt(kMatchPixels / (static_cast<double>(left.cols) * left.rows))});
    const cv::Size size(std::max(1, cvRound(left.cols * scale)),
                        std::max(1, cvRound(left.rows * scale)));
    StereoMatch match;
    const cv::Mat smallLeft = sized(left, size);
    const cv::Mat greyLeft = greyOf(smallLeft);
    cv::Mat smallRight = sized(right, size);
    cv::Mat greyRight = greyOf(smallRight);
    const auto flat = [&] {
        disparity.create(size, CV_32FC1);
        disparity.setTo(cv::Scalar(match.shift));
        match.isFlat = true;
        return match;
    };
    const auto isPlain = [](const cv::Mat& grey) { return lightOf(grey).deviation < 1; };
    if (std::min(size.width, size.height) < kMinSide || isPlain(greyLeft) || isPlain(greyRight))
        return flat();
    greyRight = withLightOf(greyRight, greyLeft);
    const RowFit rows = fitRows(greyLeft, greyRight);
    greyRight = moveRows(greyRight, rows);
    match.verticalOffset = rows.offset / size.width;
    match.rollDegrees = std::atan(rows.slope) * 180 / CV_PI;

    BothWays both = matchBothWays(greyLeft, greyRight, findRange(greyLeft, greyRight));
    cv::Mat& found = both.left;
    const std::vector<double> certain = certainOf(found, greyLeft);
    if (!certain.empty()) {
        const double low = percentile(certain, 0.2);
        const double high = percentile(certain, 99.8);
        const double margin = 1 + 0.1 * (high - low);
        limit(found, low - margin, high + margin);
        limit(both.right, low - margin, high + margin);
    }
    match.matchedShare = matchedShareOf(found);
    match.likeness = likenessOf(greyLeft, greyRight, found);
    match.isReliable = match.matchedShare >= kMinMatched && match.likeness >= kMinLikeness;
    if (certain.empty()) return flat();
    match.shift = percentile(certain, 50) / size.width;
    match.farthest = percentile(certain, 0.5) / size.width;
    match.nearest = percentile(certain, 99.5) / size.width;
    if (match.nearest - match.farthest < kFlatRange) return flat();
    toShares(found, disparity);
    constexpr std::int64_t kFewest = 100;
    const HiddenLooks looks = looksOfHidden(disparity, greyLeft, size.width);
    match.looksSwapped = looks.front + looks.behind >= kFewest && looks.front > 2 * looks.behind;
    fillFromBehind(disparity, smallLeft);
    if (hidden != nullptr && match.isReliable && matchedShareOf(both.right) > 0) {
        cv::Mat mirrored;
        cv::Mat mirroredDisparity;
        cv::Mat rightDisparity;
        smallRight = moveRows(withColoursOf(smallRight, smallLeft), rows);
        cv::flip(smallRight, mirrored, 1);
        toShares(both.right, mirroredDisparity);
        fillFromBehind(mirroredDisparity, mirrored);
        cv::flip(mirroredDisparity, rightDisparity, 1);
        *hidden = hiddenByRight(smallRight, disparity, rightDisparity);
    }
    return match;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
