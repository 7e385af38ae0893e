// altiro3D_depth_accuracy: how well estimated depth orders the pixels of photos whose depth is
// known.
//
// Usage: altiro3D_depth_accuracy [folder of the test data]
//
// Prints a Markdown table of Spearman's rank correlation with the true inverse depth (1 = the same
// order, 0 = unrelated, -1 = reversed) for a plain vertical gradient, the built-in estimator and
// FastDepth. What is missing is named and left out.

#include "altiro3D/depth_source.hpp"
#include "altiro3D/error.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Scene {
    std::string name;
    cv::Mat photo;        // [rows x cols, CV_8UC3, BGR]
    cv::Mat inverseDepth; // [rows x cols, CV_32FC1, larger = nearer]
    cv::Mat known;        // [rows x cols, CV_8UC1, 0 = unknown]
};

// Reads photo and truth; says what is missing. `metric`: the numbers are distances, not
// disparities.
bool addScene(const std::string& name, const fs::path& photoFile, const fs::path& truthFile,
              bool metric, std::vector<Scene>& scenes) {
    Scene scene;
    scene.name = name;
    scene.photo = cv::imread(photoFile.string(), cv::IMREAD_COLOR);
    const cv::Mat raw = cv::imread(truthFile.string(), cv::IMREAD_UNCHANGED);
    if (scene.photo.empty() || raw.empty() || raw.channels() != 1 ||
        raw.size() != scene.photo.size()) {
        std::cout << "missing or unreadable: " << photoFile.string() << " or " << truthFile.string()
                  << "\n\n";
        return false;
    }
    raw.convertTo(scene.inverseDepth, CV_32F);
    scene.known = cv::Mat(raw.size(), CV_8UC1, cv::Scalar(0));
    for (int y = 0; y < raw.rows; ++y) {
        for (int x = 0; x < raw.cols; ++x) {
            float& value = scene.inverseDepth.at<float>(y, x);
            if (!std::isfinite(value) || value <= 0) {
                value = 0;
                continue;
            }
            if (metric) value = 1 / value;
            scene.known.at<uchar>(y, x) = 255;
        }
    }
    scenes.push_back(scene);
    return true;
}

// scenes.csv: name, year, left photo, right photo, left disparity, ... (see its README).
void addMiddlebury(const fs::path& folder, std::vector<Scene>& scenes) {
    std::ifstream list(folder / "scenes.csv");
    if (!list) {
        std::cout << "missing: " << (folder / "scenes.csv").string() << "\n\n";
        return;
    }
    std::string line;
    std::getline(list, line); // the head
    while (std::getline(list, line)) {
        std::istringstream fields(line);
        std::vector<std::string> field;
        for (std::string text; std::getline(fields, text, ',');)
            field.push_back(text);
        if (field.size() < 5) continue;
        const fs::path scene = folder / field[0];
        addScene(field[0], scene / field[2], scene / field[4], false, scenes);
    }
}

void addRgbd(const fs::path& folder, std::vector<Scene>& scenes) {
    for (int i = 1; i <= 5; ++i) {
        const fs::path set = folder / "ch5_rgbd";
        const std::string number = std::to_string(i);
        if (!addScene("Kinect room " + number, set / "color" / (number + ".png"),
                      set / "depth" / (number + ".pgm"), true, scenes))
            break;
    }
    for (int i = 1; i <= 5; ++i) {
        const fs::path set = folder / "ch12_dense_rgbd";
        const std::string number = std::to_string(i);
        if (!addScene("rendered room " + number, set / "color" / (number + ".png"),
                      set / "depth" / (number + ".png"), true, scenes))
            break;
    }
}

cv::Mat verticalGradient(const cv::Size& size) {
    cv::Mat gradient(size, CV_32FC1);
    for (int y = 0; y < size.height; ++y)
        gradient.row(y).setTo(y);
    return gradient;
}

cv::Mat builtIn(const cv::Mat& photo) {
    cv::Mat depth;
    altiro3D::estimateDepthFromCues(photo, depth);
    cv::resize(depth, depth, photo.size(), 0, 0, cv::INTER_LINEAR);
    return depth;
}

