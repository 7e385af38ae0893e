#pragma once

#include "altiro3D/camera.hpp"
#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/placement.hpp"
#include "altiro3D/quilt2native.hpp"
#include "common/run_tool.hpp"

#include <optional>
#include <string>

namespace altiro3D::tools {

/// Whether --fit, --focus and --strength take "auto".
enum class AutoUse {
    None,
    Named,  ///< see autoChoices()
    Default ///< also without the options, see photoChoices()
};

/// --strength --focus
void addSceneOptions(CommandLine& commandLine, AutoUse use);
/// --exact-depth
void addRefineOption(CommandLine& commandLine);
DepthRefineOptions refineOptions(const CommandLine& commandLine);
/// --method -g --strength --focus --exact-depth -k, and the options of the methods
void addViewOptions(CommandLine& commandLine, AutoUse use);
/// Which of --fit, --focus and --strength are "auto".
AutoChoices autoChoices(const CommandLine& commandLine);
/// The same for AutoUse::Default: without the options, framing and focus are chosen and the
/// strength is limited.
AutoChoices photoChoices(const CommandLine& commandLine);
/// What the choices that are not asked for are, and the options that make none; empty without them.
std::string fixedWayText(const CommandLine& commandLine, const AutoChoices& choices);
/// "focus 0.72, strength 8.4 %": what was chosen
std::string autoText(const AutoChoices& choices, const Framing& framing, const ViewOptions& views);
/// What is "auto" has its default value. @throws UsageError
ViewOptions viewOptions(const CommandLine& commandLine);
/// "fast", "real" or "layered"
std::string methodName(ViewMethod method);

/// Refuses options of methods that are not used, unless they have their default values.
/// @throws UsageError
void requireKnobsOf(const CommandLine& commandLine, ViewMethod method);

/// --camera: the camera of method Real.
class CameraOptions {
  public:
    static void add(CommandLine& commandLine);
    /// @throws UsageError, Error (camera file)
    explicit CameraOptions(const CommandLine& commandLine);

    /// Options for one photo. With `--camera`, the strength follows from the camera.
    ///
    /// @param options options from the command line
    /// @param photoFile the photo, whose EXIF may state the focal length
    /// @param fit how the photo is fitted
    ViewOptions apply(const ViewOptions& options, const std::filesystem::path& photoFile,
                      cv::Size photoSize, const PhotoFit& fit, Messages& messages) const;
    /// The strength that the camera file states.
    std::optional<double> strength(const ViewOptions& options, const PhotoFit& fit) const;

  private:
    Camera fittedCamera(const PhotoFit& fit) const;

    std::optional<Camera> camera_;
    std::string source_;
};

/// --fit
void addFitOption(CommandLine& commandLine, const std::string& standard);
/// @throws UsageError
std::optional<FitMode> fitOption(const CommandLine& commandLine);
/// @param standard result if the option is not given @throws UsageError
FitMode fitOption(const CommandLine& commandLine, FitMode standard);
/// --center --zoom
void addFramingOptions(CommandLine& commandLine);
/// --fit with auto, --center and --zoom
void addPhotoFitOptions(CommandLine& commandLine, AutoUse use);
/// The fit of addPhotoFitOptions(); auto is Cover. @throws UsageError
FitMode photoFitOption(const CommandLine& commandLine);
/// @throws UsageError (also if --center has no effect with this fit)
Framing framingOption(const CommandLine& commandLine, FitMode fit);
/// "cover", "contain" or "stretch"
std::string fitName(FitMode mode);

/// A sentence such as "40 % of the width is cut off" if a picture fills a panel of a very different
/// shape; empty if little is cut off.
/// @param seenAspect width : height of the picture as shown @param panelAspect that of the panel
std::string cutText(double seenAspect, double panelAspect, FitMode mode);
/// Reports cutText(), unless it is empty, and how to see another part.
void tellCut(double seenAspect, double panelAspect, const NativeOptions& options,
             const Messages& messages);

/// Warns if the parallax between adjacent views is so large that edges appear double.
void warnAboutParallax(const CommandLine& commandLine, const AdjacentParallax& parallax,
                       Messages& messages);

/// Warns if the file format does not preserve a Native's sub-pixels.
void warnAboutNativeFormat(const std::filesystem::path& file, Messages& messages);

/// Warns if the file format stores a depth map with less precision than another one would.
void warnAboutDepthFormat(const std::filesystem::path& file, Messages& messages);

/// Renders a quilt and writes the Native; stages "render" and "write".
void makeNativeFile(const Quilt2Native& renderer, const cv::Mat& quilt,
                    const std::filesystem::path& output, Messages& messages, StageTimes& times);

/// Warns if the name of a photo or video says that it is a quilt.
/// @param instead the tool or option that reads quilts
void warnIfQuilt(const std::filesystem::path& file, const std::string& instead, Messages& messages);

/// Refuses a Native where another picture is expected; usually the names are in the wrong order.
/// @param expected "a photo" @throws Error BadFormat
void refuseNative(const std::filesystem::path& file, const std::string& expected);

/// Reads a photo or quilt; remarks about the file become warnings.
cv::Mat readPhotoFile(const std::filesystem::path& file, Messages& messages);

} // namespace altiro3D::tools
