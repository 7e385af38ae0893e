// altiro3D_view_accuracy: the accuracy of views compared with true pictures from other camera
// positions, and their time.
//
// Usage: altiro3D_view_accuracy [folder of the test data [folder for the views]]
//
// Prints Markdown tables. The first: the left picture of each Middlebury pair and its true
// disparity are made into the right picture, over the full baseline; `inside` leaves out, at both
// sides, the band that can come from outside the frame. Then the Stanford cards, from the centre to
// the cameras at the sides. The second: views of stereo pairs by method Layered from the true
// depth, from the depth found by matching the pair, and from estimated depth, which is scaled and
// shifted to the true one (to the matched one where the truth is missing); at half the baseline and
// beyond it where true views exist. The third: time of one view in a quilt of 48, one thread, by
// the side of method Fast. What is missing is named and left out.

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_map.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/photo_fit.hpp"
#include "support/files.hpp"
#include "support/middlebury.hpp"
#include "views/view_methods.hpp"
#include "views/view_renderer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using altiro3D::LayeredFill;
using altiro3D::LayeredSettings;
using altiro3D::ViewRenderer;

struct Pair {
    std::string name;
    cv::Mat photo; // [rows x cols, CV_8UC3, BGR]
    cv::Mat truth; // [as photo]
    cv::Mat depth; // [as photo, CV_32FC1, 0..1]
    double focus = 0;
    double shift = 0; // px
    int band = 0;     // columns at each side that may show what the photo does not
};

struct Method {
    std::string name;
    std::function<std::unique_ptr<ViewRenderer>(const Pair&)> make;
};

std::vector<Method> methods() {
    std::vector<Method> list;
    list.push_back({"Fast", [](const Pair& pair) {
                        altiro3D::ViewOptions options;
                        options.focus = pair.focus;
                        return altiro3D::makeFastRenderer(pair.photo, pair.depth, options,
                                                          std::abs(pair.shift));
                    }});
    list.push_back({"Real", [](const Pair& pair) {
                        return altiro3D::makeRealRenderer(pair.photo, pair.depth, pair.focus, {});
                    }});
    const auto layered = [&](const std::string& name, const LayeredSettings& options) {
        list.push_back({name, [options](const Pair& pair) {
                            LayeredSettings fitting = options;
                            fitting.reachPixels = std::abs(pair.shift);
                            return altiro3D::makeLayeredRenderer(pair.photo, pair.depth, pair.focus,
                                                                 fitting);
                        }});
    };
    LayeredSettings options;
    layered("Layered", options);
    options.fill = LayeredFill::Continue;
    layered("Layered, fill Continue", options);
    return list;
}

std::vector<Pair> middlebury(const fs::path& folder) {
    std::vector<Pair> pairs;
    for (const altiro3D::StereoScene& scene : altiro3D::test::readMiddlebury(folder)) {
        pairs.push_back({scene.name, scene.photo, scene.truth, scene.depth, 0,
                         scene.largestDisparity, scene.band()});
    }
    return pairs;
}

// Camera c8 is the centre; shift in x from there to c(8+k) is k 0.195 (v - 127.8) px, v the value
// in depth_center.png (see the README there): what is near has the small values.
std::vector<Pair> cards(const fs::path& folder) {
    std::vector<Pair> pairs;
    const cv::Mat centre = cv::imread((folder / "r08_c08.jpg").string());
    const cv::Mat raw = cv::imread((folder / "depth_center.png").string(), cv::IMREAD_GRAYSCALE);
    if (centre.empty() || raw.size() != centre.size()) {
        std::cout << "missing or unreadable: " << folder.string() << "\n\n";
        return pairs;
    }
    for (const int column : {0, 4, 12, 16}) {
        Pair pair;
        char name[32];
        std::snprintf(name, sizeof(name), "r08_c%02d.jpg", column);
        pair.name = "cards c" + std::to_string(column);
        pair.photo = centre;
        pair.truth = cv::imread((folder / name).string());
        if (pair.truth.size() != centre.size()) continue;
        raw.convertTo(pair.depth, CV_32F, -1 / 255.0, 1);
        pair.focus = 1 - 127.8 / 255;
        pair.shift = (column - 8) * 0.195 * 255;
        pair.band = static_cast<int>(std::ceil(std::abs(pair.shift) * 0.51)) + 2;
        pairs.push_back(pair);
    }
    return pairs;
}

