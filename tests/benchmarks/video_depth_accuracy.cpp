// altiro3D_video_depth_accuracy: the steadiness of the depth of videos, its accuracy between
// inferences, and its time.
//
// Usage: altiro3D_video_depth_accuracy [folder of the test data]
//
// Prints the Markdown tables of docs/lab/video.md, which also explains the columns. The network is
// FastDepth; it runs once on every picture, and its output is kept. Missing inputs are reported and
// skipped.

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_map.hpp"
#include "altiro3D/depth_network.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/video_depth.hpp"
#include "altiro3D/video_io.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <iostream>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using altiro3D::VideoDepth;
using altiro3D::VideoDepthOptions;
using altiro3D::VideoDepthStep;

struct Clip {
    std::string name;
    std::vector<cv::Mat> pictures; // [CV_8UC3, BGR]
    std::vector<cv::Mat> raw;      // of the network [CV_32FC1, metres]
};

double millisecondsSince(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
        .count();
}

Clip readClip(const fs::path& file, altiro3D::DepthNetwork& network, double& inferenceMs) {
    Clip clip;
    clip.name = file.stem().string();
    altiro3D::VideoReader reader(file);
    while (auto frame = reader.next())
        clip.pictures.push_back(frame->picture);
    const auto begin = std::chrono::steady_clock::now();
    for (const cv::Mat& picture : clip.pictures) {
        clip.raw.emplace_back();
        network.infer(picture, clip.raw.back());
    }
    inferenceMs = millisecondsSince(begin) / static_cast<double>(clip.pictures.size());
    return clip;
}

// Each picture's depth for itself.
std::vector<cv::Mat> depthPerPicture(const Clip& clip, double lowPercentile,
                                     double highPercentile) {
    altiro3D::DepthNormalization options;
    options.kind = altiro3D::DepthKind::Metric;
    options.lowPercentile = lowPercentile;
    options.highPercentile = highPercentile;
    std::vector<cv::Mat> depths(clip.raw.size());
    for (std::size_t i = 0; i < depths.size(); ++i)
        altiro3D::normalizeDepth(clip.raw[i], depths[i], options);
    return depths;
}

struct Run {
    std::vector<cv::Mat> depths;
    std::vector<char> inferred;
    double inferredShare = 0;
    double ms = 0; // of all processors per picture, without the network
    int cuts = 0;
};

Run runVideoDepth(const Clip& clip, const VideoDepthOptions& options) {
    std::size_t at = 0;
    VideoDepth video([&](const cv::Mat&, cv::Mat& raw) { raw = clip.raw[at]; },
                     altiro3D::DepthKind::Metric, options);
    Run run;
    for (; at < clip.pictures.size(); ++at) {
        cv::Mat depth;
        const std::clock_t begin = std::clock();
        const VideoDepthStep step = video.next(clip.pictures[at], depth);
        run.ms += 1000.0 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        run.inferred.push_back(step.inferred ? 1 : 0);
        run.inferredShare += step.inferred ? 1 : 0;
        run.cuts += step.cut ? 1 : 0;
        run.depths.push_back(depth);
    }
    const auto count = static_cast<double>(clip.pictures.size());
    run.inferredShare /= count;
    run.ms /= count;
    return run;
}

// --- What stands still and what moves ------------------------------------------------------------

struct Regions {
    cv::Mat still;  // [depth's size, CV_8UC1, 0 or 255]
    cv::Mat moving; // likewise; what is neither is in neither
};

cv::Mat greyAt(const cv::Mat& picture, cv::Size size) {
    cv::Mat grey;
    cv::resize(picture, grey, size, 0, 0, cv::INTER_AREA);
    cv::cvtColor(grey, grey, cv::COLOR_BGR2GRAY);
    grey.convertTo(grey, CV_32F);
    return grey;
}

// From two pictures that follow each other: the difference of brightness, less its median (the
// camera's exposure changes), as the mean of 5 x 5 px: up to 2 levels still, above 8 moving.
Regions regionsOf(const cv::Mat& before, const cv::Mat& now, cv::Size size) {
    cv::Mat difference = greyAt(now, size) - greyAt(before, size);
    std::vector<float> sorted(difference.begin<float>(), difference.end<float>());
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    difference = cv::abs(difference - static_cast<double>(*middle));
    cv::blur(difference, difference, cv::Size(5, 5));
    return {difference <= 2, difference > 8};
}

