#!/usr/bin/env bash
# Runs the checks for a release: those of .ci/run and the slow ones. Goes on after a part that fails; tells at
# the end how long each part took, and fails if one has failed.
#
#   scripts/check-all.sh [FUZZ [PHOTOS [SECONDS [PLAYED]]]]
#
# FUZZ: seconds for each fuzz target (default: 600). The others: how long scripts/soak.sh runs.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 4 -- "$@"
cd "$(dirname "$0")/.."
export ALTIRO3D_LONGEST_TEST=1000 # seconds
fuzz=${1:-600}
soak=("${@:2}")
for number in "$fuzz" "${soak[@]}"; do check_number "$number" "a number of seconds or photos"; done
results=()
failed=0

part() { # what, command...
    local begin=$SECONDS result=ok
    echo "== $1"
    "${@:2}" || { result=FAILED && failed=1; }
    results+=("$(printf '%6d s  %-6s  %s' $((SECONDS - begin)) $result "$1")")
}
built() { # preset: all tests but those of installed trees
    cmake --preset "$1" && cmake --build --preset "$1" && ctest --preset "$1" -j "$(nproc)" -LE install
}
clang() { # the other compiler and the other kind of library
    cmake --preset clang && cmake --build --preset clang &&
        ctest --preset clang -j "$(nproc)" -LE slow && ctest --preset clang -L install
}
web() {
    scripts/install-dependencies.sh web && scripts/check-web.sh
}
cluster() { # slurm or ssh; a skipped test is a failure here
    scripts/install-dependencies.sh cluster &&
        tests/cli/cluster_faults_test.sh "$PWD/build/dev/tools" "$PWD" "$1"
}

part "all tests but slow ones" scripts/test.sh
part "slow tests" ctest --preset dev -j "$(nproc)" -L slow -LE cluster # which has parts below
part "format" scripts/check-format.sh
part "includes" scripts/check-includes.py
part "documentation" scripts/check-docs.sh
part "clang-tidy" scripts/check-tidy.sh --all
part "cppcheck" scripts/check-cppcheck.sh
part "AddressSanitizer and UndefinedBehaviorSanitizer" built asan
part "ThreadSanitizer" scripts/check-tsan.sh
part "valgrind" scripts/check-valgrind.sh
part "Clang, static library" clang
part "same bytes from GCC and Clang, on any processor" scripts/compare-builds.sh build/dev build/clang
part "arm64, in an emulator" scripts/check-arm64.sh
part "WebAssembly, in Chromium" web
part "tools that are killed 200 times each" tests/cli/faults_test.sh "$PWD/build/dev/tools" "$PWD" 200
part "fuzzing, $fuzz s a target" scripts/fuzz.sh $((fuzz * $(ls tests/fuzz/*_fuzz.cpp | wc -l)))
part "lines of the readers that inputs of fuzzing reach" scripts/fuzz-coverage.sh
part "long runs in one process" scripts/soak.sh ${soak[@]+"${soak[@]}"}
part "chunks on a real Slurm, under faults" cluster slurm
part "chunks on a real ssh, under faults" cluster ssh
part "Debian packages" scripts/check-packages.sh
part "the archive for any Linux, on bare Debian 12 and 13" scripts/check-archive.sh
part "the programs for Windows, under Wine" scripts/check-windows.sh
part "the README's commands on a bare Debian 13" scripts/check-fresh.sh trixie
printf '%s\n' "" "${results[@]}"
exit "$failed"
