#include "altiro3D/trade.hpp"

#include "altiro3D/error.hpp"
#include "base/text.hpp"

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

namespace {

void checkPair(const cv::Mat& picture, const cv::Mat& truth) {
    if (picture.empty() || picture.depth() != CV_8U) {
        throw Error(ErrorCode::InvalidArgument, "picture",
                    "is of type " + cv::typeToString(picture.type()) + " and size " +
                        sizeText(picture.size()) + ", expected 8-bit samples");
    }
    if (picture.size() != truth.size() || picture.type() != truth.type()) {
        throw Error(ErrorCode::Mismatch, "picture",
                    "has " + sizeText(picture.size()) + " px of type " +
                        cv::typeToString(picture.type()) + ", expected the truth's " +
                        sizeText(truth.size()) + " px of type " + cv::typeToString(truth.type()));
    }
}

// Local mean under the window.
cv::Mat blurred(const cv::Mat& samples) {
    cv::Mat mean;
    cv::GaussianBlur(samples, mean, {11, 11}, 1.5, 1.5, cv::BORDER_REFLECT_101);
    return mean;
}

} // namespace

double psnr(const cv::Mat& picture, const cv::Mat& truth) {
    checkPair(picture, truth);
    const double distance = cv::norm(picture, truth, cv::NORM_L2SQR);
    if (distance == 0) return std::numeric_limits<double>::infinity();
    const double samples = static_cast<double>(picture.total()) * picture.channels();
    return 10 * std::log10(255.0 * 255.0 * samples / distance);
}

double ssim(const cv::Mat& picture, const cv::Mat& truth) {
    checkPair(picture, truth);
    if (picture.channels() > 4) { // size of OpenCV's Scalar
        throw Error(ErrorCode::InvalidArgument, "picture",
                    "has " + std::to_string(picture.channels()) + " channels, expected at most 4");
    }
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
    cv::Mat luminance;
    cv::Mat structure;
    cv::add(2 * meanX.mul(meanY), c1, luminance);
    cv::add(2 * covariance, c2, structure);
    cv::Mat luminanceScale;
    cv::Mat structureScale;
    cv::add(meanX.mul(meanX) + meanY.mul(meanY), c1, luminanceScale);
    cv::add(varianceX + varianceY, c2, structureScale);
    cv::Mat map;
    cv::divide(luminance.mul(structure), luminanceScale.mul(structureScale), map);
    const cv::Scalar sum = cv::sum(map.reshape(1));
    return sum[0] / (static_cast<double>(map.total()) * map.channels());
}

} // namespace altiro3D
