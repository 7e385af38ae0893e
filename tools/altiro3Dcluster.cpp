// altiro3Dcluster: makes the chunks of a plan on many machines, by Slurm or GNU Parallel.

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/video_conversion.hpp"
#include "cli/system.hpp"
#include "cluster/cluster_plan.hpp"

#include <QFile>
#include <QProcess>
#include <QString>
#include <QStringList>
#include <algorithm>
#include <atomic>
#include <functional>
#include <set>
#include <thread>

using namespace altiro3D;
using namespace altiro3D::tools;

namespace fs = std::filesystem;

namespace {

std::vector<int> missingChunks(const ClusterPlan& plan, int from, int to) {
    const std::vector<bool> made = madeChunks(plan);
    std::vector<int> missing;
    for (int number = from; number <= to; ++number)
        if (!made[static_cast<std::size_t>(number - 1)]) missing.push_back(number);
    return missing;
}

// Runs the tool of a plan and forwards its output. @return whether it succeeded
bool runTask(const ClusterPlan& plan, const QStringList& arguments) {
    QProcess process;
    process.setProcessChannelMode(QProcess::ForwardedChannels);
    process.start(QString::fromStdString(plan.program()), arguments);
    return process.waitForStarted(-1) && process.waitForFinished(-1) &&
           process.exitStatus() == QProcess::NormalExit && process.exitCode() == kExitDone;
}

QString folderOf(const ClusterPlan& plan) {
    return QFile::decodeName(plan.folder.string().c_str());
}

// Makes chunks, `atOnce` at the same time.
void runHere(const ClusterPlan& plan, const std::vector<int>& numbers, int atOnce) {
    std::atomic<std::size_t> next{0};
    std::vector<std::thread> workers;
    const auto count = std::min(static_cast<std::size_t>(atOnce), numbers.size());
    for (std::size_t i = 0; i < count; ++i) {
        workers.emplace_back([&] {
            for (std::size_t k = next++; k < numbers.size(); k = next++)
                runTask(plan, {"--chunk", QString::number(numbers[k]), folderOf(plan)});
        });
    }
    for (std::thread& worker : workers)
        worker.join();
}

// Makes chunks by GNU Parallel on the hosts of a file.
void runOnHosts(const ClusterPlan& plan, const std::vector<int>& numbers,
                const std::string& hosts) {
    if (numbers.empty()) return;
    QProcess process;
    process.setProcessChannelMode(QProcess::ForwardedChannels);
    // Not --quote: with it, GNU Parallel 20221122 also quotes the commands of --filter-hosts,
    // and ends.
    const auto word = [](const std::string& text) {
        return QString::fromLocal8Bit(shellWord(text).c_str());
    };
    process.start("parallel", {"--retries", "3", "--filter-hosts", "--jobs",
                               QString::number(std::max(100 / plan.threads, 1)) + "%",
                               "--sshloginfile", QString::fromLocal8Bit(hosts.c_str()),
                               word(plan.program()), "--chunk", "{}", word(plan.folder.string())});
    if (!process.waitForStarted(-1)) {
        throw Error(ErrorCode::Unsupported, "parallel",
                    "cannot be started, expected GNU Parallel (package parallel)");
    }
    for (const int number : numbers)
        process.write(QByteArray::number(number) + "\n");
    process.closeWriteChannel();
    process.waitForFinished(-1);
}

// Makes all chunks that are missing, those of depth alone first, then joins. Exit status.
int makeAll(const ClusterPlan& plan,
            const std::function<void(const std::vector<int>& numbers)>& makeChunks) {
    makeChunks(missingChunks(plan, 1, plan.depthAlone));
    makeChunks(missingChunks(plan, plan.depthAlone + 1, plan.chunks()));
    const std::vector<int> missing = missingChunks(plan, 1, plan.chunks());
    if (!missing.empty()) {
        throw Error(ErrorCode::WriteFailed, plan.folder.string(),
                    "has no " + std::string(missing.size() == 1 ? "chunk " : "chunks ") +
                        rangesText(missing) + "; " + plan.logs().string() +
                        " says why, and the same command tries again");
    }
    return runTask(plan, {"--join", folderOf(plan)}) ? kExitDone : kExitFailed;
}

// What is made since the submission, how fast, and how long the rest takes at this rate.
void sayRate(const ClusterPlan& plan, const std::vector<bool>& made, const SlurmRun& run,
             Messages& messages) {
    const std::set<int> before(run.wasMade.begin(), run.wasMade.end());
    std::int64_t done = 0;
    std::int64_t left = 0;
    for (int number = 1; number <= plan.chunks(); ++number) {
        const std::int64_t units = plan.units[static_cast<std::size_t>(number - 1)];
        if (!made[static_cast<std::size_t>(number - 1)]) {
            left += units;
        } else if (before.count(number) == 0) {
            done += units;
        }
    }
    const double seconds = secondsNow() - run.submitted;
    if (done == 0 || left == 0 || !(seconds > 0)) return;
    const double rate = static_cast<double>(done) / seconds;
    messages.say(fixed(rate, rate < 10 ? 2 : 0) + " " + plan.unit + "s per second since the last " +
                 "submission; at this rate " + clockText(static_cast<double>(left) / rate) +
                 " remain");
}

int status(const ClusterPlan& plan, Messages& messages) {
    const std::vector<bool> made = madeChunks(plan);
    const auto count = std::count(made.begin(), made.end(), true);
    std::string line = plan.folder.string() + ": " + std::to_string(count) + " of " +
                       counted(plan.chunks(), "chunk") + " made";
    if (!wasSubmitted(plan)) {
        messages.say(line);
        return kExitDone;
    }
    const SlurmRun run = readSlurmRun(plan);
    const SlurmState state = askSlurm(run);
    std::set<std::string> nodes;
    std::set<std::string> reasons;
    std::vector<int> failed;
    std::vector<int> lost;
    int running = 0;
    int waiting = 0;
    for (int number = 1; number <= plan.chunks(); ++number) {
        if (made[static_cast<std::size_t>(number - 1)]) continue;
        const auto task = state.tasks.find(number);
        if (task == state.tasks.end()) {
            lost.push_back(number);
        } else if (task->second.state == "PENDING") {
            ++waiting;
            reasons.insert(task->second.reason);
        } else if (task->second.isActive()) {
            ++running;
            nodes.insert(task->second.node);
        } else {
            failed.push_back(number);
        }
    }
    const std::string places = joined({nodes.begin(), nodes.end()});
    const std::string why = joined({reasons.begin(), reasons.end()});
    if (running > 0) line += ", " + std::to_string(running) + " being made on " + places;
    if (waiting > 0) line += ", " + std::to_string(waiting) + " waiting (" + why + ")";
    if (!failed.empty()) line += ", failed: " + rangesText(failed);
    if (state.isKnown && !lost.empty()) line += ", not submitted: " + rangesText(lost);
    messages.say(line);
    if (!state.isKnown && !lost.empty()) messages.say("Slurm does not say what runs: " + state.why);
    sayRate(plan, made, run, messages);
    const auto join = state.joins.find(run.join);
    if (join != state.joins.end()) {
        const std::string& is = join->second.state;
        messages.say(std::string("the join ") +
                     (is == "PENDING"           ? "waits for the chunks"
                      : join->second.isActive() ? "runs on " + join->second.node
                      : is == "COMPLETED"
                          ? "is done"
                          : "has failed (" + is + "); see " + (plan.logs() / "join.log").string()));
    }
    if (!failed.empty()) messages.say("--resume submits the missing chunks again");
    return kExitDone;
}

// The command line.
struct ClusterJob {
    ClusterPlan plan;
    std::string action; // the option that chooses it: "slurm", "hosts", ...
    fs::path hosts;
    int local = 1; // chunks at a time
    SlurmOptions slurm;
    bool dryRun = false;
};

ClusterJob clusterJob(const CommandLine& commandLine) {
    ClusterJob job;
    fs::path folder;
    commandLine.takeNames("PLAN", {&folder});
    for (const std::string option : {"slurm", "hosts", "local", "status", "resume", "cancel"}) {
        std::string action;
        commandLine.take({{option.c_str(), action, option}});
        if (action.empty()) continue;
        if (!job.action.empty()) commandLine.exclude(job.action, action);
        job.action = action;
    }
    if (job.action.empty())
        throw UsageError("expected one of --slurm, --hosts, --local, --status, --resume, --cancel");
    commandLine.refuseWithout(
        "slurm", {"partition", "account", "qos", "time", "memory", "cpus", "slurm-arg", "limit"},
        " belongs to --slurm");
    if (job.action != "slurm" && job.action != "resume")
        commandLine.refuse({"dry-run"}, " belongs to --slurm and --resume");
    job.plan = readClusterPlan(folder);
    job.slurm.cpus = job.plan.threads;
    commandLine.take({{"hosts", job.hosts},
                      {"local", job.local, 1, 1024},
                      {"dry-run", job.dryRun},
                      {"cpus", job.slurm.cpus, 1, 4096},
                      {"limit", job.slurm.limit, 1, 1000000}});
    constexpr std::pair<const char*, const char*> kSite[] = {{"partition", "--partition="},
                                                             {"account", "--account="},
                                                             {"qos", "--qos="},
                                                             {"time", "--time="},
                                                             {"memory", "--mem="}};
    for (const auto& [option, argument] : kSite) {
        std::string value;
        commandLine.take({{option, value}});
        if (!value.empty()) job.slurm.site.push_back(argument + value);
    }
    for (const std::string& word : commandLine.values("slurm-arg"))
        job.slurm.site.push_back(word);
    return job;
}

int run(const ClusterJob& job, Messages& messages) {
    const ClusterPlan& plan = job.plan;
    if (job.action == "status") return status(plan, messages);
    if (job.action == "local") {
        messages.say(plan.folder.string() + ": " +
                     counted(missingChunks(plan, 1, plan.chunks()).size(), "chunk") +
                     " to make by " + plan.tool + ", " + std::to_string(job.local) + " at a time");
        return makeAll(plan,
                       [&](const std::vector<int>& numbers) { runHere(plan, numbers, job.local); });
    }
    const std::string local = localText(plan.folder);
    if (!local.empty() && job.action != "cancel") messages.warn(local);
    if (job.action == "hosts") {
        const std::string hosts = fs::absolute(job.hosts).string();
        static_cast<void>(readFile(hosts, 1 << 24)); // a clear error if it is not there
        messages.flushWarnings();
        return makeAll(plan,
                       [&](const std::vector<int>& numbers) { runOnHosts(plan, numbers, hosts); });
    }
    if (job.action != "slurm" && !wasSubmitted(plan))
        throw Error(ErrorCode::NotFound, plan.folder.string(),
                    "was not submitted, expected --slurm before --" + job.action);
    if (job.action == "cancel") {
        cancelSlurm(plan, messages);
        return kExitDone;
    }
    submitToSlurm(plan, job.action == "resume" ? readSlurmRun(plan).options : job.slurm, job.dryRun,
                  messages);
    return kExitDone;
}

} // namespace

