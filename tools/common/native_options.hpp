#pragma once

#include "altiro3D/native_maker.hpp"
#include "common/display_options.hpp"

#include <opencv2/core/types.hpp>
#include <string>

namespace altiro3D::tools {

/// --continuous --best
void addNativeOptions(CommandLine& commandLine);
/// Refuses options of Natives that do not go together; to be called before any work.
/// @throws UsageError
void checkNativeOptions(const CommandLine& commandLine);
/// What the options say: those of views, --fit, -k, --best, --continuous and of sampling.
/// @throws UsageError
NativeOptions nativeOptions(const CommandLine& commandLine);

/// The maker for a display, over a quilt through the table of `-m` or of the user's cache.
/// @param options from nativeOptions(), perhaps with other views and fit
/// @param preferContinuous as --continuous, but only where no option stands against it
/// @throws UsageError, Error
NativeMaker makeNativeMaker(const CommandLine& commandLine, const ChosenDisplay& display,
                            const QuiltLayout& layout, NativeOptions options, Messages& messages,
                            bool preferContinuous = false);

/// For reports. @return "direct" or "quilt"
std::string pathName(const NativeMaker& maker);
/// What the time of a Native depends on besides the picture: fit for a file name.
/// @param photo size of the fitted photo
std::string costKey(const NativeMaker& maker, cv::Size photo);

} // namespace altiro3D::tools
