#pragma once

#include "altiro3D/error.hpp"
#include "altiro3D/export.hpp"
#include "altiro3D/image_io.hpp"

#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <tuple>
#include <vector>

namespace altiro3D {

/// Meaning of the numbers in a depth image.
enum class DepthKind {
    NearWhite, ///< Larger = nearer, linear in inverse depth (MiDaS, Looking Glass RGB-D).
    FarWhite,  ///< Larger = farther, linear in inverse depth.
    Metric     ///< Distance Z in any unit; 0, negative and NaN = unknown, +inf = infinitely far.
};

/// How raw depth numbers are mapped to a depth map of 0..1.
struct DepthNormalization {
    DepthKind kind = DepthKind::NearWhite; ///< Meaning of the raw numbers.
    double lowPercentile = 0.5;            ///< Percentile that becomes 0 (farthest), 0..50 %.
    double highPercentile = 99.5;          ///< Percentile that becomes 1 (nearest), 50..100 %.
    double flatDepth = 0.5;                ///< Result for input without a depth range, 0..1.
};

/// Turns raw depth numbers into a depth map: relative inverse depth, 0..1, 1 = nearest
/// (docs/mathematics.md, 4).
///
/// The two percentiles of the valid values (for metric depth: of 1/Z) become 0 and 1, and values
/// beyond are clamped, so outliers do not compress the rest. A percentile is the value at its rank,
/// without interpolation. Ranks are rounded outwards: of 200 values or fewer, percentile 0.5 is the
/// smallest and percentile 99.5 the largest.
///
/// An unknown value takes the depth of the next valid value to its left or right, whichever is
/// farther from the camera. A row without valid values becomes a copy of the nearest row that has
/// some. Non-finite values are unknown, except +inf in metric depth, which is infinitely far. In
/// metric depth, Z <= 0 is unknown as well, and so is the 16-bit value 65535. But if values of
/// 64880..65534 occur too, 65535 is a valid distance, the farthest one.
///
/// The result is defined for every input of a valid type: an image that is constant, entirely
/// unknown, or whose range between the percentiles is floating-point noise (1e-6 of the larger
/// value, or denormal) gives `flatDepth` everywhere.
/// @param raw [rows x cols, CV_8UC1, CV_16UC1, CV_32FC1 or CV_64FC1, any range]
/// @param depth [rows x cols, CV_32FC1, 0..1, 1 = nearest]; may be `raw` itself
/// @param options kind, percentiles and the result without a range
/// @throws Error InvalidArgument (empty, wrong type, percentiles or flatDepth out of range)
ALTIRO3D_EXPORT void normalizeDepth(const cv::Mat& raw, cv::Mat& depth,
                                    const DepthNormalization& options = {});

/// Rejects a matrix that holds numbers other than depth of 0..1, such as metres or 0..255: one in
/// which more than half of the finite values of up to 64 sampled rows lie outside -0.1..1.1. Single
/// outliers are accepted; functions that use depth clamp them.
/// @param depth [rows x cols, CV_32FC1]
/// @throws Error InvalidArgument (empty, wrong type, other numbers)
ALTIRO3D_EXPORT void checkDepthRange(const cv::Mat& depth);

/// Resamples a depth map to the size of a picture and aligns its edges with those of the picture.
///
/// If the map is enlarged, each px gets the mean of the depth samples around it, weighted by their
/// distance and by how similar the picture is at the px and at each sample (joint bilateral
/// upsampling, docs/mathematics.md, (4.1)). If it is shrunk, each px gets the nearest sample, so
/// the depth at an edge is that of one side and never a mixture. Equal sizes are copied. The result
/// stays within the range of the samples. Where the picture is uniform, ramps of depth stay ramps.
/// @param depth [any size, CV_32FC1, 0..1]
/// @param part the part of `depth` that the guide shows, in px of `depth` (fractions allowed),
///        inside [0, cols] x [0, rows]
/// @param guide [rows x cols, CV_8UC3, BGR], the picture
/// @param fitted [rows x cols of guide, CV_32FC1, 0..1]
/// @throws Error InvalidArgument (empty or wrong type, a part that is empty or leaves `depth`)
ALTIRO3D_EXPORT void fitDepth(const cv::Mat& depth, const cv::Rect2d& part, const cv::Mat& guide,
                              cv::Mat& fitted);

/// Position of the depth half in a one-picture RGB-D.
enum class DepthSide { Right, Left, Top, Bottom };

/// Where the depth half is, and the shape of both halves.
struct RgbdLayout {
    /// Makes a layout; a side alone converts to one with full halves.
    /// @param depthSide position of the depth half @param shape shape of both halves
    // NOLINTNEXTLINE(google-explicit-constructor)
    RgbdLayout(DepthSide depthSide = DepthSide::Right, StereoHalves shape = StereoHalves::Full)
        : side(depthSide), halves(shape) {}
    DepthSide side;      ///< Position of the depth half.
    StereoHalves halves; ///< Squeezed halves are stretched to the shape of the scene.

