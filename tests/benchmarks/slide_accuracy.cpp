// Views of a camera that is slid by hand, beside the truth. Prints the tables of docs/lab/slide.md.
//
//     altiro3D_slide_accuracy make VIDEO boards|terrace PICTURES METRES
//     altiro3D_slide_accuracy judge VIDEO boards|terrace PICTURES METRES
//     altiro3D_slide_accuracy field VIEW...      views of a light field, from the left

#include "altiro3D/camera_slide.hpp"
#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_map.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_io.hpp"
#include "support/hand_slide.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <string>

using namespace altiro3D;
using namespace altiro3D::test;

namespace {

constexpr int kViews = 48;

struct Case {
    std::string file;
    const World& world;
    HandSlide hand;
    cv::Size size;
};

void make(const Case& one) {
    VideoWriterOptions options;
    options.size = one.size;
    options.compatible = true;
    options.crf = 20;
    options.preset = EncoderPreset::Medium;
    options.timeBase = {1, 30};
    VideoWriter writer(one.file, options);
    std::int64_t time = 0;
    for (const HandCamera& camera : handSlide(one.hand))
        writer.write({one.world.photograph(one.size, camera), time++, 1});
    writer.finish();
}

// Points of one picture and the same ones in another.
struct Pairs {
    std::vector<cv::Point2f> from;
    std::vector<cv::Point2f> to;
};
Pairs pairsOf(const cv::Mat& from, const cv::Mat& to) {
    cv::Mat a;
    cv::Mat b;
    cv::cvtColor(from, a, cv::COLOR_BGR2GRAY);
    cv::cvtColor(to, b, cv::COLOR_BGR2GRAY);
    b.convertTo(b, -1, cv::mean(a)[0] / cv::mean(b)[0]); // corners are followed by brightness
    const cv::Size all(std::max(a.cols, b.cols), std::max(a.rows, b.rows));
    for (cv::Mat* grey : {&a, &b})
        cv::copyMakeBorder(*grey, *grey, 0, all.height - grey->rows, 0, all.width - grey->cols,
                           cv::BORDER_REPLICATE);
    std::vector<cv::Point2f> points;
    cv::goodFeaturesToTrack(a, points, 1500, 0.003, 5);
    std::vector<cv::Point2f> there;
    std::vector<cv::Point2f> back;
    std::vector<uchar> isFound;
    std::vector<uchar> isBack;
    std::vector<float> errors;
    const cv::TermCriteria end(3, 40, 0.001);
    cv::calcOpticalFlowPyrLK(a, b, points, there, isFound, errors, {15, 15}, 5, end);
    cv::calcOpticalFlowPyrLK(b, a, there, back, isBack, errors, {15, 15}, 5, end);
    Pairs pairs;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const cv::Point2f off = back[i] - points[i];
        if (isFound[i] == 0 || isBack[i] == 0 || std::hypot(off.x, off.y) > 0.2F) continue;
        pairs.from.push_back(points[i]);
        pairs.to.push_back(there[i]);
    }
    return pairs;
}

// How far the rows of a view are from those of the truth, px: root mean square without the worst
// 5 % of the corners.
double rowsOff(const cv::Mat& view, const cv::Mat& truth) {
    const Pairs pairs = pairsOf(truth, view);
    std::vector<double> squares;
    for (std::size_t i = 0; i < pairs.from.size(); ++i)
        squares.push_back(std::pow(static_cast<double>(pairs.to[i].y - pairs.from[i].y), 2));
    std::sort(squares.begin(), squares.end());
    squares.resize(squares.size() * 95 / 100);
    double sum = 0;
    for (const double square : squares)
        sum += square;
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, squares.size())));
}

