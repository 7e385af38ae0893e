#include "slide/slide_tracks.hpp"

#include "image/pixel_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace altiro3D {

namespace {

constexpr int kMostPictures = 600; // that are kept in memory
constexpr int kLevels = 4;         // levels of the pyramid besides the whole picture
const cv::Size kWindow(21, 21);    // px
const cv::Size kWide(61, 61);      // px, for pictures full of noise
constexpr double kQuality = 0.005; // quality of a corner against the best one

std::vector<cv::Mat> pyramidOf(const cv::Mat& grey, cv::Size window) {
    std::vector<cv::Mat> pyramid;
    cv::buildOpticalFlowPyramid(grey, pyramid, window, kLevels);
    return pyramid;
}

// The picture without the mean brightness around each px, which the light changes.
std::vector<cv::Mat> detailOf(const cv::Mat& grey, cv::Size window) {
    cv::Mat detail;
    cv::blur(grey, detail, window);
    cv::addWeighted(grey, 1, detail, -1, 128, detail);
    std::vector<cv::Mat> pyramid;
    cv::buildOpticalFlowPyramid(detail, pyramid, window, 0);
    return pyramid;
}

// Points of one picture in another one.
struct Followed {
    std::vector<cv::Point2f> to;
    std::vector<std::uint8_t> isFound;
};

// @param guess where they may be
Followed follow(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to,
                const std::vector<cv::Point2f>& points, const std::vector<cv::Point2f>& guess,
                cv::Size window, int levels) {
    Followed result;
    if (points.empty()) return result;
    result.to = guess;
    std::vector<float> errors;
    cv::calcOpticalFlowPyrLK(
        from, to, points, result.to, result.isFound, errors, window, levels,
        cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.005),
        cv::OPTFLOW_USE_INITIAL_FLOW, 1e-4);
    return result;
}

bool isInside(const cv::Point2f& p, cv::Size size) {
    constexpr float kEdge = 4; // px
    return p.x >= kEdge && p.y >= kEdge && p.x < static_cast<float>(size.width) - kEdge &&
           p.y < static_cast<float>(size.height) - kEdge;
}

// Forwards and back. @return without those that do not come back within half a px
Followed followBothWays(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to,
                        const std::vector<cv::Point2f>& points, cv::Size window) {
    Followed there = follow(from, to, points, points, window, kLevels);
    const Followed back = follow(to, from, there.to, points, window, kLevels);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const cv::Point2f off = back.to[i] - points[i];
        if (back.isFound[i] == 0 || cv::norm(off) > 0.5 || !isInside(there.to[i], from[0].size()))
            there.isFound[i] = 0;
    }
    return there;
}

double brightnessAt(const cv::Mat& grey, const cv::Point2f& p) {
    constexpr int kReach = 4;
    const cv::Rect part =
        cv::Rect(cvRound(p.x) - kReach, cvRound(p.y) - kReach, 2 * kReach + 1, 2 * kReach + 1) &
        cv::Rect({0, 0}, grey.size());
    return cv::mean(grey(part))[0];
}

} // namespace

void SlidePictures::add(const cv::Mat& picture) {
    const int number = count_++;
    if (number % stride_ != 0) return;
    SlidePicture next;
    next.number = number;
    cv::resize(greyOf(picture), next.grey, downscaledSize(picture.size(), kTrackSide), 0, 0,
               cv::INTER_AREA);
    cv::Mat right;
    cv::Mat down;
    cv::Sobel(next.grey, right, CV_16S, 1, 0);
    cv::Sobel(next.grey, down, CV_16S, 0, 1);
    next.sharpness = cv::norm(right, cv::NORM_L2SQR) + cv::norm(down, cv::NORM_L2SQR);
    kept_.push_back(next);
    if (kept_.size() < kMostPictures) return;
    stride_ *= 2;
    std::size_t left = 0;
    for (std::size_t i = 0; i < kept_.size(); i += 2)
        kept_[left++] = kept_[i];
    kept_.resize(left);
}