// --- Measures ------------------------------------------------------------------------------------

// Mean absolute change from picture to picture where nothing moves.
double flickerOf(const std::vector<cv::Mat>& depths, const std::vector<Regions>& regions) {
    double sum = 0;
    double count = 0;
    for (std::size_t i = 1; i < depths.size(); ++i) {
        const cv::Mat& still = regions[i].still;
        sum += cv::norm(depths[i], depths[i - 1], cv::NORM_L1, still);
        count += cv::countNonZero(still);
    }
    return sum / count;
}

// Mean standard deviation, because depth with a compressed range also flickers less.
double contrastOf(const std::vector<cv::Mat>& depths) {
    double sum = 0;
    for (const cv::Mat& depth : depths) {
        cv::Scalar mean;
        cv::Scalar deviation;
        cv::meanStdDev(depth, mean, deviation);
        sum += deviation[0];
    }
    return sum / static_cast<double>(depths.size());
}

// Depth in another depth's range: least squares over the px that stand still.
cv::Mat inRangeOf(const cv::Mat& depth, const cv::Mat& target, const cv::Mat& still) {
    cv::Scalar meanD;
    cv::Scalar deviationD;
    cv::Scalar meanT;
    cv::Scalar deviationT;
    cv::meanStdDev(depth, meanD, deviationD, still);
    cv::meanStdDev(target, meanT, deviationT, still);
    if (deviationD[0] < 1e-6) return depth;
    const cv::Mat product = (depth - meanD[0]).mul(target - meanT[0]);
    const double gain = cv::mean(product, still)[0] / (deviationD[0] * deviationD[0]);
    return gain * (depth - meanD[0]) + meanT[0];
}

// The depth of a neighbouring picture where its contents are in this one, by dense flow on the
// network's scale (OpenCV's Farneback: nothing of what is measured).
cv::Mat broughtHere(const cv::Mat& depth, const cv::Mat& there, const cv::Mat& here) {
    cv::Mat from;
    cv::Mat to;
    here.convertTo(from, CV_8U);
    there.convertTo(to, CV_8U);
    cv::Mat flow;
    cv::calcOpticalFlowFarneback(from, to, flow, 0.5, 4, 11, 5, 5, 1.1, 0);
    for (int y = 0; y < flow.rows; ++y)
        for (int x = 0; x < flow.cols; ++x)
            flow.at<cv::Vec2f>(y, x) += cv::Vec2f(static_cast<float>(x), static_cast<float>(y));
    cv::Mat result;
    cv::remap(depth, result, flow, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    return result;
}

struct MovingErrors {
    double perPicture = 0; // of each picture's own depth
    double steady = 0;     // of the depth that is judged
    double apart = 0;      // the two from each other
};

// Where the picture moves: the difference from the next picture's own depth, which none of the
// compared depths has used.
MovingErrors movingErrorsOf(const Clip& clip, const std::vector<cv::Mat>& own,
                            const std::vector<cv::Mat>& depths,
                            const std::vector<Regions>& regions) {
    MovingErrors errors;
    double count = 0;
    const auto add = [](double& sum, const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
        sum += cv::norm(a, b, cv::NORM_L1, mask);
    };
    for (std::size_t i = 1; i + 1 < depths.size(); ++i) {
        const cv::Mat& moving = regions[i].moving;
        const cv::Mat& still = regions[i].still;
        if (cv::countNonZero(moving) < 50 || cv::countNonZero(still) < 50) continue;
        const cv::Size size = own[i].size();
        const cv::Mat here = greyAt(clip.pictures[i], size);
        const cv::Mat next = broughtHere(own[i + 1], greyAt(clip.pictures[i + 1], size), here);
        const cv::Mat truth = inRangeOf(next, own[i], still);
        const cv::Mat judged = inRangeOf(depths[i], own[i], still);
        add(errors.perPicture, own[i], truth, moving);
        add(errors.steady, judged, truth, moving);
        add(errors.apart, judged, own[i], moving);
        count += cv::countNonZero(moving);
    }
    errors.perPicture /= count;
    errors.steady /= count;
    errors.apart /= count;
    return errors;
}

double psnrOf(const std::vector<cv::Mat>& depths, const std::vector<cv::Mat>& expected) {
    double squares = 0;
    double count = 0;
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const double norm = cv::norm(depths[i], expected[i], cv::NORM_L2);
        squares += norm * norm;
        count += static_cast<double>(depths[i].total());
    }
    return squares == 0 ? 99 : 10 * std::log10(count / squares);
}

