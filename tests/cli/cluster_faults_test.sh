#!/usr/bin/env bash
# Makes the chunks of a film and of photos on a real Slurm, and by GNU Parallel over a real ssh, all on this
# machine, while nodes, tasks, disks and the controller fail. In all cases the outputs must have the bytes of one
# run, or the programs must say in one line what is wrong.
#
#   cluster_faults_test.sh DIRECTORY-OF-TOOLS SOURCE-TREE slurm|ssh
#
# Exit status 77: skipped, because something is missing here. It needs root: each node of the cluster is a group of
# processes with its own host name, processes and mounts.
set -uo pipefail
tools=$1
source=$2
part=$3
export LC_ALL=C.UTF-8 PATH=$tools:$PATH:/usr/sbin:/sbin

skip() {
    echo "skipped: $1"
    exit 77
}
[[ $(id -u) -eq 0 ]] || skip "needs root"
case $part in
slurm) needed=(slurmctld slurmd sbatch munged unshare nsenter) ;;
ssh) needed=(parallel sshd ssh-keygen unshare) ;;
esac
for program in "${needed[@]}" ffmpeg; do
    command -v "$program" >/dev/null || skip "needs $program (scripts/install-dependencies.sh cluster)"
done
unshare --uts --pid --mount --fork --kill-child=KILL --mount-proc hostname probe 2>/dev/null ||
    skip "needs namespaces, which are not permitted here"

# Names of sockets must be short.
root=$(mktemp -d /tmp/altiro3D-cluster-XXXXXX)
chmod 755 "$root"
declare -A pids
finish() {
    cd /
    for name in "${!pids[@]}"; do kill -CONT "${pids[$name]}" && kill -KILL "${pids[$name]}"; done 2>/dev/null
    wait 2>/dev/null
    [[ -n ${KEEP:-} ]] || rm -rf -- "$root"
}
trap finish EXIT
trap 'exit 130' INT TERM
export XDG_CACHE_HOME=$root/cache HOME=$root/home ALTIRO3D_MODELS=$source/models
unset LKG_CALIBRATION XDG_DATA_HOME
mkdir -p "$root"/{home,log}
cd "$root" || exit 1

failures=0
fail() {
    failures=$((failures + 1))
    echo "FAILED: $1"
    tail -n 5 out err 2>/dev/null
}
check() { # description, condition...
    local what=$1
    shift
    "$@" || fail "$what"
}
run() { # a tool; leaves `status`, out and err
    timeout 600 "$@" >out 2>err </dev/null
    status=$?
}
ends() { [[ $status == "$1" ]]; }
says() { grep -qF -- "$1" out err; }
one_error() { [[ $(wc -l <err) -eq 1 && $(<err) == *": error: "*"$1"* ]]; }
until_true() { # seconds, condition...
    local end=$((SECONDS + $1))
    shift
    until "$@"; do
        [[ $SECONDS -lt $end ]] || return 1
        sleep 0.2
    done
}

# --- The work: a film of two scenes, the second longer than three chunks, and nine photos
cat >small.json <<JSON
{"configVersion": "1.0", "serial": "TEST", "pitch": {"value": 52.58}, "slope": {"value": -7.17},
 "center": {"value": 0.5}, "viewCone": {"value": 40}, "invView": {"value": 1}, "DPI": {"value": 324},
 "screenW": {"value": 384}, "screenH": {"value": 512}}
JSON
ffmpeg -v error -f lavfi -i testsrc2=size=320x240:rate=12:duration=11 \
    -f lavfi -i mandelbrot=size=320x240:rate=12 -f lavfi -i sine=duration=41 -filter_complex \
    '[1]trim=duration=30,setpts=PTS-STARTPTS,setsar=1[b];[0]setsar=1[a];[a][b]concat=n=2:v=1[v]' \
    -map '[v]' -map 2:a -c:v libx264 -preset ultrafast -c:a aac -y clip.mp4 || exit 1
mkdir photos
for i in 1 2 3 4 5 6 7 8 9; do
    ffmpeg -v error -i "$source/docs/examples/sample.jpg" -vf "hue=h=$((i * 30)),scale=420:-1" "photos/$i.png" || exit 1