struct Quality {
    double values[4] = {0, 0, 0, 0}; // PSNR and SSIM whole, PSNR and SSIM inside
};

void printRow(const std::string& scene, const std::string& method, const Quality& quality) {
    std::printf("| %s | %s | %.2f / %.4f | %.2f / %.4f |\n", scene.c_str(), method.c_str(),
                quality.values[0], quality.values[1], quality.values[2], quality.values[3]);
}

void printAccuracy(const std::string& title, const std::vector<Pair>& pairs,
                   const fs::path& views) {
    if (pairs.empty()) return;
    std::printf("| %s | method | whole: PSNR / SSIM | inside: PSNR / SSIM |\n|---|---|---|---|\n",
                title.c_str());
    for (const Method& method : methods()) {
        Quality mean;
        for (const Pair& pair : pairs) {
            cv::Mat view(pair.photo.size(), CV_8UC3);
            method.make(pair)->render(pair.shift, view);
            const cv::Range inside(pair.band, view.cols - pair.band);
            const Quality quality{
                {altiro3D::psnr(view, pair.truth), altiro3D::ssim(view, pair.truth),
                 altiro3D::psnr(view.colRange(inside), pair.truth.colRange(inside)),
                 altiro3D::ssim(view.colRange(inside), pair.truth.colRange(inside))}};
            printRow(pair.name, method.name, quality);
            for (int i = 0; i < 4; ++i)
                mean.values[i] += quality.values[i] / static_cast<double>(pairs.size());
            if (!views.empty())
                cv::imwrite((views / (pair.name + ", " + method.name + ".png")).string(), view);
        }
        printRow("mean", method.name, mean);
    }
    std::printf("\n");
}

// --- Stereo pairs --------------------------------------------------------------------------------

// A view at a multiple of the baseline; the left picture is at 0, the right one at 1.
struct TrueView {
    double at = 1;
    cv::Mat picture;
};

struct EyesWithViews {
    std::string name;
    cv::Mat left;
    cv::Mat right;
    std::vector<TrueView> views;
    cv::Mat disparity; // true, px of the left picture; may be empty
};

std::vector<EyesWithViews> stereoScenes(const fs::path& data, const std::vector<Pair>& middlebury) {
    std::vector<EyesWithViews> scenes;
    for (const Pair& pair : middlebury)
        scenes.push_back(
            {pair.name, pair.photo, pair.truth, {{1, pair.truth}}, pair.depth * pair.shift});
    const auto add = [&](const std::string& name, const fs::path& folder, const char* left,
                         const char* right,
                         const std::vector<std::pair<double, const char*>>& others) {
        EyesWithViews scene{name,
                            cv::imread((folder / left).string()),
                            cv::imread((folder / right).string()),
                            {},
                            {}};
        for (const auto& [at, file] : others)
            scene.views.push_back({at, cv::imread((folder / file).string())});
        scene.views.push_back({1, scene.right});
        std::sort(scene.views.begin(), scene.views.end(),
                  [](const TrueView& a, const TrueView& b) { return a.at < b.at; });
        for (const TrueView& view : scene.views) {
            if (view.picture.empty() || view.picture.size() != scene.left.size()) {
                std::cout << "missing or unreadable: " << folder.string() << "\n\n";
                return;
            }
        }
        scenes.push_back(scene);
    };
    add("Stanford cards", data / "lightfields" / "stanford_cards", "r08_c04.jpg", "r08_c12.jpg",
        {{0.5, "r08_c08.jpg"}, {1.5, "r08_c16.jpg"}});
    add("GreenBuddha", data / "lightfields" / "greenbuddha_33", "GreenBuddha010.jpg",
        "GreenBuddha018.jpg", {{0.5, "GreenBuddha014.jpg"}, {1.5, "GreenBuddha022.jpg"}});
    return scenes;
}

