// altiro3D_depth_accuracy: how well estimated depth orders the pixels of photos whose depth is
// known, how many depth steps it finds, and how straight it is along straight lines.
//
// Usage: altiro3D_depth_accuracy [--network FILE.onnx]... [--size PX] [--frames FOLDER]...
//        [--photos FOLDER]... [folder of the test data]
//
// Prints Markdown tables for a plain vertical gradient, FastDepth, and the depth that each network
// gives as a source. The first: Spearman's rank correlation with the true inverse depth (1 = the
// same order, 0 = unrelated, -1 = reversed). The second: precision and recall of steps of more than
// a tenth of the range within 4 px, met within 3 px. For folders of photos: by how much the depth
// departs from an affine function along straight lines. --size is the longer side of the networks'
// input. A folder of frames holds pairs NNNNNN.png or .jpg and NNNNNN.d.png, 16-bit inverse depth.
// Missing inputs are reported and skipped.

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/depth_map.hpp"
#include "altiro3D/depth_network.hpp"
#include "altiro3D/depth_source.hpp"
#include "support/files.hpp"
#include "support/middlebury.hpp"
#include "support/pixels.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Scene {
    std::string set;
    std::string name;
    cv::Mat photo;        // [rows x cols, CV_8UC3, BGR]
    cv::Mat inverseDepth; // [rows x cols, CV_32FC1, larger = nearer]
    cv::Mat known;        // [rows x cols, CV_8UC1, 0 = unknown]
};

// Reads photo and truth; reports a missing file. `metric`: the numbers are distances, not
// disparities.
bool addScene(const std::string& set, const std::string& name, const fs::path& photoFile,
              const fs::path& truthFile, bool metric, std::vector<Scene>& scenes) {
    Scene scene;
    scene.set = set;
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
    altiro3D::test::forPixels(raw.size(), [&](int x, int y) {
        float& value = scene.inverseDepth.at<float>(y, x);
        const bool isKnown = std::isfinite(value) && value > 0;
        value = !isKnown ? 0 : metric ? 1 / value : value;
        if (isKnown) scene.known.at<uchar>(y, x) = 255;
    });
    scenes.push_back(scene);
    return true;
}

void addMiddlebury(const fs::path& folder, std::vector<Scene>& scenes) {
    const std::vector<altiro3D::test::MiddleburyFiles> listed =
        altiro3D::test::listMiddlebury(folder);
    if (listed.empty()) std::cout << "missing: " << (folder / "scenes.csv").string() << "\n\n";
    for (const altiro3D::test::MiddleburyFiles& files : listed)
        addScene("Middlebury", files.name, files.left, files.disparity, false, scenes);
}

void addRgbd(const fs::path& folder, std::vector<Scene>& scenes) {
    for (const auto& [name, set, extension] : {std::tuple("Kinect room ", "ch5_rgbd", ".pgm"),
                                               {"rendered room ", "ch12_dense_rgbd", ".png"}}) {
        bool isThere = true;
        for (int i = 1; i <= 5 && isThere; ++i) {
            const std::string number = std::to_string(i);
            isThere = addScene(name, name + number, folder / set / "color" / (number + ".png"),
                               folder / set / "depth" / (number + extension), true, scenes);
        }
    }
}

// Pairs from the generator of training data. 0 means infinity there and is a known value.
void addFrames(const fs::path& folder, std::vector<Scene>& scenes) {
    constexpr std::size_t kMost = 100;
    std::vector<fs::path> truths;
    if (fs::is_directory(folder))
        for (const auto& entry : fs::directory_iterator(folder))
            if (entry.path().extension() == ".png" && entry.path().stem().extension() == ".d")
                truths.push_back(entry.path());
    if (truths.empty()) std::cout << "missing: frames in " << folder.string() << "\n\n";
    std::sort(truths.begin(), truths.end());
    const std::size_t step = std::max<std::size_t>(1, truths.size() / kMost);
    for (std::size_t i = 0; i < truths.size() && i / step < kMost; i += step) {
        const std::string number = truths[i].stem().stem().string();
        fs::path photo = folder / (number + ".jpg");
        if (!fs::exists(photo)) photo = folder / (number + ".png");
        if (addScene(folder.filename().string(), number, photo, truths[i], false, scenes))
            scenes.back().known.setTo(255);
    }
}

