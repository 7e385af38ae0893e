#include "slide/slide_views.hpp"

#include "base/pixel_rows.hpp"
#include "depth/map/depth_values.hpp"
#include "depth/stereo/stereo_parts.hpp"
#include "image/pixel_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr double kMatchPixels = 5e5; // at which frames are matched, at most

// The ray of a px of a view in the axes of a camera, and how inverse depth q moves it: p = ray - q
// away.
struct Rays {
    Rays(const SlideCamera& camera, const SlideWindow& window, double position)
        : turn(camera.turn), byX(turn * cv::Vec3d(1 / window.focal, 0, 0)),
          byY(turn * cv::Vec3d(0, 1 / window.focal, 0)),
          away(turn * (camera.place - cv::Vec3d(position, 0, 0))),
          first(turn * cv::Vec3d((0.5 - window.middle.x) / window.focal - position * window.focus,
                                 (0.5 - window.middle.y) / window.focal, 1)) {}
    cv::Vec3d at(double x, double y, double q) const {
        return first + byX * x + byY * y - away * q;
    }

    cv::Matx33d turn;
    cv::Vec3d byX;
    cv::Vec3d byY;
    cv::Vec3d away;
    cv::Vec3d first;
};

// Where the px of a view are in a frame's picture.
void placesIn(const SlideFrame& frame, const SlideLens& lens, const SlideWindow& window,
              double position, const cv::Mat& depth, cv::Mat& places) {
    const Rays rays(frame.camera, window, position);
    const cv::Size size = frame.picture.size();
    const double rows = size.height / frame.aspect; // px of a width
    places.create(window.size, CV_32FC2);
    overRows(window.size.height, [&](int y) {
        auto* const to = places.ptr<cv::Vec2f>(y);
        const float* const q = depth.empty() ? nullptr : depth.ptr<float>(y);
        for (int x = 0; x < window.size.width; ++x) {
            const cv::Point2d at =
                seenAt(rays.at(x, y, q == nullptr ? window.focus : static_cast<double>(q[x])),
                       frame.camera, lens);
            to[x] = {static_cast<float>(at.x * size.width + size.width / 2.0 - 0.5),
                     static_cast<float>(at.y * rows + size.height / 2.0 - 0.5)};
        }
    });
}

cv::Mat sampled(const cv::Mat& picture, const cv::Mat& places) {
    cv::Mat view;
    cv::remap(picture, view, places, {}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    return view;
}

// Moves the inverse depths of a row to another position, where the nearest ones win.
// @param shift px to the right per q beyond the focus
void moveRow(const float* from, int width, float shift, float focus, float* to) {
    constexpr float kTear = 1; // px between neighbours of one surface
    const auto put = [&](int x, float q) {
        if (x >= 0 && x < width && !(to[x] >= q)) to[x] = q;
    };
    for (int x = 0; x < width; ++x) {
        if (std::isnan(from[x])) continue;
        const float here = static_cast<float>(x) + shift * (from[x] - focus);
        put(static_cast<int>(std::lround(here)), from[x]);
        if (x + 1 == width || std::isnan(from[x + 1])) continue;
        const float next = static_cast<float>(x + 1) + shift * (from[x + 1] - focus);
        if (next <= here || next - here > 1 + kTear) continue;
        for (int at = static_cast<int>(std::ceil(here)); static_cast<float>(at) < next; ++at) {
            const float share = (static_cast<float>(at) - here) / (next - here);
            put(at, from[x] + share * (from[x + 1] - from[x]));
        }
    }
}

cv::Mat movedDepth(const cv::Mat& depth, const SlideWindow& window, double way) {
    cv::Mat moved(depth.size(), CV_32FC1, cv::Scalar::all(kUnknown));
    const double shift = -window.focal * way;
    overRows(depth.rows, [&](int y) {
        moveRow(depth.ptr<float>(y), depth.cols, static_cast<float>(shift),
                static_cast<float>(window.focus), moved.ptr<float>(y));
    });
    return moved;
}

// How much two pictures differ around each px [CV_32FC1].
cv::Mat unlikeness(const cv::Mat& a, const cv::Mat& b) {
    cv::Mat off;
    cv::absdiff(a, b, off);
    off.convertTo(off, CV_32F);
    cv::Mat sum;
    cv::transform(off, sum, cv::Matx13f(1, 1, 1));
    cv::blur(sum, sum, {3, 3});
    return sum;
}

// The window at which frames are matched.
SlideWindow smaller(const SlideWindow& window, double scale) {
    return scaled(window, {std::max(16, cvRound(window.size.width * scale)),
                           std::max(16, cvRound(window.size.height * scale))});
}

} // namespace

