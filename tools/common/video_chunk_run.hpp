#pragma once

#include "common/command_line.hpp"
#include "common/run_tool.hpp"

#include <functional>
#include <string>
#include <vector>

/// video2native for many machines, see chunk_folder.hpp and altiro3D/video_chunks.hpp. The folder
/// also holds `joined`, the size and time of the output that the join wrote.
namespace altiro3D::tools {

/// Adds the options of the plan, of its chunks and of the join.
void addVideoChunkOptions(CommandLine& commandLine);

/// Whether a command line plans a run, makes a chunk or joins.
bool isForVideoChunks(const CommandLine& commandLine);

/// Plans a run, makes a chunk or joins the chunks, as the command line says.
/// @param arguments the command line's words, the program's name first
/// @param addOptions adds all options of the tool to another command line, which reads the words of
///        the plan
/// @return the exit status
/// @throws UsageError, Error
int runVideoChunks(const CommandLine& commandLine, const std::vector<std::string>& arguments,
                   const std::function<void(CommandLine&)>& addOptions, Messages& messages);

} // namespace altiro3D::tools