cv::Mat verticalGradient(const cv::Size& size) {
    cv::Mat gradient(size, CV_32FC1);
    for (int y = 0; y < size.height; ++y)
        gradient.row(y).setTo(y);
    return gradient;
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

// --- Networks ------------------------------------------------------------------------------------

// The catalogue's entry of a network; of others, as training/ makes them, that of our own network.
altiro3D::NetworkProfile profileOf(const fs::path& file) {
    const auto catalog =
        altiro3D::readModelCatalog(altiro3D::test::sourcePath("models/catalog.json"));
    const auto* known = altiro3D::findProfile(catalog, file);
    if (known == nullptr) known = altiro3D::findProfile(catalog, "altiro3d-depth.onnx");
    altiro3D::NetworkProfile profile = *known;
    profile.inputShape = altiro3D::InputShape::Photo;
    return profile;
}

// The depth of a network.
std::function<cv::Mat(const cv::Mat&)> depthOf(const fs::path& file,
                                               altiro3D::NetworkProfile profile, int size) {
    const std::shared_ptr<altiro3D::DepthSource> source = altiro3D::depthFromNetworkFile(
        file, std::move(profile), altiro3D::InferenceTarget::Cpu, {size, size});
    return [source](const cv::Mat& photo) {
        altiro3D::Scene scene;
        source->readScene(photo, 0.5, scene);
        return scene.depth;
    };
}

// --- Steps ---------------------------------------------------------------------------------------

// From the percentile 0.5 to 99.5 of the known values.
double rangeOf(const cv::Mat& depth, const cv::Mat& known) {
    std::vector<float> values;
    altiro3D::test::forPixels(depth.size(), [&](int x, int y) {
        if (known.at<uchar>(y, x) != 0) values.push_back(depth.at<float>(y, x));
    });
    std::sort(values.begin(), values.end());
    const auto at = [&](double part) {
        return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
    };
    return static_cast<double>(at(0.995) - at(0.005));
}

// Px of steps: the depth changes by more than a tenth of the range within 4 px.
cv::Mat stepsOf(const cv::Mat& depth, double range) {
    const auto least = static_cast<float>(range / 10);
    cv::Mat steps(depth.size(), CV_8UC1, cv::Scalar(0));
    for (int y = 2; y + 2 < depth.rows; ++y) {
        for (int x = 2; x + 2 < depth.cols; ++x) {
            const float across = depth.at<float>(y, x + 2) - depth.at<float>(y, x - 2);
            const float down = depth.at<float>(y + 2, x) - depth.at<float>(y - 2, x);
            if (std::abs(across) > least || std::abs(down) > least) steps.at<uchar>(y, x) = 255;
        }
    }
    return steps;
}

cv::Mat around(const cv::Mat& mask, int radius) {
    cv::Mat wide;
    cv::dilate(mask, wide,
               cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1}));
    return wide;
}

// Px of steps: how many are found, and how many of these lie within 3 px of others.
struct StepCounts {
    double found = 0;
    double right = 0;
    double wanted = 0;
    double met = 0;

    StepCounts() = default;
    // @param depth of the photo's size
    StepCounts(const cv::Mat& depth, const Scene& scene) {
        const cv::Mat clear = ~around(~scene.known, 5); // no steps to unknown px
        const cv::Mat everywhere(depth.size(), CV_8UC1, cv::Scalar(255));
        const cv::Mat own = stepsOf(depth, rangeOf(depth, everywhere)) & clear;
        const cv::Mat truth =
            stepsOf(scene.inverseDepth, rangeOf(scene.inverseDepth, scene.known)) & clear;
        found = cv::countNonZero(own);
        right = cv::countNonZero(own & around(truth, 3));
        wanted = cv::countNonZero(truth);
        met = cv::countNonZero(truth & around(own, 3));
    }
    void add(const StepCounts& other) {
        found += other.found;
        right += other.right;
        wanted += other.wanted;
        met += other.met;
    }
    std::optional<double> precision() const { return share(right, found); }
    std::optional<double> recall() const { return share(met, wanted); }

  private:
    static std::optional<double> share(double part, double all) {
        return all > 0 ? part / all : std::optional<double>();
    }
};

// --- Lines ---------------------------------------------------------------------------------------

