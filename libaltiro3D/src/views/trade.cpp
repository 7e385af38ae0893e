#include "altiro3D/depth2quilt.hpp"

#include "base/checks.hpp"
#include "base/pixel_rows.hpp"
#include "depth/map/depth_values.hpp"
#include "views/view_methods.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace altiro3D {

namespace {

// Disparity in px; NaN where it is unknown.
float disparityOf(float raw, double scale) {
    const bool known = std::isfinite(raw) && raw > 0;
    return known ? static_cast<float>(static_cast<double>(raw) / scale)
                 : std::numeric_limits<float>::quiet_NaN();
}

} // namespace

std::vector<NamedViewOptions> defaultSettings(const ViewOptions& base) {
    std::vector<NamedViewOptions> settings;
    const std::pair<const char*, ViewMethod> kMethods[] = {
        {"fast", ViewMethod::Fast}, {"layered", ViewMethod::Layered}, {"real", ViewMethod::Real}};
    for (const auto& [name, method] : kMethods) {
        settings.push_back({name, base});
        settings.back().options.method = method;
    }
    return settings;
}

std::vector<NamedViewOptions> tradeSettings(const ViewOptions& base) {
    std::vector<NamedViewOptions> settings;
    const auto add = [&](const std::string& name, const auto& change) {
        ViewOptions options = base;
        change(options);
        settings.push_back({name, options});
    };
    for (int steps : {0, 1, 2, 4}) {
        add(steps == 0 ? "fast" : "fast, refinement " + std::to_string(steps),
            [steps](ViewOptions& o) {
                o.method = ViewMethod::Fast;
                o.refinement = steps;
            });
    }
    const auto layered = [&](const std::string& name, const auto& change) {
        add(name, [&](ViewOptions& o) {
            o.method = ViewMethod::Layered;
            change(o.layered);
        });
    };
    layered("layered, fill continue", [](LayeredOptions& o) { o.fill = LayeredFill::Continue; });
    layered("layered, hard borders", [](LayeredOptions& o) { o.softBorders = false; });
    layered("layered, dilation 0", [](LayeredOptions& o) { o.edgeDilationPixels = 0; });
    layered("layered, dilation 2", [](LayeredOptions& o) { o.edgeDilationPixels = 2; });
    const auto real = [&](const std::string& name, const auto& change) {
        add(name, [&](ViewOptions& o) {
            o.method = ViewMethod::Real;
            change(o.real);
        });
    };
    real("real", [](RealOptions&) {});
    real("real, Navier-Stokes", [](RealOptions& o) { o.inpainting = Inpainting::NavierStokes; });
    real("real, from behind", [](RealOptions& o) { o.backgroundOnly = true; });
    layered("layered", [](LayeredOptions&) {}); // the reference if there is no ground truth
    return settings;
}

ViewCost measureViews(const Scene& scene, const ViewOptions& options, int views,
                      int repetitions) try {
    checkRange("views", views, 1, 1024);
    checkRange("repetitions", repetitions, 1, 1000);
    checkType(scene.photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    // Tiles of the photo's size in a quilt that is as square as possible.
    const int columns = static_cast<int>(std::ceil(std::sqrt(views)));
    const QuiltLayout layout{columns, (views + columns - 1) / columns, scene.photo.size(), views};
    const auto milliseconds = [&](const auto& work) {
        double best = std::numeric_limits<double>::infinity();
        for (int i = 0; i < repetitions; ++i) {
            const auto start = std::chrono::steady_clock::now();
            work();
            const auto end = std::chrono::steady_clock::now();
            best = std::min(best, std::chrono::duration<double, std::milli>(end - start).count());
        }
        return best;
    };
    const Depth2Quilt maker(layout, options);
    cv::Mat quilt;
    const double all = milliseconds([&] { maker.render(scene, quilt); });
    const double preparation =
        milliseconds([&] { static_cast<void>(makeRenderer(scene, options, 1)); });
    return {all / views, std::min(preparation, all)};
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

ViewAccuracy compareViews(const cv::Mat& view, const cv::Mat& truth, int band) try {
    check(band >= 0, "band", "is " + std::to_string(band) + ", expected at least 0 px");
    ViewAccuracy accuracy;
    accuracy.psnrWhole = psnr(view, truth);
    accuracy.ssimWhole = ssim(view, truth);
    const cv::Range columns =
        band < view.cols - band ? cv::Range(band, view.cols - band) : cv::Range::all();
    accuracy.psnrInside = psnr(view.colRange(columns), truth.colRange(columns));
    accuracy.ssimInside = ssim(view.colRange(columns), truth.colRange(columns));
    return accuracy;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

ViewOptions StereoScene::options(const ViewOptions& knobs) const {
    ViewOptions result = knobs;
    result.focus = 0;
    result.strengthPercent = 200 * largestDisparity / photo.cols; // S/2 = largest disparity
    return result;
}

int StereoScene::band() const {
    return static_cast<int>(std::ceil(largestDisparity)) + 2;
}

StereoScene makeStereoScene(const std::string& name, const cv::Mat& photo,
                            const cv::Mat& rawDisparity, double scale, const cv::Mat& truth) try {
    checkType(photo, {CV_8UC3}, "photo", "CV_8UC3 (8-bit BGR)");
    checkType(rawDisparity, {CV_32FC1}, "disparity", "CV_32FC1");
    checkType(truth, {CV_8UC3}, "truth", "CV_8UC3 (8-bit BGR)");
    check(scale > 0 && std::isfinite(scale), "disparity scale",
          "is " + numberText(scale) + ", expected a number > 0");
    checkSize(rawDisparity.size(), photo.size(), name + ": disparity", "the photo's ");
    checkSize(truth.size(), photo.size(), name + ": truth", "the photo's ");
    StereoScene scene;
    scene.name = name;
    scene.photo = photo;
    scene.truth = truth;
    scene.depth =
        mapped<float, float>(rawDisparity, [=](float raw) { return disparityOf(raw, scale); });
    float largest = 0;
    for (int y = 0; y < photo.rows; ++y) {
        float* row = scene.depth.ptr<float>(y);
        if (!fillUnknown(row, photo.cols)) std::fill(row, row + photo.cols, 0.0F);
        largest = std::max(largest, *std::max_element(row, row + photo.cols));
    }
    check(largest <= static_cast<float>(photo.cols), "disparity",
          "reaches " + numberText(static_cast<double>(largest)) +
              " px, expected at most the photo's " + std::to_string(photo.cols) +
              " px; is the scale right?");
    scene.largestDisparity = static_cast<double>(largest);
    if (largest >= std::numeric_limits<float>::min())
        scene.depth.convertTo(scene.depth, CV_32F, 1.0 / scene.largestDisparity);
    return scene;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