int main(int argc, char** argv) {
    CommandLine commandLine("altiro3Dcluster",
                            "Makes the chunks of a plan of video2native or photo2native on many "
                            "machines, and joins them. Chunks that are made are not made again.");
    commandLine.addUsage("--slurm [options] PLAN");
    commandLine.addUsage("--hosts FILE | --local N PLAN");
    commandLine.addUsage("--status | --resume | --cancel PLAN");
    commandLine.addSection("Where");
    commandLine.add({"slurm"}, "Submit the chunks and the join to Slurm, and print the jobs.");
    commandLine.add({"hosts"},
                    "Make the chunks on the computers that FILE lists, by GNU Parallel over ssh, "
                    "then join.",
                    "FILE");
    commandLine.add({"local"}, "Make N chunks at a time on this machine, then join.", "N");
    commandLine.addSection("Jobs of Slurm");
    commandLine.add({"status"}, "Say what is made, what runs, and how long the rest takes.");
    commandLine.add({"resume"}, "Submit the missing chunks again, with the same options.");
    commandLine.add({"cancel"}, "Cancel the jobs. The chunks that are made stay.");
    commandLine.add({"dry-run"}, "Write the scripts, print the commands and submit nothing.");
    commandLine.addSection("Options of --slurm, passed on to sbatch");
    commandLine.add({"partition"}, "Partition of the cluster.", "NAME");
    commandLine.add({"account"}, "Account to charge.", "NAME");
    commandLine.add({"qos"}, "Quality of service.", "NAME");
    commandLine.add({"time"}, "Longest time of a chunk, and of the join.", "TIME");
    commandLine.add({"memory"}, "Memory of a task, such as 2G.", "SIZE");
    commandLine.add({"cpus"}, "Processors of a task (default: the threads of the plan).", "N");
    commandLine.add({"limit"}, "Make at most N chunks at a time.", "N");
    commandLine.add({"slurm-arg"}, "Any other argument of sbatch; may be repeated.", "ARG");
    commandLine.addNote("PLAN is the folder that video2native --plan or photo2native --plan has "
                        "made. All machines must see this folder, the inputs and the tools under "
                        "the same names.");
    commandLine.addExample("--slurm --partition long --time 1:00:00 film.plan",
                           "Submit a film to Slurm.");
    commandLine.addExample("--status film.plan", "Show the progress.");
    commandLine.addExample("--local 4 film.plan", "Make four chunks at a time on this machine.");
    commandLine.addTerm(CommandLine::Chapter::Files, "PLAN/logs",
                        "The log of each chunk (7.log), of the join (join.log) and of the jobs; "
                        "slurm.json says what was submitted.");
    commandLine.addTerm(CommandLine::Chapter::Environment, "SLURM_CONF",
                        "Read by the commands of Slurm; see slurm.conf(5).");
    return runTool(argc, argv, commandLine, [](const CommandLine& given, Messages& messages) {
        return run(clusterJob(given), messages);
    });
}