SlideWindow scaled(const SlideWindow& window, cv::Size size) {
    const double scale = static_cast<double>(size.width) / window.size.width;
    return {size, window.focal * scale, window.middle * scale, window.focus};
}

cv::Mat viewFrom(const SlideFrame& frame, const SlideLens& lens, const SlideWindow& window,
                 double position, const cv::Mat& depth) {
    cv::Mat places;
    placesIn(frame, lens, window, position, depth, places);
    return sampled(frame.picture, places);
}

cv::Rect2d commonPart(const std::vector<SlideCamera>& cameras, const SlideLens& lens, double aspect,
                      double focus) {
    const SlideWindow window{{1, 1}, 1, {0.5, 0.5}, focus};
    double left = -1e9;
    double right = 1e9;
    double top = -1e9;
    double bottom = 1e9;
    for (const SlideCamera& camera : cameras) {
        const Rays rays(camera, window, camera.place[0]);
        // the projective map of the plane, without the distortion
        const cv::Point2f plane[4] = {{-0.5F, -0.5F}, {0.5F, -0.5F}, {0.5F, 0.5F}, {-0.5F, 0.5F}};
        cv::Point2f seen[4];
        for (int k = 0; k < 4; ++k) {
            const cv::Point2d at = seenAt(
                rays.at(static_cast<double>(plane[k].x), static_cast<double>(plane[k].y), focus),
                camera, {lens.focal, 0});
            seen[k] = at;
        }
        const cv::Matx33d back = cv::getPerspectiveTransform(seen, plane);
        const double bend = lens.bend * (1 + aspect * aspect) / 4;
        const double x = 0.5 / (1 + bend);
        const double y = 0.5 * aspect / (1 + bend);
        const auto planeAt = [&](double u, double v) {
            const cv::Vec3d p = back * cv::Vec3d(u, v, 1);
            return cv::Point2d(p[0] / p[2], p[1] / p[2]);
        };
        const cv::Point2d corners[4] = {planeAt(-x, -y), planeAt(x, -y), planeAt(x, y),
                                        planeAt(-x, y)};
        left = std::max({left, corners[0].x, corners[3].x});
        right = std::min({right, corners[1].x, corners[2].x});
        top = std::max({top, corners[0].y, corners[1].y});
        bottom = std::min({bottom, corners[2].y, corners[3].y});
    }
    return {left, top, right - left, bottom - top};
}

SlideDepths matchFrames(const SlideFrame& left, const SlideFrame& right, const SlideLens& lens,
                        const SlideWindow& window, double low, double high) {
    const double scale = std::min(1.0, std::sqrt(kMatchPixels / window.size.area()));
    const SlideWindow small = smaller(window, scale);
    const double from = left.camera.place[0];
    const double to = right.camera.place[0];
    const double perDepth = small.focal * (to - from); // px of disparity
    const cv::Mat leftGrey = greyOf(viewFrom(left, lens, small, from));
    const cv::Mat rightGrey = greyOf(viewFrom(right, lens, small, to));
    RowDisparities found = matchRows(leftGrey, rightGrey, perDepth * (low - window.focus) - 1,
                                     perDepth * (high - window.focus) + 1);
    const auto toDepth = [&](const cv::Mat& disparity) {
        cv::Mat depth = disparity / perDepth + window.focus;
        if (depth.size() != window.size)
            cv::resize(depth, depth, window.size, 0, 0, cv::INTER_NEAREST);
        return depth;
    };
    return {toDepth(found.left), toDepth(found.right)};
}

