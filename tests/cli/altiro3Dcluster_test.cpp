// altiro3Dcluster, with commands of Slurm and GNU Parallel that record what they are asked

#include "sandbox.hpp"
#include "support/video.hpp"

#include <nlohmann/json.hpp>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTool = "altiro3Dcluster";

// Three photos, planned as three chunks, and commands of a cluster in bin/.
class ClusterStudio : public SmallStudio {
  public:
    ClusterStudio() {
        fs::create_directory(*this / "photos");
        for (const char* name : {"a.png", "b.png", "c.png"})
            fs::copy(*this / "photo.png", *this / "photos" / name);
        fs::create_directory(*this / "bin");
        set("PATH", (*this / "bin").string() + ":/usr/bin:/bin");
    }
    void plan() const {
        const Outcome outcome =
            run("photo2native", Arguments{"--plan", "the plan", "--chunk-photos", "1", "-j", "1"} +
                                    display() + Arguments("photos natives"));
        ASSERT_TRUE(isDone(outcome));
    }
    Outcome cluster(const Arguments& arguments) const {
        return run(kTool, arguments + Arguments{"the plan"});
    }
    // A command that writes its name and arguments to calls.txt, then does `body`.
    void command(const std::string& name, const std::string& body) const {
        const fs::path file = *this / ("bin/" + name);
        spill(file, "#!/bin/bash\n{ printf '%s' \"${0##*/}\"; printf ' [%s]' \"$@\"; echo; } >> " +
                        (*this / "calls.txt").string() + "\n" + body + "\n");
        fs::permissions(file, fs::perms::owner_all);
    }
    // Slurm that takes every job and numbers them from 101.
    void installSlurm() const {
        command("sbatch", "n=$(cat jobs 2>/dev/null || echo 100); echo $((n + 1)) | tee jobs");
        command("scancel", "");
        command("scontrol", "echo 'MaxArraySize            = 1001'");
        command("squeue", "echo 'slurm_load_jobs error: Invalid job id specified' >&2; exit 1");
    }
    std::vector<std::string> calls() const { return lines(slurp(*this / "calls.txt")); }
    std::string folder() const { return (*this / "the plan").string(); }
};

// Whether a recorded call has an argument.
bool has(const std::string& call, const std::string& argument) {
    return call.find("[" + argument + "]") != std::string::npos;
}

TEST(Cluster, RunsHereAsOneRunDoes) {
    const ClusterStudio studio;
    studio.plan();
    Outcome outcome = studio.cluster("--status");
    EXPECT_TRUE(holds(outcome.out, "the plan: 0 of 3 chunks made"));
    outcome = studio.cluster("--local 2");
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.out, "the plan: 3 chunks to make by photo2native, 2 at a time"));
    EXPECT_FALSE(holds(outcome.out, "display: ")); // of each chunk
    ASSERT_TRUE(isDone(studio.convert("photo2native", "-j 1 photos whole")));
    for (const char* name : {"a_native.png", "b_native.png", "c_native.png"})
        EXPECT_EQ(slurp(studio / "natives" / name), slurp(studio / "whole" / name)) << name;
    outcome = studio.cluster("--status");
    EXPECT_TRUE(holds(outcome.out, "3 of 3 chunks made"));
}

TEST(Cluster, SaysWhichChunksFail) {
    const ClusterStudio studio;
    studio.plan();
    fs::create_directories(studio / "natives/b_native.png");
    const Outcome outcome = studio.cluster("--local 1");
    EXPECT_EQ(outcome.status, 1);
    EXPECT_TRUE(holds(outcome.err, "has no chunk 2; "));
    EXPECT_TRUE(fs::exists(studio / "natives/c_native.png")); // the others are made
    fs::remove(studio / "natives/b_native.png");
    EXPECT_EQ(studio.cluster("--local 1").status, 0);
}