VideoDepthOptions optionsOf(int every, double steadiness = VideoDepthOptions().steadiness) {
    VideoDepthOptions options;
    options.every = every;
    options.steadiness = steadiness;
    return options;
}

// --- Tables --------------------------------------------------------------------------------------

void printSteadiness(const Clip& clip) {
    const std::vector<cv::Mat> minMax = depthPerPicture(clip, 0, 100);
    const std::vector<cv::Mat> own = depthPerPicture(clip, 0.5, 99.5);
    std::vector<Regions> regions(1);
    double still = 0;
    double moving = 0;
    for (std::size_t i = 1; i < clip.pictures.size(); ++i) {
        regions.push_back(regionsOf(clip.pictures[i - 1], clip.pictures[i], own[i].size()));
        const auto total = static_cast<double>(own[i].total());
        still += cv::countNonZero(regions[i].still) / total;
        moving += cv::countNonZero(regions[i].moving) / total;
    }
    const auto steps = static_cast<double>(clip.pictures.size() - 1);
    std::printf("%s: %.1f %% of the px stand still, %.1f %% move.\n\n", clip.name.c_str(),
                100 * still / steps, 100 * moving / steps);
    const double yardstick = flickerOf(minMax, regions);
    std::cout << "| depth | flicker, % of the range | less by | contrast | error where it moves | "
                 "grows by | from each picture's own |\n|---|---:|---:|---:|---:|---:|---:|\n";
    const auto print = [&](const std::string& name, const std::vector<cv::Mat>& depths) {
        const double flicker = flickerOf(depths, regions);
        const MovingErrors errors = movingErrorsOf(clip, own, depths, regions);
        std::printf("| %s | %.3f | %.0f %% | %.3f | %.2f %% | %+.1f %% | %.2f %% |\n", name.c_str(),
                    100 * flicker, 100 * (1 - flicker / yardstick), contrastOf(depths),
                    100 * errors.steady, 100 * (errors.steady / errors.perPicture - 1),
                    100 * errors.apart);
    };
    print("per picture, least to greatest", minMax);
    print("per picture, percentiles", own);
    for (const double steadiness : {0.5, 0.8, 0.9, 0.95})
        print("every = 1, steadiness " + std::to_string(steadiness).substr(0, 4),
              runVideoDepth(clip, optionsOf(1, steadiness)).depths);
    for (const int every : {2, 4, 8, 0})
        print(every == 0 ? "auto" : "every = " + std::to_string(every),
              runVideoDepth(clip, optionsOf(every)).depths);
    std::cout << '\n';
}

// Mean absolute change from picture to picture where nothing moves, of depth that is fitted to a
// view and refined as in a video: with the flaws of the first picture.
double flickerOfViews(const Clip& clip, const std::vector<cv::Mat>& depths, bool isRefined) {
    altiro3D::DepthRefineOptions refine{altiro3D::DepthFlaws()};
    altiro3D::Scene before;
    double sum = 0;
    double count = 0;
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const altiro3D::Scene scene{clip.pictures[i], depths[i]};
        const altiro3D::PhotoFit fit = altiro3D::fitPhoto(scene.photo.size(), 0.75, {420, 560});
        altiro3D::Scene now;
        altiro3D::fitScene(scene, fit, 0.5, now, {altiro3D::DepthFlaws()});
        if (i == 0 && isRefined) refine.flaws = altiro3D::measureDepthFlaws(now.photo, now.depth);
        altiro3D::refineDepth(now.photo, now.depth, now.depth, refine);
        if (i > 0) {
            const Regions regions = regionsOf(before.photo, now.photo, now.photo.size());
            sum += cv::norm(now.depth, before.depth, cv::NORM_L1, regions.still);
            count += cv::countNonZero(regions.still);
        }
        before = now;
    }
    return sum / count;
}