    /// The size of the photo in an RGB-D image of a given size that has no gap.
    /// @param whole size of the whole picture, px @return px
    [[nodiscard]] ALTIRO3D_EXPORT cv::Size photoSize(cv::Size whole) const;
};

/// Splits a one-picture RGB-D into photo and raw depth, exactly in the middle (an odd row or column
/// in the middle belongs to neither). A white gap between photo and depth side by side, of at least
/// 8 px, belongs to neither. Depth that is drawn in colours is read as readDepthSamples() does.
/// Squeezed halves are stretched as splitStereoPair() does; depth keeps its numbers.
/// @param picture [rows x cols, CV_8UC3 or CV_16UC3, BGR]
/// @param layout position of the depth half, shape of the halves
/// @param photo [one half, stretched if squeezed, CV_8UC3, BGR]; 16-bit values are divided by 257
///        and rounded; may be `picture` itself
/// @param rawDepth [size of photo, CV_32FC1, grey value of the depth half: 0..255, or 0..65535 for
///        16-bit pictures]
/// @param notes if given, receives remarks about a gap and about colours of the depth half
/// @throws Error InvalidArgument (too small to split, wrong type), BadFormat (the colours of the
///         depth fit two colour maps)
ALTIRO3D_EXPORT void splitRgbd(const cv::Mat& picture, const RgbdLayout& layout, cv::Mat& photo,
                               cv::Mat& rawDepth, Notes* notes = nullptr);

/// Reads an RGB-D image: as readImage(), but the numbers of the depth half stay as in the file,
/// while the colours of the photo are converted to sRGB.
/// @param file as for readImage()
/// @param side position of the depth half
/// @param notes as for readImage()
/// @return [rows x cols, CV_8UC3, CV_16UC3 or CV_32FC3, BGR]
/// @throws Error as readImage()
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat readRgbdImage(const PhotoFile& file, DepthSide side,
                                                    Notes* notes = nullptr);

/// Finds the depth half of a picture whose name says that it is an RGB-D image: the half that is
/// drawn in a colour map of depth (readDepthImage()), or that is grey while the other one has
/// colours. In a grey picture: the only half that looksLikeDepthImage() accepts, provided the edges
/// of both halves coincide.
/// @param picture [rows x cols, CV_8UC3 or CV_16UC3, BGR]
/// @param isStacked the halves above each other are examined first
/// @return its position; nothing if neither half is depth
/// @throws Error InvalidArgument (empty, wrong type)
[[nodiscard]] ALTIRO3D_EXPORT std::optional<DepthSide> findDepthHalf(const cv::Mat& picture,
                                                                     bool isStacked = false);

/// Joins photo and depth to a one-picture RGB-D, near = white.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [rows x cols, CV_32FC1, 0..1, 1 = nearest]
/// @param layout position of the depth half. Squeezed halves have half the width (above each other:
///        height), rounded up; colours are averaged, depth is sampled.
/// @param picture [both halves, CV_8UC3, BGR]; may be `photo` itself
/// @throws Error InvalidArgument (empty, wrong type, photo and depth differ in size)
ALTIRO3D_EXPORT void joinRgbd(const cv::Mat& photo, const cv::Mat& depth, const RgbdLayout& layout,
                              cv::Mat& picture);

/// Expands the range of near or of far depth: d' = d^exponent; 0 and 1 stay.
/// @param depth [rows x cols, CV_32FC1, 0..1], clamped; NaN stays
/// @param exponent 0.5..2; above 1 the foreground gets more of the range, below 1 the background
/// @return [as depth]; `depth` itself with exponent 1. The same bytes on any processor.
/// @throws Error InvalidArgument (empty, wrong type, exponent)
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat bendDepth(const cv::Mat& depth, double exponent);

/// Converts a depth map to 16 bits: 0 = farthest, 65535 = nearest.
/// @param depth [rows x cols, CV_32FC1, 0..1]; clamped, NaN counts as 0
/// @return [rows x cols, CV_16UC1]
/// @throws Error InvalidArgument (empty or wrong type)
[[nodiscard]] ALTIRO3D_EXPORT cv::Mat depthTo16Bit(const cv::Mat& depth);

/// How the edges of a depth map differ from those of its photo. All zero: no flaw was found.
struct DepthFlaws {
    /// Width over which depth steps are spread, px, 0..64; 0 for hard steps. A Gaussian blur of
    /// sigma s gives 2.5 s - 1. It is measured at the harder steps; with `isUneven`, at the softer
    /// ones, and is then at most 4 % of the longer side.
    double softnessPixels = 0;
    /// Near objects are too large by this on each side, px, -7..7; negative: too small.
    double growthPixels = 0;
    /// The depth map lies this far to the right of the photo and below it, px, each -7..7.
    cv::Point shiftPixels;
    /// The steps differ in softness, as those of depth networks do. Steps of blurred or enlarged
    /// depth are equally soft. Ignored for hard steps.
    bool isUneven = false;
    /// The equally soft steps fade out slowly: they come from a blur, not from enlargement. Almost
    /// hard steps may be misjudged. Ignored for hard and for uneven steps.
    bool isBlurred = false;
    /// Width of the band around near objects in which a soft photo mixes them with the background,
    /// px, 0..7. One px, which even sharp photos have, is not counted. Measurements give at most 2.
    int mixedPixels = 0;

