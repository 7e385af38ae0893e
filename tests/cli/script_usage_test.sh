#!/usr/bin/env bash
# Every script answers --help before it does anything, and refuses an argument that it does not know.
# usage: script_usage_test.sh SOURCE_DIRECTORY
set -euo pipefail
cd "$1"
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
mkdir "$work/bin"
for program in sudo apt-get cmake ninja ctest g++ docker curl wget git npm chroot debootstrap; do
    # shellcheck disable=SC2016 # the stand-in expands it
    printf '#!/bin/sh\necho "$0 $*" >>"%s/called"\n' "$work" >"$work/bin/$program"
    chmod +x "$work/bin/$program"
done
export PATH=$work/bin:$PATH PYTHONDONTWRITEBYTECODE=1
failures=0
count=0
fail() { # what
    failures=$((failures + 1))
    echo "FAILED: $1"
    cat "$work/said" "$work/errors" "$work/called" 2>/dev/null || true
}
run() { # script, argument
    local status=0 by=()
    [[ $1 != *.py ]] || by=(python3)
    rm -f "$work/called"
    timeout 20 "${by[@]}" "$1" "$2" >"$work/said" 2>"$work/errors" </dev/null || status=$?
    [[ ! -e $work/called ]] || fail "$1 $2: calls other programs"
    echo "$status" >"$work/status"
}
for script in scripts/* .ci/* docs/*.sh training/*.py bindings/python/make_stubs.py; do
    case $script in
    *.py) grep -q '^if __name__ == "__main__"' "$script" || continue ;; # the others are modules
    *) [[ -f $script && -x $script ]] || continue ;;                    # the others are sourced
    esac
    count=$((count + 1))
    run "$script" --help
    if [[ $(<"$work/status") != 0 || -s $work/errors ]] || ! grep -qi '^usage: ' "$work/said"; then
        fail "$script --help: expected its usage and success"
    fi
    run "$script" --no-such-option
    if [[ $(<"$work/status") != 2 || -s $work/said || ! -s $work/errors ]]; then
        fail "$script --no-such-option: expected a message and status 2"
    fi
done
((count > 30)) || fail "only $count scripts, expected more than 30"
((failures == 0)) && echo "$count scripts, all passed"
