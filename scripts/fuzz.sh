#!/usr/bin/env bash
# Runs the fuzz targets (tests/fuzz) under AddressSanitizer and UndefinedBehaviorSanitizer. New
# inputs are kept in build/fuzz/corpus, inputs that fail in build/fuzz/findings.
#
#   scripts/fuzz.sh [SECONDS] [TARGET...]
#
# SECONDS (default: 30) is the time for all targets together on one processor.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 99 -- "$@"
cd "$(dirname "$0")/.."
seconds=${1:-30}
check_number "$seconds" "seconds for all targets"
[[ $# -eq 0 ]] || shift
build=build/fuzz

if ! command -v clang++ >/dev/null ||
    ! echo 'extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }' |
        clang++ -x c++ -fsanitize=fuzzer,address - -o /dev/null 2>/dev/null; then
    echo "fuzz: skipped: there is no clang++ with libFuzzer (libclang-rt-dev)"
    exit 0
fi
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz

targets=("$@")
if [[ ${#targets[@]} -eq 0 ]]; then
    for program in "$build"/tests/fuzz/*_fuzz; do
        target=$(basename "$program")
        targets+=("${target%_fuzz}")
    done
fi
each=$(((seconds + ${#targets[@]} - 1) / ${#targets[@]}))

seeds=$build/seeds
rm -rf "$seeds"
"$build/tests/fuzz/altiro3D_fuzz_seeds" "$seeds"
for target in tests/fuzz/seeds/*; do
    mkdir -p "$seeds/${target##*/}"
    cp "$target"/* "$seeds/${target##*/}/"
done
tests/fuzz/other_streams_seeds.sh "$seeds/other_streams"
cp calibration/*.json "$seeds/calibration/"
cp models/catalog.json "$seeds/network_catalog/"

run() {
    local target=$1 options=(-timeout=25 -rss_limit_mb=3000 -malloc_limit_mb=300)
    local corpus=$build/corpus/$target
    mkdir -p "$corpus" "$build/findings" "$build/logs"
    case $target in
    bridge_answers | calibration | camera | network_catalog | video_run) options+=(-dict=tests/fuzz/json.dict) ;;
    esac
    case $target in
    quilt) options+=(-max_len=100000) ;;
    # FFmpeg and OpenCV take what a file claims, and leak on damaged input; leaks of ours show in the
    # other targets
    picture | video | other_streams) options+=(-malloc_limit_mb=2200 -detect_leaks=0) ;;
    esac
    if "$build/tests/fuzz/${target}_fuzz" "${options[@]}" -max_total_time="$each" -seed=1 \
        -print_final_stats=1 -artifact_prefix="$build/findings/$target-" \
        "$corpus" "$seeds/$target" >"$build/logs/$target.log" 2>&1; then
        local tried
        tried=$(awk '/number_of_executed_units/ {print $2}' "$build/logs/$target.log")
        echo "fuzz: $target: $tried inputs in $each s"
    else
        echo "fuzz: $target: FAILED; the input is in $build/findings, the report:" >&2
        grep -E -A25 'ERROR|runtime error|broken promise|uncaught exception' \
            "$build/logs/$target.log" | head -40 >&2
        return 1
    fi
}
export -f run
export build each seeds
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I '{}' bash -c 'run {}'
