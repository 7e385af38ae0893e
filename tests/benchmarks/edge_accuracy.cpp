// altiro3D_edge_accuracy: what wrong depth edges cost, and how much of it refinement wins back.
//
// Usage: altiro3D_edge_accuracy [--scenes] [--blur SIGMA] [folder with scenes.csv [start of a
//        depth's name...]]
//
// The left picture of each Middlebury pair becomes the right picture, over the full baseline, with
// its true disparity and with depth that is wrong in known ways. Prints a Markdown table: PSNR in
// dB / SSIM inside the frame, means over the scenes. `widened` is Layered with depth edges that
// were moved outwards by 2 px, as iw3 does to hide soft edges. --scenes also prints a row per
// scene; --blur makes photo and truth soft by a Gaussian filter of SIGMA px. The default folder is
// middlebury in the test data.

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_map.hpp"
#include "altiro3D/depth_network.hpp"
#include "altiro3D/depth_source.hpp"
#include "altiro3D/photo_fit.hpp"
#include "support/files.hpp"
#include "support/middlebury.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using altiro3D::DepthSource;
using altiro3D::StereoScene;
using altiro3D::ViewMethod;

// A way in which depth is wrong: true depth -> wrong depth.
struct Flaw {
    std::string name;
    std::function<cv::Mat(const StereoScene&)> apply;
};

