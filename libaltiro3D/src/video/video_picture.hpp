#pragma once

#include "altiro3D/video_io.hpp"
#include "video/ffmpeg.hpp"
#include "video/yuv_kernels.hpp"

#include <opencv2/core.hpp>
#include <string>
#include <vector>

/// Conversion between FFmpeg's frames and cv::Mat.
namespace altiro3D {

/// Transformation of stored pictures to upright ones: transposed first, then mirrored.
struct Orientation {
    bool transpose = false;
    bool mirrorColumns = false; ///< left to right
    bool mirrorRows = false;    ///< top to bottom

    bool isIdentity() const { return !transpose && !mirrorColumns && !mirrorRows; }
    /// The equivalent clockwise rotation by 0, 90, 180 or 270 degrees; isMirrored() follows it.
    int clockwiseDegrees() const;
    /// Whether a left-right mirroring follows the rotation.
    bool isMirrored() const { return transpose != (mirrorColumns != mirrorRows); }
};

/// The orientation nearest to a display matrix (nine numbers); upright if it is null.
Orientation orientationOf(const std::int32_t* displayMatrix);

/// The colour encoding of a frame or stream. Values that are not stated or unknown to FFmpeg are
/// assumed from the number of rows. The numbers are those of FFmpeg's enumerations.
VideoColour videoColour(AVPixelFormat format, int matrix, int range, int primaries, int transfer,
                        int rows);

AVColorSpace colourSpace(ColourMatrix matrix);
AVColorRange colourRange(ColourRange range);

/// Converts decoded frames to upright BGR pictures.
class PictureMaker {
  public:
    /// @param stored size of the pictures before rotation; frames of another size are scaled
    /// @param subject name of the video, for errors
    PictureMaker(cv::Size stored, const Orientation& orientation, int threads, std::string subject);

    /// @param frame any software format
    /// @param picture [rows x cols, CV_8UC3, BGR]
    /// @throws Error Unsupported, OutOfMemory
    void make(const AVFrame& frame, cv::Mat& picture);

  private:
    void prepare(const AVFrame& frame);
    void convert(const AVFrame& frame, cv::Mat& picture);

    cv::Size stored_;
    Orientation orientation_;
    int threads_;
    std::string subject_;
    ScalerPtr scaler_;
    cv::Size size_; // frame size that the scaler was made for
    int format_ = AV_PIX_FMT_NONE;
    int chromaLocation_ = AVCHROMA_LOC_UNSPECIFIED;
    VideoColour colour_;
    // YUV frames are first converted to full-size planes; swscale's direct conversion to BGR takes
    // four times as long.
    bool byPlanes_ = false;
    BgrWeights weights_;
    FramePtr planes_;
    cv::Mat unturned_;
};

/// Converts BGR pictures to frames for an encoder.
class FrameMaker {
  public:
    /// @param format YUV444P, YUV444P10, YUV420P, BGR24 or BGR0
    FrameMaker(AVPixelFormat format, cv::Size size, ColourMatrix matrix, ColourRange range,
               int threads);

    /// @param picture [rows x cols, CV_8UC3, BGR]
    /// @return valid until the next call; encoders may keep references
    AVFrame& make(const cv::Mat& picture);

  private:
    AVFrame& freeFrame();

    AVPixelFormat format_;
    cv::Size size_;
    int threads_;
    YuvWeights weights_;
    ScalerPtr scaler_;
    std::vector<FramePtr> frames_; // reused after the encoder has released them
};

} // namespace altiro3D
