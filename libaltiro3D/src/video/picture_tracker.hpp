#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

namespace altiro3D {

/// Follows the pictures of a video: which are new, which begin a scene, what moved.
///
/// A picture without contrast (black, white, a flash) is no news: it neither begins a scene nor
/// moves anything, and the picture after it is compared with the last one that showed something.
class PictureTracker {
  public:
    struct Step {
        bool repeated = false; // equals the picture before bit for bit
        bool cut = false;      // first picture, other size, or new scene
        bool blank = false;    // shows nothing, and is none of those
        // since the picture before [CV_32FC2, px]; empty if cut, repeated or blank
        cv::Mat motion;
    };

    /// The next picture [rows x cols, CV_8UC3, BGR].
    Step next(const cv::Mat& picture);

    /// The last picture that showed something [at most kSmallSide px a side, CV_8UC1]. Never
    /// written to again.
    const cv::Mat& grey() const { return grey_; }

    void save(std::string& bytes) const;
    /// Takes what save() appended off the front. @return false if it is not that
    bool load(std::string_view& bytes);

  private:
    int rows_ = 0;
    int cols_ = 0;
    std::uint64_t hash_ = 0;
    cv::Mat grey_;
};

/// A number that differs between different pictures but for one case in 2^64.
/// @param picture [any size, CV_8UC3]
std::uint64_t pictureHash(const cv::Mat& picture);

} // namespace altiro3D
