// Depth images in files of their own: which photo one is for, which one lies beside a photo, and
// which pictures look like one.

#include "image/depth_images.hpp"
#include "altiro3D/image_io.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "image/image_list.hpp"
#include "image/picture_shape.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <vector>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kSeparators = "-_. ";
constexpr std::array<std::string_view, 4> kWords = {"depth", "depthmap", "depth_map", "disparity"};
constexpr std::string_view kWith = "with"; // a_with_depth.jpg is a photo that holds its depth

bool endsWithAnyCase(std::string_view text, std::string_view smallEnding) {
    if (text.size() < smallEnding.size()) return false;
    text.remove_prefix(text.size() - smallEnding.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (lowerCase(text[i]) != smallEnding[i]) return false;
    }
    return true;
}

// Whether it ends with a separator and the word.
bool endsWithWord(std::string_view text, std::string_view smallWord) {
    if (!endsWithAnyCase(text, smallWord) || text.size() == smallWord.size()) return false;
    return kSeparators.find(text[text.size() - smallWord.size() - 1]) != std::string_view::npos;
}

// The second difference that a share of the px does not exceed, in standard deviations.
double bendOf(const cv::Mat& grey, double share) {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(grey, mean, deviation);
    std::vector<float> bends;
    for (int y = 1; y + 1 < grey.rows; ++y) {
        for (int x = 1; x + 1 < grey.cols; ++x) {
            const float twice = 2 * grey.at<float>(y, x);
            bends.push_back(
                std::max(std::abs(grey.at<float>(y, x - 1) + grey.at<float>(y, x + 1) - twice),
                         std::abs(grey.at<float>(y - 1, x) + grey.at<float>(y + 1, x) - twice)));
        }
    }
    const auto at =
        bends.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(bends.size() - 1));
    std::nth_element(bends.begin(), at, bends.end());
    return static_cast<double>(*at) / deviation[0];
}

// How many of 64 steps between the smallest and the largest value hold 0.5 % of the px or more.
int wideLevels(const cv::Mat& grey) {
    constexpr int kSteps = 64;
    double least = 0;
    double largest = 0;
    cv::minMaxLoc(grey, &least, &largest);
    if (!(largest > least)) return 1;
    std::array<std::size_t, kSteps> counts{};
    for (int y = 0; y < grey.rows; ++y) {
        const float* const row = grey.ptr<float>(y);
        for (int x = 0; x < grey.cols; ++x) {
            const double place = (static_cast<double>(row[x]) - least) / (largest - least);
            ++counts[static_cast<std::size_t>(std::clamp(place * kSteps, 0.0, kSteps - 1.0))];
        }
    }
    return static_cast<int>(std::count_if(counts.begin(), counts.end(), [&](std::size_t count) {
        return count * 200 >= grey.total();
    }));
}

} // namespace

cv::Mat smallGrey(const cv::Mat& picture) {
    constexpr double kMaxSide = 256;
    cv::Mat grey;
    cv::extractChannel(picture, grey, 1);
    grey.convertTo(grey, CV_32F);
    for (int y = 0; y < grey.rows; ++y) {
        float* const row = grey.ptr<float>(y);
        for (int x = 0; x < grey.cols; ++x) {
            if (!std::isfinite(row[x])) row[x] = 0;
        }
    }
    const double scale = kMaxSide / std::max(grey.cols, grey.rows);
    if (scale >= 1) return grey;
    const cv::Size size(std::max(1, static_cast<int>(std::lround(grey.cols * scale))),
                        std::max(1, static_cast<int>(std::lround(grey.rows * scale))));
    cv::Mat small;
    cv::resize(grey, small, size, 0, 0, cv::INTER_AREA);
    return small;
}

bool looksLikeDepthImage(const cv::Mat& picture) {
    constexpr int kMinSide = 16;      // px
    constexpr double kMaxBend = 0.03; // measured: docs/depth.md
    constexpr double kSmoothShare = 0.7;
    constexpr int kMinLevels = 8;
    checkType(picture, {CV_8UC3, CV_16UC3, CV_32FC3}, "picture",
              "three channels of 8 or 16 bits or of floats");
    if (std::min(picture.cols, picture.rows) < kMinSide || hasColours(picture)) return false;
    const cv::Mat grey = smallGrey(picture);
    if (std::min(grey.cols, grey.rows) < kMinSide) return false;
    return wideLevels(grey) >= kMinLevels && bendOf(grey, kSmoothShare) <= kMaxBend;
}

fs::path photoOfDepthName(const fs::path& depth) {
    const std::string stem = depth.stem().string();
    for (const std::string_view word : kWords) {
        if (!endsWithWord(stem, word) || stem.size() < word.size() + 2) continue;
        const std::string photo = stem.substr(0, stem.size() - word.size() - 1);
        return endsWithWord(photo, kWith) ? fs::path() : depth.parent_path() / photo;
    }
    return {};
}

std::string reasonAgainstDepth(const cv::Mat& samples, cv::Size photo) {
    checkType(samples, {CV_8UC1, CV_16UC1, CV_32FC1, CV_64FC1}, "samples",
              "one channel of 8 or 16 bits or of floats");
    if (!haveOneShape(samples.size(), photo))
        return "its shape, " + sizeText(samples.size()) + " px, is not that of the photo, " +
               sizeText(photo) + " px";
    cv::Mat numbers;
    samples.convertTo(numbers, CV_32F);
    std::vector<float> values;
    for (const float value : cv::Mat_<float>(numbers)) {
        if (std::isfinite(value)) values.push_back(value);
    }
    if (values.empty()) return "it is flat";
    const auto percentile = [&values](double share) {
        const auto at = values.begin() +
                        static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
        std::nth_element(values.begin(), at, values.end());
        return static_cast<double>(*at);
    };
    const double low = percentile(0.005);
    const double high = percentile(0.995);
    const bool isFlat = (high - low) * 255 < std::max(std::abs(low), std::abs(high)) || high == low;
    return isFlat ? "it is flat" : "";
}

fs::path findDepthBeside(const fs::path& photo) {
    const fs::path directory = photo.parent_path();
    const std::string stem = photo.stem().string();
    if (stem.empty()) return {};
    fs::path best;
    std::error_code error;
    fs::directory_iterator entry(directory.empty() ? fs::path(".") : directory, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        if (!startsWith(name, stem) || !hasImageExtension(name) || photoOfDepthName(name) != stem)
            continue;
        std::error_code unreadable; // dangling links are left out
        if (!entry->is_regular_file(unreadable)) continue;
        if (best.empty() || naturalLess(name, best.string())) best = name;
    }
    return best.empty() ? fs::path() : directory / best;
}

} // namespace altiro3D
