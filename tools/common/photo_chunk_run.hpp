#pragma once

#include "common/command_line.hpp"
#include "common/run_tool.hpp"

#include <functional>
#include <string>
#include <vector>

/// photo2native for many machines, see chunk_folder.hpp and photo_chunk_plan.hpp.
namespace altiro3D::tools {

/// Adds the options of the plan, of its chunks and of the join.
void addPhotoChunkOptions(CommandLine& commandLine);

/// Whether a command line plans a run, makes a chunk or joins. @throws UsageError
bool isForPhotoChunks(const CommandLine& commandLine);

/// Plans a run, makes a chunk or joins the chunks, as the command line says.
/// @param arguments the command line's words, the program's name first
/// @param addOptions adds all options of the tool to another command line, which reads the words of
///        the plan
/// @return the exit status; that of a join is the one of a run on one machine
/// @throws UsageError, Error
int runPhotoChunks(const CommandLine& commandLine, const std::vector<std::string>& arguments,
                   const std::function<void(CommandLine&)>& addOptions, Messages& messages);

} // namespace altiro3D::tools