    /// Whether there is any flaw. @return true if a number is not 0
    [[nodiscard]] bool any() const {
        return softnessPixels != 0 || growthPixels != 0 || shiftPixels != cv::Point() ||
               mixedPixels != 0;
    }

    /// All fields, to save them. @param o the flaws @return references to its fields
    template <typename Flaws>
    static auto fields(Flaws& o) {
        return std::tie(o.softnessPixels, o.growthPixels, o.shiftPixels.x, o.shiftPixels.y,
                        o.isUneven, o.isBlurred, o.mixedPixels);
    }
};

/// Whether flaws are equal. @param a one @param b the other @return true if all fields are
[[nodiscard]] inline bool operator==(const DepthFlaws& a, const DepthFlaws& b) {
    return DepthFlaws::fields(a) == DepthFlaws::fields(b);
}

/// Options of refineDepth().
struct DepthRefineOptions {
    /// Flaws to correct, for example those of an earlier frame of the scene; not set: they are
    /// measured. `DepthFlaws()` keeps an exact depth map unchanged, but normalizeDepth() and
    /// fitDepth(), which come before, still change values and size.
    std::optional<DepthFlaws> flaws;

    /// Whether the depth map stays unchanged. @return true if `flaws` is set and holds no flaw
    [[nodiscard]] bool keepsDepth() const { return flaws && !flaws->any(); }
};

/// Measures how a depth map differs from its photo. A flaw counts if many edges of the picture show
/// it. Flaws that are too small to matter are reported as 0 (docs/mathematics.md, 4a).
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]; values beyond are clamped, NaN counts as 0
/// @return the flaws
/// @throws Error InvalidArgument (empty, wrong type), Mismatch (sizes differ)
[[nodiscard]] ALTIRO3D_EXPORT DepthFlaws measureDepthFlaws(const cv::Mat& photo,
                                                           const cv::Mat& depth);

/// Corrects the flaws of a depth map: moves edges to the edges of the photo, turns soft steps into
/// hard ones where the photo has an edge, and extends near objects over their mixed px. A depth map
/// without flaws is not changed.
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]; values beyond are clamped, NaN counts as 0
/// @param refined [as depth]; may be `depth` itself
/// @param options which flaws; if it keepsDepth(), the depth is copied unchanged
/// @return the flaws that were corrected
/// @throws Error InvalidArgument (empty, wrong type, flaws out of range), Mismatch (sizes differ)
ALTIRO3D_EXPORT DepthFlaws refineDepth(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& refined,
                                       const DepthRefineOptions& options = {});