// Disparities by matching in px, in the size of the picture, and what only the right eye sees.
cv::Mat matchedDisparity(const EyesWithViews& scene, std::string& text,
                         altiro3D::HiddenLayer& hidden) {
    cv::Mat shares;
    const altiro3D::StereoMatch match =
        altiro3D::matchStereo(scene.left, scene.right, shares, &hidden);
    hidden.depth *= scene.left.cols; // px
    char likeness[32];
    std::snprintf(likeness, sizeof likeness, ", likeness %.2f", match.likeness);
    text = match.text() + likeness;
    double low = 0;
    double high = 0;
    cv::minMaxLoc(shares, &low, &high);
    altiro3D::DepthNormalization whole;
    whole.lowPercentile = 0;
    whole.highPercentile = 100;
    cv::Mat depth;
    altiro3D::normalizeDepth(shares, depth, whole);
    altiro3D::fitDepth(depth, {0, 0, double(depth.cols), double(depth.rows)}, scene.left, depth);
    return (depth * (high - low) + low) * scene.left.cols;
}

struct ViewPsnr {
    double whole = 0;
    double inside = 0;
};

// @param edges of the disparity
// @param hidden with disparities in px instead of depth
ViewPsnr measureView(const EyesWithViews& scene, const cv::Mat& disparity, const TrueView& truth,
                     altiro3D::DepthEdges edges, const altiro3D::HiddenLayer& hidden = {}) {
    double low = 0;
    double high = 0;
    cv::minMaxLoc(disparity, &low, &high);
    altiro3D::Scene refined{scene.left, (disparity - low) / (high - low), {}, {}, edges};
    refineScene(refined);
    const cv::Mat& depth = refined.depth;
    LayeredSettings settings;
    settings.mixedPixels = refined.mixedPixels;
    const double reach = truth.at * std::max(std::abs(low), std::abs(high));
    settings.reachPixels = reach;
    if (!hidden.photo.empty()) {
        altiro3D::Scene fitted;
        altiro3D::Scene whole{scene.left, depth, {hidden.photo, {}}};
        whole.hidden.depth = (hidden.depth - low) / (high - low);
        altiro3D::fitScene(
            whole,
            altiro3D::fitPhoto(scene.left.size(), 1, scene.left.size(), altiro3D::FitMode::Stretch),
            0.5, fitted, {altiro3D::DepthFlaws()});
        settings.hidden = fitted.hidden;
    }
    cv::Mat view(scene.left.size(), CV_8UC3);
    altiro3D::makeLayeredRenderer(scene.left, depth, -low / (high - low), settings)
        ->render(truth.at * (high - low), view);
    const int band = static_cast<int>(std::ceil(reach)) + 2;
    const cv::Range inside(band, view.cols - band);
    return {altiro3D::psnr(view, truth.picture),
            altiro3D::psnr(view.colRange(inside), truth.picture.colRange(inside))};
}

