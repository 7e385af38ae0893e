#include "support/compare.hpp"

#include <cmath>
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
    if (difference.sameShape && difference.samples == 0)
        return ::testing::AssertionFailure() << "both are empty: nothing is compared";
    if (difference.sameShape && difference.count == 0) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << difference.report;
}

} // namespace altiro3D::test
