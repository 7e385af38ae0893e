#pragma once

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {

/// How two pictures differ, over all channels.
struct Difference {
    bool sameShape = false;  ///< Same size and type.
    std::size_t count = 0;   ///< Channel samples that differ by more than the tolerance.
    std::size_t samples = 0; ///< Channel samples in all.
    double largest = 0;      ///< Largest absolute difference.
    double mean = 0;         ///< Mean absolute difference.
    std::string report;      ///< All of that and the first differing positions, for people.
};

/// Compares two pictures sample by sample. NaN equals NaN.
Difference compare(const cv::Mat& actual, const cv::Mat& expected, double tolerance = 0);

/// Success if no sample differs by more than the tolerance. If it is not 0, state the reason at the
/// call. Two empty pictures are a failure, because nothing would be tested.
::testing::AssertionResult samePicture(const cv::Mat& actual, const cv::Mat& expected,
                                       double tolerance = 0);

} // namespace altiro3D::test
