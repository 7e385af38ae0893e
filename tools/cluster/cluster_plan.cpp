#include "cluster/cluster_plan.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/video_conversion.hpp"
#include "cluster/photo_chunks.hpp"

#include <QCoreApplication>
#include <QProcess>
#include <QString>
#include <QStringList>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr int kPatience = 60000;      // ms for an answer of Slurm
constexpr int kUsualArraySize = 1001; // MaxArraySize if Slurm does not tell
constexpr std::uintmax_t kMaxRunBytes = std::uintmax_t{64} << 20;

fs::path runFile(const ClusterPlan& plan) {
    return plan.logs() / "slurm.json";
}

fs::path scriptOf(const ClusterPlan& plan, const char* name) {
    return plan.logs() / name;
}

std::string commandText(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words)
        text += (text.empty() ? "" : " ") + shellWord(word);
    return text;
}

struct Answer {
    int status = -1;
    std::string out;
    std::string err;
};

// Runs a command of Slurm. @throws Error Unsupported (it is not there)
Answer call(const std::vector<std::string>& words) {
    QProcess process;
    QStringList arguments;
    for (std::size_t i = 1; i < words.size(); ++i)
        arguments << QString::fromLocal8Bit(words[i].c_str());
    process.start(QString::fromStdString(words[0]), arguments);
    if (!process.waitForStarted(kPatience)) {
        throw Error(ErrorCode::Unsupported, words[0],
                    "cannot be started, expected Slurm's command on a machine of the cluster");
    }
    process.closeWriteChannel();
    Answer answer;
    if (!process.waitForFinished(kPatience)) {
        process.kill();
        process.waitForFinished(kPatience);
        answer.err = "no answer within " + std::to_string(kPatience / 1000) + " s";
        return answer;
    }
    answer.status = process.exitStatus() == QProcess::NormalExit ? process.exitCode() : -1;
    answer.out = process.readAllStandardOutput().toStdString();
    answer.err = oneLine(QString::fromUtf8(process.readAllStandardError()).trimmed().toStdString());
    return answer;
}

// Submits a job. @return its id
std::string submit(const std::vector<std::string>& words) {
    const Answer answer = call(words);
    if (answer.status != 0) {
        throw Error(ErrorCode::WriteFailed, words[0],
                    "has not taken the job: " + (answer.err.empty() ? "no reason" : answer.err));
    }
    std::string id = answer.out.substr(0, answer.out.find_first_of(";\n")); // "12;cluster"
    if (id.empty() || id.find_first_not_of("0123456789") != std::string::npos) {
        throw Error(ErrorCode::ReadFailed, words[0],
                    "answered \"" + oneLine(answer.out) + "\", expected the number of a job");
    }
    return id;
}

// The largest number of a task, plus one.
int arraySize() {
    const Answer answer = call({"scontrol", "show", "config"});
    const std::string key = "MaxArraySize";
    const std::size_t at = answer.out.find(key);
    if (at == std::string::npos) return kUsualArraySize;
    const std::size_t digit = answer.out.find_first_of("0123456789", at);
    const std::size_t line = answer.out.find('\n', at);
    if (digit == std::string::npos || digit > line) return kUsualArraySize;
    const int size = QString::fromStdString(answer.out.substr(digit, line - digit))
                         .trimmed()
                         .toInt(); // 0 if it is no number
    return size < 2 ? kUsualArraySize : size;
}

void writeScripts(const ClusterPlan& plan) {
    const std::string start = "#!/bin/bash\n";
    writeFile(scriptOf(plan, "slurm-chunk.sh"),
              start + "# Makes a chunk: task number plus $1.\nexec " + shellWord(plan.program()) +
                  " --chunk \"$((SLURM_ARRAY_TASK_ID + $1))\" " + shellWord(plan.folder.string()) +
                  "\n");
    writeFile(scriptOf(plan, "slurm-join.sh"), start + "exec " + shellWord(plan.program()) +
                                                   " --join " + shellWord(plan.folder.string()) +
                                                   "\n");
}

std::vector<std::string> sbatch(const ClusterPlan& plan, const SlurmOptions& options,
                                const std::string& log, int cpus) {
    std::vector<std::string> words = {"sbatch",
                                      "--parsable",
                                      "--requeue",
                                      "--open-mode=append",
                                      "--job-name=altiro3D",
                                      "--output=" + (plan.logs() / log).string(),
                                      "--cpus-per-task=" + std::to_string(cpus)};
    words.insert(words.end(), options.site.begin(), options.site.end());
    return words;
}

// Submits, or prints, the jobs of a run.
class Submission {
  public:
    Submission(const ClusterPlan& plan, const SlurmOptions& options, bool dryRun,
               Messages& messages)
        : plan_(plan), options_(options), dryRun_(dryRun), messages_(messages) {}

