#pragma once

#include "altiro3D/print_sheet.hpp"
#include "cli/display_options.hpp"

#include <optional>

namespace altiro3D::tools {

/// --print --bleed --no-marks --print-text
void addPrintOptions(CommandLine& commandLine);
/// What is around a print; nothing without --print. @throws UsageError
std::optional<PrintOptions> printOptions(const CommandLine& commandLine);

/// The sheet of a run with --print. The display becomes that of the sheet, with its bleed.
/// @throws UsageError (not the calibration of a print), Error
std::optional<PrintSheet> printSheet(const std::optional<PrintOptions>& options,
                                     ChosenDisplay& display, Messages& messages);

/// Refuses the name of a Native that cannot be written. @param isPrint as of --print
/// @throws UsageError
void requireNativeName(const std::filesystem::path& file, bool isPrint);

/// "12 x 34 px, 300.0 x 200.0 mm, cut to ..."
std::string printText(const PrintSheet& sheet);

} // namespace altiro3D::tools
