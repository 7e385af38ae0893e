// altiro3D_view_accuracy: the accuracy of views of stereo pairs compared with true pictures from
// other camera positions. altiro3Dtradeoff measures the accuracy and the time of methods.
//
// Usage: altiro3D_view_accuracy [folder of the test data]
//
// Prints a Markdown table: views by method Layered from the true depth, from the depth found by
// matching the pair, and from estimated depth, which is scaled and shifted to the true one (to the
// matched one where the truth is missing); at half the baseline and beyond it where true views
// exist. What is missing is named and left out.

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
#include <iostream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using altiro3D::LayeredSettings;

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

std::vector<EyesWithViews> stereoScenes(const fs::path& data) {
    std::vector<EyesWithViews> scenes;
    for (const altiro3D::StereoScene& scene : altiro3D::test::readMiddlebury(data / "middlebury")) {
        scenes.push_back({scene.name,
                          scene.photo,
                          scene.truth,
                          {{1, scene.truth}},
                          scene.depth * scene.largestDisparity});
    }
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

} // namespace

int main(int argc, char** argv) {
    try {
        cv::setNumThreads(1);
        const fs::path data = argc > 1 ? fs::path(argv[1]) : altiro3D::test::dataPath("");
        const std::vector<EyesWithViews> scenes = stereoScenes(data);
        printStereo(scenes);
        return scenes.empty() ? 1 : 0;
    } catch (const std::exception& error) {
        std::cerr << "altiro3D_view_accuracy: error: " << error.what() << "\n";
        return 1;
    }
}
