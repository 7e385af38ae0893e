#include "support/hand_slide.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {

namespace {

// A smooth motion between -1 and 1. @param t 0..1 @param kind chooses another one
double trembling(double t, int kind) {
    const double phase = 1.7 * kind + 0.4 * kind * kind;
    return 0.6 * std::sin(2 * CV_PI * (2.3 * t + phase)) +
           0.4 * std::sin(2 * CV_PI * (7.1 * t + 2.9 * phase));
}

cv::Matx33d about(int axis, double degrees) {
    const double c = std::cos(degrees * CV_PI / 180);
    const double s = std::sin(degrees * CV_PI / 180);
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    cv::Matx33d turn = cv::Matx33d::eye();
    turn(u, u) = turn(v, v) = c;
    turn(u, v) = -s;
    turn(v, u) = s;
    return turn;
}

// Spots of all sizes. @param seed chooses the colours
cv::Mat spots(cv::Size size, int seed) {
    cv::RNG random(static_cast<std::uint64_t>(seed));
    cv::Mat sum(size, CV_32FC3, cv::Scalar::all(0));
    double weight = 40;
    for (int grain = 40; grain >= 5; grain /= 2, weight *= 0.75) {
        cv::Mat noise(size.height / grain + 2, size.width / grain + 2, CV_32FC3);
        random.fill(noise, cv::RNG::UNIFORM, -weight, weight);
        cv::resize(noise, noise, size, 0, 0, cv::INTER_CUBIC);
        sum += noise;
    }
    cv::Mat picture;
    sum.convertTo(picture, CV_8U, 0.8, 60 + seed * 53 % 130); // boards differ in brightness
    return picture;
}

// From the axes of a camera (y down) to those of the world (y up).
cv::Matx33d axesOf(const HandCamera& camera) {
    return about(1, camera.panDegrees) * about(0, -camera.tiltDegrees) *
           about(2, camera.rollDegrees) * cv::Matx33d(1, 0, 0, 0, -1, 0, 0, 0, 1);
}

} // namespace

std::vector<HandCamera> handSlide(const HandSlide& hand) {
    std::vector<HandCamera> cameras(static_cast<std::size_t>(hand.pictures));
    // speed 1 + a sin, with (1 + a) / (1 - a) = ratio
    const double a = (hand.speedRatio - 1) / (hand.speedRatio + 1);
    std::vector<double> way(cameras.size());
    for (std::size_t i = 1; i < cameras.size(); ++i) {
        const double t = (static_cast<double>(i) - 0.5) / (hand.pictures - 1);
        way[i] = way[i - 1] + 1 + a * std::sin(2 * CV_PI * 1.5 * t);
    }
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        const double t = static_cast<double>(i) / std::max(1, hand.pictures - 1);
        HandCamera& camera = cameras[i];
        camera.place = {hand.length * (way[i] / std::max(way.back(), 1e-9) - 0.5),
                        hand.length * hand.away * trembling(t, 1),
                        hand.length * hand.away * trembling(t, 2)};
        camera.panDegrees = hand.turnDegrees * trembling(t, 3);
        camera.tiltDegrees = hand.turnDegrees * trembling(t, 4);
        camera.rollDegrees = hand.rollDegrees * trembling(t, 5);
        camera.zoom = 1 + hand.zoom * std::sin(2 * CV_PI * 1.3 * t);
        camera.exposure = 1 + hand.exposure / 2 * std::sin(2 * CV_PI * 0.8 * t + 1);
    }
    return cameras;
}

HandSlide shakyHand(int pictures, double length) {
    return {pictures, length, 1, 0.5, 0.01, 0.02, 3, 0.2};
}

Boards::Boards() {
    constexpr double kPerMetre = 220; // px
    const auto add = [&](const cv::Vec3d& corner, const cv::Vec3d& right, const cv::Vec3d& down) {
        const cv::Size size(cvRound(cv::norm(right) * kPerMetre),
                            cvRound(cv::norm(down) * kPerMetre));
        boards_.push_back({spots(size, static_cast<int>(boards_.size()) + 1), corner,
                           right * (1.0 / size.width), down * (1.0 / size.height)});
    };
    add({-4, 3, 6}, {8, 0, 0}, {0, -6, 0});    // a wall
    add({-4, -0.9, 6}, {8, 0, 0}, {0, 0, -5}); // a table
    add({-1.6, 0.2, 4.5}, {0.9, 0, 0.5}, {0, -1.1, 0});
    add({0.7, 0.9, 4}, {0.9, 0, -0.3}, {0, -1.6, 0});
    add({-0.6, -0.1, 3}, {0.7, 0, 0}, {0, -0.8, 0});
    add({0.25, -0.45, 2.2}, {0.35, 0, 0.1}, {0, -0.4, 0});
}

cv::Mat Boards::photograph(cv::Size size, const HandCamera& camera) const {
    const double focal = size.width * camera.zoom;
    const cv::Matx33d axes =
        axesOf(camera) * cv::Matx33d(1 / focal, 0, -size.width / 2.0 / focal, 0, 1 / focal,
                                     -size.height / 2.0 / focal, 0, 0, 1);
    constexpr int kFiner = 4; // samples of a px, each way
    const cv::Matx33d samples(kFiner, 0, -0.5, 0, kFiner, -0.5, 0, 0, 1);
    const cv::Matx33d view = samples * axes.inv();
    const cv::Size fine(size.width * kFiner, size.height * kFiner);
    cv::Mat picture(fine, CV_8UC3, cv::Scalar::all(0));
    for (const Board& board : boards_) { // from the back to the front
        const cv::Vec3d from = board.corner - camera.place + board.right * 0.5 + board.down * 0.5;
        const cv::Matx33d map =
            view * cv::Matx33d(board.right[0], board.down[0], from[0], board.right[1],
                               board.down[1], from[1], board.right[2], board.down[2], from[2]);
        cv::warpPerspective(board.texture, picture, map, fine, cv::INTER_LINEAR,
                            cv::BORDER_TRANSPARENT);
    }
    cv::Mat result;
    cv::resize(picture, result, size, 0, 0, cv::INTER_AREA);
    result.convertTo(result, CV_8U, camera.exposure);
    return result;
}

} // namespace altiro3D::test
