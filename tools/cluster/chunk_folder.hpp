#pragma once

#include "cli/command_line.hpp"
#include "cli/display_options.hpp"
#include "cli/run_tool.hpp"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// Runs of a tool by many machines: what video2native and photo2native have in common.
///
/// A folder that all machines see holds the plan of one run, and its chunks: `plan.json` for
/// video2native, `photos` for photo2native, `arguments` (the working directory and the words of the
/// command line, each followed by a zero byte), `visual.json` (a copy of the calibration, if the
/// command line names none), `chunks`, and `logs` with a file for each chunk and `join.log`.
namespace altiro3D::tools {

/// A call of the tool for many machines.
struct ChunkCall {
    enum class Task { Plan, Chunk, Join };
    Task task = Task::Plan;
    std::filesystem::path folder; ///< The plan's; absolute.
    int number = 0;               ///< The chunk's.

    /// The name of the log: "7", "join".
    std::string logName() const {
        return task == Task::Chunk ? std::to_string(number) : task == Task::Join ? "join" : "plan";
    }
};

/// Adds --plan, an option for the length of its chunks, --chunk and --join.
/// @param length "chunk-seconds" @param lengthHelp its help @param lengthValue "SECONDS"
/// @param joinHelp what the join does
void addChunkOptions(CommandLine& commandLine, const std::string& length,
                     const std::string& lengthHelp, const std::string& lengthValue,
                     const std::string& joinHelp);

/// The call of a command line that plans a run, makes a chunk or joins; nothing for others. Calls
/// other than the plan take their settings from it.
/// @param length the option for the length of chunks
/// @throws UsageError (options that belong to the plan, names that are missing)
std::optional<ChunkCall> chunkCall(const CommandLine& commandLine, const std::string& length);

/// Keeps the words of the plan's command line in its folder, with a copy of the calibration that
/// was found.
/// @param words the command line, the program's name first
/// @param options how it names the display
/// @throws Error WriteFailed
void keepCommandLine(const std::filesystem::path& folder, std::vector<std::string> words,
                     const DisplayOptions& options, const ChosenDisplay& display);

/// Goes to the working directory of a plan, reads the plan's command line and sets its number of
/// threads.
/// @param tool the tool's name @param threads of the plan
/// @param addOptions adds all options of the tool
/// @param open reads the options; what it finds wrong is a fault of the plan
/// @throws Error NotFound, ReadFailed, BadFormat
void openCommandLine(const std::filesystem::path& folder, const std::string& tool, int threads,
                     const std::function<void(CommandLine&)>& addOptions,
                     const std::function<void(const CommandLine&)>& open);

/// Adds a line with time and machine to the log of a call. A log that cannot be written does not
/// stop the work.
void logLine(const ChunkCall& call, const std::string& line);

/// Makes a chunk or joins, and logs a failure. Its message names the machine, because others make
/// other chunks.
/// @return the exit status
int runLogged(const ChunkCall& call, const std::function<int()>& work);

/// Texts in a file, each followed by a zero byte. @throws Error WriteFailed
void writeWords(const std::filesystem::path& file, const std::vector<std::string>& words);
/// Reads them. @throws Error NotFound, ReadFailed, BadFormat
std::vector<std::string> readWords(const std::filesystem::path& file);
/// @throws Error BadFormat
[[noreturn]] void failDamaged(const std::filesystem::path& file);

/// Runs of neighbouring numbers: "1-3,7". @param numbers in order
std::string rangesText(const std::vector<int>& numbers);

} // namespace altiro3D::tools
