#include "altiro3D/depth_map.hpp"
#include "altiro3D/image_io.hpp"
#include "base/checks.hpp"
#include "image/image_read.hpp"
#include "image/picture_halves.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace altiro3D {

namespace {

bool isBeside(DepthSide side) {
    return side == DepthSide::Right || side == DepthSide::Left;
}

// The halves by what they hold.
struct Halves {
    cv::Rect photo;
    cv::Rect depth;
};
Halves halvesOf(DepthSide side, cv::Size whole, int gap = 0) {
    const HalfPlaces places = halfPlaces(whole, isBeside(side), gap);
    const bool isDepthLast = side == DepthSide::Right || side == DepthSide::Bottom;
    return isDepthLast ? Halves{places.first, places.second} : Halves{places.second, places.first};
}

// Share of white px in a column.
double whiteShare(const cv::Mat& picture, int column) {
    const double least = picture.depth() == CV_8U ? 224 : 224 * 257; // compression darkens white
    cv::Mat white;
    cv::inRange(picture.col(column), cv::Scalar::all(least), cv::Scalar::all(65535), white);
    return static_cast<double>(cv::countNonZero(white)) / picture.rows;
}

// Width of the white gap between the halves that programs such as Depth-Anything leave; 0 if there
// is none. It lies in the middle and ends at both sides at columns that are not white.
int gapOf(const cv::Mat& picture) {
    constexpr int kMinWidth = 8;
    constexpr int kBlur = 2; // px that compression changes at its ends
    constexpr double kWhite = 0.98;
    constexpr double kNotWhite = 0.9;
    int first = picture.cols / 2;
    int end = first;
    while (first > 0 && whiteShare(picture, first - 1) >= kWhite)
        --first;
    while (end < picture.cols && whiteShare(picture, end) >= kWhite)
        ++end;
    const int half = std::min(first, picture.cols - end);
    if (end - first < kMinWidth || half <= kBlur || std::abs(first + end - picture.cols) > kBlur ||
        whiteShare(picture, first - 1 - kBlur) > kNotWhite ||
        whiteShare(picture, end + kBlur) > kNotWhite)
        return 0;
    return picture.cols - 2 * half;
}

// Strength of the edges; the strongest 5 % count alike. [CV_32FC1]
cv::Mat edgesOf(const cv::Mat& picture) {
    constexpr double kShare = 0.95;
    const cv::Mat grey = smallGrey(picture);
    cv::Mat across;
    cv::Mat down;
    cv::Mat edges;
    cv::Sobel(grey, across, CV_32F, 1, 0);
    cv::Sobel(grey, down, CV_32F, 0, 1);
    cv::magnitude(across, down, edges);
    std::vector<float> values = edges.reshape(1, 1);
    const auto rank = static_cast<std::size_t>(kShare * static_cast<double>(values.size()));
    return cv::min(edges, static_cast<double>(valueOfRank(values, rank)));
}

// Whether the edges of both match best without a shift, among all shifts by up to a twelfth of the
// size. They do for 89 % of smooth depth maps and their photos, and for 2 % of unrelated halves.
bool edgesMeet(const cv::Mat& photo, const cv::Mat& depth) {
    const cv::Mat edges = edgesOf(photo);
    const cv::Point margin(edges.cols / 12, edges.rows / 12);
    const cv::Rect middle(margin.x, margin.y, edges.cols - 2 * margin.x, edges.rows - 2 * margin.y);
    cv::Mat fit; // by shift
    cv::matchTemplate(edges, edgesOf(depth)(middle), fit, cv::TM_CCOEFF_NORMED);
    cv::Point best;
    cv::minMaxLoc(fit, nullptr, nullptr, nullptr, &best);
    const int near = std::max(edges.cols, edges.rows) / 128;
    return std::max(std::abs(best.x - margin.x), std::abs(best.y - margin.y)) <= near;
}

} // namespace

cv::Size RgbdLayout::photoSize(cv::Size whole) const {
    return stretchedSize(halfPlaces(whole, isBeside(side)).first.size(),
                         squeezeOf(whole, isBeside(side), halves));
}

