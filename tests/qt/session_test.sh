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
mkfifo "$work/display"
Xvfb -displayfd 3 -screen 0 1280x800x24 -nolisten tcp 3>"$work/display" 2>"$work/log" &
server=$!
trap 'kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; rm -rf "$work"' EXIT
read -r -t 60 display <"$work/display" || { cat "$work/log"; exit 1; }
DISPLAY=:$display XDG_RUNTIME_DIR=$work/runtime LANG=C.UTF-8 "$@"