TEST(Cluster, SubmitsAnArrayAndItsJoin) {
    ClusterStudio studio;
    studio.plan();
    studio.installSlurm();
    ASSERT_TRUE(isDone(studio.run("photo2native", {"--chunk", "2", "the plan"})));
    const Outcome outcome = studio.cluster("--slurm --partition long --memory 2G --limit 5 "
                                           "--slurm-arg --nice=10 --slurm-arg --mail-type=END");
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.out, "submitted 2 chunks, jobs 101, and the join, job 102"));
    std::vector<std::string> jobs;
    for (const std::string& call : studio.calls())
        if (call.rfind("sbatch", 0) == 0) jobs.push_back(call);
    ASSERT_EQ(jobs.size(), 2U);
    for (const std::string& job : jobs) {
        for (const char* argument :
             {"--parsable", "--requeue", "--open-mode=append", "--partition=long", "--mem=2G",
              "--nice=10", "--mail-type=END", "--cpus-per-task=1"})
            EXPECT_TRUE(has(job, argument)) << argument << " " << job;
    }
    EXPECT_TRUE(has(jobs[0], "--array=1,3%5")) << jobs[0];
    EXPECT_TRUE(has(jobs[0], "--output=" + studio.folder() + "/logs/slurm-%A_%a.log")) << jobs[0];
    EXPECT_TRUE(has(jobs[1], "--dependency=afterok:101")) << jobs[1];
    EXPECT_TRUE(has(jobs[1], "--kill-on-invalid-dep=yes")) << jobs[1];
    // the scripts do what the jobs are for
    studio.command("unused", "");
    for (const char* task : {"1", "3"}) {
        studio.set("SLURM_ARRAY_TASK_ID", task);
        ASSERT_TRUE(isDone(studio.run("/bin/bash", {"the plan/logs/slurm-chunk.sh", "0"})));
    }
    ASSERT_TRUE(isDone(studio.run("/bin/bash", {"the plan/logs/slurm-join.sh"})));
    EXPECT_TRUE(holds(studio.cluster("--status").out, "3 of 3 chunks made"));
}

TEST(Cluster, ADryRunSubmitsNothing) {
    const ClusterStudio studio;
    studio.plan();
    studio.installSlurm();
    const Outcome outcome = studio.cluster({"--slurm", "--dry-run", "--account", "a b"});
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.out, "'--account=a b'"));
    EXPECT_TRUE(holds(outcome.out, "--dependency=afterok:JOB1"));
    EXPECT_FALSE(fs::exists(studio / "calls.txt"));
    EXPECT_TRUE(fs::exists(studio / "the plan/logs/slurm-chunk.sh"));
    EXPECT_TRUE(fails(studio.cluster("--cancel"), 1, "was not submitted, expected --slurm"));
}

TEST(Cluster, ManyChunksBecomeSeveralArrays) {
    const ClusterStudio studio;
    studio.plan();
    studio.installSlurm();
    studio.command("scontrol", "echo 'MaxArraySize = 3'"); // so tasks are 1 and 2
    ASSERT_EQ(studio.cluster("--slurm").status, 0);
    std::vector<std::string> jobs;
    for (const std::string& call : studio.calls())
        if (call.rfind("sbatch", 0) == 0) jobs.push_back(call);
    ASSERT_EQ(jobs.size(), 3U);
    EXPECT_TRUE(has(jobs[0], "--array=1-2") && has(jobs[0], "0")) << jobs[0];
    EXPECT_TRUE(has(jobs[1], "--array=1") && has(jobs[1], "2")) << jobs[1];
    EXPECT_TRUE(has(jobs[2], "--dependency=afterok:101:102")) << jobs[2];
}