/// Whether near and far of a depth map look exchanged: far = 1 instead of near = 1.
///
/// Three criteria must be met, because a false alarm is worse than a missed one (docs/depth.md):
/// - the depth falls from the top to the bottom: its correlation with the row is -0.3 or less;
/// - the border of the upper half is nearer than the middle, on average;
/// - the depth contradicts the photo: its correlation with an estimate is -0.3 or less.
///
/// All are measured at 64 x 64 places. For depth with a standard deviation below 0.02 there, the
/// result is false.
/// @param depth of a photo [any size, CV_32FC1, 0..1, 1 = nearest]; clamped, NaN counts as 0
/// @param estimate called if the first two criteria are met; gives a depth map of the same photo,
///        as `depth`, for example by estimatedDepth(), or an empty one: the result is then false
/// @return true if near and far are probably exchanged
/// @throws Error InvalidArgument (empty or wrong type); what `estimate` throws
[[nodiscard]] ALTIRO3D_EXPORT bool looksInverted(const cv::Mat& depth,
                                                 const std::function<cv::Mat()>& estimate);

/// What a brush does to a depth map.
enum class DepthBrush {
    Nearer,  ///< Adds the amount.
    Farther, ///< Subtracts the amount.
    Smooth,  ///< Averages over about half of the radius.
    Level    ///< Moves all depth to one level.
};

/// Options of a DepthStroke.
struct DepthBrushOptions {
    DepthBrush brush = DepthBrush::Nearer; ///< What the brush does.
    /// Radius in px of the map, 0.5..4096. The inner half has the full effect, which falls to 0 at
    /// the radius.
    double radius = 40;
    /// Nearer, Farther: change of depth, 0..1. Smooth, Level: share of the full change, 0..1.
    double amount = 0.1;
    double level = 0.5; ///< The depth that Level moves to, 0..1.
    /// Whether the brush stops at edges of the photo (docs/mathematics.md, 4b). At each place of a
    /// stroke, the brush changes only the surface under its centre.
    bool keepsEdges = true;
};

/// One stroke of a brush over a depth map. A place that the stroke meets several times is changed
/// once, with the largest effect. One thread at a time.
class ALTIRO3D_EXPORT DepthStroke {
  public:
    /// Begins a stroke that has not touched the depth map yet.
    /// @param photo [rows x cols, CV_8UC3, BGR]
    /// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]; values beyond are clamped, NaN counts
    ///        as 0; it is not changed
    /// @param options what the stroke does
    /// @throws Error InvalidArgument (empty, wrong type, options out of range), Mismatch (sizes
    ///         differ)
    DepthStroke(const cv::Mat& photo, const cv::Mat& depth, const DepthBrushOptions& options);
    ~DepthStroke();
    DepthStroke(DepthStroke&&) noexcept;            ///< Moves.
    DepthStroke& operator=(DepthStroke&&) noexcept; ///< Moves. @return *this

    /// Draws a straight line from the last place, or begins at this one.
    /// @param place x and y, px; (0, 0) is the centre of the first px. May lie outside the photo.
    /// @return the part of the depth map that may have changed; empty if none
    /// @throws Error InvalidArgument (not finite)
    cv::Rect moveTo(cv::Point2d place);

    /// The depth map so far. @return [as photo, CV_32FC1, 0..1]; later calls of moveTo() change it
    [[nodiscard]] const cv::Mat& depth() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Moves the inside of an outline nearer or farther. The border follows the strongest edges of the
/// photo near the outline, up to 5 % of the photo's longer side inside it and 1.5 % outside;
/// without edges it is the outline (docs/mathematics.md, 4b).
/// @param photo [rows x cols, CV_8UC3, BGR]
/// @param depth [as photo, CV_32FC1, 0..1, 1 = nearest]; values beyond are clamped, NaN counts as 0
/// @param outline a closed polygon, px; (0, 0) is the centre of the first px. Points outside the
///        photo are moved to its border. Fewer than three points enclose nothing.
/// @param amount change of depth, -1..1; positive is nearer
/// @param lifted [as depth]; may be `depth` itself
/// @return the part of the depth map that may have changed; empty if none
/// @throws Error InvalidArgument (empty, wrong type, an amount out of range, a point that is not
///         finite), Mismatch (sizes differ)
ALTIRO3D_EXPORT cv::Rect liftDepth(const cv::Mat& photo, const cv::Mat& depth,
                                   const std::vector<cv::Point2d>& outline, double amount,
                                   cv::Mat& lifted);

} // namespace altiro3D