PictureSteps stepsWith(const std::vector<SlidePicture>& pictures, cv::Size window) {
    constexpr int kCorners = 120;
    PictureSteps result;
    result.window = window;
    result.steps.resize(pictures.size());
    std::vector<cv::Mat> before;
    result.counts.resize(pictures.size());
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        std::vector<cv::Mat> now = pyramidOf(pictures[i].grey, window);
        if (i > 0) {
            const cv::Mat& from = pictures[i - 1].grey;
            const double apart = 0.7 * std::sqrt(static_cast<double>(from.total()) / kCorners);
            std::vector<cv::Point2f> points;
            cv::goodFeaturesToTrack(from, points, kCorners, kQuality, apart, {}, 5);
            const Followed found = followBothWays(before, now, points, window);
            std::vector<double> right;
            std::vector<double> down;
            for (std::size_t k = 0; k < points.size(); ++k) {
                if (found.isFound[k] == 0) continue;
                right.push_back(static_cast<double>(found.to[k].x - points[k].x));
                down.push_back(static_cast<double>(found.to[k].y - points[k].y));
            }
            result.counts[i] = static_cast<int>(right.size());
            result.steps[i] = {percentileOf(right, 0.5), percentileOf(down, 0.5)};
        }
        before = std::move(now);
    }
    return result;
}

PictureSteps stepsOf(const std::vector<SlidePicture>& pictures) {
    constexpr double kMany = 80;    // corners of stepsWith()
    constexpr double kGained = 1.2; // ratio of corners at which the wide window is worth it
    const auto usual = [](const PictureSteps& of) {
        return percentileOf(std::vector<double>(of.counts.begin() + 1, of.counts.end()), 0.5);
    };
    PictureSteps steps = stepsWith(pictures, kWindow);
    if (pictures.size() < 2 || usual(steps) >= kMany) return steps;
    PictureSteps wide = stepsWith(pictures, kWide);
    return usual(wide) > kGained * usual(steps) ? wide : steps;
}

std::vector<std::size_t> choosePictures(const std::vector<SlidePicture>& pictures,
                                        const std::vector<cv::Point2d>& steps, int most) {
    std::vector<std::size_t> chosen(pictures.size());
    std::iota(chosen.begin(), chosen.end(), 0);
    if (pictures.size() <= static_cast<std::size_t>(most)) return chosen;
    chosen.clear();
    // the way so far, without the trembling of a hand
    constexpr std::size_t kReach = 4; // pictures
    std::vector<double> way(pictures.size());
    for (std::size_t i = 1; i < pictures.size(); ++i) {
        const std::size_t first = i > kReach ? i - kReach : 1;
        const std::size_t end = std::min(pictures.size(), i + kReach + 1);
        cv::Point2d sum(0, 0);
        for (std::size_t k = first; k < end; ++k)
            sum += steps[k];
        way[i] = way[i - 1] + std::hypot(sum.x, sum.y) / static_cast<double>(end - first);
    }
    int bin = -1;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const int here =
            std::min(most - 1, static_cast<int>(most * way[i] / std::max(way.back(), 1e-9)));
        if (here != bin) {
            chosen.push_back(i);
            bin = here;
        } else if (pictures[i].sharpness > pictures[chosen.back()].sharpness) {
            chosen.back() = i;
        }
    }
    return chosen;
}

