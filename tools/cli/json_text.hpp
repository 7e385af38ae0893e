#pragma once

#include "cli/command_line.hpp"

#include <nlohmann/json_fwd.hpp>
#include <string>

/// JSON that the tools write for programs. docs/report.schema.json describes reports and progress.
namespace altiro3D::tools {

/// The text of a JSON value. Numbers have six significant digits, and at least three decimals if
/// they are not whole: 0.208, not 0.20800000000000002. Bytes that are not UTF-8 are replaced.
/// @param indent as for json::dump(); -1: one line
std::string jsonText(nlohmann::ordered_json value, int indent = -1);

/// --progress
void addProgressOption(CommandLine& commandLine);
/// True for `--progress json`. @throws UsageError
bool wantsJsonProgress(const CommandLine& commandLine);
/// Writes a line of `--progress json` to standard output.
void writeProgress(const nlohmann::ordered_json& line);
/// Writes a line about a failure that came before all others, if `--progress json` is given.
void tellEarlyFailure(const CommandLine& commandLine, const std::exception& error);

} // namespace altiro3D::tools