    // @param numbers in order @param after ids that must have ended, with or without success
    std::vector<SlurmArray> arrays(const std::vector<int>& numbers,
                                   const std::vector<SlurmArray>& after) {
        std::vector<SlurmArray> made;
        if (numbers.empty()) return made;
        if (maxTasks_ == 0) maxTasks_ = (dryRun_ ? kUsualArraySize : arraySize()) - 1;
        for (std::size_t i = 0; i < numbers.size();) {
            const int offset = (numbers[i] - 1) / maxTasks_ * maxTasks_;
            std::vector<int> tasks;
            for (; i < numbers.size() && numbers[i] - offset <= maxTasks_; ++i)
                tasks.push_back(numbers[i] - offset);
            std::vector<std::string> words =
                sbatch(plan_, options_, "slurm-%A_%a.log", options_.cpus);
            words.push_back("--array=" + rangesText(tasks) +
                            (options_.limit > 0 ? "%" + std::to_string(options_.limit) : ""));
            if (!after.empty()) words.push_back("--dependency=afterany" + idsText(after));
            words.push_back(scriptOf(plan_, "slurm-chunk.sh").string());
            words.push_back(std::to_string(offset));
            made.push_back({send(words), offset});
        }
        return made;
    }

    std::string join(const std::vector<SlurmArray>& after) {
        std::vector<std::string> words = sbatch(plan_, options_, "slurm-join.log", options_.cpus);
        if (!after.empty()) {
            words.push_back("--dependency=afterok" + idsText(after));
            words.push_back("--kill-on-invalid-dep=yes");
        }
        words.push_back(scriptOf(plan_, "slurm-join.sh").string());
        return send(words);
    }

  private:
    static std::string idsText(const std::vector<SlurmArray>& arrays) {
        std::string text;
        for (const SlurmArray& array : arrays)
            text += ":" + array.id;
        return text;
    }

    std::string send(const std::vector<std::string>& words) {
        if (!dryRun_) return submit(words);
        messages_.say(commandText(words));
        return "JOB" + std::to_string(++printed_);
    }

    const ClusterPlan& plan_;
    const SlurmOptions& options_;
    bool dryRun_;
    Messages& messages_;
    int maxTasks_ = 0;
    int printed_ = 0;
};

void writeSlurmRun(const ClusterPlan& plan, const SlurmRun& run) {
    Json arrays = Json::array();
    for (const SlurmArray& array : run.arrays)
        arrays.push_back({{"id", array.id}, {"offset", array.offset}});
    const Json json = {{"site", run.options.site},   {"cpus", run.options.cpus},
                       {"limit", run.options.limit}, {"arrays", arrays},
                       {"join", run.join},           {"submitted", run.submitted},
                       {"wasMade", run.wasMade}};
    writeFile(runFile(plan), json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

} // namespace

std::string ClusterPlan::program() const {
    const fs::path beside = fs::path(QCoreApplication::applicationDirPath().toStdString()) / tool;
    return isFile(beside) ? beside.string() : tool;
}

ClusterPlan readClusterPlan(const fs::path& folder) {
    ClusterPlan plan;
    plan.folder = fs::absolute(folder);
    if (holdsPhotoChunks(plan.folder)) {
        const PhotoChunks photos = readPhotoChunks(plan.folder);
        plan.tool = "photo2native";
        plan.unit = "photo";
        plan.threads = photos.threads;
        for (int number = 1; number <= photos.count(); ++number) {
            const auto [first, end] = photos.photosOf(number);
            plan.units.push_back(static_cast<std::int64_t>(end - first));
        }
        return plan;
    }
    const VideoChunkPlan video = readVideoChunks(plan.folder);
    plan.tool = "video2native";
    plan.unit = "frame";
    plan.threads = video.threads;
    for (const VideoChunk& chunk : video.chunks) {
        plan.units.push_back(chunk.frames);
        if (chunk.frames == 0) ++plan.depthAlone;
    }
    return plan;
}

std::vector<bool> madeChunks(const ClusterPlan& plan) {
    std::vector<bool> made;
    const auto isMade = plan.tool == "photo2native" ? isPhotoChunkMade : isVideoChunkMade;
    for (int number = 1; number <= plan.chunks(); ++number)
        made.push_back(isMade(plan.folder, number));
    return made;
}

double secondsNow() {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch())
        .count();
}

bool wasSubmitted(const ClusterPlan& plan) {
    return isThere(runFile(plan));
}

SlurmRun readSlurmRun(const ClusterPlan& plan) {
    const fs::path file = runFile(plan);
    const Json json = Json::parse(readFile(file, kMaxRunBytes), nullptr, false);
    SlurmRun run;
    try {
        run.options.site = json.at("site").get<std::vector<std::string>>();
        run.options.cpus = std::clamp(json.at("cpus").get<int>(), 1, 1 << 20);
        run.options.limit = std::max(json.at("limit").get<int>(), 0);
        for (const Json& array : json.at("arrays"))
            run.arrays.push_back(
                {array.at("id").get<std::string>(), array.at("offset").get<int>()});
        run.join = json.at("join").get<std::string>();
        run.submitted = json.at("submitted").get<double>();
        run.wasMade = json.at("wasMade").get<std::vector<int>>();
    } catch (const Json::exception&) {
        throw Error(ErrorCode::BadFormat, file.string(),
                    "is damaged, expected the file as it was written");
    }
    return run;
}

