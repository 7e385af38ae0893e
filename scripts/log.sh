# shellcheck shell=bash
# For scripts that keep the long output of other programs in a file; to be sourced.

# Says where the output of logged commands goes. Several scripts may share the file.
log_to() { # file
    mkdir -p "$(dirname "$1")"
    log=$(realpath "$1")
    : >>"$log"
}

# Runs a command; its output goes to $log, and on a terminal the present line of it is shown. If the
# command fails, shows the end of the log and ends the script.
logged() { # command...
    local status=0 line
    echo "\$ $*" >>"$log"
    if [[ -t 1 ]]; then
        "$@" 2>&1 | tee -a "$log" | while IFS= read -r line; do
            printf '\r\033[K  %.70s' "$line"
        done || status=$?
        printf '\r\033[K'
    else
        "$@" >>"$log" 2>&1 || status=$?
    fi
    [[ $status -ne 0 ]] || return 0
    {
        echo "$0: this command failed: $*"
        echo "The end of $log:"
        tail -n 20 "$log" | sed 's/^/    /'
    } >&2
    exit "$status"
}