// By how much depth departs from an affine function along the straight edges of a photo, longer
// than 64 px at 800 px, without those along its frame: mean, in % of the range.
std::optional<double> departure(const cv::Mat& photo, const cv::Mat& depth) {
    constexpr int kSide = 800;
    constexpr float kFrame = 7;
    const double factor = static_cast<double>(kSide) / std::max(photo.cols, photo.rows);
    const cv::Size size(cvRound(photo.cols * factor), cvRound(photo.rows * factor));
    cv::Mat grey;
    cv::resize(photo, grey, size, 0, 0, factor < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
    cv::cvtColor(grey, grey, cv::COLOR_BGR2GRAY);
    cv::Mat large;
    cv::resize(depth, large, size, 0, 0, cv::INTER_LINEAR);
    const double range = rangeOf(large, cv::Mat(size, CV_8UC1, cv::Scalar(255)));
    std::vector<cv::Vec4f> lines;
    cv::createLineSegmentDetector()->detect(grey, lines);
    double sum = 0;
    double weight = 0;
    for (const cv::Vec4f& line : lines) {
        const cv::Point2f from(line[0], line[1]);
        const cv::Point2f to(line[2], line[3]);
        const double length = cv::norm(to - from);
        const auto isAtFrame = [&](float a, float b, int last) {
            return std::max(a, b) < kFrame || std::min(a, b) > static_cast<float>(last) - kFrame;
        };
        if (length <= 64 || isAtFrame(from.x, to.x, size.width - 1) ||
            isAtFrame(from.y, to.y, size.height - 1))
            continue;
        const int count = static_cast<int>(length);
        cv::Mat unknowns(count, 2, CV_64F, cv::Scalar(1));
        cv::Mat values(count, 1, CV_64F);
        for (int i = 0; i < count; ++i) {
            const double along = static_cast<double>(i) / (count - 1);
            cv::Mat value;
            cv::getRectSubPix(large, {1, 1}, from + static_cast<float>(along) * (to - from), value);
            unknowns.at<double>(i, 0) = along;
            values.at<double>(i) = static_cast<double>(value.at<float>(0));
        }
        cv::Mat affine;
        cv::solve(unknowns, values, affine, cv::DECOMP_QR);
        sum += cv::norm(values - unknowns * affine, cv::NORM_L1) / count / range * length;
        weight += length;
    }
    return weight > 0 ? 100 * sum / weight : std::optional<double>();
}

// --- Tables --------------------------------------------------------------------------------------

using Method = std::pair<std::string, std::function<cv::Mat(const cv::Mat&)>>;

std::vector<Method> methodsOf(const fs::path& data, const std::vector<std::string>& networks,
                              int size) {
    std::vector<Method> methods;
    methods.emplace_back("vertical gradient",
                         [](const cv::Mat& photo) { return verticalGradient(photo.size()); });
    const fs::path model = data / "models" / "fastdepth" / "fastdepth_224_op10.onnx";
    try {
        const auto network =
            std::make_shared<cv::dnn::Net>(cv::dnn::readNetFromONNX(model.string()));
        methods.emplace_back(
            "FastDepth", [network](const cv::Mat& photo) { return fastDepth(*network, photo); });
    } catch (const cv::Exception&) {
        std::cout << "missing or unreadable: " << model.string() << "\n\n";
    }
    for (const std::string& file : networks)
        methods.emplace_back(fs::path(file).stem().string(), depthOf(file, profileOf(file), size));
    return methods;
}

void printHead(const std::string& first, const std::vector<Method>& methods) {
    std::cout << "\n| " << first << " |";
    for (const Method& method : methods)
        std::cout << ' ' << method.first << " |";
    std::cout << "\n|---|";
    for (std::size_t i = 0; i < methods.size(); ++i)
        std::cout << "---:|";
    std::cout << '\n';
}

struct Mean {
    double sum = 0;
    int count = 0;
    void add(std::optional<double> value) {
        sum += value.value_or(0);
        count += value ? 1 : 0;
    }
    std::optional<double> value() const {
        return count == 0 ? std::optional<double>() : sum / count;
    }
};

void printRow(const std::string& name, const std::vector<Mean>& means) {
    std::cout << "| " << name << " |";
    for (const Mean& mean : means)
        std::cout << ' ' << cell(mean.value()) << " |";
    std::cout << '\n';
}

void printTables(const std::vector<Scene>& scenes, const std::vector<Method>& methods) {
    constexpr std::size_t kMaxNamed = 30; // larger sets are shown by their means
    std::map<std::string, std::size_t> sizes;
    for (const Scene& scene : scenes)
        ++sizes[scene.set];
    std::map<std::string, std::vector<Mean>> order;
    std::map<std::string, std::vector<StepCounts>> steps;
    std::vector<Mean> all(methods.size());
    printHead("scene", methods);
    for (const Scene& scene : scenes) {
        std::vector<Mean>& setOrder = order[scene.set];
        std::vector<StepCounts>& setSteps = steps[scene.set];
        setOrder.resize(methods.size());
        setSteps.resize(methods.size());
        std::vector<Mean> row(methods.size());
        for (std::size_t i = 0; i < methods.size(); ++i) {
            cv::Mat depth = methods[i].second(scene.photo);
            if (depth.size() != scene.photo.size())
                cv::resize(depth, depth, scene.photo.size(), 0, 0, cv::INTER_LINEAR);
            setSteps[i].add(StepCounts(depth, scene));
            const double correlation =
                altiro3D::rankCorrelation(depth, scene.inverseDepth, scene.known);
            row[i].add(correlation);
            setOrder[i].add(correlation);
            all[i].add(correlation);
        }
        if (sizes[scene.set] <= kMaxNamed) printRow(scene.name, row);
    }
    printRow("**mean**", all);
    printHead("set", methods);
    for (const auto& [set, means] : order)
        printRow(set + " (" + std::to_string(sizes[set]) + ")", means);
    printHead("precision / recall of steps", methods);
    for (const auto& [set, counts] : steps) {
        std::cout << "| " << set << " |";
        for (const StepCounts& count : counts)
            std::cout << ' ' << cell(count.precision()) << " / " << cell(count.recall()) << " |";
        std::cout << '\n';
    }
}

void printDepartures(const std::string& folder, const std::vector<Method>& methods) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    printHead("departure along lines, %", methods);
    std::vector<Mean> all(methods.size());
    for (const fs::path& file : files) {
        const cv::Mat photo = cv::imread(file.string(), cv::IMREAD_COLOR);
        if (photo.empty()) continue;
        std::vector<Mean> row(methods.size());
        for (std::size_t i = 0; i < methods.size(); ++i) {
            const std::optional<double> value = departure(photo, methods[i].second(photo));
            row[i].add(value);
            all[i].add(value);
        }
        printRow(file.filename().string(), row);
    }
    printRow("**mean**", all);
}

