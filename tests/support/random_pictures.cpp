#include "support/random_pictures.hpp"

#include <opencv2/imgproc.hpp>

namespace altiro3D::test {

cv::Mat randomPicture(cv::Size size, int type, int seed, double low, double high) {
    cv::Mat picture(size, type);
    cv::RNG(static_cast<std::uint64_t>(seed)).fill(picture, cv::RNG::UNIFORM, low, high);
    return picture;
}

cv::Mat randomPhoto(cv::Size size, int seed, double blur) {
    cv::Mat photo = randomPicture(size, CV_8UC3, seed);
    if (blur > 0) cv::GaussianBlur(photo, photo, {0, 0}, blur);
    return photo;
}

cv::Mat scenery(cv::Size size, int seed) {
    cv::Mat photo = randomPhoto(size, seed, 3.5);
    cv::normalize(photo, photo, 0, 255, cv::NORM_MINMAX);
    return photo;
}

cv::Mat randomDepth(cv::Size size, int seed) {
    return randomPicture(size, CV_32FC1, seed, 0, 1);
}

} // namespace altiro3D::test
