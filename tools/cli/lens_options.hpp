#pragma once

#include "altiro3D/lens_sheet.hpp"
#include "cli/run_tool.hpp"

#include <string>

namespace altiro3D::tools {

/// --lens
void addLensOption(CommandLine& commandLine);
/// The calibration by its numbers. @throws UsageError, Error
Calibration lensOption(const CommandLine& commandLine);

/// The numbers of a lens in sub-pixels, and the order of views. @param calibration with a lens
std::string subpixelLensText(const Calibration& calibration);
/// "print of 100 x 150 mm, 60 LPI". @param calibration with a sheet
std::string sheetText(const Calibration& calibration);
/// What --info says of a print or a screen without a maker.
void tellSheet(const Calibration& calibration, const Messages& messages);

} // namespace altiro3D::tools
