#include "support/random_pictures.hpp"

#include <opencv2/imgproc.hpp>

namespace altiro3D::test {

cv::Mat randomPhoto(cv::Size size, int seed, double blur) {
    cv::RNG rng(static_cast<std::uint64_t>(seed));
    cv::Mat photo(size, CV_8UC3);
    rng.fill(photo, cv::RNG::UNIFORM, 0, 256);
    if (blur > 0) cv::GaussianBlur(photo, photo, {0, 0}, blur);
    return photo;
}

cv::Mat scenery(cv::Size size, int seed) {
    cv::Mat photo = randomPhoto(size, seed, 3.5);
    cv::normalize(photo, photo, 0, 255, cv::NORM_MINMAX);
    return photo;
}

cv::Mat randomDepth(cv::Size size, int seed) {
    cv::RNG rng(static_cast<std::uint64_t>(seed));
    cv::Mat depth(size, CV_32FC1);
    rng.fill(depth, cv::RNG::UNIFORM, 0, 1);
    return depth;
}

} // namespace altiro3D::test
