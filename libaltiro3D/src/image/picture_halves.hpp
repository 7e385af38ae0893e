#pragma once

#include "altiro3D/image_io.hpp"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace altiro3D {

/// The halves of a picture: the left and the right one, or the upper and the lower one.
struct HalfPlaces {
    cv::Rect first;
    cv::Rect second;
};

/// @param gap px between the halves, which belong to neither; one more if the rest is odd
/// @return halves of one size; empty ones if the picture is too small
inline HalfPlaces halfPlaces(cv::Size whole, bool isBeside, int gap = 0) {
    const cv::Size half(isBeside ? std::max(0, whole.width - gap) / 2 : whole.width,
                        isBeside ? whole.height : std::max(0, whole.height - gap) / 2);
    return {{{0, 0}, half}, {{whole.width - half.width, whole.height - half.height}, half}};
}

/// Direction in which halves are squeezed to half their size.
enum class Squeeze { None, Width, Height };

/// @param whole width : height of the whole picture
inline Squeeze squeezeOf(double whole, bool isBeside, StereoHalves halves) {
    constexpr double kNarrowest = 1.70; // of 3D TV: 16:9 = 1.78
    constexpr double kWidest = 1.85;    // of 3D cinema
    if (halves == StereoHalves::Full) return Squeeze::None;
    if (halves == StereoHalves::Automatic && !(whole >= kNarrowest && whole <= kWidest))
        return Squeeze::None;
    return isBeside ? Squeeze::Width : Squeeze::Height;
}
inline Squeeze squeezeOf(cv::Size whole, bool isBeside, StereoHalves halves) {
    return squeezeOf(static_cast<double>(whole.width) / whole.height, isBeside, halves);
}

/// The size of a half in the shape of the scene.
inline cv::Size stretchedSize(cv::Size half, Squeeze squeeze) {
    if (squeeze == Squeeze::Width) half.width *= 2;
    if (squeeze == Squeeze::Height) half.height *= 2;
    return half;
}

/// Gives a half the shape of the scene. @param interpolation of OpenCV
inline void stretch(cv::Mat& half, Squeeze squeeze, int interpolation) {
    if (squeeze == Squeeze::None) return;
    cv::Mat stretched;
    cv::resize(half, stretched, stretchedSize(half.size(), squeeze), 0, 0, interpolation);
    half = stretched;
}

} // namespace altiro3D