cv::Mat viewBetween(const SlideFrame& left, const SlideFrame& right, const SlideLens& lens,
                    const SlideWindow& window, double position, const SlideDepths& depths) {
    const double from = left.camera.place[0];
    const double to = right.camera.place[0];
    const cv::Mat byLeft = movedDepth(depths.left, window, position - from);
    const cv::Mat byRight = movedDepth(depths.right, window, position - to);
    const float same = static_cast<float>(1 / (window.focal * std::abs(to - from))); // 1 px
    const auto share = static_cast<float>(
        std::clamp((position - from) / (to - from), 0.0, 1.0)); // share of the right frame
    cv::Mat depth(window.size, CV_32FC1);
    cv::Mat weight(window.size, CV_32FC1); // weight of the right frame
    overRows(window.size.height, [&](int y) {
        const float* const a = byLeft.ptr<float>(y);
        const float* const b = byRight.ptr<float>(y);
        float* const q = depth.ptr<float>(y);
        float* const w = weight.ptr<float>(y);
        for (int x = 0; x < window.size.width; ++x) {
            w[x] = share;
            if (std::isnan(a[x]) || std::isnan(b[x])) {
                q[x] = std::isnan(a[x]) ? b[x] : a[x];
                if (!std::isnan(a[x])) w[x] = 0;
                if (!std::isnan(b[x])) w[x] = 1;
            } else if (std::abs(a[x] - b[x]) <= same) {
                q[x] = a[x] + share * (b[x] - a[x]);
            } else { // the nearer one hides the other
                q[x] = std::max(a[x], b[x]);
                w[x] = a[x] > b[x] ? 0.0F : 1.0F;
            }
        }
    });
    // Where neither frame knows the depth, it is that of the farther neighbour (something hidden)
    // or of the nearer one (an unmatched part of it): the one with which the frames agree better.
    cv::Mat nearer = -depth;
    fillUnknown(depth);
    fillUnknown(nearer);
    nearer = -nearer;
    cv::Mat first = viewFrom(left, lens, window, position, depth);
    cv::Mat second = viewFrom(right, lens, window, position, depth);
    const cv::Mat isBeside = nearer - depth > same;
    if (cv::countNonZero(isBeside) > 0) {
        const cv::Mat nearFirst = viewFrom(left, lens, window, position, nearer);
        const cv::Mat nearSecond = viewFrom(right, lens, window, position, nearer);
        const cv::Mat isTaken =
            isBeside & (2 * unlikeness(nearFirst, nearSecond) < unlikeness(first, second));
        nearFirst.copyTo(first, isTaken);
        nearSecond.copyTo(second, isTaken);
    }
    cv::blur(weight, weight, {3, 3});
    cv::Mat view(window.size, CV_8UC3);
    overRows(window.size.height, [&](int y) {
        const auto* const a = first.ptr<cv::Vec3b>(y);
        const auto* const b = second.ptr<cv::Vec3b>(y);
        const float* const w = weight.ptr<float>(y);
        auto* const v = view.ptr<cv::Vec3b>(y);
        for (int x = 0; x < window.size.width; ++x)
            for (int c = 0; c < 3; ++c)
                v[x][c] = cv::saturate_cast<uchar>(static_cast<float>(a[x][c]) * (1 - w[x]) +
                                                   static_cast<float>(b[x][c]) * w[x]);
    });
    return view;
}

double frontShare(const std::vector<std::pair<SlideFrame, SlideFrame>>& pairs,
                  const SlideLens& lens, const SlideWindow& window, double low, double high) {
    constexpr double kMatchSide = 640; // px, whatever the size of the views
    constexpr std::int64_t kFewest = 100;
    const double scale = kMatchSide / std::max(window.size.width, window.size.height);
    const SlideWindow small = smaller(window, scale);
    HiddenLooks all;
    for (const auto& [left, right] : pairs) {
        const double way = right.camera.place[0] - left.camera.place[0];
        if (way <= 0) continue;
        const SlideDepths depths = matchFrames(left, right, lens, small, low, high);
        for (const bool isRight : {false, true}) { // in the mirror, the right one is the left one
            const SlideFrame& frame = isRight ? right : left;
            cv::Mat depth = isRight ? depths.right : depths.left;
            cv::Mat grey = greyOf(viewFrom(frame, lens, small, frame.camera.place[0]));
            if (isRight) {
                cv::flip(depth, depth, 1);
                cv::flip(grey, grey, 1);
            }
            const HiddenLooks looks = looksOfHidden(depth, grey, small.focal * way);
            all.behind += looks.behind;
            all.front += looks.front;
        }
    }
    const std::int64_t count = all.front + all.behind;
    return count < kFewest ? 0.5 : static_cast<double>(all.front) / static_cast<double>(count);
}

cv::Mat medianDepth(const std::vector<cv::Mat>& depths) {
    cv::Mat result(depths.front().size(), CV_32FC1);
    overRows(result.rows, [&](int y) {
        std::vector<float> known;
        for (int x = 0; x < result.cols; ++x) {
            known.clear();
            for (const cv::Mat& depth : depths) {
                const float value = depth.at<float>(y, x);
                if (!std::isnan(value)) known.push_back(value);
            }
            std::sort(known.begin(), known.end());
            const std::size_t half = known.size() / 2;
            result.at<float>(y, x) = known.empty()           ? kUnknown
                                     : known.size() % 2 == 1 ? known[half]
                                                             : (known[half - 1] + known[half]) / 2;
        }
    });
    return result;
}

} // namespace altiro3D
