#pragma once

#include "altiro3D/video_conversion.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

namespace altiro3D {

/// Measures GivenVideoDepth::range, if it is needed and the source can be read again: for depth of
/// 16 bits.
/// @throws Error
void measureRange(GivenVideoDepth& given);

/// Given depth of a video: another video, or a directory with one picture per frame.
class GivenDepth {
  public:
    /// @param given its `source` is a video or a directory
    /// @param part which part of the video is read
    /// @param video the video that the depth belongs to
    /// @throws Error Mismatch (its shape fits only if it is turned), and others
    GivenDepth(const GivenVideoDepth& given, const VideoReaderOptions& part,
               const VideoFacts& video);

    /// Finds the depth of the part's first frame; call it before that frame is read.
    /// @param video the video that the depth belongs to
    /// @throws Error
    void begin(VideoReader& video);

    /// The raw depth of a frame.
    ///
    /// @param time when the frame is shown, s from the beginning of the part
    /// @param number of the frame, from 0 in the part
    /// @param raw [any size, CV_8UC1, CV_16UC1 or CV_32FC1]
    /// @throws Error
    void read(double time, std::int64_t number, cv::Mat& raw);

    /// Remarks, for people.
    Notes notes() const;

  private:
    void fitShape(cv::Size depth, double sampleAspect, const VideoFacts& video);
    void turn(cv::Mat& raw) const;
    void requireRange(const cv::Mat& raw) const;
    void refuseUnusedRange(const cv::Mat& first) const;
    void readImage(std::int64_t number, cv::Mat& raw);
    void readFrame(double time, cv::Mat& raw);
    void addNotes(const std::string& name, const Notes& notes);

    GivenVideoDepth given_;
    std::vector<std::filesystem::path> pictures_;
    std::int64_t firstPicture_ = 0;
    Notes notes_;
    int rotationDegrees_ = 0; // of the video, which the depth lacks
    bool mirrored_ = false;
    std::optional<VideoReader> video_;
    double unit_ = 1; // s
    VideoFrame frame_;
    VideoFrame ahead_;
    bool hasAhead_ = false;
    bool isFirst_ = true; // no frame was read as grey
    double missing_ = 0;  // s or frames beyond the end
};

} // namespace altiro3D
