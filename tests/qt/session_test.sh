#!/usr/bin/env bash
# Runs a program on an X server of its own, without a screen.
#
# usage: session_test.sh PROGRAM [ARGUMENT...]
set -euo pipefail
for tool in Xvfb xdotool; do
    if ! command -v "$tool" >/dev/null; then
        echo "SKIPPED: needs $tool (scripts/install-dependencies.sh test)"
        exit 77
    fi
done
work=$(mktemp -d)
mkdir -m 700 "$work/runtime"
Xvfb -displayfd 3 -screen 0 1280x800x24 -nolisten tcp 3>"$work/display" 2>"$work/log" &
server=$!
trap 'kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; rm -rf "$work"' EXIT
for _ in $(seq 100); do
    [[ ! -s $work/display ]] || break
    kill -0 "$server" 2>/dev/null || { cat "$work/log"; exit 1; }
    sleep 0.1
done
DISPLAY=:$(<"$work/display") XDG_RUNTIME_DIR=$work/runtime LANG=C.UTF-8 "$@"
