#pragma once

#include "slide/slide_solver.hpp"

#include <cstddef>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

constexpr int kTrackSide =
    800; ///< px of the longer side of pictures in which corners are followed.

/// A reduced picture of a clip.
struct SlidePicture {
    int number = 0; ///< In the clip, from 0.
    cv::Mat grey;   ///< [at most kTrackSide, CV_8UC1]
    double sharpness = 0;
};

/// Keeps reduced pictures of a clip: all, or every second, fourth, ... of a long one.
class SlidePictures {
  public:
    /// @param picture [rows x cols, CV_8UC3, BGR], the next one
    void add(const cv::Mat& picture);
    std::vector<SlidePicture>& kept() { return kept_; }
    int count() const { return count_; }

  private:
    std::vector<SlidePicture> kept_;
    int count_ = 0;
    int stride_ = 1;
};

/// How pictures differ from those before them.
struct PictureSteps {
    std::vector<cv::Point2d> steps; ///< Median step of each picture's corners, px; first: 0.
    std::vector<int> counts;        ///< Corners that were followed to each picture, at most 120.
    cv::Size window;                ///< Window in which corners are compared, px.
};
/// Steps of pictures. The window is wide if that follows more corners, as it does in strong noise.
PictureSteps stepsOf(const std::vector<SlidePicture>& pictures);
PictureSteps stepsWith(const std::vector<SlidePicture>& pictures, cv::Size window);

/// Chooses pictures at equal steps of the way, of each step the sharpest one.
/// @param most their number at most @return indices, ascending
std::vector<std::size_t> choosePictures(const std::vector<SlidePicture>& pictures,
                                        const std::vector<cv::Point2d>& steps, int most);

/// Corners followed through pictures.
struct SlideTracks {
    std::vector<SlideTrack> tracks;
    std::vector<double> gains; ///< Brightness of each picture; that of the first one is 1.
    int fewest = 0;            ///< Corners that were followed at least between two pictures.
};

/// Follows corners (pyramidal Lucas-Kanade, forwards and back). Each place is then compared with
/// the picture in which its track begins, so errors do not add up. The mean brightness around it
/// does not count, because a change of the light would move the places. Where this fails, the track
/// ends.
/// @param aspect height : width of the pictures of the clip
/// @param window of stepsOf()
SlideTracks followCorners(const std::vector<const SlidePicture*>& pictures, double aspect,
                          cv::Size window);

/// Leaves out corners that stand still, and counts those that are left.
void removeStill(SlideTracks& tracks);

} // namespace altiro3D