void printStereo(const std::vector<EyesWithViews>& scenes) {
    std::printf(
        "| pair | order, matched | order, estimated | view at | true | matched | with the right "
        "picture | estimated |\n|---|---:|---:|---:|---:|---:|---:|---:|\n");
    const auto source = altiro3D::estimatedDepth();
    std::string notes;
    for (const EyesWithViews& scene : scenes) {
        std::string text;
        const auto start = std::chrono::steady_clock::now();
        altiro3D::HiddenLayer hidden;
        const cv::Mat matched = matchedDisparity(scene, text, hidden);
        const std::chrono::duration<double, std::milli> time =
            std::chrono::steady_clock::now() - start;
        notes += "- " + scene.name + ": " + text + "; " +
                 std::to_string(static_cast<int>(time.count())) + " ms\n";
        altiro3D::Scene guess;
        source->readScene(scene.left, 0.5, guess);
        altiro3D::fitDepth(guess.depth, {0, 0, double(guess.depth.cols), double(guess.depth.rows)},
                           scene.left, guess.depth);
        const cv::Mat& truth = scene.disparity.empty() ? matched : scene.disparity;
        double low = 0;
        double high = 0;
        cv::minMaxLoc(truth, &low, &high);
        cv::Mat estimated;
        const double estimatedOrder = altiro3D::rankCorrelation(guess.depth, truth);
        altiro3D::alignDepth(guess.depth, (truth - low) / (high - low), estimated);
        estimated = estimated * (high - low) + low;
        for (const TrueView& view : scene.views) {
            std::printf("| %s |", scene.name.c_str());
            if (scene.disparity.empty()) {
                std::printf(" | |");
            } else {
                std::printf(" %.3f | %.3f |", altiro3D::rankCorrelation(matched, truth),
                            estimatedOrder);
            }
            std::printf(" %.1f |", view.at);
            const auto print = [&](const cv::Mat& disparity, altiro3D::DepthEdges edges,
                                   const altiro3D::HiddenLayer& behind = {}) {
                if (disparity.empty()) {
                    std::printf(" |");
                    return;
                }
                const ViewPsnr psnr = measureView(scene, disparity, view, edges, behind);
                std::printf(" %.2f / %.2f |", psnr.whole, psnr.inside);
            };
            print(scene.disparity, altiro3D::DepthEdges::Unknown);
            print(matched, altiro3D::DepthEdges::Matched);
            print(matched, altiro3D::DepthEdges::Matched, hidden);
            print(estimated, altiro3D::DepthEdges::Unknown);
            std::printf("\n");
        }
    }
    std::printf("\nPSNR in dB, whole / inside. %d threads.\n\n%s\n", cv::getNumThreads(),
                notes.c_str());
}

// --- Times ---------------------------------------------------------------------------------------

// Best of some runs, ms.
double milliseconds(const std::function<void()>& work) {
    double best = 1e9;
    for (int run = 0; run < 5; ++run) {
        const auto start = std::chrono::steady_clock::now();
        work();
        const std::chrono::duration<double, std::milli> time =
            std::chrono::steady_clock::now() - start;
        best = std::min(best, time.count());
    }
    return best;
}

// 48 views of 420 x 560 at strength 10 %.
void printTimes(const std::vector<Pair>& pairs) {
    constexpr int kViews = 48;
    const cv::Size size(420, 560);
    std::printf("| scene | method | preparation, ms | view, ns/px | view / Fast | with preparation "
                "/ Fast |\n|---|---|---:|---:|---:|---:|\n");
    for (const Pair& original : pairs) {
        Pair pair = original;
        cv::resize(original.photo, pair.photo, size, 0, 0, cv::INTER_AREA);
        cv::resize(original.depth, pair.depth, size, 0, 0, cv::INTER_NEAREST);
        pair.shift = 0.1 * size.width / 2;
        pair.focus = 0.5;
        double fast = 0;
        for (const Method& method : methods()) {
            std::unique_ptr<ViewRenderer> renderer;
            const double preparation = milliseconds([&] { renderer = method.make(pair); });
            cv::Mat view(size, CV_8UC3);
            const double all = milliseconds([&] {
                for (int i = 0; i < kViews; ++i)
                    renderer->render((2.0 * i / (kViews - 1) - 1) * pair.shift, view);
            });
            if (fast == 0) fast = all;
            std::printf("| %s | %s | %.1f | %.2f | %.2f | %.2f |\n", pair.name.c_str(),
                        method.name.c_str(), preparation, all * 1e6 / kViews / size.area(),
                        all / fast, (all + preparation) / fast);
        }
    }
}

} // namespace

int main(int argc, char** argv) {
    try {
        cv::setNumThreads(1);
        const fs::path data = argc > 1 ? fs::path(argv[1]) : altiro3D::test::dataPath("");
        const fs::path views = argc > 2 ? fs::path(argv[2]) : fs::path();
        const std::vector<Pair> pairs = middlebury(data / "middlebury");
        printAccuracy("Middlebury", pairs, views);
        printAccuracy("Stanford", cards(data / "lightfields" / "stanford_cards"), views);
        printStereo(stereoScenes(data, pairs));
        printTimes(pairs);
        return pairs.empty() ? 1 : 0;
    } catch (const std::exception& error) {
        std::cerr << "altiro3D_view_accuracy: error: " << error.what() << "\n";
        return 1;
    }
}
