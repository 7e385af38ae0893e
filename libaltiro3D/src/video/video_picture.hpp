#pragma once

#include "altiro3D/video_types.hpp"
#include "video/ffmpeg.hpp"
#include "video/yuv_kernels.hpp"

#include <opencv2/core.hpp>
#include <string>
#include <vector>

/// Between FFmpeg's frames and cv::Mat.
namespace altiro3D {

/// How stored pictures are brought upright: transposed first, then mirrored.
struct Orientation {
    bool transpose = false;
    bool mirrorColumns = false; ///< left to right
    bool mirrorRows = false;    ///< top to bottom

    bool isIdentity() const { return !transpose && !mirrorColumns && !mirrorRows; }
    /// The same as a clockwise turn by 0, 90, 180 or 270 degrees ...
    int clockwiseDegrees() const;
    /// ... and a mirroring left to right after it.
    bool isMirrored() const { return transpose != (mirrorColumns != mirrorRows); }
};

/// The nearest orientation of a display matrix (nine numbers); upright if it is null.
Orientation orientationOf(const std::int32_t* displayMatrix);

/// The colours of a frame or stream; what is not stated, or with a number that FFmpeg does not
/// know, is assumed from the number of rows. The numbers are those of FFmpeg's enumerations.
VideoColour videoColour(AVPixelFormat format, int matrix, int range, int primaries, int transfer,
                        int rows);

AVColorSpace colourSpace(ColourMatrix matrix);
AVColorRange colourRange(ColourRange range);

/// Turns decoded frames into upright BGR pictures.
class PictureMaker {
  public:
    /// @param stored size of the pictures before they are turned; frames of another are scaled
    /// @param subject the video, for errors
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
    cv::Size size_; // of the frames the scaler is for
    int format_ = AV_PIX_FMT_NONE;
    int chromaLocation_ = AVCHROMA_LOC_UNSPECIFIED;
    VideoColour colour_;
    // Y, U and V at full size come first where the frame has them: swscale's own way to BGR takes
    // four times as long.
    bool byPlanes_ = false;
    BgrWeights weights_;
    FramePtr planes_;
    cv::Mat unturned_;
};

/// Turns BGR pictures into frames of an encoder.
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
    std::vector<FramePtr> frames_; // used again when the encoder has let them go
};

} // namespace altiro3D
