#pragma once

#include <algorithm>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

/// Motion between the images of a video: its search in small grey copies of them, and resampling by
/// it. Results are the same for any number of threads.
namespace altiro3D {

/// Longest side of the small images, px.
constexpr int kSmallSide = 192;

/// Half the size, each px the mean of four. @param grey [CV_8UC1] @return [CV_8UC1]
cv::Mat halved(const cv::Mat& grey);

/// Scales a grey image to the brightness of `now`, by the median of their ratio over cells of 4 x 4
/// px. Differences of exposure and fades are thus removed.
/// @param grey, now [equal sizes, CV_8UC1] @return [CV_8UC1]
cv::Mat matchedBrightness(const cv::Mat& grey, const cv::Mat& now);

/// The two px around a position, with the border repeated.
struct Between {
    int low = 0;
    int high = 0;
    float share = 0; ///< Share of `high`.
};

inline Between between(float place, int count) {
    // NaN becomes 0; distant positions are clamped before the conversion to a whole number
    const float inside = place > 0 ? std::min(place, static_cast<float>(count - 1)) : 0.0F;
    Between result;
    result.low = static_cast<int>(inside);
    result.high = std::min(result.low + 1, count - 1);
    result.share = inside - static_cast<float>(result.low);
    return result;
}

/// Whether a px did not move: no interpolation is needed.
inline bool isStill(const cv::Vec2f& motion) {
    return motion[0] == 0 && motion[1] == 0;
}

/// Interpolates linearly between two values. @param share share of b, 0..1
template <class T>
T mixed(const T& a, const T& b, float share) {
    return a + (b - a) * share;
}

/// Interpolates bilinearly between four px.
template <class T>
T sampled(const cv::Mat& values, const Between& x, const Between& y) {
    const T* above = values.ptr<T>(y.low);
    const T* below = values.ptr<T>(y.high);
    return mixed(mixed(above[x.low], above[x.high], x.share),
                 mixed(below[x.low], below[x.high], x.share), y.share);
}

/// Joins motions: x was at x + later + earlier in the first picture. Linear, border repeated.
/// @param earlier from the middle to the first picture @param later from the last to the middle
/// @return from the last to the first picture [CV_32FC2, px]
cv::Mat joinMotion(const cv::Mat& earlier, const cv::Mat& later);

/// Moves values with motion: each px takes the value where it was. Linear, border repeated.
/// @param before [any size, CV_32FC1]
/// @param motion [any size, CV_32FC2, px of its own size]
/// @param moved [as before, CV_32FC1]; px that did not move are copied
void carry(const cv::Mat& before, const cv::Mat& motion, cv::Mat& moved);

/// Resamples an image of one channel, linear between px, border repeated.
/// @param values [CV_32FC1] @return [rows x cols, CV_32FC1]
cv::Mat stretched(const cv::Mat& values, int rows, int cols);

/// Distance of the cells for which motion is searched, px.
constexpr int kMotionCell = 4;

/// Finds where each px of `now` was in `before`: x was at x + motion(x). Still px have exactly 0.
/// @param before, now [equal sizes, CV_8UC1] @param motion [as now, CV_32FC2, px]
void findMotion(const cv::Mat& before, const cv::Mat& now, cv::Mat& motion);

/// Refines an approximate motion, for example from joinMotion().
/// @param motion in and out [as now, CV_32FC2, px]
void refineMotion(const cv::Mat& before, const cv::Mat& now, cv::Mat& motion);

/// Error of the moved picture: mean over 3 x 3 px of |gain before(x + motion) - now|. The gain is
/// the median over all cells, so exposure and fades do not count.
/// @param before, now [CV_8UC1]
/// @param motion [as now, CV_32FC2, px]
/// @return [CV_32FC1, 0..255]
cv::Mat misfit(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion);

/// Difference of two pictures after motion compensation: the misfit relative to the contrast of the
/// less contrasty picture, plus the share of cells whose motion differs from that of their
/// neighbours. Motion between unrelated pictures is wild. Values above kNewScene are a new scene.
/// @param motion, misfits from findMotion() and misfit()
/// @return 0 = the same picture
double dissimilarity(const cv::Mat& before, const cv::Mat& now, const cv::Mat& motion,
                     const cv::Mat& misfits);

/// Neighbouring pictures of one shot have at most .23, at double speed .34; pictures of different
/// scenes have .42 or more (docs/lab/video.md).
constexpr double kNewScene = 0.37;

/// Tracks the pictures of a video: repetitions, scene cuts and motion.
///
/// A picture without contrast (black, white, a flash) is skipped: it neither begins a scene nor has
/// motion, and the picture after it is compared with the last one that had contrast.
class PictureTracker {
  public:
    struct Step {
        bool repeated = false; // equals the picture before bit for bit
        bool cut = false;      // first picture, other size, or new scene
        bool blank = false;    // without contrast, and neither of those
        // motion since the previous picture [CV_32FC2, px]; empty if cut, repeated or blank
        cv::Mat motion;
    };

    /// The next picture [rows x cols, CV_8UC3, BGR].
    Step next(const cv::Mat& picture);

    /// Last picture with contrast [at most kSmallSide px per side, CV_8UC1]; never modified.
    const cv::Mat& grey() const { return grey_; }

    void save(std::string& bytes) const;
    /// Reads the data of save() from the front of `bytes`. @return false if it is invalid
    bool load(std::string_view& bytes);

  private:
    int rows_ = 0;
    int cols_ = 0;
    std::uint64_t hash_ = 0;
    cv::Mat grey_;
};

/// A number that differs between different pictures of one size and type but for one case in 2^64.
/// @param picture [any size and type]
std::uint64_t pictureHash(const cv::Mat& picture);

/// Whether pictures are the same bit for bit; those with gaps between their rows never are.
bool areEqual(const cv::Mat& a, const cv::Mat& b);

} // namespace altiro3D