done
film_options=(-j 1 -r 140x105 -c small.json)
photo_options=(-j 1 -r 140x105 -c small.json)
plan_film() { # name
    rm -rf "$1.plan" "$1.mp4"
    run video2native --plan "$1.plan" --chunk-seconds 6 "${film_options[@]}" clip.mp4 "$1.mp4"
    check "$1 is planned" ends 0
}
run video2native "${film_options[@]}" clip.mp4 whole.mp4
check "the film is made at once" ends 0
run photo2native "${photo_options[@]}" photos whole
check "the photos are made at once" ends 0
[[ $failures -eq 0 ]] || exit 1
same_film() { cmp -s "$1.mp4" whole.mp4; }
same_photos() {
    local photo
    for photo in whole/*; do cmp -s "$photo" "$1/${photo##*/}" || return 1; done
}

start() { # name, command...: in the background; its id is in pids
    local name=$1
    shift
    "$@" </dev/null >"log/$name.out" 2>&1 &
    pids[$name]=$!
}
# A machine of its own: host name, processes and mounts. Killing `unshare` kills all of it.
start_machine() { # name, script...
    local name=$1
    shift
    start "$name" unshare --uts --pid --mount --fork --kill-child=KILL --mount-proc \
        bash -c "hostname $name && { $*; }"
}
inner() { # machine: a process in it, as the machine outside sees it
    local child=${pids[$1]}
    child=$(<"/proc/$child/task/$child/children")
    echo "${child%% *}"
}

running_on() { # machine's space of processes, program: a process of it, empty if there is none
    local process
    for process in /proc/[0-9]*; do
        [[ $(readlink "$process/ns/pid" 2>/dev/null) == "$1" ]] || continue
        [[ $(<"$process/comm") == "$2" ]] && echo "${process#/proc/}" && return
    done 2>/dev/null
}
space_of() { readlink "/proc/$(inner "$1")/ns/pid"; }
is_busy() { [[ -n $(running_on "$(space_of "$1")" video2native) ]]; }

