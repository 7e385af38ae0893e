#!/usr/bin/env bash
# Runs cppcheck on all sources that are in the build, and on the fuzz targets. Fails on any finding.
#
#   scripts/check-cppcheck.sh
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 0 -- "$@"
cd "$(dirname "$0")/.."
[[ -f build/dev/compile_commands.json ]] || cmake --preset dev >/dev/null
# the fuzz targets need Clang and are in a build of their own
if [[ ! -f build/fuzz/compile_commands.json ]] && command -v clang++ >/dev/null; then
    cmake --preset fuzz >/dev/null
fi
[[ -f build/fuzz/compile_commands.json ]] || echo "cppcheck: tests/fuzz: skipped: there is no clang++"
commands=$(mktemp --suffix .json)
trap 'rm -f -- "$commands"' EXIT
# Without what Qt generates, which is there only after a build and is not ours.
python3 - "$commands" <<'PYTHON'
import json, os, subprocess, sys
tracked = set(subprocess.check_output(["git", "ls-files", "-z"], text=True).split("\0"))
commands = []
for build in "build/dev", "build/fuzz":
    path = build + "/compile_commands.json"
    if not os.path.exists(path): continue
    for command in json.load(open(path)):
        file = os.path.relpath(command["file"])
        if file in tracked and file.startswith("tests/fuzz/") == (build == "build/fuzz"):
            commands.append(command)
with open(sys.argv[1], "w") as stream:
    json.dump(commands, stream)
print(f"cppcheck: {len(commands)} files", flush=True)
PYTHON
# cppcheck errs with moved objects that a lambda captures, with functions that never return, with the
# casts of kernels, with arrays whose size is an expression, and with conditions in a ternary; clang-tidy
# checks all of them.
# The revision is that of Qt 5's generated files, which ask for it: Qt's headers are not read.
cppcheck --project="$commands" -DQ_MOC_OUTPUT_REVISION=67 --enable=warning,performance,portability \
    --suppress=accessMoved --suppress=missingReturn --suppress=returnStdMoveLocal \
    --suppress=invalidPointerCast --suppress=containerOutOfBounds --inline-suppr --std=c++17 --library=googletest,qt --template=gcc --error-exitcode=1 --quiet -j "$(nproc)"
