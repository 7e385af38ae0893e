# shellcheck shell=bash
# For scripts that keep the long output of other programs in a file; to be sourced.

# Says where the output of logged commands goes. Several scripts may share the file.
log_to() { # file
    mkdir -p "$(dirname "$1")"
    log=$(realpath "$1")
    : >>"$log"
}

export NINJA_STATUS='[%f/%t] ' # as show_progress reads it

# Prints how long work takes on this computer: a guess, until its progress is measured.
minutes_here() { # minutes on one core
    local cores
    cores=$(nproc)
    echo "about $((($1 + cores - 1) / cores)) minutes on the $cores processor cores of this computer"
}

# Reads the output of a command and shows where it is: how much ninja has done, by its "[34/120] ...", and
# how long the rest takes if it goes on like this; of other commands the present line. On a terminal one
# line changes, else there is a line for every 10 %, and one a minute.
show_progress() {
    local line text begin=$SECONDS told=$SECONDS step=0 last=0 of=0 spent left
    while IFS= read -r line; do
        text=$line
        if [[ $line =~ ^\[([1-9][0-9]*)/([1-9][0-9]*)\] ]]; then # not [0/2], before it begins
            ((BASH_REMATCH[2] == of)) || begin=$SECONDS step=0 last=0 of=${BASH_REMATCH[2]}
            spent=$((SECONDS - begin))
            left=$((spent * (BASH_REMATCH[2] - BASH_REMATCH[1]) / BASH_REMATCH[1]))
            text="$((100 * BASH_REMATCH[1] / BASH_REMATCH[2])) %, $((spent / 60)) min $((spent % 60)) s"
            text+=", about $((left / 60)) min $((left % 60)) s left"
            step=$((10 * BASH_REMATCH[1] / BASH_REMATCH[2]))
        fi
        if [[ -t 1 ]]; then
            printf '\r\033[K  %.70s' "$text"
        elif ((step > last || SECONDS - told >= 60)); then
            printf '  %.70s\n' "$text"
            told=$SECONDS last=$step
        fi
    done
    [[ ! -t 1 ]] || printf '\r\033[K'
}

# Runs a command; its output goes to $log, and its progress is shown. If the command fails, shows the end
# of the log and ends the script.
logged() { # command...
    local status=0
    echo "\$ $*" >>"$log"
    "$@" 2>&1 | tee -a "$log" | show_progress || status=$?
    [[ $status -ne 0 ]] || return 0
    {
        echo "$0: this command failed: $*"
        echo "The end of $log:"
        tail -n 20 "$log" | sed 's/^/    /'
    } >&2
    exit "$status"
}
