#pragma once

#include "altiro3D/video_io.hpp"
#include "media/colour_table.hpp"
#include "media/ffmpeg.hpp"
#include "media/yuv_kernels.hpp"

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

/// Whether pictures are converted to sRGB: of wide gamut, HDR or linear light.
bool isConverted(const VideoColour& stored);
/// Whether the transfer curve is PQ or HLG.
bool isHdr(const VideoColour& stored);
/// The colour encoding of what PictureMaker makes, as if it were stored.
VideoColour shownColour(const VideoColour& stored);

AVColorSpace colourSpace(ColourMatrix matrix);
AVColorRange colourRange(ColourRange range);

/// Converts decoded frames to upright pictures: sRGB, with transparent parts over black.
class PictureMaker {
  public:
    /// @param isDepth see VideoReaderOptions::isDepth
    /// @param subject name of the video, for errors
    PictureMaker(const Orientation& orientation, bool isDepth, int threads, std::string subject);

    /// @param frame any software format
    /// @param picture [size of the frame, turned; CV_8UC3, BGR; of depth also CV_16UC1]
    /// @throws Error Unsupported, OutOfMemory
    void make(const AVFrame& frame, cv::Mat& picture);

    /// The transfer curve of the last frame that was HDR, or 0.
    int hdrTransfer() const { return hdrTransfer_; }

  private:
    // How frames become pictures.
    enum class Way {
        Direct, // by the scaler
        Planes, // by the scaler to planes of full size; its direct conversion takes four times as
                // long
        Deep,   // by the scaler to 16 bits, then by the table of colours and alpha
        Grey    // by the scaler to 16 bits
    };

    void prepare(const AVFrame& frame);
    void convert(const AVFrame& frame, cv::Mat& picture);
    void scale(const AVFrame& frame, AVFrame& to);

    Orientation orientation_;
    bool isDepth_;
    int threads_;
    std::string subject_;
    ScalerPtr scaler_;
    cv::Size size_; // of the frames that the scaler was made for
    int rows_ = 0;  // of the first frame, which decides about colours that are not stated
    int format_ = AV_PIX_FMT_NONE;
    int chromaLocation_ = AVCHROMA_LOC_UNSPECIFIED;
    VideoColour colour_;
    Way way_ = Way::Direct;
    BgrWeights weights_;
    FramePtr planes_;
    ColourTable table_;
    cv::Mat deep_; // [CV_16UC3 or CV_16UC4]
    cv::Mat unturned_;
    int hdrTransfer_ = 0;
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
