#pragma once

#include "cluster/chunk_folder.hpp"

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// The chunks of a plan as jobs of Slurm.
namespace altiro3D::tools {

/// What a program that starts the chunks needs to know of a plan of video2native or photo2native.
struct ClusterPlan {
    std::filesystem::path folder;    ///< Absolute.
    std::string tool;                ///< "video2native" or "photo2native".
    std::string unit;                ///< What a chunk makes: "frame" or "photo".
    int threads = 1;                 ///< Number of threads that each chunk must be made with.
    int depthAlone = 0;              ///< The first N chunks make depth alone; others wait for them.
    std::vector<std::int64_t> units; ///< Frames or photos of chunk 1, 2, ...; 0 for depth alone.

    int chunks() const { return static_cast<int>(units.size()); }
    std::filesystem::path logs() const { return folder / "logs"; }
    /// The program that makes a chunk or joins: beside this program if it is there.
    std::string program() const;
};

/// @throws Error NotFound, ReadFailed, BadFormat (no plan, a damaged one)
ClusterPlan readClusterPlan(const std::filesystem::path& folder);

/// Whether each chunk is made, from its files. Number 1 first.
std::vector<bool> madeChunks(const ClusterPlan& plan);

/// What the user wants of Slurm.
struct SlurmOptions {
    std::vector<std::string> site; ///< Arguments of sbatch for all jobs, such as --partition=long.
    int cpus = 1;                  ///< Processors of a task.
    int limit = 0;                 ///< Tasks at the same time; 0: no limit.
};

/// A job array; its task i makes the chunk i + offset.
struct SlurmArray {
    std::string id;
    int offset = 0;
};

/// What was submitted, kept in the plan's folder of logs.
struct SlurmRun {
    SlurmOptions options;
    std::vector<SlurmArray> arrays;
    std::string join;         ///< Id of the job that joins.
    double submitted = 0;     ///< Time of the last submission, s since 1970.
    std::vector<int> wasMade; ///< Chunks that were made at that time.
};

/// The time, s since 1970.
double secondsNow();

bool wasSubmitted(const ClusterPlan& plan);
/// Reads what was submitted. @throws Error NotFound, ReadFailed, BadFormat
SlurmRun readSlurmRun(const ClusterPlan& plan);

/// What Slurm says of the jobs of a run.
struct SlurmState {
    bool isKnown = false; ///< Slurm has answered and knows at least one of the jobs.
    std::string why;      ///< Why not: the answer of squeue.
    struct Task {
        std::string state; ///< "RUNNING", "PENDING", ...
        std::string node;
        std::string reason;
        bool isActive() const; ///< It runs, or will run.
    };
    std::map<int, Task> tasks;         ///< By the number of the chunk.
    std::map<std::string, Task> joins; ///< By the id of the job.
};

/// Asks Slurm once for all jobs of a run.
SlurmState askSlurm(const SlurmRun& run);

/// Submits the chunks that are neither made nor submitted, and a join that waits for all of them.
/// @param dryRun write the scripts, print the commands and submit nothing
/// @throws Error Unsupported (no Slurm), ReadFailed (Slurm does not answer), WriteFailed (Slurm
///         refuses the job; its own words)
void submitToSlurm(const ClusterPlan& plan, const SlurmOptions& options, bool dryRun,
                   Messages& messages);

/// Cancels all jobs of a run. @throws Error as submitToSlurm()
void cancelSlurm(const ClusterPlan& plan, Messages& messages);

} // namespace altiro3D::tools
