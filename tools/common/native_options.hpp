#pragma once

#include "altiro3D/native_maker.hpp"
#include "common/display_options.hpp"
#include "common/quilt_options.hpp"

#include <opencv2/core/types.hpp>
#include <string>

namespace altiro3D::tools {

/// --continuous --best
void addNativeOptions(CommandLine& commandLine);
/// --quick
void addQuickOption(CommandLine& commandLine);
/// Refuses options of Natives that exclude each other; call it before any work.
/// @throws UsageError
void checkNativeOptions(const CommandLine& commandLine);
/// Reads the options of views and sampling, --fit, -k, --best and --continuous.
/// @throws UsageError
NativeOptions nativeOptions(const CommandLine& commandLine);
/// The same for photos, of which more is made: as NativeOptions::showAs(), unless --quick or an
/// option that asks for something else is given.
/// @throws UsageError
NativeOptions photoNativeOptions(const CommandLine& commandLine);

/// Makes the NativeMaker for a display. On the path over a quilt it uses lookUpTable().
/// @param options from nativeOptions(); views and fit may be changed
/// @param preferContinuous as --continuous, unless another option rules it out
/// @throws UsageError, Error
NativeMaker makeNativeMaker(const CommandLine& commandLine, const ChosenDisplay& display,
                            const QuiltLayout& layout, NativeOptions options, Messages& messages,
                            bool preferContinuous = false);

/// The maker's path, for reports. @return "direct" or "quilt"
std::string pathName(const NativeMaker& maker);
/// A key of what the time of a Native depends on besides the picture; usable in a file name.
/// @param photo size of the fitted photo
std::string costKey(const NativeMaker& maker, cv::Size photo);

} // namespace altiro3D::tools
