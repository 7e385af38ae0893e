#pragma once

#include "common/command_line.hpp"
#include "common/run_tool.hpp"

#include <functional>
#include <string>
#include <vector>

/// video2native for many machines: a folder holds the plan of one run, and its chunks.
///
/// Besides the files of the library, the folder holds `arguments` (the working directory and the
/// command line of the plan, each followed by a zero byte), `visual.json` (a copy of the
/// calibration, if the command line names none) and `logs`.
namespace altiro3D::tools {

/// Adds the options of the plan, of its chunks and of the join.
void addChunkOptions(CommandLine& commandLine);

/// Whether a command line plans a run, makes a chunk or joins.
bool isForChunks(const CommandLine& commandLine);

/// Plans a run, makes a chunk or joins the chunks, as the command line says.
/// @param arguments the command line's words, the program's name first
/// @param addOptions adds all options of the tool to another command line, which reads the words of
///        the plan
/// @return the exit status
/// @throws UsageError, Error
int runChunks(const CommandLine& commandLine, const std::vector<std::string>& arguments,
              const std::function<void(CommandLine&)>& addOptions, Messages& messages);

} // namespace altiro3D::tools