void splitRgbd(const cv::Mat& picture, const RgbdLayout& layout, cv::Mat& photo, cv::Mat& rawDepth,
               Notes* notes) try {
    checkType(picture, {CV_8UC3, CV_16UC3}, "RGB-D image", "three channels of 8 or 16 bits");
    const cv::Mat source = picture;
    const bool beside = isBeside(layout.side);
    const int gap = beside ? gapOf(source) : 0;
    if (gap > 0)
        addNote(notes, NoteCode::LeftOut,
                "a white gap of " + std::to_string(gap) +
                    " px between photo and depth is left out");
    const Halves places = halvesOf(layout.side, source.size(), gap);
    check(!places.photo.empty(), "RGB-D image",
          shapeText(source) + ", too small to split, expected at least 2 px " +
              (beside ? "across" : "down"));
    const cv::Mat photoHalf = source(places.photo);
    const cv::Mat depthHalf = source(places.depth);
    const bool isEightBit = source.depth() == CV_8U;
    const cv::Mat levels = undoColourMap(depthHalf, "RGB-D image", notes);
    if (!levels.empty()) {
        levels.convertTo(rawDepth, CV_32F, isEightBit ? 1 : 257);
    } else {
        if (hasColours(depthHalf))
            addNote(notes, NoteCode::Doubtful,
                    "the depth half has colours, and depth has none: "
                    "their grey value is taken");
        (isEightBit ? greyValues<std::uint8_t>(depthHalf) : greyValues<std::uint16_t>(depthHalf))
            .copyTo(rawDepth);
    }
    (isEightBit ? photoHalf : toEightBits(photoHalf)).copyTo(photo);
    const Squeeze squeeze = squeezeOf(source.size(), beside, layout.halves);
    stretch(photo, squeeze, cv::INTER_LINEAR);
    stretch(rawDepth, squeeze, cv::INTER_NEAREST); // numbers of depth are not mixed
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

cv::Mat readRgbdImage(const PhotoFile& file, DepthSide side, Notes* notes) {
    return readImageParts(
        file, [side](cv::Size whole) { return halvesOf(side, whole).photo; }, notes);
}

std::optional<DepthSide> findDepthHalf(const cv::Mat& picture, bool isStacked) try {
    checkType(picture, {CV_8UC3, CV_16UC3}, "RGB-D image", "three channels of 8 or 16 bits");
    std::array<DepthSide, 4> sides = {DepthSide::Right, DepthSide::Left, DepthSide::Bottom,
                                      DepthSide::Top};
    if (isStacked) std::rotate(sides.begin(), sides.begin() + 2, sides.end());
    const auto halvesAt = [&](DepthSide side) {
        return halvesOf(side, picture.size(), isBeside(side) ? gapOf(picture) : 0);
    };
    // The first side whose halves are what is asked for.
    const auto sideWhere = [&](auto areRight) -> std::optional<DepthSide> {
        const auto found = std::find_if(sides.begin(), sides.end(), [&](DepthSide side) {
            const Halves places = halvesAt(side);
            return !places.photo.empty() && areRight(picture(places.photo), picture(places.depth));
        });
        return found == sides.end() ? std::nullopt : std::optional(*found);
    };
    const auto isMap = [](const cv::Mat& half) {
        return hasColours(half) && !undoColourMap(half, "RGB-D image", nullptr).empty();
    };
    const auto mapped = sideWhere(
        [&](const cv::Mat& photo, const cv::Mat& depth) { return isMap(depth) && !isMap(photo); });
    if (mapped) return mapped;
    if (hasColours(picture)) {
        return sideWhere([](const cv::Mat& photo, const cv::Mat& depth) {
            return hasColours(photo) && !hasColours(depth);
        });
    }
    return sideWhere([](const cv::Mat& photo, const cv::Mat& depth) {
        return looksLikeDepthImage(depth) && !looksLikeDepthImage(photo) && edgesMeet(photo, depth);
    });
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void joinRgbd(const cv::Mat& photo, const cv::Mat& depth, const RgbdLayout& layout,
              cv::Mat& picture) try {
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3");
    checkType(depth, {CV_32FC1}, "depth", "CV_32FC1");
    check(photo.size() == depth.size(), "depth",
          shapeText(depth) + ", expected the photo's " + sizeText(photo.size()));
    const bool beside = isBeside(layout.side);
    cv::Size half = photo.size();
    const cv::Size both(beside ? 2 * half.width : half.width,
                        beside ? half.height : 2 * half.height);
    const Squeeze squeeze = squeezeOf(both, beside, layout.halves);
    if (squeeze == Squeeze::Width) half.width = (half.width + 1) / 2;
    if (squeeze == Squeeze::Height) half.height = (half.height + 1) / 2;
    const cv::Size whole(beside ? 2 * half.width : half.width,
                         beside ? half.height : 2 * half.height);
    const Halves halves = halvesOf(layout.side, whole);
    // these headers keep the samples alive if `picture` is the same object as `photo` or `depth`
    cv::Mat first = photo;
    const cv::Mat given = depth;
    if (squeeze != Squeeze::None) {
        cv::Mat squeezed;
        cv::resize(photo, squeezed, half, 0, 0, cv::INTER_AREA);
        first = squeezed;
    }
    picture.create(whole, CV_8UC3);
    first.copyTo(picture(halves.photo));
    for (int y = 0; y < half.height; ++y) {
        const float* from = given.ptr<float>(nearestSample(y, half.height, given.rows));
        std::uint8_t* to = picture.ptr<std::uint8_t>(halves.depth.y + y) + 3 * halves.depth.x;
        for (int x = 0; x < half.width; ++x, to += 3) {
            const float value = from[nearestSample(x, half.width, given.cols)];
            std::fill_n(to, 3, toWhole<std::uint8_t>(value, 255.0f));
        }
    }
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
