#pragma once

#include "cli/command_line.hpp"
#include "cli/folder_search.hpp"
#include "cli/run_tool.hpp"

#include <chrono>
#include <exception>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

/// The run of a tool over many files.
namespace altiro3D::tools {

constexpr int kExitStopped = 130; ///< By Ctrl-C, as in shells.

/// --recursive
/// @param things "photos"
void addRecursiveOption(CommandLine& commandLine, const std::string& things);

/// Searches a folder and says what is left out.
/// @param leftOut receives what is left out
/// @return what is to be converted
/// @throws Error as searchFolder()
std::vector<FolderFile> listFiles(const std::filesystem::path& folder, const FolderSearch& search,
                                  std::vector<LeftOutFile>& leftOut, Messages& messages);

/// Refuses an output that names one file. @throws UsageError
/// @param things "photos" @param remedy further help, or nothing
void requireDirectoryName(const std::filesystem::path& name, const std::string& things,
                          const std::string& remedy = {});

/// Whether a file holds anything.
bool isFileWithContents(const std::filesystem::path& file);

/// Thrown for a file of a folder that turns out to be something else than its name says.
struct NotTaken {
    LeftOutFile file;
};

/// Converts files one after the other: one that fails does not stop the rest, and the end counts
/// what was made, skipped, left out and failed. Messages begin with the name of the file.
class FolderRun {
  public:
    /// @param thing "photo", for the summary
    /// @param files number of files to convert
    /// @param leftOut what the search left out already
    FolderRun(std::string thing, std::size_t files, std::vector<LeftOutFile> leftOut,
              Messages& messages);

    /// How a file ended.
    struct Outcome {
        int status = kExitDone; ///< Of the work.
        std::string leftOut;    ///< Why it is not converted; empty: it is.
        std::string error;      ///< Why it failed, if an exception says so.
    };
    /// Converts a file.
    /// @param work returns an exit status, or throws NotTaken or an exception that means failure
    Outcome convert(const std::filesystem::path& file, const std::function<int()>& work);
    /// Whether a file failed for a reason that another run may not have: a full disk, no memory.
    bool mayRecover() const { return mayRecover_; }
    /// Counts a file whose outputs exist.
    void skip(const std::filesystem::path& file, const std::filesystem::path& output);

    /// Number of files that were begun, from 1, and of all: "[2/7]".
    std::string place() const;
    /// Says what was made, skipped, stopped, not begun, left out and failed.
    /// @return the exit status: that of the user's stop, failure, or success
    int end();

  private:
    std::string thing_;
    Messages& messages_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::vector<LeftOutFile> leftOut_;
    std::size_t files_;
    std::size_t begun_ = 0;
    std::size_t made_ = 0;
    std::size_t skipped_ = 0;
    std::size_t failed_ = 0;
    std::size_t stopped_ = 0;
    bool mayRecover_ = false;
    Progress progress_;
};

} // namespace altiro3D::tools