bool SlurmState::Task::isActive() const {
    static const std::set<std::string> kActive = {
        "PENDING",      "RUNNING",      "COMPLETING",  "CONFIGURING", "SUSPENDED",
        "REQUEUED",     "REQUEUE_HOLD", "REQUEUE_FED", "RESIZING",    "SIGNALING",
        "SPECIAL_EXIT", "STAGE_OUT",    "STOPPED"};
    return kActive.count(state) > 0;
}

SlurmState askSlurm(const SlurmRun& run) {
    std::string ids;
    std::map<std::string, int> offsets;
    for (const SlurmArray& array : run.arrays) {
        ids += array.id + ",";
        offsets[array.id] = array.offset;
    }
    ids += run.join;
    const Answer answer = call({"squeue", "-h", "-r", "-t", "all", "-j", ids, "-o", "%i|%T|%N|%r"});
    SlurmState state;
    // A job that has long ended is forgotten: then squeue fails, or is silent.
    state.isKnown = answer.status == 0 && !answer.out.empty();
    if (!state.isKnown) {
        state.why = answer.err.empty() ? "squeue is silent" : answer.err;
        return state;
    }
    std::istringstream lines(answer.out);
    for (std::string line; std::getline(lines, line);) {
        std::vector<std::string> parts;
        std::istringstream fields(line);
        for (std::string part; std::getline(fields, part, '|');)
            parts.push_back(part);
        parts.resize(4);
        const SlurmState::Task task{parts[1], parts[2], parts[3]};
        const std::size_t mark = parts[0].find('_');
        if (mark == std::string::npos) {
            state.joins[parts[0]] = task;
            continue;
        }
        const auto offset = offsets.find(parts[0].substr(0, mark));
        const int index = QString::fromStdString(parts[0].substr(mark + 1)).toInt();
        if (offset == offsets.end() || index < 1) continue;
        SlurmState::Task& known = state.tasks[index + offset->second];
        if (!known.isActive()) known = task; // of several submissions the active one counts
    }
    return state;
}

void submitToSlurm(const ClusterPlan& plan, const SlurmOptions& options, bool dryRun,
                   Messages& messages) {
    const std::vector<bool> made = madeChunks(plan);
    SlurmRun run;
    std::set<int> active;
    std::vector<SlurmArray> waiting; // arrays of earlier submissions that have active tasks
    if (wasSubmitted(plan)) {
        const SlurmRun before = readSlurmRun(plan);
        const SlurmState state = askSlurm(before);
        if (!state.isKnown && state.why.find("Invalid job id") == std::string::npos &&
            state.why != "squeue is silent") {
            throw Error(ErrorCode::ReadFailed, "squeue",
                        "does not say what runs (" + state.why +
                            "), expected an answer; try again");
        }
        for (const auto& [number, task] : state.tasks)
            if (task.isActive()) active.insert(number);
        if (!active.empty()) {
            waiting = before.arrays;
            run.arrays = before.arrays;
        }
        const auto join = state.joins.find(before.join);
        if (!dryRun && join != state.joins.end() && join->second.isActive())
            call({"scancel", before.join}); // the new one waits for all chunks
    }
    std::vector<int> first;
    std::vector<int> rest;
    for (int number = 1; number <= plan.chunks(); ++number) {
        if (made[static_cast<std::size_t>(number - 1)]) {
            run.wasMade.push_back(number);
        } else if (active.count(number) == 0) {
            (number <= plan.depthAlone ? first : rest).push_back(number);
        }
    }
    run.options = options;
    run.submitted = secondsNow();
    writeScripts(plan);
    Submission submission(plan, options, dryRun, messages);
    const auto add = [&](const std::vector<SlurmArray>& arrays) {
        for (const SlurmArray& array : arrays) {
            run.arrays.push_back(array);
            waiting.push_back(array);
        }
        if (!dryRun) writeSlurmRun(plan, run); // so that --cancel finds what was submitted
    };
    const std::vector<SlurmArray> depth = submission.arrays(first, {});
    add(depth);
    add(submission.arrays(rest, depth));
    run.join = submission.join(waiting);
    if (dryRun) return;
    writeSlurmRun(plan, run);
    std::string ids;
    for (const SlurmArray& array : run.arrays)
        ids += (ids.empty() ? "" : ", ") + array.id;
    messages.say(plan.folder.string() + ": submitted " +
                 counted(first.size() + rest.size(), "chunk") +
                 (ids.empty() ? "" : ", jobs " + ids) + ", and the join, job " + run.join);
}

void cancelSlurm(const ClusterPlan& plan, Messages& messages) {
    const SlurmRun run = readSlurmRun(plan);
    std::vector<std::string> words = {"scancel"};
    for (const SlurmArray& array : run.arrays)
        words.push_back(array.id);
    if (!run.join.empty()) words.push_back(run.join);
    const Answer answer = call(words);
    if (answer.status != 0) {
        throw Error(ErrorCode::WriteFailed, "scancel",
                    "has not cancelled: " + (answer.err.empty() ? "no reason" : answer.err));
    }
    messages.say(plan.folder.string() + ": cancelled; the chunks that are made stay, --resume "
                                        "submits the rest");
}

} // namespace altiro3D::tools
