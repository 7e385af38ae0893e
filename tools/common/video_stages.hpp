#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/native_renderer.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt2native.hpp"
#include "altiro3D/video_depth.hpp"
#include "altiro3D/video_pipeline.hpp"
#include "common/depth_options.hpp"
#include "common/given_depth.hpp"
#include "common/native_options.hpp"

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

/// What is done with every frame of a video between reading and writing.
namespace altiro3D::tools {

/// What a video becomes.
enum class VideoProduct { Native, Quilt, Rgbd };

/// Makes the depth of frames: estimated and kept steady, or as it was given.
class DepthStage {
  public:
    /// @param given depth video or directory, or empty
    /// @throws Error
    DepthStage(const std::filesystem::path& given, const VideoReaderOptions& part,
               const VideoFacts& facts, ChosenDepth source, const VideoDepthOptions& options);
    DepthStage(const DepthStage&) = delete;
    DepthStage& operator=(const DepthStage&) = delete;

    /// Called before the first frame of the video is read. @throws Error
    void begin(VideoReader& video);

    /// Reads `source`, sets `depth` and `step`; of an RGB-D frame the photo stays in `source`.
    void work(PipelineFrame& frame);

    /// What the next frame's depth hangs on, for a run that goes on from here.
    std::string state() const;
    /// @throws Error BadFormat
    void setState(const std::string& state);
    VideoDepth& depth() { return *depth_; }
    const ChosenDepth& source() const { return source_; }
    const VideoDepthOptions& options() const { return options_; }
    /// Size of the photos in frames of a size, and shape of what they show.
    cv::Size photoSize(cv::Size frame) const;
    double photoAspect(double frameAspect) const;
    /// What was remarkable, for people.
    void tell(Messages& messages) const;

  private:
    void start();
    void useGiven(PipelineFrame& frame);

    ChosenDepth source_;
    VideoDepthOptions options_;
    double unit_; // s
    std::optional<GivenDepth> given_;
    cv::Mat raw_; // given
    cv::Mat lastRaw_;
    cv::Mat lastPhoto_;
    std::string kept_; // digests of both, where an earlier run had them; empty: see above
    std::optional<VideoDepth> depth_; // keeps a pointer to this
};

/// Makes what is written of frames with depth.
class RenderStage {
  public:
    /// How the frames are rendered.
    struct Settings {
        QuiltLayout layout;
        ViewOptions views;
        VideoProduct product = VideoProduct::Native;
        FitMode fit = FitMode::Cover;
        bool keep = false;       ///< at the panel's resolution
        bool continuous = false; ///< cameras anywhere, where nothing stands against it
    };

    /// @param photo size of the photos @param seenAspect width : height of what they show
    /// @throws UsageError, Error
    RenderStage(const CommandLine& commandLine, const ChosenDisplay& display,
                const Settings& settings, cv::Size photo, double seenAspect, Messages& messages);

    /// Size of what is written.
    cv::Size size() const { return size_; }
    std::string pathName() const { return maker_ ? tools::pathName(*maker_) : "quilt"; }
    bool continuous() const {
        return maker_ && maker_->options().positions == ViewPositions::Continuous;
    }

    /// Reads `source` and `depth`, sets the picture of `result`.
    void work(PipelineFrame& frame);

  private:
    void fitFrame(const PipelineFrame& frame, const PhotoFit& fit);

    Settings settings_;
    double panelAspect_;
    double seenAspect_;
    cv::Size workSize_;
    cv::Size size_;
    std::optional<NativeMaker> maker_;
    std::optional<Depth2Quilt> quilter_;
    Scene fitted_;
    cv::Mat quilt_;
    cv::Mat last_;
};

/// Makes Natives of frames that are quilts.
class QuiltStage {
  public:
    /// @throws UsageError, Error
    QuiltStage(const CommandLine& commandLine, const ChosenDisplay& display,
               const QuiltLayout& layout, const QuiltShape& shape, Messages& messages);

    /// Reads `source`, sets the picture of `result`.
    void work(PipelineFrame& frame);
    /// What was remarkable, for people.
    void tell(Messages& messages) const { messages.warn(notes_); }

  private:
    QuiltShape shape_;
    Quilt2Native renderer_;
    Notes notes_;
    cv::Mat last_;
    cv::Mat lastQuilt_;
};

} // namespace altiro3D::tools
