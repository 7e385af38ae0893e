#pragma once

#include "altiro3D/video_io.hpp"
#include "media/ffmpeg.hpp"
#include "media/yuv_kernels.hpp"

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

/// Conversion between FFmpeg's frames and cv::Mat.
namespace altiro3D {

/// The curve that makes HDR video as bright as other video. Light up to 0.97 of white (203 cd/m²)
/// stays, white becomes 0.985 of itself, and brighter light shares the rest up to 1000 cd/m².
/// @param light in units of white, from 0 @return 0..1
double videoToneMapped(double light);

/// A table from the colours of a video to the primaries of sRGB. PQ and HLG are tone-mapped by
/// videoToneMapped(), applied to the largest of red, green and blue. The system gamma of HLG counts
/// for each of them, as in FFmpeg's zscale. The result has the curve of sRGB. Other video has the
/// gamma 2.4 (BT.1886) and keeps it, so that greys stay as they are.
class ColourTable {
  public:
    /// Keeps colours as they are.
    ColourTable() = default;
    /// @param primaries, transfer codes of H.273
    ColourTable(int primaries, int transfer);

    /// Converts a row. Reads 6 or 8 bytes per px and four entries of the table, which bound the
    /// speed; writes 3.
    /// @param from blue, green, red and perhaps alpha, which composes the px over black
    /// @param channels 3 or 4
    /// @param to blue, green, red
    void row(const std::uint16_t* from, int channels, int columns, std::uint8_t* to) const;

  private:
    /// For each node of B, G and R: its linear light in the primaries of sRGB, which may leave
    /// 0..1. Empty: colours stay.
    std::vector<std::array<float, 3>> nodes_;
    std::vector<float> encoded_; ///< Encoded values, 0..255, by the square root of the light.
};

/// Sets the rotation and mirroring nearest to a display matrix (nine numbers); none if it is null.
void setRotation(VideoFacts& facts, const std::int32_t* displayMatrix);
/// The orientation of the stored pictures for upright().
int orientationOf(const VideoFacts& facts);

/// The colour encoding of a frame or stream. Values that are not stated or unknown to FFmpeg are
/// assumed from the number of rows. The numbers are those of FFmpeg's enumerations.
VideoColour videoColour(AVPixelFormat format, int matrix, int range, int primaries, int transfer,
                        int rows);

/// The colour encoding of what PictureMaker makes, as if it were stored.
VideoColour shownColour(const VideoColour& stored);

AVColorSpace colourSpace(ColourMatrix matrix);
AVColorRange colourRange(ColourRange range);

/// Converts decoded frames to upright pictures: sRGB, with transparent parts over black.
class PictureMaker {
  public:
    /// @param orientation see orientationOf() @param isDepth see VideoReaderOptions::isDepth
    /// @param subject name of the video, for errors
    PictureMaker(int orientation, bool isDepth, int threads, std::string subject);

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

    int orientation_;
    bool isDepth_;
    int threads_;
    std::string subject_;
    ScalerPtr scaler_;
    cv::Size size_; // size of the frames that the scaler was made for
    int rows_ = 0;  // rows of the first frame, which decide about colours that are not stated
    int format_ = AV_PIX_FMT_NONE;
    int chromaLocation_ = AVCHROMA_LOC_UNSPECIFIED;
    VideoColour colour_;
    Way way_ = Way::Direct;
    BgrWeights weights_;
    FramePtr planes_;
    ColourTable table_;
    cv::Mat deep_;  // [CV_16UC3 or CV_16UC4]
    cv::Mat mixed_; // for Direct with alpha [CV_8UC4]
    bool hasAlpha_ = false;
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
