#pragma once

#include "altiro3D/display.hpp"

#include <array>
#include <opencv2/core.hpp>

/// What an eye sees of a Native on a display: a slow, plain twin, in the order light goes. Nothing
/// but LensGeometry::phase is taken from the library.
///
///     Native ─► lightOf ─► LensTwin::seen ─► blurredByEye ─► eyeDifference ◄─ blurredByEye ◄─
///     truth
namespace altiro3D::test {

/// Linear light of a picture by the curve of sRGB.
/// @param picture [CV_8UC3, BGR] @return [as picture, CV_32FC3, BGR, 0..1]
cv::Mat lightOf(const cv::Mat& picture);

/// Lenses in front of a panel. In one direction, a lens shows one line of the panel: in each row
/// the sub-pixel nearest to it, over its whole width. That sub-pixel has one colour, and the light
/// of three, so that grey stays grey: on panels with cells it is more or less, as the colours'
/// parts of the width differ.
class LensTwin {
  public:
    /// @param lens its periods are some px wide
    explicit LensTwin(const LensGeometry& lens);

    /// What leaves the lenses in the direction of a phase. Mirrored panels stay mirrored.
    /// @param light of the Native [panel, CV_32FC3, BGR] @return [as light]
    cv::Mat seen(const cv::Mat& light, double phase) const;

  private:
    cv::Mat places_;           // [panel, CV_64FC3, RGB] place of each sub-pixel, counted in lenses
    cv::Vec3f gains_{1, 1, 1}; // BGR
};

/// A picture as sharp as an eye sees it. One arc minute at 50 cm is 1.85 px of a Portrait.
struct EyePicture {
    static constexpr std::array<double, 3> kSigmas{2, 3, 4}; ///< Blur of luminance, panel px.
    static constexpr double kColourSigma = 6;                ///< Blur of colour, panel px.
    std::array<cv::Mat, 3> luminance; ///< Blurred by kSigmas, coded by sRGB's curve [CV_32FC1].
    cv::Mat colour;                   ///< a and b of CIELAB [CV_32FC2].
};

/// Blurs light. @param light [CV_32FC3, BGR]
EyePicture blurredByEye(const cv::Mat& light);

/// How much an eye sees of a difference.
struct EyeDifference {
    std::array<double, 3> luminancePsnr{}; ///< dB, for EyePicture::kSigmas.
    double chroma = 0;                     ///< Mean distance in the plane of a and b.
};

/// Compares two pictures, but for 24 px at each border.
EyeDifference eyeDifference(const EyePicture& picture, const EyePicture& truth);

} // namespace altiro3D::test
