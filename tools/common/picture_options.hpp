#pragma once

#include "altiro3D/camera.hpp"
#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt2native.hpp"
#include "common/run_tool.hpp"

#include <optional>
#include <string>

namespace altiro3D::tools {

/// --strength --focus
void addSceneOptions(CommandLine& commandLine);
/// --exact-depth
void addRefineOption(CommandLine& commandLine);
DepthRefineOptions refineOptions(const CommandLine& commandLine);
/// --method -g --strength --focus --exact-depth -k, and the options of the methods
void addViewOptions(CommandLine& commandLine);
/// @throws UsageError
ViewOptions viewOptions(const CommandLine& commandLine);
/// "fast", "real" or "layered"
std::string methodName(ViewMethod method);

/// Refuses knobs of methods that are not used, unless they stand where they stand anyway.
/// @throws UsageError
void requireKnobsOf(const CommandLine& commandLine, ViewMethod method);

/// --camera: the camera of method Real.
class CameraOptions {
  public:
    static void add(CommandLine& commandLine);
    /// @throws UsageError, Error (camera file)
    explicit CameraOptions(const CommandLine& commandLine);

    /// Options for one photo: with `--camera` the file's camera gives the strength.
    ///
    /// @param options of the command line
    /// @param photoFile the photo, whose EXIF may know the focal length
    /// @param fit how the photo is fitted
    ViewOptions apply(const ViewOptions& options, const std::filesystem::path& photoFile,
                      cv::Size photoSize, const PhotoFit& fit, Messages& messages) const;

  private:
    std::optional<Camera> camera_;
    std::string source_;
};

/// --fit
void addFitOption(CommandLine& commandLine, const std::string& standard);
/// @throws UsageError
std::optional<FitMode> fitOption(const CommandLine& commandLine);
/// @param standard used where the option is not given @throws UsageError
FitMode fitOption(const CommandLine& commandLine, FitMode standard);
/// "cover", "contain" or "stretch"
std::string fitName(FitMode mode);

/// How much is cut off where a picture fills a panel of quite another shape, as "40 % of the width
/// is cut off"; empty where it is little.
/// @param seenAspect width : height of what the picture shows @param panelAspect the panel's
std::string cutText(double seenAspect, double panelAspect, FitMode mode);
/// Says it.
void tellCut(double seenAspect, double panelAspect, FitMode mode, const Messages& messages);

/// Warns where neighbouring views lie so far apart that edges show double.
void warnAboutParallax(const CommandLine& commandLine, const AdjacentParallax& parallax,
                       Messages& messages);

/// Warns where a Native loses its sub-pixels on the way to the file.
void warnAboutNativeFormat(const std::filesystem::path& file, Messages& messages);

/// Warns where a depth map is less in the file than it could be.
void warnAboutDepthFormat(const std::filesystem::path& file, Messages& messages);

/// Renders a quilt and writes the Native; stages "render" and "write".
void makeNativeFile(const Quilt2Native& renderer, const cv::Mat& quilt,
                    const std::filesystem::path& output, Messages& messages, StageTimes& times);

/// Warns of a photo or clip whose name says that it is a quilt.
/// @param instead what takes quilts: a tool or an option
void warnIfQuilt(const std::filesystem::path& file, const std::string& instead, Messages& messages);

/// Refuses a Native where another picture is expected: names in the wrong order, mostly.
/// @param expected "a photo" @throws Error BadFormat
void refuseNative(const std::filesystem::path& file, const std::string& expected);

/// Reads a photo or quilt; remarks about the file become warnings.
cv::Mat readPhotoFile(const std::filesystem::path& file, Messages& messages);

} // namespace altiro3D::tools
