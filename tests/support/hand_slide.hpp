#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D::test {

/// A camera in a hand. At rest it stands at 0 and looks along +z.
struct HandCamera {
    cv::Vec3d place{0, 0, 0}; ///< Right, up, forwards, m.
    double panDegrees = 0;    ///< To the right.
    double tiltDegrees = 0;   ///< Up.
    double rollDegrees = 0;   ///< Clockwise.
    double zoom = 1;
    double exposure = 1;
};

/// How unsteady a hand is.
struct HandSlide {
    int pictures = 60;
    double length = 0.3; ///< m
    double turnDegrees = 0;
    double rollDegrees = 0;
    double zoom = 0;       ///< 0.01: by 1 % to both sides
    double away = 0;       ///< From a straight line, share of the length.
    double speedRatio = 1; ///< Fastest : slowest.
    double exposure = 0;   ///< 0.2: by 20 % in all
};

/// The cameras of a slide from left to right.
std::vector<HandCamera> handSlide(const HandSlide& hand);

/// What a hand does at its worst: turns by 1 degree, rolls by 0.5, zooms by 1 %, leaves the
/// straight line by 2 % of the path, moves at a speed that varies by 3, under light that varies by
/// 20 %.
HandSlide shakyHand(int pictures, double length);

/// Painted boards at 2 to 6 m, which a camera sees as projective maps of their pictures. Metres; x
/// to the right, y up, z forwards; a camera at rest stands at 0.
class Boards {
  public:
    Boards();
    /// The picture of a camera whose focal length is the width of its pictures.
    cv::Mat photograph(cv::Size size, const HandCamera& camera) const;

  private:
    struct Board {
        cv::Mat texture;
        cv::Vec3d corner; // the upper left one, m
        cv::Vec3d right;  // of a px of the texture
        cv::Vec3d down;
    };
    std::vector<Board> boards_;
};

} // namespace altiro3D::test
