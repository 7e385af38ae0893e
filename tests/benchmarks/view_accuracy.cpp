// altiro3D_view_accuracy: the accuracy of views compared with true pictures from other camera
// positions, and their time.
//
// Usage: altiro3D_view_accuracy [folder of the test data [folder for the views]]
//
// Prints two Markdown tables. The first: the left picture of each Middlebury pair and its true
// disparity are made into the right picture, over the full baseline; `inside` leaves out, at both
// sides, the band that can come from outside the frame. Then the Stanford cards, from the centre to
// the cameras at the sides. The second: time of one view in a quilt of 48, one thread, by the side
// of method Fast. What is missing is named and left out.

#include "altiro3D/trade.hpp"
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
                        return altiro3D::makeFastRenderer(pair.photo, pair.depth, options);
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
        printTimes(pairs);
        return pairs.empty() ? 1 : 0;
    } catch (const std::exception& error) {
        std::cerr << "altiro3D_view_accuracy: error: " << error.what() << "\n";
        return 1;
    }
}