TEST(Cluster, TellsWhatSlurmDoesAndSubmitsWhatIsMissing) {
    const ClusterStudio studio;
    studio.plan();
    studio.installSlurm();
    ASSERT_EQ(studio.cluster("--slurm --qos low").status, 0);
    studio.command("squeue", "echo '101_1|RUNNING|node7|None'; echo '101_2|NODE_FAIL||NodeDown'; "
                             "echo '101_3|PENDING||Resources'; "
                             "echo '102|PENDING||Dependency'");
    Outcome outcome = studio.cluster("--status");
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    EXPECT_TRUE(holds(outcome.out,
                      "0 of 3 chunks made, 1 being made on node7, 1 waiting (Resources), "
                      "failed: 2"));
    EXPECT_TRUE(holds(outcome.out, "the join waits"));
    fs::remove(studio / "calls.txt");
    ASSERT_EQ(studio.cluster("--resume").status, 0);
    const std::string all = slurp(studio / "calls.txt");
    EXPECT_TRUE(holds(all, "scancel [102]")); // the earlier join
    EXPECT_TRUE(holds(all, "[--array=2]"));
    EXPECT_TRUE(holds(all, "[--qos=low]")); // as before
    EXPECT_TRUE(holds(all, "[--dependency=afterok:101:103]"));
    fs::remove(studio / "calls.txt");
    ASSERT_EQ(studio.cluster("--cancel").status, 0);
    EXPECT_EQ(slurp(studio / "calls.txt"), "scancel [101] [103] [104]\n");
}

TEST(Cluster, DoesNotGuessWhatASilentSlurmDoes) {
    const ClusterStudio studio;
    studio.plan();
    studio.installSlurm();
    ASSERT_EQ(studio.cluster("--slurm").status, 0);
    studio.command("squeue", "echo 'Unable to contact slurm controller' >&2; exit 1");
    const Outcome outcome = studio.cluster("--status");
    EXPECT_TRUE(holds(outcome.out, "does not say what runs: Unable to contact"));
    EXPECT_TRUE(fails(studio.cluster("--resume"), 1, "Unable to contact slurm controller"));
}

TEST(Cluster, RunsOnTheHostsOfAFile) {
    const ClusterStudio studio;
    studio.plan();
    spill(studio / "hosts.txt", "one\ntwo\n");
    // runs each line of its input on this machine; the words behind the seven options are a command
    // of a shell
    studio.command("parallel",
                   "shift 7; while read -r n; do eval \"${@/\\{\\}/$n}\" || exit 1; done");
    const Outcome outcome = studio.cluster("--hosts hosts.txt");
    ASSERT_EQ(outcome.status, 0) << outcome.text();
    const std::string call = studio.calls().front();
    EXPECT_EQ(
        call.rfind("parallel [--retries] [3] [--filter-hosts] [--jobs] [100%] [--sshloginfile] [" +
                       (studio / "hosts.txt").string() + "]",
                   0),
        0U)
        << call;
    EXPECT_TRUE(fs::exists(studio / "natives/b_native.png"));
    EXPECT_TRUE(fails(studio.cluster("--hosts none.txt"), 1, "none.txt: does not exist"));
}

TEST(Cluster, WrongCallsAreExplained) {
    ClusterStudio studio;
    EXPECT_TRUE(fails(studio.cluster("--status"), 1, "the plan"));
    studio.plan();
    EXPECT_TRUE(fails(studio.cluster({}), 2, "expected one of --slurm, --hosts"));
    EXPECT_TRUE(fails(studio.cluster("--local 1 --status"), 2, "--status"));
    EXPECT_TRUE(fails(studio.cluster("--local 0"), 2, "--local"));
    EXPECT_TRUE(fails(studio.cluster("--local 1 --qos low"), 2, "belongs to --slurm"));
    EXPECT_TRUE(fails(studio.run(kTool, "--status"), 2, "PLAN"));
    studio.set("PATH", (studio / "bin").string()); // this machine may have Slurm
    EXPECT_TRUE(fails(studio.cluster("--slurm"), 1, "scontrol: cannot be started"));
    studio.set("PATH", (studio / "bin").string() + ":/usr/bin:/bin");
    studio.installSlurm();
    studio.command("sbatch", "echo 'sbatch: error: invalid partition specified: none' >&2; exit 1");
    EXPECT_TRUE(
        fails(studio.cluster("--slurm --partition none"), 1, "invalid partition specified: none"));
}

} // namespace
} // namespace altiro3D::test