// PSNR where `isIn` is set; brightness is made equal first, as the hand's light is not known.
double likeness(const cv::Mat& view, const cv::Mat& truth, const cv::Mat& isIn) {
    const cv::Scalar a = cv::mean(view, isIn);
    const cv::Scalar b = cv::mean(truth, isIn);
    cv::Mat equal;
    cv::multiply(view, cv::Scalar(b[0] / a[0], b[1] / a[1], b[2] / a[2]), equal);
    const double squares = std::pow(cv::norm(equal, truth, cv::NORM_L2, isIn), 2);
    return 10 * std::log10(255.0 * 255 * 3 * cv::countNonZero(isIn) / std::max(squares, 1e-9));
}

cv::Matx33d homography(const cv::Mat& from, const cv::Mat& to, double reach) {
    Pairs pairs = pairsOf(from, to);
    for (std::size_t i = 0; i < pairs.from.size(); ++i) { // middles of px: + .5
        pairs.from[i] += cv::Point2f(0.5F, 0.5F);
        pairs.to[i] += cv::Point2f(0.5F, 0.5F);
    }
    return cv::findHomography(pairs.from, pairs.to, cv::RANSAC, reach);
}

// A picture laid on the true view by the best of several projective maps.
struct Laid {
    double psnr = 0;
    cv::Mat isIn; // [of the truth, CV_8UC1], 255 where both are compared
};
Laid lay(const cv::Mat& picture, const cv::Mat& truth, const cv::Mat& isAsked) {
    const cv::Matx33d half(1, 0, 0.5, 0, 1, 0.5, 0, 0, 1);
    cv::Mat inside = cv::Mat::zeros(picture.size(), CV_8UC1);
    constexpr int kBorder = 16; // px
    inside(cv::Rect(kBorder, kBorder, picture.cols - 2 * kBorder, picture.rows - 2 * kBorder))
        .setTo(255);
    Laid best;
    for (const double reach : {0.5, 1.0, 2.0, 4.0}) {
        const cv::Matx33d map = half.inv() * homography(truth, picture, reach) * half;
        cv::Mat laid;
        cv::warpPerspective(picture, laid, map, truth.size(),
                            cv::INTER_CUBIC | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
        cv::Mat isIn;
        cv::warpPerspective(inside, isIn, map, truth.size(),
                            cv::INTER_NEAREST | cv::WARP_INVERSE_MAP);
        if (!isAsked.empty()) isIn &= isAsked;
        const double psnr = likeness(laid, truth, isIn);
        if (psnr > best.psnr) best = {psnr, isIn};
    }
    return best;
}
double likeOf(const cv::Mat& picture, const cv::Mat& truth, const cv::Mat& isAsked = {}) {
    return lay(picture, truth, isAsked).psnr;
}

// The inner part of views of a light field that a hand has taken: it turns, rolls and zooms, and
// the light changes. Of every four views one is left out, for judging.
void judgeField(const std::vector<std::string>& files) {
    constexpr double kInner = 0.85;
    const auto count = static_cast<int>(files.size());
    const std::vector<HandCamera> hands = handSlide(shakyHand(count, 0));
    std::vector<cv::Mat> taken;
    std::vector<int> placeOf;
    std::map<int, cv::Mat> hidden;
    for (int i = 0; i < count; ++i) {
        const cv::Mat view = readPhoto(PhotoFile(files[static_cast<std::size_t>(i)]));
        const cv::Size inner(cvRound(view.cols * kInner), cvRound(view.rows * kInner));
        const cv::Rect middle({(view.cols - inner.width) / 2, (view.rows - inner.height) / 2},
                              inner);
        if (i % 4 == 2) {
            hidden[i] = view(middle).clone();
            continue;
        }
        const HandCamera& hand = hands[static_cast<std::size_t>(i)];
        const double focal = 0.866 * view.cols;
        const cv::Matx33d axes(1 / focal, 0, -view.cols / 2.0 / focal, 0, 1 / focal,
                               -view.rows / 2.0 / focal, 0, 0, 1);
        const cv::Matx33d zoomed(1 / focal / hand.zoom, 0, -inner.width / 2.0 / focal / hand.zoom,
                                 0, 1 / focal / hand.zoom, -inner.height / 2.0 / focal / hand.zoom,
                                 0, 0, 1);
        const cv::Matx33d still(1, 0, 0, 0, -1, 0, 0, 0, 1); // y of a hand points up
        cv::Mat shaken;
        cv::warpPerspective(view, shaken, axes.inv() * still * axesOf(hand) * zoomed, inner,
                            cv::INTER_CUBIC | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
        shaken.convertTo(shaken, CV_8U, hand.exposure);
        taken.push_back(shaken);
        placeOf.push_back(i);
    }
    CameraSlide slide([&](const std::function<bool(const cv::Mat&)>& take) {
        for (const cv::Mat& picture : taken)
            if (!take(picture)) return;
    });
    const SlideReport& report = slide.report();
    for (const std::string& line : report.lines())
        std::cout << "  " << line << "\n";
    double worst = 0;
    for (const auto& [number, position] : report.positions) {
        const double at = report.fromRight ? 1 - position : position;
        worst = std::max(worst,
                         std::abs(at * placeOf.back() - placeOf[static_cast<std::size_t>(number)]));
    }
    std::printf("  positions: off by %.1f %% of a step at most\n", 100 * worst);
    // the true place of a view that was left out is only known as between its neighbours
    constexpr int kFine = 8; // views for each that was taken
    const int last = kFine * placeOf.back();
    std::vector<cv::Mat> views(static_cast<std::size_t>(last + 1));
    slide.makeViews(last + 1, [&](int view, const cv::Mat& picture) {
        views[static_cast<std::size_t>(view)] = picture.clone();
    });
    const auto positionOf = [&](std::size_t picture) {
        const auto isIt = [&](const auto& one) { return one.first == static_cast<int>(picture); };
        const auto found = std::find_if(report.positions.begin(), report.positions.end(), isIt);
        return found == report.positions.end() ? std::nan("") : found->second;
    };
    for (const auto& [place, truth] : hidden) {
        const auto next = static_cast<std::size_t>(
            std::lower_bound(placeOf.begin(), placeOf.end(), place) - placeOf.begin());
        const double position = (positionOf(next - 1) + positionOf(next)) / 2;
        if (std::isnan(position)) {
            std::printf("  view %d: its neighbours are not used\n", place);
            continue;
        }
        const cv::Mat& view = views[static_cast<std::size_t>(std::lround(position * last))];
        const auto [made, isIn] = lay(view, truth, {});
        const double raw =
            std::max(likeOf(taken[next], truth, isIn), likeOf(taken[next - 1], truth, isIn));
        std::printf("  view %d: made %.2f dB, aligned neighbour %.2f dB, gain %.2f dB\n", place,
                    made, raw, made - raw);
    }
}

void judge(const Case& one) {
    const World& world = one.world;
    const std::vector<HandCamera> hands = handSlide(one.hand);
    SlideOptions options;
    options.aspect = 0.75;
    options.longestSide = 560;
    CameraSlide slide(slideVideo(one.file), options);
    const SlideReport& report = slide.report();
    std::vector<cv::Mat> views(kViews);
    slide.makeViews(kViews, [&](int view, const cv::Mat& picture) {
        views[static_cast<std::size_t>(view)] = picture.clone();
    });
    for (const std::string& line : report.lines())
        std::cout << "  " << line << "\n";
    for (const Note& note : slide.notes())
        std::cout << "  note: " << note.text << "\n";
    std::printf("  seconds: read %.1f, corners %.1f, path %.1f, views %.1f\n", report.seconds[0],
                report.seconds[1], report.seconds[2], report.seconds[3]);

    // true places as a line of the positions found
    double n = 0, sum = 0, sumSquares = 0;
    cv::Vec3d places(0, 0, 0);
    cv::Vec3d products(0, 0, 0);
    for (const auto& [number, position] : report.positions) {
        const cv::Vec3d& place = hands[static_cast<std::size_t>(number)].place;
        n += 1;
        sum += position;
        sumSquares += position * position;
        places += place;
        products += place * position;
    }
    const cv::Vec3d perPosition =
        (products * n - places * sum) * (1 / (n * sumSquares - sum * sum));
    const cv::Vec3d first = (places - perPosition * sum) * (1 / n);
    double worst = 0, squares = 0;
    std::vector<std::pair<double, double>> offs; // position found, error
    for (const auto& [number, position] : report.positions) {
        const double off =
            (hands[static_cast<std::size_t>(number)].place[0] - first[0]) / perPosition[0] -
            position;
        offs.emplace_back(position, off);
        worst = std::max(worst, std::abs(off));
        squares += off * off;
    }
    std::printf("  positions: %.2f %% of a step rms, %.2f %% at most; path %.4f m\n",
                100 * (kViews - 1) * std::sqrt(squares / n), 100 * (kViews - 1) * worst,
                perPosition[0]);
    // views are made of the pictures two steps to both sides
    const auto offOf = [&](double position) {
        const auto nearest = std::min_element(offs.begin(), offs.end(), [&](auto& a, auto& b) {
            return std::abs(a.first - position) < std::abs(b.first - position);
        });
        return nearest->second;
    };
    double spacing = 0, worstSpacing = 0, before = 0;
    for (int view = 0; view < kViews; ++view) {
        const double at = view / (kViews - 1.0);
        const double off = (offOf(at - 2 / (kViews - 1.0)) + offOf(at + 2 / (kViews - 1.0))) / 2;
        if (view > 0) {
            spacing += (off - before) * (off - before) / (kViews - 1);
            worstSpacing = std::max(worstSpacing, std::abs(off - before));
        }
        before = off;
    }
    std::printf("  spacing of neighbouring views: %.2f %% of a step rms, %.2f %% at most\n",
                100 * (kViews - 1) * std::sqrt(spacing), 100 * (kViews - 1) * worstSpacing);
    const cv::Mat& middle = views[kViews / 2];

    // The axes of the middle view, by a homography to the true view that is near it.
    const auto placeOf = [&](int view) { return first + perPosition * (view / (kViews - 1.0)); };
    const cv::Size size = views[0].size();
    const double focal = world.focalWidths() * one.size.width;
    const cv::Matx33d still(1 / focal, 0, -one.size.width / 2.0 / focal, 0, -1 / focal,
                            one.size.height / 2.0 / focal, 0, 0, 1);
    cv::Matx33d axes =
        still * homography(middle, world.shown(one.size, placeOf(kViews / 2), still), 1);
    axes = axes * homography(middle, world.shown(size, placeOf(kViews / 2), axes), 0.3);
    // The shift of the focus, by the outermost view.
    double perMetre = 0;
    for (int round = 0; round < 2; ++round) {
        const auto at = [&](double shift) {
            return axes + cv::Matx33d(0, 0, shift, 0, 0, 0, 0, 0, 0);
        };
        const double way = placeOf(0)[0] - placeOf(kViews / 2)[0];
        if (round == 0) { // a first guess by the points in the middle of the picture's depth
            double best = -1;
            for (int fiftieth = -50; fiftieth <= 0; ++fiftieth) {
                const double trial = fiftieth / 50.0;
                const cv::Size small(size.width / 8, size.height / 8);
                cv::Mat little;
                cv::resize(views[0], little, small, 0, 0, cv::INTER_AREA);
                const cv::Matx33d eighth(8, 0, 0, 0, 8, 0, 0, 0, 1);
                cv::Mat truth =
                    world.shown(small, placeOf(0), at(trial * way * axes(2, 2)) * eighth);
                const double like = cv::PSNR(little, truth);
                if (like > best) {
                    best = like;
                    perMetre = trial * axes(2, 2);
                }
            }
        }
        const Pairs pairs = pairsOf(views[0], world.shown(size, placeOf(0), at(perMetre * way)));
        std::vector<float> off;
        for (std::size_t i = 0; i < pairs.from.size(); ++i)
            off.push_back(pairs.to[i].x - pairs.from[i].x);
        std::nth_element(off.begin(), off.begin() + static_cast<long>(off.size() / 2), off.end());
        perMetre += static_cast<double>(off[off.size() / 2]) * axes(0, 0) / way;
    }
    std::vector<cv::Mat> frames;
    slideVideo(one.file)([&](const cv::Mat& frame) {
        frames.push_back(frame.clone());
        return true;
    });
    // the other way: views of the middle one and its depth, by the best of several strengths
    altiro3D::Scene scene;
    slide.makeDepth(scene.photo, scene.depth);
    normalizeDepth(scene.depth, scene.depth);
    std::map<double, double> byDepth; // sum of PSNR of each strength, %
    for (int tenths = 4; tenths <= 16; ++tenths)
        byDepth[tenths / 10.0 * report.parallaxPercent] = 0;
    QuiltLayout layout;
    layout.columns = layout.rows = layout.viewCount = 1;
    layout.tileSize = size;
    double made = 0, raw = 0, least = 1e9, rows = 0;
    int count = 0;
    for (int view = 1; view < kViews; view += 9) {
        const double way = placeOf(view)[0] - placeOf(kViews / 2)[0];
        const cv::Matx33d at = axes + cv::Matx33d(0, 0, perMetre * way, 0, 0, 0, 0, 0, 0);
        const cv::Mat truth = world.shown(size, placeOf(view), at);
        std::size_t nearest = 0;
        for (std::size_t i = 0; i < hands.size(); ++i)
            if (std::abs(hands[i].place[0] - placeOf(view)[0]) <
                std::abs(hands[nearest].place[0] - placeOf(view)[0]))
                nearest = i;
        for (auto& [strength, likes] : byDepth) {
            ViewOptions ways;
            ways.method = ViewMethod::Layered;
            ways.strengthPercent = std::min(strength, 100.0);
            cv::Mat rendered;
            Depth2Quilt(layout, ways).renderView(scene, 2.0 * view / (kViews - 1) - 1, rendered);
            likes += likeOf(rendered, truth);
        }
        rows = std::max(rows, rowsOff(views[static_cast<std::size_t>(view)], truth));
        const auto [like, isIn] = lay(views[static_cast<std::size_t>(view)], truth, {});
        const double likeRaw = likeOf(frames[nearest], truth, isIn);
        made += like;
        raw += likeRaw;
        least = std::min(least, like - likeRaw);
        ++count;
    }
    std::printf(
        "  PSNR: made %.2f dB, aligned raw frames %.2f dB, gain %.2f dB, at least %.2f dB\n",
        made / count, raw / count, (made - raw) / count, least);
    std::printf("  rows of the made views: %.2f px from those of the truth in the worst one\n",
                rows);
    const auto best = std::max_element(byDepth.begin(), byDepth.end(),
                                       [](auto& a, auto& b) { return a.second < b.second; });
    std::printf("  PSNR of the middle view and its depth, layered, strength %.1f %%: %.2f dB\n",
                best->first, best->second / count);
}

} // namespace

int main(int argc, char** argv) {
    if (argc > 4 && std::string(argv[1]) == "field") {
        judgeField({argv + 2, argv + argc});
        return 0;
    }
    if (argc != 6) {
        std::cerr << "usage: altiro3D_slide_accuracy make|judge VIDEO boards|terrace PICTURES "
                     "METRES\n       altiro3D_slide_accuracy field VIEW...\n";
        return 2;
    }
    const Boards boards;
    const RayWorld terrace(sampleScene());
    const World* world = &terrace;
    if (std::string(argv[3]) == "boards") world = &boards;
    const Case one{argv[2], *world, shakyHand(std::atoi(argv[4]), std::atof(argv[5])),
                   cv::Size(480, 640)};
    if (std::string(argv[1]) == "make")
        make(one);
    else
        judge(one);
}