cv::Mat disc(int radius) {
    return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

cv::Mat grown(const cv::Mat& depth, int pixels) {
    cv::Mat result;
    if (pixels >= 0) cv::dilate(depth, result, disc(pixels));
    if (pixels < 0) cv::erode(depth, result, disc(-pixels));
    return result;
}

// What a source makes of the photo, with the edges of the source and the values of the truth: the
// best a + b x around each px (He et al. 2010).
Flaw estimated(const std::string& name, const std::shared_ptr<DepthSource>& source) {
    return {
        name, [source](const StereoScene& scene) {
            altiro3D::Scene made;
            source->readScene(scene.photo, 0.5, made);
            cv::Mat guide;
            const cv::Rect2d all(cv::Point2d(), cv::Size2d(made.depth.size()));
            altiro3D::fitDepth(made.depth, all, scene.photo, guide);
            const auto mean = [](const cv::Mat& values) {
                cv::Mat result;
                cv::boxFilter(values, result, CV_32F, {81, 81}, {-1, -1}, true, cv::BORDER_REFLECT);
                return result;
            };
            const cv::Mat meanGuide = mean(guide);
            const cv::Mat meanTruth = mean(scene.depth);
            const cv::Mat variance = mean(guide.mul(guide)) - meanGuide.mul(meanGuide);
            const cv::Mat both = mean(guide.mul(scene.depth)) - meanGuide.mul(meanTruth);
            const cv::Mat slope = both / (variance + 1e-4);
            const cv::Mat offset = meanTruth - slope.mul(meanGuide);
            const cv::Mat result = mean(slope).mul(guide) + mean(offset);
            return cv::Mat(cv::min(cv::max(result, 0), 1));
        }};
}

// Depth by the network `altiro3d`.
Flaw estimatedFlaw() {
    const auto catalog =
        altiro3D::readModelCatalog(altiro3D::test::sourcePath("models/catalog.json"));
    const fs::path file = altiro3D::test::sourcePath("models/altiro3d-depth.onnx");
    const altiro3D::NetworkProfile* profile = altiro3D::findProfile(catalog, file);
    if (profile == nullptr) throw std::runtime_error(file.string() + " is not in the catalogue");
    return estimated("our network", altiro3D::depthFromNetworkFile(file, *profile));
}

std::vector<Flaw> flaws() {
    std::vector<Flaw> list;
    list.push_back({"exact", [](const StereoScene& scene) { return scene.depth.clone(); }});
    const auto narrow = [](const std::string& name, int width, int enlargement) {
        return Flaw{name, [width, enlargement](const StereoScene& scene) {
                        const cv::Size size = scene.depth.size();
                        cv::Mat result;
                        cv::resize(scene.depth, result,
                                   {width, std::max(1, width * size.height / size.width)}, 0, 0,
                                   cv::INTER_AREA);
                        cv::resize(result, result, size, 0, 0, enlargement);
                        return cv::Mat(cv::min(cv::max(result, 0), 1));
                    }};
    };
    for (const int width : {128, 256, 384})
        list.push_back(narrow(std::to_string(width) + " px wide", width, cv::INTER_CUBIC));
    for (const int width : {128, 256})
        list.push_back(narrow(std::to_string(width) + " px, linear", width, cv::INTER_LINEAR));
    for (const int sigma : {2, 4}) {
        list.push_back({"blur, sigma " + std::to_string(sigma) + " px", [sigma](const auto& scene) {
                            cv::Mat result;
                            cv::GaussianBlur(scene.depth, result, {}, sigma);
                            return result;
                        }});
    }
    for (const int pixels : {-2, -3, 2, 3}) {
        list.push_back(
            {std::to_string(std::abs(pixels)) + (pixels < 0 ? " px too small" : " px too large"),
             [pixels](const auto& scene) { return grown(scene.depth, pixels); }});
    }
    for (const int pixels : {1, 2}) {
        list.push_back(
            {"shifted by " + std::to_string(pixels) + " px", [pixels](const auto& scene) {
                 cv::Mat result;
                 cv::copyMakeBorder(scene.depth, result, 0, 0, pixels, 0, cv::BORDER_REPLICATE);
                 return result.colRange(0, scene.depth.cols).clone();
             }});
    }
    list.push_back(estimatedFlaw());
    return list;
}

struct Way {
    std::string name;
    ViewMethod method;
    std::function<altiro3D::Scene(const StereoScene&, const cv::Mat& depth)> prepare;
};

std::vector<Way> ways() {
    const auto asItIs = [](const StereoScene& scene, const cv::Mat& depth) {
        return altiro3D::Scene{scene.photo, depth};
    };
    const auto refined = [](const StereoScene& scene, const cv::Mat& depth) {
        altiro3D::Scene result{scene.photo, depth};
        refineScene(result);
        return result;
    };
    const auto widened = [](const StereoScene& scene, const cv::Mat& depth) {
        return altiro3D::Scene{scene.photo, grown(depth, 2)};
    };
    return {{"fast", ViewMethod::Fast, asItIs},
            {"real", ViewMethod::Real, asItIs},
            {"widened", ViewMethod::Layered, widened},
            {"layered", ViewMethod::Layered, asItIs},
            {"real, refined", ViewMethod::Real, refined},
            {"layered, refined", ViewMethod::Layered, refined}};
}

struct Quality {
    double psnr = 0;
    double ssim = 0;
};

Quality measure(const StereoScene& scene, const cv::Mat& wrong, const Way& way) {
    altiro3D::ViewOptions options;
    options.method = way.method;
    cv::Mat view;
    altiro3D::Depth2Quilt({1, 1, scene.photo.size(), 1}, scene.options(options))
        .renderView(way.prepare(scene, wrong), 1, view);
    const altiro3D::ViewAccuracy accuracy = altiro3D::compareViews(view, scene.truth, scene.band());
    return {accuracy.psnrInside, accuracy.ssimInside};
}

void printRow(const std::string& name, const std::vector<Quality>& qualities) {
    std::printf("| %s |", name.c_str());
    for (const Quality& quality : qualities)
        std::printf(" %.2f / %.3f |", quality.psnr, quality.ssim);
    std::printf("\n");
}

void printTable(const std::vector<StereoScene>& scenes, const std::vector<std::string>& wanted,
                bool perScene) {
    const std::vector<Way> columns = ways();
    std::printf("| depth |");
    for (const Way& way : columns)
        std::printf(" %s |", way.name.c_str());
    std::printf("\n|---|");
    for (std::size_t i = 0; i < columns.size(); ++i)
        std::printf("---|");
    std::printf("\n");
    for (const Flaw& flaw : flaws()) {
        const auto isThis = [&](const std::string& start) {
            return flaw.name.rfind(start, 0) == 0;
        };
        if (!wanted.empty() && std::none_of(wanted.begin(), wanted.end(), isThis)) continue;
        std::vector<Quality> means(columns.size());
        std::vector<std::vector<Quality>> rows(scenes.size());
        std::vector<cv::Mat> wrong;
        for (const StereoScene& scene : scenes)
            wrong.push_back(flaw.apply(scene));
        cv::parallel_for_(cv::Range(0, static_cast<int>(scenes.size())),
                          [&](const cv::Range& part) {
                              for (int i = part.start; i < part.end; ++i) {
                                  const auto at = static_cast<std::size_t>(i);
                                  for (const Way& way : columns)
                                      rows[at].push_back(measure(scenes[at], wrong[at], way));
                              }
                          });
        for (std::size_t scene = 0; scene < scenes.size(); ++scene) {
            for (std::size_t i = 0; i < columns.size(); ++i) {
                means[i].psnr += rows[scene][i].psnr / static_cast<double>(scenes.size());
                means[i].ssim += rows[scene][i].ssim / static_cast<double>(scenes.size());
            }
            if (perScene) printRow(flaw.name + ", " + scenes[scene].name, rows[scene]);
        }
        printRow(flaw.name, means);
        std::fflush(stdout);
    }
}

} // namespace

int main(int argc, char** argv) {
    try {
        std::vector<std::string> arguments(argv + 1, argv + argc);
        const bool perScene = !arguments.empty() && arguments.front() == "--scenes";
        if (perScene) arguments.erase(arguments.begin());
        double sigma = 0;
        if (arguments.size() > 1 && arguments.front() == "--blur") {
            sigma = std::stod(arguments[1]);
            arguments.erase(arguments.begin(), arguments.begin() + 2);
        }
        const fs::path folder = arguments.empty() ? altiro3D::test::dataPath("middlebury")
                                                  : fs::path(arguments.front());
        if (!arguments.empty()) arguments.erase(arguments.begin());
        std::vector<StereoScene> scenes = altiro3D::test::readMiddlebury(folder);
        for (StereoScene& scene : scenes) {
            if (sigma <= 0) break;
            for (cv::Mat* const picture : {&scene.photo, &scene.truth})
                cv::GaussianBlur(*picture, *picture, {}, sigma);
        }
        if (!scenes.empty()) printTable(scenes, arguments, perScene);
        return scenes.empty() ? 1 : 0;
    } catch (const std::exception& error) {
        std::cerr << "altiro3D_edge_accuracy: error: " << error.what() << "\n";
        return 1;
    }
}