# --- Slurm
export SLURM_CONF=$root/slurm.conf
slurm_node() { start_machine "$1" "slurmd -D -N $1 -f $SLURM_CONF & wait"; }
nodes_idle() { [[ $(sinfo -h -N -t idle -o %N 2>/dev/null | wc -l) -eq $1 ]]; }
start_slurm() { # nodes
    local port i
    for ((i = 0; i < 50; i++)); do
        port=$((10000 + RANDOM % 20000))
        (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || break
    done
    mkdir -m 755 munge state
    cat >"$SLURM_CONF" <<CONF
ClusterName=altiro3D
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=$port
FirstJobId=$((1000 + RANDOM))
SlurmUser=root
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket=$root/munge/socket,cred_expire=5
StateSaveLocation=$root/state
SlurmdSpoolDir=$root/spool.%n
SlurmctldPidFile=$root/slurmctld.pid
SlurmdPidFile=$root/slurmd.%n.pid
SlurmctldLogFile=$root/log/slurmctld.log
SlurmdLogFile=$root/log/slurmd.%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
MailProg=/bin/true
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
SlurmdTimeout=10
TCPTimeout=2
MessageTimeout=10
KillWait=2
CompleteWait=0
ReturnToService=1
MaxArraySize=5
SchedulerParameters=bf_interval=1,sched_interval=1,batch_sched_delay=0
SlurmdParameters=config_overrides
NodeName=node[1-$1] NodeAddr=127.0.0.1 Port=[$((port + 1))-$((port + $1))] CPUs=1 RealMemory=2000
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
    echo 'CgroupAutomount=no' >cgroup.conf
    (umask 077 && head -c 256 /dev/urandom >munge/key)
    start munged munged --foreground --force --socket="$root/munge/socket" --key-file="$root/munge/key" \
        --log-file="$root/log/munged.log" --pid-file="$root/munge/pid" --seed-file="$root/munge/seed"
    until_true 10 test -S munge/socket || return 1
    start slurmctld slurmctld -D -f "$SLURM_CONF"
    for ((i = 1; i <= $1; i++)); do slurm_node "node$i"; done
    until_true 60 nodes_idle "$1"
}
is_quiet() { [[ -z $(squeue -h -t PENDING,RUNNING,COMPLETING -o %i 2>/dev/null) ]]; }
film_is_there() { [[ -f $1.mp4 ]]; }

test_slurm() {
    if ! start_slurm 2; then
        tail -n 5 log/*
        fail "Slurm starts"
        return
    fi
    echo "power loss of a node, photos beside a film"
    plan_film power
    run photo2native --plan photos.plan --chunk-photos 2 "${photo_options[@]}" photos natives
    check "the photos are planned" ends 0
    run altiro3Dcluster --slurm power.plan
    check "the film is submitted" ends 0
    run altiro3Dcluster --slurm photos.plan
    check "the photos are submitted" ends 0
    check "a chunk begins" until_true 60 is_busy node2
    kill -KILL "${pids[node2]}"
    scontrol update nodename=node2 state=down reason=test
    run altiro3Dcluster --status power.plan
    check "the status after a power loss" ends 0
    sleep 1
    slurm_node node2
    scontrol update nodename=node2 state=resume 2>/dev/null
    check "the film is made after a power loss" until_true 240 film_is_there power
    check "the photos are made after a power loss" until_true 120 is_quiet
    check "the film is that of one run" same_film power
    check "the photos are those of one run" same_photos natives
    run altiro3Dcluster --status power.plan
    check "the status at the end" says "chunks made"
    run photo2native --join photos.plan
    check "a second join" ends 0
    scontrol update nodename=node2 state=resume 2>/dev/null
    until_true 60 nodes_idle 2

    echo "a killed task, a frozen controller, joins that are too early or at the same time"
    plan_film killed
    run altiro3Dcluster --slurm killed.plan
    check "the film is submitted" ends 0
    run video2native --join killed.plan
    check "a join before its chunks" ends 1
    check "and says which" one_error "chunk"
    until_true 60 is_busy node1
    kill -KILL "$(running_on "$(space_of node1)" video2native)"
    kill -STOP "${pids[slurmctld]}"
    run altiro3Dcluster --status killed.plan
    check "the status while the controller is away" ends 0
    check "and says so" says "does not say what runs"
    run altiro3Dcluster --resume killed.plan
    check "nothing is submitted while the controller is away" ends 1
    check "and says why" one_error "squeue"
    kill -CONT "${pids[slurmctld]}"
    check "the other chunks end" until_true 240 is_quiet
    check "a film without a chunk is not made" test ! -e killed.mp4
    run altiro3Dcluster --status killed.plan
    check "the status names what failed" says "failed: "
    run altiro3Dcluster --resume killed.plan
    check "the killed chunk alone is submitted" says "submitted 1 chunk,"
    check "the film is made" until_true 120 film_is_there killed
    until_true 60 is_quiet
    check "the film is that of one run" same_film killed
    rm killed.mp4
    video2native --join killed.plan >log/join1 2>&1 &
    local first=$!
    run video2native --join killed.plan
    wait "$first"
    check "two joins at the same time" same_film killed

    echo "a full disk on one node"
    plan_film full
    nsenter -t "$(inner node1)" -m mount -t tmpfs -o size=32k full "$root/full.plan/chunks"
    run altiro3Dcluster --slurm full.plan
    check "all chunks end" until_true 300 is_quiet
    check "a film without chunks is not made" test ! -e full.mp4
    check "the log says why" grep -q "No space left on device" full.plan/logs/*.log
    nsenter -t "$(inner node1)" -m umount "$root/full.plan/chunks"
    run altiro3Dcluster --resume full.plan
    check "the film is made when there is space" until_true 240 film_is_there full
    until_true 60 is_quiet
    check "the film is that of one run" same_film full

    echo "a damaged chunk, other options, another input"
    rm full.mp4
    local chunk
    chunk=$(find full.plan/chunks -name '*.mp4' | sort | tail -n 1)
    printf 'damage' | dd of="$chunk" bs=1 seek=3000 conv=notrunc 2>/dev/null
    run video2native --join full.plan
    check "a damaged chunk is refused" ends 1
    check "and named" one_error "chunk"
    check "no output is made of a damaged chunk" test ! -e full.mp4
    run altiro3Dcluster --resume full.plan
    check "the damaged chunk alone is submitted" says "submitted 1 chunk,"
    check "the film is made with the chunk made again" until_true 120 film_is_there full
    until_true 60 is_quiet
    check "the film is that of one run" same_film full
    rm full.mp4
    run video2native --plan full.plan --chunk-seconds 6 "${film_options[@]}" --strength 50 clip.mp4 full.mp4
    check "a plan is not mixed with other options" ends 1
    check "and says so" one_error "full.plan"
    plan_film input
    cp clip.mp4 clip.kept
    printf 'x' >>clip.mp4
    run altiro3Dcluster --slurm input.plan
    check "chunks of another input end" until_true 120 is_quiet
    check "no film is made of another input" test ! -e input.mp4
    check "the log names the input" grep -q "the file of the video has changed" input.plan/logs/1.log
    mv clip.kept clip.mp4

    echo "cancelled and resumed"
    plan_film cancelled
    run altiro3Dcluster --slurm cancelled.plan
    until_true 60 is_busy node1
    run altiro3Dcluster --cancel cancelled.plan
    check "a film is cancelled" ends 0
    check "nothing runs any more" until_true 60 is_quiet
    run altiro3Dcluster --resume --dry-run cancelled.plan
    check "a dry run prints the commands" says "sbatch "
    check "a dry run submits nothing" is_quiet
    run altiro3Dcluster --resume cancelled.plan
    check "the film is made after a cancellation" until_true 240 film_is_there cancelled
    until_true 60 is_quiet
    check "the film is that of one run" same_film cancelled
}

# --- ssh
test_ssh() {
    local machine port=$((20000 + RANDOM % 10000))
    mkdir -p home/.ssh home/.parallel /run/sshd
    ssh-keygen -q -t ed25519 -N '' -f key
    ssh-keygen -q -t ed25519 -N '' -f host_key
    for machine in near far; do
        port=$((port + 1))
        cat >"$machine.sshd" <<CONF
Port $port
ListenAddress 127.0.0.1
HostKey $root/host_key
AuthorizedKeysFile $root/key.pub
StrictModes no
PidFile none
UsePAM no
PermitRootLogin yes
SetEnv HOME=$HOME XDG_CACHE_HOME=$XDG_CACHE_HOME ALTIRO3D_MODELS=$ALTIRO3D_MODELS
CONF
        printf 'Host %s\n  HostName 127.0.0.1\n  Port %s\n' "$machine" "$port" >>ssh_config
        start_machine "$machine" "$(command -v sshd) -D -e -f $root/$machine.sshd & wait"
    done
    printf 'Host dead\n  HostName 127.0.0.1\n  Port 1\n' >>ssh_config
    printf 'Host *\n  IdentityFile %s\n  StrictHostKeyChecking no\n  UserKnownHostsFile /dev/null\n  LogLevel ERROR\n' \
        "$root/key" >>ssh_config
    # GNU Parallel finds ssh in the path; ours reads this test's configuration, not that of the account.
    mkdir bin
    printf '#!/bin/sh\nexec %s -F %s "$@"\n' "$(command -v ssh)" "$root/ssh_config" >bin/ssh
    chmod +x bin/ssh
    export PATH=$root/bin:$PATH
    check "near answers" until_true 20 ssh near true
    check "far answers" until_true 20 ssh far true
    [[ $failures -eq 0 ]] || {
        tail -n 5 log/*
        return
    }
    printf '1/near\n1/far\n1/dead\n' >hosts

    echo "three computers, of which one is dead and one dies"
    plan_film hosts
    timeout 600 altiro3Dcluster --hosts hosts hosts.plan >log/cluster 2>&1 </dev/null &
    local cluster=$!
    pids[cluster]=$cluster
    check "far works" until_true 60 is_busy far
    kill -KILL "${pids[far]}"
    wait "$cluster"
    status=$?
    unset 'pids[cluster]'
    cp log/cluster err
    check "the film is made" ends 0
    check "the film is that of one run" same_film hosts
    run photo2native --plan photos.plan --chunk-photos 2 "${photo_options[@]}" photos natives
    run altiro3Dcluster --hosts hosts photos.plan
    check "the photos are made" ends 0
    check "the photos are those of one run" same_photos natives
    printf 'dead\n' >hosts
    plan_film alone
    run altiro3Dcluster --hosts hosts alone.plan
    check "no computer answers" ends 1
    check "no film is made" test ! -e alone.mp4
    check "the chunks that are missing are named" says "has no chunks 1-"
    run altiro3Dcluster --local 2 alone.plan
    check "the same plan is made here" ends 0
    check "the film is that of one run" same_film alone
}

"test_$part"
[[ $failures -eq 0 ]] || {
    echo "$failures checks failed"
    exit 1
}
echo "all checks of $part passed"