void printRefinement(const Clip& clip) {
    std::cout << "| flicker of " << clip.name
              << " at 420 x 560 px, % of the range | not refined | refined |\n|---|---:|---:|\n";
    for (const int every : {1, 4, 0}) {
        const std::vector<cv::Mat> depths = runVideoDepth(clip, optionsOf(every)).depths;
        std::printf("| %s | %.3f | %.3f |\n",
                    every == 0 ? "auto" : ("every = " + std::to_string(every)).c_str(),
                    100 * flickerOfViews(clip, depths, false),
                    100 * flickerOfViews(clip, depths, true));
    }
    std::cout << '\n';
}

void printCarrying(const std::vector<Clip>& clips) {
    std::cout << "| clip | pictures, scenes | every = 2 | 4 | 8 | auto | frozen, 8 | auto infers | "
                 "ms per picture: 1 | 8 |\n"
                 "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
    for (const Clip& clip : clips) {
        const Run plain = runVideoDepth(clip, optionsOf(1));
        std::printf("| %s | %zu, %d |", clip.name.c_str(), clip.pictures.size(), plain.cuts);
        Run run;
        for (const int every : {2, 4, 8}) {
            run = runVideoDepth(clip, optionsOf(every));
            std::printf(" %.1f |", psnrOf(run.depths, plain.depths));
        }
        const double eighthMs = run.ms;
        const Run automatic = runVideoDepth(clip, optionsOf(0));
        std::printf(" %.1f |", psnrOf(automatic.depths, plain.depths));
        std::vector<cv::Mat> frozen; // what was inferred stays where it is
        for (std::size_t i = 0; i < run.depths.size(); ++i)
            frozen.push_back(run.inferred[i] != 0 ? run.depths[i] : frozen.back());
        std::printf(" %.1f | %.0f %% | %.2f | %.2f |\n", psnrOf(frozen, plain.depths),
                    100 * automatic.inferredShare, plain.ms, eighthMs);
    }
    std::cout << '\n';
}

int run(const fs::path& data) {
    if (data.empty()) {
        std::cout << "No test data: set ALTIRO3D_TEST_DATA to its folder or name it as the "
                     "argument.\n";
        return 0;
    }
    const auto catalog =
        altiro3D::readModelCatalog(altiro3D::test::sourcePath("models/catalog.json"));
    const fs::path model = data / "models" / "fastdepth" / "fastdepth_224_op10.onnx";
    const altiro3D::NetworkProfile* profile = altiro3D::findProfile(catalog, model);
    if (!fs::exists(model) || profile == nullptr) {
        std::cout << "missing: " << model.string() << '\n';
        return 0;
    }
    altiro3D::DepthNetwork network(model, *profile);
    std::vector<Clip> clips;
    double inferenceMs = 0;
    for (const char* name :
         {"car-detection", "bikes", "bigbuckbunny", "flower", "carphone_pristine", "realshort"}) {
        const fs::path file = data / "videos" / (std::string(name) + ".mp4");
        if (fs::exists(file)) {
            clips.push_back(readClip(file, network, inferenceMs));
        } else {
            std::cout << "missing: " << file.string() << "\n\n";
        }
    }
    if (clips.empty()) return 0;
    if (clips.front().name == "car-detection") {
        printSteadiness(clips.front());
        printRefinement(clips.front());
    }
    printCarrying(clips);
    std::printf("One inference of FastDepth: %.1f ms; %d threads.\n", inferenceMs,
                cv::getNumThreads());
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    if (argc > 2) {
        std::cerr << "altiro3D_video_depth_accuracy: error: expected at most one argument, the "
                     "folder of the test data\n";
        return 2;
    }
    try {
        return run(argc == 2 ? fs::path(argv[1]) : altiro3D::test::dataPath(""));
    } catch (const std::exception& error) {
        std::cerr << "altiro3D_video_depth_accuracy: error: " << error.what() << '\n';
        return 1;
    }
}
