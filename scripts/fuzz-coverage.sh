#!/usr/bin/env bash
# Which lines of each reader its fuzz target has reached: runs the inputs that scripts/fuzz.sh has
# gathered (build/fuzz/seeds and build/fuzz/corpus, or those below DIR) once, with Clang's coverage.
#
#   scripts/fuzz-coverage.sh [DIR]
set -euo pipefail
cd "$(dirname "$0")/.."
inputs=${1:-build/fuzz}
build=build/fuzz-coverage
declare -A seen=()
cmake -S . -B "$build" -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -fprofile-instr-generate -fcoverage-mapping" \
    -DALTIRO3D_SANITIZE=fuzzer-no-link -DALTIRO3D_BUILD_FUZZERS=ON -DALTIRO3D_BUILD_TOOLS=OFF \
    -DALTIRO3D_BUILD_TESTS=OFF -DALTIRO3D_BUILD_BENCHMARKS=OFF >/dev/null
cmake --build "$build" >/dev/null

# target, source, functions that are the reader (a regular expression of mangled names; '.': all),
# functions that are not ('-': none)
readers="
calibration     calibration      .                                     -
native_lut      native_lut_file  .                                     4save
quilt           quilt            .                                     -
picture_header  image_header     .                                     -
exif            exif             .                                     -
picture         image_io         .                                     rite|ncode|listPict|natural|isDigit|folded
picture         rgbd             split|greyOf|halves|isBeside          -
camera          camera           parseCamera|5check|7require|8validate CameraPose|RealOptions
network_catalog network_profile  .                                     modelSearchPath|findModelFile
onnx_facts      onnx_facts       .                                     -
view_names      image_io         listPict|natural|isDigit|folded|lower -
video_run       resumable_video  readRun|differ|Segment|Shown|4join    closeSeg|segmentExt
depth_state     video_depth      8setState                             -
depth_state     picture_tracker  4take|4load|checksum                  -
video           video_input      .                                     describeOthers
video           video_reader     .                                     otherStreams|pass
"
suffix=$(clang++ --version | sed -n 's/.*version \([0-9]*\).*/-\1/p;q')
printf '%-16s %-18s %6s %8s %8s\n' target reader lines reached share
while read -r target source wanted others; do
    [[ -n $target ]] || continue
    profile=$build/$target
    if [[ ! -f $profile.profdata || -z ${seen[$target]:-} ]]; then
        directories=()
        for directory in "$inputs/seeds/$target" "$inputs/corpus/$target"; do
            [[ ! -d $directory ]] || directories+=("$directory")
        done
        LLVM_PROFILE_FILE=$profile.profraw "$build/tests/fuzz/${target}_fuzz" -runs=0 \
            -rss_limit_mb=4000 "${directories[@]}" >"$profile.log" 2>&1
        "llvm-profdata$suffix" merge -sparse "$profile.profraw" -o "$profile.profdata"
        seen[$target]=1
    fi
    "llvm-cov$suffix" report -show-functions -instr-profile="$profile.profdata" \
        "$build/tests/fuzz/${target}_fuzz" "libaltiro3D/src/$source.cpp" |
        awk -v target="$target" -v source="$source" -v wanted="$wanted" -v others="$others" '
            NF >= 7 && $1 ~ /_Z/ && $1 ~ wanted && (others == "-" || $1 !~ others) {
                lines += $5
                missed += $6
            }
            END {
                printf "%-16s %-18s %6d %8d %7.1f%%\n", target, source, lines, lines - missed,
                    lines > 0 ? 100 * (lines - missed) / lines : 0
            }'
done <<<"$readers"
