#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/placement.hpp"
#include "altiro3D/quilt2native.hpp"
#include "altiro3D/recipe.hpp"
#include "cli/quilt_options.hpp"

#include <filesystem>
#include <optional>
#include <string>

namespace altiro3D::tools {

/// Whether --fit, --focus and --strength take "auto".
enum class AutoUse {
    None,
    Named,
    Photos ///< Also without the options. More is made of photos, see sceneOptions().
};

/// Adds the option of a field of a recipe.
/// @param use decides what the help says about "auto"
void addField(CommandLine& commandLine, const std::string& name, AutoUse use = AutoUse::None);
/// Adds the options of all fields of a part; those of views with -g and -k.
void addFields(CommandLine& commandLine, RecipePart part, AutoUse use);
/// --continuous
void addNativeOptions(CommandLine& commandLine);
/// --quick
void addQuickOption(CommandLine& commandLine);

/// How scenes are shown. Without options, a photo is shown by showAs(Detail::Lens), its framing and
/// focus are chosen, and its strength is limited; a frame of a video has the recipe's defaults.
struct SceneOptions {
    Recipe recipe;
    AutoChoices unasked;           ///< The choices of the recipe that no option asks for.
    bool mustBeContinuous = false; ///< --continuous: fails if it is not possible.
};
/// Reads the options that are fields of a recipe.
/// @throws UsageError that names option, value and what was expected
void readFields(const CommandLine& commandLine, Recipe& recipe);
/// Reads the options of views and sampling, --fit, --center, --zoom, -k and --continuous.
/// @param use Photos: they are shown as by NativeOptions::showAs(Detail::Lens), unless --quick or
///        an option for another way to show them is given; framing and focus are chosen and the
///        strength is limited, unless options state them
/// @param standard the method without --method
/// @throws UsageError, also for an option of another method that does not have its default value
SceneOptions sceneOptions(const CommandLine& commandLine, AutoUse use,
                          ViewMethod standard = ViewOptions().method);
/// Makes the NativeMaker for a display, with the map of `-m` if there is one.
/// @param preferContinuous as --continuous, unless another option rules it out
/// @throws UsageError, Error
NativeMaker makeNativeMaker(const SceneOptions& asked, const ChosenDisplay& display,
                            const QuiltLayout& layout, Messages& messages,
                            bool preferContinuous = false);
/// The name of the path of a maker: "direct" or "quilt".
std::string pathName(const NativeMaker& maker);
/// Tells what is chosen although no option asks for it, and the options that turn this off; empty
/// if there is nothing to tell.
std::string unaskedText(const AutoChoices& unasked);
/// "focus 0.72, strength 8.4 %": what was chosen
std::string autoText(const AutoChoices& choices, const Framing& framing, const ViewOptions& views);
std::string methodName(ViewMethod method);

/// --camera: the camera of method Real.
class CameraOptions {
  public:
    static void add(CommandLine& commandLine);
    CameraOptions() = default;
    /// @param method that is used @throws UsageError, Error (camera file)
    CameraOptions(const CommandLine& commandLine, ViewMethod method);

    const std::filesystem::path& file() const { return file_; } ///< Empty: none.
    /// Options for one photo. With `--camera`, the strength follows from the camera.
    ///
    /// @param options options from the command line
    /// @param fit how the photo is fitted
    ViewOptions apply(ViewOptions options, const PhotoFit& fit, Messages& messages) const;
    /// The strength that the camera file states.
    std::optional<double> strength(const PhotoFit& fit) const;

  private:
    Camera fittedCamera(const PhotoFit& fit) const;

    std::optional<Camera> camera_;
    std::filesystem::path file_;
};

/// --fit
void addFitOption(CommandLine& commandLine, const std::string& standard);
/// @throws UsageError
std::optional<FitMode> fitOption(const CommandLine& commandLine);
std::string fitName(FitMode mode);

/// A sentence such as "40 % of the width is cut off" if a picture fills a panel of a very different
/// shape; empty if little is cut off.
/// @param seenAspect width : height of the picture as shown @param panelAspect that of the panel
std::string cutText(double seenAspect, double panelAspect, FitMode mode);
/// Reports cutText(), unless it is empty, and how to see another part.
void tellCut(double seenAspect, double panelAspect, const NativeOptions& options,
             const Messages& messages);

/// Warns if the parallax between adjacent views is so large that edges appear double.
/// @param remedy what makes it less, besides --focus
void warnAboutParallax(const AdjacentParallax& parallax, Messages& messages,
                       const std::string& remedy = "--strength");

} // namespace altiro3D::tools
