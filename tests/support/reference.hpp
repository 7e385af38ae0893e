#pragma once

#include "altiro3D/depth_map.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/quilt.hpp"

#include <array>
#include <opencv2/core.hpp>
#include <vector>

/// Slow, obvious twins of the library's fast paths, written from the formulas alone.
namespace altiro3D::test {

/// Position under the lens of a sub-pixel, 0..1, in long double: the formula of docs/mathematics.md
/// section 1, with nothing taken from the library.
/// @param y row from the top @param channel 0 red, 1 green, 2 blue
long double referencePhase(const Calibration& calibration, bool inverted, int x, int y,
                           int channel);

/// View of a sub-pixel: min(floor(phase * views), views - 1).
int referenceView(const Calibration& calibration, bool inverted, int views, int x, int y,
                  int channel);

/// View of a sub-pixel of a CubeVi C1, as its maker publishes it. @param x, y from 0, top left
int referenceCubeViView(double interval, double slope, double x0, int x, int y, int colour);

/// View of the sub-pixel i of the row j of a screen with a barrier, both from 0: (1.16).
int referenceBarrierView(double pitch, double slope, double offset, const std::vector<int>& order,
                         int views, int i, int j);

/// Quilt pixel that a sub-pixel shows: tile of its view, nearest pixel in it.
cv::Point referenceQuiltPixel(const Calibration& calibration, bool inverted,
                              const QuiltLayout& layout, int x, int y, int channel);

/// Method Fast in double, without cv::remap: photo(x + shift (depth - focus), y), linear, clamped.
/// @param photo [CV_8UC3] @param depth [CV_32FC1] @param shiftPixels p S/2
/// @return [CV_64FC3], not rounded
cv::Mat referenceFast(const cv::Mat& photo, const cv::Mat& depth, double shiftPixels, double focus);

/// The picture that an eye sees of a Native through the lenses: each px takes each colour from the
/// nearest px whose sub-pixel of that colour has a phase within half the spot of the eye's. Ties go
/// to the nearer row, then to the upper row, then to the left. Mirrored panels stay mirrored.
/// @param native [CV_8UC3] @param phase of the eye @param spot its width, lens periods
cv::Mat referenceLensView(const cv::Mat& native, const Calibration& calibration, bool inverted,
                          double phase, double spot);

/// Chromaticities of red, green and blue, x and y of each; white is D65.
using Chromaticities = std::array<double, 6>;
constexpr Chromaticities kSrgb = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06};
constexpr Chromaticities kDisplayP3 = {0.680, 0.320, 0.265, 0.690, 0.150, 0.060};
constexpr Chromaticities kRec2020 = {0.708, 0.292, 0.170, 0.797, 0.131, 0.046};

/// Linear RGB to XYZ.
cv::Matx33d referenceXyz(const Chromaticities& chromaticities);

/// Linear light of a value of sRGB's curve, 0..1.
double referenceLight(double srgb);

/// The curve of sRGB. @param light 0 and more @return 0..1 for light 0..1
double srgbCode(double light);

/// Light in cd/m^2 coded by PQ (SMPTE ST 2084), 0..1.
double referencePq(double nits);

/// A colour as sRGB, from the chromaticities alone, in double: decoded, to XYZ, to sRGB's
/// primaries, clipped, encoded.
/// @param bgr 0..1, as encoded @param exponent of the decoding; 0 = the curve of sRGB
/// @return BGR, 0..1
cv::Vec3d referenceSrgb(const cv::Vec3d& bgr, const Chromaticities& chromaticities,
                        double exponent);

/// A colour of an HDR picture as sRGB, from the formulas of BT.2100 and BT.2390 alone, in double.
/// @param bgr 0..1, as encoded
/// @param isHlg HLG, else PQ
/// @return BGR, 0..1
cv::Vec3d referenceToneMapped(const cv::Vec3d& bgr, const Chromaticities& chromaticities,
                              bool isHlg);

/// fitDepth() for enlargement: per px and in double, directly from the definition.
/// @param depth [CV_32FC1] @param part in px of `depth` @param guide [CV_8UC3]
/// @return [rows x cols of guide, CV_32FC1]
cv::Mat referenceFit(const cv::Mat& depth, const cv::Rect2d& part, const cv::Mat& guide);

/// sharpenSteps(): per px and in double, from the formulas of docs/mathematics.md, 4a.3.
/// @param photo [CV_8UC3] @param flaws of even steps @param depth [as photo, CV_32FC1, 0..1]
/// @return [as photo, CV_32FC1]
cv::Mat referenceSharpenSteps(const cv::Mat& photo, const DepthFlaws& flaws, const cv::Mat& depth);

/// decideContours(): per px and in double, from the formulas of docs/mathematics.md, 4a.4.
/// @param photo [CV_8UC3] @param depth [as photo, CV_32FC1]
/// @return [as photo, CV_32FC1]
cv::Mat referenceDecideContours(const cv::Mat& photo, const cv::Mat& depth);

/// straightenLines(): in double, from the formulas of docs/mathematics.md, 4a.5.
/// @param lines ends in px, x and y @param depth [CV_32FC1]
/// @param passes of the relaxation; the membrane comes to rest after some thousand
/// @return [as depth, CV_32FC1]
cv::Mat referenceStraightenLines(const std::vector<cv::Vec4f>& lines, const cv::Mat& depth,
                                 int passes = 14);

/// subjectWeights() of a photo of at most 320 px per side: per px, directly from the formula.
/// @param photo [CV_8UC3] @param depth [CV_32FC1] @return [CV_32SC1]
cv::Mat referenceSubjectWeights(const cv::Mat& photo, const cv::Mat& depth);

/// The window with the largest sum of weights, its middle half counted twice; then the nearest to
/// the middle, then the upper one, then the left one. @param weights [CV_32SC1]
cv::Rect referenceBestWindow(const cv::Mat& weights, cv::Size window);

/// downscale(): the rounded mean of all px that a px of the result touches.
/// @param photo [CV_8UC3]
/// @return [CV_8UC3]
cv::Mat referenceDownscale(const cv::Mat& photo, int longestSide);

} // namespace altiro3D::test
