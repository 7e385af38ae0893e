#pragma once

#include "altiro3D/depth_source.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/video_depth.hpp"
#include "altiro3D/video_reader.hpp"
#include "altiro3D/video_types.hpp"

#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace altiro3D {

/// What a video becomes.
enum class VideoProduct {
    Native, ///< A Native video for the display.
    Quilt,  ///< A video of quilts for other players, 4:2:0 where the codec allows it.
    Rgbd    ///< Frame and depth side by side for other players, 4:2:0 where the codec allows it.
};

/// What is done about an earlier run of the same output that has not ended.
enum class UnfinishedRun {
    Refuse, ///< It is an error.
    Resume, ///< The run goes on where it ended; without one a new run begins.
    Discard ///< It is removed, and a new run begins.
};

/// Depth that comes with a video. At most one of `source` and `side` is set.
struct GivenVideoDepth {
    /// A video, or a directory with one depth picture per frame in the order of their names.
    std::filesystem::path source;
    std::optional<DepthSide> side;         ///< Each frame is an RGB-D picture: where its depth is.
    DepthKind kind = DepthKind::NearWhite; ///< Meaning of the numbers.
    /// Reads a picture of the directory as readDepthSamples() does, which is used if it is empty.
    std::function<cv::Mat(const std::filesystem::path& file, Notes* notes)> read;
};

/// How a video is converted. Input, output and display are enough.
struct VideoConversion {
    std::filesystem::path input; ///< As for VideoReader.
    VideoReaderOptions part;     ///< The part of the input that is converted, as for VideoReader.
    /// The input if it is open already, without a frame read from it; may be null. A device and
    /// the standard input can be opened only once.
    std::unique_ptr<VideoReader> reader;
    std::filesystem::path output; ///< .mkv, .mp4, .m4v or .mov; empty: `show` takes the pictures.
    /// Takes each picture [size() of the converter, CV_8UC3, BGR] when it is due, in the thread of
    /// run(). Frames that are late are left out. False ends the run.
    std::function<bool(const cv::Mat& picture)> show;

    VideoProduct product = VideoProduct::Native; ///< What the video becomes.
    /// What Natives and quilts are made for. Not needed for Rgbd and beside `map`.
    std::optional<Display> display;
    std::optional<NativeLut> map; ///< Look-up table through which Natives are made.
    /// Layout of the quilts; nothing: that of `map`, else the display's.
    std::optional<QuiltLayout> layout;
    NativeOptions native; ///< Method, knobs and fit. Frames that are quilts need the fit only.

    bool fromQuilt = false; ///< Frames are quilts; product is Native.
    /// Of frames that are quilts: width : height of what a view shows, 0.01..100; 0: the panel's.
    double viewAspect = 0;

    /// Estimates the depth; null: depthFromCues(). Not used with `given` depth and for quilts.
    std::unique_ptr<DepthSource> depth;
    VideoDepthOptions depthOptions;       ///< How often depth is estimated and how steady it is.
    std::optional<GivenVideoDepth> given; ///< Depth that need not be estimated.

    VideoWriterOptions encoding; ///< Size, times and `compatible` of quilts and RGB-D are set here.
    UnfinishedRun unfinished = UnfinishedRun::Refuse; ///< Of an output whose input is a file.
    /// Texts of the caller's own settings, as a JSON object: they are compared when a run is
    /// resumed, before those of this structure, and named in the error.
    std::string settings = "{}";
    bool threads = true; ///< See PipelineOptions::threads.
};

} // namespace altiro3D
