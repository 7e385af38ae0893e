#include "altiro3D/depth2quilt.hpp"

#include "base/checks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace altiro3D {

namespace {

void checkPair(const cv::Mat& picture, const cv::Mat& truth) {
    check(!picture.empty() && picture.depth() == CV_8U, "picture",
          shapeText(picture) + ", expected 8-bit samples");
    if (picture.size() == truth.size() && picture.type() == truth.type()) return;
    throw Error(ErrorCode::Mismatch, "picture",
                shapeText(picture) + ", and the truth " + shapeText(truth) +
                    ", expected the same of both");
}

// Local mean under the window.
cv::Mat blurred(const cv::Mat& samples) {
    cv::Mat mean;
    cv::GaussianBlur(samples, mean, {11, 11}, 1.5, 1.5, cv::BORDER_REFLECT_101);
    return mean;
}

// Ranks from 0; equal values share the mean of theirs.
std::vector<double> ranksOf(const std::vector<float>& values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
    std::vector<double> ranks(values.size());
    for (std::size_t first = 0; first < order.size();) {
        std::size_t last = first;
        while (last < order.size() && values[order[last]] == values[order[first]])
            ++last;
        const double mean = 0.5 * static_cast<double>(first + last - 1);
        for (std::size_t i = first; i < last; ++i)
            ranks[order[i]] = mean;
        first = last;
    }
    return ranks;
}

} // namespace

double psnr(const cv::Mat& picture, const cv::Mat& truth) try {
    checkPair(picture, truth);
    const double distance = cv::norm(picture, truth, cv::NORM_L2SQR);
    if (distance == 0) return std::numeric_limits<double>::infinity();
    const double samples = static_cast<double>(picture.total()) * picture.channels();
    return 10 * std::log10(255.0 * 255.0 * samples / distance);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

double ssim(const cv::Mat& picture, const cv::Mat& truth) try {
    checkPair(picture, truth);
    check(picture.channels() <= 4, "picture", // size of OpenCV's Scalar
          "has " + std::to_string(picture.channels()) + " channels, expected at most 4");
    constexpr double kC1 = (0.01 * 255) * (0.01 * 255);
    constexpr double kC2 = (0.03 * 255) * (0.03 * 255);
    cv::Mat x;
    cv::Mat y;
    picture.convertTo(x, CV_64F);
    truth.convertTo(y, CV_64F);
    const cv::Mat meanX = blurred(x);
    const cv::Mat meanY = blurred(y);
    const cv::Mat varianceX = blurred(x.mul(x)) - meanX.mul(meanX);
    const cv::Mat varianceY = blurred(y.mul(y)) - meanY.mul(meanY);
    const cv::Mat covariance = blurred(x.mul(y)) - meanX.mul(meanY);
    const cv::Scalar c1 = cv::Scalar::all(kC1);
    const cv::Scalar c2 = cv::Scalar::all(kC2);
    const cv::Mat luminance = 2 * meanX.mul(meanY) + c1;
    const cv::Mat structure = 2 * covariance + c2;
    const cv::Mat luminanceScale = meanX.mul(meanX) + meanY.mul(meanY) + c1;
    const cv::Mat structureScale = varianceX + varianceY + c2;
    const cv::Mat map = luminance.mul(structure) / luminanceScale.mul(structureScale);
    const cv::Scalar sum = cv::sum(map.reshape(1));
    return sum[0] / (static_cast<double>(map.total()) * map.channels());
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

double rankCorrelation(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) try {
    checkType(a, {CV_32FC1}, "a", "CV_32FC1");
    checkType(b, {CV_32FC1}, "b", "CV_32FC1");
    checkSize(b.size(), a.size(), "b");
    if (!mask.empty()) {
        checkType(mask, {CV_8UC1}, "mask", "CV_8UC1");
        checkSize(mask.size(), a.size(), "mask");
    }
    std::vector<float> valuesA;
    std::vector<float> valuesB;
    for (int y = 0; y < a.rows; ++y) {
        for (int x = 0; x < a.cols; ++x) {
            if (!mask.empty() && mask.at<uchar>(y, x) == 0) continue;
            const float valueA = a.at<float>(y, x);
            const float valueB = b.at<float>(y, x);
            check(std::isfinite(valueA), "a", "holds NaN or infinity, expected finite values");
            check(std::isfinite(valueB), "b", "holds NaN or infinity, expected finite values");
            valuesA.push_back(valueA);
            valuesB.push_back(valueB);
        }
    }
    const std::vector<double> ranksA = ranksOf(valuesA);
    const std::vector<double> ranksB = ranksOf(valuesB);
    const double mean = 0.5 * (static_cast<double>(ranksA.size()) - 1);
    double ab = 0;
    double aa = 0;
    double bb = 0;
    for (std::size_t i = 0; i < ranksA.size(); ++i) {
        ab += (ranksA[i] - mean) * (ranksB[i] - mean);
        aa += (ranksA[i] - mean) * (ranksA[i] - mean);
        bb += (ranksB[i] - mean) * (ranksB[i] - mean);
    }
    return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

void alignDepth(const cv::Mat& estimate, const cv::Mat& truth, cv::Mat& aligned) try {
    checkType(estimate, {CV_32FC1}, "estimate", "CV_32FC1");
    checkType(truth, {CV_32FC1}, "truth", "CV_32FC1");
    check(cv::checkRange(estimate) && cv::checkRange(truth), "depth",
          "has NaN or infinity, expected numbers");
    cv::Mat sized;
    cv::resize(estimate, sized, truth.size(), 0, 0, cv::INTER_LINEAR);
    const double meanEstimate = cv::mean(sized)[0];
    const double meanTruth = cv::mean(truth)[0];
    double product = 0;
    double square = 0;
    for (int y = 0; y < truth.rows; ++y) {
        for (int x = 0; x < truth.cols; ++x) {
            const double difference = static_cast<double>(sized.at<float>(y, x)) - meanEstimate;
            product += difference * (static_cast<double>(truth.at<float>(y, x)) - meanTruth);
            square += difference * difference;
        }
    }
    const double scale = square > 0 ? std::max(product / square, 0.0) : 0;
    sized.convertTo(sized, CV_32F, scale, meanTruth - scale * meanEstimate);
    cv::min(cv::max(sized, 0), 1, aligned);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
