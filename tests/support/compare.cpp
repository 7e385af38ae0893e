#include "support/compare.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

namespace altiro3D::test {

Difference compare(const cv::Mat& actual, const cv::Mat& expected, double tolerance) {
    Difference difference;
    std::ostringstream report;
    if (actual.size() != expected.size() || actual.type() != expected.type()) {
        report << "shape " << actual.cols << " x " << actual.rows << " type " << actual.type()
               << " instead of " << expected.cols << " x " << expected.rows << " type "
               << expected.type();
        difference.report = report.str();
        return difference;
    }
    difference.sameShape = true;
    cv::Mat a;
    cv::Mat e;
    actual.convertTo(a, CV_64F);
    expected.convertTo(e, CV_64F);
    const int channels = a.channels();
    double sum = 0;
    int shown = 0;
    for (int y = 0; y < a.rows; ++y) {
        const double* rowA = a.ptr<double>(y);
        const double* rowE = e.ptr<double>(y);
        for (int i = 0; i < a.cols * channels; ++i) {
            ++difference.samples;
            if (rowA[i] == rowE[i] || (std::isnan(rowA[i]) && std::isnan(rowE[i]))) continue;
            const double d = std::abs(rowA[i] - rowE[i]);
            if (!(d <= difference.largest)) difference.largest = d;
            sum += d;
            if (d <= tolerance) continue;
            ++difference.count;
            if (shown < 5) {
                ++shown;
                report << "\n  (x " << i / channels << ", y " << y << ", channel " << i % channels
                       << ") is " << rowA[i] << ", expected " << rowE[i];
            }
        }
    }
    if (difference.samples > 0) difference.mean = sum / static_cast<double>(difference.samples);
    std::ostringstream head;
    head << difference.count << " of " << difference.samples << " samples differ by more than "
         << tolerance << ", largest " << difference.largest << ", mean " << difference.mean;
    difference.report = head.str() + report.str();
    return difference;
}

::testing::AssertionResult samePicture(const cv::Mat& actual, const cv::Mat& expected,
                                       double tolerance) {
    const Difference difference = compare(actual, expected, tolerance);
    if (difference.sameShape && difference.samples == 0) {
        return ::testing::AssertionFailure() << "both are empty: nothing is compared";
    }
    if (difference.sameShape && difference.count == 0) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << difference.report;
}

namespace {

std::vector<double> ranks(const std::vector<float>& values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
    std::vector<double> rank(values.size());
    for (std::size_t first = 0; first < order.size();) {
        std::size_t last = first;
        while (last < order.size() && values[order[last]] == values[order[first]])
            ++last;
        const double mean = 0.5 * static_cast<double>(first + last - 1);
        for (std::size_t i = first; i < last; ++i)
            rank[order[i]] = mean;
        first = last;
    }
    return rank;
}

} // namespace

double rankCorrelation(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
    CV_Assert(a.type() == CV_32FC1 && b.type() == CV_32FC1 && a.size() == b.size());
    std::vector<float> valuesA;
    std::vector<float> valuesB;
    for (int y = 0; y < a.rows; ++y) {
        for (int x = 0; x < a.cols; ++x) {
            if (!mask.empty() && mask.at<uchar>(y, x) == 0) continue;
            valuesA.push_back(a.at<float>(y, x));
            valuesB.push_back(b.at<float>(y, x));
        }
    }
    const std::vector<double> rankA = ranks(valuesA);
    const std::vector<double> rankB = ranks(valuesB);
    const double mean = 0.5 * (static_cast<double>(rankA.size()) - 1);
    double ab = 0;
    double aa = 0;
    double bb = 0;
    for (std::size_t i = 0; i < rankA.size(); ++i) {
        ab += (rankA[i] - mean) * (rankB[i] - mean);
        aa += (rankA[i] - mean) * (rankA[i] - mean);
        bb += (rankB[i] - mean) * (rankB[i] - mean);
    }
    return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

} // namespace altiro3D::test