struct Arguments {
    fs::path data = altiro3D::test::dataPath("");
    std::vector<std::string> networks;
    std::vector<std::string> frames;
    std::vector<std::string> photos;
    int size = 0; // 0: the networks' own
};

std::optional<Arguments> readArguments(int argc, char** argv) {
    Arguments arguments;
    bool named = false;
    for (int i = 1; i < argc; ++i) {
        const std::string text = argv[i];
        std::vector<std::string>* const list = text == "--network"  ? &arguments.networks
                                               : text == "--frames" ? &arguments.frames
                                               : text == "--photos" ? &arguments.photos
                                                                    : nullptr;
        if (list != nullptr) {
            if (++i == argc) return {};
            list->emplace_back(argv[i]);
        } else if (text == "--size") {
            if (++i == argc) return {};
            arguments.size = std::atoi(argv[i]);
        } else if (named || text.substr(0, 2) == "--") {
            return {};
        } else {
            arguments.data = text;
            named = true;
        }
    }
    return arguments;
}

int run(const Arguments& arguments) {
    const fs::path& data = arguments.data;
    if (data.empty() && arguments.frames.empty()) {
        std::cout << "No test data: set ALTIRO3D_TEST_DATA to its folder or name it as the "
                     "argument.\n";
        return 0;
    }
    std::vector<Scene> scenes;
    if (!data.empty()) {
        addMiddlebury(data / "middlebury", scenes);
        addRgbd(data / "rgbd" / "slambook2", scenes);
    }
    for (const std::string& folder : arguments.frames)
        addFrames(folder, scenes);
    if (scenes.empty()) {
        std::cout << "No scene to measure in " << data.string() << "\n";
        return 0;
    }
    const std::vector<Method> methods = methodsOf(data, arguments.networks, arguments.size);
    printTables(scenes, methods);
    for (const std::string& folder : arguments.photos)
        printDepartures(folder, methods);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    const std::optional<Arguments> arguments = readArguments(argc, argv);
    if (!arguments) {
        std::cerr << "altiro3D_depth_accuracy: error: wrong usage, expected [--network "
                     "FILE.onnx]... [--size PX] "
                     "[--frames FOLDER]... [--photos FOLDER]... [folder of the test data]\n";
        return 2;
    }
    try {
        return run(*arguments);
    } catch (const std::exception& error) {
        std::cerr << "altiro3D_depth_accuracy: error: " << error.what() << '\n';
        return 1;
    }
}
