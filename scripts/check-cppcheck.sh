#!/usr/bin/env bash
# Runs cppcheck on all sources that are in the build; whatever it finds fails.
#
#   scripts/check-cppcheck.sh
set -euo pipefail
cd "$(dirname "$0")/.."
build=build/dev
[[ -f $build/compile_commands.json ]] || cmake --preset dev >/dev/null
commands=$(mktemp --suffix .json)
trap 'rm -f -- "$commands"' EXIT
# Without what Qt generates, which is there only after a build and is not ours.
python3 - "$build/compile_commands.json" "$commands" <<'PYTHON'
import json, os, subprocess, sys
tracked = set(subprocess.check_output(["git", "ls-files", "-z"], text=True).split("\0"))
with open(sys.argv[1]) as stream:
    commands = [command for command in json.load(stream)
                if os.path.relpath(command["file"]) in tracked]
with open(sys.argv[2], "w") as stream:
    json.dump(commands, stream)
print(f"cppcheck: {len(commands)} files", flush=True)
PYTHON
# The revision is that of Qt 5's generated files, which ask for it: Qt's headers are not read.
cppcheck --project="$commands" -DQ_MOC_OUTPUT_REVISION=67 --enable=warning,performance,portability \
    --inline-suppr --std=c++17 --library=googletest,qt --template=gcc --error-exitcode=1 --quiet -j "$(nproc)"