// FastDepth gives metres; the inverse has the same order as the negative.
cv::Mat fastDepth(cv::dnn::Net& network, const cv::Mat& photo) {
    constexpr int kSide = 224;
    network.setInput(
        cv::dnn::blobFromImage(photo, 1.0 / 255, cv::Size(kSide, kSide), cv::Scalar(), true));
    const cv::Mat output = network.forward();
    const cv::Mat metres(kSide, kSide, CV_32FC1, const_cast<float*>(output.ptr<float>()));
    cv::Mat nearness = -metres;
    cv::resize(nearness, nearness, photo.size(), 0, 0, cv::INTER_LINEAR);
    return nearness;
}

std::string cell(std::optional<double> value) {
    if (!value) return "-";
    char text[32];
    std::snprintf(text, sizeof text, "%.3f", *value);
    return text;
}

// Milliseconds of one call, the median of several.
double timeBuiltIn(const cv::Mat& photo) {
    std::vector<double> milliseconds;
    cv::Mat depth;
    for (int i = 0; i < 9; ++i) {
        const auto begin = std::chrono::steady_clock::now();
        altiro3D::estimateDepthFromCues(photo, depth);
        const std::chrono::duration<double, std::milli> taken =
            std::chrono::steady_clock::now() - begin;
        milliseconds.push_back(taken.count());
    }
    std::sort(milliseconds.begin(), milliseconds.end());
    return milliseconds[milliseconds.size() / 2];
}

void printTable(const std::vector<Scene>& scenes, std::optional<cv::dnn::Net> network) {
    std::cout << "| scene | vertical gradient | built-in | FastDepth |\n|---|---:|---:|---:|\n";
    double gradientSum = 0;
    double builtInSum = 0;
    double networkSum = 0;
    int better = 0;
    for (const Scene& scene : scenes) {
        const auto correlation = [&](const cv::Mat& depth) {
            return altiro3D::test::rankCorrelation(depth, scene.inverseDepth, scene.known);
        };
        const double ofGradient = correlation(verticalGradient(scene.photo.size()));
        const double ofBuiltIn = correlation(builtIn(scene.photo));
        std::optional<double> ofNetwork;
        if (network) ofNetwork = correlation(fastDepth(*network, scene.photo));
        gradientSum += ofGradient;
        builtInSum += ofBuiltIn;
        networkSum += ofNetwork.value_or(0);
        if (ofBuiltIn > ofGradient) ++better;
        std::cout << "| " << scene.name << " | " << cell(ofGradient) << " | " << cell(ofBuiltIn)
                  << " | " << cell(ofNetwork) << " |\n";
    }
    const auto count = static_cast<double>(scenes.size());
    std::optional<double> networkMean;
    if (network) networkMean = networkSum / count;
    std::cout << "| **mean** | " << cell(gradientSum / count) << " | " << cell(builtInSum / count)
              << " | " << cell(networkMean) << " |\n\n"
              << "The built-in estimator beats the gradient on " << better << " of "
              << scenes.size() << " scenes.\n";

    cv::Mat large;
    cv::resize(scenes.front().photo, large, cv::Size(4000, 3000), 0, 0, cv::INTER_CUBIC);
    std::printf("Built-in, a photo of 4000 x 3000: %.0f ms; %d x %d: %.0f ms; %d threads.\n",
                timeBuiltIn(large), scenes.front().photo.cols, scenes.front().photo.rows,
                timeBuiltIn(scenes.front().photo), cv::getNumThreads());
}

int run(const fs::path& data) {
    if (data.empty()) {
        std::cout << "No test data: set ALTIRO3D_TEST_DATA to its folder or name it as the "
                     "argument.\n";
        return 0;
    }
    std::vector<Scene> scenes;
    addMiddlebury(data / "middlebury", scenes);
    addRgbd(data / "rgbd" / "slambook2", scenes);
    if (scenes.empty()) {
        std::cout << "No scene to measure in " << data.string() << "\n";
        return 0;
    }
    std::optional<cv::dnn::Net> network;
    const fs::path model = data / "models" / "fastdepth" / "fastdepth_224_op10.onnx";
    try {
        network = cv::dnn::readNetFromONNX(model.string());
    } catch (const cv::Exception&) {
        std::cout << "missing or unreadable: " << model.string() << "\n\n";
    }
    printTable(scenes, network);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    if (argc > 2) {
        std::cerr << "altiro3D_depth_accuracy: error: expected at most one argument, the folder of "
                     "the test data\n";
        return 2;
    }
    try {
        return run(argc == 2 ? fs::path(argv[1]) : altiro3D::test::dataPath(""));
    } catch (const std::exception& error) {
        std::cerr << "altiro3D_depth_accuracy: error: " << error.what() << '\n';
        return 1;
    }
}
