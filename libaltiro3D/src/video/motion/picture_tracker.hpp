#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

namespace altiro3D {

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

    /// The last picture with contrast [at most kSmallSide px per side, CV_8UC1]. It is never
    /// written to again.
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