SlideTracks followCorners(const std::vector<const SlidePicture*>& pictures, double aspect,
                          cv::Size window) {
    constexpr int kCorners = 500;
    const cv::Size size = pictures.front()->grey.size();
    const auto widths = [&](const cv::Point2f& p) {
        return cv::Point2d((static_cast<double>(p.x) + 0.5 - size.width / 2.0) / size.width,
                           ((static_cast<double>(p.y) + 0.5) / size.height - 0.5) * aspect);
    };
    // a track that goes on
    struct Live {
        std::size_t track;
        std::size_t origin; // the picture in which it begins
        cv::Point2f begin;
        cv::Point2f at;
    };
    SlideTracks result;
    result.gains.assign(pictures.size(), 1);
    result.fewest = kCorners;
    std::vector<Live> live;
    std::vector<cv::Mat> before;
    std::vector<std::vector<cv::Mat>> details;
    const double apart = 0.7 * std::sqrt(static_cast<double>(size.area()) / kCorners);
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const cv::Mat& grey = pictures[i]->grey;
        std::vector<cv::Mat> now = pyramidOf(grey, window);
        details.push_back(detailOf(grey, window));
        if (i > 0) {
            std::vector<cv::Point2f> points;
            for (const Live& one : live)
                points.push_back(one.at);
            const Followed found = followBothWays(before, now, points, window);
            std::vector<Live> next;
            std::vector<double> ratios;
            for (std::size_t origin = 0; origin < i; ++origin) {
                std::vector<std::size_t> of;
                std::vector<cv::Point2f> begins;
                std::vector<cv::Point2f> guesses;
                for (std::size_t k = 0; k < live.size(); ++k) {
                    if (found.isFound[k] == 0 || live[k].origin != origin) continue;
                    of.push_back(k);
                    begins.push_back(live[k].begin);
                    guesses.push_back(found.to[k]);
                }
                const Followed exact =
                    follow(details[origin], details[i], begins, guesses, window, 0);
                for (std::size_t k = 0; k < of.size(); ++k) {
                    const cv::Point2f off = exact.to[k] - guesses[k];
                    if (exact.isFound[k] == 0 || cv::norm(off) > 1 || !isInside(exact.to[k], size))
                        continue;
                    Live one = live[of[k]];
                    const double was = brightnessAt(pictures[i - 1]->grey, one.at);
                    one.at = exact.to[k];
                    const double is = brightnessAt(grey, one.at);
                    if (was > 16 && was < 220 && is > 16 && is < 220) ratios.push_back(is / was);
                    result.tracks[one.track].at.push_back(widths(one.at));
                    next.push_back(one);
                }
            }
            live = std::move(next);
            result.fewest = std::min(result.fewest, static_cast<int>(live.size()));
            result.gains[i] =
                result.gains[i - 1] * (ratios.empty() ? 1 : percentileOf(ratios, 0.5));
        }
        before = std::move(now);
        if (i + 1 == pictures.size()) break;
        cv::Mat free(size, CV_8UC1, cv::Scalar(255));
        for (const Live& one : live)
            cv::circle(free, one.at, cvRound(apart), cv::Scalar(0), cv::FILLED);
        const int missing = kCorners - static_cast<int>(live.size());
        if (missing <= 0) continue;
        std::vector<cv::Point2f> corners;
        cv::goodFeaturesToTrack(grey, corners, missing, kQuality, apart, free, 5);
        for (const cv::Point2f& corner : corners) {
            if (!isInside(corner, size)) continue;
            live.push_back({result.tracks.size(), i, corner, corner});
            result.tracks.push_back({static_cast<int>(i), {widths(corner)}});
        }
    }
    const std::size_t fewest = std::min<std::size_t>(3, pictures.size());
    const auto isShort = [&](const SlideTrack& track) { return track.at.size() < fewest; };
    result.tracks.erase(std::remove_if(result.tracks.begin(), result.tracks.end(), isShort),
                        result.tracks.end());
    return result;
}

void removeStill(SlideTracks& tracks) {
    constexpr double kStill = 0.004; // widths
    const auto isStill = [](const SlideTrack& track) {
        return cv::norm(track.at.back() - track.at.front()) < kStill;
    };
    std::vector<SlideTrack>& all = tracks.tracks;
    all.erase(std::remove_if(all.begin(), all.end(), isStill), all.end());
    std::vector<int> counts(tracks.gains.size() - 1);
    for (const SlideTrack& track : all)
        for (int i = track.first; i + 1 < track.end(); ++i)
            ++counts[static_cast<std::size_t>(i)];
    tracks.fewest = *std::min_element(counts.begin(), counts.end());
}

} // namespace altiro3D
